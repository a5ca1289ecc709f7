// Method: train a network on the scene (no frames) and encode each frame by the trained network, the untrained network
// and the template estimator. Frames without signal give the scatter of each estimator; efficiency is the Cramer-Rao
// bound over that of the latent. The decoder is checked against the whitened derivative image, because a decoder that
// ignores the latent also reaches the photon floor of the reconstruction error.
#include "run/estimators.hpp"

#include <iterator>

#include "common/parallel.hpp"
#include "frames/frame_loop.hpp"

namespace cli {

namespace {

constexpr size_t kValidationFrames = 110; // size of the book chapter's validation set

constexpr uint32_t kSteps = 300; // the library's default

using toliman::check;

toliman::autoencoder network_of(const Scene &scene, uint64_t seed, const toliman_cae_options *options) {
    return toliman::make<toliman::autoencoder>(toliman_cae_create, scene.sim.get(), seed, options);
}

// Appends the values of frames. encode: toliman_cae_encode or toliman_linear_encode.
template <class Encode, class Estimator>
void add_values(Encode encode, const Estimator &estimator, const double *images, size_t count,
                std::vector<double> &values) {
    const toliman_image image = plain_image(images);
    values.resize(values.size() + count);
    check(encode(estimator.get(), &image, count, &values[values.size() - count], nullptr));
}

class Reconstructor {
  public:
    // For a run of `total` frames.
    Reconstructor(const Scene &scene, const toliman::autoencoder &cae, size_t total, Reconstructions &result)
        : scene_(scene), cae_(cae), result_(result) {
        const auto info = toliman::result<toliman_cae_info>(toliman_cae_get_info, cae.get(), nullptr);
        side_ = info.side;
        crop_row_ = static_cast<size_t>(info.crop_row);
        crop_col_ = static_cast<size_t>(info.crop_col);
        sigma_ = cropped(scene.image(TOLIMAN_SIM_IMAGE_VARIANCE).data());
        for (double &pixel : sigma_)
            pixel = std::sqrt(pixel);
        result_.validation_frames = std::min(total, kValidationFrames);
    }

    // Reconstructs those of frames first ... first + count - 1 that are validation frames. Frames come in order.
    void take(size_t first, const double *images, size_t count) {
        if (first >= result_.validation_frames)
            return;
        std::vector<Reconstruction> all(std::min(count, result_.validation_frames - first));
        run_parallel(all.size(), [&](size_t i) { reconstruct(images + i * scene_.pixels(), all[i]); });
        for (const Reconstruction &one : all) // in order, so that the sums have the same bits for any number of threads
            add(one);
    }

  private:
    using Image = std::vector<double>;
    // The part of a frame that the network sees.
    Image cropped(const double *image) const {
        const auto cols = static_cast<size_t>(scene_.info.cols);
        Image part;
        part.reserve(side_ * side_);
        for (size_t row = 0; row < side_; row++) {
            const double *start = image + (crop_row_ + row) * cols + crop_col_;
            part.insert(part.end(), start, start + side_);
        }
        return part;
    }

    struct Reconstruction {
        Image residual;
        double mmse = 0, mssim = 0, photon_floor = 0;
    };
    void reconstruct(const double *image, Reconstruction &result) const {
        Image again(side_ * side_);
        check(toliman_cae_reconstruct(cae_.get(), image, static_cast<size_t>(scene_.info.cols), again.data(), side_,
                                      &result.mmse, &result.mssim, &result.photon_floor));
        result.residual = cropped(image);
        for (size_t i = 0; i < again.size(); i++)
            result.residual[i] = (result.residual[i] - again[i]) / sigma_[i];
    }

    void add(const Reconstruction &one) {
        const auto frames = static_cast<double>(result_.validation_frames), share = 1 / frames;
        result_.mmse += one.mmse * share;
        result_.mssim += one.mssim * share;
        result_.photon_floor += one.photon_floor * share;
        double sum = 0, square = 0, product = 0;
        for (size_t i = 0; i < one.residual.size(); i++) {
            sum += one.residual[i];
            square += one.residual[i] * one.residual[i];
            product += (i + 1) % side_ != 0 ? one.residual[i] * one.residual[i + 1] : 0;
        }
        const auto side = static_cast<double>(side_), pixels = side * side;
        result_.residual_mean += sum / (pixels * frames);
        result_.residual_square += square / (pixels * frames);
        result_.residual_product += product / ((pixels - side) * frames);
    }

