"""The chapter's figures: what they plot, against the files of a run, formats.md and plain arithmetic."""
import json
import math
import pathlib
import re
import shutil
import sys
import tempfile
import unittest

import numpy
from program import ROOT
from shared_run import rows_of, shared_run

sys.path.append(str(ROOT / "build" / "python"))
from toliman.report import chapter, results, run_chapter, run_images, run_simulation  # noqa: E402

NAMES = ["signal-and-atom", "bandwidths", "reconstructions", "displacement", "architecture", "pooling", "activations"]


class Pages:
    """Keeps what is added to a page."""

    def __init__(self):
        self.figures, self.captions = {}, {}

    def add(self, kind, text):
        self.last = kind, text

    def add_figure(self, name, figure, caption):
        self.figures[name], self.captions[name] = figure, caption


def setUpModule():
    global FOLDER, PICTURES, PAGE
    FOLDER = shared_run()
    PICTURES, _ = run_simulation.simulate(FOLDER, results.load(FOLDER / "result.json", "toliman-run/2"))
    PAGE = page_of(FOLDER, PICTURES)


def page_of(folder, pictures):
    page = Pages()
    images = run_images.Images(results.load(folder / "result.json", "toliman-run/2"), pictures)
    run_chapter.add(folder, images, page)
    return page


def pictures(name):
    """Axes with an image, and their images."""
    axes = [axis for axis in PAGE.figures[name].axes if axis.images]
    return axes, [numpy.asarray(axis.images[0].get_array()) for axis in axes]


class Figures(unittest.TestCase):
    def setUp(self):
        self.result = json.loads((FOLDER / "result.json").read_text())

    def stored(self, name):
        return PICTURES.images[name].values

    def test_each_is_on_the_page(self):
        self.assertEqual(list(PAGE.figures), NAMES)
        for caption in PAGE.captions.values():
            self.assertRegex(caption, r"^[A-Z0-9].*\.$")

    def test_signal_and_atom(self):
        series, table = rows_of(FOLDER / "series.csv"), rows_of(FOLDER / "periodogram.csv")
        signal, atom, of_signal, of_atom = PAGE.figures["signal-and-atom"].axes
        for axis, line, name in ((signal, 0, "true"), (atom, 0, "latent")):
            values = axis.lines[line].get_ydata()
            numpy.testing.assert_allclose(axis.lines[line].get_xdata(), series["t"])
            numpy.testing.assert_allclose([values.mean(), values.std()], [0, 1], atol=1e-9)
            self.assertAlmostEqual(numpy.corrcoef(values, series[name])[0, 1], 1, delta=1e-12)
        true, latent = (series[name] - series[name].mean() for name in ("true", "latent"))
        numpy.testing.assert_allclose(atom.lines[1].get_ydata(), true / latent.std())
        for axis, name, stated in ((of_signal, "true", self.result["true_series"]), (of_atom, "power", self.result)):
            numpy.testing.assert_allclose(axis.lines[0].get_data(), (table["frequency"], table[name]))
            (low, high), half = axis.lines[1].get_xdata(), axis.lines[1].get_ydata()
            numpy.testing.assert_allclose(half, 2 * [table[name].max() / 2])
            width = (high - low) * stated["period_days"] ** 2
            self.assertAlmostEqual(width / stated["fwhm_period_days"], 1, delta=0.05)
            width = float(re.match(r"FWHM ([\d.]+) days, half of it ", axis.lines[1].get_label())[1])
            self.assertAlmostEqual(width / stated["fwhm_period_days"], 1, delta=0.01)

    def test_a_peak_at_the_edge_has_no_width(self):
        half, low, high = chapter.half_maximum(numpy.arange(1.0, 6), numpy.array([1.0, 0.8, 0.2, 0.1, 0.1]))
        self.assertEqual(half, 0.5)
        self.assertTrue(math.isnan(low))
        self.assertAlmostEqual(high, 2.5)

    def test_bandwidths(self):
        axes, images = pictures("bandwidths")
        self.assertEqual([axis.get_title() for axis in axes], ["600 nm", "550–600 nm", "500–700 nm"])
        for name, image in zip(run_simulation.BANDS, images):
            numpy.testing.assert_array_equal(image, self.stored(name))

    def test_reconstructions(self):
        axes, images = pictures("reconstructions")
        middle = (slice(None), slice(64, 192), slice(64, 192))
        wanted = [image for name in ("frames", "reconstructions", "residuals") for image in self.stored(name)[middle]]
        self.assertEqual(len(images), 15)
        for image, want in zip(images, wanted):
            numpy.testing.assert_array_equal(image, want)
        self.assertEqual([axis.get_title() for axis in axes[:5]], [f"frame {k}" for k in PICTURES.samples])
        listed, scale = PICTURES.images["frames"], self.result["geometry"]["pixel_scale_arcsec"]
        left, _, bottom, top = axes[0].images[0].get_extent()
        self.assertAlmostEqual(left, (listed.first_x + 64 - 0.5) * scale)
        self.assertAlmostEqual(bottom, (listed.first_y + 64 - 0.5) * scale)
        self.assertAlmostEqual(top - bottom, 128 * scale)
        rms = numpy.sqrt(numpy.mean(self.stored("residuals") ** 2))
        self.assertIn(f"{rms:.3f}", PAGE.captions["reconstructions"])

    def test_displacement(self):
        table = PICTURES.displacement
        lines = PAGE.figures["displacement"].axes[0].lines
        for name, line in zip(("linear", "cubic", "linear_change", "cubic_change", "taylor"), lines):
            numpy.testing.assert_allclose(line.get_data(), (table["displacement_px"], table[name]))
            self.assertIn(name.partition("_")[0], line.get_label().lower())
            self.assertEqual("change" in name, "change" in line.get_label())

    def test_no_signal_no_noise_of_photons_and_no_displacements(self):
        with tempfile.TemporaryDirectory() as top:
            copy = pathlib.Path(top) / "r"
            shutil.copytree(FOLDER, copy)
            (copy / "result.json").write_text(json.dumps({**self.result, "true_series": None, "efficiency": None}))
            page = page_of(copy, PICTURES._replace(displacement={}))
        self.assertEqual(list(page.figures), [name for name in NAMES[1:] if name != "displacement"])
        self.assertNotIn("noise alone", page.captions["reconstructions"])


