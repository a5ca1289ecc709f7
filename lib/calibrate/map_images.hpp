// What an OPD of the pupil's cells changes in the images of both stars, to first order, and the adjoint.
#pragma once
#include "calibrate/planes.hpp"

namespace toliman::calibrate {

// Samples of an image of each star, for the atlas of `Planes`.
using StarSamples = std::array<Buffer<double>, 2>;

class MapImages {
  public:
    // About the instrument of `outline`, on the samples of `planes`; both must outlive the object.
    MapImages(const optics::Outline &outline, const Planes &planes);

    // The change of the images by an OPD (m) [N][N].
    StarSamples images_of(const Buffer<double> &opd_m) const;
    // The derivative by the OPD of each cell of sum over samples of weights times images_of().
    Buffer<double> gradient_of(const StarSamples &weights) const;

  private:
    const optics::Atlas &atlas_;
    optics::Plan plan_;
    optics::Light light_;
    std::vector<std::vector<double>> spectra_;
    optics::Imager imager_;
};

} // namespace toliman::calibrate