    const Scene &scene_;
    const toliman::autoencoder &cae_;
    size_t side_, crop_row_, crop_col_; // rows and columns of the crop; its first row and column
    Image sigma_;
    Reconstructions &result_;
};

// For stars at rest.
class NetworkRun final : public Estimators {
  public:
    // Without controls there is no untrained network.
    NetworkRun(const Scene &scene, size_t frames, Pipeline &result, Progress &progress)
        : scene_(scene), frames_(frames), result_(result), outcome_(result.network.emplace()), progress_(progress),
          options_(with_warnings<toliman_cae_options>(progress)),
          cae_(network_of(scene, result.options.seed, &options_)),
          template_(toliman::make<toliman::linear_estimator>(toliman_linear_create, scene.sim.get(), nullptr)),
          reconstructor_(scene, cae_, frames, outcome_.reconstructions) {
        if (result.options.controls != Controls::none)
            untrained_ = network_of(scene, result.options.seed, nullptr);
    }

    void train() override {
        auto options = with_progress<toliman_cae_train_options>(progress_);
        outcome_.losses.resize(kSteps);
        options.steps = kSteps;
        options.losses = outcome_.losses.data();
        options.loss_count = kSteps;
        outcome_.training.struct_size = sizeof outcome_.training;
        check(toliman_cae_train(cae_.get(), &options, &outcome_.training));
        outcome_.weights = bytes_of([this](unsigned char *data, size_t capacity, size_t *size) {
            return toliman_cae_save(cae_.get(), nullptr, data, capacity, size);
        });
        inspect_decoder();
    }

    void push(size_t at, const double *images, size_t count) override {
        {
            const Stopwatch watch(result_.timings.encode);
            add_values(toliman_cae_encode, cae_, images, count, outcome_.latent.values);
        }
        const Stopwatch watch(result_.timings.controls);
        if (untrained_)
            add_values(toliman_cae_encode, untrained_, images, count, outcome_.untrained.values);
        add_values(toliman_linear_encode, template_, images, count, outcome_.template_fit.values);
        reconstructor_.take(at, images, count);
    }

    void push_control(size_t at, const double *images, size_t count) override {
        add_values(toliman_cae_encode, cae_, images, count, outcome_.no_signal.values);
        add_values(toliman_linear_encode, template_, images, count, template_controls_);
        if (at < frames_)
            add_values(toliman_cae_encode, untrained_, images, std::min(count, frames_ - at), untrained_controls_);
    }

    void end_controls() override {
        std::vector<double> &latents = outcome_.no_signal.values;
        outcome_.latent.sigma_px = outcome_.no_signal.sigma_px = deviation(latents);
        outcome_.template_fit.sigma_px = deviation(template_controls_);
        outcome_.untrained.sigma_px = deviation(untrained_controls_);
        if (result_.photon_noise)
            outcome_.efficiency = scene_.bounds().crb_projected_px / outcome_.latent.sigma_px;
        latents.resize(std::min(frames_, latents.size()));
    }

  private:
    // Compares (decode(z) - decode(0))/z with the whitened derivative image, which it should be.
    void inspect_decoder() {
        const double z = scene_.bounds().crb_px;
        const size_t side = toliman::result<toliman_cae_info>(toliman_cae_get_info, cae_.get(), nullptr).side;
        std::vector<double> target(side * side), at_z(target.size()), at_0(target.size());
        check(toliman_cae_get_target(cae_.get(), target.data(), side));
        check(toliman_cae_decode(cae_.get(), z, at_z.data(), side));
        check(toliman_cae_decode(cae_.get(), 0, at_0.data(), side));
        double product = 0, target_square = 0, output_square = 0;
        for (size_t i = 0; i < target.size(); i++) {
            const double output = (at_z[i] - at_0[i]) / z;
            product += output * target[i];
            target_square += target[i] * target[i];
            output_square += output * output;
        }
        outcome_.decoder_cosine = product / std::sqrt(target_square * output_square);
        outcome_.decoder_gain = product / target_square;
    }

