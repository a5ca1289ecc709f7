"""Time of the periodograms against their error, on one core, beside astropy on the same samples.

Usage: bench_period.py FOLDER RESULT.json. FOLDER holds bench_period. Times are processor seconds."""
import json
import os
import subprocess
import sys
import tempfile
import time

os.environ.update({name: "1" for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS")})
import numpy
from astropy.timeseries import LombScargle

SPAN = 1000.0
GRIDS = [(1000, 10000), (10000, 10000), (100000, 10000), (1000000, 10000), (10000, 100000), (1000000, 100000)]


def samples(count):
    """Uneven times, a sine of an amplitude near the noise, sigmas that differ."""
    generator = numpy.random.default_rng(count)
    t = numpy.sort(generator.uniform(0, SPAN, count))
    sigma = generator.uniform(0.5, 1.5, count)
    return t, 3 + 0.7 * numpy.sin(2 * numpy.pi * 0.37 * t) + sigma * generator.normal(size=count), sigma


def processor_seconds(work, repeats):
    times = []
    for _ in range(repeats):
        start = time.process_time()
        result = work()
        times.append(time.process_time() - start)
    return sorted(times)[repeats // 2], result


def astropy_rows(count, f0, df, nf, reference):
    grid = f0 + df * numpy.arange(nf)
    t, y, sigma = samples(count)
    for method in ["fast"] + (["cython", "slow"] if count * nf <= 1e7 else []):
        seconds, power = processor_seconds(
            lambda: LombScargle(t, y, sigma).power(grid, method=method, assume_regular_frequency=True),
            3 if method == "fast" else 1)
        error = numpy.abs(power[reference["k"]] - reference["power"]).max()
        yield {"part": "astropy", "method": method, "seconds": seconds, "error": error}


def measure(program, count, nf):
    f0, df = 1.5 / SPAN, 0.1 / SPAN if nf == 10000 else 0.05 / SPAN
    with tempfile.NamedTemporaryFile() as file:
        for column in samples(count):
            file.write(column.tobytes())
        file.flush()
        done = subprocess.run([program, file.name, str(count), repr(f0), repr(df), str(nf)], stdout=subprocess.PIPE,
                              text=True)
    if done.returncode != 0:
        sys.exit(done.returncode)
    rows = [json.loads(line) for line in done.stdout.splitlines()]
    reference, = [row for row in rows if row["part"] == "reference"]
    rows += astropy_rows(count, f0, df, nf, reference)
    for row in rows:
        row.update(samples=count, frequencies=nf)
    return rows


def show(rows):
    best = {}
    print("one frame more, 10,000 frequencies\n                     push, ns a frequency   query   both, s")
    for row in rows:
        if row["part"] in ("frame", "wide") and (row["samples"], row["frequencies"]) == GRIDS[0]:
            best = row if row["part"] == "frame" else best
            name = row["isa"] + (", wide sums" if row["part"] == "wide" else "")
            print(f"{name:20s} {row['push_ns']:11.2f} {row['query_ns']:7.2f}   {row['seconds']:.2e}")
    for row in rows:
        if row["part"] == "astropy" and row["frequencies"] == GRIDS[0][1]:
            print(f"astropy {row['method']:7s} of all {row['samples']:8d} samples: {row['seconds']:.4f} s, "
                  f"{row['seconds'] / best['seconds']:,.0f} times a frame")
    for count, nf in GRIDS:
        print(f"\nall of {count} samples, {nf} frequencies\n{'':22s} seconds     error")
        for row in rows:
            if (row["samples"], row["frequencies"]) != (count, nf) or row["part"] in ("frame", "wide", "reference"):
                continue
            name = {"batch": "batch, tolerance %g" % row.get("tolerance", 0), "direct": "batch, direct sums",
                    "stream": "streaming, exact sums", "astropy": "astropy " + row.get("method", "")}[row["part"]]
            error = "      -" if row["error"] is None else f"{row['error']:.1e}"
            of = "samples" if row["part"] == "stream" else "frequencies"
            part = row.get("measured", 1)
            print(f"{name:22s} {row['seconds']:8.4f}   {error}"
                  + ("" if part == 1 else f"   ({100 * part:.2g} % of the {of} measured)"))


def main():
    program, rows = os.path.join(sys.argv[1], "bench_period"), []
    for count, nf in GRIDS:
        rows += measure(program, count, nf)
    show(rows)
    with open(sys.argv[2], "w") as out:
        json.dump(rows, out, indent=1)
    print(f"\n{sys.argv[2]}", file=sys.stderr)


main()
