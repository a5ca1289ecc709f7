"""Images blurred by jitter against quadrature, over scale, width, covariance, band and accuracy. The short form:
test_blur_campaign.py.

    blur_campaign.py [blurs] [--jobs 0]

The blurred image is the integral of shifted images over the Gaussian. The reference is its trapezoidal sum over shifts by
1/n px on a grid to 8.5 standard deviations, from one image without jitter with n x n samples per pixel: its error is
exp(-2 pi^2 sigma^2 (n - f_c)^2), f_c in cycles per pixel, below 1e-14. Pixels that integrate average the Gaussian in
Gauss-Legendre nodes.

Prints for each width the largest error, relative to the peak, its largest ratio to the stated error, and the darkest pixel.
Wrong: an error above the stated one, or negative light beyond it."""
import itertools
import math
import pathlib
import sys

import numpy

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT / "build" / "python"))
import campaign  # noqa: E402
import toliman  # noqa: E402

SIDE, CUT, STAR = 16, 8.5, (1.3, -0.6)
SCALES = (0.1, 0.2, 0.375, 0.8, 1.6)  # arcsec per px: 0.1 to 1.8 cycles per px
SIGMAS = (0.3, 0.45, 0.6, 0.8, 1, 1.5, 2.25, 3, 4, 5, 6, 8, 10)  # px
SHAPES = ((1, 1, 0), (1, 0.5, 0.4), (0.7, 1, -0.9))  # of the standard deviations along x and y, and their correlation
BANDS = ((600, 600), (530, 640))  # nm
ACCURACIES = (1e-3, 1e-6, 1e-9, 1e-11)
MOST = 4  # arcsec, of a blur with a covariance, whose filters take seconds beyond
REFERENCE = 2e-12  # error of the reference


def cutoff_of(scale, band):
    """Cycles per pixel."""
    return 0.125 * math.radians(scale / 3600) / (band[0] * 1e-9)


def scene_of(scale, n, band, accuracy, pixel, side, samples):
    """With n x n samples of the image per pixel, side x side of them, and samples x samples of the pupil."""
    return {
        "schema": "toliman-scene/1", "name": "blur",
        "telescope": {"aperture_m": 0.125, "secondary_m": 0.03, "pupil_samples": samples,
                      "mask": {"kind": "spiral", "edges": "cell", "opd_nm": 275, "terms": [{"a": 1, "f": 2, "m": 3, "p": 1}]}},
        "band": {"wavelength_nm": band[0]} if band[0] == band[1] else {"min_nm": band[0], "max_nm": band[1], "step_nm": 10},
        "stars": {"A": {"spectrum": {"kind": "blackbody", "temperature_k": 5790}, "photons_per_s": 1e6}},
        "binary": {"offsets_px": {"A": [n * x for x in STAR]}},
        "cadence": {"frames": 1, "exposure_s": 1},
        "detector": {"shape": [side, side], "pixel_scale_arcsec": scale / n, "pixel": pixel},
        "noise": {"photon": False}, "accuracy": accuracy,
    }


def kernel_of(shifts, covariance, nodes):
    """The density of a Gaussian [y][x], averaged over a pixel about each shift in `nodes` Gauss-Legendre nodes along each axis;
    1: not averaged."""
    places, weights = numpy.polynomial.legendre.leggauss(nodes)
    inverse, kernel = numpy.linalg.inv(covariance), 0
    for (u, a), (v, b) in itertools.product(zip(places / 2, weights / 2), repeat=2):
        x, y = shifts - u, (shifts - v)[:, None]
        kernel = kernel + a * b * numpy.exp(-0.5 * (inverse[0, 0] * x * x + inverse[1, 1] * y * y) - inverse[0, 1] * x * y)
    return kernel / (2 * math.pi * math.sqrt(numpy.linalg.det(covariance)))


