"""Verdicts of planets on simulated series: the short form of doubt_campaign.py."""
import unittest

from study import Serial, run
import doubt_campaign as campaign
import doubt_frames


class Campaign(unittest.TestCase):
    # promise: wrong-models-make-no-planet
    def test_mistakes(self):
        self.assertEqual(run(campaign.all_mistakes, 1, 2)[0], [])

    # promises: one-reason-forbids-a-planet, wrong-models-make-no-planet
    def test_frames(self):
        wrong, lines = run(doubt_frames.effects, Serial, 1, 12, 64, ("none", "edges by cells"))
        self.assertEqual((wrong, len(lines)), ([], 4))

    # promise: wrong-models-make-no-planet
    def test_noise_is_called_poor(self):
        for factor, word in (1, "good"), (1.5, "poor"), (0.5, "too good"):
            self.assertEqual(campaign.of_noise((factor, 150, 0)), (0, word))

    def test_missions(self):
        found, error, _, reasons, ratios = campaign.of_mission((campaign.MISSIONS[-1], 1))
        self.assertTrue(found and error < 4 and abs(max(ratios) - 1) < 0.05, reasons)


if __name__ == "__main__":
    unittest.main()
