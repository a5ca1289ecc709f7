// Options of `encode` and `calibrate` for the files of their frames.
#pragma once
#include "frames/frames_in.hpp"

namespace cli {

struct FrameOptions {
    void add_to(CLI::App &command);
    // Files and those of folders. Throws Failure for pairs of several regions without --roi.
    std::vector<std::string> inputs() const;
    // exposure_s: of the scene, for raw pairs and batches; 0: unknown.
    std::unique_ptr<FrameFile> open(const std::string &path, double exposure_s) const;

    std::string dtype, shape;         // of files without header
    std::string stamp;                // of raw pairs: one of kStamps; empty: start
    std::string roi;                  // of raw pairs; empty: the only one
    std::optional<double> exposure_s; // of raw pairs and batches; otherwise that of the scene
    std::string unit;                 // of FITS files: name or number of the HDU
    std::optional<double> cadence;    // seconds
    std::vector<std::string> files;
};

} // namespace cli
