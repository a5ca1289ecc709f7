"""
Orbit, mass and limits of a planet
==================================

A search compares models with and without a planet, and samples the posterior of its orbit.
"""
# %%
# Reduced separations of two years, in arcsec, with an error of 1 microarcsec, and a planet of A with the period of an
# Earth at 1.2 au.
import numpy
import toliman

random = numpy.random.default_rng(5)
t = numpy.arange(0, 730, 4.0)
signal = 2.5e-6 * numpy.cos(2 * numpy.pi * t / 200 + 1)
y = signal + random.normal(scale=1e-6, size=t.size)
series = toliman.Measurements.of(t, y, 1e-6, kind="reduced", unit=1)
series.plot()

# %%
# The search: how much more probable is a planet than noise, and what are its orbit and mass?
found = toliman.planets(series, parallax_arcsec=0.75, star_masses=(1.08, 0.91), samples=2000)
planet = found.planets[0]
print(f"log10 of the odds {planet.log10_bayes:.1f}; period {planet.period[1]:.1f} "
      f"(+{planet.period[2] - planet.period[1]:.1f} -{planet.period[1] - planet.period[0]:.1f}) days")
found.plot_folded()

# %%
# Samples of the posterior, and all pairs of their columns:
found.plot_corner()

# %%
# What the series excludes in addition, as masses of planets of star A, and what a search would have found:
found.plot_limits(numpy.geomspace(60, 700, 12))
