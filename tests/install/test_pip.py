"""Tests pip with the folder of the Python package in the build folder TOLIMAN_BUILD, without network. TOLIMAN_LIBRARY is the
library."""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

SOURCE = pathlib.Path(os.environ["TOLIMAN_BUILD"]) / "python"


class Pip(unittest.TestCase):
    def test_installs_and_finds_a_period(self):
        kept = tempfile.TemporaryDirectory()
        self.addCleanup(kept.cleanup)
        folder = pathlib.Path(kept.name)
        shutil.copytree(SOURCE, folder / "python", ignore=shutil.ignore_patterns("__pycache__"))  # pip builds inside it

        def run(*command, code=0, without="PYTHONPATH"):
            environment = {name: value for name, value in os.environ.items() if name not in ("PYTHONPATH", without)}
            done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True)
            self.assertEqual(done.returncode, code, done.stdout + done.stderr)
            return done.stderr if code else done.stdout
        run(sys.executable, "-m", "venv", "--system-site-packages", "venv")
        run("venv/bin/pip", "install", "--no-index", "--no-build-isolation", "./python")
        output = run("venv/bin/python", "-c", "import importlib.metadata, math, toliman\n"
                     "with toliman.Periodogram(0.05, 0.01, 10) as periodogram:\n"
                     "    for i in range(100):\n"
                     "        periodogram.push(i, math.sin(2 * math.pi * i / 10))\n"
                     "    print('%.12f' % periodogram.power()[5], toliman.__file__)\n"
                     "print(importlib.metadata.version('toliman') == toliman.__version__)")
        self.assertEqual(output, f"1.000000000000 {folder.resolve()}/venv/lib/python{sys.version_info[0]}."
                               f"{sys.version_info[1]}/site-packages/toliman/__init__.py\nTrue\n")
        for name in ("py.typed", "experiment/__main__.py", "report/page.html"):
            self.assertTrue(next(folder.glob(f"venv/lib/python*/site-packages/toliman/{name}")).exists())

        # A version that exists nowhere: each place that was tried is listed once.
        raw = next(folder.glob("venv/lib/python*/site-packages/toliman/_raw.py"))
        raw.write_text(re.sub("(?m)^TOLIMAN_VERSION_MINOR = .*", "TOLIMAN_VERSION_MINOR = 99", raw.read_text()))
        output = run("venv/bin/python", "-c", "from toliman import CAE", code=1, without="TOLIMAN_LIBRARY")
        tried = [line.split(":")[0].strip() for line in output.partition("Tried:\n")[2].splitlines()]
        self.assertIn(f"{folder.resolve()}/venv/lib/libtoliman.so.0.99", tried)
        self.assertEqual(tried, list(dict.fromkeys(tried)))


if __name__ == "__main__":
    unittest.main()
