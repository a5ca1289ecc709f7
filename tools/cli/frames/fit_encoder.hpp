// Encoders that follow moving stars: the fit of a scene, and its bank of networks.
#pragma once
#include <memory>
#include <optional>

#include "frames/encoder.hpp"

namespace cli {

// estimator.fit must be there. Otherwise as make_encoder.
std::unique_ptr<Encoder> make_fit_encoder(const Estimator &estimator, size_t most, const FrameClock &clock,
                                          Progress &progress);

} // namespace cli
