#include "track/sample_batch.hpp"

#include <algorithm>

#include "base/workers.hpp"

namespace toliman::track {

namespace {

constexpr size_t kMostBytes = size_t{256} << 20;

} // namespace

SampleBatch::SampleBatch(period::Stream &sums, unsigned workers)
    : sums_(sums), workers_(1 + std::min<unsigned>(workers - 1, static_cast<unsigned>(std::min<size_t>(
                                                                    kMostBytes / sums.saved_size(), kMostWorkers)))) {
    samples_.reserve(kSamples);
    rows_.reserve(kSamples);
}

void SampleBatch::push(const period::Sample &sample, const Row &row) {
    samples_.push_back(sample);
    rows_.push_back(row);
    if (samples_.size() == kSamples)
        flush();
}

// Few samples do not pay for further sums.
void SampleBatch::flush() {
    const bool is_parallel = workers_ > 1 && samples_.size() == kSamples;
    while (is_parallel && parts_.size() + 1 < workers_)
        parts_.emplace_back(sums_.grid());
    for (size_t i = 0; i < samples_.size(); i++)
        if (samples_[i].columns != nullptr)
            samples_[i].columns = rows_[i].data();
    const size_t parts = is_parallel ? workers_ : 1;
    run_jobs(workers_, parts, [&](size_t part) {
        period::Stream &sums = part == 0 ? sums_ : parts_[part - 1];
        for (size_t i = part; i < samples_.size(); i += parts)
            sums.push(samples_[i]);
    });
    samples_.clear();
    rows_.clear();
}

void SampleBatch::finish() {
    flush();
    for (const period::Stream &part : parts_)
        sums_.merge(part);
    parts_.clear();
}

} // namespace toliman::track
