// Method: with the distance r towards the true anomaly nu, in units of the semi-major axis, x = r cos nu and
// y = r sin nu, the coordinate along an axis is
//     alpha r cos(nu + w) = c_0 x + c_1 y,    c_0 = alpha cos w,    c_1 = -alpha sin w;
// of a velocity K (cos(nu + w) + e cos w) with x = cos nu + e and y = sin nu. If the position angle of the axis is the
// mean plus d, the coordinate is cos d times that along the mean axis plus sin d times that across: the four
// amplitudes are the Thiele-Innes constants in the frame of the mean axis. Those of the coordinate away from the
// observer are the other two of the three rows of the same matrix.
#include "planet/signal.hpp"

#include <algorithm>
#include <cmath>

#include "base/constants.hpp"
#include "kernels/kepler_rows.hpp"

namespace toliman::planet {

namespace {

void set_plane(bool velocity, const Orbit &orbit, const double *t, size_t n, double *x, double *y) noexcept {
    const kernels::KeplerKernels &kernel = kernels::kepler_kernels();
    (velocity ? kernel.velocity : kernel.position)({orbit.frequency, orbit.anomaly, orbit.eccentricity}, t, n, x, y);
}

// The motion away from the observer, in the rows of the velocities of the orbit's star: with the motion
// g = 2 pi f/sqrt(1 - e^2), dx/dt = -g sin nu and dy/dt = g (cos nu + e). The separation follows the planet of A, whose
// star moves the other way, and star B.
void set_motion(const Series &series, const Orbit &orbit, double *x, double *y) noexcept {
    const double g =
        (orbit.star == 0 ? -1 : 1) * 2 * kPi * orbit.frequency / std::sqrt(1 - orbit.eccentricity * orbit.eccentricity);
    set_plane(true, orbit, series.t.data(), series.rows, y, x);
    const double *const motion = series.motion[orbit.star].data();
    for (size_t i = 0; i < series.rows; i++) {
        x[i] *= -g * motion[i];
        y[i] *= g * motion[i];
    }
}

} // namespace

void set_shapes(const Series &series, const Orbit &orbit, double *shapes) noexcept {
    const size_t rows = series.rows;
    double *const x = shapes, *const y = shapes + rows;
    set_plane(series.velocity, orbit, series.t.data(), rows, x, y);
    if (series.has_velocities()) {
        std::fill(x + series.primary, x + rows, 0.0);
        std::fill(y + series.primary, y + rows, 0.0);
        double *const away = shapes + (series.amplitudes() - 2) * rows;
        set_motion(series, orbit, away, away + rows);
    }
    if (series.axis_cosine.empty())
        return;
    double *const across_x = shapes + 2 * rows, *const across_y = shapes + 3 * rows;
    const double *const cosine = series.axis_cosine.data(), *const sine = series.axis_sine.data();
    for (size_t i = 0; i < rows; i++) {
        across_x[i] = sine[i] * x[i];
        across_y[i] = sine[i] * y[i];
        x[i] *= cosine[i];
        y[i] *= cosine[i];
    }
}

std::vector<Function> shape_functions(const Series &series, const Orbit &orbit) {
    Buffer<double> shapes(series.amplitudes() * series.rows);
    set_shapes(series, orbit, shapes.data());
    std::vector<Function> functions(series.amplitudes());
    for (size_t j = 0; j < functions.size(); j++) {
        const auto first = shapes.begin() + static_cast<std::ptrdiff_t>(j * series.rows);
        functions[j].values.assign(first, first + static_cast<std::ptrdiff_t>(series.rows));
    }
    return functions;
}

Buffer<double> signal_at(const Series &series, const Planet &planet, const double *t, const double *position_angle_deg,
                         size_t n) {
    Buffer<double> times(n), x(n), y(n), signal(n);
    for (size_t i = 0; i < n; i++)
        times[i] = t[i] - series.time_reference;
    set_plane(series.velocity, planet.orbit, times.data(), n, x.data(), y.data());
    const Amplitudes &c = planet.amplitudes;
    for (size_t i = 0; i < n; i++) {
        const double angle = position_angle_deg != nullptr ? position_angle_deg[i] * (kPi / 180) - series.axis : 0,
                     off = std::remainder(angle, 2 * kPi);
        signal[i] = std::cos(off) * (c[0] * x[i] + c[1] * y[i]);
        if (!series.axis_cosine.empty())
            signal[i] += std::sin(off) * (c[2] * x[i] + c[3] * y[i]);
    }
    return signal;
}

Buffer<double> signal_of(const Series &series, const Planet &planet) {
    Buffer<double> shapes(series.amplitudes() * series.rows), signal(series.rows, 0.0);
    set_shapes(series, planet.orbit, shapes.data());
    for (size_t j = 0; j < series.amplitudes(); j++)
        for (size_t i = 0; i < series.n; i++)
            signal[i] += planet.amplitudes[j] * shapes[j * series.rows + i];
    return signal;
}

double amplitude_of(const Amplitudes &amplitudes) noexcept {
    return std::hypot(amplitudes[0], amplitudes[1]);
}

double periastron_of(const Amplitudes &amplitudes) noexcept {
    return std::atan2(-amplitudes[1], amplitudes[0]);
}

} // namespace toliman::planet
