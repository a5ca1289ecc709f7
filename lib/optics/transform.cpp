// Phases are formed in long double and reduced before they become double: many cycles would cost their last digits.
#include "optics/transform.hpp"

#include <cmath>

namespace toliman::optics {

void tilt(long double step, Buffer<double> &cycles) noexcept {
    const long double centre = 0.5L * static_cast<long double>(cycles.size() - 1);
    for (size_t i = 0; i < cycles.size(); i++) {
        const long double phase = (static_cast<long double>(i) - centre) * step;
        cycles[i] = static_cast<double>(phase - std::rint(phase));
    }
}

} // namespace toliman::optics
