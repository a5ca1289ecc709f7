// Named columns that a ledger declares in addition to the fixed members of its records (tools/docs/formats.md, "TLML").
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
// Origin of a column: the library; the second and later values of the estimator; covariances of its values; parameters
// that it fits to each frame, without covariances, for trends of the instrument.
enum class ColumnRole : uint32_t { own = 1, value = 2, covariance = 3, parameter = 4 };

// Columns of the library in the ledgers that this version creates, in this order. Those from factor on exist if frames
// are reduced.
enum class OwnColumn : size_t {
    chi_square,
    exposure_s,
    shift_s,
    window_row,
    window_col,
    flags,
    intervals, // number of on-target intervals, in records before that of the frame; kLostIntervals: not known any more
    chi_square_sigma,
    largest_residual,
    bad_pixels,
    factor,
    geometric_arcsec,
    partials // of the geometric separation by the elements of the orbit: kPartials columns
};
constexpr size_t kPartials = 7;
constexpr size_t kOwnColumns = static_cast<size_t>(OwnColumn::partials) + kPartials; // at most
constexpr int64_t kLostIntervals = -1;
const char *name_of(OwnColumn column) noexcept; // of partials: of the first

constexpr size_t kMaxValues = 8;      // of an estimator
constexpr size_t kMaxParameters = 28; // of an estimator
constexpr size_t kMaxFurther = kMaxValues - 1 + kMaxValues * (kMaxValues + 1) / 2 - 1 + kMaxParameters;
constexpr size_t kMaxColumns = kOwnColumns + kMaxFurther;

// One cell per column: the bits of a double or an int64.
using Cells = std::array<uint64_t, kMaxColumns>;

struct Column {
    std::string name;
    ColumnType type;
    ColumnRole role;
    uint64_t empty() const noexcept; // the cell without a number: NaN or 0
    double number(uint64_t cell) const noexcept;
};

class Columns {
  public:
    // The columns of the library, then those of an estimator with these further values and parameters (names separated
    // by spaces or commas). Status::argument for invalid names and for too many.
    explicit Columns(std::string_view further = {}, bool reduced = false, std::string_view parameters = {});
    // Reads the columns of a ledger header. Status::format if they are invalid.
    static Columns load(ByteReader &in, size_t count);
    void save(ByteWriter &out) const;
    static constexpr size_t kSavedSize = 64; // bytes per column

    const std::vector<Column> &all() const noexcept { return all_; }
    size_t count() const noexcept { return all_.size(); }
    size_t find(std::string_view name) const noexcept;       // returns count() if there is none
    size_t own() const noexcept;                             // number of columns of the library
    bool is_reduced() const noexcept { return is_reduced_; } // whether it has those of a reduction
    // Whether on-target intervals have records of their own (interval_records.hpp).
    bool has_intervals() const noexcept { return has_intervals_ && count() > 1; }
    size_t values() const noexcept; // number of values of the estimator, including the first
    std::string further() const;    // names of the further values, as for the constructor
    std::string parameters() const; // of the parameters
    Cells empty() const noexcept;

  private:
    void add(std::string name, ColumnType type, ColumnRole role);
    std::string names_of(ColumnRole role) const;
    std::vector<Column> all_;
    bool is_reduced_ = false, has_intervals_ = false;
};

// Maps cells in the columns of one ledger to those of another, matched by name and type.
class Arrangement {
  public:
    Arrangement(const Columns &from, const Columns &to);
    Cells operator()(const Cells &cells) const noexcept;

  private:
    Cells empty_;
    std::vector<size_t> from_; // source of each column; kMaxColumns: none
};

} // namespace toliman::track
