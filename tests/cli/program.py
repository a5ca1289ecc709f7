"""Runs the program the way a user does. TOLIMAN is the program, CMake sets it for the tests."""
import hashlib
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

import schemas

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCENES = ROOT / "examples" / "scenes"
# Seconds after which a run is taken to hang; sanitizers are slow.
PATIENCE = 2500 if os.environ.get("TOLIMAN_SANITIZE") else 250
HEADER, LINE = 124 + 10 * 64, 64 + 10 * 8  # bytes of a ledger's header and of its lines, tools/docs/formats.md "TLML"
# Otherwise the program sets it and starts twice, as test_doctor.py runs it.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
PROGRAM = os.path.abspath(os.environ.get("TOLIMAN", ROOT / "build" / "bin" / "toliman"))

# One star on 8x8 px, for what does not depend on the scene.
TINY = {
    "schema": "toliman-scene/1",
    "telescope": {"aperture_m": 0.125, "pupil_samples": 32},
    "band": {"wavelength_nm": 550},
    "stars": {"A": {"spectrum": {"kind": "blackbody", "temperature_k": 5790}}},
    "cadence": {"frames": 10, "peak_photons": 1e6},
    "detector": {"shape": [8, 8], "pixel_scale_arcsec": 0.2},
}


# Days of steps of TAI - UTC from 1972 on, MJD, as the IERS publishes them.
LEAP_DAYS = (41317, 41499, 41683, 42048, 42413, 42778, 43144, 43509, 43874, 44239, 44786, 45151, 45516, 46247, 47161, 47892,
             48257, 48804, 49169, 49534, 50083, 50630, 51179, 53736, 54832, 56109, 57204, 57754)


def leap_seconds(*more, expires=66000):
    """A leap-seconds.list with its hash; more: days (MJD) of further leap seconds."""
    ntp = lambda day: str((day - 15020) * 86400)
    rows = [(ntp(day), str(10 + k)) for k, day in enumerate((*LEAP_DAYS, *more))]
    digits = hashlib.sha1("".join((ntp(61000), ntp(expires), *("".join(row) for row in rows))).encode()).hexdigest()
    text = f"#\tupdated\n#$\t{ntp(61000)}\n#@\t{ntp(expires)}\n" + "".join(f"{a}\t{b}\t# step\n" for a, b in rows)
    return text + "#h\t" + " ".join(digits[k:k + 8] for k in range(0, 40, 8)) + "\n"


def one_wavelength():
    """The chapter's scene at one wavelength, which takes a third of the time, where no more is needed."""
    return {**json.loads((SCENES / "chapter.json").read_text()), "band": {"wavelength_nm": 580}}


# Runs in `make long` alone.
LONG = bool(os.environ.get("TOLIMAN_LONG"))
long = unittest.skipUnless(LONG, "runs in make long")

# A message: what it is about, a colon, and what is wrong or allowed; or words of the command line that do not go
# together. No full stop, control character or blank too many. test_messages.py has examples.
FORM = re.compile(r"toliman: (?!.*(  |[\x00-\x09\x0b-\x1f\x7f]))"
                  r"(.*: \S.*|--\S+ (requires|excludes|needs) --.*|\S+ is required|"
                  r"(unknown|unexpected) (command|option|argument) .*|give .*)(?<![:, ])(?<![^.]\.)\n\Z")


class ProgramTest(unittest.TestCase):
    """Each test runs in a fresh empty folder, self.folder."""

    modules = ()  # of the Python package, which the name of a command stands for

    def setUp(self):
        kept = tempfile.TemporaryDirectory()
        self.addCleanup(kept.cleanup)
        self.folder = pathlib.Path(kept.name)

    def words_of(self, *arguments):
        """The words that start the program or a module."""
        words = [str(word) for word in arguments]
        if words and words[0] in self.modules:
            return [sys.executable, "-m", f"toliman.{words[0]}", *words[1:]]
        return [PROGRAM, *words]

    def run_program(self, *arguments, **options):
        done = subprocess.run(
            self.words_of(*arguments), cwd=self.folder, capture_output=True, text=True, timeout=PATIENCE, **options
        )
        schemas.check(done.stdout)
        return done

    def succeed(self, *arguments, **options):
        """Standard output of a run that must end well and say nothing on stderr but results of `train`."""
        done = self.run_program(*arguments, **options)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout

    def refuse(self, code, *texts, arguments, left=()):
        """The run must end with this code and one line on stderr, of the form of all messages, that holds the texts
        (names and values, no sentences), and leave no new file behind. Returns that line."""
        before = sorted(p.name for p in self.folder.iterdir())
        done = self.run_program(*arguments)
        self.assertEqual(done.returncode, code, done.stderr)
        self.assertEqual(done.stderr.count("\n"), 1, done.stderr)
        self.assertRegex(done.stderr, FORM)
        for text in texts:
            self.assertIn(text, done.stderr)
        self.assertEqual(done.stdout, "")
        self.assertEqual(sorted(p.name for p in self.folder.iterdir()), sorted(before + list(left)))
        return done.stderr

    def refuse_all(self, *rows, command=()):
        """Rows of (code, text, *arguments), after those of the command."""
        for code, text, *arguments in rows:
            with self.subTest(arguments):
                self.refuse(code, text, arguments=(*command, *arguments))
