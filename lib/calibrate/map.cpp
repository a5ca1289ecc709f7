// Method: Gauss-Newton with conjugate gradients. With the unknown z of the map p = C^(1/2) z (map_prior.cpp), J the
// derivatives of all frames by the cells, D by all other parameters d, weights W and residuals r, the step solves
//     ( 1 + C^(1/2) J'WJ C^(1/2)   C^(1/2) J'WD ) ( dz )   ( C^(1/2) J'W r - z )
//     ( D'WJ C^(1/2)               D'WD + P     ) ( dd ) = ( D'W r - P d       ).
// The thousands of derivatives J are never formed: products with J and J' cost two transforms per wavelength each
// (map_images.cpp). The parameters d are few and correlate strongly with the map: they are eliminated exactly. What
// remains for dz is positive definite,
//     A = 1 + C^(1/2) J'(W - W D (D'WD + P)^-1 D'W) J C^(1/2).
// Preconditioner: J'WJ is roughly a multiple h of the identity, larger for the part of the map that is odd about the
// centre: with a mask of odd m, an even OPD has an effect only where struts or aberrations break the symmetry. Both h
// are measured with a map of random signs, and (1 + h C)^-1 is a filter. One h for each band of frequencies, measured
// likewise, needs more iterations.
// Far from the maximum, the squares of odd OPDs change frames by more than the noise, which a step would explain by
// even OPDs, whose effect is as small. As in solve.cpp, all variances are therefore multiplied by the chi-square per
// pixel e, if that is above 1. In A, e takes the place of 1, and e P that of P. For the same reason the conjugate
// gradients end early: the next step begins nearer.
// Measured:
//   64 cells, 64 x 64 px, four frames of 1e12 photons without noise, a map of 1 nm rms with 4 to 20 cycles per
//   aperture: separations wrong by 3e-4 px rms with Zernike polynomials only, then by 1e-5, 7e-6 and 1e-6 px after
//   steps of at most 60 iterations
//   256 cells, 256 x 256 px, ten frames: 4e-4 px, then 2e-5 and 1.4e-6 px; 0.7 s for a product with A on two cores
//
// Reference: Nocedal and Wright 2006, Numerical Optimization, chapter 7.1; Jurling and Fienup 2014, J. Opt. Soc. Am. A
// 31, 1348.
#include "calibrate/map.hpp"

#include <algorithm>
#include <cmath>
#include <memory>

#include "base/hash.hpp"
#include "calibrate/map_frames.hpp"
#include "calibrate/map_prior.hpp"
#include "calibrate/memo.hpp"
#include "calibrate/solve.hpp"
#include "calibrate/vectors.hpp"
#include "kernels/poisson.hpp"
#include "kernels/random.hpp"

namespace toliman::calibrate {

namespace {

constexpr double kLeastCurvature = 1e-3; // of the other parity's

bool is_in_map(const Free &free) noexcept {
    return free.parameter.kind == Parameter::Kind::focus || free.parameter.kind == Parameter::Kind::zernike;
}

// The problem and the point without the parameters that the map contains.
Problem without_aberrations(Problem problem) {
    problem.free.erase(std::remove_if(problem.free.begin(), problem.free.end(), is_in_map), problem.free.end());
    return problem;
}

Point without_aberrations(const Problem &problem, const Point &point) {
    Point part = point;
    for (size_t window = 0; window < point.instrument.size(); window++) {
        part.instrument[window].clear();
        for (size_t i = 0; i < problem.free.size(); i++)
            if (!is_in_map(problem.free[i]))
                part.instrument[window].push_back(point.instrument[window][i]);
    }
    return part;
}

Point with_aberrations(const Problem &problem, const Point &part) {
    Point point = part;
    for (size_t window = 0; window < part.instrument.size(); window++) {
        point.instrument[window].clear();
        size_t next = 0;
        for (const Free &free : problem.free)
            point.instrument[window].push_back(is_in_map(free) ? 0 : part.instrument[window][next++]);
    }
    return point;
}

class MapFit {
  public:
    MapFit(const Problem &problem, const Point &point, const MapOptions &options);
    MapStep step();
    double parameters();

