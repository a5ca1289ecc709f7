"""Each example of the gallery, run as a user runs it in its folder: what it finds, and that it draws."""
import contextlib
import io
import os
import runpy
import unittest
import warnings

import numpy

from package import ROOT

GALLERY = ROOT / "examples" / "gallery"
os.environ["MPLBACKEND"] = "agg"

# What is found with each example: of its variables, the least and the largest value; and the number of figures.
FOUND = {
    "plot_01_frame": (lambda of: of["simulator"].bounds.crb_px / of["displacement"], 0.5, 2, 2),
    "plot_02_network": (lambda of: numpy.std(of["latents"] - of["displacements"]) / of["simulator"].bounds.crb_px, 0.9, 1.1, 1),
    "plot_03_period": (lambda of: of["peak"].period, 520, 540, 2),
    "plot_04_stream": (lambda of: of["peak"].period, 16.8, 17.2, 1),
    "plot_05_moving": (lambda of: of["peak"].period, 16.9, 17.1, 1),
    "plot_06_sky": (lambda of: 1e6 * of["reduced"].y.mean(), 2.49, 2.51, 1),
    "plot_07_calibration": (lambda of: of["calibration"].values()["focus"].value, 4.9, 5.1, 1),
    "plot_08_track": (lambda of: of["peak"].period if len(of["table"]) == 100 else 0, 16.9, 17.1, 2),
    "plot_09_planets": (lambda of: of["planet"].period[1], 195, 205, 4),
    "plot_10_budget": (lambda of: of["budget"].summary.crb_px / of["simulator"].bounds.crb_flux_shift_px, 0.999, 1.001, 1),
}


class Examples(unittest.TestCase):
    def test_each_finds_what_it_says(self):
        try:
            import matplotlib.pyplot as plt
            import astropy.table  # noqa: F401
        except ImportError as error:
            self.skipTest(str(error))
        self.assertEqual(sorted(path.stem for path in GALLERY.glob("*.py")), sorted(FOUND))
        for name, (value, least, most, figures) in FOUND.items():
            with self.subTest(name), contextlib.chdir(GALLERY), warnings.catch_warnings():
                warnings.simplefilter("error", RuntimeWarning)
                plt.close("all")
                with contextlib.redirect_stdout(io.StringIO()):
                    found = runpy.run_path(f"{name}.py")
                self.assertTrue(least <= value(found) <= most, value(found))
                self.assertEqual(len(plt.get_fignums()), figures)


if __name__ == "__main__":
    unittest.main()
