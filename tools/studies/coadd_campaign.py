"""Sums of short frames whose pointing jitters: the separation of a sum is that of one long exposure with the same jitter.

Frames are drawn with numpy: images of the scene on a wider frame, moved by Fourier transforms, which know nothing of the
library's interpolation; Poisson and read noise; cosmic rays in 1 % of the frames. Each sum is fitted with the spread that it
measured. Limits: bias below 0.05 of the bound (or twice its error, if the sums are too few to tell), scatter below 1.03 of the
bound of a long exposure with this jitter (or twice its error more), chi-square 1 within 0.01 (or twice its error).

Usage: coadd_campaign.py [--sums N] [--frames N] [--jitter PX] [--kind normal|sine|even]
"""
import argparse
import sys

import numpy

import toliman

SIDE, WIDE, BIAS, READ = 64, 160, 100, 1.3
SCENE = {
    "schema": "toliman-scene/1", "name": "frame",
    "telescope": {"aperture_m": 0.125, "secondary_m": 0.032, "struts": {"count": 3, "width_m": 0.002}, "pupil_samples": 128,
                  "mask": {"kind": "spiral", "edges": "area", "opd_nm": 292.5,
                           "terms": [{"a": 0.819, "f": 2.918, "l": 0, "m": -27, "p": 4.874},
                                     {"a": 0.93, "f": 1.829, "l": 0, "m": 25, "p": 5.967},
                                     {"a": 0.702, "f": 9.468, "l": 10.905, "m": -27, "p": 4.193}]}},
    "band": {"min_nm": 530, "max_nm": 640, "step_nm": 10},
    "stars": {"A": {"spectrum": {"kind": "blackbody", "temperature_k": 5790}, "photons_per_s": 7.27e7},
              "B": {"spectrum": {"kind": "blackbody", "temperature_k": 5260}, "photons_per_s": 2.26e7}},
    "binary": {"separation_arcsec": 9.76, "position_angle_deg": 14.5},
    "cadence": {"frames": 1, "interval_days": 1, "exposure_s": 0.005},
    "noise": {"photon": True, "read_e": READ, "seed": 1}, "accuracy": 1e-9,
}


def scene_of(side, **detector):
    return {**SCENE, "detector": {"shape": [side, side], "pixel_scale_arcsec": 0.375, "pixel": "integrated", **detector}}


class Sky:
    """Expected light of both stars at any place, by Fourier transforms of a wider image."""

    def __init__(self):
        self.spectrum = numpy.fft.rfft2(toliman.Simulator(scene_of(WIDE)).image())
        self.y, self.x = numpy.fft.fftfreq(WIDE)[:, None], numpy.fft.rfftfreq(WIDE)[None]
        self.first = (WIDE - SIDE) // 2

    def light(self, x, y):
        image = numpy.fft.irfft2(self.spectrum * numpy.exp(-2j * numpy.pi * (self.x * x + self.y * y)), (WIDE, WIDE))
        inner = slice(self.first, self.first + SIDE)
        return numpy.maximum(0, image[inner, inner])


def places(kind, count, jitter, random):
    if kind == "normal":
        return random.normal(0, jitter, (count, 2))
    if kind == "even":
        return random.uniform(-jitter * 3**0.5, jitter * 3**0.5, (count, 2))
    return jitter * 2**0.5 * numpy.sin(random.uniform(0, 2 * numpy.pi, (count, 2)))


def draw(sky, place, random):
    counts = random.poisson(sky.light(*place)) + random.normal(BIAS, READ, (SIDE, SIDE))
    if random.random() < 0.01:
        for _ in range(random.integers(1, 6)):
            counts[tuple(random.integers(0, SIDE, 2))] += 60 + random.exponential(500)
    return numpy.clip(numpy.rint(counts), 0, 4095).astype(numpy.uint16)


def one_sum(coadd, fit, sky, count, options, random):
    for k, place in enumerate(places(options.kind, count, options.jitter, random)):
        coadd.add(draw(sky, place, random), k * 10**7, exposure_s=0.005)
    taken = coadd.take()
    result, values, covariance = fit.frame(taken.counts.astype(float), time_days=0, shift=(taken.sum.x_px, taken.sum.y_px),
                                           spread=taken.spread)
    return taken, result


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--sums", type=int, default=400)
    parser.add_argument("--frames", type=int, default=250)
    parser.add_argument("--jitter", type=float, default=0.3)
    parser.add_argument("--kind", choices=("normal", "sine", "even"), default="normal")
    options = parser.parse_args()
    random = numpy.random.default_rng(options.frames)
    fit = toliman.Fit(toliman.Simulator(scene_of(SIDE, bias_dn=BIAS, gain_e_per_dn=1, bit_depth=12)), capture_px=8)
    coadd, sky = toliman.Coadd(fit), Sky()
    variance = options.jitter**2
    bound = fit.predict(spread=toliman.Spread(options.frames, variance, variance))[2][0, 0]**0.5
    found = [one_sum(coadd, fit, sky, options.frames, options, random) for _ in range(options.sums)]
    errors = numpy.array([result.displacement_px for _, result in found]) / bound
    chi_square = numpy.array([result.chi_square for _, result in found])
    n = len(errors)
    scatter = errors.std() if n > 1 else abs(errors[0])
    noise = found[0][1].chi_square_sigma / n**0.5
    left = sum(taken.sum.cosmic_rays for taken, _ in found)
    frames = sum(taken.sum.frames for taken, _ in found)
    print(f"{n} sums of {options.frames} frames, {options.kind} jitter of {options.jitter} px: {frames} added, {left} pixels left out")
    print(f"  bound {bound:.3g} px; bias {errors.mean():+.3f} +- {n**-0.5:.3f} of it, scatter {scatter:.3f} +- {(2 * n)**-0.5:.3f}")
    print(f"  chi-square {chi_square.mean():.4f} +- {noise:.4f}")
    good = (abs(errors.mean()) <= max(0.05, 2 * n**-0.5) and (n < 10 or scatter <= 1.03 + 2 * (2 * n)**-0.5)
            and abs(chi_square.mean() - 1) <= max(0.01, 2 * noise))
    sys.exit(0 if good else 1)


if __name__ == "__main__":
    main()
