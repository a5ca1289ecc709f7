// Options of `track` for its state folder and estimator, and the tracker that they describe.
#pragma once
#include "downlink/realigner.hpp"
#include "downlink/setup_options.hpp"
#include "downlink/state_folder.hpp"
#include "frames/estimator.hpp"

namespace cli {

struct FolderOptions {
    void add_to(CLI::App &command);
    void check() const; // of what needs no file
    // Whether the folder will take the noise of `sums`, if frames are some.
    bool needs_sigma() const;
    // Whether the folder will take the bit depth of the pixel type, TOLIMAN_PIXEL_..., of the first pair.
    bool needs_pixel() const;
    // Makes the estimator, then opens the folder, or creates it, for frames of the pixel type `dtype`, "" if it is not
    // given.
    toliman::tracker open(const std::string &dtype, Estimator &estimator, Progress &progress);

    EstimatorOptions estimator_options;
    std::string folder, sync = "group", crop, shape;
    SetupOptions setup;
    ReferenceOptions reference;
    std::optional<double> value_limit, sigma;
    std::optional<toliman_spread> sums; // of the largest one
    std::optional<uint32_t> bit_depth;
    int32_t pixel = 0; // of the first pair; 0: none
    std::optional<int64_t> bin, capacity;
    unsigned jobs = 1;
    bool has_stamps = false; // pairs or batches, whose frames have stamps of the camera
    // After open():
    bool is_new = false; // the folder
    Notes notes;         // options that differ from the scene
    Realigner realigner; // of the tracker
};

} // namespace cli
