"""
The period of any time series
=============================

:func:`toliman.period` finds the period of times, values and errors, here radial velocities of nu Ophiuchi (Quirrenbach
et al. 2019), which has two companions.
"""
# %%
import numpy
import toliman

data = numpy.genfromtxt("../data/nu_oph_rv.csv", delimiter=",", skip_header=3)
t, velocity, sigma = data.T
peak = toliman.period(t, velocity, sigma)
peak

# %%
# The velocities, folded at the period:
peak.plot()

# %%
# The periodogram, with the power that noise alone exceeds in one of a thousand series:
grid = toliman.suited_grid(t)
periodogram = toliman.Periodogram(*grid)
periodogram.push_many(t, velocity, sigma)
periodogram.plot()

# %%
# It is that of astropy, to rounding.
from astropy.timeseries import LombScargle

reference = LombScargle(t, velocity, sigma)
difference = periodogram.power() - reference.power(periodogram.frequency, method="slow")
print(f"largest difference of power: {abs(difference).max():.1e}")
