"""The fit of bench_fit.c in plain numpy: Gauss-Newton steps whose model images are Fourier transforms of each star,
shifted by phases. The images have a margin, since shifts wrap around. Usage: numpy_fit.py FOLDER with the files that
bench_fit wrote. Prints version, median of the processor seconds per frame, steps and errors as JSON."""
import json
import os
import sys
import time

import numpy

SIDE, WIDE, READ_E, STILL_PX, MOST_STEPS = 256, 320, 1.3, 1e-6, 20
CROP = slice((WIDE - SIDE) // 2, (WIDE + SIDE) // 2)
SLOPES = 2j * numpy.pi * numpy.fft.rfftfreq(WIDE), 2j * numpy.pi * numpy.fft.fftfreq(WIDE)[:, None]  # by x, y
# Transforms of real images have no slope at the highest frequency.
SLOPES[0][-1] = SLOPES[1][WIDE // 2] = 0


def shifted(transform, shift):
    """A star's image and its derivatives by x and y."""
    moved = transform * numpy.exp(-shift[0] * SLOPES[0]) * numpy.exp(-shift[1] * SLOPES[1])
    return [numpy.fft.irfft2(factor * moved)[CROP, CROP].ravel() for factor in (1, -SLOPES[0], -SLOPES[1])]


def fitted(transforms, counts, start):
    """Shifts of both stars, their covariance, and the number of steps. The parameters are the shifts, relative changes
    of both fluxes, and the background."""
    values = numpy.append(start, (0.0, 0.0, 0.0))
    for steps in range(1, MOST_STEPS + 1):
        flux = 1 + values[4:6]
        (a, a_x, a_y), (b, b_x, b_y) = (shifted(transform, values[2 * star:2 * star + 2])
                                        for star, transform in enumerate(transforms))
        model = flux[0] * a + flux[1] * b + values[6]
        slopes = numpy.stack([flux[0] * a_x, flux[0] * a_y, flux[1] * b_x, flux[1] * b_y, a, b, numpy.ones_like(a)])
        expected = numpy.maximum(model, 0) if steps > 1 else 0.5 * (numpy.maximum(model, 0) + numpy.maximum(counts, 0))
        weighted = slopes / (expected + READ_E**2)
        covariance = numpy.linalg.inv(weighted @ slopes.T)
        change = covariance @ (weighted @ (counts - model))
        values += change
        if steps > 1 and numpy.abs(change[:4]).max() < STILL_PX:
            break
    return values[:4], covariance[:4, :4], steps


def main():
    stars, frames, starts = (numpy.fromfile(os.path.join(sys.argv[1], name)).reshape(shape) for name, shape in (
        ("stars.bin", (2, WIDE, WIDE)), ("frames.bin", (-1, SIDE * SIDE)), ("starts.bin", (-1, 9))))
    transforms = numpy.fft.rfft2(stars)
    seconds, pulls, steps = [], [], []
    for counts, start in zip(frames, starts):
        shift, places, predicted = start[:4], start[4:8], start[8]
        begin = time.process_time()
        shifts, covariance, count = fitted(transforms, counts, shift)
        seconds.append(time.process_time() - begin)
        apart = (places + shifts)[2:] - (places + shifts)[:2]
        along = numpy.concatenate([-apart, apart]) / numpy.hypot(*apart)
        pulls.append(abs(numpy.hypot(*apart) - predicted) / numpy.sqrt(along @ covariance @ along))
        steps.append(count)
    print(json.dumps({"name": f"numpy {numpy.__version__}, Fourier shifts", "seconds": float(numpy.median(seconds)),
                      "steps": float(numpy.median(steps)), "frames": len(frames),
                      "rms_pull": float(numpy.sqrt(numpy.mean(numpy.square(pulls)))), "largest_pull": max(pulls)}))


main()
