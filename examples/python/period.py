"""Finds the period of samples. In the source tree: PYTHONPATH=build/python /usr/bin/python3 examples/python/period.py"""
import numpy
import toliman

t = numpy.arange(200.0)  # your samples; here with a period of 17 days
y = t % 17
fit = toliman.period(t, y)  # period(t, y, dy) with standard errors
print(f"period {fit.period:.3f} +- {fit.period_error:.3f} days")
