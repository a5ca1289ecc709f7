"""Complete runs as a user starts them (frames, training, encoding, period), and frames through the tracker."""
import json
import os
import resource
import subprocess
import tempfile

from measuring import environment, lines, median_spread, peer, row

SEEDS, WAVELENGTHS = (1, 2, 3, 4, 5), 51


def children_s():
    """Processor seconds of all terminated child processes."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def measure(binaries):
    found = []
    with tempfile.TemporaryDirectory() as folder:
        for seed in SEEDS:
            command = [os.path.join(binaries, "toliman"), "run", "chapter.json", "--seed", str(seed), "--json", "--out", folder]
            before = children_s()
            done = subprocess.run(command, env=environment(), stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
                                  text=True, check=True)
            found.append({"part": "run", "processor_s": children_s() - before, **json.loads(done.stdout)})
    tracked = lines([os.path.join(binaries, "bench_track"), 50000, 2000])
    return found + [{"part": "track", **one} for one in tracked] + [{"part": "numpy", "image_s": peer("numpy", "numpy_mft.py", 0.2, 550)}]


def rows(measured):
    runs = [one for one in measured if one["part"] == "run"]
    worst = max(abs(one["period_days"] / one["true_period_days"] - 1) for one in runs)
    image, = [one["image_s"] for one in measured if one["part"] == "numpy"]
    # Two stars in each wavelength, every frame propagated.
    plain = image and image * 2 * WAVELENGTHS / 101 * runs[0]["frames"]
    yield row("run", "chapter", "toliman run, total of all workers",
              *median_spread([one["processor_s"] for one in runs]), worst, "of the period",
              "numpy, frames only (one timed)", plain, headline=True, at=f"{len(runs)} seeds",
              efficiency=median_spread([one["efficiency"] for one in runs])[0])
    for one in measured:
        if one["part"] == "track" and "frames" in one and one["threads"] < 2:
            yield row("track", one["case"], f"track a frame, {one['case']}", 1 / one["frames_per_cpu_s"],
                      headline=True)


def show(measured):
    for one in measured:
        print(json.dumps({key: value for key, value in one.items() if not isinstance(value, (dict, list))}))
