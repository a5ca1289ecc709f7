"""Runs all benchmarks and prints error, reference and speed-up of each (make bench).

Usage: bench.py BIN OUT [NAME ...]. BIN is the folder of the programs; NAME is sim, cae, period, weights, fit, coadd, calibrate, python,
commands, growth or size (default: all). A single NAME also prints its details. Writes OUT/NAME.json (schema toliman-bench/1) and prints
the table of tools/docs/benchmarks.md. Exits with 1 if a time is below its hardware lower bound, and leaves that row
out."""
import datetime
import importlib
import json
import os
import subprocess
import sys

import table

NAMES = ("sim", "cae", "period", "weights", "fit", "coadd", "calibrate", "python", "commands", "growth", "size")


def machine(binaries):
    """Properties reported by `toliman doctor`; exits if OpenBLAS uses kernels older than the processor supports."""
    from measuring import environment
    done = subprocess.run([os.path.join(binaries, "toliman"), "doctor", "--json"], env=environment(),
                          stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    properties = json.loads(done.stdout)  # the exit code is ignored: a slow disk does not matter
    if properties["blas_is_slow"]:
        sys.exit(f"bench: OpenBLAS runs its {properties['blas_core']} kernels; set OPENBLAS_CORETYPE")
    return properties


def split(rows):
    """The rows that can be true, and a message for each that cannot: a time below its lower bound."""
    good = [row for row in rows if row.get("ratio_roofline", 1) >= 1]
    return good, [f"bench: {row['what']}: takes {row['ratio_roofline']:.2f} of its lower bound: the bound is wrong"
                  for row in rows if row not in good]


def main():
    binaries, out, names = sys.argv[1], sys.argv[2], sys.argv[3:] or NAMES
    unknown = [name for name in names if name not in NAMES]
    if unknown:
        print(f"bench: unknown benchmark {unknown[0]}: must be one of {', '.join(NAMES)}", file=sys.stderr)
        return 2
    # All modules are imported first: a missing dependency is reported before anything is measured.
    benches = [importlib.import_module(name) for name in names]
    os.makedirs(out, exist_ok=True)
    properties = {"date": datetime.date.today().isoformat(), **machine(binaries)}
    print(f"{properties['date']}, {properties['cpu']}, one core; kernels {properties['isa']}, OpenBLAS {properties['blas_core']}\n")
    everything, errors = [], []
    for name, bench in zip(names, benches):
        measured = bench.measure(binaries)
        rows, wrong = split(list(bench.rows(measured)))
        everything += rows
        errors += wrong
        with open(os.path.join(out, name + ".json"), "w") as file:
            json.dump({"schema": "toliman-bench/1", "machine": properties, "rows": rows, "details": measured}, file, indent=1)
        if len(names) == 1:
            bench.show(measured)
            print()
    print(table.markdown([{"machine": properties, "rows": everything}]), end="")
    print("".join(error + "\n" for error in errors), end="", file=sys.stderr)
    return 1 if errors else 0


if __name__ == "__main__":
    sys.exit(main())
