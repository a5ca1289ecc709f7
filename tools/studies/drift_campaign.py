"""Optics that drift by 1 nm in three years, through the commands `calibrate`, `track`, `status` and `planet`: are separations at
the photon bound, and are no planets found that are not there?

    drift_campaign.py [self] [windows] [--seed 1] [--jobs 0]

self     281 frames of 1e12 photons in three years, of the stars of alpha Centauri on their orbit, behind a spiral mask and unknown
         optics, whose aberrations (Noll 4 to 11, in a random direction) drift by 1 nm rms. `calibrate` learns them from the
         first ten frames; `track --fit` has its defaults for a calibrated scene, or --free none. Three truths without a planet,
         and one with a planet of 2.6 uas and 430 d.
windows  The same with a calibration of 36 frames, --windows 90, and --free none: a step at each start of a window would be a
         planet of 90 d.

The table has for each row the median chi-square of a frame; the standard deviation of a frame over the Cramer-Rao bound with
the optics known; the scatter of the separations about a parabola over their standard deviations, and over the scatter in frames
of the same noise without drift, fitted with the true optics; log10 FAP and the period of the highest peak; and the verdict of
`planet`. The exit status is 1 if a planet is wrong, or with the default the standard deviation is more than 1.03 of the bound or
the scatter more than 1.03 of that without drift."""
import copy
import json
import pathlib
import sys
import tempfile

import numpy

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path += [str(ROOT / name) for name in ("build/python", "examples/sky")]
import campaign  # noqa: E402
import toliman  # noqa: E402
from doubt_frames import AMPLITUDE, DAYS, PERIOD, nominal, run, with_planet  # noqa: E402
from truth import draw_truth  # noqa: E402

DRIFT_NM, FRAMES, SIDE, FIRST = 1.0, 281, 256, 10
PART = 4  # frames with the same optics: steps of 0.014 nm
WORST_SIGMA = 1.03
# (truth's seed, planet, arguments of calibrate, number of its frames, arguments of track)
ROWS = {
    "self": tuple((seed, False, (), FIRST, ()) for seed in range(3)) + ((0, True, (), FIRST, ()),
             (0, False, (), FIRST, ("--free", "none", "--chi-limit", 100))),
    "windows": ((0, False, ("--windows", 90), 36, ("--free", "none")),),
}


def write_frames(path, truth, drift_nm, frames):
    """Writes the frames of a scene whose aberrations drift by drift_nm {Noll number: nm} from the first to the last."""
    cube = numpy.lib.format.open_memmap(path, mode="w+", dtype=numpy.float64, shape=(frames, *truth["detector"]["shape"]))
    start = truth["telescope"]["aberrations"]["zernike_rms_nm"]
    for first in range(0, frames, PART):
        now, count = copy.deepcopy(truth), min(PART, frames - first)
        share = (first + 0.5 * (count - 1)) / (frames - 1)
        now["telescope"]["aberrations"]["zernike_rms_nm"] = {noll: nm + share * drift_nm[noll] for noll, nm in start.items()}
        cube[first:first + count] = toliman.Simulator(now).frames(first, count)
    cube.flush()


def mission(row, seed, folder, frames=FRAMES, side=SIDE):
    """Writes the scene and the frames of a row. Returns those without drift with known optics: the bound of the separation, px,
    and their series."""
    number, has_planet = row[0], row[1]
    given = nominal(frames, side)
    truth = draw_truth(given, 100 * seed + number, out=folder)
    if has_planet:
        with_planet(truth, folder)
    drift = numpy.random.default_rng([seed, number, 54]).normal(size=8)
    drift *= DRIFT_NM / numpy.linalg.norm(drift)
    truth["noise"]["seed"] = 100 * seed + number
    write_frames(f"{folder}/frames.npy", truth, dict(zip(map(str, range(4, 12)), drift.tolist())), frames)
    pathlib.Path(f"{folder}/scene.json").write_text(json.dumps(given))
    numpy.save(f"{folder}/first.npy", choice(numpy.load(f"{folder}/frames.npy", mmap_mode="r"), row))
    return without_drift(truth, frames)


def without_drift(truth, frames):
    simulator, times = toliman.Simulator(truth), DAYS / frames * numpy.arange(frames)
    fit = toliman.Fit(simulator)
    parts = [fit.frames(simulator.frames(k, min(16, frames - k)), times_days=times[k:k + 16]) for k in range(0, frames, 16)]
    separation, sigma = (numpy.concatenate([part[name] for part in parts]) for name in ("separation_px", "separation_sigma_px"))
    exact = [fit.predict(time_days=t)[1][0] for t in times]
    return float(fit.predict()[2][0, 0]) ** 0.5, {"t": times, "y": separation - exact, "sigma": sigma}


