// Method: with the fit p^ of a frame, its covariance C, and the separation's axis e = C a/(a C a) (fit/separation.hpp),
// the model is taken at p0 = p^ - d e: the separation at its prediction, d px from the fitted one, the other parameters
// at their best values for it. The residual r = (n - m(p0))/sigma is then free of them in first order. A network with
// gradient g at the place z0 is applied to the frame at place z by moving the residual by z0 - z, operator R:
//     latent = network(R r)/k,   k = <R^T g, J e/sigma>,
//     efficiency = k sqrt(a C a)/|q|,   q = R^T g minus its components along all derivatives J/sigma except the
//                                       separation's,
// where J, at p^ - d e/2, halfway, makes k exact to third order in d: a prediction off by 5e-3 px, 2000 sigma, changes
// the value by 0.006 sigma; with J at p0 it would be 1.2 sigma. At 0.05 px it would be 2.3 sigma (sky scene), so that d
// is at most 5e-3 px: from a prediction farther off, p0 is taken that far from the fit.
// The residual is moved after whitening, because its noise stays white then; counts over variances lose four times as
// much. The displacement follows mostly the fainter star B (SeparationAxis::share_b): 90 days after its date, a network
// has an efficiency of 0.97, and of 0.90 if it follows A.
#include "bank/bank.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <iterator>
#include <limits>
#include <mutex>
#include <thread>
#include <utility>

#include "bank/weights.hpp"
#include "base/bytes.hpp"
#include "base/error.hpp"
#include "base/hash.hpp"
#include "base/text.hpp"
#include "base/workers.hpp"
#include "cae/tied.hpp"
#include "fit/separation.hpp"

