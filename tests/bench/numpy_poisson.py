"""Nanoseconds per count of numpy's Poisson generator with the same means; median of five, processor time."""
import sys
import time

import numpy

count = 1 << 18
means = 1e4 * 10 ** (float(sys.argv[1]) * (numpy.arange(count) * 7919 % count) / count)
generator = numpy.random.default_rng(1)
times = []
for _ in range(5):
    start = time.process_time()
    generator.poisson(means)
    times.append((time.process_time() - start) / count * 1e9)
print(sorted(times)[2])
