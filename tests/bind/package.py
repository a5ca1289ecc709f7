"""The package of this build for tests that run without ctest: `from package import ROOT, toliman`."""
import os
import pathlib
import sys

LONG = bool(os.environ.get("TOLIMAN_LONG"))  # set by make long
ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path += [str(ROOT / name) for name in ("build/python", "tests/support", "examples/sky", "tools/studies")]
import toliman  # noqa: E402, F401
