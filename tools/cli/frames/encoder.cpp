#include "frames/encoder.hpp"

#include <cmath>
#include <cstdint>
#include <utility>

#include "common/text.hpp"

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

constexpr std::pair<uint32_t, const char *> kFlags[] = {{TOLIMAN_FIT_NOT_CONVERGED, "not_converged"},
                                                        {TOLIMAN_FIT_OUTLIER, "outlier"},
                                                        {TOLIMAN_FIT_SATURATED, "saturated"},
                                                        {TOLIMAN_FIT_EDGE, "edge"},
                                                        {TOLIMAN_FIT_SEARCHED, "searched"}};

std::string flag_words(uint32_t flags) {
    std::vector<std::string> words;
    for (const auto &[flag, word] : kFlags)
        if ((flags & flag) != 0)
            words.push_back(word);
    return joined(words, "+");
}

// The fit of a scene: each frame is predicted at its time.
class FitEncoder final : public Encoder {
  public:
    FitEncoder(const Estimator &estimator, size_t most, const std::optional<double> &cadence)
        : fit_(estimator.fit.get()), scene_times_(estimator.times), cadence_(cadence),
          predictions_(most, toliman::sized<toliman_fit_prediction>()),
          results_(most, toliman::sized<toliman_fit_result>()) {}

    const char *columns() const override {
        return "displacement_px,chi_square,separation_px,separation_sigma_px,position_angle_deg,x_px,y_px,flux_a,"
               "flux_b,background,iterations,flags";
    }

    void open(FrameFile &frames) override {
        path_ = frames.path();
        file_times_ = frames.days();
        if (frames.counted())
            check_times(frames.count());
    }

    toliman_status encode(const toliman_image &image, size_t first, size_t count) override {
        check_times(first + count);
        for (size_t i = 0; i < count; i++)
            predictions_[i].time_days = days_of(first + i);
        return toliman_fit_frames(fit_, &image, count, predictions_.data(), 0, results_.data());
    }

    std::string line(size_t i) const override {
        const toliman_fit_result &result = results_[i];
        return formatted("%.17g,%.6g,%.17g,%.6g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%d,", result.displacement_px,
                         result.chi_square, result.separation_px, result.separation_sigma_px, result.position_angle_deg,
                         result.x_px, result.y_px, result.flux_a, result.flux_b, result.background, result.iterations) +
               flag_words(result.flags);
    }

    std::vector<Doubt> doubts(size_t i) const override {
        const toliman_fit_result &result = results_[i];
        std::vector<Doubt> doubts;
        if ((result.flags & TOLIMAN_FIT_NOT_CONVERGED) != 0)
            doubts.push_back({"did not converge", "the fit did not converge: its numbers are nan"});
        if ((result.flags & TOLIMAN_FIT_OUTLIER) != 0)
            doubts.push_back({"have a chi-square far above 1",
                              formatted("a chi-square of %.3g is more than 6 sigma above 1: the frame is damaged, or "
                                        "the scene lacks something",
                                        result.chi_square)});
        if ((result.flags & TOLIMAN_FIT_SEARCHED) != 0)
            doubts.push_back({"have their stars elsewhere than predicted",
                              "the stars were not at their predicted places, and were searched for"});
        return doubts;
    }

  private:
    const std::vector<double> &times() const { return file_times_.empty() ? scene_times_ : file_times_; }

    void check_times(size_t frames) const {
        if (!cadence_ && frames > times().size())
            malformed(path_, "has " + std::to_string(frames) + " frames: the scene has times for " +
                                 std::to_string(times().size()) + " only: give --cadence SECONDS");
    }

    double days_of(size_t frame) const {
        constexpr double kDay = 86400;
        return cadence_ ? static_cast<double>(frame) * *cadence_ / kDay : times()[frame];
    }

    const toliman_fit *fit_;
    const std::vector<double> &scene_times_;
    std::optional<double> cadence_;
    std::string path_;
    std::vector<double> file_times_; // days, of the table FRAMES; empty without one
    std::vector<toliman_fit_prediction> predictions_;
    std::vector<toliman_fit_result> results_;
};

} // namespace

std::unique_ptr<Encoder> make_encoder(const Estimator &estimator, size_t most, const std::optional<double> &cadence) {
    if (estimator.fit)
        return std::make_unique<FitEncoder>(estimator, most, cadence);
    return std::make_unique<ValueEncoder>(estimator, most);
}

} // namespace cli
