// The ranks of an MPI job: they fail together, and add up their exact sums.
#pragma once
#include <functional>
#include <vector>

#include <toliman/toliman.hpp>

#include "common/failure.hpp"

namespace mpi {

// What together() throws on every rank, after the reason was told.
struct Ended {
    cli::ExitCode code;
};

// Whether mpirun, srun or the like started this process: each sets a variable with its rank. Needs no MPI.
bool launched();

class Ranks {
  public:
    Ranks();
    ~Ranks();
    Ranks(const Ranks &) = delete;
    Ranks &operator=(const Ranks &) = delete;

    bool first() const noexcept { return rank_ == 0; }
    // Where this rank's share of `count` things starts and ends.
    int64_t share_begin(int64_t count) const noexcept { return count * rank_ / size_; }
    int64_t share_end(int64_t count) const noexcept { return count * (rank_ + 1) / size_; }

    // Does the work on every rank and waits for all. Where it fails on some, the lowest of them tells why, and all
    // throw Ended with its code.
    void together(const std::function<void()> &work) const;

    // The sums of all ranks' periodograms, on the first rank; nothing on the others. All must have one grid and one set
    // of options, so that the result has the same bits whatever the ranks.
    toliman::periodogram sum(const toliman::periodogram &own) const;

  private:
    int rank_ = 0, size_ = 1;
};

} // namespace mpi
