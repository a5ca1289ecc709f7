// Search for planets, one at a time, and their posteriors with all others.
#pragma once
#include <memory>
#include <vector>

#include "planet/description.hpp"
#include "planet/detection.hpp"
#include "planet/joint_fit.hpp"
#include "planet/outliers.hpp"
#include "planet/verdict.hpp"

namespace toliman::planet {

// What the caller asks for; 0: the default.
struct Settings {
    size_t most = 1;
    unsigned threads = 0;
    bool jitter = true, clip = false;
    bool scales_of_rms = false; // the scales of amplitudes are those of the series without the planets before
    Units units;
    double period_min = 0, period_max = 0, eccentricity_max = 0, amplitude_min = 0, amplitude_max = 0, jitter_max = 0;
    double threshold = 2, fap = 1e-3;
    size_t samples = 4096;
    uint64_t seed = 0;
    double rms = 0; // of the series, about its functions; set by the search
    Progress progress;
};

struct Candidate {
    FittedPlanet fitted; // of the joint fit
    double log10_bayes, log10_bayes_error, log10_fap, log10_fap_orbit;
    double log10_star; // log10 of the odds of star A against B, with velocities
    uint32_t reasons;  // against a planet
    bool at_edge;
    std::vector<PosteriorSample> samples;
    Description best, best_error;
    double power_left;

    // Whether its signal is in the joint fit.
    bool is_fitted() const noexcept { return (reasons & kReasonOdds) == 0; }
    bool is_planet() const noexcept { return reasons == 0; }
};

// Searches, and keeps what later questions need.
struct Result {
    Result(const GivenSeries &given, const GivenVelocities &velocities, const Settings &settings);
    Result(const Result &) = delete; // the members refer to each other
    Result &operator=(const Result &) = delete;

    Series series;
    double frame_chi_square; // median of the frames; 0: unknown
    Settings settings;       // with defaults replaced
    Prior prior;
    std::vector<Candidate> candidates;
    // The joint fit of the candidates that reach the threshold, and its residuals.
    std::unique_ptr<JointFunctions> functions;
    std::unique_ptr<Problem> rest;
    std::unique_ptr<Design> design;
    Buffer<double> residuals;      // [n]
    Goodness goodness;             // without the jitter
    double chi_square_with_jitter; // per degree of freedom
    std::vector<size_t> outliers;  // measurements that do not belong, in order

    // The last candidate of the joint fit, or the only one.
    const Candidate &last_fitted() const noexcept;
    // The search for candidates in the measurements that are not left out. Returns those that are then to be left out.
    std::vector<bool> search(const Settings &asked);
    void judge();
};

} // namespace toliman::planet
