#include "sky/system.hpp"

#include <algorithm>

#include "sky/time.hpp"

namespace toliman::sky {

const System &alpha_cen() {
    static const System system = {
        "alpha Centauri AB",
        {{79.762, 17.4930, 0.51947, 79.2430, 205.073, 231.519, 1955.564},
         // Radial velocity: the published spectroscopic one, -22.3796 km/s, corrected by 0.0614 km/s for the stars'
         // gravity.
         {219.85892215, -60.83163195, 2019.5, -3639.95, 700.40, 750.81, -22.3182},
         {1.0788, 0.9092}},
        {{0.019, 0.0096, 0.00015, 0.0089, 0.025, 0.027, 0.015}, {0, 0, 0, 0, 0, 0.38, 0}, {0.0029, 0.0025}}};
    return system;
}

Refitted dates_of(const std::vector<int64_t> &tai_ns) {
    const auto [first, last] = std::minmax_element(tai_ns.begin(), tai_ns.end());
    const auto year = [](int64_t time) { return 2000 + terrestrial_days(time) / 365.25; };
    return {year(*first), year(*last)};
}

bool is_refitted_to(const System &system, const Refitted &dates) noexcept {
    return system.refit && system.refit->first <= dates.last && dates.first <= system.refit->last;
}

} // namespace toliman::sky