    const Scene &scene_;
    size_t frames_; // of the cadence
    Pipeline &result_;
    NetworkOutcome &outcome_;
    Progress &progress_;
    toliman_cae_options options_;
    toliman::autoencoder cae_, untrained_;
    toliman::linear_estimator template_;
    std::vector<double> template_controls_, untrained_controls_; // values of frames without signal
    Reconstructor reconstructor_;
};

// Method: each frame is fitted at its time in the scene, alone or with the networks of a bank. The efficiency compares
// each value of a frame without signal with the Cramer-Rao bound at this time, because the bound changes with the
// places of the stars.

constexpr uint32_t kBankSteps = 300; // as many as those of a single network; 600 would gain 0.3 % of efficiency

bool is_series(const std::vector<double> &values) {
    constexpr int fewest = 5;
    return std::count_if(values.begin(), values.end(), [](double value) { return !std::isnan(value); }) >= fewest;
}

// Not in frames that are too small, nor for an orbit of more dates than a bank can have.
bool can_have_bank(const Scene &scene) {
    auto plan = toliman::sized<toliman_bank_plan_info>();
    return toliman_bank_plan(scene.sim.get(), nullptr, &plan) == TOLIMAN_OK;
}

toliman_fit_prediction prediction_at(double time_days) {
    auto prediction = toliman::sized<toliman_fit_prediction>();
    prediction.time_days = time_days;
    return prediction;
}

// Appends `count` structs with their size set; returns the first.
template <class T> T *append(std::vector<T> &structs, size_t count) {
    structs.resize(structs.size() + count, toliman::sized<T>());
    return &structs[structs.size() - count];
}

template <class Result> std::vector<double> displacements(const std::vector<Result> &results) {
    std::vector<double> values;
    values.reserve(results.size());
    for (const Result &result : results)
        values.push_back(result.displacement_px);
    return values;
}

// For moving stars.
class FitRun final : public Estimators {
  public:
    // Throws toliman::error if the scene has no fit.
    FitRun(const Scene &scene, const Cadence &cadence, Pipeline &result, Progress &progress)
        : scene_(scene), times_days_(cadence.times), result_(result), outcome_(result.fit.emplace()),
          progress_(progress) {
        const Stopwatch watch(result.timings.fit);
        const toliman_sim *const sim = scene.sim.get();
        fit_ = toliman::make<toliman::frame_fit>(toliman_fit_create, &sim, nullptr, size_t{1}, nullptr);
        if (!can_have_bank(scene))
            return;
        auto options = toliman::sized<toliman_bank_options>();
        options.steps = kBankSteps;
        options.seed = result.options.seed;
        bank_ = toliman::make<toliman::network_bank>(toliman_bank_create, fit_.get(), &options);
        result.bank.emplace();
    }

    // Trains the bank; does nothing without one
    void train() override {
        const toliman_bank *const bank = bank_.get();
        if (bank == nullptr)
            return;
        BankOutcome &outcome = *result_.bank;
        auto options = with_progress<toliman_bank_train_options>(progress_);
        toliman::check(toliman_bank_train(bank_.get(), fit_.get(), &options));
        outcome.info = toliman::result<toliman_bank_info>(toliman_bank_get_info, bank);
        outcome.least_cosine = 1;
        for (const toliman_bank_network &network : items_of(toliman_bank_get_network, bank, outcome.info.networks))
            outcome.least_cosine = std::min(outcome.least_cosine, network.cosine);
        outcome.weights = bytes_of([bank](unsigned char *data, size_t capacity, size_t *size) {
            return toliman_bank_save(bank, TOLIMAN_CAE_ENCODING_FLOAT32, data, capacity, size);
        });
    }

    void push(size_t at, const double *images, size_t count) override {
        const Stopwatch watch(result_.timings.fit);
        push_control(at, images, count);
    }
    void end_frames() override {
        const Stopwatch watch(result_.timings.fit);
        const std::vector<toliman_fit_result> results = std::exchange(results_, {});
        std::vector<double> chi_squares, iterations;
        for (const toliman_fit_result &result : results) {
            outcome_.signal.values.push_back(result.displacement_px);
            if ((result.flags & TOLIMAN_FIT_NOT_CONVERGED) != 0)
                continue;
            chi_squares.push_back(result.chi_square);
            iterations.push_back(result.iterations);
        }
        outcome_.lost = results.size() - chi_squares.size();
        outcome_.chi_square = mean(chi_squares);
        outcome_.iterations = mean(iterations);
        if (bank_)
            end_frames(std::exchange(estimates_, {}));
        bounds_px_ = bounds_px();
        std::vector<double> variances;
        for (const double bound : bounds_px_)
            variances.push_back(bound * bound);
        outcome_.bound_px = std::sqrt(mean(variances));
    }

