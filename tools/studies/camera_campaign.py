"""Three years through a real camera whose flat field, diffusion, smear, coupling and non-linearity nobody knows: are they found in the
frames themselves, and does a planet come out that is there, and none that is not? The short form: test_camera_campaign.py.

    camera_campaign.py [--sets 3] [--seed 1] [--jobs 0]

Frames of alpha Centauri on its orbit behind unknown optics, 20 nm rms of aberrations: the expected light is the library's, what the
detector makes of it is numpy's (test_camera.py), with Poisson numbers of numpy. Flat 0.5 % rms, diffusion 0.1 px, smear of the frame
transfer 1e-3 of a column in all, coupling 2e-3, non-linearity 1 % and brighter-fatter 0.005 px^2 of the brightest pixel. Each truth
has a mission with a planet of 2.6 uas at 430 d, and one without, whose frames calibrate. Models: the nominal scene, `calibrate` of 20
frames (optics), and `calibrate --detector` of all frames (all); then `track --fit`, `status` and `planet`. For each: error of the separation in the
standard deviation of a frame, which is the bound with places, fluxes and background free; chi-square; odds and verdict. Wrong, with all
calibrated: a scatter above 1.05, a mean above 0.1 and the error that the calibration states for it (all at 3 standard errors), a planet
that is not there, or none where there is one."""
# promise: detectors-are-calibrated
import json
import pathlib
import sys
import tempfile
import time

import numpy

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path += [str(ROOT / "build" / "python"), str(ROOT / "examples" / "sky")]
import campaign  # noqa: E402
import toliman  # noqa: E402
import doubt_frames  # noqa: E402
from doubt_frames import AMPLITUDE, DAYS, PERIOD, nominal, run  # noqa: E402
from truth import draw_truth  # noqa: E402

FLAT, DIFFUSION_PX, SMEAR, COUPLING, BENT, FATTER = 5e-3, 0.1, 1e-3, 2e-3, 1e-2, 5e-3
PART, CHOSEN, POINTING_PX = 16, 20, 0.7
MODELS = "nominal", "optics", "all"


def flow(values):
    """The sum over the four neighbours of a pixel of their value minus its own; nothing crosses the border."""
    padded = numpy.pad(values, 1, mode="edge")
    return padded[:-2, 1:-1] + padded[2:, 1:-1] + padded[1:-1, :-2] + padded[1:-1, 2:] - 4 * values


def scenes(seed, frames, side, photons, planet):
    """Returns the nominal scene, and the true one without its detector but for the diffusion."""
    scene = nominal(frames, side)
    scene["cadence"]["exposure_s"] *= photons / 1e12
    scene["systematics"]["pointing_rms_px"] = POINTING_PX
    scene["detector"]["pixel"] = "integrated"
    if planet:
        scene["signal"] = {"kind": "sinusoid", "star": "A", "amplitude_px": AMPLITUDE / scene["detector"]["pixel_scale_arcsec"],
                           "period_days": PERIOD, "phase_rad": 1}
    true_scene = draw_truth(scene, seed, jitter_px=0)
    true_scene["detector"]["diffusion_px"] = DIFFUSION_PX
    true_scene["noise"] = {"photon": False, "seed": seed}
    return {**scene, "signal": {"kind": "none"}}, true_scene


def detected(light, rng, response, peak):
    """The electrons that the detector reads."""
    side = light.shape[0]
    charge = light * response
    charge = rng.poisson(charge + SMEAR / side * charge.sum(axis=0)).astype(float)
    charge += FATTER / peak / 4 * flow(charge**2)
    charge += COUPLING * flow(charge)
    return charge - BENT / peak * charge**2


def write_frames(path, scene, seed):
    """Writes the frames. Returns the times (d) and the true separations (px). seed: of the noise."""
    simulator = toliman.Simulator(scene)
    response = 1 + FLAT * numpy.random.default_rng([simulator.info.seed, 1]).normal(size=simulator.shape)
    rng, count, peak = numpy.random.default_rng([seed, 2]), simulator.info.frames, simulator.image().max()
    cube = numpy.lib.format.open_memmap(path, mode="w+", dtype=numpy.float64, shape=(count, *simulator.shape))
    for first in range(0, count, PART):
        for k, light in enumerate(simulator.frames(first, min(PART, count - first)), first):
            cube[k] = detected(light, rng, response, peak)
    cube.flush()
    days, displacements = simulator.series()
    fit = toliman.Fit(simulator, capture_px=1)
    return days, numpy.array([fit.predict(time_days=day)[1][0] for day in days]) + displacements


