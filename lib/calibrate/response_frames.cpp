// Method: each pass reads a frame once, keeps W a, W a J and, in the first pass, G of its pixels, the derivatives by
// the parameters of the instrument, and uses these lines twice: for the products with them, and after the elimination.
// The rows are computed again in each pass, as in map_frames.cpp, so that memory does not depend on the number of
// frames, except for F_k^-1. Frames are distributed over a fixed number of chunks, whose sums are added in order: the
// bits do not depend on the workers. Memory: 8 (3 + n) values per pixel for n parameters of the instrument in the first
// pass, and 11 + n for each worker.
#include "calibrate/response_frames.hpp"

#include <algorithm>
#include <cmath>

#include "base/symmetric.hpp"
#include "base/workers.hpp"
#include "calibrate/vectors.hpp"
#include "kernels/normal.hpp"

namespace toliman::calibrate {

namespace {

// a += b; a may be empty.
void add(const Buffer<double> &b, Buffer<double> &a) {
    a.resize(b.size());
    for (size_t i = 0; i < b.size(); i++)
        a[i] += b[i];
}

// h: of the separation by a frame's own parameters.
std::array<double, kOwn> separation_gradient(const std::array<double, kOwn> &own) {
    const double x = own[fit::x_b] - own[fit::x_a], y = own[fit::y_b] - own[fit::y_a], r = std::hypot(x, y);
    std::array<double, kOwn> gradient = {};
    gradient[fit::x_b] = x / r;
    gradient[fit::y_b] = y / r;
    gradient[fit::x_a] = -x / r;
    gradient[fit::y_a] = -y / r;
    return gradient;
}

} // namespace

// The pixels of a frame; of one thread.
class ResponseFrames::Rows {
  public:
    // count: of the derivatives, those by the frame's own parameters first.
    Rows(const ResponseFrames &owner, size_t count)
        : owner_(owner), rows_(owner.problem_.nominal.detector.rows), cols_(owner.problem_.nominal.detector.cols),
          count_(count), products_(cols_), sums_((count + 1) * (count + 1) * kernels::kNormalLanes) {
        for (Buffer<double> *const image : {&counts_, &weighted, &curvature, &residual})
            image->resize(rows_ * cols_);
        lines.resize(count * rows_ * cols_);
    }

    Buffer<double> weighted, curvature, residual; // W a, W a^2, r
    Buffer<double> lines;                         // J G, [count][pixels]

    // planes: of G; NULL with count = kOwn. block: NULL, or gets the matrix of the derivatives.
    void read(size_t frame, const Planes *planes, Block *block) {
        const Problem &problem = owner_.problem_;
        const std::shared_ptr<const fit::Fit> fit = owner_.joint_.fit_of(frame);
        const double *const values = owner_.point_.own[frame].data();
        const double exposures = problem.frames.predictions[frame].spread.frames;
        const Buffer<double> &response = owner_.point_.response;
        const size_t pixels = rows_ * cols_;
        problem.frames.read(frame, counts_.data());
        Buffer<double> scratch(planes != nullptr ? planes->scratch_size() : 0);
        Planes::Places places;
        if (planes != nullptr)
            planes->place(values, places, scratch.data());
        std::fill(sums_.begin(), sums_.end(), 0.0);
        std::vector<double *> at(count_);
        std::vector<const double *> columns(count_ + 1);
        fit->model().undo(counts_.data());
        fit::Work work = fit->model().work();
        work.bad = owner_.point_.bad_of(frame);
        const ImageView<const double> view = {counts_.data(), rows_, cols_, cols_};
        fit->model().visit(&view, values, 0, work, [&](const fit::Model::Row &row) {
            const size_t first = row.row * cols_;
            for (size_t i = 0; i < count_; i++)
                columns[i] = at[i] = &lines[i * pixels + first];
            if (planes != nullptr)
                planes->row(values, places, row.row, at.data() + kOwn, scratch.data());
            for (size_t i = 0; i < count_; i++) {
                const double scale = i < kOwn ? fit::Model::scale_of(i, values) : exposures;
                const double *const from = i < kOwn ? row.derivatives[i] : at[i];
                for (size_t x = 0; x < cols_; x++)
                    at[i][x] = scale * from[x];
            }
            for (size_t x = 0; x < cols_; x++) {
                const size_t pixel = first + x;
                const double a = row.light[x] / (response.empty() ? 1 : 1 + response[pixel]);
                weighted[pixel] = row.weight[x] * a;
                curvature[pixel] = weighted[pixel] * a;
                residual[pixel] = row.residual[x];
            }
            if (block == nullptr)
                return;
            columns[count_] = row.residual;
            kernels::normal_kernels().add(columns.data(), count_ + 1, row.weight, cols_, products_.data(),
                                          sums_.data());
        });
        if (block != nullptr)
            fill(work, *block);
    }

