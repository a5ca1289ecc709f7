"""train --bank, encode --weights BANK --fit, plan: networks that follow moving stars, their dates, messages and refusals."""
import datetime
import functools
import json
import os
import pathlib
import random
import re
import signal
import subprocess
import tempfile
import time
import unittest


from program import PATIENCE, PROGRAM, ProgramTest
from test_fit import COLUMNS as FIT_COLUMNS
from test_fit import SCENE as SMALL

# 2026.0 and 2030.0 are midnight: 2000.0 is noon, and 26 and 30 Julian years have half a day.
SCENE = {**SMALL, "binary": {"date": 2026, "orbit": "alpha-cen", "moving": True},
         "cadence": {"frames": 100, "interval_days": 2, "peak_photons": 1e7},
         "telescope": {**SMALL["telescope"], "pupil_samples": 144}, "band": {"wavelength_nm": 575},
         "detector": {"shape": [256, 256], "pixel_scale_arcsec": 0.4}}
AT_REST = {**SCENE, "binary": {"separation_arcsec": 7, "position_angle_deg": 30}}
QUICK = ("--places", "1", "--steps", "30")
COLUMNS = ("file,frame,displacement_px,chi_square,chi_square_sigma,largest_residual,goodness,bad_pixels,separation_px,"
           "separation_sigma_px,efficiency,network,fit_displacement_px,position_angle_deg,x_px,y_px,flux_a,flux_b,background,iterations,flags")
ENCODE = ("encode", "--weights", "b.tlmb", "--fit", "s.json")
SOON = 6  # s


@functools.lru_cache(None)
def made():
    """A folder with a bank of three networks and frames, and what the training printed."""
    kept = tempfile.TemporaryDirectory()
    folder = pathlib.Path(kept.name)
    (folder / "s.json").write_text(json.dumps(SCENE))
    printed = [subprocess.run([PROGRAM, *command], cwd=folder, capture_output=True, text=True, check=True).stderr
               for command in (("train", "s.json", "--bank", "frames", *QUICK, "--spacing", "0.3", "--out", "b.tlmb"),
                               ("simulate", "s.json", "--frames", "0:3", "--out", "f.npy"))]
    return kept, folder, printed[0]


class Bank(ProgramTest):

    def setUp(self):
        super().setUp()
        _, folder, self.trained = made()
        for path in folder.iterdir():
            os.link(path, self.folder / path.name)

    def write(self, name, scene):
        (self.folder / name).write_text(json.dumps(scene))

    def bytes_of(self, name):
        return (self.folder / name).read_bytes()

    def rows(self, text, columns=COLUMNS):
        head, *lines = text.splitlines()
        self.assertEqual(head, columns)
        return [dict(zip(columns.split(","), line.split(","))) for line in lines]

    def train(self, *arguments):
        """The last message."""
        done = self.run_program("train", "s.json", *arguments)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stderr.splitlines()[-1]


class Train(Bank):
    def test_result(self):
        found = re.search(r" 1 x 3\D+(0\.\d{4}) to (0\.\d{4}),.* (\d{4}-\d\d-\d\d), \d+ kB$", self.trained.splitlines()[-1])
        self.assertTrue(found, self.trained)
        self.assertLessEqual(float(found[1]), float(found[2]))
        last = datetime.date(2026, 1, 1) + datetime.timedelta(days=2 * 99)
        self.assertEqual(found[3], last.isoformat())

    def test_calendar_dates_and_years(self):
        for name, dates in (("years", "2026:2030"), ("days", "2026-01-01:2030-01-01")):
            last = self.train("--bank", dates, *QUICK, "--spacing", "4", "--out", name)
            self.assertIn(", 2030-01-01, ", last)
        self.assertEqual(self.bytes_of("years"), self.bytes_of("days"))

    def test_payloads(self):
        exact = self.rows(self.succeed(*ENCODE, "f.npy"))
        self.train("--bank", "frames", *QUICK, "--spacing", "0.3", "--payload", "bf16", "--out", "x")
        self.assertLess(len(self.bytes_of("x")), 0.7 * len(self.bytes_of("b.tlmb")))
        for row, narrow in zip(exact, self.rows(self.succeed("encode", "--weights", "x", "--fit", "s.json", "f.npy"))):
            self.assertNotEqual(row["displacement_px"], narrow["displacement_px"])
            change = float(row["displacement_px"]) - float(narrow["displacement_px"])
            self.assertLess(abs(change), 0.05 * float(row["separation_sigma_px"]))

    def test_stars_at_rest(self):
        self.write("rest.json", AT_REST)
        done = self.run_program("train", "rest.json", "--bank", "frames", *QUICK, "--out", "rest.tlmb")
        self.assertRegex(done.stderr, r"^rest.tlmb: .* 1 x 1.* 0\.\d+ to 0\.\d+, \d+ kB\n$")
        self.refuse(2, "--bank 2026:2027: ", arguments=("train", "rest.json", "--bank", "2026:2027", "--out", "x"))

    def test_refusals(self):
        for text, *arguments in (
            *(("--bank " + dates, "--bank", dates) for dates in ("2026", "2027:2026", "2026-02-30:2027", "2026:nan", "")),
            ("--bank 2026:2052", "--bank", "2026:2052", *QUICK, "--spacing", "4"),  # the fit does not cover the last date
            ("--bank 2026:2036", "--bank", "2026:2036", "--places", "8", "--spacing", "0.05"),  # 449 dates
            *((option, "--bank", "frames", option, value) for option, value in (
                ("--mode", "unsupervised"), ("--epochs", "3"), ("--input", "raw"), ("--spacing", "9"), ("--places", "9"),
                ("--free", "scal"))),
            *((f"{option}: ", option, value) for option, value in (("--places", "2"), ("--spacing", "2"), ("--free", "scale"))),
            ("--resume", "--resume", "b.tlmb", "--bank", "frames"),
        ):
            with self.subTest(arguments):
                self.refuse(2, text, arguments=("train", "s.json", "--out", "x", *arguments))
        done = self.run_program("train", "s.json", "--out", "x", "--resume", "b.tlmb")
        self.assertEqual((done.returncode, "b.tlmb: " in done.stderr), (3, True), done.stderr)