def choice(frames, row):
    """The frames of the calibration: the first ones, or with windows all of the time in equal steps."""
    return frames[:row[3]] if not row[2] else frames[::len(frames) // row[3]]


def measure(row, seed=1, frames=FRAMES, side=SIDE):
    """Returns bound and series without drift, and what `status` and `planet` say: (px, series, status, series, planets)."""
    with tempfile.TemporaryDirectory() as folder:
        bound, control = mission(row, seed, folder, frames, side)
        cadence = DAYS / frames * 86400
        step = 1 if not row[2] else frames // row[3]
        run("calibrate", f"{folder}/scene.json", f"{folder}/first.npy", "--out", f"{folder}/fitted.json", "--cadence",
            cadence * step, *row[2])
        state = f"{folder}/state"
        run("track", "--fit", f"{folder}/fitted.json", *row[4], "--state", state, "--cadence", cadence,
            "--mission-days", DAYS, "--sync", "none", f"{folder}/frames.npy")
        status = json.loads(run("status", state, "--json")[0])
        run("status", state, "--out", f"{folder}/out")
        lines = [line for line in pathlib.Path(f"{folder}/out/series.csv").read_text().splitlines() if line[0] != "#"]
        series = numpy.genfromtxt(lines, delimiter=",", names=True)
        found = json.loads(run("planet", state, "--star-masses", "1.0788,0.9092", "--parallax", 750.81, "--json")[0])
    return bound, control, status, series, found


def scatter_of(series):
    """The rms of the residuals of a parabola over their standard deviations, and its own standard deviation."""
    t = (series["t"] - series["t"].mean()) / numpy.ptp(series["t"])
    w = 1 / series["sigma"]
    a = numpy.stack([numpy.ones_like(t), t, t * t], axis=1) * w[:, None]
    rest = series["y"] * w - a @ numpy.linalg.lstsq(a, series["y"] * w, rcond=None)[0]
    freedom = len(t) - 3
    return float(numpy.sqrt(rest @ rest / freedom)), float(numpy.sqrt(0.5 / freedom))


def judge(row, bound, control, status, series, found):
    """Returns the row of the table, and what is wrong in it."""
    number, has_planet, calibrate, _, track = row
    name = " ".join([f"truth {number}", *(["with a planet"] if has_planet else []), *map(str, calibrate + track)])
    sigma = float(numpy.median(series["sigma"])) / bound
    scatter, error = scatter_of(series)
    ratio = scatter * sigma * bound / (scatter_of(control)[0] * float(numpy.median(control["sigma"])))
    best = found["candidates"][0]
    line = (f"| {name} | {status['goodness']['chi_square']:.4f} | {sigma:.4f} | {scatter:.3f} +- {error:.3f} | {ratio:.3f} | "
            f"{best['log10_fap']:.2f} | {best['period'][1]:.1f} | {best['log10_bayes']:.2f} {best['verdict']} |")
    wrong = []
    if found["planets"] != has_planet or has_planet and abs(best["period"][1] / PERIOD - 1) > 0.05:
        wrong.append(f"{name}: {found['planets']} planets, {best['period'][1]} d")
    if not track and sigma > WORST_SIGMA:
        wrong.append(f"{name}: sigma is {sigma:.4f} of the bound: must be at most {WORST_SIGMA}")
    if not track and not has_planet and ratio > WORST_SIGMA:
        wrong.append(f"{name}: scatter is {ratio:.3f} of that without drift: must be at most {WORST_SIGMA}")
    return line, wrong


def of_row(task):
    row, seed, *sizes = task
    return judge(row, *measure(row, seed, *sizes))


def all_rows(pool, rows, seed, *sizes):
    """Prints the table of these rows. Returns what is wrong in it."""
    print("| truth | chi-square of a frame | sigma over the bound | scatter over sigma | over that without drift | log10 FAP | period, d | log10 Bayes, verdict |\n"
          "|---|---|---|---|---|---|---|---|", flush=True)
    all_wrong = []
    for line, wrong in pool.imap(of_row, [(row, seed, *sizes) for row in rows]):
        print(line, flush=True)
        all_wrong += wrong
    return all_wrong


def main():
    modes = {name: lambda pool, given, rows=rows: all_rows(pool, rows, given.seed) for name, rows in ROWS.items()}
    return campaign.run(__doc__, modes, sets=1, sets_help="not used")


if __name__ == "__main__":
    sys.exit(main())
