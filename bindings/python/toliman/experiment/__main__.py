"""python3 -m toliman.experiment SCENE --out FOLDER: compares detection methods over a range of signal amplitudes."""
from __future__ import annotations

import argparse
import datetime
import difflib
import os
import pathlib
import shlex
import sys
import typing
import warnings

from .._failure import OUTPUT, USAGE, Failure, failure_of, readable
from .._goodness import FitWarning
from .._library import Error
from .._output import SignalWatch, Temporary, check_free, make_folder, print_text, replace_files
from .._progress import Bar
from ..machine import machine
from ..sim import Simulator
from .campaign import Campaign, Options
from .journal import Journal
from .methods import METHODS
from .summary import result_of
from .tables import MARKS, csv_of, json_of, markdown_of

_TABLES = ["real", "equal", "robust"]
_CONTROLS = ["none", "quick", "full"]
_AMPLITUDES = [1e-2, 1e-3, 1e-4, 1e-5, 1e-6]
_MOST_SEEDS, _MOST_BLIND = 100000, 10000000
_MOST_AMPLITUDE = 0.1  # px, range of the expansion in the displacement
_STOPPED = "stopped by a signal; the same command resumes the experiment"

_HELP = """\
Compare detection methods over a range of signal amplitudes, with controls.

Examples:
  # a first impression: four minutes
  python3 -m toliman.experiment chapter.json --quick --out quick
  # all methods and tables: about an hour on two cores
  python3 -m toliman.experiment chapter.json --out table
  # two methods at three amplitudes with 50 seeds each
  python3 -m toliman.experiment scene.json --tables real --amplitudes 1e-5,3e-6,1e-6 --methods cae,template --seeds 50 --out fine

The scene's signal is given each amplitude in turn. For each amplitude and seed a series of frames is simulated with
fresh noise that no training has seen, and every method gets the same frames. The results per method are the period,
its relative error, log10 FAP, the slope of the values over the true displacement, and the efficiency: the Cramer-Rao
bound divided by the scatter about that line.
"""
_MORE_HELP = """\
Methods:
{methods}

Tables:
  real    the scene as it is
  equal   the scene with both stars equally bright
  robust  frames with jitter of pointing and fluxes, with and without projecting it out; and frames of
          scenes that differ from the one the methods were made for, as they are and relative to
          their own mean; with the scene's own amplitude and at most 10
          seeds. It needs stars at rest

Where orbit, pointing or roll move the stars, only the fit and a bank of networks follow them: give --methods bank,fit
--tables real.

Controls: --blind series without signal per table, on which the FAP should be uniformly distributed, and the results
expected in theory of a method that reaches the Cramer-Rao bound. --controls quick computes a tenth of these series, but
at least one per seed; --controls none computes none. The theory is always given.

Methods that learn from the series itself (pca, pca-white, pca-blocks, dictionary, cae-unsupervised) and
untrained-paper are in the tables `real` and `equal` only. Those that learn from the series have no series without
signal. cae-unsupervised takes about a minute per series, so it has only seed 1 and amplitudes of at least 1e-4 px.
Methods that learn from the series, except pca-blocks, hold the frames of one series in memory, 4 bytes per pixel.

Output: the tables on standard output, and a folder with these files.
  experiment.json  all results (schema toliman-experiment/1)
  experiment.csv   one row per method and series
  experiment.md    the tables
  journal.jsonl    every result as soon as it is known
If the experiment is stopped, the same command resumes from the journal. Other arguments need another folder.

Exit codes are those of `toliman --help`.
"""


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> typing.NoReturn:
        raise Failure(USAGE, message.removeprefix("argument "))


def _words(known: typing.Sequence[str]) -> typing.Callable[[str], list[str]]:
    """Returns the type of an option whose value is a list of known words, each once."""
    def words(text: str) -> list[str]:
        found = text.split(",")
        for word in found:
            if word not in known:
                similar = difflib.get_close_matches(word, known, 1)
                hint = f" (did you mean {similar[0]}?)" if similar else ""
                raise argparse.ArgumentTypeError(f"{word}: must be one of {', '.join(known)}{hint}")
        _check_once(found, found)
        return found
    return words


def _amplitudes(text: str) -> list[float]:
    words, found = text.split(","), []
    for word in words:
        try:
            found.append(float(word))
        except ValueError:
            found.append(0.0)
        if not 0 < found[-1] <= _MOST_AMPLITUDE:
            raise argparse.ArgumentTypeError(f"{word}: must be in (0, {_MOST_AMPLITUDE}] px")
    _check_once(words, found)
    return found


def _check_once(words: typing.Sequence[str], values: typing.Sequence[object]) -> None:
    for word, value in zip(words, values):
        if values.count(value) != 1:
            raise argparse.ArgumentTypeError(f"{word}: must be given once")


def _whole(low: int, high: int) -> typing.Callable[[str], int]:
    """Returns the type of an option whose value is a whole number in [low, high]."""
    def whole(text: str) -> int:
        if not text.isdecimal() or not low <= int(text) <= high:
            raise argparse.ArgumentTypeError(f"{text}: must be a whole number in [{low}, {high}]")
        return int(text)
    return whole


