"""python3 -m toliman.report DIR...: writes an HTML page with figures of result folders."""
from __future__ import annotations

import argparse
import importlib.util
import logging
import pathlib
import signal
import sys
import warnings

from .._failure import Failure, readable
from .._output import STOPS, print_text

PACKAGES = {"numpy": "python3-numpy", "matplotlib": "python3-matplotlib", "jinja2": "python3-jinja2"}


def parse(words: list[str] | None) -> argparse.Namespace:
    """Parses the command line; its description is that of `toliman report --help`."""
    parser = argparse.ArgumentParser(
        prog="python3 -m toliman.report", description="Write an HTML page with figures from results of run, "
                                                      "experiment, period, "
        "planet, pupil, track or make bench. See `toliman report --help`.")
    parser.add_argument("folders", metavar="DIR", nargs="+", help="folders of results, shown on one page in this order")
    parser.add_argument("--out", metavar="FOLDER",
                        help="folder for the page and its figures, default DIR/report of the first DIR")
    parser.add_argument("--png", action="store_true", help="write each figure as PNG too")
    parser.add_argument("--pdf", action="store_true", help="write each figure as PDF too")
    parser.add_argument("--force", action="store_true", help="replace files that toliman did not write")
    return parser.parse_args(words)


def missing_packages() -> list[str]:
    """Returns the Debian packages of modules that are not installed."""
    return [package for name, package in PACKAGES.items() if importlib.util.find_spec(name) is None]


def report(options: argparse.Namespace) -> pathlib.Path:
    """Writes the page; returns its path."""
    from .page import Page
    from .sections import section_of
    folders = [pathlib.Path(folder) for folder in options.folders]
    sections = [section_of(folder) for folder in folders]
    kinds = ["svg"] + [kind for kind in ("png", "pdf") if getattr(options, kind)]
    page = Page(pathlib.Path(options.out) if options.out else folders[0] / "report", kinds, options.force)
    for number, (folder, add) in enumerate(zip(folders, sections), 1):
        page.prefix = f"{number}-" if number > 1 else ""
        add(folder, page)
    return page.write()


def stop(number: int, _: object) -> None:
    """Handles a signal: ends the program, which then removes its temporary files."""
    print("toliman: stopped by a signal", file=sys.stderr)
    sys.exit(128 + number)


def main(words: list[str] | None = None) -> int:
    """Runs the program; returns its exit code."""
    for number in STOPS:
        if signal.getsignal(number) != signal.SIG_IGN:
            signal.signal(number, stop)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, STOPS)  # blocked while `toliman report` starts Python
    options = parse(words)
    missing = missing_packages()
    if missing:
        print("toliman: report needs Debian packages that are not installed: apt-get install " + " ".join(missing),
              file=sys.stderr)
        return 1
    # Nothing about the cache of fonts or the user's settings.
    logging.getLogger("matplotlib").setLevel(logging.CRITICAL)
    warnings.simplefilter("ignore")  # nothing about letters that the font does not have
    try:
        print_text(readable(report(options)) + "\n")
    except Failure as failure:
        if str(failure):
            print(f"toliman: {failure}", file=sys.stderr)
        return failure.code
    return 0


if __name__ == "__main__":
    sys.exit(main())