  private:
    void fill(const fit::Work &work, Block &block) const {
        const auto sum = [&](size_t i, size_t j) {
            return kernels::sum_of_lanes(&sums_[(i * (count_ + 1) + j) * kernels::kNormalLanes]);
        };
        block = {Buffer<double>(count_ * count_), Buffer<double>(count_)};
        for (size_t i = 0; i < count_; i++) {
            for (size_t j = i; j < count_; j++)
                block.matrix[i * count_ + j] = block.matrix[j * count_ + i] = sum(i, j);
            block.gradient[i] = sum(i, count_);
        }
        block.chi_square = sum(count_, count_);
        block.inverse_counts = sum(fit::background, fit::background);
        block.used = work.used;
        block.saturated = work.saturated;
    }

    const ResponseFrames &owner_;
    const size_t rows_, cols_, count_;
    Buffer<double> counts_, products_, sums_;
};

// Calls work(chunk, frames of the chunk) with each chunk on one thread.
template <class Work> void ResponseFrames::for_chunks(const Work &work) const {
    const size_t count = problem_.frames.count;
    run_jobs(problem_.settings.workers, std::min(count, kChunks), [&](size_t chunk) {
        std::vector<size_t> frames;
        for (size_t frame = chunk; frame < count; frame += kChunks)
            frames.push_back(frame);
        work(chunk, frames);
    });
}

// Adds a frame after the elimination of its own parameters. gain: F^-1 J'W (G r), [kOwn][n + 1].
void ResponseFrames::accumulate(const Rows &rows, const std::array<double, kOwn * kOwn> &inverse,
                                const Buffer<double> &gain, Equations &sum) {
    const size_t n = sum.instrument.size(), pixels = rows.weighted.size();
    const double *const lines = rows.lines.data();
    for (size_t i = 0; i < pixels; i++) {
        sum.diagonal[i] += rows.curvature[i];
        sum.gradient[i] += rows.weighted[i] * rows.residual[i];
    }
    for (size_t k = 0; k < kOwn; k++)
        for (size_t i = 0; i < pixels; i++) {
            const double coupled = rows.weighted[i] * lines[k * pixels + i];
            double row = 0; // of F^-1 A'
            for (size_t l = 0; l < kOwn; l++)
                row += inverse[k * kOwn + l] * lines[l * pixels + i];
            sum.gradient[i] -= gain[k * (n + 1) + n] * coupled;
            sum.eliminated[i] += coupled * rows.weighted[i] * row;
        }
    for (size_t j = 0; j < n; j++)
        for (size_t i = 0; i < pixels; i++) {
            double value = lines[(kOwn + j) * pixels + i];
            for (size_t k = 0; k < kOwn; k++)
                value -= gain[k * (n + 1) + j] * lines[k * pixels + i];
            sum.instrument[j][i] += rows.weighted[i] * value;
        }
}

void ResponseFrames::accumulate_separation(const Rows &rows, const std::array<double, kOwn> &gradient,
                                           const std::array<double, kOwn * kOwn> &inverse, const Buffer<double> &gain,
                                           Equations &sum) {
    const size_t n = sum.instrument.size(), pixels = rows.weighted.size();
    for (size_t k = 0; k < kOwn; k++) {
        double factor = 0; // of F^-1 h
        for (size_t l = 0; l < kOwn; l++)
            factor += inverse[k * kOwn + l] * gradient[l];
        for (size_t i = 0; i < pixels; i++)
            sum.separation[i] += factor * rows.weighted[i] * rows.lines[k * pixels + i];
        for (size_t j = 0; j < n; j++)
            sum.separation_gain[j] += gradient[k] * gain[k * (n + 1) + j];
    }
}

ResponseFrames::Equations ResponseFrames::linearise(const Planes &planes) {
    const size_t frames = problem_.frames.count, n = planes.parameters(), count = kOwn + n,
                 pixels = problem_.nominal.detector.rows * problem_.nominal.detector.cols;
    Equations all;
    all.normal.blocks.resize(frames);
    all.instrument.resize(n);
    all.separation.resize(pixels);
    all.separation_gain.resize(n);
    inverse_.resize(frames);
    std::vector<Equations> parts(std::min(frames, kChunks));
    for_chunks([&](size_t chunk, const std::vector<size_t> &of_chunk) {
        Equations &part = parts[chunk];
        for (Buffer<double> *const image : {&part.diagonal, &part.gradient, &part.eliminated, &part.separation})
            image->resize(pixels);
        part.separation_gain.resize(n);
        for (size_t i = 0; i < n; i++)
            part.instrument.emplace_back(pixels);
        Rows rows(*this, count);
        Buffer<double> gain(kOwn * (n + 1));
        for (const size_t frame : of_chunk) {
            Block &block = all.normal.blocks[frame];
            in_frame(frame, [&] { rows.read(frame, &planes, &block); });
            std::array<double, kOwn *kOwn> &inverse = inverse_[frame];
            for (size_t i = 0; i < kOwn * kOwn; i++)
                inverse[i] = block.matrix[i / kOwn * count + i % kOwn];
            part.solvable = part.solvable && invert_symmetric(inverse.data(), kOwn);
            for (size_t i = 0; i < kOwn; i++)
                for (size_t j = 0; j <= n; j++) {
                    double &sum = gain[i * (n + 1) + j] = 0;
                    for (size_t k = 0; k < kOwn; k++)
                        sum += inverse[i * kOwn + k] * (j < n ? block.matrix[k * count + kOwn + j] : block.gradient[k]);
                }
            accumulate(rows, inverse, gain, part);
            accumulate_separation(rows, separation_gradient(point_.own[frame]), inverse, gain, part);
        }
    });
    for (Equations &part : parts) {
        add(part.diagonal, all.diagonal);
        add(part.gradient, all.gradient);
        add(part.eliminated, all.eliminated);
        add_scaled(1 / static_cast<double>(frames), part.separation, all.separation);
        for (size_t i = 0; i < n; i++) {
            add(part.instrument[i], all.instrument[i]);
            all.separation_gain[i] += part.separation_gain[i] / static_cast<double>(frames);
        }
        all.solvable = all.solvable && part.solvable;
        part = {};
    }
    for (const Block &block : all.normal.blocks) {
        all.normal.chi_square += block.chi_square;
        all.normal.inverse_counts += block.inverse_counts;
        all.normal.used += block.used;
    }
    return all;
}

Buffer<double> ResponseFrames::product(const Buffer<double> &v, Projections &projections) const {
    const size_t pixels = v.size();
    projections.resize(problem_.frames.count);
    std::vector<Buffer<double>> parts(std::min(problem_.frames.count, kChunks));
    for_chunks([&](size_t chunk, const std::vector<size_t> &of_chunk) {
        Buffer<double> &part = parts[chunk];
        part.resize(pixels);
        Rows rows(*this, kOwn);
        for (const size_t frame : of_chunk) {
            in_frame(frame, [&] { rows.read(frame, nullptr, nullptr); });
            for (size_t k = 0; k < kOwn; k++) {
                double *const line = &rows.lines[k * pixels];
                double sum = 0;
                for (size_t i = 0; i < pixels; i++) {
                    line[i] *= rows.weighted[i];
                    sum += line[i] * v[i];
                }
                projections[frame][k] = sum;
            }
            for (size_t k = 0; k < kOwn; k++) {
                double factor = 0;
                for (size_t l = 0; l < kOwn; l++)
                    factor += inverse_[frame][k * kOwn + l] * projections[frame][l];
                const double *const line = &rows.lines[k * pixels];
                for (size_t i = 0; i < pixels; i++)
                    part[i] += factor * line[i];
            }
        }
    });
    Buffer<double> sum;
    for (const Buffer<double> &part : parts)
        add(part, sum);
    return sum;
}

} // namespace toliman::calibrate
