// Method: ERFA's series for the Earth takes 50 us. Its states at whole days are therefore kept, and interpolated by
// Lagrange's polynomial through the eight nearest. The error is that of the Moon's pull on the Earth, 12.5 m/s with a
// period of 27 days: less than 1e-6 m/s, 4e-8 uas. Memory: 100 bytes per day. They do not depend on system or observer:
// all objects of the process share them, and the last one frees them.
#include "sky/earth.hpp"

#include <array>
#include <cmath>

namespace toliman::sky {

namespace {

constexpr int kGridPoints = 8;

// Weights of the values at 0, 1, ..., 7 for the value at `x`.
std::array<double, kGridPoints> weights_at(double x) noexcept {
    std::array<double, kGridPoints> weights;
    for (int i = 0; i < kGridPoints; i++) {
        weights[static_cast<size_t>(i)] = 1;
        for (int j = 0; j < kGridPoints; j++)
            if (j != i)
                weights[static_cast<size_t>(i)] *= (x - j) / (i - j);
    }
    return weights;
}

void add(double weight, const erfa::Vector &from, erfa::Vector &to) noexcept {
    for (size_t k = 0; k < 3; k++)
        to[k] += weight * from[k];
}

std::mutex sharing;
const Earth *current = nullptr; // under the lock

void destroy(const Earth *earth) noexcept {
    const std::lock_guard<std::mutex> lock(sharing);
    if (current == earth)
        current = nullptr;
    delete earth;
}

std::shared_ptr<const Earth> living() {
    const std::lock_guard<std::mutex> lock(sharing);
    return current == nullptr ? nullptr : current->weak_from_this().lock(); // null while another thread destroys it
}

} // namespace

std::shared_ptr<const Earth> Earth::shared() {
    std::shared_ptr<const Earth> earth = living();
    if (earth == nullptr) {
        earth.reset(new Earth, destroy); // without the lock, which `destroy` takes if memory is short
        const std::lock_guard<std::mutex> lock(sharing);
        current = earth.get();
    }
    return earth;
}

const Earth::State &Earth::day(int64_t number) const {
    const auto [place, added] = days_.try_emplace(number);
    if (added) {
        const auto days = static_cast<double>(number);
        const double shift = erfa::tdb_minus_tt(days);
        place->second = {erfa::earth_state(days + shift / 86400), shift};
    }
    return place->second;
}

Earth::State Earth::at(double days) const {
    const double whole = std::floor(days);
    const int64_t first = static_cast<int64_t>(whole) - (kGridPoints / 2 - 1);
    const auto weights = weights_at(days - static_cast<double>(first));
    State sum = {};
    const std::lock_guard<std::mutex> lock(mutex_);
    for (int i = 0; i < kGridPoints; i++) {
        const State &state = day(first + i);
        const double weight = weights[static_cast<size_t>(i)];
        add(weight, state.earth.from_sun, sum.earth.from_sun);
        add(weight, state.earth.from_barycentre, sum.earth.from_barycentre);
        add(weight, state.earth.velocity, sum.earth.velocity);
        sum.tdb_minus_tt += weight * state.tdb_minus_tt;
    }
    return sum;
}

} // namespace toliman::sky
