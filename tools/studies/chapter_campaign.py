"""The book chapter's own training at length, and its next idea, a network that uses the order of the frames.
The short form: test_chapter_campaign.py. Results: tools/docs/benchmarks.md, "Detection methods over amplitude".

    chapter_campaign.py [training] [smooth] [--folder build/chapter] [--epochs 1000] [--amplitudes 1e-2,1e-4,1e-6]
                        [--seeds 10] [--controls 40] [--jobs 0]

training  Trains the chapter's network as the chapter does: layout `paper`, raw input, 985 frames and 110 for validation,
          at each amplitude (px). 6 s of one core per epoch. Weights and logs are in the folder: a training that was stopped
          is continued, and --epochs may be raised. Prints tables and draws training.png.
smooth    A linear autoencoder whose latents must be smooth in time. It is trained without supervision on the frames of
          even days and encodes those of odd days, so that a false alarm probability means what it says. With X the even
          frames' residuals (x - mean)/sqrt(mean), one per row, and D differences of their latents (first differences per
          day, or second differences per day^2), it minimises
              |X - z u^T|^2 + penalty |D z|^2    over latents z and the axis u of unit length.
          For the best z this maximises u^T X^T (1 + penalty D^T D)^-1 X u: u = X^T S v with S = (1 + penalty D^T D)^-1/2
          and v the first eigenvector of S X X^T S. The latents of the odd frames are their products with u. Prints in how
          many series each penalty finds the period, and the false alarms in series without signal. 4 s per series.

Without a mode both run."""
import argparse
import csv
import json
import multiprocessing.pool
import os
import pathlib
import subprocess
import sys

import numpy

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT / "build" / "python"))
import toliman  # noqa: E402

SCENE = ROOT / "examples" / "scenes" / "chapter.json"
PERIOD, ALARM, NEAR = 365, 1e-3, 0.05  # d; false alarm probability; relative error of a period that counts as found
PENALTIES = {1: (0, 3, 10, 30, 100), 2: (1e2, 1e3, 1e4, 1e5)}  # by the order of the differences; d^2, d^4
AMPLITUDES = 5e-6, 4e-6, 3e-6, 2.5e-6, 2e-6  # px
SHOWN = 0, 1, 10, 20, 50, 100, 200, 300, 500, 700, 1000, 1500, 2000, 3000, 5000, 10000  # epochs in the table


def scene_of(amplitude, **detector):
    scene = json.loads(SCENE.read_text())
    scene["signal"]["amplitude_px"] = amplitude
    scene["detector"].update(detector)
    return scene


# training

def train(folder, amplitude, epochs, processor=None):
    """Trains, or continues, the network of an amplitude; returns its log."""
    base = folder / f"{amplitude:g}"
    scene, weights, part, log = (base.with_suffix(base.suffix + end) for end in (".json", ".tlmw", ".tlmw.part", ".csv"))
    scene.write_text(json.dumps(scene_of(amplitude)))
    command = [os.environ.get("TOLIMAN", ROOT / "build/bin/toliman"), "train", scene, "--epochs", str(epochs), "--log", log,
               "--out", weights]
    done = next((file for file in (part, weights) if file.exists()), None)
    command += ["--resume", done] if done else ["--mode", "unsupervised", "--layout", "paper", "--input", "raw"]
    if processor is not None:
        command = ["taskset", "-c", str(processor), *command]
    if not (done == weights and len(read_log(log)) > epochs):
        subprocess.run(command, check=True)
    return read_log(log)


def read_log(path):
    """Rows of a log by epoch; empty cells are nan."""
    with open(path, newline="") as file:
        next(file)
        return {int(row["epoch"]): {name: float(cell or "nan") for name, cell in row.items()} for row in csv.DictReader(file)}


