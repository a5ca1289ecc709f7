"""Draws a mission of three years that nobody has seen, and writes what its ground segment receives.

    python3 mission.py FOLDER [--seed 1] [--planet DAYS:UAS[:ECCENTRICITY] ... | --none] [--frames 365] [--photons 1e12]
                       [--side PX] [--cells N] [--mid NM] [--drift NM] [--detector] [--scene examples/scenes/mission.json]

FOLDER/scene.json    the nominal scene: what is known before the launch
FOLDER/craft.oem     the orbit of the spacecraft: circular, Sun-synchronous, 600 km
FOLDER/windows.csv   when the telescope points at the stars: while they are 20 deg or more above the limb, in arcs that the
                     schedule leaves it
FOLDER/downlink      the frames, sums over a day every third day: a pair of files a quarter, out of order, 10 % of the frames
                     lost, 5 % twice
FOLDER/truth         what is true: optics, orbit of the stars, planets (compare.py reads it)

Optics are those of truth.py. The orbit of the stars differs from the published one by its errors. --mid adds errors of the
surface from 4 to 20 cycles per aperture, --drift a focus and astigmatism that grow by so many nm in the mission, --detector a
flat field, smear, coupling and non-linearity, --cells a pupil that is finer than that of the scene, --scene is the telescope."""
import argparse
import datetime
import json
import logging
import math
import pathlib
import shutil
import sys

import numpy

TOP = pathlib.Path(__file__).resolve().parents[2]
sys.path.append(str(TOP / "build" / "python"))  # if it is not installed
import toliman  # noqa: E402
from truth import draw_truth, resolve_files  # noqa: E402

START, INTERVAL_DAYS, EXPOSURE_S = datetime.date(2029, 6, 1), 3, 86400
LOST, REPEATED, ARCS_KEPT, FRAMES_PER_PAIR = 0.1, 0.05, 0.8, 30
ALTITUDE_M, EARTH_M, MU, STEP_S, LIMB_DEG = 600e3, 6378.137e3, 3.986004418e14, 120, 20
FLAT, SMEAR, COUPLING, BENT = 5e-3, 1e-3, 2e-3, 1e-2
SCENE, SYSTEM = (TOP / "examples" / name for name in ("scenes/mission.json", "systems/alpha-cen.json"))
RANDOM = {name: k for k, name in enumerate(("planets", "orbit", "arcs", "downlink", "flat", "charge", "craft", "phases"))}


def draws(seed, name):
    """The random stream of a part of the mission: an option does not change what the others draw."""
    return numpy.random.default_rng([seed, 100 + RANDOM[name]])


def tai_ns(date):
    """TAI of midnight UTC, ns since 1970."""
    return ((date - datetime.date(1970, 1, 1)).days * 86400 + 37) * 10**9


