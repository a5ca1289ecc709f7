"""The commands as users run them, start-up included unless stated otherwise: processor time of all threads, wall time,
memory. `toliman track` is compared with the library and with the disk."""
import functools
import json
import math
import os
import random
import shutil
import subprocess
import sys
import tempfile
import time

from measuring import HERE, SHORT, lines, median_spread, name_and_seconds, peer, row, stay_on_cores, warn

SCENES = os.path.join(HERE, "..", "..", "examples", "scenes")
SEEDS, REPEATS, ITERATIONS = ((1,), 1, 5) if SHORT else ((1, 2, 3, 4, 5), 3, 250)
FRAMES, PIXELS = 1095, 65536  # of the chapter's scene
STARS = 2 * 51 / 101  # its images of one star in one wavelength, by those that numpy_mft.py computes
GROUP = 64  # records between two fsyncs; also the frames of a run whose time is that of the start
FREQUENCIES = 5475  # of a mission of 1095 days
RECORD_BYTES = 80
CASES = {"template 64x64": (1024 if SHORT else 8192), "network 256x256": (128 if SHORT else 1024),
         "fit 64x64": (128 if SHORT else 1095), "fit 256x256": (96 if SHORT else 192)}
FIT_REPEATS = 1 if SHORT else 2
FITS = [case for case in CASES if case.startswith("fit")]


def timed(command, cwd, cores=None):
    """Runs a command in the user's own environment, on all cores unless given. Returns its times, peak memory and
    output."""
    words, start = [str(word) for word in command], time.perf_counter()
    with tempfile.TemporaryFile() as messages:
        with subprocess.Popen(words, cwd=cwd, stdout=subprocess.PIPE, stderr=messages,
                              preexec_fn=cores and functools.partial(stay_on_cores, cores)) as run:
            out = run.stdout.read()
            _, status, used = os.wait4(run.pid, 0)
            run.returncode, wall = os.waitstatus_to_exitcode(status), time.perf_counter() - start
        if run.returncode != 0:
            messages.seek(0)
            sys.exit(f"bench: {' '.join(words)}: exit code {run.returncode}\n{messages.read().decode()}")
    return {"processor_s": used.ru_utime + used.ru_stime, "wall_s": wall,
            "memory_bytes": 1024 * used.ru_maxrss, "out": out.decode()}


def repeated(part, count, command, **facts):
    """One object with the medians of several runs, each in a new folder."""
    runs = []
    for _ in range(count):
        with tempfile.TemporaryDirectory() as cwd:
            runs.append(timed(command, cwd))
    processor, wall = (median_spread([one[key] for one in runs]) for key in ("processor_s", "wall_s"))
    return {"part": part, "processor_s": processor[0], "spread_s": processor[1], "wall_s": wall[0], **facts}


def shipped_scene(name):
    with open(os.path.join(SCENES, name + ".json")) as file:
        return json.load(file)


def scene_of(case):
    """The scene of a case of `toliman track`: chapter.json, or sky.json for the fit."""
    estimator, shape = case.split()
    scene = shipped_scene("sky" if estimator == "fit" else "chapter")
    scene["cadence"]["frames"] = CASES[case]
    if shape == "64x64":
        scene["detector"]["shape"] = [64, 64]
    if estimator == "template":
        scene["binary"]["separation_arcsec"] = 4
    return scene


def folder_of(case):
    return case.replace(" ", "-")


def write_inputs(program, folder):
    """Scenes and pairs of files for each case of `toliman track`, and the weights of the network."""
    scene = scene_of(FITS[0])
    for part in (scene["telescope"]["mask"], *(star["spectrum"] for star in scene["stars"].values())):
        shutil.copy(os.path.join(SCENES, part["file"]), folder)
    for case in CASES:
        name = folder_of(case)
        with open(os.path.join(folder, name + ".json"), "w") as file:
            json.dump(scene_of(case), file)
        timed([program, "simulate", name + ".json", "--out", name, "--session", "s", "--dtype", "u32le"], folder)
    timed([program, "train", folder_of("network 256x256") + ".json", "--out", "w.tlmw"], folder)


def frame_s(case, wall_s):
    """Wall seconds per frame without the start: the shortest time of all frames minus that of the first group."""
    repeats = FIT_REPEATS if case in FITS else REPEATS
    least = [min(wall_s(end) for _ in range(repeats)) for end in (GROUP, CASES[case])]
    return (least[1] - least[0]) / (CASES[case] - GROUP)


