#include "scenes/star_data.hpp"

#include <toliman/toliman.hpp>

#include "common/library.hpp"

namespace cli {

StarData stars_of(const std::string &system) {
    const auto sky = toliman::make<toliman::sky_predictor>(toliman_sky_create, system.c_str(), nullptr);
    const auto info = toliman::result<toliman_sky_info>(toliman_sky_get_info, sky.get());
    return {info.parallax_arcsec, {info.star_mass[0], info.star_mass[1]}};
}

} // namespace cli
