"""Cosmic rays in frames: the period of their values against that of the same frames without them.
The short form: test_cosmic_campaign.py. Results: tools/docs/reliability.md.

    cosmic_campaign.py [--frames 1000] [--rate 0.5] [--seed 4]

Each frame has a Poisson number of hits, `rate` on average, of 5e3 to 3e4 photons in one pixel of any brightness. Frames of
the chapter's scene, with a peak of 1e6 photons, are encoded by its template, its network and its fit, those of moving.json (64 x 64 px, stars on their
orbit) by the fit. Prints for each the false alarm probability of the period without and with hits, frames whose goodness is
not "good", pixels left out of frames without and with hits, and by how many standard deviations the hits move a value."""
# promise: cosmic-rays-lose-no-frame
import argparse
import json
import pathlib
import sys

import numpy

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT / "build" / "python"))
import toliman  # noqa: E402

GOOD = 802  # TOLIMAN_GOODNESS_GOOD
FEWEST, MOST = 5e3, 3e4  # photons of a hit
PART = 100  # frames in memory at once


def chapter(frames, amplitude=9e-5):
    scene = json.loads((ROOT / "examples" / "scenes" / "chapter.json").read_text())
    scene["signal"]["amplitude_px"] = amplitude
    scene["cadence"].update(frames=frames, peak_photons=1e6)  # of 1e9, most hits would be below the noise of their pixel
    return scene


def moving(frames, amplitude=6e-4):
    scene = json.loads((ROOT / "examples" / "data" / "moving.json").read_text())
    scene["signal"].update(amplitude_px=amplitude, star=scene["signal"].get("star", "A"))
    scene["cadence"].update(frames=frames, interval_days=min(1, 100 / frames))
    return scene


def with_hits(frames, rate, random):
    """Returns a copy with hits, and their number in each frame."""
    hit, counts = frames.copy(), random.poisson(rate, len(frames))
    for frame, count in zip(hit, counts):
        for _ in range(count):
            frame[random.integers(frame.shape[0]), random.integers(frame.shape[1])] += random.uniform(FEWEST, MOST)
    return hit, counts


def estimators(simulator, network):
    """Yields (name, function of frames and times that returns values, their standard deviation, and fits)."""
    fit = toliman.Fit(simulator)

    def of_fit(frames, times):
        found = fit.frames(frames, times_days=times)
        return found["displacement_px"], float(numpy.median(found["separation_sigma_px"])), found

    yield "fit", of_fit
    if not network:
        return
    template, cae = toliman.Template(simulator), toliman.CAE(simulator)
    cae.train()
    yield "template", lambda frames, times: (*ordered(template.encode(frames, goodness=True), template.sigma),)
    yield "network", lambda frames, times: (*ordered(cae.encode(frames, goodness=True), template.sigma),)


def ordered(found, sigma):
    return found[0], sigma, found[1]


def measure(scene, network, rate, seed):
    """Returns for each estimator a dict of what hits do."""
    simulator = toliman.Simulator(scene)
    times, truth = simulator.series()
    functions = dict(estimators(simulator, network))
    values = {name: ([], []) for name in functions}
    fits = {name: ([], []) for name in functions}
    sigmas, hits, random = {}, [], numpy.random.default_rng(seed)
    for first in range(0, len(times), PART):
        count = min(PART, len(times) - first)
        clean = simulator.frames(first, count)
        hit, number = with_hits(clean, rate, random)
        hits.extend(number)
        for name, function in functions.items():
            for which, frames in enumerate((clean, hit)):
                found, sigmas[name], fit = function(frames, times[first:first + count])
                values[name][which].append(found)
                fits[name][which].append(fit)
    made = {}
    for name in functions:
        clean, hit = (numpy.concatenate(parts) for parts in values[name])
        moved = (hit - clean) / sigmas[name]
        goods = [numpy.concatenate([part["goodness"] for part in parts]) for parts in fits[name]]
        bad = [numpy.concatenate([part["bad_pixels"] for part in parts]) for parts in fits[name]]
        faps = [toliman.period(times, series).log10_fap if len(times) >= 50 else numpy.nan for series in (clean, hit)]
        made[name] = {"fap": faps, "lost": [int((good != GOOD).sum()) for good in goods], "bad": [int(b.sum()) for b in bad],
                      "hits": int(numpy.sum(hits)), "mean": float(moved.mean()), "rms": float(numpy.sqrt(numpy.mean(moved**2))),
                      "largest": float(numpy.abs(moved).max()),
                      "error": [float(numpy.std((series - truth) / sigmas[name])) for series in (clean, hit)]}
    return made


def report(title, made):
    print(f"{title}\n| estimator | log10 FAP, clean | with hits | not good, clean | with hits | left out, clean | with hits | "
          "hits | moved by, mean | rms | largest | scatter, clean | with hits |")
    for name, of in made.items():
        print(f"| {name} | {of['fap'][0]:.2f} | {of['fap'][1]:.2f} | {of['lost'][0]} | {of['lost'][1]} | {of['bad'][0]} | "
              f"{of['bad'][1]} | {of['hits']} | {of['mean']:.4f} | {of['rms']:.4f} | {of['largest']:.3f} | "
              f"{of['error'][0]:.3f} | {of['error'][1]:.3f} |", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--frames", type=int, default=1000)
    parser.add_argument("--rate", type=float, default=0.5)
    parser.add_argument("--seed", type=int, default=4)
    options = parser.parse_args()
    report("chapter.json", measure(chapter(options.frames), True, options.rate, options.seed))
    report("moving.json", measure(moving(options.frames), False, options.rate, options.seed))


if __name__ == "__main__":
    main()
