"""
Track a downlink
================

Frames arrive late, twice or damaged. A :class:`Tracker` records each in a ledger, once, and updates the periodogram; the
result has the same bits for any order of arrival.
"""
# %%
# Frames of 100 days, which are received out of order, some of them twice, and one with lost packets.
import tempfile
import warnings

import numpy
import toliman

simulator = toliman.Simulator("../data/moving.json")
times, displacements, frames = toliman.simulate(simulator)
zero_ns = simulator.info.time_zero_ns
sent = [toliman.Frame(image, frame_id=k, camera_ns=zero_ns + int(t * 86400e9))
        for k, (t, image) in enumerate(zip(times, frames))]
order = numpy.random.default_rng(1).permutation(len(frames))
received = [sent[k] for k in [*order, *order[:5]]]
lost = received[3]
received[3] = toliman.Frame(lost.pixels * numpy.nan, lost.frame_id, lost.camera_ns)

# %%
# :func:`toliman.track` has the defaults of ``toliman track``. It warns of what it did not accept.
folder = tempfile.mkdtemp()
with warnings.catch_warnings(record=True) as caught:
    warnings.simplefilter("always")
    with toliman.track(simulator, received, folder=folder) as tracker:
        print(tracker)
print(caught[0].message)

# %%
# The next downlink of the same frames: known ones are duplicates, the damaged one is there now.
with toliman.track(simulator, sent, folder=folder) as tracker:
    print(tracker)
    series = tracker.measurements()
series.plot()

# %%
peak = toliman.period(series.t, series.y, series.sigma)
peak.plot()

# %%
# The folder has all that was measured.
table = toliman.Measurements(folder).to_table()
table["t", "y", "sigma"][:5]
