// Motion of the image within an exposure, as a weighted mean of displaced images.
#pragma once
#include <vector>

#include "scene/scene.hpp"

namespace toliman::optics {

// Displacements along a straight line, symmetric about 0: each node with at > 0 stands for -at, too, with half of the
// weight each.
struct Path {
    struct Node {
        double at, weight; // px
    };
    std::vector<Node> nodes; // none: no displacement
    double x = 1, y = 0;     // direction, a unit vector
    double error = 0;        // of the transfer function up to the cutoff
};

// The mean over the path of an image without frequencies above `cutoff` cycles per px. Empty if the length is 0.
Path path_of(const Smear &smear, double cutoff, double accuracy);

// The same with weights for the second derivative of the image along the path, whose sum is then the derivative of the
// mean by the square of the length.
Path path_of_rate(const Smear &smear, double cutoff, double accuracy);

} // namespace toliman::optics