    void push_control(size_t at, const double *images, size_t count) override {
        const toliman_image image = plain_image(images);
        std::vector<toliman_fit_prediction> predictions;
        for (size_t k = at; k < at + count; k++)
            predictions.push_back(prediction_at(times_days_[k % times_days_.size()]));
        toliman_fit_result *const results = append(results_, count);
        toliman::check(
            bank_ ? toliman_bank_encode(bank_.get(), fit_.get(), &image, count, predictions.data(),
                                        append(estimates_, count), results)
                  : toliman_fit_frame(fit_.get(), &image, count, predictions.data(), results, nullptr, nullptr));
    }

    void end_controls() override {
        if (bank_)
            end_controls(displacements(estimates_), *result_.bank);
        end_controls(displacements(results_), outcome_);
    }

    void require_series() const override {
        const std::vector<double> &no_signal = outcome_.no_signal.values;
        if (!is_series(outcome_.signal.values) || !(no_signal.empty() || is_series(no_signal)))
            throw Failure(kExitUsage,
                          formatted("%s: the fit did not converge for %zu of %zu frames: their noise must be smaller, "
                                    "and the stars must be in the frame",
                                    scene_.path.c_str(), outcome_.lost, times_days_.size()));
    }

  private:
    void end_frames(const std::vector<toliman_bank_result> &estimates) {
        BankOutcome &outcome = *result_.bank;
        outcome.signal.values = displacements(estimates);
        std::vector<double> known;
        for (const toliman_bank_result &estimate : estimates) {
            outcome.efficiencies.push_back(estimate.efficiency);
            if (!std::isnan(estimate.efficiency))
                known.push_back(estimate.efficiency);
        }
        if (known.empty())
            return;
        outcome.least_efficiency = *std::min_element(known.begin(), known.end());
        outcome.mean_efficiency = mean(known);
    }

    void end_controls(std::vector<double> values, FollowOutcome &of) const {
        Outcome &control = of.no_signal;
        control.values = std::move(values);
        std::vector<double> known, squared_ratios;
        for (size_t k = 0; k < control.values.size(); k++) {
            if (std::isnan(control.values[k]))
                continue;
            known.push_back(control.values[k]);
            const double ratio = control.values[k] / bounds_px_[k % bounds_px_.size()];
            squared_ratios.push_back(ratio * ratio);
        }
        control.sigma_px = of.signal.sigma_px = deviation(known);
        if (result_.photon_noise)
            of.efficiency = 1 / std::sqrt(mean(squared_ratios));
        control.values.resize(std::min(control.values.size(), bounds_px_.size()));
    }

    // Standard deviations of the values that noise alone causes in the frames of the cadence: Cramer-Rao bounds with
    // places, fluxes and background free, px.
    std::vector<double> bounds_px() const {
        const auto parameters =
            static_cast<size_t>(toliman::result<toliman_fit_info>(toliman_fit_get_info, fit_.get()).parameters);
        std::vector<double> bounds(times_days_.size());
        run_parallel(bounds.size(), [&](size_t i) {
            const toliman_fit_prediction prediction = prediction_at(times_days_[i]);
            std::vector<double> covariance(parameters * parameters);
            toliman::check(toliman_fit_predict(fit_.get(), &prediction, nullptr, 0, nullptr, covariance.data()));
            bounds[i] = std::sqrt(covariance[0]); // of the separation, the first parameter
        });
        return bounds;
    }

    const Scene &scene_;
    const std::vector<double> &times_days_;
    Pipeline &result_;
    FitOutcome &outcome_;
    Progress &progress_;
    toliman::frame_fit fit_;
    toliman::network_bank bank_; // null if there can be none
    std::vector<toliman_fit_result> results_;
    std::vector<toliman_bank_result> estimates_;
    std::vector<double> bounds_px_; // of the frames of the cadence
};

} // namespace

std::unique_ptr<Estimators> make_estimators(const Scene &scene, const Cadence &cadence, Pipeline &result,
                                            Progress &progress) {
    if (scene.moves())
        return std::make_unique<FitRun>(scene, cadence, result, progress);
    return std::make_unique<NetworkRun>(scene, cadence.times.size(), result, progress);
}

} // namespace cli
