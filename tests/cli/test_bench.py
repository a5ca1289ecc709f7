"""make bench: no figures from kernels that are too old for the processor, and ratios that are what they say."""
import contextlib
import io
import os
import pathlib
import subprocess
import sys
import unittest

import schemas
from program import PROGRAM, ROOT, ProgramTest

BENCH = ROOT / "tests" / "bench"
sys.path.append(str(BENCH))
import measuring


class Bench(ProgramTest):
    def test_refuses_old_kernels(self):
        binaries = pathlib.Path(PROGRAM).parent
        done = subprocess.run(["/usr/bin/python3", BENCH / "bench.py", binaries, "out", "size"], cwd=self.folder,
                              env={**os.environ, "OPENBLAS_CORETYPE": "PRESCOTT"}, capture_output=True, text=True)
        self.assertEqual((done.returncode, done.stdout), (1, ""))
        self.assertRegex(done.stderr, r"^bench: OpenBLAS runs its Prescott kernels; set OPENBLAS_CORETYPE")
        self.assertEqual(os.listdir(self.folder / "out"), [])

    @unittest.skipIf(os.environ.get("TOLIMAN_SANITIZE"), "a plain Python cannot load the library then")
    def test_file(self):
        done = subprocess.run(["/usr/bin/python3", BENCH / "bench.py", pathlib.Path(PROGRAM).parent, "out", "size"],
                              cwd=self.folder, capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        text = (self.folder / "out" / "size.json").read_text()
        schemas.check(text)
        self.assertIn("\n| load the library and those below it, by the clock | ", done.stdout)
        self.succeed("report", "out")

    def test_ratios(self):
        row = measuring.row("period", "batch", "x", 0.5, 0.1, 1e-9, "of peak", "astropy", 2.0, 0.25)
        self.assertEqual((row["ratio_peer"], row["ratio_roofline"], row["headline"]), (4, 2, False))
        alone = measuring.row("period", "batch", "x", 0.5, beside="astropy", beside_seconds=None)  # not installed
        self.assertEqual([key for key in alone if "peer" in key or "roofline" in key], [])

    def test_peers_that_are_not_there(self):
        remark = io.StringIO()
        with contextlib.redirect_stderr(remark):
            self.assertEqual(measuring.peer_program("oneDNN", ["./not-built"]), [])
            self.assertEqual(measuring.peer_program("PyTorch", ["sh", "-c", "echo 1; echo x >&2; echo no torch >&2; exit 1"]), [])
        self.assertEqual(remark.getvalue(),
                         "bench: nothing measured beside oneDNN (No such file or directory); see tests/bench/README.md\n"
                         "bench: nothing measured beside PyTorch (no torch); see tests/bench/README.md\n")
        with self.assertRaises(SystemExit):
            measuring.lines(["false"])


if __name__ == "__main__":
    unittest.main()
