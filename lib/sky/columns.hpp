// Errors of the orbital elements as nuisance functions of reduced separations.
#pragma once
#include <cstddef>
#include <vector>

#include "sky/system.hpp"

namespace toliman::sky {

// The partial derivative of the separation by an element, whose coefficient is the error of the element.
struct Column {
    size_t element;
    double bound; // of its absolute values, arcsec per unit of the element
    double sigma; // standard deviation of the error
};

// The name of an element, with its unit, in the order of kElementOf.
const char *element_name(size_t element) noexcept;

// Those of the elements with a standard deviation. scale_sigma: standard deviation of the relative error of the plate
// scale.
std::vector<Column> error_columns(const System &system, double scale_sigma);

} // namespace toliman::sky
