#include "options/duration.hpp"

#include "common/common.hpp"

#include "base/name.hpp"

namespace cli {

double seconds_of(const char *option, const std::string &text) {
    static const std::pair<const char *, double> kUnits[] = {{"min", 60}, {"h", 3600}, {"d", 86400}, {"s", 1}, {"", 1}};
    for (const auto &[unit, length] : kUnits) {
        double value;
        if (ends_with(text, unit) && number_of(text.substr(0, text.size() - std::string(unit).size()), value) &&
            value > 0)
            return value * length;
    }
    if (!text.empty())
        throw Failure(kExitUsage,
                      std::string(option) + " " + text + ": must be a time above 0 such as 90s, 10min, 1h or 1d");
    return 0;
}

std::string session_complaint(const std::string &name) {
    return toliman::is_name(name) ? ""
                                  : name + ": must be 1 to 64 characters of A-Z a-z 0-9 . _ - and not begin with a dot";
}

} // namespace cli
