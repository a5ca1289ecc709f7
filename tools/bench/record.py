"""Records the results of `make bench` in recorded.json and writes the tables of README.md and tools/docs/benchmarks.md
from it (make record).

Usage: record.py [OUT]. OUT is the folder of the results; without it, only the tables are written. recorded.json keeps
the newest results of a processor, and those of one other processor for comparison."""
import json
import os
import sys

import table
from bench import NAMES
from measuring import HERE, SHORT

RECORD = os.path.join(HERE, "recorded.json")
ROOT = os.path.join(HERE, "..", "..")
BEGIN, END = "<!-- table of make record -->\n", "<!-- end of the table -->\n"
# The rows of README.md, by the beginning of their description.
MAIN = ('image of 101 wavelengths, 0.2"/px, accuracy 1e-9', "encode a frame, flight",
        "training step of 16 images, per image, flight", "push one frame", "1,000,000 samples, 100,000 frequencies, tolerance 1e-09", "toliman psf", "toliman run",
        "toliman track, network 256x256, --every 1, --jobs 1",
        "fit a frame of sky.json, 256 x 256 px, prediction off by 0.3 px rms",
        "encode the frame by a network of a bank, beyond the fit, predicted separation exact",
        "toliman encode, fit 256x256, 2 cores", "toliman calibrate")


def newest(out):
    """The results in a folder as one object, with the rows of the tables only."""
    files = []
    for name in NAMES:
        path = os.path.join(out, name + ".json")
        if not os.path.exists(path):
            sys.exit(f"record: {path}: is missing: run make bench")
        with open(path) as file:
            files.append(json.load(file))
    if any(one["machine"]["cpu"] != files[0]["machine"]["cpu"] for one in files):
        sys.exit(f"record: {out}: must be the results of make bench on one machine")
    rows = [row for one in files for row in one["rows"] if row["headline"]]
    machine = {key: value for key, value in files[0]["machine"].items() if key != "fsync_folder"}  # a path of its own
    return {"schema": files[0]["schema"], "machine": machine, "rows": rows, "details": []}


def with_newest(recorded, result):
    others = [one for one in recorded if one["machine"]["cpu"] != result["machine"]["cpu"]]
    return [result] + others[:1]


def section(recorded, wanted):
    """The text between the marks: what was measured, and the table."""
    machines = "; ".join(f"{table.processor(one['machine'])}, {one['machine']['isa']} kernels, {one['machine']['date']}"
                         for one in recorded)
    return f"Measured on: {machines}.\n\n" + table.markdown(recorded, wanted)


def with_section(text, recorded, wanted):
    """A document with the section between its marks."""
    before, _, rest = text.partition(BEGIN)
    _, end, after = rest.partition(END)
    if not end:
        sys.exit(f"record: a document has no lines {BEGIN}{END}")
    return before + BEGIN + section(recorded, wanted) + END + after


def documents(recorded):
    """Pairs of a path and what the document should be."""
    for path, wanted in (("README.md", lambda row: row["what"].startswith(MAIN)),
                         ("tools/docs/benchmarks.md", lambda row: row["headline"])):
        with open(os.path.join(ROOT, path), encoding="utf-8") as file:
            yield os.path.join(ROOT, path), with_section(file.read(), recorded, wanted)


def main():
    with open(RECORD) as file:
        recorded = json.load(file)
    if len(sys.argv) > 1:
        if SHORT:
            sys.exit("record: BENCH_SHORT is set: the times of few repeats are not recorded")
        recorded = with_newest(recorded, newest(sys.argv[1]))
        with open(RECORD, "w") as file:
            json.dump(recorded, file, indent=1)
            file.write("\n")
    for path, text in documents(recorded):
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)


if __name__ == "__main__":
    main()
