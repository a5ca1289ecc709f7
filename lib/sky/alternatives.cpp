// Axes of date: the equator and equinox precess by the angles zeta, z and theta, linear in time (IAU 1976; within 0.1
// arcsec in 30 years, 4e-5 uas). A state on axes of date is turned back to J2000.0 by Rz(zeta) Ry(-theta) Rz(z).
#include "sky/alternatives.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "base/constants.hpp"
#include "sky/orbit.hpp"

namespace toliman::sky {

namespace {

constexpr double kObliquity = 84381.448 * kArcsec;           // of the ecliptic, J2000.0
constexpr double kLeap = 37, kGpsLag = 19, kTtLead = 32.184; // s: TAI - UTC since 2017, TAI - GPS, TT - TAI

struct TimeScale {
    const char *name;
    double ahead_s; // of TAI
};
constexpr TimeScale kScales[] = {{"UTC", -kLeap}, {"GPS time", -kGpsLag}, {"TAI", 0}, {"TT", kTtLead}};
constexpr double kMostShare = 0.1; // of an offset: standard deviation at which it is still recognised
constexpr double kMostSigmas = 3;  // between an offset and its value
constexpr double kRounding = 0.05; // s, of the values in the list
constexpr size_t kMostLikely = 2;
constexpr double kHour = 3600, kDay = 86400;

Matrix product(const Matrix &a, const Matrix &b) noexcept {
    Matrix out = {};
    for (size_t i = 0; i < 3; i++)
        for (size_t j = 0; j < 3; j++)
            for (size_t k = 0; k < 3; k++)
                out[3 * i + j] += a[3 * i + k] * b[3 * k + j];
    return out;
}

// Exchanges and reversals: axis i of the ICRS is axis from[i] of the states, times sign[i].
struct Signed {
    size_t from[3];
    double sign[3];

    int moved() const noexcept { return (from[0] != 0) + (from[1] != 1) + (from[2] != 2); }
    int reversed() const noexcept { return (sign[0] < 0) + (sign[1] < 0) + (sign[2] < 0); }
    int rank() const noexcept { // simple ones first
        return moved() == 0 && reversed() == 3 ? 0 : 4 * moved() + reversed();
    }
};

std::vector<Signed> signed_axes() {
    constexpr size_t kOrders[][3] = {{0, 1, 2}, {1, 0, 2}, {0, 2, 1}, {2, 1, 0}, {1, 2, 0}, {2, 0, 1}};
    std::vector<Signed> all;
    for (const auto &order : kOrders)
        for (unsigned bits = 0; bits < 8; bits++) {
            Signed one = {{order[0], order[1], order[2]}, {1, 1, 1}};
            for (size_t i = 0; i < 3; i++)
                one.sign[i] = (bits >> i & 1) != 0 ? -1 : 1;
            if (one.moved() + one.reversed() > 0)
                all.push_back(one);
        }
    std::stable_sort(all.begin(), all.end(), [](const Signed &a, const Signed &b) { return a.rank() < b.rank(); });
    return all;
}

std::string text_of(const Signed &axes) {
    constexpr char kNames[] = "xyz";
    std::string reversed, exchanged, given;
    for (size_t i = 0; i < 3; i++) {
        const std::string name(1, kNames[i]), from(1, kNames[axes.from[i]]);
        if (axes.sign[i] < 0)
            reversed += (reversed.empty() ? "" : " and ") + name;
        if (axes.from[i] != i)
            exchanged += (exchanged.empty() ? "" : " and ") + name;
        given += (i == 0 ? "" : ", ") + std::string(axes.sign[i] < 0 ? "-" : "") + from;
    }
    if (axes.moved() == 0)
        return axes.reversed() == 3
                   ? "all signs of the observer's states are reversed"
                   : reversed + " of the observer's states " + (axes.reversed() == 1 ? "is" : "are") + " reversed";
    if (axes.moved() == 2 && axes.reversed() == 0)
        return exchanged + " of the observer's states are exchanged";
    return "(x, y, z) should be (" + given + ") of the observer's states";
}

struct Offset {
    double late_s;
    std::string text;
};

std::vector<Offset> known_offsets(double exposure_s) {
    std::vector<Offset> offsets;
    for (const TimeScale &given : kScales)
        for (const TimeScale &read : kScales)
            if (&given != &read)
                offsets.push_back(
                    {given.ahead_s - read.ahead_s, std::string(given.name) + " taken for " + std::string(read.name)});
    if (exposure_s > 0) {
        offsets.push_back({-exposure_s / 2, "starts of exposures taken for their middles"});
        offsets.push_back({exposure_s / 2, "ends of exposures taken for their middles"});
        offsets.push_back({-exposure_s, "starts of exposures taken for their ends"});
        offsets.push_back({exposure_s, "ends of exposures taken for their starts"});
    }
    for (const double sign : {-1.0, 1.0}) {
        offsets.push_back({sign, "a leap second"});
        for (double hours = 0.5; hours <= 14; hours += 0.5)
            offsets.push_back({sign * hours * kHour,
                               hours == 12 ? "half a day lost between MJD and JD" : "local time taken for UTC"});
        offsets.push_back({sign * kDay, "the day before or after"});
    }
    return offsets;
}

} // namespace

Matrix rotation(size_t axis, double radians) noexcept {
    const size_t a = (axis + 1) % 3, b = (axis + 2) % 3;
    Matrix out = kSameAxes;
    out[3 * a + a] = out[3 * b + b] = std::cos(radians);
    out[3 * b + a] = std::sin(radians);
    out[3 * a + b] = -out[3 * b + a];
    return out;
}

std::vector<Axes> wrong_axes(double days) {
    std::vector<Axes> all;
    for (const Signed &axes : signed_axes()) {
        Matrix matrix = {};
        for (size_t i = 0; i < 3; i++)
            matrix[3 * i + axes.from[i]] = axes.sign[i];
        all.push_back({matrix, text_of(axes)});
    }
    all.push_back({rotation(0, kObliquity), "the observer's states have the axes of the ecliptic"});
    const double centuries = days / (100 * kDaysPerYear);
    const double zeta = 2306.2181 * centuries * kArcsec, theta = 2004.3109 * centuries * kArcsec;
    // Axes turn against vectors: Rz(a) of axes is rotation(2, -a) of vectors.
    const Matrix back = product(product(rotation(2, -zeta), rotation(1, theta)), rotation(2, -zeta));
    all.push_back({back, "the observer's states have the axes of date"});
    return all;
}

std::string mistake_of(double late_s, double sigma_s, double exposure_s) {
    std::vector<Offset> likely;
    for (const Offset &offset : known_offsets(exposure_s))
        if (sigma_s <= kMostShare * std::fabs(offset.late_s) &&
            std::fabs(offset.late_s - late_s) <= kMostSigmas * sigma_s + kRounding)
            likely.push_back(offset);
    const auto nearer = [&](const Offset &a, const Offset &b) {
        return std::fabs(a.late_s - late_s) < std::fabs(b.late_s - late_s);
    };
    std::stable_sort(likely.begin(), likely.end(), nearer);
    std::string text;
    for (size_t i = 0; i < std::min(likely.size(), kMostLikely); i++)
        text += (i == 0 ? "" : ", or ") + likely[i].text;
    return text;
}

} // namespace toliman::sky
