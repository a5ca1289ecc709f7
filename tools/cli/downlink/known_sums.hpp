// Sums of `coadd` among the inputs of a new state folder, which needs to know their noise.
#pragma once
#include "common/common.hpp"

namespace cli {

struct KnownSums {
    // Reads the side files of pairs, and folders of them, as far as their frames are sums.
    explicit KnownSums(const std::vector<std::string> &inputs);
    bool waits = true;                     // there are pairs at most, and none has a line yet
    std::optional<toliman_spread> largest; // of the sum of the most frames; nothing for single frames
};

// Standard deviation, px, of the separation that a fit finds in a sum with this spread.
double sigma_of(const toliman_fit *fit, const toliman_spread &spread);

} // namespace cli
