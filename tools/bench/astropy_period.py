"""Computes the same periodograms with astropy: one JSON line per method, with processor seconds and largest error.

Usage: astropy_period.py SAMPLES REFERENCE F0 DF NF. SAMPLES holds times, values and sigmas as float64; REFERENCE holds
exact powers at some frequencies."""
import json
import sys
import time

import astropy
import numpy
from astropy.timeseries import LombScargle


def processor_seconds(work, repeats):
    times = []
    for _ in range(repeats):
        start = time.process_time()
        result = work()
        times.append(time.process_time() - start)
    return sorted(times)[repeats // 2], result


def main():
    t, y, sigma = numpy.fromfile(sys.argv[1]).reshape(3, -1)
    with open(sys.argv[2]) as file:
        reference = json.load(file)
    f0, df, nf = float(sys.argv[3]), float(sys.argv[4]), int(sys.argv[5])
    grid = f0 + df * numpy.arange(nf)
    for method in ["fast"] + (["cython", "slow"] if len(t) * nf <= 1e7 else []):
        seconds, power = processor_seconds(
            lambda: LombScargle(t, y, sigma).power(grid, method=method, assume_regular_frequency=True),
            3 if method == "fast" else 1)
        error = float(numpy.abs(power[reference["k"]] - reference["power"]).max())
        print(json.dumps({"part": "astropy", "method": method, "version": astropy.__version__, "seconds": seconds,
                          "error": error}))


main()
