// Pushes many samples into sums on several threads. Exact sums do not depend on how their samples were divided.
#pragma once
#include <vector>

#include "period/stream/stream.hpp"
#include "track/reduction.hpp"

namespace toliman::track {

class SampleBatch {
  public:
    // Each worker but the first has sums of its own, as long as these take at most 256 MiB together.
    SampleBatch(period::Stream &sums, unsigned workers);
    SampleBatch(const SampleBatch &) = delete;
    SampleBatch &operator=(const SampleBatch &) = delete;

    // A sample that the sums cover; its columns, if it has any, are those of the row.
    void push(const period::Sample &sample, const Row &row);
    // Adds what is left; without it, the samples that were pushed are lost.
    void finish();

  private:
    void flush();
    static constexpr size_t kSamples = 8192; // that are pushed together
    period::Stream &sums_;
    unsigned workers_;
    std::vector<period::Stream> parts_; // of the further workers
    std::vector<period::Sample> samples_;
    std::vector<Row> rows_;
};

} // namespace toliman::track
