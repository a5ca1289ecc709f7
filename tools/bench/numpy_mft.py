"""One image in 101 wavelengths, computed directly: two complex matrix products per wavelength (Soummer et al. 2007,
Optics Express 15, 15935). The offset of the star is in the kernels, and phases are computed as cosine and sine, which
numpy vectorises, unlike its complex exponential. Prints version and median of the processor seconds as JSON."""
import json
import sys
import time

import numpy


def phasor(phase):
    out = numpy.empty(phase.shape, complex)
    numpy.cos(phase, out=out.real)
    numpy.sin(phase, out=out.imag)
    return out


def image(n, aperture_m, pixel_rad, wavelengths_m, opd_m, amplitude, offset_px):
    x = (numpy.arange(n) - (n - 1) / 2) / n * aperture_m
    u = (numpy.arange(n) - (n - 1) / 2) * pixel_rad
    columns, rows = (numpy.outer(u - offset * pixel_rad, x) for offset in offset_px)
    total = numpy.zeros((n, n))
    for wavelength in wavelengths_m:
        turn = 2 * numpy.pi / wavelength
        field = phasor(turn * opd_m) * amplitude
        focal = phasor(-turn * rows) @ field @ phasor(-turn * columns).T
        total += focal.real**2 + focal.imag**2
    return total


def main():
    pixel_arcsec, min_nm = float(sys.argv[1]), float(sys.argv[2])
    n, aperture_m = 256, 0.125
    x = (numpy.arange(n) - (n - 1) / 2) / n * 2
    r = numpy.hypot(x[None, :], x[:, None])
    amplitude = ((r < 1) & (r > 0.15)).astype(float)
    opd_m = 297.5e-9 * (numpy.cos(7 * numpy.arctan2(x[:, None], x[None, :]) + 9 * r) > 0)
    wavelengths_m = (min_nm + numpy.arange(101)) * 1e-9
    seconds = []
    for _ in range(5):
        start = time.process_time()
        image(n, aperture_m, pixel_arcsec * numpy.pi / 648000, wavelengths_m, opd_m, amplitude, (12.5, -21.7))
        seconds.append(time.process_time() - start)
    print(json.dumps({"name": f"numpy {numpy.__version__}", "seconds": sorted(seconds)[2]}))


main()
