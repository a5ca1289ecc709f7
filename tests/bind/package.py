"""The package of this build for tests that run without ctest: `from package import ROOT, toliman`."""
import pathlib
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path += [str(ROOT / name) for name in ("build/python", "tests/support", "examples/sky", "tools/studies")]
import toliman  # noqa: E402, F401
