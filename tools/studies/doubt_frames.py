"""Frames of a telescope that the model does not describe: is a planet found in them that is not there? Part of doubt_campaign.py.

281 frames of 1e12 photons in three years, of the stars of alpha Centauri on their orbit, behind a spiral mask and unknown
optics; no planet. Each row adds one effect to the frames, or leaves one out of the model, which is otherwise the truth:

detector  an error of the flat field, more jitter, smear of the frame transfer, nonlinearity, charge repelled by the charge
          of a pixel (brighter-fatter), hot pixels, hits of cosmic rays, a background with a slope
model     no calibration, edges of the mask by cells, 256 for 1024 pupil samples, mid frequencies, a focus that drifts

The frames go through the commands `track --fit`, `status` and `planet`. The table has for each effect the median chi-square of a
frame, the misfits, the chi-square of the series, odds, false alarm probability and period of the best candidate, and the
verdict. Wrong is a planet that is not there, the planet of the control if it is not found, and an effect that is not said."""
import copy
import json
import os
import pathlib
import subprocess
import sys
import tempfile

import numpy

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path += [str(ROOT / "build" / "python"), str(ROOT / "examples" / "sky")]
import toliman  # noqa: E402
from truth import add_map, add_jitter, draw_truth, mid_frequencies, resolve_files  # noqa: E402

DAYS, PHOTONS, FULL_WELL = 1092.0, 1e12, 1e9
PERIOD, AMPLITUDE = 430, 2.6e-6  # of the planet of the control: d, arcsec
PART = 16  # frames in memory at once
SCENE = ROOT / "examples" / "scenes" / "mission.json"


def nominal(frames, side):
    """The scene of the mission with stars that move, as it is before any calibration."""
    scene = json.loads(SCENE.read_text())
    resolve_files(scene, SCENE.parent)
    scene["telescope"]["mask"]["edges"] = "area"
    scene["binary"] = {"orbit": "alpha-cen", "date": 2029.4, "moving": True, "centre": "barycentre"}
    scene["systematics"] = {"pointing_rms_px": 0.3, "roll_rms_deg": 0.01}
    scene["signal"] = {"kind": "none"}
    scene["detector"]["shape"] = [side, side]
    light = sum(star["detected_per_s"] for star in scene["stars"].values())
    scene["cadence"] = {"frames": frames, "interval_days": DAYS / frames, "exposure_s": PHOTONS / light}
    return scene


def flat(rms):
    def effect(frames, random, fixed):
        return frames * (1 + rms * fixed.normal(size=frames.shape[1:]))
    return effect


def smear(part):
    return lambda frames, random, fixed: frames + part * frames.mean(axis=1, keepdims=True)


def nonlinearity(part):
    return lambda frames, random, fixed: frames * (1 - part * frames / FULL_WELL)


def brighter_fatter(variance_px2):
    """Blur of each pixel's charge by a variance that is proportional to it."""
    def effect(frames, random, fixed):
        charge = 0.5 * variance_px2 / FULL_WELL * frames**2
        padded = numpy.pad(charge, ((0, 0), (1, 1), (1, 1)), mode="edge")
        neighbours = padded[:, 2:, 1:-1] + padded[:, :-2, 1:-1] + padded[:, 1:-1, 2:] + padded[:, 1:-1, :-2]
        return frames + neighbours - 4 * charge
    return effect


def hot_pixels(count, photons):
    def effect(frames, random, fixed):
        frames = frames.copy()
        frames.reshape(len(frames), -1)[:, fixed.choice(frames[0].size, count, replace=False)] += photons
        return frames
    return effect


def cosmic_rays(hits, mean):
    def effect(frames, random, fixed):
        frames = frames.copy()
        for frame in frames.reshape(len(frames), -1):
            numpy.add.at(frame, random.integers(frame.size, size=hits), random.exponential(mean, hits))
        return frames
    return effect


def background(photons, slope):
    def effect(frames, random, fixed):
        across = numpy.linspace(-1, 1, frames.shape[2])
        return frames + random.poisson(photons * (1 + slope * across), frames.shape)
    return effect


def blurred(scene, folder):
    add_jitter(scene["systematics"], 0.03, numpy.random.default_rng(0))


def mid_mapped(scene, folder):
    add_map(scene["telescope"], 0.5e-9 * mid_frequencies(scene["telescope"], numpy.random.default_rng(5)), f"{folder}/mid.npy")


def drifting(scene, folder):
    scene["systematics"]["focus_rms_nm"] = {"rms": 0, "drift_per_day": 1 / DAYS}


def finely_sampled(scene, folder):
    scene["telescope"]["pupil_samples"] = 1024


def celled(scene, folder):
    scene["telescope"]["mask"].update(edges="cell", rotation_deg=0)


def with_planet(scene, folder):
    scene["signal"] = {"kind": "sinusoid", "star": "A", "amplitude_px": AMPLITUDE / scene["detector"]["pixel_scale_arcsec"],
                       "period_days": PERIOD, "phase_rad": 1}


def uncalibrated(scene, folder):
    scene.update(copy.deepcopy(nominal(scene["cadence"]["frames"], scene["detector"]["shape"][0])))


