"""Simulated series whose sampling repeats their signals: is the period of the signal the one that is shown?

    alias_campaign.py [--missions 20] [--seed 1]

A mission of three years has one frame every 3 days at 600 km above the Earth: the mean times of 12 arcs scatter. 10 % of
the frames are lost, 5 % arrive twice, all in random order. A planet of 132 to 560 days has 1 to 10 uas, the noise is
2.2 uas. The frames enter a state folder of the default grid, which goes to 0.5 per day. Other series are those of telescopes
on the ground. Prints for each kind how often the highest peak and the period that is shown are right. The exit status
is 1 if a period that is shown is wrong."""
# promise: longest-alias-is-shown
import argparse
import pathlib
import sys

import numpy

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT / "build" / "python"))
import toliman  # noqa: E402

DAY, DAYS, NOISE = 86400 * 10**9, 1095, 2.2
GRID = toliman.suited_grid([], DAYS)
OWN = {"estimator_id": 7, "sigma": NOISE, "value_limit": 1e3, "rows": 8, "cols": 6, "image_shape": (8, 6),
       "allow_zero_runs": True}


def corner(image):
    return image[0, 0]


def mission_times(rng, scatter=0.02, cadence=3.0):
    times = numpy.arange(0, DAYS - 1, cadence) + rng.uniform(0, 1)
    times = times[rng.uniform(size=times.size) > 0.1]
    return times + rng.normal(0, scatter, times.size)


def with_wave(rng, times, period, amplitude, noise):
    phase = rng.uniform(0, 2 * numpy.pi)
    return amplitude * numpy.sin(2 * numpy.pi * times / period + phase) + rng.normal(0, noise, times.size)


def frames(rng, period, scatter=0.02):
    """Frames of a mission: the value of each is its first pixel."""
    times = mission_times(rng, scatter)
    values = with_wave(rng, times, period, rng.uniform(1, 10), NOISE)
    order = rng.permutation(numpy.concatenate([numpy.arange(times.size), rng.choice(times.size, times.size // 20)]))
    return [toliman.Frame(numpy.full((8, 6), values[k]), frame_id=int(k), camera_ns=int(times[k] * DAY)) for k in order]


def tracker(**more):
    return toliman.Tracker(corner, *GRID, **{**OWN, **more})


def highest(periodogram):
    """Period of the highest power."""
    return 1 / periodogram.frequency[periodogram.power().argmax()]


def fly(seed):
    """Returns the true period of a mission, that of the highest power, and those that are shown from sums and frames."""
    rng = numpy.random.default_rng(seed)
    period = rng.uniform(132, 560)
    with tracker() as ours:
        ours.push_many(frames(rng, period))
        return period, highest(ours.period), ours.period.peak().period, ours.fit().period


def nights(rng, visits, each=1, scatter=0.08, days=900, step=1.0):
    """Times of a telescope on the ground: nights drawn from `days`, `each` exposures 5 minutes apart."""
    night = numpy.sort(rng.choice(days, visits, replace=False)) * step + rng.normal(0, scatter, visits)
    return (night[:, None] + 0.0035 * numpy.arange(each)).ravel()


# Name: times, shortest and longest period.
GROUND = {
    "one visit a night, hours apart": (lambda rng: nights(rng, 90), 0.6, 20),
    "one visit a night, same hour": (lambda rng: nights(rng, 120, scatter=0.005), 2.2, 100),
    "three exposures a night": (lambda rng: nights(rng, 100, each=3), 0.6, 100),
    "every night": (lambda rng: nights(rng, 150, days=160, scatter=0.06), 0.6, 20),
    "random times": (lambda rng: numpy.sort(rng.uniform(0, 400, 100)), 1.0, 100),
    "regular, gaps": (lambda rng: rng.choice(400, 200, replace=False) * 0.5, 1.05, 50)}


def observe(name, seed):
    """Returns the true period of a series of the ground and the one that is shown."""
    times, shortest, longest = GROUND[name]
    rng = numpy.random.default_rng([seed, list(GROUND).index(name)])
    t, period = times(rng), numpy.exp(rng.uniform(numpy.log(shortest), numpy.log(longest)))
    return period, toliman.period(t, with_wave(rng, t, period, 5, 1), numpy.ones(t.size)).period


def is_right(truth, period):
    return abs(period / truth - 1) < 0.1


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--missions", type=int, default=20)
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    seeds, wrong = range(given.seed, given.seed + given.missions), 0
    rows = [fly(seed) for seed in seeds]
    for column, what in enumerate(("highest power", "shown by the sums", "shown by the fit"), 1):
        right = sum(is_right(row[0], row[column]) for row in rows)
        wrong += (column > 1) * (len(rows) - right)
        print(f"missions, {what}: {right} of {len(rows)} right")
    for name in GROUND:
        right = sum(is_right(*observe(name, seed)) for seed in seeds)
        wrong += len(rows) - right
        print(f"{name}: {right} of {len(rows)} right")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
