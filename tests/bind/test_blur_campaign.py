"""Blurred images against quadrature: the short form of blur_campaign.py; and what commands say of wide blurs."""
import contextlib
import io
import json
import pathlib
import sys
import unittest

import numpy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import blur_campaign  # noqa: E402
import toliman  # noqa: E402
from test_planet_campaign import Serial  # noqa: E402

CHAPTER = blur_campaign.ROOT / "examples" / "scenes" / "chapter.json"


class Blurs(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        blur_campaign.campaign.quiet()

    def test_against_quadrature(self):
        with contextlib.redirect_stdout(io.StringIO()) as printed:
            self.assertEqual(blur_campaign.blurs(Serial, (3,), (0.375,)), [])
        self.assertIn("48 cases", printed.getvalue())

    def test_images_of_wide_blurs_are_light(self):
        """Positive, as bright as without the blur, and of a bound that grows with it: 5.9e-6 px at 5 px by quadrature."""
        scene, bounds, light = json.loads(CHAPTER.read_text()), [], []
        for sigma in 0, 2, 5:
            simulator = toliman.Simulator({**scene, "systematics": {"jitter_sigma_px": sigma}})
            image = simulator.image()
            bounds.append(simulator.bounds.crb_px)
            light.append(image.sum() / image.max())
            self.assertGreater(image.min(), 0, sigma)
        self.assertEqual(bounds, sorted(bounds))
        self.assertAlmostEqual(bounds[-1] / 5.9e-6, 1, delta=0.05)
        self.assertTrue((numpy.diff(light) > 0).all(), light)


if __name__ == "__main__":
    unittest.main()
