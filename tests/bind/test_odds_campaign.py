"""Odds and errors of planets on simulated series: the short form of odds_campaign.py."""
import math
import unittest
import unittest.mock

from study import Serial, run
import odds_campaign as campaign


class Campaign(unittest.TestCase):
    def test_modes(self):
        made = {"noise_of": lambda task: (-0.3, 0), "pull_of": lambda task: [0.5, 0.4, 0.6], "star_of": lambda task: [1, 0, 1]}
        with unittest.mock.patch.multiple(campaign, **made):
            for mode in campaign.noise, campaign.pulls, campaign.star:
                wrong, lines = run(mode, Serial, 1, 1)
                self.assertEqual((wrong, len(lines)), ([], 3))

    def test_ridge_of_an_eccentric_orbit(self):
        """A strong signal of short passages, whose peak leaves the cells that were divided first: it came out at 14 sigma."""
        for name, rank in zip(("period", "eccentricity", "amplitude"), campaign.pull_of((10**6 + 66,))):
            with self.subTest(name=name):
                self.assertLess(abs(campaign.deviate(rank)), 3)

    def test_noise_of_instruments_of_which_one_is_quiet(self):
        """The log10 odds were -3: the least scale of amplitudes was that of the noisy instruments."""
        odds, planets = campaign.noise_of((10**6 + 3,), 150)
        self.assertGreater(odds, -1.5)
        self.assertEqual(planets, 0)

    def test_star_of_a_mission(self):
        mission = campaign.Mission(7, count=(50, 40))
        self.assertGreater(mission.search().candidates[0].log10_star * (1 - 2 * mission.star), 0)

    def test_deviates(self):
        for share, expected in ((0.5, 0), (0.8413447, 1), (0.0227501, -2)):
            self.assertAlmostEqual(campaign.deviate(share), expected, delta=1e-6)

    def test_orbits_of_all_directions(self):
        mission = campaign.Mission(7)
        self.assertAlmostEqual(float(mission.p @ mission.q), 0, delta=1e-12)
        self.assertTrue(0 <= mission.theory(campaign.numpy.random.default_rng(1)) <= 1)
        t = campaign.numpy.array([33.0])
        x, y = (campaign.model.places(mission.mean(t + h), mission.e) for h in (-1e-4, 1e-4))
        speed = [(b - a) / 2e-4 * campaign.MOTION for a, b in zip(x, y)]
        for found, expected in zip(mission.motion(t), speed):
            self.assertTrue(math.isclose(found[0], expected[0], rel_tol=1e-5))


if __name__ == "__main__":
    unittest.main()
