#include "api/parameters.hpp"

#include <algorithm>
#include <vector>

#include "api/choice.hpp"
#include "base/error.hpp"
#include "base/nearest_word.hpp"
#include "base/words.hpp"

namespace toliman::api {

namespace {

constexpr Choice<Scope> kScopes = {TOLIMAN_SIM_SCOPE_FRAME, TOLIMAN_SIM_SCOPE_INSTRUMENT, "TOLIMAN_SIM_SCOPE_..."};

// Static texts, in the order of all_parameters().
const std::vector<std::string> &names() {
    static const std::vector<std::string> all = [] {
        std::vector<std::string> list;
        for (const Parameter parameter : all_parameters())
            list.push_back(name_of(parameter));
        return list;
    }();
    return all;
}

} // namespace

toliman_sim_parameter public_parameter(Parameter parameter) {
    const std::vector<Parameter> &all = all_parameters();
    const auto number = static_cast<size_t>(std::find(all.begin(), all.end(), parameter) - all.begin());
    return {0, kScopes.to_constant(scope_of(parameter)), names()[number].c_str(), unit_of(parameter)};
}

std::string suggestion_for(const std::string &name) {
    const std::string nearest = nearest_word(name, names());
    return nearest.empty() ? "" : "; did you mean \"" + nearest + "\"?";
}

std::vector<Parameter> parameters_of(const char *names, const char *field, bool *self) {
    std::vector<Parameter> parameters;
    for (const std::string &name : words_of(names != nullptr ? names : "")) {
        if (self != nullptr && name == "self") {
            *self = true;
            continue;
        }
        const std::optional<Parameter> parameter = parameter_named(name);
        if (!parameter)
            fail(Status::argument, "{%s}: \"%s\": must be the name of a parameter%s", field, name.substr(0, 40).c_str(),
                 suggestion_for(name).c_str());
        if (std::find(parameters.begin(), parameters.end(), *parameter) != parameters.end())
            fail(Status::argument, "{%s}: \"%s\": must be named once", field, name.c_str());
        parameters.push_back(*parameter);
    }
    return parameters;
}

} // namespace toliman::api