# (name, what changes the true scene, what changes its model, what changes the frames).
# The model is the truth without its change, but for disturbances of single frames.
EFFECTS = (
    ("none", None, None, None),
    ("none, planet of 2.6 uas", with_planet, None, None),
    ("flat 1e-3", None, None, flat(1e-3)),
    ("flat 1e-4", None, None, flat(1e-4)),
    ("jitter +0.03 px", blurred, None, None),
    ("smear 1e-3", None, None, smear(1e-3)),
    ("smear 1e-4", None, None, smear(1e-4)),
    ("nonlinearity 1e-2", None, None, nonlinearity(1e-2)),
    ("brighter-fatter 0.01 px2", None, None, brighter_fatter(0.01)),
    ("50 hot pixels of 1e5", None, None, hot_pixels(50, 1e5)),
    ("2000 hits of 1e4", None, None, cosmic_rays(2000, 1e4)),
    ("background 1e5, slope 30 %", None, None, background(1e5, 0.3)),
    ("no calibration", None, uncalibrated, None),
    ("edges by cells", None, celled, None),
    ("1024 pupil samples", finely_sampled, None, None),
    ("mid frequencies 0.5 nm", mid_mapped, None, None),
    ("focus drifts by 1 nm", drifting, None, None),
)


def scenes(effect, frames, side, seed, folder):
    """Returns the true scene and its model."""
    _, of_truth, of_model, _ = effect
    truth = draw_truth(nominal(frames, side), seed, out=folder)
    model = copy.deepcopy(truth)
    if of_truth:
        of_truth(truth, folder)
    if of_model:
        of_model(model, folder)
    model["systematics"] = {k: v for k, v in model["systematics"].items() if k.startswith("jitter")}
    return truth, model


def write_frames(path, truth, disturb, seed):
    """Writes the disturbed frames of a scene, photons in float64, as a cube."""
    simulator = toliman.Simulator(truth)
    count, shape = truth["cadence"]["frames"], truth["detector"]["shape"]
    cube = numpy.lib.format.open_memmap(path, mode="w+", dtype=numpy.float64, shape=(count, *shape))
    random = numpy.random.default_rng([seed, 8])
    for first in range(0, count, PART):
        frames = simulator.frames(first, min(PART, count - first))
        if disturb:
            frames = disturb(numpy.asarray(frames, float), random, numpy.random.default_rng([seed, 9]))
        cube[first:first + len(frames)] = frames
    cube.flush()


def run(*words):
    """Runs a command. Returns what it printed, and its errors."""
    done = subprocess.run([os.environ["TOLIMAN"], *map(str, words)], capture_output=True, text=True)
    if done.returncode not in (0, 4):
        raise RuntimeError(f"{' '.join(map(str, words))}: {done.stderr}")
    return done.stdout, done.stderr


def measure(effect, frames=281, side=256, seed=1):
    """Returns what `track`, `status` and `planet` say of the frames with an effect: (errors, status, planets or None)."""
    with tempfile.TemporaryDirectory() as folder:
        truth, model = scenes(effect, frames, side, seed, folder)
        write_frames(f"{folder}/frames.npy", truth, effect[3], seed)
        pathlib.Path(f"{folder}/model.json").write_text(json.dumps(model))
        state = f"{folder}/state"
        _, warnings = run("track", "--fit", f"{folder}/model.json", "--state", state, "--cadence", DAYS / frames * 86400,
                          "--mission-days", DAYS, "--sync", "none", f"{folder}/frames.npy")
        status = json.loads(run("status", state, "--json")[0])
        found = None
        if status["accepted"]:
            found = json.loads(run("planet", state, "--star-masses", "1.0788,0.9092", "--parallax", 750.81, "--json")[0])
    return warnings, status, found


def row(effect, warnings, status, found):
    """Returns the row of the table, and what is wrong in it."""
    name, of_truth, _, _ = effect
    goodness, wrong, has_planet = status["goodness"], [], of_truth is with_planet
    line = f"| {name} | {goodness['chi_square']:.4g} {goodness['goodness']} | {status['misfit']} |"
    if found:
        best = found["candidates"][0]
        line += (f" {found['chi_square']:.3g} | {best['log10_bayes']:.3g} | {best['log10_fap']:.3g} | {best['period'][1]:.0f} | "
                 f"{best['verdict']}{': ' if best['reasons'] else ''}{'; '.join(best['reasons'])} |")
        if found["planets"] != has_planet or has_planet and abs(best["period"][1] / PERIOD - 1) > 0.05:
            wrong.append(f"{name}: {found['planets']} planets, {best['period'][1]} d")
        if abs(found["frame_chi_square"] / goodness["chi_square"] - 1) > 0.05:
            wrong.append(f"{name}: planet takes a chi-square of {found['frame_chi_square']} for its frames")
    else:
        line += " | | | | no frame is accepted |"
    expected = "good" if name.startswith("none") else "poor"
    if goodness["goodness"] != expected or ("warning: " in warnings) != (expected == "poor"):
        wrong.append(f"{name}: is {goodness['goodness']}: must be {expected}, and said")
    return line, wrong


def of_effect(task):
    number, *sizes = task
    return row(EFFECTS[number], *measure(EFFECTS[number], *sizes))


def effects(pool, seed, frames=281, side=256, names=tuple(name for name, *_ in EFFECTS)):
    """Prints the table. Returns what is wrong in it. frames: their number, of side x side px; names: of effects."""
    print("| effect | chi-square of a frame | misfits | chi-square of the series | log10 Bayes | log10 FAP | period, d | verdict |\n"
          "|---|---|---|---|---|---|---|---|", flush=True)
    all_wrong = []
    for line, wrong in pool.imap(of_effect, [(k, frames, side, seed) for k, effect in enumerate(EFFECTS) if effect[0] in names]):
        print(line, flush=True)
        all_wrong += wrong
    return all_wrong
