"""Runs all benchmarks and prints error, reference and speed-up of each (make bench).

Usage: bench.py BIN OUT [NAME ...]. BIN is the folder of the programs; NAME is sim, cae, period, weights, run or size
(default: all). A single NAME also prints its details. Writes OUT/NAME.json (schema toliman-bench/1) and prints the
table of tools/docs/benchmarks.md."""
import datetime
import importlib
import json
import os
import subprocess
import sys

NAMES = ("sim", "cae", "period", "weights", "run", "size")


def machine(binaries):
    """Properties reported by `toliman doctor`; exits if OpenBLAS uses kernels older than the processor supports."""
    from measuring import environment
    done = subprocess.run([os.path.join(binaries, "toliman"), "doctor", "--json"], env=environment(),
                          stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    properties = json.loads(done.stdout)  # the exit code is ignored: a slow disk does not matter
    if properties["blas_is_slow"]:
        sys.exit(f"bench: OpenBLAS runs its {properties['blas_core']} kernels; set OPENBLAS_CORETYPE")
    return properties


def number(value, form):
    return "" if value is None else format(value, form)


def seconds(value):
    """In s, ms or us, depending on the value."""
    for unit, size in (("s", 1), ("ms", 1e-3), ("us", 1e-6)):
        if value >= size:
            break
    return f"{value / size:.3g} {unit}"


def spread(row):
    if "spread" not in row:
        return ""
    part = row["spread"] / row["seconds"]
    return f"{part:.0%}" if part >= 0.005 else "<1%"


def error(row):
    """For example "1e-9 of peak at 196 pixels"."""
    if "error" not in row:
        return ""
    at = "at " + row["error_at"] if "error_at" in row else ""
    return " ".join(word for word in (f"{row['error']:.0e}", row.get("error_of"), at) if word)


def print_table(rows):
    print("| what | time | +- | error | reference | speed-up | x roofline |\n|---|---|---|---|---|---|---|")
    for r in rows:
        print(f"| {r['what']} | {seconds(r['seconds'])} | {spread(r)} | {error(r)} | {r.get('peer', '')} | "
              f"{number(r.get('ratio_peer'), ',.3g')} | {number(r.get('ratio_roofline'), '.2f')} |")


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
    print(f"{properties['date']}, {properties['cpu']}, one core; kernels {properties['isa']}, OpenBLAS {properties['blas_core']} "
          f"{properties['blas_gflops']:.0f} GFLOP/s\n")
    everything = []
    for name, bench in zip(names, benches):
        measured = bench.measure(binaries)
        rows = list(bench.rows(measured))
        everything += rows
        with open(os.path.join(out, name + ".json"), "w") as file:
            json.dump({"schema": "toliman-bench/1", "machine": properties, "rows": rows, "details": measured}, file, indent=1)
        if len(names) == 1:
            bench.show(measured)
            print()
    print_table([r for r in everything if r["headline"]])
    return 0


if __name__ == "__main__":
    sys.exit(main())
