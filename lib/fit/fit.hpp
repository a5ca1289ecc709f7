// Maximum-likelihood fit of the forward model to one frame: places and fluxes of both stars, background, and further
// parameters on request.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "base/buffer.hpp"
#include "base/pixel.hpp"
#include "base/view.hpp"
#include "fit/workspaces.hpp"
#include "optics/atlas.hpp"
#include "optics/simulator.hpp"

namespace toliman::fit {

constexpr size_t kFewestParameters = 7, kMostParameters = 32;

struct Settings {
    unsigned workers = 0; // 0 = one per processor
    std::vector<Parameter> free;
    double capture_px = 15;
    Progress progress;
    Log log;
};

// As toliman_fit_prediction.
struct Prediction {
    double days = 0, shift_px[2] = {0, 0};
    double separation_px = 0, position_angle_deg = 0; // 0 = those of the scene
};

enum Flag : uint32_t { not_converged = 1, outlier = 2, saturated = 4, edge = 8, searched = 16 };

// Values and covariance of the parameters, in the order of Fit::parameters().
struct Result {
    uint32_t flags = 0;
    double values[kMostParameters], covariance[kMostParameters * kMostParameters]; // [n], [n][n]
    double displacement_px = 0, chi_square = 0;
    int iterations = 0, excluded = 0;
};

// Const calls may run on several threads.
class Fit {
  public:
    // The simulator is not needed afterwards.
    Fit(const optics::Simulator &simulator, const Settings &settings);

    // Fits a frame of rows() x cols() counts. The result depends on the arguments only.
    void frame(ImageView<const double> counts, const Prediction &prediction, Work &work, Result &result) const;
    // The frame that is expected, unless image.data is NULL, and the result of its fit: values and covariance.
    void predict(const Prediction &prediction, ImageView<double> image, Work &work, Result &result) const;

    const std::vector<Parameter> &parameters() const noexcept { return parameters_; }
    size_t rows() const noexcept { return rows_; }
    size_t cols() const noexcept { return cols_; }
    // Standard deviation of the separation (px) in the scene's frame at time 0.
    double sigma_px() const noexcept { return sigma_px_; }
    // FNV-1a of everything that determines the results.
    uint64_t digest() const noexcept { return digest_; }
    double capture_px() const noexcept { return capture_px_; }
    const optics::Atlas &atlas() const noexcept { return *atlas_; }
};

} // namespace toliman::fit