class Stops(Bank):
    HOW = ("--bank", "2026:2026.3", "--places", "2", "--steps", "60", "--free", "scale")

    def start(self, *arguments):
        return subprocess.Popen([PROGRAM, "--progress=json", "train", "s.json", *arguments], cwd=self.folder,
                                stderr=subprocess.PIPE, text=True)

    # promises: bank-training-resumes, killed-trainings-resume
    def test_resumed_after_any_stop(self):
        """Weights do not depend on the moments of the signals. A journal of other options is refused, and what differs is named."""
        self.train(*self.HOW, "--out", "whole")
        chance, stopped, done, command = random.Random(1), 0, 0, ("--out", "parts", *self.HOW, "--resume")
        while not (self.folder / "parts").exists():
            child = self.start(*command)
            if stopped < 2:
                for line in child.stderr:  # until one more network is trained
                    found = re.search(r'"note":"(\d+) of 4 networks', line)
                    if found and int(found[1]) > done:
                        done = int(found[1])
                        break
                time.sleep(chance.uniform(0, 0.05))
                child.send_signal(signal.SIGTERM)
            errors = child.communicate(timeout=PATIENCE)[1].splitlines()
            self.assertIn(child.returncode, (0, 143))
            if child.returncode == 143:
                stopped += 1
                self.assertIn("parts.part", errors[-2])
            if child.returncode == 143 and stopped == 1:
                self.refuse(3, "parts.part: ",
                            arguments=("encode", "--weights", "parts.part", "--fit", "s.json", "--free", "scale", "f.npy"))
                for other in (("--free", "jitter_xx"), ("--bank", "2026:2026.2")):
                    how = [*self.HOW, "--seed", "1"]
                    how[how.index(other[0]) + 1] = other[1]
                    self.refuse(2, "parts.part: ", arguments=("train", "s.json", *how, "--out", "parts", "--resume"))
        self.assertGreater(stopped, 0)
        self.assertEqual(self.bytes_of("parts"), self.bytes_of("whole"))
        self.assertFalse((self.folder / "parts.part").exists())

    def test_within_seconds(self):
        """A stop before the first network is done leaves nothing."""
        before = sorted(self.folder.iterdir())
        child = self.start("--bank", "frames", "--steps", "1000000", "--out", "x")
        while '"progress":"train"' not in child.stderr.readline():
            pass
        start = time.monotonic()
        child.send_signal(signal.SIGINT)
        last = child.communicate(timeout=PATIENCE)[1].splitlines()[-1]
        self.assertLess(time.monotonic() - start, SOON)
        self.assertEqual((child.returncode, last), (130, "toliman: stopped by a signal"))
        self.assertEqual(sorted(self.folder.iterdir()), before)