def models(folder, scene, names):
    """Yields (name, file, seconds, standard deviation of the mean separation in that of a frame) of each model."""
    path, frames, clock = folder / "nominal.json", folder / "frames0.npy", time.monotonic
    path.write_text(json.dumps(scene))
    for name in names:
        start = clock()
        out = path if name == "nominal" else folder / f"{name}.json"
        if name != "nominal":
            run("calibrate", path, frames, "--out", out, *(("--detector",) if name == "all" else ("--choose", CHOSEN)))
        seconds, stated = clock() - start, 0.0
        if name != "nominal":
            said = json.loads((folder / f"{name}.calibration.json").read_text())
            stated = said["calibration_sigma_px"] / said["separation_sigma_px"]
        yield name, out, seconds, stated


def row(first, error, stated, chi_square, said, seconds):
    """Returns the row of the table."""
    line = f"{first} {error.mean():.3g} | {stated:.2g} | {error.std(ddof=1):.3g} | {numpy.median(chi_square):.5g} |"
    if not said["candidates"]:
        return f"{line} | | no frame is accepted | {seconds:.0f} |"
    best = said["candidates"][0]
    return (f"{line} {best['log10_bayes']:.3g} | {best['period'][1]:.0f} | {best['verdict']}{': ' if best['reasons'] else ''}"
            f"{'; '.join(best['reasons'])} | {seconds:.0f} |")


def misses(ours, name, planet, error, stated, said):
    """Returns what is wrong."""
    wrong, found = [], said["planets"]
    low, period, high = said["candidates"][0]["period"] if found else (0, PERIOD, 0)
    if found > planet or name == "all" and found != planet or abs(period - PERIOD) > 1.5 * (high - low):
        wrong.append(f"{ours}: {found} planets")
    noise = error.size**-0.5
    if name == "all" and (error.std(ddof=1) > 1.05 + 1.5 * noise or abs(error.mean()) > 0.1 + 3 * numpy.hypot(noise, stated)):
        wrong.append(f"{ours}: mean {error.mean():.3g}, scatter {error.std(ddof=1):.3g} of the bound")
    return wrong


def measured(model, days, path):
    """Returns separations, their standard deviations and chi-squares of all frames."""
    fit, cube = toliman.Fit(toliman.Simulator(model)), numpy.load(path, mmap_mode="r")
    found = [fit.frames(cube[k:k + PART], times_days=days[k:k + PART]) for k in range(0, len(cube), PART)]
    return [numpy.concatenate([part[key] for part in found]) for key in ("separation_px", "separation_sigma_px", "chi_square")]


def planets(model, frames, path, state):
    """Returns what `planet` says of the frames, after `track`."""
    run("track", "--fit", model, "--state", state, "--cadence", DAYS / frames * 86400, "--mission-days", DAYS, "--sync", "none", path)
    if not json.loads(run("status", state, "--json")[0])["accepted"]:
        return {"planets": 0, "candidates": []}
    return json.loads(run("planet", state, "--star-masses", "1.0788,0.9092", "--parallax", 750.81, "--json")[0])


def truth(task):
    """Returns the rows of a truth, and what is wrong in them. The frames without a planet calibrate."""
    seed, frames, side, photons, names = task
    rows, wrong = [], []
    with tempfile.TemporaryDirectory() as name:
        folder, series = pathlib.Path(name), {}
        for planet in False, True:
            scene, true_scene = scenes(seed, frames, side, photons, planet)
            series[planet] = write_frames(folder / f"frames{planet:d}.npy", true_scene, 2 * seed + planet)
        for name, model, seconds, stated in models(folder, scene, names):
            for planet, (days, true) in series.items():
                path = folder / f"frames{planet:d}.npy"
                separation, sigma, chi_square = measured(model, days, path)
                error, said = (separation - true) / sigma, planets(model, frames, path, folder / f"{name}{planet:d}")
                rows.append(row(f"| {seed} | {name} | {'2.6 uas, 430 d' if planet else 'none'} |", error, stated, chi_square, said,
                                seconds))
                wrong += misses(f"seed {seed}, {name}, {'planet' if planet else 'no planet'}", name, planet, error, stated, said)
    return rows, wrong


def missions(pool, seeds, frames=281, side=256, photons=1e12, names=MODELS):
    """Prints the table. Returns what is wrong in it."""
    print("| truth | calibrated | planet | mean error, sigma | stated | scatter, sigma | chi-square | log10 Bayes | period, d | verdict | calibrate, s |\n"
          "|---|---|---|---|---|---|---|---|---|---|---|", flush=True)
    all_wrong = []
    for rows, wrong in pool.imap(truth, [(seed, frames, side, photons, names) for seed in seeds]):
        print("\n".join(rows), flush=True)
        all_wrong += wrong
    return all_wrong


if __name__ == "__main__":
    sys.exit(campaign.run(__doc__, {"missions": lambda pool, given: missions(pool, range(given.seed, given.seed + given.sets))}, 3,
                          "number of truths"))
