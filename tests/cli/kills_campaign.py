"""Commands that are killed (SIGKILL) at random moments: those that take long (JOBS). After each kill the output is absent
or whole; the same command, with --resume where it has that option, then gives the bits of an undisturbed run and leaves no
other file. Usage: kills_campaign.py [--scale SHARE_OF_KILLS] [JOB...]; TOLIMAN is the program."""
# promises: killed-calibrations-resume, killed-trainings-resume, kills-leave-no-half-result
import argparse
import dataclasses
import json
import math
import os
import pathlib
import random
import resource
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
import typing

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from program import PROGRAM, SCENES  # noqa: E402
from test_calibrate import SCENE as TELESCOPE  # noqa: E402
from test_calibrate import with_optics  # noqa: E402
from test_fit import SCENE as SMALL  # noqa: E402

FOLDER = pathlib.Path
TICK = os.sysconf("SC_CLK_TCK")


@dataclasses.dataclass(frozen=True)
class Job:
    """A command in a folder of inputs; `out` is what it makes, `files` the names of all that it leaves."""

    command: tuple[str, ...]
    out: str
    resume: tuple[str, ...]
    read: typing.Callable[[FOLDER], object]  # the results, for comparison; fails if they are not whole


@dataclasses.dataclass
class Tally:
    kills: int = 0
    absent: int = 0  # outputs after a kill
    whole: int = 0
    half: int = 0
    other: int = 0  # runs after a kill that failed, or ended with other bits
    left: int = 0  # files that remained after them
    seconds: float = 0  # of processor time, of an undisturbed run
    after_half: list[float] = dataclasses.field(default_factory=list)  # time to finish after a kill at half of it

    @property
    def faults(self) -> int:
        return self.half + self.other + self.left

    def text(self, name: str) -> str:
        share = f"{statistics.median(self.after_half):.2f}, at most {max(self.after_half):.2f}" if self.after_half else "-"
        return (f"{name:18} {self.kills:4} kills: {self.absent:3} absent, {self.whole:3} whole, {self.half} half; then "
                f"{self.other} failed or differ, {self.left} files left; {self.seconds:.2f} s, after a kill at half {share}")


def call(folder: FOLDER, *arguments: object) -> str:
    return subprocess.run([PROGRAM, *map(str, arguments)], cwd=folder, capture_output=True, text=True, check=True).stdout


