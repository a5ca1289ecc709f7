"""Tests that C and Fortran give the same numbers to the last bit; also failures in Fortran."""
import json
import os
import re
import struct
import subprocess
import tempfile
import unittest

import numpy

from package import ROOT
from toliman import _raw

KEPT = tempfile.TemporaryDirectory()
SCENE = os.path.join(KEPT.name, "scene.json")
PROGRAMS = os.path.dirname(os.environ["TOLIMAN"])
N, FRAMES = 1095, 6


def setUpModule():
    """The chapter's scene with frames that are not square, so that exchanged rows and columns are detected."""
    unittest.addModuleCleanup(KEPT.cleanup)
    scene = json.loads((ROOT / "examples" / "scenes" / "chapter.json").read_text())
    scene["detector"]["shape"] = [260, 270]
    scene["telescope"]["pupil_samples"] = 128
    scene["band"]["step_nm"] = (scene["band"]["max_nm"] - scene["band"]["min_nm"]) / 4
    with open(SCENE, "w", encoding="utf-8") as stream:
        json.dump(scene, stream)


def run(program, *arguments):
    """(code, stdout, stderr); one OpenBLAS thread, since the last bits of components depend on the number of
    threads."""
    done = subprocess.run([os.path.join(PROGRAMS, program), SCENE, *arguments], universal_newlines=True,
                          stdout=subprocess.PIPE, stderr=subprocess.PIPE, env={**os.environ, "OPENBLAS_NUM_THREADS": "1"})
    return done.returncode, done.stdout, done.stderr


def value_of(bits):
    return struct.unpack(">d", bytes.fromhex(bits))[0]


def least_squares(frequency):
    """Share of the samples' sum of squares that a sinusoid of this frequency removes."""
    k = numpy.arange(N)
    y = k * 37 % 101 / 1010 + numpy.where(k % 365 < 182, 0.25, 0)
    angle = 2 * numpy.pi * frequency * k
    _, left, _, _ = numpy.linalg.lstsq(numpy.stack([angle * 0 + 1, numpy.cos(angle), numpy.sin(angle)], 1), y, rcond=None)
    return 1 - left[0] / numpy.sum((y - y.mean()) ** 2)


def grid():
    """The lowest frequencies of the grid, which include the highest peak."""
    return [(1.5 + 0.1 * k) / N for k in range(100)]


class Numbers(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.c, cls.fortran = run("bind_numbers_c"), run("bind_numbers_fortran")
        cls.lines = [line.split(" ") for line in cls.c[1].splitlines()]
        cls.values = {name: value_of(text) for name, text in cls.lines if re.fullmatch("[0-9A-F]{16}", text)}

    def test_fortran_equals_c(self):
        self.assertEqual(self.c[0], 0, self.c[2])
        self.assertEqual(self.fortran[0], 0, self.fortran[2])
        self.assertGreater(len(self.lines), 40)
        self.assertEqual(self.fortran[1].splitlines(), self.c[1].splitlines())

    def test_expected_values(self):
        got = self.values
        self.assertEqual(dict(self.lines)["name"], "chapter")
        self.assertEqual(got["rows"], 260)
        self.assertLess(abs(got["estimate"] - 1e-6), 5 * got["sigma"])
        self.assertLess(abs(got["frame_sum"] - got["photons"]), 5 * got["photons"] ** 0.5)
        self.assertAlmostEqual(got["power"], least_squares((1.5 + 0.1 * 102) / N), delta=1e-12)
        self.assertAlmostEqual(got["batch"], got["power"], delta=1e-9)
        self.assertAlmostEqual(least_squares(1 / got["period"]) / max(map(least_squares, grid())), 1, delta=1e-2)
        self.assertAlmostEqual(got["planet_period"], 90, delta=2)
        self.assertGreater(got["planet_bayes"], 2)
        self.assertGreater(got["planet_injected"], 0)
        self.assertEqual(got["networks"], 4)
        self.assertTrue(0 < got["bank_efficiency"] <= 1)
        self.assertLess(abs(got["bank_displacement"] - 1e-6), 5 * got["bank_sigma"])
        self.assertGreater(got["share"], 0.9)  # of frames each displaced by 1000 sigma
        self.assertEqual([got[name] for name in ("count", "in_period", "rejected", "bad_pixel")], [N, FRAMES - 1, 1, 7009])
        self.assertEqual(got["tai"], (FRAMES - 1) * 86400e9 + 1000)


class Failures(unittest.TestCase):
    def test_stat_and_errmsg(self):
        code, output, errors = run("bind_failures")
        self.assertEqual(code, 0, errors)
        lines = output.splitlines()
        expected = [
            (_raw.TOLIMAN_E_NOT_FOUND, "no/such/scene.json"), (_raw.TOLIMAN_E_ARGUMENT, "sim"),
            (_raw.TOLIMAN_E_ARGUMENT, "size(image, 2) = 259: must be 260"), (_raw.TOLIMAN_E_ARGUMENT, "stride"),
            (_raw.TOLIMAN_E_ARGUMENT, "size(weight_b, 1) = 4: must be 5"), (_raw.TOLIMAN_E_NOT_FOUND, "no/such/weights"),
            (_raw.TOLIMAN_E_ARGUMENT, "cae"), (_raw.TOLIMAN_E_ARGUMENT, "pixels is NULL"), (_raw.TOLIMAN_E_ARGUMENT, "f0"),
            (_raw.TOLIMAN_E_STATE, "five samples"), (_raw.TOLIMAN_E_ARGUMENT, "size(y, 1) = 4: must be 5"),
            (_raw.TOLIMAN_E_NOT_FOUND, "no/such/folder"), (_raw.TOLIMAN_OK, "untouched"),
        ]
        self.assertEqual(len(lines), len(expected), output)
        for line, (status, words) in zip(lines, expected):
            self.assertEqual(int(line.split(" ", 1)[0]), status, line)
            self.assertIn(words, line)

    def test_without_stat_the_program_stops(self):
        code, output, errors = run("bind_failures", "stop")
        self.assertNotEqual(code, 0)
        self.assertEqual(output, "")
        self.assertIn("libtoliman: period", errors)

    def test_objects_cannot_be_assigned(self):
        code, output, errors = run("bind_failures", "assign")
        self.assertNotEqual(code, 0)
        self.assertEqual(output, "empty ones may\n")
        self.assertIn("cannot be assigned", errors)

    @unittest.skipIf(os.environ.get("TOLIMAN_SANITIZE"), "sanitizers keep what is freed")
    def test_memory_is_freed(self):
        """20 times three objects of 13 MB: 0.8 GB if they leaked."""
        child = subprocess.Popen([os.path.join(PROGRAMS, "bind_failures"), SCENE, "leak"], stdout=subprocess.PIPE)
        output = child.stdout.read()
        _, code, usage = os.wait4(child.pid, 0)
        child.stdout.close()
        child.returncode = code
        self.assertEqual((code, output), (0, b"freed\n"))
        self.assertLess(usage.ru_maxrss, 200 * 1024)


if __name__ == "__main__":
    unittest.main()
