"""The orbit and the planets of a state folder, in C, Fortran and Python: the numbers of `toliman refit` and `planet`."""
import json
import os
import pathlib
import subprocess
import sys
import unittest

TOP = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(TOP / "tests/cli"), str(TOP / "tests/support")]
from test_refit_state import RefitState  # noqa: E402

PROGRAMS = pathlib.Path(os.environ["TOLIMAN"]).parent


class State(RefitState):
    def test_track_refit_rebuild(self):
        """All print the same line."""
        observer = ("--observer", "definitive.csv")
        self.track("s", "--system", "alpha-cen", *observer)
        fit = json.loads(self.succeed("refit", "alpha-cen", "s", *observer, "--json"))
        planets = json.loads(self.succeed("planet", "s", "--json"))
        expected = f"orbit: chi-square {fit['chi_square']:.3f}; {planets['planets']} planets\n"
        for program in ([PROGRAMS / "state"], [PROGRAMS / "fortran_state"], [sys.executable, TOP / "examples/python/state.py"]):
            done = subprocess.run([*program, "s", "definitive.csv"], cwd=self.folder, capture_output=True, text=True)
            self.assertEqual((done.returncode, done.stdout.lstrip()), (0, expected), done.stderr)


def load_tests(loader, tests, pattern):
    return loader.loadTestsFromName("test_track_refit_rebuild", State)


if __name__ == "__main__":
    unittest.main()
