"""Fits the forward model to frames of stars that follow their orbit, and finds the period of the signal.

    python3 moving.py [SCENE]                   by default examples/data/moving.json
"""
import pathlib
import sys

import numpy

TOP = pathlib.Path(__file__).resolve().parents[1]
sys.path.append(str(TOP.parent / "build" / "python"))  # if it is not installed
import toliman

simulator = toliman.Simulator(sys.argv[1] if sys.argv[1:] else TOP / "data" / "moving.json")
times, _, frames = toliman.simulate(simulator)

# Each frame is expected where the orbit is at its time; the displacement is what differs from that.
results = toliman.Fit(simulator).frames(frames, times_days=times)
has_fit = numpy.isfinite(results["displacement_px"])
peak = toliman.period(times[has_fit], results["displacement_px"][has_fit], results["separation_sigma_px"][has_fit])
print(f"separation {results['separation_px'][0]:.3f} px at first, {results['separation_px'][-1]:.3f} px at the end")
print(f"period {peak.period:.2f} days")
