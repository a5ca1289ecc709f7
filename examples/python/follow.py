"""Follows a pair of files that grows while it is downlinked, and prints the period: follow.py SCENE PAIR FRAMES"""
import itertools
import sys

from toliman import Pair, Simulator, Template, Tracker

scene, path, frames = sys.argv[1], sys.argv[2], int(sys.argv[3])
tracker = Tracker(Template(Simulator(scene)), 1.5 / frames, 0.1 / frames, 5 * frames)
pair = Pair(path, "u32le", growing=True)
for frame in itertools.islice(pair.follow(), frames):
    tracker.push(frame)
fit = tracker.fit()
print(f"period {fit.period:.3f} +- {fit.period_error:.3f} days")