class Network(unittest.TestCase):
    def test_layers_are_those_of_the_format(self):
        text = (ROOT / "tools/docs/formats.md").read_text()
        shapes = dict(re.findall(r"\| (\w+\.(?:weight|bias)) \| ([\dD ]+?) (?=\|)", text))
        for layout, side in (("flight", 256), ("paper", 256), ("core", 128)):
            deep = {name: " ".join(str(side // 16) if size == "D" else size for size in shape.split()) for name, shape in shapes.items()}
            self.assertEqual({name: " ".join(map(str, shape)) for name, shape in chapter.tensors(layout).items()}, deep)
            layers = chapter.layers(layout)
            self.assertIn(f"{sum(layer.parameters for layer in layers):,}", text)
            sides = [side >> k for k in range(5)]
            self.assertEqual([layer.rows for layer in layers], [*sides, 1, *sides[::-1]])
            self.assertEqual([layer.channels for layer in layers], [1, 8, 16, 32, 64, 1, 64, 32, 16, 8, 1])

    def test_architecture(self):
        flight, paper = PAGE.figures["architecture"].axes
        for axis, layout in ((flight, "flight"), (paper, "paper")):
            self.assertEqual(axis.get_title(loc="left"), f"layout {layout}: 97,858 weights")
            texts = [text.get_text() for text in axis.texts]
            for operation in (layer.operation for layer in chapter.layers(layout)[1:]):
                self.assertIn(operation, texts)
            self.assertEqual(sum("max 2×2" in text for text in texts), 4 * (layout == "paper"))
            self.assertEqual(sum("mean 2×2" in text for text in texts), 4 * (layout == "flight"))
            self.assertEqual(sum("256×256" in text for text in texts), 2)

    def test_pooling(self):
        image, highest, again, mean, repeated = pictures("pooling")[1]
        for row in range(0, 4, 2):
            for column in range(0, 4, 2):
                group = (slice(row, row + 2), slice(column, column + 2))
                values = image[group].ravel().tolist()
                first = values.index(max(values))
                self.assertEqual(highest[row // 2, column // 2], max(values))
                self.assertEqual(again[group].ravel().tolist(), [max(values) if i == first else 0 for i in range(4)])
                self.assertEqual({mean[row // 2, column // 2]}, set(repeated[group].ravel()))
                self.assertEqual(mean[row // 2, column // 2], sum(values) / 4)

    def test_activations(self):
        values, slopes = PAGE.figures["activations"].axes
        for name, below in (("ELU", lambda x: math.exp(x) - 1), ("ReLU", lambda x: 0.0)):
            value, slope = ({line.get_label(): line.get_data() for line in axis.lines}[name]
                            for axis in (values, slopes))
            numpy.testing.assert_allclose(value[1], [x if x > 0 else below(x) for x in value[0]], atol=1e-12)
            middle = abs(value[0]) > 0.02
            numpy.testing.assert_allclose(slope[1][middle], numpy.gradient(value[1], value[0])[middle], atol=1e-4)


if __name__ == "__main__":
    unittest.main()
