// Options of `encode` and `calibrate` for the files of their frames.
#pragma once
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "frames/frames_in.hpp"

namespace CLI {
class App;
}

namespace cli {

struct FrameOptions {
    // cadence: the description of --cadence.
    void add_to(CLI::App &command, const char *cadence);
    std::unique_ptr<FrameFile> open(const std::string &path) const;

    std::string dtype, shape;      // of files without header
    std::string unit;              // of FITS files: name or number of the HDU
    std::optional<double> cadence; // seconds
    std::vector<std::string> files;
};

} // namespace cli
