"""toliman report STATE: one page with the story of a folder in order, also with the planets of a folder with a system."""
import json
import re
import unittest

import test_refit_sums
import test_status_trends


def figures_of(page):
    return re.findall(r'<figure id="([A-Za-z0-9-]+)">', page)


class Trends(test_status_trends.StatusTrends):
    """The cases of StatusTrends run in their own file."""

    test_lines_are_those_of_numpy = test_few_frames_have_no_trend = None

    def test_instrument(self):
        self.track(range(test_status_trends.FRAMES))
        self.succeed("report", "s")
        page = (self.folder / "s" / "report" / "report.html").read_text()
        self.assertEqual(figures_of(page)[:2], ["instrument", "series"])
        self.assertEqual(len(re.findall("<td>drifts</td>", page)), 2)
        lines = (self.folder / "s" / "report" / "frames.csv").read_text().splitlines()
        names = next(line for line in lines if not line.startswith("#")).split(",")
        rows = [line.split(",") for line in lines if line[0].isdigit()]
        self.assertEqual((names, len(rows)), (["t", "chi_square", "x_px", "y_px", "flux_a", "focus", "zernike_5"], test_status_trends.FRAMES))
        for row, years, focus in zip(rows, self.years, self.values["flux_a"]):
            self.assertAlmostEqual(float(row[0]), years * 365.25, delta=1e-6)
            self.assertEqual(float(row[names.index("flux_a")]), focus)


class Planets(test_refit_sums.RefitSums):
    test_elements_are_those_of_python_and_of_the_stars = test_a_series_with_windows = None
    test_frames_of_a_refit_are_not_searched = test_series_of_a_refit = None

    def test_planets(self):
        self.make(0)
        self.succeed("report", "s")
        report = self.folder / "s" / "report"
        page = (report / "report.html").read_text()
        names = figures_of(page)
        self.assertEqual(len(names), len(set(names)))
        self.assertLess(names.index("series"), names.index("2-limits"))
        found = json.loads((report / "planets" / "result.json").read_text())
        self.assertEqual(found["schema"], "toliman-planet/1")
        # an orbit of a refit: the page has no planets, and says why
        self.succeed("refit", "alpha-cen", "s", *test_refit_sums.LOW, "--out", "refit.json")
        self.run_program("rebuild", "s", *test_refit_sums.LOW, "--system", "refit.json")
        done = self.run_program("report", "s")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("refit", done.stderr)
        self.assertNotIn("2-limits", figures_of((report / "report.html").read_text()))


if __name__ == "__main__":
    unittest.main()
