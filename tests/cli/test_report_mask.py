"""toliman report of a designed mask: tables and figures with the numbers of pupil.json and of the scene, and damaged files."""
import json
import math
import os
import signal
import unittest
import unittest.mock

import numpy
from pages import Reader, Recorder, ReportTest, lines
from test_pupil import FLUX, tiny_scene
import toliman
from toliman._progress import Watch
from toliman.report import mask_information, style
from toliman.report.text import exponential

FREE = ["flux_a", "flux_b", "shift_x", "shift_y", "roll", "scale", "focus", "background"]
FIGURES = ["mask", "mask-information", "mask-descent"]
MASK = {"kind": "file", "file": "mask.npy", "quantity": "binary", "opd_nm": 288}


def scores(factor):
    return {"crb_alone_px": 2e-6 * factor, "crb_flux_shift_px": 3e-6 * factor, "crb_px": 4e-6 * factor,
            "peak_to_mean": 40 + factor, "light_in_frame": 0.9125, "gradient_energy": 12.34 / factor, "radius_50_px": 10.25,
            "radius_80_px": 20.5}


def place(**where):
    return {"date": None, "position_angle_deg": None, "quantum_px": 1.25e-6, "quantum_flux_shift_px": 1.5e-6,
            "scene_mask": scores(1), "designed": scores(0.8), **where}


