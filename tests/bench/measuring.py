"""What the benches share: programs that print a JSON object a line, and the row in which all tell what they measured."""
import functools
import json
import os
import subprocess
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
PYTHON = "/usr/bin/python3"


def environment():
    """One thread, and kernels as new as the processor: Debian's OpenBLAS takes many for older ones."""
    with open("/proc/cpuinfo") as file:
        core = "SKYLAKEX" if " avx512f " in file.read() else "HASWELL"
    return {"OPENBLAS_CORETYPE": core, **os.environ, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}


def lines(command):
    """What a program prints."""
    found = []
    with subprocess.Popen([str(word) for word in command], env=environment(), stdout=subprocess.PIPE, text=True) as run:
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
    """As timing.h has them: the median and half of what the middle half spans."""
    times = sorted(times)
    quarter = len(times) // 4
    return times[len(times) // 2], (times[len(times) - 1 - quarter] - times[quarter]) / 2


@functools.lru_cache(None)  # each is said once
def remark(text):
    print(f"bench: {text}; see tests/bench/README.md", file=sys.stderr)


def peer_program(name, command):
    """What a peer prints; none and a remark where it does not run, mostly as it is not installed."""
    try:
        done = subprocess.run([str(word) for word in command], env=environment(), capture_output=True, text=True)
        if done.returncode == 0:
            return [json.loads(line) for line in done.stdout.splitlines()]
        why = (done.stderr.strip() or f"exit code {done.returncode}").splitlines()[-1]
    except OSError as error:
        why = error.strerror
    remark(f"nothing measured beside {name} ({why})")
    return []


def peer_lines(name, script, *arguments):
    """The same of a script in this folder."""
    return peer_program(name, [PYTHON, os.path.join(HERE, script), *arguments])


def peer(name, script, *arguments):
    """The one number that it prints: processor seconds; None where what it needs is not installed."""
    found = peer_lines(name, script, *arguments)
    return found[0] if found else None


def row(bench, series, what, seconds, spread=None, error=None, of=None, beside=None, beside_seconds=None,
        roofline=None, headline=False, at=None, **more):
    """Seconds are processor seconds of one core unless `what` says otherwise, spread half of what the middle half of the
    runs spans, error the largest (relative to `of`, looked for `at` those only, else everywhere). beside is the peer,
    measured in the same run; roofline the seconds that the machine needs at the very least. The headlines are for the
    table of tools/docs/benchmarks.md. What is not known is not in the row."""
    all_of_it = {
        "bench": bench, "series": series, "what": what, "seconds": seconds, "spread": spread, "error": error,
        "error_of": of if error is not None else None, "error_at": at if error is not None else None,
        "peer": beside if beside_seconds else None,
        "ratio_peer": beside_seconds / seconds if beside_seconds else None,
        "ratio_roofline": seconds / roofline if roofline else None, "headline": headline, **more,
    }
    return {key: value for key, value in all_of_it.items() if value is not None}
