"""Time of many frames from Python, compared with the same calls from C, on two cores."""
import json
import os
import sys
import time

from measuring import SHORT, lines, median_spread, row

FRAMES, REPEATS = (64, 1) if SHORT else (1000, 5)
WHAT = {"network": "encode 1,000 frames of chapter.json, flight, from Python, 2 cores, wall time",
        "fit": "fit 1,000 frames of sky.json, from Python, 2 cores, wall time"}


def measure(binaries):
    package = os.path.join(os.path.dirname(binaries), "python")
    return (lines([os.path.join(binaries, "bench_frames"), FRAMES], one_core=False)
            + lines(["/usr/bin/env", f"PYTHONPATH={package}", "/usr/bin/python3", __file__], one_core=False))


def rows(measured):
    of_c = {one["part"]: one for one in measured[:len(WHAT)]}
    for one in measured[len(WHAT):]:
        reference = of_c[one["part"]]
        yield row("python", one["part"], WHAT[one["part"]], one["seconds"], one["spread"],
                  abs(one["last"] - reference["last"]), "px at the last frame", reference="the same from C",
                  reference_seconds=reference["seconds"], headline=True)


def show(measured):
    for c, python in zip(measured[:len(WHAT)], measured[len(WHAT):]):
        print(f"{c['part']}: {c['seconds']:.3f} s from C, {python['seconds']:.3f} s from Python, "
              f"{python['seconds'] / c['seconds'] - 1:+.1%}, same bits: {c['last'] == python['last']}")


def main():
    """Prints the times from Python, one JSON object per line."""
    import toliman
    network = toliman.CAE(toliman.Simulator("chapter.json"), seed=1)
    sky = toliman.Simulator("sky.json")
    fit, (days, _) = toliman.Fit(sky), sky.series(0, FRAMES)
    for part, scene, call in (("network", "chapter.json", network.encode),
                              ("fit", sky, lambda frames: fit.frames(frames, times_days=days)["separation_px"])):
        _, _, frames = toliman.simulate(scene, 0, FRAMES, seed=1)
        times = []
        for _ in range(REPEATS):
            start = time.perf_counter()
            found = call(frames)
            times.append(time.perf_counter() - start)
        median, spread = median_spread(times)
        print(json.dumps({"part": part, "seconds": median, "spread": spread, "frames": FRAMES, "last": float(found[-1])}))


if __name__ == "__main__":
    sys.exit(main())
