// Names of the forward model's parameters, to and from the caller.
#pragma once
#include <string>
#include <vector>

#include <toliman/sim_derivative.h>

#include "scene/parameter.hpp"

namespace toliman::api {

// The parameter as the caller receives it; its texts are static.
toliman_sim_parameter public_parameter(Parameter parameter);

// "; did you mean "scale"?" for the nearest name of a parameter, "" if none is near.
std::string suggestion_for(const std::string &name);

// The parameters of a list of names, separated by spaces or commas; none for NULL. Status::argument for another name
// and for one that is given twice; field: where the list is given ("options->free"). self: whether the word "self" is
// among them; NULL: the word is unknown.
std::vector<Parameter> parameters_of(const char *names, const char *field, bool *self = nullptr);

} // namespace toliman::api
