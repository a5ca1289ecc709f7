"""A mission through an unknown detector: the short form of camera_campaign.py."""
import os
import unittest

import package  # noqa: F401, which finds the studies
from study import Serial, run
import camera_campaign as campaign


class Missions(unittest.TestCase):
    @unittest.skipUnless("TOLIMAN" in os.environ, "the environment names no program")
    def test_a_planet_and_none(self):
        wrong, lines = run(campaign.missions, Serial, (1,), 60, 48, 3e11, (True, False), ("all",))
        self.assertEqual(wrong, [], "\n".join(lines))
        self.assertEqual(len(lines), 4)


if __name__ == "__main__":
    unittest.main()
