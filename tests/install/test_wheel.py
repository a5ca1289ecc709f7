"""Tests that a wheel containing the library, built without network, works where no other libtoliman.so is
installed."""
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest
import zipfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
USE = """
import math, toliman
assert toliman.library_path() == str(toliman._library.above(0) / toliman._library.SONAME), toliman.library_path()
t = range(100)
assert all(toliman.plan(scene.name).stages for scene in toliman.shipped_scenes())
print(round(toliman.period(t, [math.sin(2 * math.pi * i / 10) for i in t]).period, 6), toliman.library_path(),
      *(scene.name for scene in toliman.shipped_scenes()))
"""


class Wheel(unittest.TestCase):
    def test_holds_the_library(self):
        kept = tempfile.TemporaryDirectory()
        self.addCleanup(kept.cleanup)
        folder = pathlib.Path(kept.name).resolve()
        environment = {name: value for name, value in os.environ.items()
                       if name not in ("PYTHONPATH", "TOLIMAN_LIBRARY", "LD_LIBRARY_PATH")}

        def run(*command):
            done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
            return done.stdout
        wheel = run(ROOT / "tools" / "cmake" / "wheel", os.environ["TOLIMAN_LIBRARY"],
                    pathlib.Path(os.environ["TOLIMAN_BUILD"]) / "python", folder).strip()
        self.assertRegex(wheel, rf"/toliman-[0-9.]+-py3-none-linux_{os.uname().machine}\.whl$")
        names = zipfile.ZipFile(wheel).namelist()
        for name in ("py.typed", "_raw.py", "_results.py", "experiment/__main__.py", "report/__main__.py", "report/_network.py", "report/page.html"):
            self.assertIn(f"toliman/{name}", names)
        self.assertEqual([name for name in names if "__pycache__" in name], [])
        self.assertTrue(any(name.endswith("/LICENSE") for name in names), names)

        run(sys.executable, "-m", "venv", "--system-site-packages", "venv")
        run("venv/bin/pip", "install", "--no-index", wheel)
        period, path, *scenes = run("venv/bin/python", "-c", USE).split()
        self.assertEqual((period, scenes), ("10.0", ["chapter.json", "mission.json", "sky.json"]))
        self.assertTrue(path.startswith(f"{folder}/venv/lib/"), path)


if __name__ == "__main__":
    unittest.main()
