"""Tests that what every public function computes has the same bits in another process and on other instruction sets, OpenBLAS
kernels and threads, but for the modules that ALLOWED names. Prints how many calls of each module differ. TOLIMAN_DIGESTS is
the program digests; TOLIMAN_ORDERS tests every choice instead of a few; TOLIMAN_DIGESTS_OF names what `digests 0` printed on
another architecture (tests/elsewhere)."""
import collections
import os
import subprocess
import sys

PROGRAM = os.environ["TOLIMAN_DIGESTS"]
FULL = "TOLIMAN_ORDERS" in os.environ
OTHER = os.environ.get("TOLIMAN_DIGESTS_OF", "")

NETWORKS = {"cae", "bank", "track network"}  # float32 with fused multiply-adds
MATRICES = {"bank", "cae", "calibration", "coadd", "components", "fit", "linear", "mask", "sim", "track network", "track fit",
            "track template"}
ALLOWED = {"process": set(), "avx2": set(), "baseline": NETWORKS, "OpenBLAS kernels": MATRICES, "OpenBLAS threads": {"components"},
           "architecture": NETWORKS | MATRICES | {"planet", "sky"}}
# Of the other modules, calls whose numbers go through functions of the C library, ERFA and FFTW, which differ between
# architectures in the last bits. Sums, powers, peaks, verdicts and files do not.
ALLOWED_CALLS = {"architecture": {
    "toliman_period_query_fit, rows", "toliman_period_batch", "toliman_period_batch, FFT", "toliman_period_batch, threads",
    "toliman_measure_load_file, state folder", "toliman_measure_query_instruments", "toliman_measure_query_noise",
    "toliman_track_create, reduced again", "toliman_track_push, reduced", "toliman_track_query_fit",
    "toliman_track_get_intervals", "toliman_track_get_intervals, too small", "toliman_track_get_measure"}}
CORES = ("Prescott", "Nehalem", "Sandybridge", "Haswell", "Zen") if FULL else ()


def module(call):
    """period of "toliman_period_push, NaN"; "track fit" of calls of a tracker with an estimator."""
    name, _, variant = call.partition(", ")
    words = name.split("_")
    if words[1] == "track" and variant in ("network", "template", "fit"):
        return "track " + variant
    return words[1] if len(words) > 2 and words[1] not in ("get", "last", "abi", "constant") else "base"


def parsed(text):
    lines = dict(line.split("\t") for line in text.splitlines())
    lines.pop("toliman_get_machine")  # names the settings
    return lines


def digests(isa, **environment):
    """Digest of each call, or None if the processor does not support the instruction set."""
    run = subprocess.run([PROGRAM, str(isa)], capture_output=True, text=True,
                         env={**os.environ, "OPENBLAS_NUM_THREADS": "1", **environment})
    if run.returncode == 77:
        return None
    if run.returncode:
        sys.exit(run.stdout + run.stderr)
    return parsed(run.stdout)


def runs():
    """Digests of the best instruction set, and of (axis, others)."""
    best, first = next((isa, found) for isa in (2, 1, 0) if (found := digests(isa)))
    others = [(name, digests(isa)) for isa, name in enumerate(("baseline", "avx2")) if isa < best and (FULL or isa == 0)]
    if FULL or not others:
        others.append(("process", digests(best)))
    others += [("OpenBLAS kernels", digests(best, OPENBLAS_CORETYPE=core)) for core in CORES]
    others += [("OpenBLAS threads", digests(best, OPENBLAS_NUM_THREADS="2"))] if FULL else []
    return first, others


# promises: processors-change-little, threads-change-no-bit
def main():
    first, others = runs()
    if OTHER:
        with open(OTHER, encoding="utf-8") as stream:
            others.append(("architecture", parsed(stream.read())))
    calls = collections.Counter(map(module, first))
    differ = {}
    bad = []
    for axis, found in others:
        assert found.keys() == first.keys()
        changed = [call for call in first if found[call] != first[call]]
        differ.setdefault(axis, set()).update(changed)
        bad += [(axis, call) for call in changed
                if module(call) not in ALLOWED[axis] and call not in ALLOWED_CALLS.get(axis, ())]
    print(f"{'calls that differ':20}" + "".join(f"{axis:>22}" for axis in differ))
    for name in sorted(calls):
        cells = [sum(module(call) == name for call in changed) for changed in differ.values()]
        print(f"{name:14}{calls[name]:6}" + "".join(f"{cell or '=':>22}" for cell in cells))
    for axis, call in bad:
        print(f"{axis}: {call} must have the same bits")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
