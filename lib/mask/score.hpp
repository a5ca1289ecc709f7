// The figures of merit of a mask, and the simpler scenes that rank masks like the given one in less time.
#pragma once
#include <limits>

#include "optics/simulator.hpp"

namespace toliman::mask {

struct Score {
    double crb_px = std::numeric_limits<double>::infinity();       // Cramer-Rao bound of the separation
    double peak_to_mean = std::numeric_limits<double>::infinity(); // of the noise-free frame
    double light_in_frame = 0;                                     // fraction of the stars' photons
    double gradient_energy = 0; // px^-2 (optics/information.hpp), where it is asked for
};

// Of the scene with these images and this light, and with these nuisances free.
Score score_of(const optics::Images &images, const optics::Light &light, const std::vector<Parameter> &free = {});

// Simulates the scene with another mask on one thread; may be called from several threads at once.
Score score_of(Scene scene, const Mask &mask, const std::vector<Parameter> &free = {});

// The same with the gradient energy.
Score full_score_of(Scene scene, const Mask &mask, const std::vector<Parameter> &free = {});

// The scene with a signal of amplitude 0, which is faster to simulate: the bound does not depend on the amplitude.
Scene without_signal(Scene scene);

// A coarse scene, which ranks masks nearly alike in a fraction of the time: few wavelengths and, if it can be simulated
// with the mask `trial`, half the pupil samples.
Scene coarse(Scene scene, const Mask &trial);

} // namespace toliman::mask