def table_of(logs):
    yield "| amplitude | epoch | loss | validation | MMSE | MSSIM | log10 FAP trained | fresh | no signal |"
    yield "|---|---|---|---|---|---|---|---|---|"
    for amplitude, log in logs.items():
        for epoch in sorted({*SHOWN, max(log)} & {*log}):
            row = log[epoch]
            cells = [f"{row[name]:.1e}" for name in ("loss", "validation_loss", "mmse")] + [f"{row['mssim']:.4f}"]
            cells += [f"{row['log10_fap_' + name]:.4g}" for name in ("trained", "fresh", "none")]
            yield f"| {amplitude:g} px | {epoch} | {' | '.join(cell.replace('nan', '') for cell in cells)} |"


def summary_of(logs):
    """Smallest error, that of the last 100 epochs, and searches below the false alarm probability ALARM, with the lowest."""
    yield "| amplitude | epochs | smallest MMSE | median of the last 100 | trained | fresh | no signal |"
    yield "|---|---|---|---|---|---|---|"
    for amplitude, log in logs.items():
        trained = [log[epoch] for epoch in sorted(log) if epoch > 0]
        errors = [row["mmse"] for row in trained]
        cells = [f"{min(errors):.1e}", f"{numpy.median(errors[-100:]):.1e}"]
        for name in ("trained", "fresh", "none"):
            searched = [row["log10_fap_" + name] for row in trained if not numpy.isnan(row["log10_fap_" + name])]
            alarms = sum(value < numpy.log10(ALARM) for value in searched)
            cells.append(f"{alarms} of {len(searched)} ({min(searched):.1f})")
        yield f"| {amplitude:g} px | {max(log)} | {' | '.join(cells)} |"


def draw(logs, floor, path):
    """Loss and false alarm probability against epochs."""
    from matplotlib import pyplot
    figure, axes = pyplot.subplots(2, len(logs), figsize=(4 * len(logs), 6), sharex=True, sharey="row", squeeze=False,
                                   layout="constrained")
    for (amplitude, log), (above, below) in zip(logs.items(), axes.T):
        epochs = numpy.array(sorted(log))
        values = {name: numpy.array([log[epoch][name] for epoch in epochs]) for name in log[max(log)]}
        above.set_title(f"{amplitude:g} px")
        above.semilogy(epochs, values["loss"], linewidth=0.6, label="training frames")
        above.semilogy(epochs, values["validation_loss"], linewidth=0.6, label="validation frames")
        above.axhline(4.4e-8, color="black", linestyle="--", linewidth=0.8, label="the chapter's 4.4e-8")
        above.axhline(floor, color="black", linestyle=":", linewidth=0.8, label="photon noise")
        for name, label in (("trained", "training frames"), ("fresh", "fresh frames"), ("none", "no signal")):
            found = ~numpy.isnan(values["log10_fap_" + name])
            below.plot(epochs[found], -values["log10_fap_" + name][found], linewidth=0.8, label=label)
        below.set_yscale("symlog", linthresh=10)
        below.axhline(3, color="black", linestyle=":", linewidth=0.8)
        below.set_xlabel("epoch")
    axes[0, 0].set_ylabel("mean squared error")
    axes[1, 0].set_ylabel("-log10 false alarm probability")
    axes[0, -1].legend(fontsize=8)
    axes[1, -1].legend(fontsize=8)
    figure.savefig(path, dpi=100)


def training(options):
    options.folder.mkdir(parents=True, exist_ok=True)
    jobs = min(options.jobs, len(options.amplitudes))
    with multiprocessing.pool.ThreadPool(jobs) as pool:
        tasks = [(options.folder, amplitude, options.epochs, i % jobs) for i, amplitude in enumerate(options.amplitudes)]
        logs = dict(zip(options.amplitudes, pool.starmap(train, tasks, 1)))
    print("\n".join([*table_of(logs), "", *summary_of(logs)]))
    draw(logs, photon_floor(), options.folder / "training.png")