def reference(scale, band, covariance, pixel, samples):
    """The blurred image [SIDE][SIDE]."""
    narrow, wide = numpy.sqrt(numpy.linalg.eigvalsh(covariance))
    n = math.ceil(cutoff_of(scale, band) + 1.4 / narrow)
    n += n % 2 == 0  # a sample at the centre of each pixel
    integrated = pixel == "integrated"
    margin = math.ceil((CUT * wide + integrated / 2) * n)
    side = SIDE * n - (n - 1) + 2 * margin
    image = toliman.Simulator(scene_of(scale, n, band, 1e-12, "point", side, samples)).image()
    kernel = kernel_of(numpy.arange(-margin, margin + 1) / n, covariance, (32 if narrow < 0.6 else 10) if integrated else 1)
    inside = slice(margin, side - margin, n)
    return convolved(image, kernel)[inside, inside]


def convolved(image, kernel):
    """The same size as the image, whose edges are too small by the kernel."""
    shape = [a + b - 1 for a, b in zip(image.shape, kernel.shape)]
    product = numpy.fft.irfft2(numpy.fft.rfft2(image, shape) * numpy.fft.rfft2(kernel, shape), shape)
    first = [k // 2 for k in kernel.shape]
    return product[first[0]:first[0] + image.shape[0], first[1]:first[1] + image.shape[1]]


def of_case(task):
    """Error of a blurred image relative to its peak, its stated error, and its darkest pixel."""
    scale, sigma, (x, y, correlation), band, pixel = task
    covariance = sigma**2 * numpy.array([[x * x, correlation * x * y], [correlation * x * y, y * y]])
    samples = 96 + int(2 * (SIDE + 2 * CUT * sigma) * cutoff_of(scale, band))  # so that the reference has no aliases
    true, found = reference(scale, band, covariance, pixel, samples), []
    for accuracy in ACCURACIES:
        scene = scene_of(scale, 1, band, accuracy, pixel, SIDE, samples)
        scene["systematics"] = {"jitter_covariance_px2": {"xx": covariance[0, 0], "yy": covariance[1, 1], "xy": covariance[0, 1]}}
        simulator = toliman.Simulator(scene)
        image, plan = simulator.image(), simulator.plan
        stated = plan.pixel_error + plan.spectrum_error + plan.rounding_error
        found.append((abs(image - true).max() / true.max(), stated, image.min() / true.max()))
    return found


def blurs(pool, sigmas=SIGMAS, scales=SCALES):
    wrong, cases = [], 0
    print("| sigma, px | cases | largest error | over the stated error, at accuracies of 1e-3 | 1e-6 | 1e-9 | 1e-11 | darkest pixel |\n"
          "|---|---|---|---|---|---|---|---|")
    for sigma in sigmas:
        tasks = [task for task in itertools.product(scales, [sigma], SHAPES, BANDS, ("point", "integrated"))
                 if task[0] * sigma < MOST or task[2][2] == 0]
        found = numpy.array(pool.map(of_case, tasks, chunksize=1))  # [task][accuracy][error, stated, darkest]
        ratio = found[..., 0] / (found[..., 1] + REFERENCE)
        cases += ratio.size
        print(f"| {sigma:g} | {ratio.size} | {found[..., 0].max():.2g} | {' | '.join(f'{r:.2f}' for r in ratio.max(0))} | "
              f"{found[..., 2].min():.2g} |", flush=True)
        for task, accuracy in numpy.argwhere(ratio > 1):
            wrong.append(f"{tasks[task]}, accuracy {ACCURACIES[accuracy]:g}: error {found[task, accuracy, 0]:.2g}, stated "
                         f"{found[task, accuracy, 1]:.2g}")
        for task, accuracy in numpy.argwhere(found[..., 2] < -found[..., 1] - REFERENCE):
            wrong.append(f"{tasks[task]}, accuracy {ACCURACIES[accuracy]:g}: a pixel of {found[task, accuracy, 2]:.2g} of the peak")
    print(f"\n{cases} cases")
    return wrong


if __name__ == "__main__":
    sys.exit(campaign.run(__doc__, {"blurs": lambda pool, given: blurs(pool)}))
