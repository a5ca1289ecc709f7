"""doctor: its output is correct, and so is its verdict on machines made slow or unusable on purpose."""
import json
import os
import re
import subprocess
import unittest

from program import ProgramTest

SYNC = r"""#include <unistd.h>
int fsync(int descriptor) { (void)descriptor; usleep(%d); return 0; }
"""


@unittest.skipIf(os.environ.get("TOLIMAN_SANITIZE"), "a sanitizer has to come first")
class Doctor(ProgramTest):
    def disk(self, milliseconds):
        """The environment of a disk that takes so long."""
        source, library = self.folder / "sync.c", self.folder / f"sync{milliseconds}.so"
        source.write_text(SYNC % (1000 * milliseconds))
        subprocess.run(["cc", "-shared", "-fPIC", "-o", library, source], check=True)
        return {**os.environ, "LD_PRELOAD": str(library)}

    def test_a_good_machine(self):
        text = self.succeed("doctor", env=self.disk(0))
        self.assertTrue(text.splitlines()[-1].startswith("verdict      ready"), text)
        unset = {name: value for name, value in self.disk(0).items() if not name.startswith("OPENBLAS_")}
        result = json.loads(self.succeed("doctor", "--json", env=unset))  # which it sets itself, and restarts
        self.assertTrue(result["ready"])
        with open("/proc/cpuinfo", encoding="utf-8") as stream:
            cpu = stream.read()
        name = re.search(r"^model name\s*: (.*)$", cpu, re.M)
        self.assertEqual(result["cpu"], name.group(1) if name else "unknown")
        if "TOLIMAN_EMULATED" not in os.environ:  # the file is that of the host
            self.assertEqual("avx2" in result["isa_available"], " avx2 " in cpu and " fma " in cpu and " bmi2 " in cpu)
        self.assertEqual(result["isa"], result["isa_available"][-1])
        self.assertEqual(result["fsync_folder"].rstrip("/"), os.path.realpath(self.folder))
        self.assertEqual((result["blas_is_slow"], result["blas_threads"]), (False, 1))
        for name, package in (("fftw", "libfftw3-dev"), ("zlib", "zlib1g-dev"), ("cjson", "libcjson-dev"), ("netcdf", "libnetcdf-dev"),
                              ("cli11", "libcli11-dev")):
            shown = subprocess.run(["dpkg-query", "-W", "-f", "${Version}", package], capture_output=True, text=True)
            if shown.returncode == 0:
                self.assertIn(re.search(r"(?:\d+:)?(\d+\.\d+\.\d+)", shown.stdout).group(1), result[name])
        self.assertEqual(list(self.folder.glob("toliman-doctor*")), [])

    def not_ready(self, text, *arguments, env=None):
        """Everything is printed all the same, the verdict last and again on stderr."""
        done = self.run_program("doctor", *arguments, env=env or self.disk(0))
        self.assertEqual(done.returncode, 4, done.stderr)
        last = done.stdout.splitlines()[-1]
        self.assertRegex(last, r"^verdict {6}.*" + text)
        self.assertEqual(done.stderr, "toliman: not ready: " + last[13:] + "\n")

    def test_a_slow_disk(self):
        self.not_ready(r" (6|7|8|9|\d\d)\d ms in /.*--sync group", env=self.disk(60))

    def test_no_place(self):
        self.not_ready("/.*/none: ", "none")
        done = self.run_program("doctor", "none", "--json", env=self.disk(0))
        result = json.loads(done.stdout)
        self.assertEqual((done.returncode, result["ready"], result["fsync_ms"]), (4, False, None))

    def test_old_kernels(self):
        result = json.loads(self.run_program("doctor", "--json").stdout)
        if result["isa"] == "baseline":
            self.skipTest("they fit this CPU")
        self.not_ready("Prescott .*OPENBLAS_CORETYPE=", env={**self.disk(0), "OPENBLAS_CORETYPE": "Prescott"})


if __name__ == "__main__":
    unittest.main()
