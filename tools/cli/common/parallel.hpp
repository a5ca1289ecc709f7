// Runs independent jobs on all processors.
#pragma once
#include "common/common.hpp"

namespace cli {

// Runs job(0) ... job(count - 1), each once, on `most` threads; 0: as many as there are processors. The calling thread
// runs job 0 and then the next one that is left, as the other threads do. After an exception no further job starts; the
// exception of the lowest job is rethrown when all threads have ended.
void run_parallel(size_t count, const std::function<void(size_t)> &job, size_t most = 0);

} // namespace cli
