"""Fits the forward model to frames of stars that follow their orbit, and finds the period of the signal.

    python3 moving.py [SCENE]                   by default examples/data/moving.json
"""
import pathlib
import sys

import numpy

TOP = pathlib.Path(__file__).resolve().parents[1]
sys.path.append(str(TOP.parent / "build" / "python"))  # if it is not installed
from toliman import Fit, Periodogram, Simulator

simulator = Simulator(sys.argv[1] if sys.argv[1:] else TOP / "data" / "moving.json")
times, _ = simulator.series()
frames = numpy.stack([simulator.frame(k) for k in range(len(times))])

# Each frame is expected where the orbit is at its time; the displacement is what differs from that.
results = Fit(simulator).frames(frames, times_days=times)
with Periodogram(0.01, 0.001, 200, sigma_floor=2e-5) as periodogram:
    for t, result in zip(times, results):
        if numpy.isfinite(result["displacement_px"]):
            periodogram.push(t, result["displacement_px"], result["separation_sigma_px"])
    peak = periodogram.peak()
print(f"separation {results['separation_px'][0]:.3f} px at first, {results['separation_px'][-1]:.3f} px at the end")
print(f"period {peak.period:.2f} days")
