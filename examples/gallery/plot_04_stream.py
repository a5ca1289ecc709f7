"""
A periodogram that grows with each sample
=========================================

A :class:`Periodogram` takes samples one at a time, in any order, and its state does not grow.
"""
# %%
# A signal of 17 days in noise twice as large, at 200 times of a year.
import matplotlib.pyplot as plt
import numpy
import toliman

random = numpy.random.default_rng(3)
t = numpy.sort(random.uniform(0, 365, 200))
y = numpy.sin(2 * numpy.pi * t / 17) + random.normal(scale=2, size=t.size)

# %%
# The false alarm probability after each sample of the second half, as an operator would watch it: the grid is that of
# the whole mission, 365 days.
grid = toliman.suited_grid(t[:30], mission_span=365)
periodogram = toliman.Periodogram(*grid, sigma_floor=2)
history = []
for time, value in zip(t, y):
    periodogram.push(time, value, 2)
    if time > 180:
        history.append((time, periodogram.peak().log10_fap, periodogram.peak().period))
days, log10_fap, period = numpy.array(history).T
figure, (top, bottom) = plt.subplots(2, sharex=True)
top.plot(days, log10_fap)
top.set_ylabel("log10 FAP")
bottom.plot(days, period, ".")
bottom.axhline(17)
bottom.set_ylabel("period, days")
bottom.set_xlabel("time, days")

# %%
# The order does not matter: the same sums, to the last bit, and so the same powers.
other = toliman.Periodogram(*grid, sigma_floor=2)
order = random.permutation(t.size)
other.push_many(t[order], y[order], 2)
assert (other.power() == periodogram.power()).all()
peak = periodogram.fit(t, y, 2)
peak