def photon_floor():
    """Expected mean squared error of the noise-free image, scaled to 0..1 as the frames are."""
    with toliman.Simulator(scene_of(1e-6)) as simulator:
        mean = simulator.expect(0)
        return float(numpy.mean(simulator.image("variance")) / (mean.max() - mean.min())**2)


# smooth

def smoothers(days):
    """S = (1 + penalty D^T D)^-1/2 of each order and penalty, for samples two days apart."""
    identity = numpy.eye(days)
    for order, penalties in PENALTIES.items():
        differences = numpy.diff(identity, order, axis=0) / 2**order
        values, vectors = numpy.linalg.eigh(differences.T @ differences)
        for penalty in penalties:
            yield (order, penalty), (vectors / numpy.sqrt(1 + penalty * values)) @ vectors.T


def peaks(task):
    """(period, log10 FAP) of one series for each order and penalty."""
    amplitude, seed, detector = task
    with toliman.Simulator(scene_of(amplitude or 1e-6, **detector)) as simulator:
        count = simulator.info.frames
        days = numpy.arange(float(count))
        moved = None if amplitude else numpy.zeros(count)
        images = simulator.frames(displacements=moved, seed=seed).reshape(count, -1)
    mean = images[::2].mean(0)
    images -= mean
    images /= numpy.sqrt(mean)
    even, odd = images[::2].astype(numpy.float32), images[1::2].astype(numpy.float32)
    del images
    gram, across = (even @ even.T).astype(float), (odd @ even.T).astype(float)
    found = {}
    for key, smoother in smoothers(len(even)):
        first = numpy.linalg.eigh(smoother @ gram @ smoother)[1][:, -1]
        peak = toliman.period(days[1::2], across @ (smoother @ first))
        found[key] = peak.period, peak.log10_fap
    return found


def is_found(period, log10_fap):
    return log10_fap < numpy.log10(ALARM) and abs(period / PERIOD - 1) < NEAR


def smooth(options, pool, amplitudes=AMPLITUDES, detector=None):
    """Prints the table and returns it: by amplitude, then by order and penalty, the peaks of each series."""
    keys = [(order, penalty) for order, penalties in PENALTIES.items() for penalty in penalties]
    print("| amplitude | series | " + " | ".join(f"order {order}, {penalty:g}" for order, penalty in keys) + " |")
    print("|---" * (len(keys) + 2) + "|")
    results = {}
    for amplitude in (*amplitudes, 0):
        seeds = range(options.seeds) if amplitude else range(1000, 1000 + options.controls)
        series = pool.map(peaks, [(amplitude, 100 + seed, detector or {}) for seed in seeds], chunksize=1)
        results[amplitude] = {key: [one[key] for one in series] for key in keys}
        cells = []
        for key in keys:
            of_key = results[amplitude][key]
            if amplitude:
                cells.append(f"{sum(is_found(*peak) for peak in of_key)} ({numpy.median([fap for _, fap in of_key]):.1f})")
            else:
                cells.append(str(sum(fap < numpy.log10(ALARM) for _, fap in of_key)))
        print(f"| {f'{amplitude:g} px' if amplitude else 'no signal: alarms'} | {len(series)} | {' | '.join(cells)} |", flush=True)
    return results


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("modes", nargs="*", default=["training", "smooth"], metavar="MODE", choices=["training", "smooth"])
    parser.add_argument("--folder", type=pathlib.Path, default=ROOT / "build" / "chapter")
    parser.add_argument("--epochs", type=int, default=1000)
    parser.add_argument("--amplitudes", type=lambda text: [float(word) for word in text.split(",")], default=[1e-2, 1e-4, 1e-6])
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--controls", type=int, default=40)
    parser.add_argument("--jobs", type=int, default=0)
    options = parser.parse_args()
    options.jobs = options.jobs or os.cpu_count()
    if "training" in options.modes:
        training(options)
    if "smooth" in options.modes:
        with multiprocessing.get_context("spawn").Pool(options.jobs) as pool:
            smooth(options, pool)


if __name__ == "__main__":
    main()
