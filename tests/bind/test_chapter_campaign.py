"""Smoothness in time on simulated frames, and the table of a training: the short form of chapter_campaign.py."""
import argparse
import pathlib
import tempfile
import unittest

from study import Serial, run
import chapter_campaign as campaign

LOG = """# epochs of an unsupervised training; log10_fap: of the latents of frames
epoch,loss,validation_loss,mmse,mssim,log10_fap_trained,log10_fap_fresh,log10_fap_none
0,,,,,-14.00,-13.50,-0.10
1,0.0021,0.0011,0.0011,0.910000000,,,
2,0.00021,0.00011,0.00011,0.991000000,-9.00,-8.50,-0.20
"""


class Chapter(unittest.TestCase):
    def test_smoothness_in_time_lowers_the_threshold(self):
        """96 x 96 px: the unconstrained axis is noise at an amplitude that every penalty finds; no false alarm."""
        found, _ = run(campaign.smooth, argparse.Namespace(seeds=1, controls=1), Serial, (5e-6,), {"shape": [96, 96]})
        for key, series in found[5e-6].items():
            self.assertEqual([campaign.is_found(*peak) for peak in series], [key != (1, 0)], (key, series))
        for key, series in found[0].items():
            self.assertTrue(all(log10_fap > -3 for _, log10_fap in series), (key, series))

    def test_table_and_figure(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "log.csv"
            path.write_text(LOG)
            logs = {1e-2: campaign.read_log(path)}
            rows = list(campaign.table_of(logs))
            self.assertEqual(rows[2:], ["| 0.01 px | 0 |  |  |  |  | -14 | -13.5 | -0.1 |",
                                        "| 0.01 px | 1 | 2.1e-03 | 1.1e-03 | 1.1e-03 | 0.9100 |  |  |  |",
                                        "| 0.01 px | 2 | 2.1e-04 | 1.1e-04 | 1.1e-04 | 0.9910 | -9 | -8.5 | -0.2 |"])
            self.assertEqual(list(campaign.summary_of(logs))[2],
                             "| 0.01 px | 2 | 1.1e-04 | 6.1e-04 | 1 of 1 (-9.0) | 1 of 1 (-8.5) | 0 of 1 (-0.2) |")
            campaign.draw(logs, campaign.photon_floor(), path.with_suffix(".png"))
            self.assertGreater(path.with_suffix(".png").stat().st_size, 10000)
        self.assertAlmostEqual(campaign.photon_floor() / 7.13e-11, 1, delta=0.01)


if __name__ == "__main__":
    unittest.main()
