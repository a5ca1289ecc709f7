// Method: the frames of all windows are rows of the same planes, at the places of their stars. Each product computes
// these rows again, which costs less than their transforms, so that memory does not depend on the number of frames.
// Frames are distributed over a fixed number of chunks, whose sums are added in order: the bits do not depend on the
// workers. Weights, derivatives and matrices are of the same planes: an operator with a Schur complement of matrices of
// another model might have negative eigenvalues.
#include "calibrate/map_frames.hpp"

#include <algorithm>

#include "base/workers.hpp"
#include "kernels/normal.hpp"

namespace toliman::calibrate {

// A frame row by row; of one thread.
class MapFrames::Rows {
  public:
    Rows(const MapFrames &owner, size_t frame)
        : owner_(owner), atlas_(owner.planes_.atlas()), values_(owner.point_.own[frame].data()), cols_(atlas_.cols()),
          size_(kOwn + owner.planes_.parameters()), lines_(size_ * cols_, 1.0), work_(7 * cols_),
          scratch_(owner.planes_.scratch_size()), sums_((size_ + 1) * (size_ + 1) * kernels::kNormalLanes) {
        owner.planes_.place(values_, derivative_places_, scratch_.data());
        for (size_t star = 0; star < 2; star++)
            places_[star] = atlas_.place(star, values_[2 * star], values_[2 * star + 1], 2);
        for (size_t i = 0; i < size_; i++)
            line_of_.push_back(&lines_[i * cols_]);
        columns_.assign(line_of_.begin(), line_of_.end());
        columns_.push_back(residual());
    }

    // Derivatives by all parameters, and weights.
    void compute(size_t r) {
        double *const light = line(0);
        std::fill_n(light, cols_, values_[fit::background]);
        for (size_t star = 0; star < 2; star++) {
            double *const out[] = {line_of_[fit::flux_a + star], line_of_[2 * star], line_of_[2 * star + 1]};
            atlas_.row(star, 0, places_[star], r, 2, out, scratch_.data());
            for (size_t x = 0; x < cols_; x++) {
                light[x] += flux(star) * out[0][x];
                out[1][x] *= flux(star);
                out[2][x] *= flux(star);
            }
        }
        owner_.planes_.row(values_, derivative_places_, r, line_of_.data() + kOwn, scratch_.data());
        owner_.model_.weigh(r, light, weight(), line(5));
    }

    // The change of the row by that of the images into residual().
    void change(const StarSamples &images, size_t r) {
        std::fill_n(residual(), cols_, 0.0);
        for (size_t star = 0; star < 2; star++) {
            atlas_.row_of_samples(star, images[star], places_[star], r, line(0), scratch_.data());
            for (size_t x = 0; x < cols_; x++)
                residual()[x] += flux(star) * line(0)[x];
        }
    }
    void subtract(const double *own, const double *instrument) {
        for (size_t i = 0; i < size_; i++) {
            const double factor = i < kOwn ? own[i] : instrument[i - kOwn];
            for (size_t x = 0; x < cols_; x++)
                residual()[x] -= factor * line_of_[i][x];
        }
    }
    // Adds the adjoint of change() of weight times residual().
    void gather(size_t r, StarSamples &samples) {
        for (size_t star = 0; star < 2; star++) {
            for (size_t x = 0; x < cols_; x++)
                line(0)[x] = flux(star) * weight()[x] * residual()[x];
            atlas_.spread(star, line(0), places_[star], r, samples[star], scratch_.data());
        }
    }

    // Products of all lines, the residual last, with each other.
    void add_products() {
        kernels::normal_kernels().add(columns_.data(), size_ + 1, weight(), cols_, line(0), sums_.data());
    }
    double product(size_t i, size_t j) const noexcept {
        return kernels::sum_of_lanes(&sums_[(std::min(i, j) * (size_ + 1) + std::max(i, j)) * kernels::kNormalLanes]);
    }
    // Products of all lines with the residual.
    void add_projection() {
        kernels::normal_kernels().correlate(columns_.data(), size_, weight(), residual(), cols_, line(0), sums_.data());
    }
    Buffer<double> projection() const {
        Buffer<double> sums(size_);
        for (size_t i = 0; i < size_; i++)
            sums[i] = kernels::sum_of_lanes(&sums_[i * kernels::kNormalLanes]);
        return sums;
    }

    size_t size() const noexcept { return size_; }
    double *weight() noexcept { return line(3); }
    double *residual() noexcept { return line(4); }

  private:
    double *line(size_t i) noexcept { return work_.data() + i * cols_; }
    double flux(size_t star) const noexcept { return 1 + values_[fit::flux_a + star]; }

