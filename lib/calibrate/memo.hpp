// Results of the costly functions of a calibration, in the order of their calls, kept in a journal.
#pragma once
#include <initializer_list>

#include "backend/journal.hpp"
#include "calibrate/map.hpp"
#include "calibrate/solve.hpp"

namespace toliman::calibrate {

// What the results depend on, for the journal; the rest is in their keys.
std::vector<Journal::Input> inputs_of(const Problem &problem, const optics::Outline &nominal, const Point &start);

// A linearisation, or the error of a scene that is refused: the latter is lost, too.
struct Linearised {
    Linearisation normal;
    bool refused = false;
};

using Own = std::vector<std::array<double, kOwn>>;

class Memo {
  public:
    // journal: may be NULL.
    explicit Memo(Journal *journal) noexcept : journal_(journal) {}

    // What the next calls are for: results of another model are not taken.
    void begin(const Problem &problem, uint32_t improved) noexcept;

    // The result of an earlier process for this function at this point and these numbers, or that of compute(), which is
    // appended. Where the calls differ from those of the earlier process, its further results are dropped.
    template <class Result, class Compute>
    Result of(const Point &point, std::initializer_list<uint64_t> numbers, const Compute &compute) {
        if (journal_ == nullptr)
            return compute();
        const uint64_t key = key_of(static_cast<const Result *>(nullptr), point, numbers);
        Result result;
        const Journal::Record *const next = journal_->next();
        recalled_ = next != nullptr && next->key == key && read(next->bytes, result);
        if (recalled_) {
            journal_->take();
            return result;
        }
        result = compute();
        journal_->append(key, bytes_of(result));
        return result;
    }
    bool recalled() const noexcept { return recalled_; } // the last result

  private:
    template <class Result>
    uint64_t key_of(const Result *, const Point &point, std::initializer_list<uint64_t> numbers) const noexcept;
    template <class Result> static bool read(const std::vector<uint8_t> &bytes, Result &result);
    template <class Result> static std::vector<uint8_t> bytes_of(const Result &result);

    Journal *journal_;
    uint64_t model_ = 0; // hash
    bool recalled_ = false;
};

} // namespace toliman::calibrate