def date_text(ns):
    """A date of UTC."""
    moment = datetime.datetime(1970, 1, 1) + datetime.timedelta(microseconds=int(ns) // 1000 - 37 * 10**6)
    return moment.isoformat(timespec="milliseconds")


class Craft:
    """A circular orbit whose plane follows the Sun, in the axes of the ICRS."""

    def __init__(self, seed):
        random = draws(seed, "craft")
        self.radius = EARTH_M + ALTITUDE_M
        self.rate = math.sqrt(MU / self.radius**3)
        self.inclination, self.phase = math.radians(97.8), random.uniform(0, 2 * math.pi)
        self.node = math.radians(random.uniform(80, 100))  # of the mean Sun, at 18 h local time

    def states(self, ns):
        """Positions (m) and velocities (m/s) at times of TAI."""
        seconds = (numpy.asarray(ns) - tai_ns(START)) / 1e9
        days = seconds / 86400 + (START - datetime.date(2000, 1, 1)).days - 0.5
        u = self.phase + self.rate * seconds
        node = math.radians(280.46) + 2 * math.pi * days / 365.2422 + self.node
        along, across = numpy.stack([numpy.cos(node), numpy.sin(node), 0 * node]), numpy.stack(
            [-numpy.sin(node) * math.cos(self.inclination), numpy.cos(node) * math.cos(self.inclination),
             math.sin(self.inclination) + 0 * node])
        turn = 2 * math.pi / 365.2422 / 86400 * self.radius  # of the plane
        place = numpy.cos(u) * along + numpy.sin(u) * across
        speed = self.rate * self.radius * (numpy.cos(u) * across - numpy.sin(u) * along)
        return self.radius * place, speed + turn * numpy.stack([-place[1], place[0], 0 * node])


def arcs(craft, starts, system, seed):
    """Windows (TAI ns) in which the stars are above the limb, in exposures that begin at these times."""
    ra, dec = (math.radians(system["barycentre"][key]) for key in ("ra_deg", "dec_deg"))
    stars = numpy.array([math.cos(dec) * math.cos(ra), math.cos(dec) * math.sin(ra), math.sin(dec)])
    lowest = math.cos(math.asin(EARTH_M / craft.radius) + math.radians(LIMB_DEG))
    random, windows = draws(seed, "arcs"), []
    for start in starts:
        times = start + numpy.arange(0, EXPOSURE_S + 1, 10, dtype=numpy.int64) * 10**9
        seen = -stars @ craft.states(times)[0] / craft.radius < lowest
        edges = numpy.flatnonzero(numpy.diff(numpy.r_[False, seen, False].astype(int))).reshape(-1, 2)
        for first, end in edges:
            if end - first > 30 and random.uniform() < ARCS_KEPT:
                windows.append((times[first], times[end - 1]))
    return windows


def write_orbit(path, craft, starts):
    """An OEM with a segment for each exposure."""
    lines = ["CCSDS_OEM_VERS = 2.0", "CREATION_DATE = 2029-06-01T00:00:00", "ORIGINATOR = EXAMPLE"]
    for start in starts:
        times = start + numpy.arange(-2 * STEP_S, EXPOSURE_S + 2 * STEP_S + 1, STEP_S, dtype=numpy.int64) * 10**9
        places, speeds = craft.states(times)
        lines += ["META_START", "OBJECT_NAME = TOLIMAN", "OBJECT_ID = 2029-001A", "CENTER_NAME = EARTH", "REF_FRAME = GCRF",
                  "TIME_SYSTEM = UTC", f"START_TIME = {date_text(times[0])}", f"STOP_TIME = {date_text(times[-1])}", "META_STOP"]
        for time, place, speed in zip(times, places.T / 1e3, speeds.T / 1e3):
            lines.append(date_text(time) + " " + " ".join(f"{value:.9f}" for value in (*place, *speed)))
    path.write_text("\n".join(lines) + "\n")


def nominal_scene(options):
    """What is known before the launch."""
    scene = json.loads(options.scene.read_text())
    resolve_files(scene, options.scene.resolve().parent)
    middle_ns = tai_ns(START) + EXPOSURE_S * 10**9 // 2
    j2000_ns = (10957 * 86400 + 43200) * 10**9 - 32184 * 10**6  # TT 2000-01-01T12 in TAI
    scene["binary"] = {"orbit": "alpha-cen", "date": 2000 + (middle_ns - j2000_ns) / 1e9 / 86400 / 365.25, "moving": True,
                       "centre": "barycentre", "observer": {"file": "craft.oem"}}
    scene["signal"] = {"kind": "none"}
    scene["systematics"] = {"pointing_rms_px": 0.3, "roll_rms_deg": 0.01}
    if options.side:
        scene["detector"]["shape"] = [options.side, options.side]
    scene["cadence"] = {"frames": options.frames, "interval_days": INTERVAL_DAYS, "exposure_s": EXPOSURE_S,
                        "on_target": "windows.csv"}
    return scene


def set_photons(scene, windows, photons):
    """Scales the stars to photons of a frame of mean time on target."""
    seconds = sum(end - start for start, end in windows) / 1e9 / scene["cadence"]["frames"]
    factor = photons / seconds / sum(star["detected_per_s"] for star in scene["stars"].values())
    for star in scene["stars"].values():
        star["detected_per_s"] *= factor


def draw_planets(options):
    """Planets of A: circular or eccentric, two in one of five missions that have some."""
    if options.none:
        return []
    if options.planet:
        return [dict(zip(("period_days", "amplitude_uas", "eccentricity"), map(float, text.split(":")))) for text in options.planet]
    random = draws(options.seed, "planets")
    periods = [math.exp(random.uniform(math.log(120), math.log(600)))]
    if random.uniform() < 0.2:
        periods.append(periods[0] * random.uniform(0.4, 0.6))
    return [{"period_days": period, "amplitude_uas": math.exp(random.uniform(math.log(2), math.log(10)))} for period in periods]


def displacement_uas(planet, phase, days):
    """Along the axis from A to B, of a star with a planet: the x coordinate of a Kepler orbit, of amplitude 1 if circular."""
    e = planet.get("eccentricity", 0)
    mean = 2 * numpy.pi * days / planet["period_days"] + phase
    anomaly = mean + e * numpy.sin(mean)
    for _ in range(50):
        anomaly -= (anomaly - e * numpy.sin(anomaly) - mean) / (1 - e * numpy.cos(anomaly))
    return planet["amplitude_uas"] * (numpy.cos(anomaly) - e)


def true_system(path, system, seed):
    """The orbit of the stars, which differs from the published one by its errors. Written to `path`."""
    true, random = json.loads(json.dumps(system)), draws(seed, "orbit")
    for group in ("orbit", "barycentre"):
        for key, sigma in system["sigma"][group].items():
            true[group][key] += sigma * random.normal()
    path.write_text(json.dumps(true))
    return true


def detected(light, flat, random, peak):
    """Electrons that a real detector reads."""
    charge = light * flat
    charge = random.poisson(charge + SMEAR / len(charge) * charge.sum(axis=0)).astype(float)
    padded = numpy.pad(charge, 1, mode="edge")
    charge += COUPLING * (padded[:-2, 1:-1] + padded[2:, 1:-1] + padded[1:-1, :-2] + padded[1:-1, 2:] - 4 * charge)
    return numpy.rint(charge - BENT / peak * charge**2)


def side_line(number, start_ns, shape, session):
    return json.dumps({"frame_id": number, "timestamp_ns": int(start_ns), "host_time": start_ns / 1e9, "nframes_dropped": 0,
                       "roi_label": "single_roi", "n_rows": shape[0], "n_cols": shape[1], "session_id": session}) + "\n"


def write_downlink(folder, frame_of, starts, shape, seed):
    """A pair of files for each quarter, as it arrives."""
    folder.mkdir()
    random = draws(seed, "downlink")
    for first in range(0, len(starts), FRAMES_PER_PAIR):
        numbers = [k for k in range(first, min(first + FRAMES_PER_PAIR, len(starts))) if random.uniform() >= LOST]
        numbers += [k for k in numbers if random.uniform() < REPEATED]
        random.shuffle(numbers)
        session = f"sky{first // FRAMES_PER_PAIR:03d}"
        made = {}
        with open(folder / f"{session}_frames.bin", "wb") as pixels, open(folder / f"{session}_meta.jsonl", "w") as side:
            for k in numbers:
                if k not in made:
                    counts = frame_of(k)
                    if counts.max() >= 2**32:
                        raise SystemExit(f"frame {k}: {counts.max():.3g} photons in a pixel: must be below 2^32: give fewer --photons")
                    made[k] = counts.astype("<u4").tobytes()
                pixels.write(made[k])
                side.write(side_line(k, starts[k], shape, session))
        if sys.stderr.isatty():
            print(f"\rframe {min(first + FRAMES_PER_PAIR, len(starts))} of {len(starts)}", end="", file=sys.stderr)
    if sys.stderr.isatty():
        print(file=sys.stderr)


def draw(options):
    folder = options.folder.resolve()
    if (folder / "truth" / "truth.json").is_file() and (folder / "scene.json").is_file():  # an earlier mission
        shutil.rmtree(folder)
    folder.mkdir(parents=True)
    truth = folder / "truth"
    truth.mkdir()
    system = json.loads(SYSTEM.read_text())
    starts = [tai_ns(START) + k * INTERVAL_DAYS * 86400 * 10**9 for k in range(options.frames)]
    craft = Craft(options.seed)
    windows = arcs(craft, starts, system, options.seed)
    write_orbit(folder / "craft.oem", craft, starts)
    (folder / "windows.csv").write_text("start_tai_ns,end_tai_ns\n" + "".join(f"{start},{end}\n" for start, end in windows))
    scene = nominal_scene(options)
    set_photons(scene, windows, options.photons)
    (folder / "scene.json").write_text(json.dumps(scene, indent=2) + "\n")

    system = true_system(truth / "system.json", system, options.seed)
    scene["binary"]["orbit"] = str(truth / "system.json")
    if options.cells:
        scene["telescope"]["pupil_samples"] = options.cells
    true_scene = draw_truth(scene, options.seed, mid_nm=options.mid, folder=folder, out=truth)
    true_scene["noise"]["seed"] = options.seed
    if options.detector:
        true_scene["noise"] = {"photon": False, "seed": options.seed}  # of the charge, below
    if options.drift:
        days = options.frames * INTERVAL_DAYS
        drift = {"rms": 0, "drift_per_day": options.drift / math.sqrt(2) / days}
        true_scene["systematics"].update(focus_rms_nm=drift, zernike_rms_nm={"6": drift})
    (truth / "scene.json").write_text(json.dumps(true_scene, indent=2) + "\n")

    simulator = toliman.Simulator(true_scene, folder=folder)
    planets, random = draw_planets(options), draws(options.seed, "phases")
    days = numpy.arange(options.frames) * float(INTERVAL_DAYS)
    wobble = sum((displacement_uas(planet, random.uniform(0, 2 * math.pi), days) for planet in planets), numpy.zeros(len(days)))
    displacements = wobble * 1e-6 / true_scene["detector"]["pixel_scale_arcsec"]
    flat = 1 + FLAT * draws(options.seed, "flat").normal(size=simulator.shape)
    charge, peak = draws(options.seed, "charge"), simulator.image().max()

    def frame_of(k):
        light = simulator.frame(k, displacement=displacements[k])
        return detected(light, flat, charge, peak) if options.detector else numpy.rint(light)

    write_downlink(folder / "downlink", frame_of, starts, simulator.shape, options.seed)
    seen = toliman.Sky(truth / "system.json", folder / "craft.oem").predict_exposures(
        [[arc for arc in windows if start <= arc[0] < start + EXPOSURE_S * 10**9] for start in starts], on_target=True)
    separations = seen["separation_arcsec"] / true_scene["detector"]["pixel_scale_arcsec"] + displacements
    (truth / "truth.json").write_text(json.dumps(
        {"planets": planets, "masses": [system["masses"][star] for star in "AB"], "parallax_mas": system["barycentre"]["parallax_mas"],
         "middles_tai_ns": [start + EXPOSURE_S * 10**9 // 2 for start in starts], "separations_px": separations.tolist()}, indent=1) + "\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--planet", action="append")
    parser.add_argument("--none", action="store_true")
    parser.add_argument("--frames", type=int, default=365)
    parser.add_argument("--photons", type=float, default=1e12)
    parser.add_argument("--side", type=int, default=0)
    parser.add_argument("--cells", type=int, default=0)
    parser.add_argument("--mid", type=float, default=0)
    parser.add_argument("--drift", type=float, default=0)
    parser.add_argument("--detector", action="store_true")
    parser.add_argument("--scene", type=pathlib.Path, default=SCENE)
    logging.getLogger("toliman").setLevel(logging.ERROR)
    draw(parser.parse_args())


if __name__ == "__main__":
    main()
