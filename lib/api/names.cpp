// include/toliman/base.h: names of constants, as in files and messages. No two of the named ones share a value, so that
// one function suffices.
#include <initializer_list>

#include <toliman/toliman.h>

#include "sky/columns.hpp"

namespace {

struct Names {
    int32_t first; // constant of the first name; the others follow
    std::initializer_list<const char *> names;
};

constexpr Names kNames[] = {
    {TOLIMAN_OK,
     {"TOLIMAN_OK", "TOLIMAN_E_INTERNAL", "TOLIMAN_E_ARGUMENT", "TOLIMAN_E_MEMORY", "TOLIMAN_E_NOT_FOUND",
      "TOLIMAN_E_FORMAT", "TOLIMAN_E_SCENE", "TOLIMAN_E_UNSUPPORTED", "TOLIMAN_E_WRITE", "TOLIMAN_E_CANCELLED",
      "TOLIMAN_E_RANGE", "TOLIMAN_E_MISMATCH", "TOLIMAN_E_CAPACITY", "TOLIMAN_E_STATE", "TOLIMAN_E_LOST"}},
    {TOLIMAN_COADD_VERDICT_ADDED, {"added", "next", "lost", "faint", "not found", "outside", "misfit"}},
    {TOLIMAN_COADD_REASON_NONE, {"none", "time", "gap", "motion", "full", "source"}},
    {TOLIMAN_GOODNESS_UNKNOWN, {"unknown", "good", "poor", "too good"}},
    {TOLIMAN_INGEST_REASON_NONE,
     {"none", "bad line", "short file", "place unknown", "clock jump", "clocks differ", "extra bytes", "overlap",
      "restart", "unknown key"}},
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

struct Flags {
    uint32_t first; // bit of the first name; the others follow
    std::initializer_list<const char *> names;
};

constexpr Flags kFlags[] = {
    {TOLIMAN_CALIBRATION_CHANGE_EDGES, {"mask edges", "pupil samples", "spectral modes", "windows", "map"}},
    {TOLIMAN_PLANET_REASON_ODDS,
     {"the odds are below the threshold", "chi-square of the fit is too good, or poor without a jitter",
      "the noise is far above the sigmas: the model lacks an effect, or times, unit or sigmas are wrong",
      "the false alarm probability contradicts the odds", "period or eccentricity is at the edge of the prior",
      "a period outside the range fits better", "the mass is not below that of the star",
      "the orbit crosses that of a more certain planet of the same star",
      "chi-square of the frames is poor: the model of the frames lacks an effect", "there are outliers",
      "the odds have not converged"}},
};

static_assert(kFlags[0].first << kFlags[0].names.size() <= kFlags[1].first);

const char *name_of_flag(uint32_t flag) noexcept {
    for (const Flags &known : kFlags)
        for (size_t i = 0; i < known.names.size(); i++)
            if (flag == known.first << i)
                return known.names.begin()[i];
    return "?";
}

} // namespace

extern "C" const char *toliman_constant_name(int32_t constant) noexcept {
    if (constant >= TOLIMAN_SKY_ELEMENT_PERIOD && constant <= TOLIMAN_SKY_ELEMENT_EPOCH)
        return toliman::sky::element_name(static_cast<size_t>(constant - TOLIMAN_SKY_ELEMENT_PERIOD));
    for (const Names &known : kNames)
        if (constant >= known.first && constant - known.first < static_cast<int32_t>(known.names.size()))
            return known.names.begin()[constant - known.first];
    return name_of_flag(static_cast<uint32_t>(constant));
}
