"""Bytes of the stripped library, what it loads, and how long a fresh process takes to load it. Usage: bench_size.py bin"""
import os
import statistics
import subprocess
import sys
import tempfile

LOAD = """
import ctypes, sys, time
for path in sys.argv[2:]:
    ctypes.CDLL(path, ctypes.RTLD_GLOBAL)
start = time.perf_counter()
ctypes.CDLL(sys.argv[1])
print(time.perf_counter() - start)
"""


def milliseconds(library, *before):
    """Median of 21 processes: to load the library after these."""
    runs = [subprocess.run([sys.executable, "-c", LOAD, library, *before], capture_output=True, text=True, check=True)
            for _ in range(21)]
    return 1e3 * statistics.median(float(run.stdout) for run in runs)


library = os.path.realpath(os.path.join(sys.argv[1], "..", "lib", "libtoliman.so"))
with tempfile.NamedTemporaryFile() as stripped:
    subprocess.run(["strip", "-o", stripped.name, library], check=True)
    print(f"{os.path.basename(library)}: {os.path.getsize(stripped.name):,} bytes stripped")
table = subprocess.run(["ldd", library], capture_output=True, text=True, check=True).stdout
print(table, end="")
others = [line.split()[2] for line in table.splitlines() if " => /" in line]
print(f"loaded in {milliseconds(library):.1f} ms, {milliseconds(library, *others):.1f} ms of it its own")
