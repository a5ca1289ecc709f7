#include "frames/encoder.hpp"

#include <cmath>
#include <cstdint>

#include "common/failure.hpp"
#include "common/text.hpp"
#include "frames/fit_encoder.hpp"

namespace cli {

namespace {

constexpr double kFarSigmas = 1000;

// A network or a template: one value per frame.
class ValueEncoder final : public Encoder {
  public:
    ValueEncoder(const Estimator &estimator, size_t most)
        : values_(most), fits_(most, toliman::sized<toliman_frame_goodness>()) {
        if (estimator.network) {
            cae_ = estimator.network->cae.get();
            const toliman_cae_info &info = estimator.network->info;
            sigma_ = info.cosine > 0 ? info.crb_px : 0; // unsupervised training leaves the latent without a unit
        } else {
            linear_ = estimator.linear.get();
            toliman::check(toliman_linear_get_sigma(linear_, &sigma_));
        }
        columns_ = std::string(linear_ != nullptr ? "displacement_px"
                               : sigma_ > 0       ? "latent_px"
                                                  : "latent") +
                   "," + kGoodnessColumns;
    }

    const char *columns() const override { return columns_.c_str(); }
    void open(FrameFile &frames) override { refuse_sums(frames, linear_ != nullptr ? "a template" : "a network"); }

    toliman_status encode(const toliman_image &image, size_t, size_t count) override {
        return linear_ != nullptr ? toliman_linear_encode(linear_, &image, count, values_.data(), fits_.data())
                                  : toliman_cae_encode(cae_, &image, count, values_.data(), fits_.data());
    }

    std::string line(size_t i) const override { return formatted("%.17g,", values_[i]) + goodness_cells(fits_[i]); }

    // A latent without unit is not judged, only the fit.
    std::vector<Doubt> doubts(size_t i) const override {
        std::vector<Doubt> doubts;
        if (sigma_ > 0 && std::fabs(values_[i]) > kFarSigmas * sigma_)
            doubts.push_back({"differ from the scene",
                              formatted("a %s of %.3g px is far beyond the noise of %.3g px: is this frame of the %s's "
                                        "scene, pointing and exposure?",
                                        linear_ != nullptr ? "displacement" : "latent", values_[i], sigma_,
                                        linear_ != nullptr ? "template" : "network")});
        doubt_goodness(fits_[i], doubts);
        return doubts;
    }

  private:
    const toliman_cae *cae_ = nullptr;
    const toliman_linear *linear_ = nullptr;
    double sigma_ = 0; // of a value; 0: unknown
    std::vector<double> values_;
    std::vector<toliman_frame_goodness> fits_;
    std::string columns_;
};

} // namespace

std::string goodness_cells(const toliman_frame_goodness &fit) {
    return formatted("%.6g,%.6g,%.4g,%s,%u", fit.chi_square, fit.chi_square_sigma, fit.largest_residual,
                     toliman_constant_name(fit.goodness), fit.bad_pixels);
}

void refuse_sums(FrameFile &frames, const char *estimator) {
    if (!frames.spreads().empty())
        malformed(frames.path(), std::string("sums of frames, which ") + estimator + " does not take: use --fit");
}

void doubt_goodness(const toliman_frame_goodness &fit, std::vector<Doubt> &doubts) {
    const bool poor = fit.goodness == TOLIMAN_GOODNESS_POOR;
    if (!poor && fit.goodness != TOLIMAN_GOODNESS_TOO_GOOD)
        return;
    doubts.push_back(
        {poor ? "have a poor fit" : "have a fit that is too good",
         formatted("the fit is %s: a chi-square of %.3g differs from 1 +- %.3g, that of the scene's noise: %s",
                   toliman_constant_name(fit.goodness), fit.chi_square, fit.chi_square_sigma,
                   poor ? "the frame is damaged, or the scene lacks an effect"
                        : "are the counts in the unit of the scene?")});
}

std::unique_ptr<Encoder> make_encoder(const Estimator &estimator, size_t most, const FrameClock &clock,
                                      Progress &progress) {
    if (estimator.fit)
        return make_fit_encoder(estimator, most, clock, progress);
    return std::make_unique<ValueEncoder>(estimator, most);
}

} // namespace cli
