"""Sums of short frames from Python: exact counts, verdicts, saved sums, and the short form of tools/studies/coadd_campaign.py,
whose frames are drawn with numpy."""
import os
import subprocess
import sys
import unittest

import numpy

import toliman

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path.insert(0, os.path.join(ROOT, "tools", "studies"))
import coadd_campaign as study  # noqa: E402

FRAMES = 60


class Coadd(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        scene = study.scene_of(study.SIDE, bias_dn=study.BIAS, gain_e_per_dn=1, bit_depth=12)
        cls.fit = toliman.Fit(toliman.Simulator(scene), capture_px=8)
        random, sky = numpy.random.default_rng(4), study.Sky()
        cls.places = study.places("normal", FRAMES, 0.3, random)
        cls.frames = [study.draw(sky, place, random) for place in cls.places]

    def test_sums(self):
        coadd = toliman.Coadd(self.fit, gap_s=1)
        halfway = None
        for k, frame in enumerate(self.frames):
            outcome = coadd.add(frame if k % 2 else frame.astype(numpy.uint32), k * 10**7, exposure_s=0.005)
            self.assertEqual(outcome.verdict, "added")
            self.assertLess(abs(outcome.x_px - self.places[k][0]), 6 * outcome.x_sigma_px)
            halfway = coadd.to_bytes() if k == FRAMES // 2 else halfway
        outcome = coadd.add(self.frames[0], 10**12)
        self.assertEqual((outcome.verdict, outcome.reason), ("next", "gap"))
        taken = coadd.take()
        plain = numpy.sum(self.frames, axis=0, dtype=numpy.uint32)
        kept = taken.left_out == 0
        numpy.testing.assert_array_equal(taken.counts[kept], plain[kept])
        self.assertEqual(taken.spread.frames, FRAMES)
        covariance = numpy.cov(self.places.T, bias=True)
        numpy.testing.assert_allclose((taken.spread.xx, taken.spread.xy, taken.spread.yy), covariance.ravel()[[0, 1, 3]],
                                      atol=0.001)
        coadd.load_bytes(halfway)
        self.assertEqual(coadd.info.frames, FRAMES // 2 + 1)
        with self.assertRaises(toliman.InputError):
            coadd.load_bytes(halfway[:-1])
        for wrong in (self.frames[0].astype(float), self.frames[0].astype(numpy.int16)):
            with self.assertRaises(TypeError):
                coadd.add(wrong, 0)

    def test_study(self):
        program = os.path.join(ROOT, "tools", "studies", "coadd_campaign.py")
        done = subprocess.run([sys.executable, program, "--sums", "12", "--frames", "100"], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)


if __name__ == "__main__":
    unittest.main()
