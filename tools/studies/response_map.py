"""The response of each pixel from frames in which the stars move, and what separations lose without it.

    response_map.py [--side 256] [--frames 1000] [--photons 1e8] [--rms 5e-3] [--pattern white|structured] [--pointing 2]

A white pattern is drawn from the prior. `structured` is that plus a gradient of 1 % over the frame and columns of 0.3 %. Frames are
drawn by numpy's Poisson numbers from expected ones times the pattern; 100 others serve for the separations, which
are also measured with the true optics and response. The exit status is 1 if
a figure exceeds its limit."""
import argparse
import copy
import pathlib
import resource
import sys
import tempfile
import time

import numpy

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path += [str(ROOT / "build" / "python"), str(ROOT / "examples" / "sky"), str(ROOT / "tools" / "studies")]
import toliman  # noqa: E402
import calibration_campaign  # noqa: E402

FREE = "focus zernike_5-8 scale jitter_xx jitter_yy jitter_xy"
ABERRATIONS = {"4": 5, "5": -8, "6": 6, "7": 4, "8": -5}  # nm
OTHERS, CHOSEN, CAPTURE, CHUNK = 100, 20, 10, 50
failures = []


def check(holds, what):
    """Prints a figure with its limit."""
    print(f"  {'ok    ' if holds else 'FAILED'} {what}", flush=True)
    if not holds:
        failures.append(what)


def pattern_of(name, side, rms, random):
    """The true response [row][column]."""
    response = 1 + rms * random.standard_normal((side, side))
    if name == "structured":
        response *= 1 + 0.01 * (numpy.arange(side) / (side - 1) - 0.5)[:, None]
        response *= 1 + 3e-3 * random.standard_normal(side)
    return response


def drawn(scene, response, count, random, first=0):
    """Frames of the scene with this response, counts of each pixel."""
    expected = toliman.Simulator({**scene, "noise": {"photon": False, "seed": scene["noise"]["seed"]}})
    frames = numpy.empty((count, *response.shape), "u4")
    for k in range(0, count, CHUNK):
        part = expected.frames(first + k, min(CHUNK, count - k)) * response
        noise = scene["noise"].get("read_e", 0) * random.standard_normal(part.shape)
        frames[k:k + CHUNK] = numpy.maximum(0, numpy.rint(random.poisson(part) + noise + scene["detector"]["bias_dn"]))
    return frames


def with_detector(scene, frames, pointing):
    """The scene with a bias, so that read noise does not end at 0, and moving frames."""
    scene = copy.deepcopy(scene)
    scene["detector"]["bias_dn"] = 100
    scene["systematics"] = {**scene.get("systematics", {}), "pointing_rms_px": pointing}
    scene["cadence"] = {"frames": frames, "interval_days": 0.01, "exposure_s": scene["cadence"]["exposure_s"]}
    return scene


def calibrated(scene, frames, rms, **options):
    return toliman.calibrate(toliman.Simulator(scene), frames, detector=True, response_rms=rms, capture_px=CAPTURE, **options)


def pulls_of(found, response):
    """Errors of the response over their standard deviations, of all pixels and of those that the frames determine."""
    pulls, sigma = (found.response - response) / found.response_sigma, found.response_sigma
    return pulls, pulls[sigma < 0.7 * sigma.max()]


def separations(scene, truth, response, count, random, first):
    """Errors of the separation (px) and chi-square of other frames, with a scene or the name of its file."""
    frames = drawn(truth, response, count, random, first)
    simulator = toliman.Simulator(truth)
    times, displacements = simulator.series(first, count)
    exact = toliman.Fit(simulator, capture_px=CAPTURE)
    wanted = numpy.array([exact.predict(time_days=day)[1][0] for day in times]) + displacements
    found = toliman.Fit(toliman.Simulator(scene), capture_px=CAPTURE).frames(frames, times_days=times)
    return found["separation_px"] - wanted, found["separation_sigma_px"], found["chi_square"]


def rms(values):
    return numpy.sqrt(numpy.mean(numpy.square(values)))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for name, kind, default in (("side", int, 256), ("frames", int, 1000), ("photons", float, 1e8), ("rms", float, 5e-3),
                                ("pointing", float, 2), ("step-nm", float, 5), ("threads", int, 0)):
        parser.add_argument("--" + name, type=kind, default=default)
    parser.add_argument("--pattern", choices=("white", "structured"), default="white")
    options = parser.parse_args()
    random = numpy.random.default_rng(1)
    nominal = calibration_campaign.sky(options.photons, options.step_nm)
    nominal["detector"]["shape"] = [options.side, options.side]
    nominal = with_detector(nominal, options.frames + OTHERS, options.pointing)
    truth = copy.deepcopy(nominal)
    truth["telescope"].setdefault("aberrations", {})["zernike_rms_nm"] = ABERRATIONS
    truth["systematics"]["jitter_covariance_px2"] = {"xx": 0.01, "yy": 0.006, "xy": 0.002}
    response = pattern_of(options.pattern, options.side, options.rms, random)
    frames = drawn(truth, response, options.frames, random)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    start, used = time.monotonic(), time.process_time()
    found = calibrated(nominal, frames, options.rms, free=FREE, threads=options.threads,
                       step=lambda _, step: print(f"    {step.iteration:2d} {'response' if step.is_response else 'parameters'} "
                                                  f"{step.chi_square:.5f} {step.largest_step:.3g}, "
                                                  f"{time.monotonic() - start:.0f} s, processor {time.process_time() - used:.0f} s", flush=True))
    minutes, memory = (time.monotonic() - start) / 60, (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 1024
    print(f"{options.frames} frames of {options.side}x{options.side}: {minutes:.1f} min, {(time.process_time() - used) / 60:.1f} min of processor, {memory:.0f} MiB beyond the frames; "
          f"{found.verdict}", flush=True)
    pulls, lit = pulls_of(found, response)
    print(f"  sigma: least {found.response_sigma.min():.2e}, of {lit.size} determined pixels; {found.info.response_parameters:.0f} "
          "parameters")
    white = options.pattern == "white"
    check(not white or abs(rms(pulls) - 1) < 0.02, f"rms of (response - truth)/sigma: all {rms(pulls):.4f}, determined {rms(lit):.4f}"
          " (1 +- 0.02 if white)")
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "fitted.json"
        found.save(path)
        alone = toliman.calibrate(toliman.Simulator(nominal), frames[:CHOSEN], free=FREE, capture_px=CAPTURE)
        bare = pathlib.Path(folder) / "bare.json"
        alone.save(bare)
        numpy.save(pathlib.Path(folder) / "true.npy", response)
        exact = {**truth, "detector": {**truth["detector"], "response": str(pathlib.Path(folder) / "true.npy")}}
        for name, scene in ("with the truth", exact), ("with the response", path), ("without", bare):
            error, sigma, chi_square = separations(scene, truth, response, OTHERS, numpy.random.default_rng(2), options.frames)
            line = (f"separations {name}: mean error {error.mean():.2e} +- {rms(sigma) / OTHERS**0.5:.1e} px, scatter {error.std(ddof=1):.2e} px, sigma "
                    f"{numpy.median(sigma):.2e} px, chi-square {chi_square.mean():.3f}")
            check(name == "without" or rms(error / sigma) < 1.25 and abs(error.mean()) < 4 * rms(sigma) / OTHERS**0.5, line)
    return bool(failures)


if __name__ == "__main__":
    sys.exit(main())