class Encode(Bank):
    def test_numbers(self):
        done = self.run_program(*ENCODE, "f.npy")
        rows = self.rows(done.stdout)
        fits = self.rows(self.succeed("encode", "--fit", "s.json", "f.npy"), FIT_COLUMNS)
        self.assertEqual(len(rows), 3)
        for row, fit in zip(rows, fits):
            for name in FIT_COLUMNS.split(","):
                if name not in ("displacement_px", "separation_px", "separation_sigma_px", "flags"):
                    self.assertEqual(row[name], fit[name], name)
            self.assertEqual(row["fit_displacement_px"], fit["displacement_px"])
            sigma, bound = float(row["separation_sigma_px"]), float(fit["separation_sigma_px"])
            self.assertAlmostEqual(sigma * float(row["efficiency"]), bound, delta=1e-4 * bound)
            self.assertLess(abs(float(row["displacement_px"]) - float(fit["displacement_px"])), 5 * sigma)
            predicted = [float(line["separation_px"]) - float(line["displacement_px"]) for line in (row, fit)]
            self.assertAlmostEqual(*predicted, delta=1e-9)
            self.assertEqual((row["network"], row["flags"]), ("0", "low_efficiency"))
        efficiencies = sorted(float(row["efficiency"]) for row in rows)
        self.assertIn("smallest %.4f, median %.4f\n" % (efficiencies[0], efficiencies[1]), done.stderr)
        self.assertIn(f"warning: f.npy: frame 0: an efficiency of {float(rows[0]['efficiency']):.3g} ", done.stderr)
        self.assertIn("warning: 3 of 3 frames ", done.stderr)
        self.assertNotIn("dates of the bank", done.stderr)

    def test_bits(self):
        """On one processor, and one by one through a pipe."""
        whole = self.succeed(*ENCODE, "f.npy")
        alone = self.succeed(*ENCODE, "f.npy", preexec_fn=lambda: os.sched_setaffinity(0, {min(os.sched_getaffinity(0))}))
        self.assertEqual(alone, whole)
        piped = subprocess.run([PROGRAM, *ENCODE, "-"], cwd=self.folder, input=self.bytes_of("f.npy"), capture_output=True,
                               check=True)
        self.assertEqual(piped.stdout.decode().replace("\n-,", "\nf.npy,"), whole)

    def test_outside_the_dates(self):
        done = self.run_program(*ENCODE, "--cadence", str(150 * 86400), "f.npy")
        outside = ["outside" in row["flags"].split("+") for row in self.rows(done.stdout)]
        self.assertEqual(outside, [False, False, True])  # of days 0, 150 and 300
        self.assertRegex(done.stderr, r"1 of 3 frames .* 2026-07-18; .*: toliman train s\.json --bank 2026-07-18:2027-02-01 "
                                      r"--places 1 --spacing 0\.3 --steps 30 --out FILE\n")

    def test_refusals(self):
        self.write("rest.json", AT_REST)
        self.succeed("train", "rest.json", "--steps", "1", "--out", "w.tlmw")
        (self.folder / "cut.tlmb").write_bytes(self.bytes_of("b.tlmb")[:-9])
        for code, text, *arguments in (
            (2, "b.tlmb: ", "--weights", "b.tlmb"),
            (2, "b.tlmb: ", "--weights", "b.tlmb", "--fit", "s.json", "--free", "scale"),
            (2, "b.tlmb: ", "--weights", "b.tlmb", "--fit", "rest.json"),
            (2, "--weights, --template and --fit", "--weights", "b.tlmb", "--template", "s.json"),
            *((code, f"{name}: ", "--weights", name, "--fit", "s.json")
              for code, name in ((3, "f.npy"), (3, "none"), (2, "w.tlmw"), (3, "cut.tlmb"))),
        ):
            with self.subTest(arguments):
                self.refuse(code, text, arguments=("encode", *arguments, "f.npy"))


class Plan(Bank):
    def plan(self, name):
        return json.loads(self.succeed("plan", name, "--json"))["bank"]

    def test_bank(self):
        plan = self.plan("s.json")
        self.assertEqual((plan["networks"], plan["places"]), (plan["places"] * plan["dates"], 9))
        self.assertEqual((plan["first_days"], plan["last_days"]), (0, 198))
        self.assertEqual(2 * plan["bytes_half"], plan["bytes_float32"])
        self.assertRegex(self.succeed("plan", "s.json"), rf"\nbank          {plan['networks']} .* 9 x {plan['dates']}\), ")

    def test_none(self):
        self.write("rest.json", AT_REST)
        self.assertIsNone(self.plan("rest.json"))
        self.assertNotIn("\nbank ", self.succeed("plan", "rest.json"))
        scene = {**SCENE, "binary": {"offsets_px": {"A": [0, 0]}}, "systematics": {"pointing_rms_px": 0.3}}
        self.write("single.json", {**scene, "stars": {"A": SCENE["stars"]["A"]}, "signal": {"kind": "none"}})
        self.assertIsNone(self.plan("single.json"))
        self.assertIn("\nbank          none: single.json: ", self.succeed("plan", "single.json"))


if __name__ == "__main__":
    unittest.main()
