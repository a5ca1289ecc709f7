"""Period of nu Ophiuchi's radial velocities, pushed one by one, as they were measured."""
import pathlib
import sys

import numpy

root = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(root / "bindings" / "python"))
import toliman  # noqa: E402

t, y, sigma = numpy.genfromtxt(root / "examples" / "data" / "nu_oph_rv.csv", delimiter=",", skip_header=3, unpack=True)
with toliman.Periodogram(1e-4, 2e-5, 2500, time_offset=t[0], sigma_floor=sigma.min()) as periodogram:
    for sample in zip(t, y, sigma):
        periodogram.push(*sample)
    peak = periodogram.fit(t, y, sigma)
print(f"period {peak.period:.2f} days, log10 FAP {peak.log10_fap:.1f}, from {t.size} velocities")
