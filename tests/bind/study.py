"""Shared by the short forms of the studies in tools/studies: a pool of processes and a captured table."""
import contextlib
import io
import logging

import package  # noqa: F401, which finds the studies


class Serial:
    """The pool of a study, in this process."""

    @staticmethod
    def map(function, tasks, chunksize=1):
        return [function(task) for task in tasks]

    imap = map


def run(mode, *arguments):
    """Figures that a mode misses, and the lines that it prints."""
    logging.getLogger("toliman").setLevel(logging.ERROR)
    with contextlib.redirect_stdout(io.StringIO()) as shown:
        wrong = mode(*arguments)
    return wrong, shown.getvalue().splitlines()
