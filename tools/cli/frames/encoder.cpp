#include "frames/encoder.hpp"

#include "frames/predictions.hpp"

namespace cli {

namespace {

constexpr double kFarSigmas = 1000;

constexpr char kGoodnessColumns[] = "chi_square,chi_square_sigma,largest_residual,goodness,bad_pixels";

// The columns kGoodnessColumns. Result: toliman_frame_goodness, or a result with its members.
template <class Result> std::string goodness_cells(const Result &fit) {
    return formatted("%.6g,%.6g,%.4g,%s,%u", fit.chi_square, fit.chi_square_sigma, fit.largest_residual,
                     toliman_constant_name(fit.goodness), fit.bad_pixels);
}

// Adds the doubt about a fit that is poor or too good.
template <class Result> void doubt_goodness(const Result &fit, std::vector<Doubt> &doubts) {
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

// Throws Failure for frames that are sums; estimator: "a network".
void refuse_sums(FrameFile &frames, const char *estimator) {
    if (!frames.spreads().empty())
        malformed(frames.path(), std::string("sums of frames, which ") + estimator + " does not take: use --fit");
}

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

using Flags = std::vector<std::pair<uint32_t, const char *>>;

const Flags kFitFlags = {{TOLIMAN_FIT_NOT_CONVERGED, "not_converged"},
                         {TOLIMAN_FIT_SATURATED, "saturated"},
                         {TOLIMAN_FIT_EDGE, "edge"},
                         {TOLIMAN_FIT_SEARCHED, "searched"}};
const Flags kBankFlags = {{TOLIMAN_BANK_OUTSIDE, "outside"}, {TOLIMAN_BANK_LOW_EFFICIENCY, "low_efficiency"}};

void add_words(const Flags &names, uint32_t flags, std::vector<std::string> &words) {
    for (const auto &[flag, word] : names)
        if ((flags & flag) != 0)
            words.push_back(word);
}

// The columns up to separation_sigma_px; Result is that of a fit or a bank.
template <class Result> std::string value_cells(const Result &result, double sigma_px) {
    return formatted("%.17g,", result.displacement_px) + goodness_cells(result) +
           formatted(",%.17g,%.6g,", result.separation_px, sigma_px);
}

constexpr char kPlaceColumns[] = "position_angle_deg,x_px,y_px,flux_a,flux_b,background,iterations,flags";

// The columns kPlaceColumns except the last.
std::string place_words(const toliman_fit_result &result) {
    return formatted("%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%d,", result.position_angle_deg, result.x_px, result.y_px,
                     result.flux_a, result.flux_b, result.background, result.iterations);
}

std::vector<Doubt> fit_doubts(const toliman_fit_result &result) {
    std::vector<Doubt> doubts;
    if ((result.flags & TOLIMAN_FIT_NOT_CONVERGED) != 0)
        doubts.push_back({"did not converge", "the fit did not converge: its numbers are nan"});
    doubt_goodness(result, doubts);
    if ((result.flags & TOLIMAN_FIT_SEARCHED) != 0)
        doubts.push_back({"have their stars elsewhere than predicted",
                          "the stars were not at their predicted places, and were searched for"});
    return doubts;
}

// A fit, alone or with the networks of a bank, whose value is then that of a frame.
class FitEncoder final : public Encoder {
  public:
    FitEncoder(const Estimator &estimator, size_t most, const FrameClock &clock, Progress &progress)
        : estimator_(estimator), bank_(estimator.bank.get()), predictions_(estimator.times, most, clock, progress),
          fits_(most, toliman::sized<toliman_fit_result>()), results_(most, toliman::sized<toliman_bank_result>()),
          columns_(std::string("displacement_px,") + kGoodnessColumns + ",separation_px,separation_sigma_px," +
                   (bank_ != nullptr ? "efficiency,network,fit_displacement_px," : "") + kPlaceColumns) {
        if (bank_ != nullptr)
            info_ = toliman::result<toliman_bank_info>(toliman_bank_get_info, bank_);
    }

    const char *columns() const override { return columns_.c_str(); }
    void open(FrameFile &frames) override {
        if (bank_ != nullptr)
            refuse_sums(frames, "a bank");
        predictions_.open(frames);
    }

    toliman_status encode(const toliman_image &image, size_t first, size_t count) override {
        const toliman_fit *const fit = estimator_.fit.get();
        const toliman_fit_prediction *const predictions = predictions_.from(first, count);
        if (bank_ == nullptr)
            return toliman_fit_frame(fit, &image, count, predictions, fits_.data(), nullptr, nullptr);
        const toliman_status status =
            toliman_bank_encode(bank_, fit, &image, count, predictions, results_.data(), fits_.data());
        for (size_t i = 0; status == TOLIMAN_OK && i < count; i++)
            record(results_[i]);
        return status;
    }

    std::string line(size_t i) const override {
        const toliman_fit_result &fit = fits_[i];
        std::vector<std::string> words;
        add_words(kFitFlags, fit.flags, words);
        if (bank_ == nullptr)
            return value_cells(fit, fit.separation_sigma_px) + place_words(fit) + joined(words, "+");
        const toliman_bank_result &result = results_[i];
        add_words(kBankFlags, result.flags, words);
        return value_cells(result, result.sigma_px) +
               formatted("%.6g,%lld,%.17g,", result.efficiency, static_cast<long long>(result.network),
                         fit.displacement_px) +
               place_words(fit) + joined(words, "+");
    }

    std::vector<Doubt> doubts(size_t i) const override {
        std::vector<Doubt> doubts = fit_doubts(fits_[i]);
        const toliman_bank_result &result = results_[i];
        if (bank_ == nullptr || (result.flags & TOLIMAN_BANK_LOW_EFFICIENCY) == 0)
            return doubts;
        const Apart efficiency = apart(result.efficiency, kLeastEfficiency, 3);
        doubts.push_back({"have a low efficiency", "an efficiency of " + efficiency.value + " is below " +
                                                       efficiency.limit +
                                                       ": the stars are far from the places of the networks, or "
                                                       "these have too few steps of training"});
        return doubts;
    }

    Separation separation(size_t i) const override {
        return {predictions_.tai_ns(i), predictions_.days(i),
                bank_ != nullptr ? results_[i].separation_px : fits_[i].separation_px};
    }

    void end(Progress &progress) const override {
        if (outside_ > 0 && !estimator_.renewal.empty())
            progress.warn(
                formatted("%zu of %zu frames are outside the dates of the bank: ", outside_, efficiencies_.size()) +
                estimator_.renewal);
        else if (ends())
            progress.warn("the dates of the bank end: " + estimator_.renewal);
        if (efficiencies_.empty())
            return;
        std::vector<double> sorted = efficiencies_;
        std::sort(sorted.begin(), sorted.end());
        progress.tell(formatted("efficiency of the networks: smallest %.4f, median %.4f", sorted.front(),
                                sorted[sorted.size() / 2]));
    }

  private:
    void record(const toliman_bank_result &result) {
        if ((result.flags & TOLIMAN_BANK_NOT_FITTED) != 0)
            return;
        efficiencies_.push_back(result.efficiency);
        outside_ += (result.flags & TOLIMAN_BANK_OUTSIDE) != 0;
        at_last_date_ = at_last_date_ || result.network >= info_.networks - info_.places;
    }

    // Whether the frames are at the last date of a bank whose efficiency decreases towards it.
    bool ends() const {
        constexpr double kEnding = 0.98;
        return at_last_date_ && !estimator_.renewal.empty() &&
               efficiency_at(estimator_.bank, estimator_.fit, info_.last_days) < kEnding;
    }

    const Estimator &estimator_;
    const toliman_bank *bank_; // null: the fit alone
    toliman_bank_info info_ = {};
    Predictions predictions_;
    std::vector<toliman_fit_result> fits_;
    std::vector<toliman_bank_result> results_;
    std::string columns_;
    std::vector<double> efficiencies_; // of all fitted frames
    size_t outside_ = 0;               // those outside the dates of the bank
    bool at_last_date_ = false;        // whether a frame was encoded by a network of the last date
};

} // namespace

std::unique_ptr<Encoder> make_encoder(const Estimator &estimator, size_t most, const FrameClock &clock,
                                      Progress &progress) {
    if (estimator.fit)
        return std::make_unique<FitEncoder>(estimator, most, clock, progress);
    return std::make_unique<ValueEncoder>(estimator, most);
}

} // namespace cli