class Mask(ReportTest):
    def setUp(self):
        super().setUp()
        self.result = {"schema": "toliman-pupil/1", "version": "0.2.0", "scene": "tiny<1>", "seed": 18446744073709551615,
                       "free": FREE, "improved": True, "stopped": False, "iterations": 3, "small_features": 0.0123,
                       "places": [place()], "mask": MASK, "descent_px": [5e-6, 4e-6, 3e-6]}
        self.scene = tiny_scene()
        self.scene["telescope"]["mask"] = MASK
        y, x = numpy.indices((64, 64)) - 31.5
        self.cells = (numpy.cos(0.09 * x * y / 8 + 0.9 * y) + numpy.cos(0.7 * x) > 0).astype(numpy.uint8)
        (self.folder / "m").mkdir()
        (self.folder / "m" / "flux.csv").write_text(FLUX)
        numpy.save(self.folder / "m" / "mask.npy", self.cells)
        self.write()

    def write(self):
        (self.folder / "m" / "pupil.json").write_text(json.dumps(self.result))
        (self.folder / "m" / "scene.json").write_text(json.dumps(self.scene))

    def text(self):
        return Reader(Recorder(self.folder / "m").html()).text

    def test_page(self):
        page = self.report("m")
        self.check_page(self.folder / "m" / "report", FIGURES)
        for words in ("tiny<1>", "4.00 × 10⁻⁶ px", "3.20 × 10⁻⁶ px", "factor of 1.56", "Seed 18446744073709551615, 3 iterations",
                      "1.23 %", "288 nm"):
            self.assertIn(words, page.text)
        for name, cells in (("none", ["2.00 × 10⁻⁶", "1.60 × 10⁻⁶", "1.56", "1.25 × 10⁻⁶"]),
                            ("fluxes, shift", ["3.00 × 10⁻⁶", "2.40 × 10⁻⁶", "1.56", "1.50 × 10⁻⁶"]),
                            ("all of the design", ["4.00 × 10⁻⁶", "3.20 × 10⁻⁶", "1.56", "–"]),
                            ("peak-to-mean ratio", ["41.0", "40.8"]), ("light in the frame", ["91.2 %", "91.2 %"]),
                            ("gradient energy, px⁻²", ["12.3", "15.4"]),
                            ("radius with 50 % of the light, px", ["10.2", "10.2"]),
                            ("radius with 80 % of the light, px", ["20.5", "20.5"])):
            self.assertEqual(page.row(name, len(cells)), cells)
        with toliman.Simulator(self.folder / "m" / "scene.json") as simulator:
            self.assertIn(f"{exponential(simulator.bounds.crb_marginal_px)} px", page.text)

    def test_places(self):
        infinite = {**scores(1), "crb_px": None}
        self.result["places"] = [place(date=2027.25, scene_mask=infinite), place(date=2030, quantum_flux_shift_px=None)]
        self.write()
        page = Reader(Recorder(self.folder / "m").html())
        self.assertRegex(page.text, r"date 2027.25: ∞ px .* 3.20 × 10⁻⁶ px")
        self.assertEqual(page.row("all of the design", 5), ["date 2027.25", "∞", "3.20 × 10⁻⁶", "∞", "–"])
        at = page.cells.index("date 2030", page.cells.index("fluxes, shift"))
        self.assertEqual(page.cells[at + 1 : at + 5], ["3.00 × 10⁻⁶", "2.40 × 10⁻⁶", "1.56", "–"])
        self.result["places"] = [place(position_angle_deg=12.5)]
        self.write()
        self.assertIn("position angle 12.5°: 4.00", self.text())
        self.assertFalse("not better" in self.text() or "stopped" in self.text())
        self.result.update(improved=False, stopped=True)
        self.write()
        self.assertTrue("not better" in self.text() and "stopped" in self.text())

    def test_information(self):
        """Bounds against those of the library, and costs against the inverse of the Fisher matrix."""
        with toliman.Simulator(self.folder / "m" / "scene.json") as simulator:
            bounds, variance = simulator.bounds, simulator.image("variance")
            signal = simulator.image("separation")
            images = {name: simulator.image(name) for name in FREE if not name.startswith("flux")}
            images.update(flux_a=simulator.image("star_a"), flux_b=simulator.image("star_b"))
        found, reason = mask_information.simulate(self.folder / "m" / "scene.json", FREE)
        self.assertEqual(reason, "")
        information = found.information
        self.assertEqual(information.share.shape, (64, 64))
        self.assertAlmostEqual(information.share.sum(), 1, delta=1e-12)
        self.assertTrue((information.share >= 0).all())
        self.assertAlmostEqual(information.bound_px / bounds.crb_marginal_px, 1, delta=1e-6)
        derivatives = [signal, *images.values()]
        fisher = numpy.array([[(a * b / variance).sum() for a in derivatives] for b in derivatives])
        scale = numpy.sqrt(numpy.diag(fisher))
        fisher /= scale * scale[:, None]
        inverse = numpy.linalg.inv(fisher)
        for number, name in enumerate(images, 1):
            known = numpy.delete(numpy.delete(fisher, number, 0), number, 1)
            cost = math.sqrt(inverse[0, 0] / numpy.linalg.inv(known)[0, 0])
            self.assertAlmostEqual(information.bound_px / information.known_px[name] / cost, 1, delta=1e-6)
        # The efficient score is orthogonal to the nuisances: weights of the inverse give the same image.
        score = sum(weight / s * image for weight, s, image in zip(inverse[0], scale, derivatives))
        share = score**2 / variance
        numpy.testing.assert_allclose(information.share, share / share.sum(), atol=1e-6 * information.share.max())
        for free, bound in (((), bounds.crb_px), (FREE[:4], bounds.crb_flux_shift_px)):
            found, _ = mask_information.simulate(self.folder / "m" / "scene.json", free)
            self.assertAlmostEqual(found.information.bound_px / bound, 1, delta=1e-6)

    def test_no_information(self):
        image = numpy.ones((2, 2))
        for nuisances in ({"a": image}, {"a": 2 * image, "b": image, "c": 0 * image}):
            found = mask_information.information_of(3 * image, nuisances, image)
            self.assertEqual(found.bound_px, math.inf)
        found = mask_information.information_of(image * [[1], [2]], {"a": image, "b": 3 * image}, image)
        self.assertAlmostEqual(found.bound_px, 1, delta=1e-12)  # rows of -0.5 and 0.5 remain
        numpy.testing.assert_allclose(found.share, 0.25, rtol=1e-12)
        self.assertAlmostEqual(found.known_px["a"], 1, delta=1e-12)  # b has the effect of a

    def test_signal(self):
        """A signal during the simulation ends the report."""
        class Stopped(Exception):
            pass

        def stop(*_):
            raise Stopped

        def interrupted(*arguments, call=Watch._call):
            signal.raise_signal(signal.SIGTERM)
            return call(*arguments)

        self.addCleanup(signal.signal, signal.SIGTERM, signal.signal(signal.SIGTERM, stop))
        with unittest.mock.patch.object(Watch, "_call", interrupted), self.assertRaises(Stopped):
            mask_information.simulate(self.folder / "m" / "scene.json", FREE)

    def test_figures(self):
        found = Recorder(self.folder / "m")
        self.assertEqual(list(found.figures), FIGURES)
        kinds = numpy.asarray(found.figures["mask"].axes[0].images[0].get_array())
        self.assertEqual(set(kinds.ravel()), {0, 1, 2})
        numpy.testing.assert_array_equal(kinds[kinds > 0], self.cells[kinds > 0] + 1)
        self.assertEqual(kinds[0, 0], 0)  # outside the aperture
        frame, share = found.figures["mask-information"].axes[:2]
        with toliman.Simulator(self.folder / "m" / "scene.json") as simulator:
            numpy.testing.assert_array_equal(frame.images[0].get_array(), simulator.image("both"))
            stars = simulator.offsets()
        numpy.testing.assert_array_equal([numpy.ravel(line.get_data()) for line in share.get_lines()], stars)
        self.assertAlmostEqual(share.images[0].get_array().sum(), 1, delta=1e-12)
        (line,) = lines(found.figures["mask-descent"].axes[0]).values()
        numpy.testing.assert_allclose(line, [[1, 2, 3], [5, 4, 3]])
        self.result.update(descent_px=[None, 2e-6], free=[])
        self.write()
        found = Recorder(self.folder / "m")
        self.assertIn(b"</svg>", style.drawn(found.figures["mask-descent"], "svg"))
        self.assertNotIn("Cost of each free parameter", Reader(found.html()).text)

    def test_without_library_or_file(self):
        done = self.run_program("report", "m", env={**os.environ, "TOLIMAN_LIBRARY": "none.so"})
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        page = self.check_page(self.folder / "m" / "report", ["mask", "mask-descent"])
        self.assertIn("No figure of the frame, no map of the information and no costs of the parameters: libtoliman cannot be "
                      "loaded.", page.text)
        self.assertIn("none.so", page.text)
        (self.folder / "m" / "flux.csv").unlink()
        self.assertRegex(self.text(), "no costs of the parameters: .*flux.csv")

    def test_damaged_files(self):
        for change, words in (({"places": []}, "places = []: "), ({"free": "roll"}, 'free = "roll": '),
                              ({"places": [place(designed={})]}, "places[0].designed.crb_px: "),
                              ({"places": [place(designed={**scores(1), "crb_px": -1})]}, "places[0].designed.crb_px = -1: "),
                              ({"descent_px": [1, 0]}, "descent_px = [1, 0]: "), ({"improved": 1}, "improved = 1: "),
                              ({"schema": "x"}, 'schema = "x": ')):
            kept = dict(self.result)
            self.result.update(change)
            self.write()
            self.fail_with(f"pupil.json: {words}", "m")
            self.result = kept
        self.write()
        mask = self.folder / "m" / "mask.npy"
        mask.write_bytes(mask.read_bytes()[:-100])
        self.fail_with("mask.npy: ", "m")
        for cells, words in ((self.cells[:60], "60 x 64 cells"), (self.cells[0], ""), (3 * self.cells, "")):
            numpy.save(mask, cells)
            self.fail_with(f"mask.npy: {words}" if not words else words, "m")
        mask.unlink()
        self.fail_with("mask.npy: ", "m")
        for name in ("scene.json", "pupil.json"):
            (self.folder / "m" / name).write_text("{")
            self.fail_with(f"{name}: ", "m")
        (self.folder / "m" / "pupil.json").unlink()
        self.fail_with("pupil.json", "m")


if __name__ == "__main__":
    unittest.main()
