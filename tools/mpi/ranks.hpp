// The ranks of an MPI job: common failure, and the sum of their exact periodograms.
#pragma once
#include <functional>
#include <vector>

#include <toliman/toliman.hpp>

#include "common/failure.hpp"

namespace mpi {

// Thrown by together() on every rank, after the reason was printed.
struct Ended {
    cli::ExitCode code;
};

// Whether mpirun, srun or a similar launcher started this process: each sets a variable with the rank. Needs no MPI.
bool launched();

class Ranks {
  public:
    Ranks();
    ~Ranks();
    Ranks(const Ranks &) = delete;
    Ranks &operator=(const Ranks &) = delete;

    bool first() const noexcept { return rank_ == 0; }
    int64_t size() const noexcept { return size_; }
    // First index, and index after the last, of this rank's share of `count` items.
    int64_t share_begin(int64_t count) const noexcept { return count * rank_ / size_; }
    int64_t share_end(int64_t count) const noexcept { return count * (rank_ + 1) / size_; }

    // Does the work on every rank and waits for all. If it fails on some ranks, the lowest of them prints the reason,
    // and all throw Ended with its code.
    void together(const std::function<void()> &work) const;

    // The first rank's number.
    int64_t of_first(int64_t own) const;
    // Adds up the numbers of all ranks, on all ranks.
    void add(std::vector<uint32_t> &numbers) const;

    // The sum of all ranks' periodograms on the first rank; an empty pointer on the others. All must have the same grid
    // and options; then the result has the same bits for any number of ranks.
    toliman::periodogram sum(const toliman::periodogram &own) const;

  private:
    int rank_ = 0, size_ = 1;
};

} // namespace mpi
