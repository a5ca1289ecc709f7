"""toliman status: the trends of what each frame was fitted with, against a line fitted by numpy."""
import json
import logging
import unittest

import numpy
from observed import DAY, toliman
from program import ProgramTest

FRAMES, YEARS, NAMES = 200, 2.0, ("x_px", "y_px", "flux_a", "focus", "zernike_5")
SLOPE = {"x_px": 0.0, "y_px": 0.3, "flux_a": -0.02, "focus": 0.0, "zernike_5": 1.0}
SCATTER = {"x_px": 0.3, "y_px": 0.3, "flux_a": 1e-3, "focus": 0.0, "zernike_5": 0.1}


def setUpModule():
    logging.getLogger("toliman").setLevel(logging.ERROR)


class StatusTrends(ProgramTest):
    def setUp(self):
        super().setUp()
        random = numpy.random.default_rng(3)
        self.years = numpy.sort(random.uniform(0, YEARS, FRAMES))
        self.values = {name: 0.5 + SLOPE[name] * self.years + SCATTER[name] * random.normal(size=FRAMES) for name in NAMES}
        self.values["x_px"][[5, 17]] = 40  # another star
        self.values["y_px"][7] = numpy.nan

    def track(self, frames):
        """The value of a frame is 0; its other values are those of its number, which is its pixel."""
        def estimate(image):
            number = int(image[0, 0])
            further = [self.values[name][number] for name in NAMES]
            return toliman.Estimate(float(number % 2), further=further)
        with toliman.Tracker(estimate, 1e-3, 1e-3, 10, folder=self.folder / "s", estimator_id=1, sigma=1.0, rows=8, cols=8,
                             image_shape=(8, 8), values=NAMES, sync="none", value_limit=1e3, allow_zero_runs=True) as tracker:
            for number in frames:
                pixels = numpy.full((8, 8), number, numpy.uint16)
                self.assertEqual(tracker.push(toliman.Frame(pixels, frame_id=int(number), camera_ns=int(
                    self.years[number] * 365.25 * DAY))).verdict, "accepted")
            tracker.save()

    def trends(self):
        return {one["name"]: one for one in json.loads(self.succeed("status", "s", "--json"))["trends"]}

    def test_lines_are_those_of_numpy(self):
        self.track(numpy.random.default_rng(4).permutation(FRAMES))  # in any order of arrival
        found = self.trends()
        self.assertEqual(set(found), {"x_px", "y_px", "flux_a", "zernike_5"})  # focus is constant
        for name, one in found.items():
            y = self.values[name]
            rms = 1.4826 * numpy.nanmedian(abs(y - numpy.nanmedian(y)))
            used = abs(y - numpy.nanmedian(y)) <= 6 * rms
            (slope, _), covariance = numpy.polyfit(self.years[used], y[used], 1, cov=True)
            self.assertAlmostEqual(one["per_year"], slope, delta=1e-9 * abs(slope))
            self.assertAlmostEqual(one["sigma_per_year"], covariance[0, 0] ** 0.5, delta=1e-6 * covariance[0, 0] ** 0.5)
            self.assertAlmostEqual(one["rms"], rms, delta=0.02 * rms)
            self.assertEqual(used.sum(), FRAMES - {"x_px": 2, "y_px": 1}.get(name, 0))
        # 5 sigmas of y_px do not matter: less than the scatter of a frame
        self.assertGreater(abs(found["y_px"]["per_year"]), 5 * found["y_px"]["sigma_per_year"])
        self.assertEqual({name for name, one in found.items() if one["significant"]}, {"flux_a", "zernike_5"})
        self.assertEqual({name: one["unit"] for name, one in found.items()},
                         {"x_px": "px", "y_px": "px", "flux_a": "", "zernike_5": "nm"})
        lines = [line.split() for line in self.succeed("status", "s").splitlines() if "per year" in line]
        self.assertEqual([(line[0], line[-1]) for line in lines], [("x_px", "year"), ("y_px", "year"), ("flux_a", "drifts"),
                                                                   ("zernike_5", "drifts")])

    def test_few_frames_have_no_trend(self):
        self.track(range(19))
        self.assertEqual(self.trends(), {})
        self.years = self.years[19:] / 50  # of a fortnight
        self.values = {name: values[19:] for name, values in self.values.items()}
        self.folder = self.folder / "short"
        self.folder.mkdir()
        self.track(range(60))
        self.assertEqual(self.trends(), {})


if __name__ == "__main__":
    unittest.main()