  private:
    bool prepare(MapFrames::Residuals &sum);
    Buffer<double> hessian(const Buffer<double> &opd_m);
    Buffer<double> product(const Buffer<double> &unknown);
    void measure_curvature();
    Buffer<double> solve(const Buffer<double> &right, MapStep &step);
    Buffer<double> signs(uint64_t seed) const;
    void finish(const MapFrames::Residuals &given, const Buffer<double> &unknown, MapStep &step);

    const Problem &problem_;
    const Point &point_;
    const MapOptions &options_;
    const Problem part_;
    const Point part_point_;
    const optics::Outline outline_; // of the mean of the windows
    const Planes planes_;
    const MapImages images_;
    const Joint first_; // window, which weighs the pixels of all frames
    const MapFrames frames_;
    Linearisation matrices_;
    std::unique_ptr<Solver> solver_;
    MapPrior prior_;
    double curvature_[2] = {0, 0}; // h, per m^2: even, odd
    double excess_ = 1;            // factor of all variances
};

MapFit::MapFit(const Problem &problem, const Point &point, const MapOptions &options)
    : problem_(problem), point_(point), options_(options), part_(without_aberrations(problem)),
      part_point_(without_aberrations(problem, point)),
      outline_(outline_at(problem, mean_of(point.instrument), point.map_m)),
      planes_(outline_, part_.parameters(), problem.capture_px), images_(outline_, planes_), first_(problem, point, 0),
      frames_(part_, part_point_, first_.first().model(), planes_), prior_(outline_.pupil.samples, options.rms_m) {}

// Residuals about the point, window by window, and the normal equations without the map. False if a star is outside
// the model images.
bool MapFit::prepare(MapFrames::Residuals &sum) {
    std::unique_ptr<Joint> later;
    for (size_t window = 0; window < problem_.windows.size(); window++) {
        if (window > 0)
            later = std::make_unique<Joint>(problem_, point_, window, later ? later.get() : &first_);
        const Joint &joint = later ? *later : first_;
        for (const size_t frame : joint.frames())
            if (!planes_.covers(point_.own[frame].data()) ||
                !joint.fit_of(frame)->model().covers(point_.own[frame].data()))
                return false;
        frames_.add_residuals(joint, sum);
    }
    matrices_ = frames_.matrices();
    matrices_.excess = excess_ = std::max(1.0, sum.chi_square / static_cast<double>(sum.used));
    solver_ = std::make_unique<Solver>(part_, matrices_);
    return true;
}

// J'(W - W D (D'WD + P)^-1 D'W) J times an OPD.
Buffer<double> MapFit::hessian(const Buffer<double> &opd_m) {
    const StarSamples change = images_.images_of(opd_m);
    return images_.gradient_of(frames_.gather(&change, solver_->solve(frames_.project(change), nullptr)));
}

// A times an unknown.
Buffer<double> MapFit::product(const Buffer<double> &unknown) {
    Buffer<double> result = prior_.opd_of(hessian(prior_.opd_of(unknown)));
    add_scaled(excess_, unknown, result);
    return result;
}

// +-1 at random in each cell.
Buffer<double> MapFit::signs(uint64_t seed) const {
    Buffer<double> signs(outline_.pupil.amplitude.size());
    kernels::Rng random(seed, kernels::kStreamProbe);
    for (double &sign : signs)
        sign = random.uniform() < 0.5 ? -1 : 1;
    return signs;
}

void MapFit::measure_curvature() {
    Buffer<double> open = signs(0);
    for (size_t i = 0; i < open.size(); i++)
        if (!(outline_.pupil.amplitude[i] > 0))
            open[i] = 0;
    const Parities in = parities_of(open), out = parities_of(hessian(open));
    curvature_[0] = dot(in.even, out.even) / dot(in.even, in.even);
    curvature_[1] = dot(in.odd, out.odd) / dot(in.odd, in.odd);
    const double least = kLeastCurvature * std::max(curvature_[0], curvature_[1]);
    for (double &curvature : curvature_)
        curvature = std::max(curvature, least);
}

// Preconditioned conjugate gradients for A x = right.
Buffer<double> MapFit::solve(const Buffer<double> &right, MapStep &step) {
    Buffer<double> x(right.size()), rest = right, direction = prior_.preconditioned(rest, curvature_, excess_);
    double size = dot(rest, direction);
    const double first = size;
    const double goal = options_.tolerance * options_.tolerance * first;
    while (size > goal && step.iterations < options_.most_iterations) {
        step.iterations++;
        const Buffer<double> image = recalled<Buffer<double>>(
            problem_.memo, {hash_of(point_), fnv1a(direction, kFnvOffset)}, [&] { return product(direction); });
        const double length = size / dot(direction, image);
        add_scaled(length, direction, x);
        add_scaled(-length, image, rest);
        Buffer<double> next = prior_.preconditioned(rest, curvature_, excess_);
        const double next_size = dot(rest, next);
        add_scaled(next_size / size, direction, next);
        direction = std::move(next);
        size = next_size;
        problem_.settings.progress.report("map", std::min(1.0, std::log(size / first) / std::log(goal / first)));
    }
    step.residual = first > 0 ? std::sqrt(size / first) : 0;
    return x;
}

// The other parameters for a change of the map, and what the caller is told.
void MapFit::finish(const MapFrames::Residuals &given, const Buffer<double> &unknown, MapStep &step) {
    const Buffer<double> opd_m = prior_.opd_of(unknown);
    const std::vector<Buffer<double>> by_map = frames_.project(images_.images_of(opd_m));
    Linearisation normal = matrices_;
    for (size_t frame = 0; frame < by_map.size(); frame++)
        for (size_t i = 0; i < by_map[frame].size(); i++)
            normal.blocks[frame].gradient[i] = given.projected[frame][i] - by_map[frame][i];
    const Step others = step_from(part_, part_point_, normal, 0); // jitter remains possible
    step.solvable = others.solvable;
    if (!others.solvable)
        return;
    step.change = with_aberrations(problem_, others.change);
    step.change.map_m = opd_m;
    step.rms_m = rms_of(opd_m, outline_.pupil.amplitude);
}

// The trace of A^-1 (A - e), which gives what a step fits of the noise in the unknowns, from one vector of random signs
// s: it is the expectation of s'A^-1 (A - e) s (Hutchinson 1990), with a standard deviation of about the square root of
// twice the result. A^-1 stands for the conjugate gradients, which end as early as those of a step: directions that
// they do not reach fit no noise. Further steps reach more. Measured with 2, 4 and 10 frames of 40 x 40 px, priors of 1
// and 10 nm, three telescopes each: a map of 2 to 5 steps lowers the sum of squares by 1.4 to 1.8 times the result (310
// to 340). With A^-1 itself it would be 650 to 1010, more than the map fits.
double MapFit::parameters() {
    MapStep step;
    MapFrames::Residuals given;
    if (!prepare(given) || !solver_->solvable())
        return 0;
    measure_curvature();
    const Buffer<double> probe = signs(1);
    Buffer<double> right = product(probe);
    add_scaled(-excess_, probe, right);
    return std::max(0.0, dot(probe, solve(right, step)));
}

MapStep MapFit::step() {
    MapStep step;
    MapFrames::Residuals given;
    step.lost = !prepare(given);
    if (step.lost || !solver_->solvable())
        return step;
    step.chi_square = given.chi_square;
    step.used = given.used;
    StarSamples gathered = frames_.gather(nullptr, solver_->solve(given.projected, &part_point_));
    add(given.gathered, gathered);
    Buffer<double> right = prior_.opd_of(images_.gradient_of(gathered));
    if (!point_.map_m.empty())
        add_scaled(-excess_, prior_.unknown_of(point_.map_m), right);
    measure_curvature();
    finish(given, solve(right, step), step);
    return step;
}

} // namespace

double map_parameters(const Problem &problem, const Point &point, double rms_m) {
    MapOptions options;
    options.rms_m = rms_m;
    return MapFit(problem, point, options).parameters();
}

MapStep map_step(const Problem &problem, const Point &point, const MapOptions &options) {
    return MapFit(problem, point, options).step();
}

} // namespace toliman::calibrate