def parser() -> argparse.ArgumentParser:
    """Returns the parser of the command line."""
    methods = "\n".join(f"  {name:16s}  {kind.what}" for name, kind in METHODS.items())
    result = _Parser(prog="python3 -m toliman.experiment", description=_HELP, epilog=_MORE_HELP.format(methods=methods),
                     formatter_class=argparse.RawDescriptionHelpFormatter, allow_abbrev=False)
    add = result.add_argument
    add("scene", metavar="SCENE", help="scene file, or name of a shipped scene")
    add("--out", metavar="FOLDER", required=True, help="folder for the results")
    add("--amplitudes", metavar="PX,...", type=_amplitudes, default=_AMPLITUDES,
        help="signal amplitudes in px, default 1e-2,1e-3,1e-4,1e-5,1e-6")
    add("--methods", metavar="NAME,...", type=_words(list(METHODS)),
        help="methods to compare, default all but bank and untrained-bank")
    add("--tables", metavar="NAME,...", type=_words(_TABLES), help="tables to make, default real,equal,robust")
    add("--seeds", metavar="N", type=_whole(1, _MOST_SEEDS), help="seeds 1 to N of weights and noise, default 20")
    add("--blind", metavar="N", type=_whole(0, _MOST_BLIND), help="series without signal per table, default 200")
    add("--quick", action="store_true",
        help="change the defaults: 3 seeds, 30 series without signal, table real, no cae-unsupervised")
    add("--controls", choices=_CONTROLS, default="full",
        help="none: no series without signal; quick: a tenth of them, at least one per seed; full, the default: all")
    add("--json", action="store_true", help="print experiment.json instead of the tables")
    add("--force", action="store_true", help="replace files that toliman did not write")
    return result


def options_of(given: argparse.Namespace) -> Options:
    """Returns what the experiment computes: the given values, or the defaults."""
    methods = [name for name, kind in METHODS.items() if not kind.on_request and not (given.quick and kind.slow)]
    seeds = given.seeds or (3 if given.quick else 20)
    blind = (30 if given.quick else 200) if given.blind is None else given.blind
    if given.controls == "quick":
        blind = min(blind, max(blind // 10, seeds))
    return Options(given.amplitudes, given.methods or methods, given.tables or (["real"] if given.quick else _TABLES), seeds,
                   0 if given.controls == "none" else blind, given.controls)


def _check_outputs(folder: pathlib.Path, force: bool) -> None:
    """Fails for files that cannot be written, before the computation."""
    for name, mark in MARKS.items():
        path = folder / name
        if not force and not (path.is_file() and path.read_bytes()[:len(mark)] == mark.encode()):
            check_free(path)
        try:
            Temporary(path, b"").close()
        except OSError as error:
            raise Failure(OUTPUT, f"{readable(path)}: cannot be written: {error.strerror}") from None


def _provenance(words: typing.Sequence[str]) -> dict[str, str]:
    with open("/proc/cpuinfo", encoding="utf-8", errors="replace") as file:
        models = [line.partition(": ")[2].strip() for line in file if line.startswith("model name")]
    now = datetime.datetime.now(datetime.timezone.utc)
    return {"command": shlex.join(["python3", "-m", "toliman.experiment", *words]),
            "date": now.strftime("%Y-%m-%dT%H:%M:%SZ"), "processor": models[0] if models else "unknown"}


def experiment(words: typing.Sequence[str], given: argparse.Namespace, watch: SignalWatch) -> str:
    """Runs the experiment and writes its folder; returns the text to print."""
    folder = pathlib.Path(given.out)
    campaign = Campaign(given.scene, Simulator(given.scene), options_of(given))
    with watch.lock:
        if make_folder(folder):
            watch.at_end(folder.rmdir)
        _check_outputs(folder, given.force)
        journal = Journal(folder / "journal.jsonl", campaign.arguments())
        watch.at_end(journal.discard)
    bar = Bar() if sys.stderr.isatty() else None

    def add(row: typing.Any) -> None:
        with watch.lock:
            journal.add(row)

    campaign.run(add, journal, bar or (lambda stage, fraction: None))
    if bar is not None:
        bar.close(True)
    result = result_of(campaign, journal, _provenance(words))
    texts = {"experiment.csv": csv_of(campaign, journal), "experiment.md": markdown_of(campaign, result),
             "experiment.json": json_of(result)}
    with watch.lock:
        (folder / "experiment.json").unlink(missing_ok=True)  # it implies the others
        replace_files({folder / name: text.encode() for name, text in texts.items()})
    return texts["experiment.json" if given.json else "experiment.md"]


def _restart_with_fast_blas(words: typing.Sequence[str]) -> None:
    """Starts the program again with the OpenBLAS kernels and threads that `toliman` sets, unless they are set: OpenBLAS
    chooses both when it is loaded."""
    found = machine()
    wanted = {"OPENBLAS_CORETYPE": found.blas_better} if found.blas_is_slow else {}
    if found.blas_threads != 1:
        wanted["OPENBLAS_NUM_THREADS"] = "1"
    if not wanted.keys() <= os.environ.keys():
        os.execve(sys.executable, [sys.executable, "-m", "toliman.experiment", *words], {**wanted, **os.environ})


def main(words: list[str] | None = None) -> int:
    """Runs the program; returns its exit code."""
    words = sys.argv[1:] if words is None else words
    watch = SignalWatch(_STOPPED)
    warnings.simplefilter("ignore", FitWarning)  # frames of other scenes fit badly
    try:
        given = parser().parse_args(words)
        _restart_with_fast_blas(words)
        print_text(experiment(words, given, watch))
        return 0
    except Failure as failure:
        ending = failure
    except Error as error:
        ending = failure_of(error)
    watch.clean_up()
    if str(ending):
        print(f"toliman: {ending}", file=sys.stderr)
    return ending.code


if __name__ == "__main__":
    sys.exit(main())
