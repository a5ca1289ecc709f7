"""Functions shared by the benchmarks: running programs that print JSON lines, and the row that each measurement
yields."""
import functools
import json
import os
import subprocess
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
PYTHON = "/usr/bin/python3"
SHORT = bool(os.environ.get("BENCH_SHORT"))  # few frames and repeats, to try the benchmarks


def environment():
    """One thread, and OpenBLAS kernels as new as the processor: Debian's OpenBLAS treats many processors as older
    ones."""
    with open("/proc/cpuinfo") as file:
        core = "SKYLAKEX" if " avx512f " in file.read() else "HASWELL"
    return {"OPENBLAS_CORETYPE": core, **os.environ, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}


def stay_on_cores(count):
    """Of this process and its children."""
    os.sched_setaffinity(0, set(sorted(os.sched_getaffinity(0))[-count:]))


def stay_on_one_core():
    """Of this process and its children: the bounds are then of the core that does the work."""
    stay_on_cores(1)


def lines(command, one_core=True):
    """Runs a program that prints one JSON object per line; returns the objects."""
    found = []
    with subprocess.Popen([str(word) for word in command], env=environment(), stdout=subprocess.PIPE, text=True,
                          preexec_fn=stay_on_one_core if one_core else None) as run:
        for line in run.stdout:
            found.append(json.loads(line))
            if sys.stderr.isatty():
                print(f"\r{os.path.basename(str(command[0]))}: {len(found)} measured ", end="", file=sys.stderr)
    if sys.stderr.isatty():
        print("\r\033[K", end="", file=sys.stderr)
    if run.returncode != 0:
        sys.exit(run.returncode)
    return found


def median_spread(times):
    """As in timing.h: the median, and half the interquartile range."""
    times = sorted(times)
    quarter = len(times) // 4
    return times[len(times) // 2], (times[len(times) - 1 - quarter] - times[quarter]) / 2


@functools.lru_cache(None)  # prints each warning once
def warn(text):
    print(f"bench: {text}; see tools/bench/README.md", file=sys.stderr)


def peer_program(name, command):
    """Output of a reference program. If it does not run (usually because it is not installed), warns and returns
    []."""
    try:
        done = subprocess.run([str(word) for word in command], env=environment(), capture_output=True, text=True,
                              preexec_fn=stay_on_one_core)
        if done.returncode == 0:
            return [json.loads(line) for line in done.stdout.splitlines()]
        why = (done.stderr.strip() or f"exit code {done.returncode}").splitlines()[-1]
    except OSError as error:
        why = error.strerror
    warn(f"no reference times from {name} ({why})")
    return []


def peer_lines(name, script, *arguments):
    """The same for a script in this folder."""
    return peer_program(name, [PYTHON, os.path.join(HERE, script), *arguments])


def peer(name, script, *arguments):
    """What the script prints: name with version, and processor seconds; None if it does not run."""
    found = peer_lines(name, script, *arguments)
    return found[0] if found else None


def name_and_seconds(found, count=1):
    """The reference of a row: from the result of `peer`, for so many calls."""
    return (found["name"], count * found["seconds"]) if found else (None, None)


def row(bench, series, what, seconds, spread=None, error=None, of=None, reference=None, reference_seconds=None,
        roofline=None, headline=False, at=None, **more):
    """One row of the results. seconds: processor seconds of one core unless `what` says otherwise. spread: half the
    interquartile range of the runs. error: the largest error, relative to `of`, over the points `at` (default: all).
    reference, reference_seconds: another implementation, measured in the same run. roofline: hardware lower bound in
    seconds. headline: whether the row is part of the table of tools/docs/benchmarks.md. more: further keys of the schema.
    Unknown values are left out of the row."""
    all_of_it = {
        "bench": bench, "series": series, "what": what, "seconds": seconds, "spread": spread, "error": error,
        "error_of": of if error is not None else None, "error_at": at if error is not None else None,
        "peer": reference if reference_seconds else None,
        "ratio_peer": reference_seconds / seconds if reference_seconds else None,
        "ratio_roofline": seconds / roofline if roofline else None, "headline": headline, **more,
    }
    return {key: value for key, value in all_of_it.items() if value is not None}
