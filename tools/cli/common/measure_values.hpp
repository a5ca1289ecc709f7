// What a series of the library has.
#pragma once
#include <vector>

#include <toliman/toliman.hpp>

#include "common/library.hpp"

namespace cli {

inline toliman_measure_info info_of(const toliman_measure *measure) {
    return toliman::result<toliman_measure_info>(toliman_measure_get_info, measure);
}

// Numbers of the samples, by their name in measure.h; empty if the series does not have them.
inline std::vector<double> values_of(const toliman_measure *measure, const char *name) {
    std::vector<double> values(static_cast<size_t>(info_of(measure).n));
    const toliman_status status = toliman_measure_get_values(measure, name, values.data(), values.size());
    if (status == TOLIMAN_E_NOT_FOUND)
        return {};
    toliman::check(status);
    return values;
}

} // namespace cli
