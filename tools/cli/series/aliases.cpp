#include "series/aliases.hpp"

#include <algorithm>
#include <cmath>

#include "common/library.hpp"
#include "common/text.hpp"

namespace cli {

namespace {

constexpr size_t kMost = 16, kShown = 4;

bool is_slow(const toliman_period_alias &alias) {
    return alias.slow != 0 && alias.equal != 0;
}

std::string interval_text(const toliman_period_alias &alias) {
    if (alias.interval_kind == TOLIMAN_PERIOD_INTERVAL_SAMPLING)
        return formatted("the sampling interval of %.6g", alias.interval);
    const std::string name = toliman_constant_name(alias.interval_kind);
    return alias.parts > 1 ? formatted("1/%d of one ", alias.parts) + name : "one " + name;
}

std::string line_of(const toliman_period_alias &alias) {
    const std::string at = " at " + interval_text(alias);
    if (alias.slow != 0)
        return "of a change slower than the grid," + at;
    return formatted("%.6g", alias.period) + at +
           (std::isnan(alias.power) ? ", outside the grid" : formatted(", power %.6f", alias.power));
}

} // namespace

Aliases aliases_of(const toliman_period *periodogram, double frequency) {
    const auto info = toliman::result<toliman_period_info>(toliman_period_get_info, periodogram);
    const double last = info.f0 + info.df * static_cast<double>(info.nf - 1);
    if (!(frequency >= info.f0 && frequency <= last))
        return {};
    Aliases aliases(kMost, toliman::sized<toliman_period_alias>());
    size_t count = 0;
    toliman::check(toliman_period_query_aliases(periodogram, frequency, aliases.data(), kMost, &count));
    aliases.resize(count);
    return aliases;
}

std::string text_of(const Aliases &aliases) {
    std::string text;
    size_t shown = 0;
    for (const toliman_period_alias &alias : aliases)
        if (alias.equal != 0 && shown++ < kShown)
            text += "alias       " + line_of(alias) + "\n";
    return text;
}

std::vector<Json> json_of(const Aliases &aliases) {
    return array_of(aliases, [](const toliman_period_alias &alias) {
        return Json("period", alias.period, "frequency", alias.frequency, "cause",
                    toliman_constant_name(alias.interval_kind), "interval", alias.interval, "window", alias.window,
                    "power", alias.power, "equal", alias.equal != 0, "slow", alias.slow != 0);
    });
}

void warn_of_aliases(const Aliases &aliases, const std::string &hint, Progress &progress) {
    const auto alias = std::find_if(aliases.begin(), aliases.end(), is_slow);
    if (alias != aliases.end())
        progress.warn("the period may be that of the sampling: a slow change, sampled at " + interval_text(*alias) +
                      ", has this peak as an alias" + hint);
}

} // namespace cli
