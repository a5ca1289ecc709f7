// include/toliman/base.h: names of the constants of enumerations, as in files and messages. No two enumerations share a
// value, so that one function suffices.
#include <initializer_list>

#include <toliman/toliman.h>

namespace {

struct Names {
    int32_t first; // constant of the first name; the others follow
    std::initializer_list<const char *> names;
};

constexpr Names kNames[] = {
    {TOLIMAN_GOODNESS_UNKNOWN, {"unknown", "good", "poor", "too good"}},
    {TOLIMAN_INGEST_REASON_NONE,
     {"none", "bad line", "short file", "place unknown", "clock jump", "clocks differ", "extra bytes", "overlap"}},
    {TOLIMAN_MEASURE_VALUE, {"value", "separation", "reduced", "velocity"}},
    {TOLIMAN_PERIOD_INTERVAL_SAMPLING, {"sampling", "solar day", "sidereal day", "year"}},
    {TOLIMAN_SIM_IMAGE_BOTH,
     {"both", "star_a", "star_b", "separation", "curvature", "shift_x", "shift_y", "variance", "roll", "scale", "focus",
      "background"}},
    {TOLIMAN_SKY_OBSERVER_EARTH, {"Earth", "circular orbit", "file"}},
    {TOLIMAN_SKY_CAUSE_NONE, {"none", "time", "axes", "rotation_x", "rotation_y", "rotation_z", "scale", "centre"}},
    {TOLIMAN_TRACK_VERDICT_ACCEPTED,
     {"accepted", "duplicate", "quarantined", "outlier", "rejected", "merged", "unreduced", "intervals", "misfit"}},
    {TOLIMAN_TRACK_REASON_NONE,
     {"none", "shape", "over range", "zero run", "not finite", "clock", "estimate", "no orbit", "no intervals"}},
};

} // namespace

extern "C" const char *toliman_constant_name(int32_t constant) noexcept {
    for (const Names &known : kNames)
        if (constant >= known.first && constant - known.first < static_cast<int32_t>(known.names.size()))
            return known.names.begin()[constant - known.first];
    return "?";
}
