// Evaluation of frames on worker threads: identity, validation, estimate and reduction.
#pragma once
#include <exception>
#include <vector>

#include "base/buffer.hpp"
#include "track/plan.hpp"
#include "track/registry.hpp"

namespace toliman::track {

// Result of a worker for one frame.
struct Job {
    uint64_t stream = 0;
    uint32_t content = 0;
    Outcome outcome;
    Estimated estimated;
    Reason unreduced = Reason::none;
    Reduction reduction;
    std::exception_ptr failure; // of the reduction: no memory
};

class Evaluation {
  public:
    static constexpr size_t kBatch = 256; // maximum number of frames at once

    // Plan and registry must outlive the object. Without an estimator there is nothing to evaluate.
    Evaluation(const Plan &plan, Estimate estimate, const Registry &registry);
    Evaluation(const Evaluation &) = delete;
    Evaluation &operator=(const Evaluation &) = delete;

    bool has_estimator() const noexcept { return estimate_ != nullptr; }
    // The columns of the records; those of the plan until then.
    void set_columns(const Columns &columns) { arrange_ = Arrangement(plan_.columns, columns); }

    // Evaluates frames on all workers. With one worker, frames without intervals that are not reduced allocate nothing.
    void run(const Frame *frames, size_t count);
    // The result of frame i of the last run. Throws what a reduction or a shortage of memory has thrown.
    Job &result(size_t i);
    // Replaces a misfit by the frame that the caller gives for it, unless that is one, too.
    void retry(Frame &frame, Job &job);
    // In the columns of the records.
    Record record_of(const Frame &frame, const Job &job) const noexcept;

  private:
    void evaluate(const Frame &frame, Job &job, unsigned worker) noexcept;
    void validate_and_estimate(const Frame &frame, Job &job, unsigned worker);
    void reduce(const Frame &frame, Job &job, unsigned worker) noexcept;
    Cells cells_of(const Frame &frame, const Job &job) const noexcept;

    const Plan &plan_;
    const Registry &registry_;
    Estimate estimate_;
    Arrangement arrange_;             // plan's columns -> those of the records
    std::vector<OnTarget> on_target_; // of each worker
    Buffer<double> images_;           // [workers][out_rows * out_cols]
    std::vector<Job> jobs_;
};

} // namespace toliman::track
