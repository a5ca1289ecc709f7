// Columns that a ledger declares beyond the fixed members of its lines, by name (tools/docs/formats.md "TLML").
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "base/bytes.hpp"

namespace toliman::track {

enum class ColumnType : uint32_t { f64 = 0, i64 = 1 };
// Who fills a column: the library, or the estimator with its second and later values and their covariances.
enum class ColumnRole : uint32_t { own = 1, value = 2, covariance = 3 };

// Of every ledger that this version begins, in this order.
enum class Own : size_t { chi_square, exposure_s, shift_s, window_row, window_col, flags };
constexpr size_t kOwn = 6;

constexpr size_t kMostValues = 8; // of an estimator
constexpr size_t kMostFurther = kMostValues - 1 + kMostValues * (kMostValues + 1) / 2 - 1;
constexpr size_t kMostColumns = kOwn + kMostFurther;

// One number of each column: the bits of a double or an int64.
using Cells = std::array<uint64_t, kMostColumns>;

struct Column {
    std::string name;
    ColumnType type;
    ColumnRole role;
    uint64_t empty() const noexcept; // the cell where there is no number: NaN or 0
    double number(uint64_t cell) const noexcept;
};

class Columns {
  public:
    // Those of the library, then those of an estimator with these values beyond its first, separated by commas.
    // Status::argument for names that are none, and for too many.
    explicit Columns(std::string_view further = {});
    // As in a file. Status::format.
    static Columns load(ByteReader &in, size_t count);
    void save(ByteWriter &out) const;
    static constexpr size_t kSavedSize = 64; // of each column

    const std::vector<Column> &all() const noexcept { return all_; }
    size_t count() const noexcept { return all_.size(); }
    size_t find(std::string_view name) const noexcept; // count() if there is none
    size_t values() const noexcept;                    // of the estimator, the first among them
    std::string further() const;                       // as the constructor takes them
    Cells empty() const noexcept;

  private:
    void add(std::string name, ColumnType type, ColumnRole role);
    std::vector<Column> all_;
};

// Cells by the columns of one ledger -> by those of another, which are found by name.
class Arrangement {
  public:
    Arrangement(const Columns &from, const Columns &to);
    Cells operator()(const Cells &cells) const noexcept;

  private:
    Cells empty_;
    std::vector<size_t> from_; // of each column where it comes from, or kMostColumns
};

} // namespace toliman::track
