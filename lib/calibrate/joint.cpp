// Method: with the counts' derivatives J by a frame's own parameters and G by those of the instrument, weights W and
// residuals r, the block of a frame is
//     ( J'WJ  J'WG )        ( J'Wr )
//     ( G'WJ  G'WG )  and   ( G'Wr ),
// accumulated row by row. In a sum of N frames, J and r are those of its own spread; G is N times that of a frame with
// the mean spread of all (planes.cpp): the mean of r is 0 at the truth, so that an inexact G adds no bias. Blocks are
// summed in the order of the frames: the bits do not depend on the workers.
#include "calibrate/joint.hpp"

#include <algorithm>
#include <cmath>

#include "base/workers.hpp"
#include "calibrate/memo.hpp"
#include "kernels/normal.hpp"

namespace toliman::calibrate {

namespace {

constexpr size_t kWhitenedAtOnce = 16; // frames
constexpr size_t kKeptPerWorker = 4;   // frames, after which progress is reported and their blocks are kept

} // namespace

Joint::Joint(const Problem &problem, const Point &point, size_t window, const Joint *before)
    : problem_(problem), point_(point), window_(problem.windows[window]) {
    const auto fit_at = [&](size_t start) {
        optics::Outline outline = outline_at(problem, point.instrument[start], point.map_m);
        if (!point.response.empty())
            change_response(point.response, outline.scene.detector);
        const optics::Simulator simulator(outline, problem.settings);
        return std::make_shared<const fit::Fit>(simulator, std::vector<Parameter>(), problem.capture_px,
                                                simulator.plan().workers, Progress());
    };
    if (window_.frames.empty())
        return;
    first_ = before != nullptr && before->next_ != nullptr ? before->next_ : fit_at(window);
    if (std::any_of(window_.shares.begin(), window_.shares.end(), [](double share) { return share > 0; }))
        next_ = fit_at(window + 1);
}

std::shared_ptr<const fit::Fit> Joint::fit_of(size_t frame) const {
    const auto found = std::find(window_.frames.begin(), window_.frames.end(), frame) - window_.frames.begin();
    const double share = window_.shares.empty() ? 0 : window_.shares[static_cast<size_t>(found)];
    return fit::of_sum(share > 0 ? std::make_shared<const fit::Fit>(*first_, *next_, share) : first_,
                       problem_.frames.predictions[frame].spread);
}

Block Joint::block(size_t frame, const Planes &planes, double blend) const {
    const std::shared_ptr<const fit::Fit> fit = fit_of(frame);
    const size_t rows = fit->rows(), cols = fit->cols(), n = planes.parameters(), size = kOwn + n;
    const double *const values = point_.own[frame].data(), exposures = problem_.frames.predictions[frame].spread.frames;
    Buffer<double> counts(rows * cols), lines(n * cols), scratch(planes.scratch_size()), products(cols),
        sums((size + 1) * (size + 1) * kernels::kNormalLanes);
    problem_.frames.read(frame, counts.data());
    std::vector<double *> own_lines;
    std::vector<const double *> columns(kOwn);
    for (size_t i = 0; i < n; i++) {
        own_lines.push_back(&lines[i * cols]);
        columns.push_back(own_lines.back());
    }
    columns.push_back(nullptr); // residual
    Planes::Places places;
    planes.place(values, places, scratch.data());
    fit->model().undo(counts.data());
    fit::Work work = fit->model().work();
    work.bad = point_.bad_of(frame);
    const ImageView<const double> view = {counts.data(), rows, cols, cols};
    fit->model().visit(&view, values, blend, work, [&](const fit::Model::Row &row) {
        planes.row(values, places, row.row, own_lines.data(), scratch.data());
        for (size_t i = 0; i < kOwn; i++)
            columns[i] = row.derivatives[i];
        columns[size] = row.residual;
        kernels::normal_kernels().add(columns.data(), size + 1, row.weight, cols, products.data(), sums.data());
    });
    const auto sum = [&](size_t i, size_t j) {
        return kernels::sum_of_lanes(&sums[(i * (size + 1) + j) * kernels::kNormalLanes]);
    };
    const auto scale = [&](size_t i) { return i < kOwn ? fit::Model::scale_of(i, values) : exposures; };
    Block block = {Buffer<double>(size * size), Buffer<double>(size)};
    for (size_t i = 0; i < size; i++) {
        for (size_t j = i; j < size; j++)
            block.matrix[i * size + j] = block.matrix[j * size + i] = scale(i) * scale(j) * sum(i, j);
        block.gradient[i] = scale(i) * sum(i, size);
    }
    block.chi_square = sum(size, size);
    block.inverse_counts = sum(fit::background, fit::background);
    block.used = work.used;
    block.saturated = work.saturated;
    return block;
}

void Joint::linearise(const Planes &planes, double blend, Linearisation &all) const {
    for (const size_t frame : window_.frames)
        if (!fit_of(frame)->model().covers(point_.own[frame].data()) || !planes.covers(point_.own[frame].data())) {
            all.lost = true;
            return;
        }
    const size_t count = window_.frames.size(), at_once = problem_.settings.workers * kKeptPerWorker;
    for (size_t first = 0; first < count; first += at_once) {
        problem_.settings.progress.report("frames", static_cast<double>(window_.frames[first]) /
                                                        static_cast<double>(problem_.frames.count));
        std::vector<Block> made = recalled<std::vector<Block>>(
            problem_.memo, {hash_of(point_), bits_of(blend), planes.key(), window_.frames[first], at_once},
            [&] { return blocks(first, std::min(at_once, count - first), planes, blend); });
        for (size_t i = 0; i < made.size(); i++)
            all.blocks[window_.frames[first + i]] = std::move(made[i]);
    }
}

// Of `count` frames of the window, from number `first` on.
std::vector<Block> Joint::blocks(size_t first, size_t count, const Planes &planes, double blend) const {
    std::vector<Block> blocks(count);
    run_jobs(problem_.settings.workers, count, [&](size_t i) {
        const size_t frame = window_.frames[first + i];
        in_frame(frame, [&] { blocks[i] = block(frame, planes, blend); });
    });
    return blocks;
}

void Joint::whiten(const std::vector<size_t> &frames, const std::function<void(const Whitened &)> &on_frame) const {
    const size_t rows = problem_.nominal.detector.rows, cols = problem_.nominal.detector.cols, pixels = rows * cols;
    for (size_t first = 0; first < frames.size(); first += kWhitenedAtOnce) {
        const size_t count = std::min(kWhitenedAtOnce, frames.size() - first);
        Buffer<double> residuals(count * pixels);
        run_jobs(problem_.settings.workers, count, [&](size_t i) {
            const size_t frame = frames[first + i];
            Buffer<double> counts(pixels);
            problem_.frames.read(frame, counts.data());
            const std::shared_ptr<const fit::Fit> fit = fit_of(frames[first + i]);
            fit->model().undo(counts.data());
            fit::Work work = fit->model().work();
            work.bad = point_.bad_of(frames[first + i]);
            const ImageView<const double> view = {counts.data(), rows, cols, cols};
            fit->model().visit(&view, point_.own[frame].data(), 0, work, [&](const fit::Model::Row &row) {
                for (size_t x = 0; x < cols; x++)
                    residuals[i * pixels + row.row * cols + x] = std::sqrt(row.weight[x]) * row.residual[x];
            });
        });
        for (size_t i = 0; i < count; i++)
            on_frame({frames[first + i], &residuals[i * pixels]});
    }
}

void Joint::find_bad_pixels(std::vector<BadPixels> &bad) const {
    run_jobs(problem_.settings.workers, window_.frames.size(), [&](size_t i) {
        const size_t frame = window_.frames[i];
        const std::shared_ptr<const fit::Fit> fit = fit_of(frame);
        Buffer<double> counts(fit->rows() * fit->cols());
        problem_.frames.read(frame, counts.data());
        fit->model().undo(counts.data());
        fit::FitWork work = fit->work();
        bad[frame] =
            fit->bad_pixels_at({counts.data(), fit->rows(), fit->cols(), fit->cols()}, point_.own[frame].data(), work);
    });
}

std::vector<BadPixels> find_bad_pixels(const Problem &problem, const Point &point) {
    std::vector<BadPixels> bad(problem.frames.count);
    std::unique_ptr<Joint> joint;
    for (size_t window = 0; window < problem.windows.size(); window++) {
        joint = std::make_unique<Joint>(problem, point, window, joint.get());
        joint->find_bad_pixels(bad);
    }
    const bool any = std::any_of(bad.begin(), bad.end(), [](const BadPixels &one) { return one.count() > 0; });
    return any ? bad : std::vector<BadPixels>();
}

Linearisation linearise(const Problem &problem, const Point &point, const Planes &planes, double blend) {
    Linearisation all;
    all.blocks.resize(problem.frames.count);
    std::unique_ptr<Joint> joint;
    for (size_t window = 0; window < problem.windows.size() && !all.lost; window++) {
        joint = std::make_unique<Joint>(problem, point, window, joint.get());
        joint->linearise(planes, blend, all);
    }
    for (const Block &block : all.blocks) {
        all.chi_square += block.chi_square;
        all.inverse_counts += block.inverse_counts;
        all.used += block.used;
    }
    if (all.used > 0)
        all.excess = std::max(1.0, all.chi_square / static_cast<double>(all.used));
    return all;
}

} // namespace toliman::calibrate
