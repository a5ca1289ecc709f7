"""A day of the camera through `toliman coadd`: 43,200 s at 100 frames of 128x128 per second, 4.32e6 frames, to hourly sums. Wall and
processor time, and peak memory.

A day is 142 GB, so that 10,000 simulated frames stand for all: each of 432 pairs has a link to their pixels, which then are in memory,
and lines of its own, with times that continue. Every frame is parsed, read, registered, tested and added.

Usage: coadd_day.py [--files N] [--jobs N] [--folder FOLDER]; TOLIMAN is the program
"""
import argparse
import json
import os
import pathlib
import resource
import subprocess
import sys
import tempfile
import time

from coadd_campaign import scene_of

RATE, FRAMES, SIDE = 100, 10000, 128
LEAST_RATE, MOST_MB = 10 * RATE, 300  # frames per second of wall time, on one processor of two that others use
PROGRAM = os.environ.get("TOLIMAN", "toliman")


def simulate(folder):
    scene = scene_of(SIDE, bias_dn=100, gain_e_per_dn=1, bit_depth=12)
    (folder / "frame.json").write_text(json.dumps(scene))
    subprocess.run([PROGRAM, "--progress", "none", "simulate", "frame.json", "--rate", str(RATE), "--duration", f"{FRAMES / RATE}s", "--jitter",
                    "0.3:10", "--drift", "0.5:100s", "--cosmic-rays", "0.03", "--drops", "0.001:5", "--session", "once", "--out", "once"],
                   cwd=folder, check=True)
    return [json.loads(line) for line in (folder / "once/once_meta.jsonl").read_text().splitlines()]


def write_day(folder, lines, files):
    (folder / "day").mkdir()
    for number in range(files):
        name = folder / f"day/day{number:04}"
        pathlib.Path(f"{name}_frames.bin").symlink_to(folder / "once/once_frames.bin")
        late = number * FRAMES
        with open(f"{name}_meta.jsonl", "w") as side:
            for line in lines:
                moved = {**line, "frame_id": line["frame_id"] + late, "timestamp_ns": line["timestamp_ns"] + late * 10**9 // RATE,
                         "host_time": line["host_time"] + late / RATE, "session_id": "day"}
                side.write(json.dumps(moved) + "\n")


def add(folder, jobs):
    start = time.monotonic()
    done = subprocess.run([PROGRAM, "--progress", "none", "coadd", "--fit", "frame.json", "--every", "1h", "--jobs", str(jobs), "--dtype", "u16le", "--out",
                           f"sums{jobs}", "day"], cwd=folder, stdout=subprocess.PIPE, text=True, check=True)
    return time.monotonic() - start, [json.loads(line) for line in done.stdout.splitlines()]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--files", type=int, default=432)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--folder", help="for 1 GB of files; default: that of temporary files")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory(dir=options.folder) as name:
        folder = pathlib.Path(name)
        start = time.monotonic()
        lines = simulate(folder)
        drawn = time.monotonic() - start
        write_day(folder, lines, options.files)
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        wall, sums = add(folder, options.jobs)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
    frames, all_frames = sum(one["frames"] for one in sums), len(lines) * options.files
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    megabytes = max(after.ru_maxrss, before.ru_maxrss) / 1024
    print(f"{FRAMES} frames drawn in {drawn:.1f} s, {FRAMES / drawn:.0f} per second")
    print(f"{frames} of {all_frames} frames added to {len(sums)} sums, {options.jobs} threads: wall {wall:.0f} s, processor {cpu:.0f} s, "
          f"{1e6 * cpu / all_frames:.1f} us per frame, at most {megabytes:.0f} MB")
    sys.exit(0 if frames == all_frames and all_frames > LEAST_RATE * wall and megabytes < MOST_MB else 1)


if __name__ == "__main__":
    main()
