// Method: photon noise is exact Poisson at every mean (kernels/poisson.hpp), no Gaussian approximation. Read noise is
// Gaussian; a frame of n coadds has variance n sigma_read^2 and n times the full well. Rounding to integers adds
// gain^2/12 electrons^2. Streams of random numbers are counter-based: photons and read noise are keyed by (seed,
// frame), the flat field by the scene's seed alone, so that it is the same in all frames.
#include "optics/detector.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "kernels/poisson.hpp"

namespace toliman::optics {

namespace {

constexpr double kBiasSigmas = 4; // pixels nearer to 0 DN than this many sigma of read noise may be clipped

bool counts_electrons(const Scene &scene) noexcept {
    return scene.detector.qe != 1 || !scene.detector.qe_file.empty() || scene.stars.front().detected;
}

// qe times flat field and response file, the same in all frames; empty if all are 1.
Buffer<double> response_of(const Scene &scene, size_t pixels) {
    const Detector &detector = scene.detector;
    if (detector.qe == 1 && detector.flat_rms == 0 && detector.response.empty())
        return {};
    Buffer<double> response(pixels);
    if (detector.flat_rms != 0)
        kernels::poisson_kernels().gaussian(pixels, 0, {scene.noise.seed, 0, kernels::kStreamFlat}, response.data());
    for (double &value : response)
        value = detector.qe * (1 + detector.flat_rms * value);
    for (size_t i = 0; i < detector.response.size(); i++)
        response[i] *= detector.response[i];
    return response;
}

} // namespace

DetectorStages::DetectorStages(const Scene &scene)
    : pixels_(scene.detector.rows * scene.detector.cols), readout_(scene), photon_noise_(scene.noise.photon),
      electrons_(counts_electrons(scene)), response_(response_of(scene, pixels_)),
      dark_e_(scene.detector.dark_e_per_s * scene.cadence.exposure_s),
      read_e_(scene.noise.read_e * std::sqrt(static_cast<double>(scene.detector.coadds))),
      full_well_e_(std::numeric_limits<double>::infinity()), e_per_count_(scene.detector.gain_e_per_dn),
      bias_(scene.detector.bias_dn),
      largest_count_(scene.detector.bit_depth > 0 ? std::ldexp(1.0, scene.detector.bit_depth) - 1 : 0) {
    if (scene.detector.full_well_e)
        full_well_e_ = *scene.detector.full_well_e * static_cast<double>(scene.detector.coadds);
    full_well_e_ = std::min(full_well_e_, readout_.brightest_reading()); // beyond it counts would fall
}

void DetectorStages::apply_response(double *image) const noexcept {
    for (size_t i = 0; i < response_.size(); i++)
        image[i] *= response_[i];
}

void DetectorStages::collect(double *image) const {
    apply_response(image);
    readout_.add_smear(image);
}

void DetectorStages::spread(double *weights) const {
    readout_.add_smear(weights); // symmetric
    apply_response(weights);
}

double DetectorStages::added_variance_e2() const noexcept {
    const double rounding = largest_count_ > 0 ? e_per_count_ * e_per_count_ / 12 : 0;
    return (read_e_ * read_e_ + rounding) * readout_.noise_gain();
}

double DetectorStages::saturation_e() const noexcept {
    const double most = std::min(full_well_e_, readout_.most_charge());
    return largest_count_ > 0 ? std::min(most, electrons_of(largest_count_)) : most;
}

Unit DetectorStages::unit() const noexcept {
    if (e_per_count_ != 1 || bias_ != 0 || largest_count_ > 0)
        return Unit::dn;
    return electrons_ ? Unit::electron : Unit::photon;
}

bool DetectorStages::whole_counts() const noexcept {
    const bool whole_electrons =
        photon_noise_ && read_e_ == 0 && !readout_.any() && std::floor(full_well_e_) == full_well_e_;
    return largest_count_ > 0 || (whole_electrons && e_per_count_ == 1 && std::floor(bias_) == bias_);
}

void DetectorStages::detect(uint64_t seed, uint64_t frame, double *expected, double *image) const {
    const kernels::PoissonKernels &random = kernels::poisson_kernels();
    if (photon_noise_)
        random.poisson(expected, pixels_, 0, {seed, frame, kernels::kStreamPhotons}, image);
    else
        std::copy_n(expected, pixels_, image);
    readout_.exchange(image);
    if (std::isfinite(full_well_e_))
        for (size_t i = 0; i < pixels_; i++)
            image[i] = std::min(image[i], full_well_e_);
    readout_.couple(image);
    readout_.bend(image);
    if (read_e_ != 0) {
        double *const normals = expected;
        random.gaussian(pixels_, 0, {seed, frame, kernels::kStreamReadout}, normals);
        for (size_t i = 0; i < pixels_; i++)
            image[i] += read_e_ * normals[i];
    }
    scale(Quantity::frame, image);
    if (largest_count_ > 0)
        for (size_t i = 0; i < pixels_; i++) // adding 2^52 leaves no fractional bits: rounds to nearest, ties to even
            image[i] = (std::min(std::max(0.0, image[i]), largest_count_) + 0x1p52) - 0x1p52;
}

// From electrons that are read to the frame's unit.
void DetectorStages::scale(Quantity quantity, double *image) const noexcept {
    if (e_per_count_ == 1 && bias_ == 0)
        return;
    const double unit = quantity == Quantity::variance ? e_per_count_ * e_per_count_ : e_per_count_;
    const double offset = quantity == Quantity::frame ? bias_ : 0;
    for (size_t i = 0; i < pixels_; i++)
        image[i] = image[i] / unit + offset;
}

void DetectorStages::to_counts(double *charge) const {
    readout_.read(charge);
    scale(Quantity::frame, charge);
}

void DetectorStages::to_counts(Quantity quantity, const Buffer<double> &charge, double *image) const {
    if (quantity == Quantity::frame)
        return to_counts(image);
    if (readout_.any())
        quantity == Quantity::derivative ? readout_.differentiate(charge.data(), image)
                                         : readout_.read_variance(charge.data(), image);
    scale(quantity, image);
}

Buffer<double> DetectorStages::in_counts(Buffer<double> charge) const {
    to_counts(charge.data());
    return charge;
}

Buffer<double> DetectorStages::in_counts(Quantity quantity, const Buffer<double> &charge, Buffer<double> image) const {
    to_counts(quantity, charge, image.data());
    return image;
}

void DetectorStages::weights_to_charge(const Buffer<double> &charge, double *weights) const {
    scale(Quantity::derivative, weights);
    if (readout_.any())
        readout_.adjoint(charge.data(), weights);
}

void DetectorStages::warn(const Buffer<double> &electrons, const char *about, const std::string &source,
                          const Log &log) const {
    size_t saturated = 0, overflowing = 0, clipped = 0;
    const double least = kBiasSigmas * read_e_;
    for (const double value : electrons) {
        saturated += value > full_well_e_;
        overflowing += counts_of(std::min(value, full_well_e_)) > largest_count_ + 0.5;
        clipped += value + bias_ * e_per_count_ < least;
    }
    const double largest = *std::max_element(electrons.begin(), electrons.end());
    if (saturated > 0)
        log.warn("%s: detector.full_well_e: %s%zu pixels are saturated: the brightest pixel expects %g e-, the full "
                 "well of all coadds is %g e-",
                 source.c_str(), about, saturated, largest, full_well_e_);
    if (largest_count_ > 0 && overflowing > 0)
        log.warn("%s: detector.bit_depth: %s%zu pixels overflow: the brightest pixel expects %g DN, the largest count "
                 "is %.0f DN",
                 source.c_str(), about, overflowing, counts_of(std::min(largest, full_well_e_)), largest_count_);
    if (largest_count_ > 0 && clipped > 0)
        log.warn(
            "%s: detector.bias_dn: read noise may take %s%zu pixels below 0 DN, where counts are clipped: increase "
            "the bias",
            source.c_str(), about, clipped);
}

} // namespace toliman::optics
