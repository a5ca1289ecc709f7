// Loads the trained network of a weights file.
#pragma once
#include "common/content.hpp"

namespace cli {

// Throws Failure, with the type of the file if it is known, unless it is a weights file.
inline toliman::autoencoder load_weights(const std::string &path) {
    need(path, "toliman weights", {Content::weights});
    return toliman::make<toliman::autoencoder>(toliman_cae_load_file, path.c_str(), nullptr);
}

struct Network {
    // Throws Failure if the file contains an interrupted training.
    explicit Network(const std::string &path)
        : cae(load_weights(path)), info(toliman::result<toliman_cae_info>(toliman_cae_get_info, cae.get(), nullptr)) {
        if (info.trained == 0)
            malformed(path, "contains an interrupted training, not a trained network: continue it with `toliman train "
                            "--resume`");
    }

    toliman::autoencoder cae;
    toliman_cae_info info;
};

} // namespace cli
