"""Windows of 128x128 pixels at few samples, wavelengths and frames: the short form of core_campaign.py."""
import argparse
import pathlib
import tempfile
import unittest

from study import run
import core_campaign as campaign

GROUPS = {"telescope": {"pupil_samples": 96}, "band": {"min_nm": 550, "max_nm": 600, "step_nm": 25}, "cadence": {"frames": 60},
          "signal": {"period_days": 20}}


class Campaign(unittest.TestCase):
    def test_methods_reach_the_bound(self):
        with tempfile.TemporaryDirectory() as folder:
            wrong, lines = run(campaign.measure, argparse.Namespace(folder=pathlib.Path(folder), seeds=2, groups=GROUPS,
                                                                    efficiency=0.8))
        self.assertEqual(wrong, [])
        rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in lines[2:]]
        self.assertEqual([row[1] for row in rows], ["cae", "template", "cae", "template", "fit"])
        self.assertEqual({(row[6], row[8]) for row in rows}, {("2 of 2", "0 of 4")})
        self.assertEqual(rows[3][2], rows[4][2])


if __name__ == "__main__":
    unittest.main()
