// Loads the trained network of a weights file.
#pragma once
#include <string>

#include <toliman/toliman.hpp>

namespace cli {

// Throws Failure, with the type of the file if it is known, unless it is a weights file.
toliman::autoencoder load_weights(const std::string &path);

struct Network {
    // Throws Failure if the file contains an interrupted training.
    explicit Network(const std::string &path);

    toliman::autoencoder cae;
    toliman_cae_info info;
};

} // namespace cli
