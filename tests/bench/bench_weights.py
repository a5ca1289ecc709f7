"""Bytes of the weights blob against what they are worth, for every encoding of weights and planes.

Usage: bench_weights.py FOLDER. FOLDER holds bench_weights; the table is that of lib/FORMATS.md."""
import json
import os
import subprocess
import sys
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, "..", "support"))
import numpy
import tlmw


def largest_error(narrow, exact):
    """Of a number relative to itself, where it is at least 1e-6 of its tensor's or plane's largest."""
    worst = 0
    for a, b in zip(narrow, exact):
        large = abs(b) > 1e-6 * abs(b).max()
        worst = max(worst, (abs(a - b)[large] / abs(b)[large]).max(initial=0))
    return worst


def main():
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run([os.path.join(sys.argv[1], "bench_weights"), folder], stdout=subprocess.PIPE, text=True)
        if done.returncode != 0:
            sys.exit(done.returncode)
        rows = [json.loads(line) for line in done.stdout.splitlines()]
        blobs = [tlmw.Blob(os.path.join(folder, "%(weights)s-%(planes)s.tlmw" % row)) for row in rows]
    whole = blobs[0]
    print("| weights | planes | bytes | of raw float32 | error of weights | of planes | slope | bias | change | "
          "flux | shift | efficiency |")
    print("|---|---|---|---|---|---|---|---|---|---|---|---|")
    for row, blob in zip(rows, blobs):
        figures = (blob.size / whole.raw_size, largest_error(blob.weights, whole.weights),
                   largest_error(blob.planes, whole.planes), row["slope"] - rows[0]["slope"],
                   row["bias"], row["change"], row["flux"], row["shift"])
        print(f"| {row['weights']} | {row['planes']} | {blob.size:,} | {figures[0]:.3f} | "
              + " | ".join(f"{figure:.1e}" if figure else "0" for figure in figures[1:])
              + f" | {row['efficiency']:.4f} |")


main()