    const MapFrames &owner_;
    const optics::Atlas &atlas_;
    const double *values_;
    size_t cols_, size_;
    Buffer<double> lines_, work_, scratch_, sums_; // lines_: the background's derivative remains 1
    optics::Atlas::Place places_[2];
    Planes::Places derivative_places_;
    std::vector<double *> line_of_;
    std::vector<const double *> columns_;
};

void add(const StarSamples &b, StarSamples &a) noexcept {
    for (size_t star = 0; star < 2; star++)
        for (size_t i = 0; i < a[star].size(); i++)
            a[star][i] += b[star][i];
}

StarSamples MapFrames::samples() const {
    return {Buffer<double>(planes_.atlas().plane(0, 0).size()), Buffer<double>(planes_.atlas().plane(1, 0).size())};
}

// Calls work(chunk, frames of the chunk).
template <class Work> void MapFrames::for_chunks(const Work &work) const {
    const size_t count = problem_.frames.count;
    run_jobs(problem_.settings.workers, std::min(count, kChunks), [&](size_t chunk) {
        for (size_t frame = chunk; frame < count; frame += kChunks)
            work(chunk, frame);
    });
}

Linearisation MapFrames::matrices() const {
    Linearisation all;
    all.blocks.resize(problem_.frames.count);
    for_chunks([&](size_t, size_t frame) {
        Rows rows(*this, frame);
        for (size_t r = 0; r < problem_.nominal.detector.rows; r++) {
            rows.compute(r);
            rows.add_products();
        }
        Block &block = all.blocks[frame];
        const size_t size = rows.size();
        block.matrix.resize(size * size);
        block.gradient.resize(size);
        for (size_t i = 0; i < size * size; i++)
            block.matrix[i] = rows.product(i / size, i % size);
    });
    return all;
}

std::vector<Buffer<double>> MapFrames::project(const StarSamples &images) const {
    std::vector<Buffer<double>> projected(problem_.frames.count);
    for_chunks([&](size_t, size_t frame) {
        Rows rows(*this, frame);
        for (size_t r = 0; r < problem_.nominal.detector.rows; r++) {
            rows.compute(r);
            rows.change(images, r);
            rows.add_projection();
        }
        projected[frame] = rows.projection();
    });
    return projected;
}

StarSamples MapFrames::gather(const StarSamples *images, const Point &change) const {
    std::vector<StarSamples> parts(std::min(problem_.frames.count, kChunks));
    std::vector<std::vector<double>> instrument(problem_.frames.count);
    problem_.for_frames([&](size_t frame, const std::vector<Part> &of_frame) {
        instrument[frame] = sum_of(change.instrument, of_frame);
    });
    for_chunks([&](size_t chunk, size_t frame) {
        if (parts[chunk][0].empty())
            parts[chunk] = samples();
        Rows rows(*this, frame);
        for (size_t r = 0; r < problem_.nominal.detector.rows; r++) {
            rows.compute(r);
            if (images != nullptr)
                rows.change(*images, r);
            else
                std::fill_n(rows.residual(), planes_.atlas().cols(), 0.0);
            rows.subtract(change.own[frame].data(), instrument[frame].data());
            rows.gather(r, parts[chunk]);
        }
    });
    for (size_t part = 1; part < parts.size(); part++)
        add(parts[part], parts[0]);
    return std::move(parts[0]);
}

void MapFrames::add_residuals(const Joint &joint, Residuals &sum) const {
    const std::vector<size_t> &frames = joint.frames();
    const size_t rows = problem_.nominal.detector.rows, cols = planes_.atlas().cols();
    std::vector<StarSamples> parts(std::min(frames.size(), kChunks));
    std::vector<double> chi_square(frames.size());
    std::vector<size_t> used(frames.size());
    sum.projected.resize(problem_.frames.count);
    run_jobs(problem_.settings.workers, parts.size(), [&](size_t chunk) {
        parts[chunk] = samples();
        Buffer<double> counts(rows * cols);
        for (size_t i = chunk; i < frames.size(); i += kChunks) {
            const size_t frame = frames[i];
            in_frame(frame, [&] {
                problem_.frames.read(frame, counts.data());
                const std::shared_ptr<const fit::Fit> fit = joint.fit_of(frame);
                fit->model().undo(counts.data());
                fit::Work work = fit->model().work();
                work.bad = point_.bad_of(frame);
                Rows of(*this, frame);
                const ImageView<const double> view = {counts.data(), rows, cols, cols};
                fit->model().visit(&view, point_.own[frame].data(), 0, work, [&](const fit::Model::Row &row) {
                    of.compute(row.row);
                    std::copy_n(row.weight, cols, of.weight());
                    std::copy_n(row.residual, cols, of.residual());
                    of.add_projection();
                    of.gather(row.row, parts[chunk]);
                    for (size_t x = 0; x < cols; x++)
                        chi_square[i] += row.weight[x] * row.residual[x] * row.residual[x];
                });
                sum.projected[frame] = of.projection();
                used[i] = work.used;
            });
        }
    });
    if (sum.gathered[0].empty())
        sum.gathered = samples();
    for (const StarSamples &part : parts)
        add(part, sum.gathered);
    for (size_t i = 0; i < frames.size(); i++) {
        sum.chi_square += chi_square[i];
        sum.used += used[i];
    }
}

} // namespace toliman::calibrate