def track_s(program, folder, case, every, jobs, sync):
    scene = folder_of(case) + ".json"
    estimator = {"template": ["--template", scene], "network": ["--weights", "w.tlmw"], "fit": ["--fit", scene]}

    def wall_s(end):
        with tempfile.TemporaryDirectory(dir=folder) as parent:
            return timed([program, "track", *estimator[case.split()[0]], "--state", os.path.join(parent, "state"),
                          "--mission-days", 1095, "--dtype", "u32le", "--every", every, "--jobs", jobs, "--sync", sync,
                          "--frames", f"0:{end}", folder_of(case)], folder)["wall_s"]
    return frame_s(case, wall_s)


def encode_s(program, folder, case, cores):
    shape, name = case.split()[1], folder_of(case)

    def wall_s(end):
        frames = f"{name}-{end}.bin"
        path, size = os.path.join(folder, frames), end * 4 * int(shape.split("x")[0])**2
        if not os.path.exists(path):
            with open(os.path.join(folder, name, "s_frames.bin"), "rb") as file, open(path, "wb") as out:
                out.write(file.read(size))
        return timed([program, "encode", "--fit", name + ".json", "--dtype", "u32le", "--shape", shape, frames],
                     folder, cores)["wall_s"]
    return frame_s(case, wall_s)


def fdatasync_s(folder):
    """Seconds until a group of records is on the disk: written to the end of a file, then fdatasync."""
    times, records = [], bytes(GROUP * RECORD_BYTES)
    with open(os.path.join(folder, "synced"), "wb", buffering=0) as file:
        for _ in range(9 if SHORT else 51):
            start = time.perf_counter()
            file.write(records)
            os.fdatasync(file.fileno())
            times.append(time.perf_counter() - start)
    return median_spread(times)[0]


def measure_per_frame(binaries, folder):
    program = os.path.join(binaries, "toliman")
    write_inputs(program, folder)
    counts = (1000, 200) if SHORT else (20000, 1000)
    found = [{"part": "library", **one} for one in lines([os.path.join(binaries, "bench_track"), *counts, FREQUENCIES],
                                                         one_core=False)]
    for case in CASES:
        for every in (1000,) if case in FITS else (1, 1000):
            for jobs in (1, 2):
                found.append({"part": "track", "case": case, "every": every, "jobs": jobs, "sync": "none",
                              "seconds": track_s(program, folder, case, every, jobs, "none")})
    case = next(iter(CASES))
    found.append({"part": "track", "case": case, "every": 1000, "jobs": 1, "sync": "group",
                  "seconds": track_s(program, folder, case, 1000, 1, "group")})
    found += [{"part": "encode", "case": case, "cores": cores, "seconds": encode_s(program, folder, case, cores)}
              for case in FITS for cores in (1, 2)]
    return found + [{"part": "fdatasync", "seconds": fdatasync_s(folder)}]


def write_separations(path):
    """836 reduced separations of three years, in uas, with a planet of 1.2 uas and 226 d."""
    draw = random.Random(1)
    days = sorted(draw.sample(range(1095), 836))
    lines = [f"{day},{1.2 * math.sin(2 * math.pi * day / 226) + draw.gauss(0, 0.375):.6f},0.375\n" for day in days]
    with open(path, "w", encoding="ascii") as file:
        file.writelines(["t,y,sigma\n", *lines])


def measure(binaries):
    program = os.path.join(os.path.abspath(binaries), "toliman")
    series = os.path.abspath(os.path.join(HERE, "..", "..", "examples", "data", "nu_oph_rv.csv"))
    with tempfile.TemporaryDirectory() as folder:
        found = [{"part": "run", **timed([program, "run", "chapter.json", "--seed", seed, "--json", "--out", "out"], folder)}
                 for seed in SEEDS]
        for one in found:
            one.update(json.loads(one.pop("out")))
        found += measure_per_frame(os.path.abspath(binaries), folder)
        separations = os.path.join(folder, "separations.csv")
        write_separations(separations)
        found.append(repeated("planet", REPEATS, [program, "planet", separations, "--unit", "uas", "--trend", "4"]))
    found += [repeated("psf", 5, [program, "psf", "chapter.json", "--out", "psf.npy"]),
              repeated("pupil", 1, [program, "pupil", "chapter.json", "--iterations", ITERATIONS]),
              repeated("period", 11, [program, "period", series]),
              repeated("planets", REPEATS, [program, "planet", series, "--unit", "m/s", "--max", "2",
                                            "--period-max", "5000"]),
              repeated("simulate", REPEATS, [program, "simulate", "chapter.json", "--out", "frames.bin"]),
              repeated("simulate sky", REPEATS, [program, "simulate", "sky.json", "--out", "frames.bin"])]
    return found + [{"part": "numpy", "image": peer("numpy", "numpy_mft.py", 0.2, 550),
                     "poisson": peer("numpy", "numpy_poisson.py", 5)}]


