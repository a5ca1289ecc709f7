"""How the times of commands grow with frames, samples and cells, start-up included: each is measured at several sizes, and
the exponent of a power of the size is fitted to the logarithms. Of state folders, the sums that merge adds and those
that rebuild computes again are compared."""
import json
import math
import os
import random
import shutil
import sys
import tempfile

import calibrate
from commands import SCENES, shipped_scene, timed
from measuring import SHORT, lines, median_spread, row

REPEATS = 1 if SHORT else 3
GRID = "0.001:0.0005:2000"


def write_series(folder, samples):
    """A period of 31.7 d in white noise, unevenly sampled."""
    draw = random.Random(1)
    with open(os.path.join(folder, "series.csv"), "w", encoding="ascii") as file:
        file.write("t,y,sigma\n")
        for i in range(samples):
            day = (i + draw.random()) * 1000 / samples
            file.write(f"{day:.9f},{math.sin(2 * math.pi * day / 31.7) + draw.gauss(0, 1):.9f},1\n")


def simulate(program, folder, frames):
    return [program, "simulate", "chapter.json", "--frames", f"0:{frames}", "--out", "frames.bin", "--force"]


def period(program, folder, samples):
    write_series(folder, samples)
    return [program, "period", "series.csv", "--f0", 0.001, "--df", 0.0005, "--nf", 2000, "--json"]


def fit(program, folder, frames):
    timed([program, "simulate", "sky.json", "--frames", f"0:{frames}", "--out", "frames.fits", "--force"], folder)
    return [program, "encode", "--fit", "sky.json", "frames.fits"]


def calibration(program, folder, cells):
    """As calibrate.py, with another number of cells in model and truth."""
    for star in shipped_scene("sky")["stars"].values():
        shutil.copy(os.path.join(SCENES, star["spectrum"]["file"]), folder)
    for name, scene in (("nominal", calibrate.nominal_scene()), ("truth", calibrate.true_scene())):
        scene["telescope"]["pupil_samples"] = cells
        with open(os.path.join(folder, name + ".json"), "w") as file:
            json.dump(scene, file)
    timed([program, "simulate", "truth.json", "--out", "frames.fits"], folder)
    return [program, "calibrate", "nominal.json", "frames.fits", "--out", "fitted.json", "--json", "--force"]


def make_folders(program, folder, frames):
    """Two folders of half of the frames each."""
    for name, first in (("a", 0), ("b", frames // 2)):
        path = os.path.join(folder, name)
        os.mkdir(path)
        lines([os.path.join(os.path.dirname(program), "bench_track"), "--folder", path, first, frames // 2])


def merge(program, folder, frames):
    if not os.path.exists(os.path.join(folder, "a")):
        make_folders(program, folder, frames)
    shutil.rmtree(os.path.join(folder, "merged"), ignore_errors=True)
    return [program, "merge", "a", "b", "--out", "merged"]


def status(program, folder, frames):
    timed(merge(program, folder, frames), folder)
    return [program, "status", "merged", "--json"]


def rebuild(program, folder, frames):
    timed(merge(program, folder, frames), folder)
    return [program, "rebuild", "merged", "--grid", GRID, "--json"]


FOLDERS = (2000, 20000) if SHORT else (10000, 100000, 1000000)
# Name, what is measured, unit of the size, sizes. The command is made by the function of this name, before each run.
CASES = ((simulate, "toliman simulate chapter.json", "frames", (16, 64) if SHORT else (64, 256, 1024)),
         (period, "toliman period, 2,000 frequencies", "samples", (1000, 10000) if SHORT else (1000, 10000, 100000)),
         (fit, "toliman encode --fit sky.json", "frames", (8, 32) if SHORT else (32, 128, 512)),
         (calibration, "toliman calibrate, cells per axis of the mask", "cells", (144, 192) if SHORT else (144, 256, 512)),
         (merge, "toliman merge of two folders", "frames", FOLDERS),
         (status, "toliman status", "frames", FOLDERS),
         (rebuild, "toliman rebuild", "frames", FOLDERS))


def exponent(points):
    """Least-squares slope of log(seconds) by log(size), of the larger two thirds: start-up is the same for all."""
    logs = [(math.log(size), math.log(seconds)) for size, seconds in points[len(points) // 3:]]
    x, y = (sum(values) / len(logs) for values in zip(*logs))
    return sum((a - x) * (b - y) for a, b in logs) / sum((a - x)**2 for a, _ in logs)


def measure_case(program, make, size):
    with tempfile.TemporaryDirectory() as folder:
        runs = []
        for _ in range(REPEATS):
            runs.append(timed(make(program, folder, size), folder))
        found = {key: median_spread([run[key] for run in runs]) for key in ("processor_s", "wall_s", "memory_bytes")}
    return {"case": make.__name__, "size": size, "processor_s": found["processor_s"][0],
            "spread_s": found["processor_s"][1], "wall_s": found["wall_s"][0], "memory_bytes": found["memory_bytes"][0],
            "out": runs[0]["out"]}


def measure(binaries):
    program = os.path.join(os.path.abspath(binaries), "toliman")
    found = [measure_case(program, make, size) for make, _, _, sizes in CASES for size in sizes]
    fits = {one["size"]: json.loads(one["out"])["fit"] for one in found if one["case"] == "status"}  # of merged sums
    for one in found:
        if one["case"] == "rebuild":
            fit_of, merged = json.loads(one["out"])["fit"], fits[one["size"]]
            if abs(fit_of["period"] - merged["period"]) > 1e-6 * merged["period_error"]:
                sys.exit(f"bench: {one['size']} frames: the sums of merge and rebuild differ")
        one.pop("out")
    return found


def rows(measured):
    for make, what, unit, _ in CASES:
        case = [one for one in measured if one["case"] == make.__name__]
        power = exponent([(one["size"], one["processor_s"]) for one in case])
        for one in case:
            yield row("growth", make.__name__, f"{what}: {one['size']:,} {unit}", one["processor_s"], one["spread_s"],
                      headline=one is case[-1], wall_seconds=one["wall_s"], memory_bytes=one["memory_bytes"],
                      size=one["size"], exponent=power)


def show(measured):
    for make, _, unit, _ in CASES:
        case = [one for one in measured if one["case"] == make.__name__]
        power = exponent([(one["size"], one["processor_s"]) for one in case])
        print(f"{make.__name__}: " + ", ".join(f"{one['size']:,} {unit} {one['processor_s']:.3g} s" for one in case) +
              f": as {unit}^{power:.2f}")
