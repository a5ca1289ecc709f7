#include "frames/network.hpp"

#include "common/content.hpp"
#include "common/failure.hpp"
#include "common/library.hpp"

namespace cli {

toliman::autoencoder load_weights(const std::string &path) {
    need(path, "toliman weights", {Content::weights});
    return toliman::make<toliman::autoencoder>(toliman_cae_load_file, path.c_str(), nullptr);
}

Network::Network(const std::string &path)
    : cae(load_weights(path)), info(info_from<toliman_cae_info>(toliman_cae_get_info, cae.get())) {
    if (info.trained == 0)
        malformed(path, "contains an interrupted training, not a trained network: continue it with `toliman train "
                        "--resume`");
}

} // namespace cli
