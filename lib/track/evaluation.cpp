// Threads: workers validate and estimate frames in parallel. They read the registry, which changes only between runs.
#include "track/evaluation.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <memory>
#include <new>
#include <utility>

#include "base/bytes.hpp"
#include "base/error.hpp"
#include "base/workers.hpp"

namespace toliman::track {

namespace {

// Whether the exception in flight is a shortage of memory.
bool is_short_of_memory() noexcept {
    try {
        throw;
    } catch (const std::bad_alloc &) {
        return true;
    } catch (const Error &error) {
        return error.status() == Status::memory;
    } catch (...) {
        return false;
    }
}

constexpr size_t kSpans = 64; // of a frame, for which memory is reserved

} // namespace

Evaluation::Evaluation(const Plan &plan, Estimate estimate, const Registry &registry)
    : plan_(plan), registry_(registry), estimate_(std::move(estimate)), arrange_(plan.columns, plan.columns) {
    images_.resize(plan_.workers * plan_.terms.geometry.out_rows * plan_.terms.geometry.out_cols);
    jobs_.resize(kBatch);
    on_target_.resize(plan_.workers);
    for (OnTarget &one : on_target_)
        one.spans.reserve(kSpans);
}

void Evaluation::run(const Frame *frames, size_t count) {
    std::atomic<size_t> next{0}; // dynamic: slower workers process fewer frames
    const auto evaluate_next = [&](size_t worker) noexcept {
        for (size_t i; (i = next.fetch_add(1, std::memory_order_relaxed)) < count;)
            evaluate(frames[i], jobs_[i], static_cast<unsigned>(worker));
    };
    const auto workers = static_cast<unsigned>(std::min<size_t>(plan_.workers, count));
    if (workers > 1)
        run_jobs(workers, workers, evaluate_next);
    else
        evaluate_next(0);
}

Job &Evaluation::result(size_t i) {
    if (jobs_[i].failure)
        std::rethrow_exception(std::exchange(jobs_[i].failure, nullptr));
    return jobs_[i];
}

void Evaluation::retry(Frame &frame, Job &job) {
    const auto is_misfit = [this](const Job &one) {
        return one.outcome.flaw.reason == Reason::none && registry_.is_misfit(one.outcome.goodness.chi_square);
    };
    Frame other = frame;
    if (!plan_.retry || !is_misfit(job) || !plan_.retry(frame, job.outcome, other))
        return;
    const auto second = std::make_unique<Job>();
    evaluate(other, *second, 0);
    if (second->failure)
        std::rethrow_exception(second->failure);
    if (second->outcome.flaw.reason != Reason::none || is_misfit(*second))
        return;
    frame = other;
    job = *second;
}

// Runs in a worker: identifies a frame and, unless it is a duplicate, validates and estimates it.
void Evaluation::evaluate(const Frame &frame, Job &job, unsigned worker) noexcept {
    job = Job();
    job.stream = stream_digest(frame.session, frame.roi, frame.restarts);
    job.content = content_of(frame);
    if (!registry_.knows(key_digest(job.stream, frame.frame_id), job.content))
        validate_and_estimate(frame, job, worker);
}

// A frame is not rejected because memory is short: the push fails instead.
void Evaluation::validate_and_estimate(const Frame &frame, Job &job, unsigned worker) {
    Outcome &outcome = job.outcome;
    const Terms &terms = plan_.terms;
    double *image = images_.data() + worker * terms.geometry.out_rows * terms.geometry.out_cols;
    outcome.flaw = check_and_bin(frame, terms.geometry, image);
    if (outcome.flaw.reason != Reason::none)
        return;
    const std::optional<int64_t> tai_ns = plan_.clock.tai_ns(frame.camera_ns);
    if (!tai_ns || !registry_.covers(*tai_ns)) {
        outcome.flaw.reason = Reason::clock;
        return;
    }
    outcome.tai_ns = *tai_ns;
    try {
        Frame placed = frame;
        placed.is_reduced = plan_.reduce != nullptr;
        const bool has_window = frame.window_row != 0 || frame.window_col != 0;
        if (has_window && terms.geometry.bin == 1)
            placed.image_window = DetectorWindow{frame.window_row + static_cast<int64_t>(terms.geometry.crop_row),
                                                 frame.window_col + static_cast<int64_t>(terms.geometry.crop_col)};
        estimate_(image, placed, *tai_ns, worker, job.estimated);
    } catch (...) {
        outcome.flaw.reason = Reason::estimate;
        if (is_short_of_memory())
            job.failure = std::current_exception();
        return;
    }
    const Estimated &found = job.estimated;
    const double measured = plan_.reduce ? found.further[plan_.columns.find(kMeasured) - plan_.columns.own()] : 0;
    if (!std::isfinite(found.value) || !std::isfinite(measured)) {
        outcome.flaw = {Reason::estimate, 0, 0, std::isfinite(found.value) ? measured : found.value};
    } else if (found.sigma != 0 && !terms.allows_sigma(found.sigma)) {
        outcome.flaw = {Reason::estimate, 0, 0, found.sigma};
    } else {
        outcome.value = found.value;
        outcome.goodness = goodness_of(found.chi_square, found.chi_square_sigma, found.largest_residual, kFrameSigmas);
        outcome.bad_pixels = found.bad_pixels;
        if (plan_.reduce)
            reduce(frame, job, worker);
    }
}

void Evaluation::reduce(const Frame &frame, Job &job, unsigned worker) noexcept try {
    OnTarget &on_target = on_target_[worker];
    const double exposure_s = frame.exposure_s > 0 ? frame.exposure_s : plan_.timing.exposure_s;
    const bool fits =
        find_on_target(frame.camera_ns, exposure_s, frame.intervals, frame.interval_count, plan_.clock, on_target);
    job.unreduced = fits ? plan_.reduce(on_target, job.reduction) : Reason::no_orbit;
} catch (...) {
    job.failure = std::current_exception();
}

// Cells in the order of the plan's columns.
Cells Evaluation::cells_of(const Frame &frame, const Job &job) const noexcept {
    Cells cells = plan_.columns.empty();
    const auto cell = [&](OwnColumn column) -> uint64_t & { return cells[static_cast<size_t>(column)]; };
    cell(OwnColumn::exposure_s) = with_bits<uint64_t>(frame.exposure_s);
    cell(OwnColumn::shift_s) = with_bits<uint64_t>(mean_shift_s(frame));
    cell(OwnColumn::window_row) = static_cast<uint64_t>(frame.window_row);
    cell(OwnColumn::window_col) = static_cast<uint64_t>(frame.window_col);
    if (job.outcome.flaw.reason != Reason::none)
        return cells;
    cell(OwnColumn::intervals) = frame.interval_count;
    if (plan_.reduce)
        store(job.unreduced == Reason::none ? &job.reduction : nullptr, cells);
    cell(OwnColumn::chi_square) = with_bits<uint64_t>(job.estimated.chi_square);
    cell(OwnColumn::chi_square_sigma) = with_bits<uint64_t>(job.estimated.chi_square_sigma);
    cell(OwnColumn::largest_residual) = with_bits<uint64_t>(job.estimated.largest_residual);
    cell(OwnColumn::bad_pixels) = job.estimated.bad_pixels;
    cell(OwnColumn::flags) = job.estimated.flags;
    const size_t own = plan_.columns.own();
    for (size_t i = own; i < plan_.columns.count(); i++)
        cells[i] = with_bits<uint64_t>(job.estimated.further[i - own]);
    return cells;
}

Record Evaluation::record_of(const Frame &frame, const Job &job) const noexcept {
    Record record;
    record.stream = job.stream;
    record.content = job.content;
    record.frame_id = frame.frame_id;
    record.camera_ns = frame.camera_ns;
    record.tai_ns = job.outcome.tai_ns;
    record.value = job.outcome.value;
    record.reason = job.outcome.flaw.reason;
    record.sigma = frame.sigma != 0 ? frame.sigma : plan_.terms.sigma;
    if (record.reason == Reason::none && job.estimated.sigma != 0)
        record.sigma = job.estimated.sigma;
    record.cells = arrange_(cells_of(frame, job));
    record.dropped = static_cast<uint32_t>(std::min<int64_t>(frame.dropped, kMostDropped));
    const bool is_limited = !plan_.reduce; // otherwise the reduced value is: sample_of()
    record.kind = record.reason != Reason::none                                     ? Kind::rejected
                  : is_limited && std::fabs(record.value) > plan_.terms.value_limit ? Kind::outlier
                                                                                    : Kind::accepted;
    if (record.kind == Kind::accepted)
        record.reason = job.unreduced;
    return record;
}

} // namespace toliman::track
