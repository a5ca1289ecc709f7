"""Blurred images against quadrature: the short form of blur_campaign.py; and what commands say of wide blurs."""
import json
import unittest
import unittest.mock

import numpy

from package import toliman
from study import Serial, run
import blur_campaign as campaign

CHAPTER = campaign.ROOT / "examples" / "scenes" / "chapter.json"


class Blurs(unittest.TestCase):
    def test_against_quadrature(self):
        with unittest.mock.patch.object(campaign, "SHAPES", campaign.SHAPES[1:2]):
            wrong, lines = run(campaign.blurs, Serial, (3,), (0.375,))
        self.assertEqual((wrong, lines[-1]), ([], "16 cases"))

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
