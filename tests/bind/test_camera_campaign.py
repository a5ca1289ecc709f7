"""A mission through an unknown detector: the short form of camera_campaign.py, in small frames of few wavelengths."""
import os
import unittest
import unittest.mock

import package  # noqa: F401, which finds the studies
from study import Serial, run
import camera_campaign as campaign


def rough(frames, side):
    scene = campaign.doubt_frames.nominal(frames, side)
    scene["telescope"]["pupil_samples"] = 128
    scene["band"]["step_nm"] = 11
    return scene


class Missions(unittest.TestCase):
    # promise: detectors-are-calibrated
    @unittest.skipUnless("TOLIMAN" in os.environ, "the environment names no program")
    def test_missions(self):
        with unittest.mock.patch.object(campaign, "nominal", rough):
            wrong, lines = run(campaign.missions, Serial, (1,), 40, 48, 3e13, ("nominal", "all"))
        self.assertEqual(wrong, [], "\n".join(lines))
        self.assertEqual(len(lines), 6)


if __name__ == "__main__":
    unittest.main()
