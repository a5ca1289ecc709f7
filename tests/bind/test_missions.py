"""Simulated missions, from the measured separations to the period of a planet: the short form of mission_campaign.py."""
import logging
import unittest

import package  # noqa: F401, which finds the studies
import mission_campaign as campaign


class Missions(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        logging.getLogger("toliman").setLevel(logging.ERROR)
        cls.rows = campaign.fly(missions=1, seed=1)

    def test_the_planet_is_found_and_no_other(self):
        self.assertEqual(campaign.misses(self.rows, missions=1), [])

    def test_the_mean_alone_raises_alarms(self):
        self.assertEqual(self.rows["mean"]["none"], 1)

    def test_errors_are_near_the_bound(self):
        row = self.rows[campaign.ORBIT]
        self.assertLess(row["errors"][0], 3 * row["bounds"][0])

    def test_figures_that_are_missed_are_named(self):
        row = {"circular": 89, "eccentric": 90, "none": 2}
        self.assertEqual(campaign.misses({campaign.ORBIT: row}, missions=100),
                         ["circular: 89 of 100 found: must be at least 90 %", "2 of 100 alarms without planet: must be at most 1 %"])

    def test_median_error(self):
        self.assertAlmostEqual(campaign.median_error([2, 2]), 2 * 0.67449, places=4)


if __name__ == "__main__":
    unittest.main()
