"""Time and error of the periodograms on one core, compared with astropy on the same samples. Times are processor
seconds."""
import json
import os
import tempfile

import numpy

from measuring import SHORT, lines, peer_lines, row

SPAN = 1000.0
FRAMES = {"frame": "", "double_limb": ", double-limb", "nuisance": ", {} functions"}  # parts of one frame
GRIDS = [(1000, 10000), (10000, 10000), (100000, 10000), (1000000, 10000), (1000000, 100000)]


def samples(count):
    """Uneven times, a sine with an amplitude near the noise, unequal sigmas."""
    generator = numpy.random.default_rng(count)
    t = numpy.sort(generator.uniform(0, SPAN, count))
    sigma = generator.uniform(0.5, 1.5, count)
    return t, 3 + 0.7 * numpy.sin(2 * numpy.pi * 0.37 * t) + sigma * generator.normal(size=count), sigma


def measure_one(program, count, nf):
    grid = [repr(1.5 / SPAN), repr(0.1 / SPAN if nf == 10000 else 0.05 / SPAN), nf]
    with tempfile.TemporaryDirectory() as folder:
        file, exact = os.path.join(folder, "samples"), os.path.join(folder, "reference.json")
        numpy.concatenate(samples(count)).tofile(file)
        found = lines([program, file, count, *grid])
        reference, = [one for one in found if one["part"] == "reference"]
        with open(exact, "w") as out:
            json.dump(reference, out)
        found += peer_lines("astropy", "astropy_period.py", file, exact, *grid)
    found.remove(reference)
    for one in found:
        one.update(samples=count, frequencies=nf, compared=len(reference["k"]))
    return found


def measure(binaries):
    program = os.path.join(binaries, "bench_period")
    return [one for count, nf in GRIDS[:2 if SHORT else None] for one in measure_one(program, count, nf)]


def rows(measured):
    fast = {(one["samples"], one["frequencies"]): (f"astropy {one['version']} fast", one["seconds"]) for one in measured
            if one["part"] == "astropy" and one["method"] == "fast"}
    frames = [one for one in measured if one["part"] == "frame" and (one["samples"], one["frequencies"]) == GRIDS[0]]
    name, seconds = fast.get(GRIDS[0], (None, None))
    error = next((one["error"] for one in measured if one["part"] == "stream" and one["samples"] == GRIDS[0][0]), None)
    for one in frames:
        yield row("one frame", one["isa"], f"push one frame, query 10,000 powers, {one['isa']}", one["seconds"],
                  one["spread"], error, None, name and name + ", all 1,000 samples", seconds, one["roofline"],
                  one is frames[-1])
    for one in measured:
        if one["part"] == "nuisance" and (one["samples"], one["frequencies"]) == GRIDS[0]:
            yield row("one frame", one["isa"], f"push one frame, query 10,000 powers, {one['functions']} functions, "
                      f"{one['isa']}", one["seconds"], one["spread"], None, None, None, None, one["roofline"],
                      one["isa"] == frames[-1]["isa"])
    for one in measured:
        grid = one["samples"], one["frequencies"]
        name = f"{one['samples']:,} samples, {one['frequencies']:,} frequencies"
        bench = "periodogram of " + name
        at = None if one["compared"] == one["frequencies"] else f"{one['compared']} frequencies"
        if one["part"] == "batch":
            headline = one["tolerance"] == 1e-9 or one["tolerance"] in (1e-3, 1e-13) and grid in (GRIDS[0], GRIDS[-1])
            yield row(bench, "batch", f"{name}, tolerance {one['tolerance']:g}", one["seconds"], one["spread"],
                      one["error"], None, *fast.get(grid, (None, None)), None, headline, at)
        elif one["part"] == "batch_nuisance" and one["functions"] > 1:
            yield row(bench, "batch", f"{name}, tolerance 1e-09, {one['functions']} functions", one["seconds"],
                      one["spread"], one["error"], headline=one["functions"] == 5 and grid == GRIDS[0])
        elif one["part"] in ("direct", "stream", "astropy"):
            series = {"direct": "direct sums", "stream": "streaming, exact sums"}.get(one["part"])
            series = series or "astropy " + one["method"]
            part = one.get("measured", 1)
            yield row(bench, series, f"{name}, {series}" + (f", extrapolated from {part:.2g}" if part < 1 else ""),
                      one["seconds"], None, one["error"] if part == 1 else None, at=at)


def show(rows):
    best = {}
    print("push one frame, query 10,000 frequencies\n                     push, ns/frequency   query   both, s    bytes/frequency")
    for row in rows:
        if row["part"] in FRAMES and (row["samples"], row["frequencies"]) == GRIDS[0]:
            best = row if row["part"] == "frame" else best
            name = row["isa"] + FRAMES[row["part"]].format(row["functions"])
            print(f"{name:20s} {row['push_ns']:18.2f} {row['query_ns']:7.2f}   {row['seconds']:.2e} {row['bytes']:8.0f}")
    for row in rows:
        if row["part"] == "astropy" and row["frequencies"] == GRIDS[0][1]:
            print(f"astropy {row['method']:7s}, all {row['samples']:8d} samples: {row['seconds']:.4f} s, "
                  f"speed-up per frame {row['seconds'] / best['seconds']:,.0f}")
    for count, nf in GRIDS:
        print(f"\n{count} samples, {nf} frequencies\n{'':22s} seconds     error")
        for row in rows:
            if (row["samples"], row["frequencies"]) != (count, nf) or row["part"] in (*FRAMES, "reference"):
                continue
            name = {"batch": "batch, tolerance %g" % row.get("tolerance", 0), "direct": "batch, direct sums",
                    "batch_nuisance": "batch, 1e-9, K = %d" % row.get("functions", 0),
                    "stream": "streaming, exact sums", "astropy": "astropy " + row.get("method", "")}[row["part"]]
            error = "      -" if row["error"] is None else f"{row['error']:.1e}"
            of = "samples" if row["part"] == "stream" else "frequencies"
            part = row.get("measured", 1)
            print(f"{name:22s} {row['seconds']:8.4f}   {error}"
                  + ("" if part == 1 else f"   ({100 * part:.2g} % of the {of} measured)"))
