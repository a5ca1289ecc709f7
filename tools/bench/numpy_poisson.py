"""Seconds per count of numpy's Poisson generator with the same means: the median of five, processor time, of the
faster of its default and its fastest bit generator. Prints them with numpy's version as JSON."""
import json
import sys
import time

import numpy

COUNT = 1 << 18


def seconds_per_count(bits, means):
    generator, times = numpy.random.Generator(bits(1)), []
    for _ in range(5):
        start = time.process_time()
        generator.poisson(means)
        times.append((time.process_time() - start) / COUNT)
    return sorted(times)[2]


def main():
    means = 1e4 * 10 ** (float(sys.argv[1]) * (numpy.arange(COUNT) * 7919 % COUNT) / COUNT)
    best = min(seconds_per_count(bits, means) for bits in (numpy.random.PCG64, numpy.random.SFC64))
    print(json.dumps({"name": f"numpy {numpy.__version__}", "seconds": best}))


main()
