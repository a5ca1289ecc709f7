"""Time of the periodograms against their error, on one core, beside astropy on the same samples. Times are processor
seconds."""
import os
import tempfile
import time

os.environ.update({name: "1" for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS")})
import numpy
from astropy.timeseries import LombScargle

from measuring import lines, row

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


def measure_one(program, count, nf):
    f0, df = 1.5 / SPAN, 0.1 / SPAN if nf == 10000 else 0.05 / SPAN
    with tempfile.NamedTemporaryFile() as file:
        for column in samples(count):
            file.write(column.tobytes())
        file.flush()
        found = lines([program, file.name, count, repr(f0), repr(df), nf])
    reference, = [one for one in found if one["part"] == "reference"]
    found += astropy_rows(count, f0, df, nf, reference)
    for one in found:
        one.update(samples=count, frequencies=nf)
    return found


def measure(binaries):
    program = os.path.join(binaries, "bench_period")
    return [one for count, nf in GRIDS for one in measure_one(program, count, nf)]


def rows(measured):
    fast = {(one["samples"], one["frequencies"]): one["seconds"] for one in measured
            if one["part"] == "astropy" and one["method"] == "fast"}
    frames = [one for one in measured if one["part"] == "frame" and (one["samples"], one["frequencies"]) == GRIDS[0]]
    for one in frames:
        yield row("one frame more", one["isa"], f"one frame more and 10,000 powers, {one['isa']}", one["seconds"], one["spread"], None, None,
                  "astropy fast, all 1,000", fast[GRIDS[0]], one["roofline"], one is frames[-1])
    for one in measured:
        grid = one["samples"], one["frequencies"]
        name = f"{one['samples']:,} samples, {one['frequencies']:,} frequencies"
        bench = "periodogram of " + name
        if one["part"] == "batch":
            headline = one["tolerance"] in (1e-3, 1e-9, 1e-13) and grid in (GRIDS[0], GRIDS[-1])
            yield row(bench, "batch", f"{name}, tolerance {one['tolerance']:g}", one["seconds"], one["spread"],
                      one["error"], None, "astropy fast", fast[grid], None, headline)
        elif one["part"] in ("direct", "stream", "astropy"):
            series = {"direct": "direct sums", "stream": "streaming, exact sums"}.get(one["part"])
            series = series or "astropy " + one["method"]
            part = one.get("measured", 1)
            yield row(bench, series, f"{name}, {series}" + (f", {part:.2g} of it measured" if part < 1 else ""),
                      one["seconds"], None, one["error"] if part == 1 else None)


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
