"""Size of the stripped library, its dependencies, and the time that a new process takes to load it."""
import os
import subprocess
import sys
import tempfile

from measuring import median_spread, row

REPEATS = 21
LOAD = """
import ctypes, sys, time
for path in sys.argv[2:]:
    ctypes.CDLL(path, ctypes.RTLD_GLOBAL)
start = time.perf_counter()
ctypes.CDLL(sys.argv[1])
print(time.perf_counter() - start)
"""


def load_times(library, *before):
    """Times of new processes that load the library after the libraries in `before`."""
    runs = [subprocess.run([sys.executable, "-c", LOAD, library, *before], capture_output=True, text=True, check=True)
            for _ in range(REPEATS)]
    return [float(run.stdout) for run in runs]


def measure(binaries):
    library = os.path.realpath(os.path.join(binaries, "..", "lib", "libtoliman.so"))
    with tempfile.NamedTemporaryFile() as stripped:
        subprocess.run(["strip", "-o", stripped.name, library], check=True)
        size = os.path.getsize(stripped.name)
    table = subprocess.run(["ldd", library], capture_output=True, text=True, check=True).stdout
    others = [line.split()[2] for line in table.splitlines() if " => /" in line]
    return {"bytes": size, "ldd": table, "whole_s": load_times(library), "own_s": load_times(library, *others)}


def rows(measured):
    for series, what in (("whole", "load the library and its dependencies"), ("own", "load the library alone")):
        yield row("load", series, what + ", wall time", *median_spread(measured[series + "_s"]),
                  headline=series == "whole")


def show(measured):
    print(f"{measured['bytes']:,} bytes stripped\n{measured['ldd']}", end="")