namespace toliman::bank {

namespace {

// First row or column of a crop of `side` px centred on the stars, whose middle is at `middle` px from that of the
// frame.
uint32_t crop_start(double middle, size_t size, size_t side) {
    const double start = std::floor(0.5 * static_cast<double>(size - side) + middle + 0.5);
    return static_cast<uint32_t>(std::clamp(start, 0.0, static_cast<double>(size - side)));
}

fit::Prediction prediction_of(const Date &date, const Network &network) {
    fit::Prediction prediction;
    prediction.days = date.days;
    std::copy_n(network.shift_px, 2, prediction.shift_px);
    return prediction;
}

// Closer predictions need no second model image halfway: the error of the slope changes the value by 0.005 sigma.
constexpr double kNearPx = 3e-4;

constexpr double kFarPx = 5e-3; // largest d

constexpr int kMostServedDays = 4096;

double square(double x) noexcept {
    return x * x;
}

} // namespace

void check_size(size_t rows, size_t cols, size_t dates, const Options &options) {
    const cae::Layout &layout = *options.layout;
    if (std::min(rows, cols) < layout.side || std::max(rows, cols) > kLargestFrame)
        fail(Status::unsupported, "bank: {detector.shape} = [%zu, %zu]: must be in [%zu, %zu] px for layout %s", rows,
             cols, layout.side, kLargestFrame, layout.name);
    const size_t places = options.places;
    if (dates * places * places > kMostNetworks)
        fail(Status::argument, "{options}: %zu dates with %zu places each: must be at most %zu networks", dates,
             places * places, kMostNetworks);
}

Course course_of(size_t i, size_t dates, const Options &options) noexcept {
    const size_t places = size_t{options.places} * options.places, first = (dates - 1) / 2 * places;
    if (i == first)
        return {0, i, options.steps};
    const uint32_t fewer = (options.steps + 2) / 3;
    return i % places == 0 ? Course{1, first, fewer} : Course{2, i / places * places, fewer};
}

Network new_network(size_t i, const Options &options, cae::Encoder encoder) {
    const size_t places = options.places;
    return {i / (places * places),
            {shift_of(i % places, places), shift_of(i / places % places, places)},
            std::move(encoder)};
}

Bank::Bank(const fit::Fit &fit, const Options &options)
    : options_(options), rows_(fit.rows()), cols_(fit.cols()), fit_digest_(fit.digest()),
      dates_(dates_of(options.first_days, options.last_days, options.spacing_px,
                      [&fit](double days) { return fit.difference_on_orbit(days); })) {
    check_size(rows_, cols_, dates_.size(), options);
    const size_t places = options.places;
    fit::FitWork work = fit.work();
    const cae::Encoder untrained(cae::random_encoder(*options.layout, options.seed));
    const cae::Response response = untrained.response();
    for (const double days : {options.first_days, options.last_days}) { // networks are made for dates in between
        fit::Prediction end;
        fit::Result unused;
        end.days = days;
        fit.predict(end, work, unused);
    }
    for (size_t i = 0; i < dates_.size() * places * places; i++) {
        Network network = new_network(i, options, untrained);
        network.response = response;
        fit::Result undisturbed;
        fit.predict(prediction_of(dates_[network.date], network), work, undisturbed);
        const double *const values = undisturbed.state.values;
        std::copy_n(values, 4, &network.star_px[0][0]);
        network.share_b = fit::separation_axis(undisturbed.state, fit.parameters().size()).share_b;
        network.crop_row = crop_start(0.5 * (values[fit::y_a] + values[fit::y_b]), rows_, options.layout->side);
        network.crop_col = crop_start(0.5 * (values[fit::x_a] + values[fit::x_b]), cols_, options.layout->side);
        networks_.push_back(std::move(network));
    }
}

Bank::Bank(const Options &options, size_t rows, size_t cols, uint64_t fit_digest, std::vector<Date> dates,
           std::vector<Network> networks)
    : options_(options), rows_(rows), cols_(cols), fit_digest_(fit_digest), dates_(std::move(dates)),
      networks_(std::move(networks)) {}

BankWork Bank::work() const {
    return {{},
            cae::EncoderWork(*options_.layout),
            Resampler(std::max(cols_, options_.layout->side)),
            Buffer<double>(rows_ * cols_),
            Buffer<double>(rows_ * cols_),
            Buffer<double>(options_.layout->pixels())};
}

size_t Bank::trained() const noexcept {
    return static_cast<size_t>(
        std::count_if(networks_.begin(), networks_.end(), [](const Network &network) { return network.trained(); }));
}

uint64_t Bank::digest() const noexcept {
    uint64_t hash = fnv1a(cae::layout_hash(*options_.layout), fnv1a(fit_digest_, kFnvOffset));
    for (const Network &network : networks_) {
        hash = fnv1a(std::array<double, 5>{network.star_px[0][0], network.star_px[0][1], network.star_px[1][0],
                                           network.star_px[1][1], network.share_b},
                     hash);
        hash = fnv1a(std::array<double, 2>{network.response.gain, network.response.share}, hash);
        hash = fnv1a(network.encoder.weights().values,
                     fnv1a(uint64_t{network.crop_row}, fnv1a(uint64_t{network.crop_col}, hash)));
    }
    return hash;
}

// The whitened derivative by the separation with all others projected out, at the network's place, in its crop.
Buffer<double> Bank::target_of(const fit::Fit &fit, const Network &network) const {
    fit::FitWork work = fit.work();
    fit::Result undisturbed;
    fit.predict(prediction_of(dates_[network.date], network), work, undisturbed);
    const fit::SeparationAxis axis = fit::separation_axis(undisturbed.state, fit.parameters().size());
    const size_t side = options_.layout->side;
    Buffer<double> image(rows_ * cols_), target(side * side);
    fit.model().whiten_derivative(undisturbed.state.values, axis.change, image.data(), work.model);
    for (size_t r = 0; r < side; r++)
        std::copy_n(&image[(network.crop_row + r) * cols_ + network.crop_col], side, &target[r * side]);
    return target;
}

std::vector<Journal::Input> Bank::inputs() const {
    uint64_t dates = kFnvOffset;
    for (const double days : {options_.first_days, options_.last_days, options_.spacing_px})
        dates = fnv1a(with_bits<uint64_t>(days), dates);
    return {{"another scene or other free parameters", fit_digest_},
            {"another layout", cae::layout_hash(*options_.layout)},
            {"other dates or another spacing", dates},
            {"another number of places", options_.places},
            {"another number of steps", options_.steps},
            {"another seed", options_.seed}};
}

// Networks that an earlier process trained.
void Bank::recall(Journal *journal) {
    for (const Journal::Record *record; journal != nullptr && (record = journal->next()) != nullptr; journal->take())
        if (record->key < networks_.size() && !networks_[record->key].trained())
            set_training(record->bytes, record->key, options_, networks_[record->key]);
}

void Bank::train_one(size_t i, const fit::Fit &fit, const Progress &progress) {
    Network &network = networks_[i];
    const Course course = course_of(i, dates_.size(), options_);
    const Buffer<double> target = target_of(fit, network);
    cae::TiedOptions how;
    how.steps = course.steps;
    how.progress = progress;
    if (course.generation > 0)
        how.learning_rate /= 2;
    cae::Parameters weights = course.generation == 0 ? cae::random_encoder(*options_.layout, options_.seed)
                                                     : networks_[course.start].encoder.weights();
    const double cosine = cae::train_encoder(target, how, weights);
    cae::Encoder encoder(std::move(weights));
    network.response = encoder.response();
    network.encoder = std::move(encoder);
    network.cosine = cosine;
}

// The progress callback runs on the thread of the call only; workers on other threads see its answer in a flag.
void Bank::train(const fit::Fit &fit, unsigned workers, const Progress &progress, Journal *journal) {
    recall(journal);
    std::vector<size_t> untrained;
    for (size_t i = 0; i < networks_.size(); i++)
        if (!networks_[i].trained())
            untrained.push_back(i);
    const std::thread::id caller = std::this_thread::get_id();
    std::atomic<size_t> done{networks_.size() - untrained.size()};
    struct Watch {
        const Progress &progress;
        const std::thread::id caller;
        const std::atomic<size_t> &done;
        const size_t networks;
        std::atomic<bool> stop{false};
        static int32_t look(const char *, double, void *data) {
            auto &watch = *static_cast<Watch *>(data);
            if (std::this_thread::get_id() == watch.caller) {
                const size_t trained = watch.done;
                char stage[64];
                print_text(stage, sizeof stage, "train: %zu of %zu networks", trained, watch.networks);
                if (watch.progress.asks_to_stop(stage,
                                                static_cast<double>(trained) / static_cast<double>(watch.networks)))
                    watch.stop = true;
            }
            return watch.stop ? 1 : 0;
        }
    } watch{progress, caller, done, networks_.size()};
    std::mutex appending;
    for (size_t generation = 0; generation < kGenerations; generation++) {
        std::vector<size_t> next;
        std::copy_if(untrained.begin(), untrained.end(), std::back_inserter(next),
                     [&](size_t i) { return course_of(i, dates_.size(), options_).generation == generation; });
        run_jobs(worker_count(workers), next.size(), [&](size_t job) {
            train_one(next[job], fit, {Watch::look, &watch});
            done++;
            if (journal != nullptr) {
                const std::vector<uint8_t> bytes = training_of(networks_[next[job]]);
                const std::lock_guard<std::mutex> lock(appending);
                journal->append(next[job], bytes);
            }
        });
    }
    progress.asks_to_stop("train: networks", 1); // nothing is left to stop
}

Bank::Nearest Bank::nearest(const double *values) const noexcept {
    Nearest best = {0, 0, 0, std::numeric_limits<double>::infinity()};
    for (size_t i = 0; i < networks_.size(); i++) {
        const Network &network = networks_[i];
        double moved[2], distance = 0;
        for (size_t axis = 0; axis < 2; axis++) {
            const double a = values[fit::x_a + axis] - network.star_px[0][axis],
                         b = values[fit::x_b + axis] - network.star_px[1][axis];
            moved[axis] = a + network.share_b * (b - a);
            distance += square(b - a) + square(moved[axis] - std::nearbyint(moved[axis]));
        }
        if (distance < best.distance)
            best = {i, moved[0], moved[1], distance};
    }
    best.distance = std::sqrt(best.distance);
    return best;
}

void Bank::measure(const fit::Fit &fit, const ImageView<const double> *counts, const fit::Prediction &prediction,
                   fit::FitWork &fit_work, BankWork &work, Estimate &estimate) const {
    const size_t n = fit.parameters().size(), side = options_.layout->side;
    const fit::State &state = work.fitted.state;
    const fit::SeparationAxis axis = fit::separation_axis(state, n);
    const Nearest near = nearest(state.values);
    const Network &network = networks_[near.network];
    estimate.network = static_cast<int32_t>(near.network);
    estimate.goodness = work.fitted.goodness;
    estimate.distance_px = near.distance;
    if (prediction.days < options_.first_days || prediction.days > options_.last_days)
        estimate.flags |= outside;

    const double x = near.x + network.crop_col, y = near.y + network.crop_row; // of the network's crop in the frame
    const Buffer<float> &gradient = network.encoder.gradient();
    std::copy(gradient.begin(), gradient.end(), work.crop.begin());
    const ImageView<double> filter = {work.filter.data(), rows_, cols_, cols_},
                            crop = {work.crop.data(), side, side, side};
    work.resampler.move({crop.data, side, side, side}, -x, -y, filter);

    const double off = std::clamp(work.fitted.displacement_px, -kFarPx, kFarPx); // of the fit from p0
    const bool near_by = std::fabs(off) < kNearPx;
    double predicted[fit::kMostParameters], halfway[fit::kMostParameters], filtered[fit::kMostParameters + 1];
    for (size_t i = 0; i < n; i++) {
        predicted[i] = state.values[i] - off * axis.change[i];
        halfway[i] = state.values[i] - 0.5 * off * axis.change[i];
    }
    fit.model().whiten_residual(counts, predicted, near_by ? predicted : halfway, work.filter.data(),
                                work.residual.data(), filtered, fit_work.model);
    double slope = 0, along = 0; // along: squared norm of the filter's components along all derivatives
    for (size_t i = 0; i < n; i++) {
        slope += axis.change[i] * filtered[i];
        for (size_t j = 0; j < n; j++)
            along += filtered[i] * state.covariance[i * n + j] * filtered[j];
    }
    const double noise2 = filtered[n] - along + axis.variance_px2 * slope * slope;
    const double ratio = noise2 > 0 ? std::fabs(slope) * std::sqrt(axis.variance_px2 / noise2) : 0;
    estimate.efficiency = std::fmin(1, ratio) * network.response.share;
    estimate.sigma_px = std::sqrt(axis.variance_px2) / estimate.efficiency;
    if (!(estimate.efficiency >= kLeastEfficiency))
        estimate.flags |= low_efficiency;

    double from_p0 = 0;
    if (counts != nullptr) {
        work.resampler.move({work.residual.data(), rows_, cols_, cols_}, x, y, crop);
        from_p0 = network.encoder.latent(crop.data, work.encoder) / (network.response.gain * slope);
    }
    estimate.displacement_px = from_p0 + (work.fitted.displacement_px - off);
    estimate.separation_px = fit::separation_of(predicted) + from_p0;
}

Estimate Bank::estimate(const fit::Fit &fit, ImageView<const double> counts, const fit::Prediction &prediction,
                        fit::FitWork &fit_work, BankWork &work) const {
    Estimate estimate;
    const ImageView<const double> ideal = fit.undo(counts, fit_work);
    fit.frame_of_ideal(ideal, prediction, fit_work, work.fitted);
    if ((work.fitted.flags & fit::not_converged) == 0) {
        measure(fit, &ideal, prediction, fit_work, work, estimate);
        return estimate;
    }
    estimate.flags = not_fitted;
    estimate.displacement_px = estimate.separation_px = estimate.sigma_px = estimate.efficiency = estimate.distance_px =
        std::numeric_limits<double>::quiet_NaN();
    return estimate;
}

Estimate Bank::predict(const fit::Fit &fit, const fit::Prediction &prediction, fit::FitWork &fit_work,
                       BankWork &work) const {
    Estimate estimate;
    fit.predict(prediction, fit_work, work.fitted);
    measure(fit, nullptr, prediction, fit_work, work, estimate);
    return estimate;
}

double Bank::renewal(const fit::Fit &fit, double efficiency, fit::FitWork &fit_work, BankWork &work) const {
    const auto serves = [&](double days) {
        fit::Prediction prediction;
        prediction.days = days;
        return fit.covers(prediction) && predict(fit, prediction, fit_work, work).efficiency >= efficiency;
    };
    const auto after = [&](int days) { return options_.last_days + days; };
    int served = 0, step = 1; // days after the last date
    for (; served + step < kMostServedDays && serves(after(served + step)); step *= 2)
        served += step;
    for (; step > 0; step /= 2) // the first failure is within the last step
        if (served + step < kMostServedDays && serves(after(served + step)))
            served += step;
    return after(served + 1);
}

} // namespace toliman::bank
