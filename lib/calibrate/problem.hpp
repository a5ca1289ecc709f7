// What a calibration is given, and where it stands.
#pragma once
#include <array>
#include <functional>
#include <vector>

#include "base/buffer.hpp"
#include "base/view.hpp"
#include "fit/fit.hpp"
#include "optics/simulator.hpp"

namespace toliman::calibrate {

constexpr size_t kOwn = fit::always; // parameters of a frame: places, fluxes, background, as in fit/model.hpp

// A parameter of the instrument with its prior, a normal one around 0.
struct Free {
    Parameter parameter;
    double sigma;
};

// A default parameter that the scene does not have, and the reason.
struct LeftOut {
    Parameter parameter;
    const char *why;
};

// Frames are read when needed, one at a time by each thread: memory does not depend on their number.
struct Frames {
    size_t count = 0;
    std::function<void(size_t k, double *counts)> read; // [rows][cols]
    std::vector<fit::Prediction> predictions;

    double exposures() const noexcept; // frames, those of sums counted one by one
    bool has_sums() const noexcept;
    Spread mean_spread() const noexcept; // of 1 frame, with the mean covariance of all
};

// The instrument changes linearly from the start of a window to that of the next; after the last start it is constant.
struct Window {
    double first_days = 0;
    double elapsed = 1; // windows since the one before, those without frames included
    std::vector<size_t> frames;
    std::vector<double> shares; // of each frame: weight of the values at the next start, 0 to 1; empty: 0
};

// The weight of the values at the start of a window.
struct Part {
    size_t window;
    double share;
};

class Memo;

struct Problem {
    Scene nominal;
    optics::Settings settings;
    std::vector<Free> free;
    std::vector<LeftOut> left_out;
    double peak_photons = 0; // of the brightest pixel of the nominal scene's frames
    double peak_e = 0;       // its charge in one exposure
    Frames frames;
    std::vector<Window> windows;
    double window_days = 0;   // 0: one window, without change
    double smoothness = 0.01; // standard deviation of the change from start to start, in those of the priors
    double capture_px = 6;
    Memo *memo = nullptr; // of the results of costly functions; may be NULL

    // Calls visit(frame, parts) for all frames of a window, then of the next. The values of a frame are the sum of the
    // parts, one or two.
    template <class Visit> void for_frames(const Visit &visit) const {
        for (size_t window = 0; window < windows.size(); window++)
            for (size_t i = 0; i < windows[window].frames.size(); i++)
                visit(windows[window].frames[i], parts_of(window, i));
    }
    std::vector<Part> parts_of(size_t window, size_t i) const {
        const std::vector<double> &shares = windows[window].shares;
        const double share = shares.empty() ? 0 : shares[i];
        if (share == 0)
            return {{window, 1}};
        return {{window, 1 - share}, {window + 1, share}};
    }
    std::vector<Parameter> parameters() const {
        std::vector<Parameter> all;
        for (const Free &one : free)
            all.push_back(one.parameter);
        return all;
    }
};

using OwnOfFrames = std::vector<std::array<double, kOwn>>; // [frame]

// Values of all parameters: changes of the instrument against the nominal scene at the start of each window, and those
// of each frame.
struct Point {
    std::vector<std::vector<double>> instrument; // [window][parameter]
    OwnOfFrames own;
    Buffer<double> map_m;            // OPD added to the pupil, [N][N]; empty = none
    Buffer<double> response;         // relative change of each pixel's response, [rows][cols]; empty = none
    std::vector<BadPixels> bad = {}; // [frame], left out; empty = none

    BadPixels bad_of(size_t frame) const noexcept { return bad.empty() ? BadPixels() : bad[frame]; }
};

// Status::unsupported for a scene that cannot be calibrated.
void check_scene(const optics::Simulator &simulator);

// The scene with absolute photons. Photons relative to the peak of the image would change with the optics.
Scene with_photons(const optics::Simulator &simulator);

// Windows of `days` from the first time on: those with frames, and those whose start is the end of one with frames.
// 0: one window, without change.
void set_windows(Problem &problem, double days);

constexpr size_t kMostUnknowns = 4096; // parameters times windows

// Splits the windows in two, one without change into one of all frames. Returns false, with the windows as before,
// where too few frames would remain in each, or too many unknowns.
bool refine_windows(Problem &problem);

// The mean over the windows.
std::vector<double> mean_of(const std::vector<std::vector<double>> &windows);

// The values at the starts of other windows, by linear interpolation.
std::vector<std::vector<double>> at_starts(const std::vector<std::vector<double>> &values,
                                           const std::vector<Window> &from, const std::vector<Window> &to);

// The values of a frame.
std::vector<double> sum_of(const std::vector<std::vector<double>> &windows, const std::vector<Part> &parts);

// The rms of a map over the open pupil.
double rms_of(const Buffer<double> &map_m, const Buffer<double> &amplitude) noexcept;

// Multiplies the response of a detector by 1 + change.
void change_response(const Buffer<double> &change, Detector &detector);

// The scene with changed parameters, and its outline with the map.
Scene scene_at(const Problem &problem, const std::vector<double> &changes);
optics::Outline outline_at(const Problem &problem, const std::vector<double> &changes, const Buffer<double> &map_m);

} // namespace toliman::calibrate
