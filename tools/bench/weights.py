"""Size of the weights blob and performance of the network for every encoding of weights and planes; the table is that
of tools/docs/formats.md."""
import os
import sys
import tempfile

from measuring import HERE, lines, row

sys.path.insert(0, os.path.join(HERE, "..", "..", "tests", "support"))
import numpy
import tlmw


def largest_error(narrow, exact):
    """Largest relative error of the numbers that are at least 1e-6 of the largest in their tensor or plane."""
    worst = 0
    for a, b in zip(narrow, exact):
        large = abs(b) > 1e-6 * abs(b).max()
        worst = max(worst, (abs(a - b)[large] / abs(b)[large]).max(initial=0))
    return worst


def measure(binaries):
    with tempfile.TemporaryDirectory() as folder:
        found = lines([os.path.join(binaries, "bench_weights"), folder])
        blobs = [tlmw.Blob(os.path.join(folder, "%(weights)s-%(planes)s.tlmw" % one)) for one in found]
    for one, blob in zip(found, blobs):
        one.update(bytes=blob.size, of_raw=blob.size / blobs[0].raw_size,
                   weights_error=largest_error(blob.weights, blobs[0].weights),
                   planes_error=largest_error(blob.planes, blobs[0].planes))
    return found


def rows(measured):
    for one in measured:
        change = one["change"] if one is not measured[0] else None  # relative to the first row
        yield row("weights", f"planes {one['planes']}", f"load weights in {one['weights']}, planes in {one['planes']}: "
                  f"{one['bytes'] / 1e6:.2f} MB", one["load_s"], one["load_spread"], change, "of sigma, rms",
                  headline=one["weights"] == one["planes"], bytes=one["bytes"], efficiency=one["efficiency"])


def show(measured):
    print("| weights | planes | bytes | of raw float32 | error of weights | of planes | slope | bias | change | "
          "flux | shift | efficiency |")
    print("|---|---|---|---|---|---|---|---|---|---|---|---|")
    for one in measured:
        figures = (one["weights_error"], one["planes_error"], one["slope"] - measured[0]["slope"], one["bias"],
                   one["change"], one["flux"], one["shift"])
        print(f"| {one['weights']} | {one['planes']} | {one['bytes']:,} | {one['of_raw']:.3f} | "
              + " | ".join(f"{figure:.1e}" if figure else "0" for figure in figures)
              + f" | {one['efficiency']:.4f} |")
