"""One image in 101 wavelengths, computed directly: two complex matrix products per wavelength. Prints the median of the
processor seconds."""
import sys
import time

import numpy


def image(n, aperture_m, pixel_rad, wavelengths_m, opd_m, amplitude, offset_px):
    x = (numpy.arange(n) - (n - 1) / 2) / n * aperture_m
    u = (numpy.arange(n) - (n - 1) / 2) * pixel_rad
    opd = opd_m + (x[None, :] * offset_px[0] + x[:, None] * offset_px[1]) * pixel_rad
    total = numpy.zeros((n, n))
    for wavelength in wavelengths_m:
        field = amplitude * numpy.exp(2j * numpy.pi / wavelength * opd)
        kernel = numpy.exp(-2j * numpy.pi / wavelength * numpy.outer(u, x))
        focal = kernel @ field @ kernel.T
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
    print(sorted(seconds)[2])


main()
