#include "ingest/unit.hpp"

#include <algorithm>
#include <cstring>
#include <map>
#include <vector>

#include "ingest/fields.hpp"

namespace toliman::ingest {

namespace {

struct Known {
    const char *name, *forms; // lower case, without blanks and punctuation other than / and -
    Quantity quantity;
    double factor;
};

constexpr double kHours = 24, kArcsecPerDegree = 3600; // of a day; arcsec
constexpr Known kUnits[] = {
    {"m/s", "m/s ms-1 m/sec msec-1 meter/second metre/second meters/second meter/s metre/s", Quantity::velocity, 1},
    {"km/s", "km/s kms-1 km/sec kmsec-1 kilometer/second kilometre/second kilometers/second", Quantity::velocity, 1e3},
    {"cm/s", "cm/s cms-1 cm/sec cmsec-1", Quantity::velocity, 1e-2},
    {"mas", "mas milliarcsec marcsec milliarcsecond milliarcseconds", Quantity::angle, 1e-3},
    {"uas",
     "uas \xc2\xb5"
     "as \xce\xbc"
     "as \xb5"
     "as muas microarcsec uarcsec microarcsecond microarcseconds",
     Quantity::angle, 1e-6}, // with the sign for micro in UTF-8 and in ISO 8859-1
    {"arcsec", "arcsec asec arcsecond arcseconds", Quantity::angle, 1},
    {"deg", "deg degree degrees", Quantity::angle, kArcsecPerDegree},
    {"px", "px pix pixel pixels", Quantity::pixels, 1},
    {"d", "d day days", Quantity::time, 1},
    {"h", "h hr hour hours hrs", Quantity::time, 1 / kHours},
    {"min", "min minute minutes", Quantity::time, 1 / (kHours * 60)},
    {"s", "s sec second seconds", Quantity::time, 1 / (kHours * 3600)},
    {"yr", "yr year years", Quantity::time, 365.25},
};

std::map<std::string, const Known *> table_of_forms() {
    std::map<std::string, const Known *> table;
    for (const Known &unit : kUnits)
        for (const std::string &form : split(unit.forms, ' '))
            table[form] = &unit;
    return table;
}

} // namespace

Unit unit_of(std::string_view text) {
    static const std::map<std::string, const Known *> table = table_of_forms();
    const std::string given = trimmed(text);
    if (is_missing(given))
        return {};
    std::string form = lower(given);
    const auto is_ignored = [](char c) { return c != '\0' && std::strchr(" \t*.^()[]{}$\\_'\"", c) != nullptr; };
    form.erase(std::remove_if(form.begin(), form.end(), is_ignored), form.end());
    const auto found = table.find(form);
    if (found == table.end())
        return {in_ascii(given), Quantity::unknown, 0};
    return {found->second->name, found->second->quantity, found->second->factor};
}

double factor_between(const Unit &from, const Unit &to) noexcept {
    if (from.name.empty() || to.name.empty() || from.name == to.name)
        return 1;
    const bool convertible = from.quantity == to.quantity && from.quantity != Quantity::unknown;
    return convertible ? from.factor / to.factor : 0;
}

} // namespace toliman::ingest
