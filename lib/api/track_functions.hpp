// Nuisance functions of a tracker, from its options and its folder.
#pragma once
#include <optional>

#include <toliman/track.h>

#include "api/sky_handle.hpp"
#include "track/setup.hpp"

namespace toliman::api {

using KnownSetup = std::optional<track::Setup>; // of a folder

// Status::argument for impossible values of the options.
void check_functions(const toliman_track_options &options);

// Sets basis and errors of the orbit: those of the options, else those of the folder. setup: with grid and reference.
void set_functions(const toliman_track_options &options, const KnownSetup &known, const SkySource &sky,
                   track::Setup &setup);

// Sets the options that give these functions in a new folder.
void show_functions(const period::Basis &basis, const track::OrbitErrors &errors, bool is_reduced,
                    toliman_track_options &options);

} // namespace toliman::api