def processor_time(process: "subprocess.Popen[bytes]") -> float:
    """Seconds so far, of all its threads."""
    try:
        fields = pathlib.Path(f"/proc/{process.pid}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return float("inf")
    return (int(fields[11]) + int(fields[12])) / TICK


def run(folder: FOLDER, command: typing.Sequence[str]) -> tuple[bool, float]:
    """Whether it succeeded, and its processor time."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run([PROGRAM, *command], cwd=folder, capture_output=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return done.returncode == 0, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def kill(folder: FOLDER, command: typing.Sequence[str], seconds: float, wall: bool) -> None:
    """Starts the command and kills it after that much processor time, or time."""
    process = subprocess.Popen([PROGRAM, *command], cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    start = time.monotonic()
    while process.poll() is None and (time.monotonic() - start if wall else processor_time(process)) < seconds:
        time.sleep(min(0.002, seconds / 50))
    process.kill()
    process.wait()


def names(folder: FOLDER) -> set[str]:
    return {path.name for path in folder.iterdir()}


def measure(job: Job, inputs: FOLDER, kills: int, at_half: int, seed: int = 1) -> Tally:
    """Kills at random moments of the whole run, and the time to finish after a kill at half of it."""
    tally = Tally()
    with tempfile.TemporaryDirectory() as kept:
        def fresh(name: str) -> FOLDER:
            folder = FOLDER(kept) / "work"  # always the same: results may name their folder
            shutil.rmtree(folder, ignore_errors=True)
            return FOLDER(shutil.copytree(inputs, folder, copy_function=os.link))

        folder = fresh("whole")
        start = time.monotonic()
        ended, tally.seconds = run(folder, job.command)
        wall = time.monotonic() - start
        assert ended, job.command
        result, files = job.read(folder), names(folder)
        chance, is_short = random.Random(seed), tally.seconds < 50 / TICK

        def finish() -> float:
            ended, seconds = run(folder, job.command + job.resume)
            tally.other += not ended or job.read(folder) != result
            tally.left += len(names(folder) ^ files)
            return seconds

        for number in range(kills + at_half):
            folder = fresh("killed")
            share = chance.uniform(0.02, 1.02) if number < kills else 0.5
            kill(folder, job.command, share * (wall if is_short else tally.seconds), is_short)
            tally.kills += 1
            if not (folder / job.out).exists():
                tally.absent += 1
            else:
                try:
                    is_whole = job.read(folder) == result
                except (OSError, ValueError, subprocess.CalledProcessError):
                    is_whole = False
                tally.whole += is_whole
                tally.half += not is_whole
                if names(folder) == files:  # it was complete
                    continue
            seconds = finish()
            if number >= kills:
                tally.after_half.append(seconds / tally.seconds)
    return tally


def states(folder: FOLDER, frames: int) -> None:
    """Two state folders, each with its own session."""
    scene = {**SMALL, "cadence": {"frames": 2 * frames, "interval_days": 1, "peak_photons": 1e5}}
    (folder / "s.json").write_text(json.dumps(scene))
    for half in range(2):
        call(folder, "simulate", "s.json", "--frames", f"{half * frames}:{(half + 1) * frames}", "--out", "in", "--session",
             f"n{half}", "--dtype", "u32le")
        call(folder, "track", "--fit", "s.json", "--state", f"state{half}", "--dtype", "u32le", "--mission-days", "200",
             f"in/n{half}_meta.jsonl")


def rapid(folder: FOLDER) -> None:
    stars = {name: {"spectrum": star["spectrum"], "photons_per_s": 1e7} for name, star in SMALL["stars"].items()}
    (folder / "s.json").write_text(json.dumps({
        **{name: part for name, part in SMALL.items() if name != "signal"}, "stars": stars, "cadence": {"frames": 400, "interval_days": 1, "exposure_s": 0.01},
        "detector": {**SMALL["detector"], "bias_dn": 100, "gain_e_per_dn": 1, "bit_depth": 12}}))


def network_scene(folder: FOLDER) -> None:
    (folder / "s.json").write_text(json.dumps({
        **SMALL, "binary": {"separation_arcsec": 4, "position_angle_deg": 30},
        "detector": {"shape": [128, 128], "pixel_scale_arcsec": 0.2}}))


def bank_scene(folder: FOLDER) -> None:
    (folder / "s.json").write_text(json.dumps({
        **SMALL, "binary": {"date": 2026, "orbit": "alpha-cen", "moving": True}, "band": {"wavelength_nm": 575},
        "cadence": {"frames": 100, "interval_days": 2, "peak_photons": 1e7},
        "telescope": {**SMALL["telescope"], "pupil_samples": 144},
        "detector": {"shape": [256, 256], "pixel_scale_arcsec": 0.4}}))


def calibration(folder: FOLDER, scene: dict[str, typing.Any], frames: int) -> None:
    """The scene s.json, and frames of it with other optics, which the calibration has to find."""
    (folder / "s.json").write_text(json.dumps(scene))
    (folder / "truth.json").write_text(json.dumps(with_optics(scene, zernike_5=8, zernike_6=-12, zernike_7=5, zernike_8=10)))
    call(folder, "simulate", "truth.json", "--frames", f"0:{frames}", "--out", "f.npy")


def sky(folder: FOLDER) -> None:
    """256 x 256 px, ten frames."""
    for path in (*SCENES.glob("*.csv"), SCENES / "sky_mask.npy"):
        shutil.copy(path, folder)
    calibration(folder, json.loads((SCENES / "sky.json").read_text()), 10)


def read_state(folder: FOLDER) -> object:
    call(folder, "status", "merged")
    return sorted(call(folder, "status", "merged", "--series").splitlines())


def read_bank(folder: FOLDER) -> object:
    return (folder / "b.tlmb").read_bytes()


def read_calibration(folder: FOLDER) -> object:
    """All results but the command. calibration.json tells that the other files are complete."""
    result = folder / "c.calibration.json"
    parts = json.loads(result.read_text()) if result.exists() else None
    if parts is not None:
        del parts["provenance"]
    arrays = sorted(folder.glob("c.*.npy")) if parts is not None else []
    return [json.loads(path.read_text()) for path in sorted(folder.glob("c*.json")) if path != result], parts, [
        path.read_bytes() for path in arrays]


def read_bytes(*paths: str) -> typing.Callable[[FOLDER], object]:
    """The bytes of files; of results in JSON without what tells when and how they were made."""
    def read(folder: FOLDER) -> object:
        texts: list[object] = []
        for path in paths:
            content = (folder / path).read_bytes()
            parts = json.loads(content) if path.endswith("result.json") or path.endswith("pupil.json") else None
            texts.append({name: value for name, value in parts.items() if name not in ("provenance", "timings")}
                         if parts is not None else content)
        return texts
    return read


def small(folder: FOLDER) -> None:
    (folder / "s.json").write_text(json.dumps({**SMALL, "cadence": {"frames": 400, "interval_days": 1, "peak_photons": 1e5}}))


def velocities(folder: FOLDER) -> None:
    chance = random.Random(1)
    (folder / "rv.csv").write_text("t,y,sigma\n" + "".join(
        f"{7 * i + chance.random()},{3 * math.sin(7 * i / 19) + chance.gauss(0, 1)},1\n" for i in range(60)))


MERGE = Job(("merge", "state0", "state1", "--out", "merged"), "merged", (), read_state)
BANK = Job(("train", "s.json", "--bank", "frames", "--spacing", "0.3", "--out", "b.tlmb"), "b.tlmb", ("--resume",), read_bank)
CALIBRATE = Job(("calibrate", "s.json", "f.npy", "--out", "c.json"), "c.calibration.json", ("--resume",), read_calibration)


def with_options(job: Job, *options: str) -> Job:
    return dataclasses.replace(job, command=job.command + options)


# Name -> (job, how its inputs are made, kills, kills at half).
JOBS: dict[str, tuple[Job, typing.Callable[[FOLDER], None], int, int]] = {
    "merge": (MERGE, lambda folder: states(folder, 20), 160, 0),
    "train --bank": (with_options(BANK, "--places", "3", "--steps", "100"), bank_scene, 60, 10),
    "calibrate": (CALIBRATE, sky, 60, 10),
    "calibrate --windows": (with_options(CALIBRATE, "--windows", "60", "--free", "scale zernike_5-8"),
                            lambda folder: calibration(folder, TELESCOPE, 12), 20, 5),
    "calibrate --map": (with_options(CALIBRATE, "--map", "--free", "scale zernike_5-8"),
                        lambda folder: calibration(folder, TELESCOPE, 6), 20, 5),
    "simulate": (Job(("simulate", "s.json", "--out", "f.npy"), "f.npy", (), read_bytes("f.npy")), small, 60, 0),
    "simulate --session": (Job(("simulate", "s.json", "--session", "n", "--out", "in"), "in/n_meta.jsonl", (),
                               read_bytes("in/n_frames.bin", "in/n_meta.jsonl")), small, 60, 0),
    "simulate --rate": (Job(("simulate", "s.json", "--rate", "50", "--duration", "20s", "--session", "n", "--out", "in"),
                            "in/n_meta.jsonl", (), read_bytes("in/n_frames.bin", "in/n_meta.jsonl", "in/n_truth.csv")), rapid, 60, 0),
    "train": (Job(("train", "s.json", "--out", "w.tlmw"), "w.tlmw", (), read_bytes("w.tlmw")), network_scene, 20, 0),
    "run": (Job(("run", "s.json", "--out", "r"), "r/result.json", (),
                read_bytes("r/result.json", "r/series.csv", "r/periodogram.csv", "r/scene.json")), small, 30, 0),
    "pupil": (Job(("pupil", "s.json", "--iterations", "60", "--out", "mask"), "mask/pupil.json", (),
                  read_bytes("mask/mask.npy", "mask/scene.json", "mask/pupil.json")), small, 40, 0),
    "planet": (Job(("planet", "rv.csv", "--unit", "m/s", "--star-masses", "1", "--out", "p"), "p/result.json", (),
                   read_bytes("p/result.json", "p/samples_1.npy", "p/series.csv")), velocities, 60, 0),
    "planet --map": (Job(("planet", "rv.csv", "--unit", "m/s", "--star-masses", "1", "--map", "--map-cells", "6x6", "--map-injections", "50",
                          "--out", "p"), "p/result.json", (), read_bytes("p/result.json", "p/map.csv")), velocities, 60, 10),
}


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("jobs", nargs="*", metavar="JOB", help=", ".join(JOBS))
    parser.add_argument("--scale", type=float, default=1, help="share of the kills")
    options = parser.parse_args()
    faults = 0
    for name in options.jobs or JOBS:
        job, make, kills, at_half = JOBS[name]
        with tempfile.TemporaryDirectory() as inputs:
            make(FOLDER(inputs))
            tally = measure(job, FOLDER(inputs), round(options.scale * kills), at_half)
        print(tally.text(name), flush=True)
        faults += tally.faults
    return faults != 0


if __name__ == "__main__":
    sys.exit(main())
