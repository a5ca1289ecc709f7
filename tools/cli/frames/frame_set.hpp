// The frames of a calibration: good ones of all files, spread in time and pointing.
#pragma once
#include <deque>

#include <toliman/fit.h>

#include "frames/frame_options.hpp"
#include "scenes/scene.hpp"

namespace cli {

// How frames are chosen.
struct FrameChoice {
    size_t most = 20;       // of a window
    double window_days = 0; // length of the windows; 0: one for all
};

struct FrameSet {
    // Reads the files twice: first to judge all frames, then those that are chosen. Tells what was left out. Throws
    // Failure for frames of another shape than the scene's, and fewer than 2 good frames.
    FrameSet(const FrameOptions &options, const Scene &scene, const FrameChoice &choice, Progress &progress);
    struct Place {
        std::string file;
        size_t frame; // of the file
    };
    std::vector<double> pixels;
    std::vector<FrameWindow> windows; // of each frame; empty if a file does not tell them
    std::vector<Place> places;
    std::vector<toliman_fit_prediction> predictions;
    std::string name(size_t i) const; // "night1.fits: frame 3"

  private:
    std::deque<toliman_spread> spreads_; // of the predictions
};

} // namespace cli
