"""
What a spacecraft sees of alpha Centauri
========================================

The velocity of a telescope in a low orbit moves the stars by differential aberration: in the course of a day, by more
than a hundred Earths.
"""
# %%
# The separation for an observer at the Earth's centre, and in a sun-synchronous orbit at 600 km, every minute of three
# hours.
import matplotlib.pyplot as plt
import numpy
import toliman

minutes = numpy.arange(180)
times = toliman.parse_time("2027-05-01") + minutes * 60 * 10**9
spacecraft = toliman.Sky("alpha-cen", altitude_km=600)
without = toliman.Sky("alpha-cen", altitude_km=600, without="spacecraft_aberration")
seen, still = spacecraft.predict(times), without.predict(times)
uas = 1e6 * (seen["separation_arcsec"] - still["separation_arcsec"])
figure, axes = plt.subplots()
axes.plot(minutes, uas)
axes.set_xlabel("minutes of 2027-05-01")
axes.set_ylabel("aberration by the orbit, µas")

# %%
# Exposures average over it. A measured separation, divided by the factor of its exposure, minus the separation on the
# orbit, is what planets and noise leave: here an Earth of 2.5 microarcsec.
exposures = numpy.stack([times[::10], times[::10] + 600 * 10**9], axis=1)
mean = spacecraft.predict_exposures(exposures)
measured = mean["factor"] * (mean["geometric_arcsec"] + 2.5e-6)
reduced = spacecraft.reduce(exposures, measured, 1e-6)
print(f"reduced: {1e6 * reduced.y.mean():.3f} microarcsec")
reduced
