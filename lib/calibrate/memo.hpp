// Results of the costly functions of a calibration, in the order of their calls, kept in a journal.
#pragma once
#include <chrono>
#include <cstdint>
#include <initializer_list>
#include <vector>

#include "backend/journal.hpp"
#include "base/bytes.hpp"
#include "calibrate/problem.hpp"

namespace toliman::calibrate {

// What all results depend on, for the journal; the rest is in their keys.
std::vector<Journal::Input> inputs_of(const Problem &problem, const optics::Outline &nominal, const Point &start);

uint64_t hash_of(const Point &point) noexcept;
inline uint64_t bits_of(double value) noexcept {
    return with_bits<uint64_t>(value);
}

class Memo {
  public:
    explicit Memo(Journal &journal) noexcept : journal_(journal) {}

    // What the next calls are for: results of another model are not taken. improved: the changes of the scene.
    void begin(const Problem &problem, uint32_t improved) noexcept;

    // The result of an earlier process, if it is the next one in the journal and has this key; or that of compute(),
    // which is appended. Results of calls within compute() are kept until then, and those on the disk only by chance.
    template <class Result, class Compute> Result of(std::initializer_list<uint64_t> what, const Compute &compute) {
        const uint64_t key = key_of(what, static_cast<const Result *>(nullptr));
        Result result;
        recalled_ = take(key, result);
        if (recalled_)
            return result;
        const uint64_t before = journal_.position();
        depth_++;
        try {
            result = compute();
        } catch (...) {
            depth_--;
            throw;
        }
        depth_--;
        journal_.return_to(before);
        append(key, result);
        recalled_ = false;
        return result;
    }
    bool recalled() const noexcept { return recalled_; } // the last result

  private:
    template <class Result> uint64_t key_of(std::initializer_list<uint64_t> what, const Result *kind) const noexcept;
    template <class Result> bool take(uint64_t key, Result &result);
    template <class Result> void append(uint64_t key, const Result &result);

    Journal &journal_;
    uint64_t model_ = 0; // hash
    int depth_ = 0;      // of calls of of()
    bool recalled_ = false;
    std::chrono::steady_clock::time_point durable_; // the last result that survives a failure of the machine
};

// memo: NULL computes.
template <class Result, class Compute>
Result recalled(Memo *memo, std::initializer_list<uint64_t> what, const Compute &compute) {
    return memo != nullptr ? memo->of<Result>(what, compute) : compute();
}

} // namespace toliman::calibrate
