// Bank: networks for dates of an orbit and sub-pixel places; estimates the separation of frames that a fit follows.
#pragma once
#include <cstdint>
#include <vector>

#include "backend/journal.hpp"
#include "bank/grid.hpp"
#include "bank/resample.hpp"
#include "base/progress.hpp"
#include "cae/encoder.hpp"
#include "fit/fit.hpp"

namespace toliman::bank {

constexpr double kSpacingPx = 0.5, kLeastSpacingPx = 0.05, kMostSpacingPx = 4;
constexpr uint32_t kPlaces = 3, kMostPlaces = 8, kSteps = 600, kMostSteps = 1000000;
constexpr double kMostDays = 1e6;
constexpr size_t kMostNetworks = 1024; // up to 0.8 MB of memory each
constexpr size_t kLargestFrame = 4096; // rows and columns

// toliman_bank_options, defaults resolved.
struct Options {
    const cae::Layout *layout = &cae::kFlight;
    double first_days = 0, last_days = 0, spacing_px = kSpacingPx;
    uint32_t places = kPlaces, steps = kSteps;
    uint64_t seed = 1;
};

struct Network {
    size_t date;        // index
    double shift_px[2]; // of the scene's centre
    cae::Encoder encoder;
    double star_px[2][2] = {};           // places of A and B, px from the centre of the frame: [star][x, y]
    double share_b = 0;                  // of B's displacement in that of the frame, the rest is A's
    uint32_t crop_row = 0, crop_col = 0; // of the crop, [side][side]
    double cosine = 0;                   // of gradient and target; 0: untrained
    cae::Response response = {};
    bool trained() const noexcept { return cosine > 0; }
};
// Training of a network: from the weights of another one, trained before it, in so many steps.
struct Course {
    size_t generation; // 0: from random weights; n: from a network of an earlier generation
    size_t start;      // number of that network
    uint32_t steps;
};
constexpr size_t kGenerations = 3;
Course course_of(size_t i, size_t dates, const Options &options) noexcept;

// Network number i of a bank, [dates][places along y][places along x], without places of the stars.
Network new_network(size_t i, const Options &options, cae::Encoder encoder);

// Status::unsupported for frames of another size, Status::argument for more than kMostNetworks.
void check_size(size_t rows, size_t cols, size_t dates, const Options &options);

enum Flag : uint32_t { not_fitted = 1, outside = 2, low_efficiency = 4 };
constexpr double kLeastEfficiency = 0.95;

// toliman_bank_result.
struct Estimate {
    uint32_t flags = 0;
    double displacement_px = 0, separation_px = 0, sigma_px = 0, efficiency = 0, distance_px = 0;
    int32_t network = -1;
    FrameGoodness goodness; // of the fit
};

// Working memory of one thread: Bank::work().
struct BankWork {
    fit::Result fitted; // of the last frame
    cae::EncoderWork encoder;
    Resampler resampler;
    Buffer<double> filter, residual, crop; // [rows][cols] twice, [pixels]
};

// Const calls may run on several threads, each with its own work and that of the fit. The fit of a call must be that of
// the constructor, or have the same digest.
class Bank {
  public:
    // Untrained networks. Errors of check_size.
    Bank(const fit::Fit &fit, const Options &options);
    // A bank that was saved.
    Bank(const Options &options, size_t rows, size_t cols, uint64_t fit_digest, std::vector<Date> dates,
         std::vector<Network> networks);

    // Trains the networks that are not trained yet; those trained before a cancellation remain. journal: gets each
    // network once it is trained, and gives those of an earlier call; may be NULL.
    void train(const fit::Fit &fit, unsigned workers, const Progress &progress, Journal *journal);
    std::vector<Journal::Input> inputs() const; // of the journal

    BankWork work() const;
    // Fits and encodes counts of rows() x cols(); work.fitted is the result of the fit.
    Estimate estimate(const fit::Fit &fit, ImageView<const double> counts, const fit::Prediction &prediction,
                      fit::FitWork &fit_work, BankWork &work) const;
    // The estimate of an undisturbed frame.
    Estimate predict(const fit::Fit &fit, const fit::Prediction &prediction, fit::FitWork &fit_work,
                     BankWork &work) const;

    // The first time after the last date, in whole days, at which the efficiency of an undisturbed frame is below
    // `efficiency`, or the end of the model images; at most 4096. By steps that are doubled, then halved.
    double renewal(const fit::Fit &fit, double efficiency, fit::FitWork &fit_work, BankWork &work) const;

    const Options &options() const noexcept { return options_; }
    size_t rows() const noexcept { return rows_; }
    size_t cols() const noexcept { return cols_; }
    const std::vector<Date> &dates() const noexcept { return dates_; }
    const std::vector<Network> &networks() const noexcept { return networks_; }
    size_t trained() const noexcept;
    uint64_t fit_digest() const noexcept { return fit_digest_; }
    uint64_t digest() const noexcept; // of all that determines estimates

  private:
    struct Nearest {
        size_t network;
        double x, y, distance; // displacement from the network's place to the frame's; what it does not remove
    };
    void recall(Journal *journal);
    void train_one(size_t i, const fit::Fit &fit, const Progress &progress);
    Nearest nearest(const double *values) const noexcept;
    Buffer<double> target_of(const fit::Fit &fit, const Network &network) const;
    void measure(const fit::Fit &fit, const ImageView<const double> *counts, const fit::Prediction &prediction,
                 fit::FitWork &fit_work, BankWork &work, Estimate &estimate) const;

    Options options_;
    size_t rows_, cols_;
    uint64_t fit_digest_;
    std::vector<Date> dates_;
    std::vector<Network> networks_;
};

} // namespace toliman::bank
