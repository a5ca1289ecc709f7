"""Pushes a million samples one by one and compares the power with 40-digit arithmetic and with astropy's slow method,
at low and high frequencies, with weights, a mean far from 0 and uneven times. Usage: long_stream.py [samples]. Exits
with 1 if the power differs from the exact one by more than max(1e-12 power, 1e-14), or from astropy's by more than 1e-9
of the peak."""
# promise: long-streams-stay-exact
import pathlib
import sys

import numpy
from astropy.timeseries import LombScargle
from mpmath import mp, mpf

sys.path.append(str(pathlib.Path(__file__).resolve().parents[2] / "build" / "python"))
from toliman import Periodogram  # noqa: E402

mp.dps = 40
F0, DF, NF = 0.0013, 0.0017, 200
EXACT = (0, 97, 199)


def samples(count):
    random = numpy.random.default_rng(1)
    t = numpy.arange(count) + random.uniform(-0.3, 0.3, count)
    sigma = random.uniform(0.5, 2, count)
    y = 5 + 0.3 * numpy.sin(2 * numpy.pi * (F0 + 97 * DF) * t + 1) + sigma * random.standard_normal(count)
    return t, y, sigma


def power_of_40_digits(t, y, sigma, k):
    """Floating-mean power by Zechmeister and Kuerster (2009), eqs. 4-15."""
    phase_rate = 2 * mp.pi * (mpf(F0) + k * mpf(DF))
    w_all = ym = c = s = yy = yc = ys = cc = cs = mpf(0)
    for ti, yi, si in zip(t, y, sigma):
        w, value = 1 / mpf(si) ** 2, mpf(yi)
        cosine, sine = mp.cos_sin(phase_rate * mpf(ti))
        wy, wc, ws = w * value, w * cosine, w * sine
        w_all += w
        ym += wy
        c += wc
        s += ws
        yy += wy * value
        yc += wy * cosine
        ys += wy * sine
        cc += wc * cosine
        cs += wc * sine
    ym, c, s, yy, yc, ys, cc, cs = (x / w_all for x in (ym, c, s, yy, yc, ys, cc, cs))
    yy, yc, ys, ss = yy - ym**2, yc - ym * c, ys - ym * s, 1 - cc - s**2
    cc, cs = cc - c**2, cs - c * s
    return (ss * yc**2 + cc * ys**2 - 2 * cs * yc * ys) / (yy * (cc * ss - cs**2))


def main():
    t, y, sigma = samples(int(sys.argv[1]) if len(sys.argv) > 1 else 1000000)
    stream = Periodogram(F0, DF, NF, value_offset=5.0, sigma_floor=0.5, sigma_ceiling=2.0)
    for i in range(len(t)):
        stream.push(t[i], y[i], sigma[i])
    power = stream.power()
    exact = [power_of_40_digits(t.tolist(), y.tolist(), sigma.tolist(), k) for k in EXACT]
    differences = [float(abs(mpf(float(power[k])) - p)) for k, p in zip(EXACT, exact)]
    slow = LombScargle(t, y, sigma).power(F0 + DF * numpy.arange(NF), method="slow", assume_regular_frequency=False)
    against_astropy = float(numpy.max(numpy.abs(power - slow) / slow.max()))
    for k, p, difference in zip(EXACT, exact, differences):
        print(f"frequency {k}: power {float(p):.6g}, error {difference:.2g}, relative {difference / float(p):.2g}")
    print(f"{len(t)} samples, {NF} frequencies: difference from astropy's slow method {against_astropy:.2g} of the peak")
    good = all(difference <= max(1e-12 * p, 1e-14) for p, difference in zip(exact, differences))
    return 0 if good and against_astropy <= 1e-9 else 1


if __name__ == "__main__":
    sys.exit(main())