def rows_of_runs(runs, image):
    """`toliman run`; the reference is numpy that propagates every frame."""
    worst = max(abs(one["period_days"] / one["true_period_days"] - 1) for one in runs)
    processor, wall, memory = (median_spread([one[key] for one in runs]) for key in ("processor_s", "wall_s", "memory_bytes"))
    yield row("commands", "run", "toliman run chapter.json", *processor, worst, "of the period",
              image and f"{image['name']}, frames only (one timed)", name_and_seconds(image, STARS * runs[0]["frames"])[1],
              headline=True, at=f"{len(runs)} seeds", efficiency=median_spread([one["efficiency"] for one in runs])[0],
              wall_seconds=wall[0], memory_bytes=memory[0])


def positive(measured, part):
    """The times per frame of a command, without those that a busy machine made negative."""
    for one in measured:
        if one["part"] == part and one["seconds"] > 0:
            yield one
        elif one["part"] == part:
            warn(f"toliman {part}, {one['case']}: a few frames took longer than all: the machine is too busy")


def rows_of_encode(measured):
    for one in positive(measured, "encode"):
        cores = "1 core" if one["cores"] == 1 else f"{one['cores']} cores"
        yield row("encode", f"{one['case']}, {cores}", f"toliman encode, {one['case']}, {cores}: per frame, wall time",
                  one["seconds"], headline=True)


def rows_of_track(measured):
    library = {(one["case"], one["threads"]): 1 / one["frames_per_wall_s"] for one in measured
               if one["part"] == "library" and "frames" in one}
    disk, = [one["seconds"] for one in measured if one["part"] == "fdatasync"]
    free = {(one["case"], one["every"], one["jobs"]): one["seconds"] for one in measured if one["part"] == "track"
            and one["sync"] == "none"}
    for one in positive(measured, "track"):
        case, jobs = one["case"], one["jobs"]
        reference = "the library", library.get((case, jobs), library.get((case, 0)))
        if one["sync"] == "group":
            reference = f"--sync none, and fdatasync every {GROUP} frames", free[case, one["every"], jobs] + disk / GROUP
        options = f"--every {one['every']}, --jobs {jobs}, --sync {one['sync']}"
        yield row("track", f"{case}, {options}", f"toliman track, {case}, {options}: per frame, wall time", one["seconds"],
                  None, None, None, *reference, headline=True)
    yield row("track", "fdatasync", f"fdatasync of {GROUP} records on this disk, wall time", disk, headline=True)


def rows(measured):
    parts = {one["part"]: one for one in measured}
    image, poisson = parts["numpy"]["image"], parts["numpy"]["poisson"]
    yield from rows_of_runs([one for one in measured if one["part"] == "run"], image)
    counts, counts_s = name_and_seconds(poisson, PIXELS * FRAMES)
    for part, what, share, reference in (
            ("psf", "toliman psf chapter.json", 1, name_and_seconds(image, STARS)),
            ("simulate", f"toliman simulate chapter.json: {FRAMES} frames into a file", 1,
             (counts and counts + ", Poisson counts only", counts_s)),
            ("simulate sky", f"toliman simulate sky.json: {FRAMES} frames into a file", 1, (None, None)),
            ("pupil", "toliman pupil chapter.json", 1, (None, None)),
            ("period", "toliman period nu_oph_rv.csv", 1, (None, None)),
            ("planet", "toliman planet: 836 separations, 5 functions, one planet", 1, (None, None)),
            ("planets", "toliman planet nu_oph_rv.csv: two planets, with jitter", 1, (None, None))):
        one = parts[part]
        yield row("commands", part, what, one["processor_s"] / share, one["spread_s"] / share, None, None,
                  *reference, headline=True, wall_seconds=one["wall_s"] / share)
    yield from rows_of_track(measured)
    yield from rows_of_encode(measured)


def show(measured):
    for one in measured:
        print(json.dumps({key: value for key, value in one.items() if not isinstance(value, (dict, list))}))
