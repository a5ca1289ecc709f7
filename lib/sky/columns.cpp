// Method: the separation g of the reference orbit and the true one differ by sum of dg/de_j times the error of e_j, to
// first order, also through the factor. An error of the plate scale by a factor 1 + x changes g by x g = (dg/da) (a x):
// it is an error a x of the semi-major axis.
#include "sky/columns.hpp"

#include <cmath>

namespace toliman::sky {

const char *element_name(size_t element) noexcept {
    static const char *const names[kElements] = {"period_years", "semi_major_arcsec", "eccentricity", "inclination_deg",
                                                 "node_deg",     "periastron_deg",    "epoch"};
    return names[element];
}

std::vector<Column> error_columns(const System &system, double scale_sigma) {
    Orbit sigmas = system.sigma.orbit;
    const double axis = system.value.orbit.semi_major_arcsec;
    sigmas.semi_major_arcsec = std::hypot(sigmas.semi_major_arcsec, axis * scale_sigma);
    double bounds[kElements];
    bound_partials(system.value.orbit, bounds);
    std::vector<Column> columns;
    for (size_t i = 0; i < kElements; i++)
        if (const double sigma = sigmas.*kElementOf[i]; sigma > 0)
            columns.push_back({i, bounds[i], sigma});
    return columns;
}

} // namespace toliman::sky
