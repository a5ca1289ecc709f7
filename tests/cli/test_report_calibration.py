"""toliman report of calibrations: figures with the numbers of the result, and damaged files."""
import json
import unittest

import numpy
import schemas
from pages import Reader, Recorder, ReportTest, lines
from toliman.report import style

FIGURES = ["calibration-residuals", "calibration-whiteness", "calibration-maps", "calibration-aberrations",
           "calibration-correlations", "calibration-separations", "calibration-steps"]


def parameter(name, unit, value, sigma, **flags):
    return {"name": name, "unit": unit, "value": value, "sigma": sigma, "prior_sigma": 100, "held": False, "no_sign": False, **flags}


def window(first_days, shift=0.0):
    return {"first_days": first_days, "frames": 2, "chi_square": 1.01, "chi_square_sigma": 0.01, "largest_residual": 4.5,
            "goodness": "good", "scene": "fitted.json",
            "parameters": [parameter("scale", "", 1e-3 + shift, 1e-5), parameter("focus", "nm", -3.25, 0.02, no_sign=True),
                           parameter("zernike_7", "nm", 4.5 + shift, 0.01, held=True)],
            "covariance": [[1e-10, 1e-7, 0], [1e-7, 4e-4, -1e-4], [0, -1e-4, 1e-4]]}


class Calibration(ReportTest):
    def setUp(self):
        super().setUp()
        frame = {"file": "f.fits", "position_angle_deg": 1, "x_px": 0, "y_px": 0, "flux_a": 0, "flux_b": 0, "background": 1,
                 "chi_square": 1, "excluded": 0, "separation_px": 20, "separation_sigma_px": 2e-5}
        step = {"change": None, "accepted": True, "response": False, "largest_step": 2}
        self.result = {
            "schema": "toliman-calibration-result/1", "version": "0.2.0",
            "provenance": {"command": "toliman calibrate", "date": "d", "processor": "p"}, "scene": "sky<1>.json",
            "out": "fitted.json", "verdict": ["converged; the model is complete", "known mostly by the prior: zernike_7"],
            "complete": True, "held": True, "no_sign": True, "frames": 2, "rows": 6, "cols": 8, "cells": 5, "iterations": 2,
            "map_iterations": 1, "chi_square": 1.0123, "chi_square_sigma": 0.0091, "structure": 6, "structure_limit": 50,
            "largest_residual": 5.1, "goodness": "good", "map_parameters": 9, "response_iterations": 1, "response_pixels": 9,
            "response_rms": 5e-3, "response_parameters": 7, "pupil_error": 1e-3, "peak_noise": 1e-4, "lacks": [],
            "changes": ["map"], "attempts": [], "left_out": [], "separation_sigma_px": 6.1e-6, "calibration_sigma_px": 1.2e-7, "map_rms_nm": 0.98, "windows": [window(0)],
            "separations": [{**frame, "frame": k, "time_days": 10 * k, "displacement_px": 1e-5 * k} for k in range(2)],
            "steps": [{**step, "map": False, "iteration": 1, "chi_square": 100}, {**step, "map": False, "iteration": 2, "chi_square": 3},
                      {**step, "map": False, "iteration": 3, "chi_square": 9, "accepted": False},
                      {**step, "map": True, "iteration": 4, "chi_square": 1.0123}]}
        schemas.check(json.dumps(self.result, indent=1))
        (self.folder / "c").mkdir()
        random = numpy.random.default_rng(1)
        self.images = {name: random.normal(size=(6, 8)) for name in ("residual_before", "residual_after", "chi_map")}
        self.opd = 1e-9 * numpy.arange(25).reshape(1, 5, 5)
        for name, values in (*self.images.items(), ("opd_change", self.opd)):
            numpy.save(self.folder / "c" / f"fitted.{name}.npy", values)
        self.write()

    def write(self):
        (self.folder / "c" / "fitted.calibration.json").write_text(json.dumps(self.result))

    def test_page(self):
        page = self.report("c")
        self.check_page(self.folder / "c" / "report", FIGURES)
        for words in ("sky<1>.json: fitted.json", "converged; the model is complete; known mostly by the prior: zernike_7",
                      "1.0123 ± 0.0091", "σ = 6.10 × 10⁻⁶ px", "1.20 × 10⁻⁷ px", "0.98 nm"):
            self.assertIn(words, page.text)
        self.assertEqual(page.row("focus", 4), ["−3.250 ± 0.020", "nm", "100", "sign unknown"])
        self.assertEqual(page.row("zernike_7", 4), ["4.500 ± 0.010", "nm", "100", "known by the prior"])

    def test_figures(self):
        found = Recorder(self.folder / "c").figures
        before, after = found["calibration-residuals"].axes[:2]
        numpy.testing.assert_array_equal(before.images[0].get_array(), self.images["residual_before"])
        numpy.testing.assert_array_equal(after.images[0].get_array(), self.images["residual_after"])
        opd = found["calibration-maps"].axes[1].images[0].get_array().filled(0)
        numpy.testing.assert_allclose(opd, 1e9 * self.opd[0], rtol=1e-12)
        bars = found["calibration-aberrations"].axes[0].patches
        self.assertEqual([bar.get_height() for bar in bars], [-3.25, 4.5])
        matrix = numpy.asarray(found["calibration-correlations"].axes[0].images[0].get_array())
        numpy.testing.assert_allclose(matrix, [[1, 0.5, 0], [0.5, 1, -0.5], [0, -0.5, 1]], atol=1e-12)
        steps = lines(found["calibration-steps"].axes[0])
        numpy.testing.assert_array_equal(steps["parameters"], [[1, 2], [100, 3]])
        numpy.testing.assert_array_equal(steps["map"], [[4], [1.0123]])

    def test_windows(self):
        self.result["windows"] = [window(0), window(30, 2e-5), window(60, -1e-5)]
        self.write()
        found = Recorder(self.folder / "c")
        self.assertEqual(list(found.figures), [*FIGURES[:4], "calibration-windows", *FIGURES[4:]])
        self.assertIn("Parameters of the first window", Reader(found.html()).text)
        figure = found.figures["calibration-windows"]
        self.assertIn(b"</svg>", style.drawn(figure, "svg"))
        axes = figure.axes
        self.assertEqual([axis.get_ylabel() for axis in axes], ["change (no unit)", "change, nm"])
        numpy.testing.assert_allclose(lines(axes[0])["scale"], [[0, 30, 60], [0, 2e-5, -1e-5]], atol=1e-15)

    def test_damaged_files(self):
        (self.folder / "c" / "fitted.chi_map.npy").unlink()
        self.fail_with("fitted.chi_map.npy: ", "c")
        numpy.save(self.folder / "c" / "fitted.chi_map.npy", numpy.ones((4, 4)))
        self.fail_with("rows = 6, cols = 8: ", "c")
        numpy.save(self.folder / "c" / "fitted.chi_map.npy", self.images["chi_map"])
        for windows, text in (([{**window(0), "covariance": [[1, 0]]}], "windows[0].covariance = [[1, 0]]: "),
                              ([{**window(0), "parameters": 3}], "windows[0].parameters = 3: "), ([], "windows = []: ")):
            self.result["windows"] = windows
            self.write()
            self.fail_with(text, "c")


if __name__ == "__main__":
    unittest.main()
