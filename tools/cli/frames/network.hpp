// The trained network of a weights file.
#pragma once
#include <string>

#include <toliman/toliman.hpp>

namespace cli {

// A Failure says what a file is that is known to be something else.
toliman::autoencoder load_weights(const std::string &path);

// Frames of doubles without gaps, as they are encoded.
inline toliman_image plain_image(const double *frames) noexcept {
    toliman_image image = toliman::sized<toliman_image>();
    image.pixels = frames;
    return image;
}

struct Network {
    // A Failure for the file of a training that was stopped.
    explicit Network(const std::string &path);

    toliman::autoencoder cae;
    toliman_cae_info info = {};
};

} // namespace cli
