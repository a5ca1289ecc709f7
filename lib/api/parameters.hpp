// Names of the forward model's parameters, to and from the caller.
#pragma once
#include <string>

#include <toliman/sim_derivative.h>

#include "scene/parameter.hpp"

namespace toliman::api {

// The parameter as the caller receives it; its texts are static.
toliman_sim_parameter public_parameter(Parameter parameter);

// "; did you mean "scale"?" for the nearest name of a parameter, "" if none is near.
std::string suggestion_for(const std::string &name);

} // namespace toliman::api
