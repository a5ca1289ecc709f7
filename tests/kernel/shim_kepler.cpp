#include "kernels/kepler.hpp"

extern "C" double shim_kepler(double mean_anomaly, double eccentricity) {
    return toliman::kernels::kepler(mean_anomaly, eccentricity);
}
