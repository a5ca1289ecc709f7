"""track --fit --weights: the values of encode, warnings of a bank that does not serve the frames, and other banks."""
import csv
import json
import unittest

from program import ProgramTest
from test_fit import SCENE

STEP = 10  # days
LARGE = {**SCENE, "telescope": {**SCENE["telescope"], "pupil_samples": 144},
         "cadence": {"frames": 24, "interval_days": STEP, "peak_photons": 1e5},
         "detector": {"shape": [256, 256], "pixel_scale_arcsec": 0.4}}
GRID = "--mission-days", "400", "--cadence", STEP * 86400


class TrackBank(ProgramTest):
    def setUp(self):
        super().setUp()
        (self.folder / "s.json").write_text(json.dumps(LARGE))
        self.assertEqual(self.run_program("simulate", "s.json", "--frames", "0:4", "--out", "f.npy").returncode, 0)

    def train(self, steps, dates="frames"):
        name = f"{steps}.tlmb"
        self.succeed("train", "s.json", "--bank", dates, "--places", 1, "--steps", steps, "--out", name)
        return name

    def track(self, bank, *more, state="st"):
        """Lines of the frames, messages, records."""
        done = self.run_program("track", "--fit", "s.json", "--weights", bank, "--state", state, *GRID, *more, "f.npy")
        self.assertEqual(done.returncode, 0, done.stderr)
        lines = [json.loads(line) for line in done.stdout.splitlines()]
        records = [json.loads(line) for line in self.succeed("status", state, "--records").splitlines()]
        return [line for line in lines if line["schema"] == "toliman-frame/2"], done.stderr.splitlines(), records

    def test_values_are_those_of_encode(self):
        bank = self.train(100)
        rows = list(csv.DictReader(self.run_program("encode", "--fit", "s.json", "--weights", bank, "f.npy").stdout.splitlines()))
        frames, messages, records = self.track(bank)
        self.assertEqual([frame["value"] for frame in frames], [float(row["displacement_px"]) for row in rows])
        for record, row in zip(records, rows):
            self.assertAlmostEqual(record["sigma"] / float(row["separation_sigma_px"]), 1, places=5)
        least = min(float(row["efficiency"]) for row in rows)
        self.assertRegex(messages[0], rf"smallest {least:.4f}; of 4 .* 0 .* 0\.95 and 0 ")
        self.assertIn(": toliman train s.json --bank 2027-08-19:", messages[1])
        self.assertEqual(len(messages), 2)

    def test_a_bank_that_does_not_serve_the_frames(self):
        _, messages, _ = self.track(self.train(60, "2027:2027.02"))  # the first week
        self.assertEqual(len(messages), 4, messages)
        self.assertRegex(messages[0], r"warning: frame 0: .* 0\.[5-9][0-9]+ .* 0\.95")
        self.assertIn("warning: frame 1: ", messages[1])
        self.assertRegex(messages[2], r"of 4 .* 4 .* 0\.95 and 3 ")
        self.assertIn("warning: ", messages[3])
        for state, steps, texts in (("st", 61, ("st", "ids 0 to 3 of session f\n")), ("new", 3, ("3.tlmb: network 0 of 1 ", "0.5"))):
            with self.subTest(state):
                bank = self.train(steps, "2027:2027.02")
                self.refuse(2, *texts, arguments=("track", "--fit", "s.json", "--weights", bank, "--state", state, *GRID, "f.npy"))


if __name__ == "__main__":
    unittest.main()
