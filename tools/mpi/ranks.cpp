// Method: each rank holds the exact sums of its share of the samples as a TLMP state. MPI_Reduce adds them up with a
// user-defined operation on one contiguous element per rank, which loads two states, merges them and saves the result.
// The sums are integers, so the result has the same bits in any order of reduction and for any number of ranks. After
// every step the ranks exchange their exit codes, so that a failure on one of them ends all with the same code.
#include "ranks.hpp"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <mpi.h>

#include "series/periodogram.hpp"

namespace mpi {

namespace {

toliman::periodogram state_from(const void *bytes, int size) {
    return toliman::make<toliman::periodogram>(toliman_period_load, bytes, static_cast<size_t>(size), nullptr);
}

// The MPI operation of the reduction: every element of the type is a whole state. It cannot return an error, so it
// aborts.
void add_states(void *more, void *sums, int *count, MPI_Datatype *type) {
    const cli::Ending ending = cli::ending_of([&] {
        int size = 0;
        MPI_Type_size(*type, &size);
        for (ptrdiff_t at = 0; at < *count; at++) {
            auto *into = static_cast<unsigned char *>(sums) + at * size;
            const toliman::periodogram sum = state_from(into, size);
            const toliman::periodogram other = state_from(static_cast<unsigned char *>(more) + at * size, size);
            toliman::check(toliman_period_merge(sum.get(), other.get()));
            const std::vector<unsigned char> bytes = cli::state_bytes(sum);
            std::copy(bytes.begin(), bytes.end(), into);
        }
    });
    if (ending.code == cli::kExitOk)
        return;
    std::fprintf(stderr, "toliman-mpi: cannot add up the sums of the ranks: %s\n", ending.why.c_str());
    MPI_Abort(MPI_COMM_WORLD, ending.code);
}

} // namespace

bool launched() {
    const auto names = {"OMPI_COMM_WORLD_RANK", "PMIX_RANK", "PMI_RANK", "SLURM_PROCID"};
    return std::any_of(names.begin(), names.end(), [](const char *name) { return std::getenv(name) != nullptr; });
}

Ranks::Ranks() {
    MPI_Init(nullptr, nullptr);
    MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
    MPI_Comm_size(MPI_COMM_WORLD, &size_);
}

Ranks::~Ranks() {
    MPI_Finalize();
}

void Ranks::together(const std::function<void()> &work) const {
    const cli::Ending ending = cli::ending_of(work);
    const int own = ending.code;
    std::vector<int> codes(static_cast<size_t>(size_));
    MPI_Allgather(&own, 1, MPI_INT, codes.data(), 1, MPI_INT, MPI_COMM_WORLD);
    const auto failed = [](int code) { return code != cli::kExitOk; };
    const auto lowest = std::find_if(codes.begin(), codes.end(), failed);
    if (lowest == codes.end())
        return;
    if (lowest - codes.begin() == rank_) {
        const bool everywhere = std::all_of(codes.begin(), codes.end(), failed);
        const std::string where = everywhere ? "" : "rank " + std::to_string(rank_) + ": ";
        std::fprintf(stderr, "toliman-mpi: %s%s\n", where.c_str(), ending.why.c_str());
    }
    throw Ended{static_cast<cli::ExitCode>(*lowest)};
}

int64_t Ranks::of_first(int64_t own) const {
    MPI_Bcast(&own, 1, MPI_INT64_T, 0, MPI_COMM_WORLD);
    return own;
}

void Ranks::add(std::vector<uint32_t> &numbers) const {
    MPI_Allreduce(MPI_IN_PLACE, numbers.data(), static_cast<int>(numbers.size()), MPI_UINT32_T, MPI_SUM,
                  MPI_COMM_WORLD);
}

toliman::periodogram Ranks::sum(const toliman::periodogram &own) const {
    std::vector<unsigned char> bytes = cli::state_bytes(own);
    MPI_Datatype state;
    MPI_Op add;
    MPI_Type_contiguous(static_cast<int>(bytes.size()), MPI_BYTE, &state);
    MPI_Type_commit(&state);
    MPI_Op_create(add_states, 1, &add);
    if (first())
        MPI_Reduce(MPI_IN_PLACE, bytes.data(), 1, state, add, 0, MPI_COMM_WORLD);
    else
        MPI_Reduce(bytes.data(), nullptr, 1, state, add, 0, MPI_COMM_WORLD);
    MPI_Op_free(&add);
    MPI_Type_free(&state);
    return first() ? state_from(bytes.data(), static_cast<int>(bytes.size())) : nullptr;
}

} // namespace mpi
