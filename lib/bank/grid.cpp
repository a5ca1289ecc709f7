// Method: the length of the path of B relative to A, summed over short steps, is divided into equal parts; a date is
// the middle of its part. The path of an orbit is nearly straight over a part.
#include "bank/grid.hpp"

#include <algorithm>
#include <cmath>

namespace toliman::bank {

namespace {

constexpr size_t kPathSteps = 4096; // of the path; a year of an orbit of 80 years is smooth over hours

// The time at which the path has this length; between steps by proportion.
double time_at(double length, const std::vector<double> &lengths, double first, double step) {
    const auto after = std::lower_bound(lengths.begin() + 1, lengths.end() - 1, length);
    const auto before = after - 1;
    const double part = *after > *before ? (length - *before) / (*after - *before) : 0;
    return first + step * (static_cast<double>(before - lengths.begin()) + std::clamp(part, 0.0, 1.0));
}

} // namespace

std::vector<Date> dates_of(double first, double last, double spacing_px, const Difference &difference) {
    const double step = (last - first) / static_cast<double>(kPathSteps);
    std::vector<double> lengths = {0};
    std::array<double, 2> before = difference(first);
    for (size_t i = 1; i <= kPathSteps; i++) {
        const std::array<double, 2> here = difference(first + step * static_cast<double>(i));
        lengths.push_back(lengths.back() + std::hypot(here[0] - before[0], here[1] - before[1]));
        before = here;
    }
    const double total = lengths.back();
    const auto parts = static_cast<size_t>(std::fmax(1, std::ceil(total / spacing_px)));
    if (total <= 0)
        return {{0.5 * (first + last), first, last}};
    std::vector<Date> dates;
    for (size_t k = 0; k < parts; k++) {
        const auto at = [&](double part) {
            return time_at(total * part / static_cast<double>(parts), lengths, first, step);
        };
        const auto number = static_cast<double>(k);
        dates.push_back({at(number + 0.5), k == 0 ? first : at(number), k + 1 == parts ? last : at(number + 1)});
    }
    return dates;
}

} // namespace toliman::bank
