"""Signals, masses and priors of planet.h in numpy, independent of the library."""
import math

import numpy

GM_SUN, AU, DAY = 1.32712440018e20, 149597870700.0, 86400.0  # m^3/s^2, m, s
EARTH = 3.0034893e-6  # solar masses
BETA = 0.867, 3.03  # of the eccentricity


def eccentric_anomaly(mean, e):
    """Kepler's equation by bisection and three steps of Newton."""
    mean = numpy.asarray(mean) % (2 * math.pi)
    low, high = numpy.zeros_like(mean + e), numpy.full_like(mean + e, 2 * math.pi)
    for _ in range(16):
        middle = (low + high) / 2
        is_low = middle - e * numpy.sin(middle) < mean
        low, high = numpy.where(is_low, middle, low), numpy.where(is_low, high, middle)
    found = (low + high) / 2
    for _ in range(3):
        found = found - (found - e * numpy.sin(found) - mean) / (1 - e * numpy.cos(found))
    return found


def true_anomaly(mean, e):
    """True anomaly and r/a."""
    anomaly = eccentric_anomaly(mean, e)
    return (numpy.arctan2(numpy.sqrt(1 - e * e) * numpy.sin(anomaly), numpy.cos(anomaly) - e),
            1 - e * numpy.cos(anomaly))


def places(mean, e):
    """Place in the orbit, in semi-major axes: along the line to periastron, and 90 deg further."""
    nu, r = true_anomaly(mean, e)
    return r * numpy.cos(nu), r * numpy.sin(nu)


def separation(t, period, e, periastron_deg, epoch, amplitude):
    """Signal of a separation with a fixed axis."""
    nu, r = true_anomaly(2 * math.pi * (t - epoch) / period, e)
    return amplitude * r * numpy.cos(nu + math.radians(periastron_deg))


def velocity(t, period, e, periastron_deg, epoch, amplitude):
    """Signal of a radial velocity."""
    nu, _ = true_anomaly(2 * math.pi * (t - epoch) / period, e)
    angle = math.radians(periastron_deg)
    return amplitude * (numpy.cos(nu + angle) + e * math.cos(angle))


def bases(t, angles, period, e, anomaly):
    """The four functions of a separation, whose amplitudes have Gaussian priors: along and across the mean axis."""
    x, y = places(2 * math.pi * (t - t.mean()) / period + anomaly, e)
    turned = numpy.radians(angles - angles.mean())
    return numpy.stack([x * numpy.cos(turned), -y * numpy.cos(turned), x * numpy.sin(turned), -y * numpy.sin(turned)])


def _root(function, low, high):
    for _ in range(200):
        middle = math.sqrt(low * high)
        low, high = (middle, high) if function(middle) < 0 else (low, middle)
    return math.sqrt(low * high)


def mass_of_separation(amplitude_arcsec, period_days, star, parallax_arcsec):
    """Mass in Earth masses of a planet, times g, whose star has this semi-major axis."""
    def excess(m):
        total = (star + m) * GM_SUN
        axis = (total * (period_days * DAY / (2 * math.pi))**2)**(1 / 3) / AU
        return m / (star + m) * axis * parallax_arcsec - amplitude_arcsec
    return _root(excess, 1e-15, 1e3) / EARTH


def mass_of_velocity(amplitude, period_days, e, star):
    """Mass in Earth masses of a planet, times sin i, with this semi-amplitude in m/s."""
    def excess(m):
        total = (star + m) * GM_SUN
        speed = (2 * math.pi * total / (period_days * DAY))**(1 / 3)
        return m / (star + m) * speed / math.sqrt(1 - e * e) - amplitude
    return _root(excess, 1e-15, 1e3) / EARTH


def eccentricities(count, largest=0.99):
    """`count` eccentricities and their weights under the truncated prior; uniform in e^0.867, where the density is finite."""
    a, b = BETA
    e = (largest**a * (numpy.arange(count) + 0.5) / count)**(1 / a)
    weights = (1 - e)**(b - 1)
    return e, weights / weights.sum()


def draw_eccentricity(random, largest=0.95):
    """Draws from the prior."""
    while (e := random.beta(*BETA)) > largest:
        pass
    return e


def midpoints(low, high, count):
    return low + (high - low) * (numpy.arange(count) + 0.5) / count


def log10_bayes(t, y, sigmas, scales, periods, *, largest=0.95, functions=(), angles=None, is_velocity=False, motion=None,
                counts=(100, 12, 20, 12)):
    """log10 of the Bayes factor of one planet by the midpoint rule in log period, eccentricity, mean anomaly and log
    scale of the amplitudes. sigmas: arrays of equal weight in the prior, one without jitter, each with its weight;
    functions: those of the fit after the mean, without priors. motion: with velocities of the planet's star, their size in
    the rows of velocities for a star that moves by one unit of y times one radian per unit of t, NaN in all others."""
    design = numpy.stack([numpy.ones_like(t), *functions], 1)
    period = numpy.exp(midpoints(*numpy.log(periods), counts[0]))
    e, weight = eccentricities(counts[1], largest)
    anomaly = midpoints(0, 2 * math.pi, counts[2])
    scale = numpy.exp(midpoints(*numpy.log(scales), counts[3]))
    mean = 2 * math.pi * (t - t.mean()) / period[:, None, None, None] + anomaly[:, None]
    x, y_ = places(mean, e[:, None, None])
    if is_velocity:
        nu = numpy.arctan2(y_, x)
        x, y_ = numpy.cos(nu) + e[:, None, None], numpy.sin(nu)
    signals = [x, y_]
    if angles is not None:
        turned = numpy.radians(angles - angles.mean())
        signals = [x * numpy.cos(turned), y_ * numpy.cos(turned), x * numpy.sin(turned), y_ * numpy.sin(turned)]
    if motion is not None:
        speed = 2 * math.pi / period[:, None, None, None] / numpy.sqrt(1 - e[:, None, None]**2) * numpy.nan_to_num(motion)
        nu, is_place = numpy.arctan2(y_, x), numpy.isnan(motion)
        signals = [x * is_place, y_ * is_place, speed * numpy.sin(nu), speed * (numpy.cos(nu) + e[:, None, None])]
    signals = numpy.stack(signals, -2)
    with_planet, without = [], []
    for sigma, share in sigmas:
        base = numpy.linalg.qr(design / sigma[:, None])[0]
        data = y / sigma
        data = data - base @ (base.T @ data)
        constant = math.log(share) - numpy.log(sigma).sum() - data @ data / 2
        constant -= numpy.log(numpy.abs(numpy.diag(numpy.linalg.qr(design / sigma[:, None])[1]))).sum()
        without.append(constant)
        white = signals / sigma
        white = white - (white @ base) @ base.T
        vector, matrix = white @ data, white @ numpy.swapaxes(white, -1, -2)
        values, vectors = numpy.linalg.eigh(matrix)
        squared = numpy.einsum("...ij,...i->...j", vectors, vector)[..., None, :]**2
        spread = scale[:, None]**2 * values[..., None, :]
        logs = (squared * scale[:, None]**2 / (1 + spread) / 2 - numpy.log1p(spread) / 2).sum(-1)
        top = logs.max()
        mean_likelihood = numpy.einsum("pems,e->", numpy.exp(logs - top), weight)
        with_planet.append(constant + top + math.log(mean_likelihood / (counts[0] * counts[2] * counts[3])))
    return (numpy.logaddexp.reduce(with_planet) - numpy.logaddexp.reduce(without)) / math.log(10)
