#include "frames/encoder.hpp"

#include <cmath>
#include <cstdint>

#include "common/text.hpp"
#include "frames/fit_encoder.hpp"

namespace cli {

namespace {

constexpr double kFarSigmas = 1000, kFarChiSquareSigmas = 5;

// A network or a template: one value per frame.
class ValueEncoder final : public Encoder {
  public:
    ValueEncoder(const Estimator &estimator, size_t most) : values_(most), squares_(most) {
        if (estimator.network) {
            cae_ = estimator.network->cae.get();
            const toliman_cae_info &info = estimator.network->info;
            sigma_ = info.cosine > 0 ? info.crb_px : 0; // unsupervised training leaves the latent without a unit
        } else {
            linear_ = estimator.linear.get();
            toliman::check(toliman_linear_get_sigma(linear_, &sigma_));
        }
        chi_square_sigma_ = std::sqrt(2 / static_cast<double>(estimator.rows * estimator.cols));
    }

    const char *columns() const override {
        if (linear_ != nullptr)
            return "displacement_px,chi_square";
        return sigma_ > 0 ? "latent_px,chi_square" : "latent,chi_square";
    }

    toliman_status encode(const toliman_image &image, size_t, size_t count) override {
        return linear_ != nullptr
                   ? toliman_linear_encode_many(linear_, &image, count, 0, values_.data(), squares_.data())
                   : toliman_cae_encode_many(cae_, &image, count, 0, values_.data(), squares_.data());
    }

    std::string line(size_t i) const override { return formatted("%.17g,%.6g", values_[i], squares_[i]); }

    // A latent without unit is not judged, only the chi-square.
    std::vector<Doubt> doubts(size_t i) const override {
        const char *const value = linear_ != nullptr ? "displacement" : "latent";
        std::string text;
        if (sigma_ > 0 && std::fabs(values_[i]) > kFarSigmas * sigma_)
            text = formatted("a %s of %.3g px is far beyond the noise of %.3g px", value, values_[i], sigma_);
        else if (!(std::fabs(squares_[i] - 1) <= kFarChiSquareSigmas * chi_square_sigma_))
            text = formatted("a chi-square of %.3g differs from 1 +- %.3g, that of the scene's noise", squares_[i],
                             chi_square_sigma_);
        if (text.empty())
            return {};
        text += std::string(": is this frame of the ") + (linear_ != nullptr ? "template" : "network") +
                "'s scene, pointing and exposure?";
        return {{"differ from the scene", text}};
    }

  private:
    const toliman_cae *cae_ = nullptr;
    const toliman_linear *linear_ = nullptr;
    double sigma_ = 0; // of a value; 0: unknown
    double chi_square_sigma_;
    std::vector<double> values_, squares_;
};

} // namespace

std::unique_ptr<Encoder> make_encoder(const Estimator &estimator, size_t most, const FrameClock &clock,
                                      Progress &progress) {
    if (estimator.fit)
        return make_fit_encoder(estimator, most, clock, progress);
    return std::make_unique<ValueEncoder>(estimator, most);
}

} // namespace cli
