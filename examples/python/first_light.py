"""The whole pipeline in Python: simulates a scene, trains the network, encodes frame by frame, prints the period.

    python3 first_light.py [SCENE]              a file, or the name of a shipped scene; chapter.json by default
"""
import pathlib
import sys

sys.path.append(str(pathlib.Path(__file__).resolve().parents[2] / "build" / "python"))  # if it is not installed
from toliman import CAE, Periodogram, Simulator, suited_grid

simulator = Simulator(sys.argv[1] if sys.argv[1:] else "chapter.json", progress=True)
network = CAE(simulator)
network.train(progress=True)

times, _ = simulator.series()
with Periodogram(*suited_grid(times)) as periodogram:
    for k, t in enumerate(times):
        latent = network.encode(simulator.frame(k))
        periodogram.push(t, latent)
    peak = periodogram.peak()
print(f"true period {simulator.info.period_days:g} days, found {peak.period:.2f} days, log10 FAP {peak.log10_fap:.1f}")
