"""Figures of toliman.report: the data that they plot, against plain arithmetic."""
import base64
import io
import math
import re
import unittest

import numpy
from pages import lines

import matplotlib
from matplotlib.colors import LogNorm
from PIL import Image
from toliman.report import figures, images, style, text
from toliman.report.figures import Power, Sinusoid


class Text(unittest.TestCase):
    def test_numbers(self):
        for shown, expected in (
            (text.with_error(363.1109, 3.1323), "363.1 ± 3.1"), (text.with_error(2.599307, 0.00041953), "2.59931 ± 0.00042"),
            (text.with_error(365.0, math.nan), "365.00 ± –"), (text.with_error(1234.0, 56.7), "1234 ± 57"),
            (text.scaled(1.0989e-6, 5.223e-8), "(1.099 ± 0.052) × 10⁻⁶"), (text.exponential(-1.07e10), "−1.07 × 10¹⁰"),
            (text.exponential(0), "0"), (text.exponential(math.inf), "–"), (text.scientific(-370.4), "−370"),
            (text.scientific(9.999e-4), "0.001"), (text.scientific(2.9e-7), "2.90 × 10⁻⁷"), (text.fixed(-0.001, 2), "0.00"),
            (text.fixed(-17008.46, 1), "−17008.5"), (text.fixed(math.nan, 1), "–"),
        ):
            self.assertEqual(shown, expected)
        self.assertEqual(text.short_unit([3e-6, math.nan, -4.2e-6], "px")[1], "10⁻⁶ px")
        self.assertEqual(text.short_unit([0], "px"), (1.0, "px"))


class Series(unittest.TestCase):
    def setUp(self):
        noise = numpy.random.default_rng(5)
        self.t = numpy.arange(400.0)
        self.truth = Sinusoid(2e-6, 100.0, 0.7, 1e-6, 3.0)
        self.values = self.truth.at(self.t) + noise.normal(0, 1e-6, 400)

    def test_along_time(self):
        figure = figures.series(self.t, {"a $b": self.values, "c": -self.values}, self.truth.at(self.t), 0.2e6, 100.0)
        for axes, sign in zip(figure.axes, (1, -1)):
            found = lines(axes)
            expected = 1e6 * (sign * self.values - (sign * self.values).mean())
            numpy.testing.assert_allclose(found["each frame"], [self.t, expected], atol=1e-9)
            wave = 1e6 * self.truth.at(self.t)
            numpy.testing.assert_allclose(found["truth"][1], wave - wave.mean(), atol=1e-9)
            x, mean = found["mean over 1/24 of a period"]
            edges = numpy.linspace(0, 399, 97)  # 24 for each of 3.99 periods
            for k, (low, high) in enumerate(zip(edges, edges[1:])):
                inside = (self.t >= low) & ((self.t < high) | (k == 95))
                self.assertAlmostEqual(mean[k], expected[inside].mean(), delta=1e-9)
                self.assertAlmostEqual(x[k], self.t[inside].mean(), delta=1e-9)
            self.assertEqual(axes.get_ylabel(), "separation, 10⁻⁶ px")
            (right,) = axes.child_axes
            self.assertEqual(right.get_ylabel(), "separation, µas")
            figure.draw_without_rendering()
            numpy.testing.assert_allclose(numpy.array(right.get_ylim()), 0.2 * numpy.array(axes.get_ylim()))
        self.assertEqual(figure.axes[1].get_xlabel(), "time, days")
        self.assertEqual(figure.axes[0].get_title("left"), "a \\$b")  # not mathematics

    def test_without_period_or_truth(self):
        found = lines(figures.series(self.t, {"a": self.values}).axes[0])
        self.assertEqual(len(found["mean over 1/72 of the time"][0]), 72)
        self.assertNotIn("truth", found)
        figures.series(numpy.zeros(3), {"a": numpy.zeros(3)})  # one time, one value
        t = numpy.arange(7000.0)  # many frames are thinned
        self.assertEqual(len(lines(figures.series(t, {"a": numpy.sin(t)}).axes[0])["each frame"][0]), 2334)

    def test_folded(self):
        fit = Sinusoid(2.1e-6, 99.0, 0.6, 0.9e-6)
        figure = figures.folded(self.t + 50, {"a": self.values, "b": self.values}, 99.0, self.truth, 0.2e6, {"a": fit})
        found = lines(figure.axes[0])
        numpy.testing.assert_allclose(found["each frame"][0], self.t % 99 / 99, atol=1e-8)
        x, mean = found["mean of 1/24"]
        expected = 1e6 * (self.values - self.values.mean())
        for k in range(24):
            inside = (self.t % 99 / 99 * 24 + 1e-9).astype(int) == k
            self.assertAlmostEqual(mean[k], expected[inside].mean(), delta=1e-9)
        phase, wave = found["truth"]  # of its own period, from the first frame on
        numpy.testing.assert_allclose(wave, 2 * numpy.sin(2 * numpy.pi * (50 + 100 * phase - 3) / 100 + 0.7), atol=1e-9)
        phase, wave = found["best sinusoid"]
        numpy.testing.assert_allclose(wave, 1e6 * (fit.at(50 + 99 * phase) - self.values.mean()), atol=1e-9)
        self.assertNotIn("best sinusoid", lines(figure.axes[1]))
        self.assertEqual(figure.axes[0].get_xlim(), (0, 1))
        error = figure.axes[0].containers[0][2][0].get_segments()
        inside = (self.t % 99 / 99 * 24 + 1e-9).astype(int) == 3
        self.assertAlmostEqual(numpy.ptp(error[3][:, 1]) / 2, expected[inside].std(ddof=1) / inside.sum() ** 0.5, delta=1e-9)


class Periodogram(unittest.TestCase):
    def curve(self, period, width=0.003, **marks):
        frequency = numpy.linspace(0, 0.5, 501)
        power = numpy.exp(-(((frequency - 1 / period) / width) ** 2))
        return Power("curve", frequency, power, **{"grid_peak": 1 / period, "fit": 1.02 / period, "fit_error": 1e-3, **marks})

    def test_marks(self):
        curve = self.curve(25.0, fwhm=0.005, level=0.3)
        figure = figures.periodogram([curve, curve._replace(name="other", fit=math.nan, level=math.nan)])
        axes, other = figure.axes
        found = lines(axes)
        numpy.testing.assert_array_equal(found["curve"], [curve.frequency[1:], curve.power[1:]])
        self.assertEqual([v[0] for v in found["grid peak"]], [0.04, curve.power.max()])
        self.assertEqual(found["fit ± error"][0][0], 0.0408)
        (bar,) = axes.containers[0][2]
        numpy.testing.assert_allclose(bar.get_segments()[0][:, 0], [0.0398, 0.0418])
        self.assertEqual(set(found["FAP 0.001"][1]), {0.3})
        arrow = next(note for note in axes.texts if note.arrow_patch)
        numpy.testing.assert_allclose([arrow.xy[0], arrow.xyann[0]], [0.0375, 0.0425])
        numpy.testing.assert_allclose([arrow.xy[1], arrow.xyann[1]], curve.power.max() / 2)
        label = next(note.get_text() for note in axes.texts if "fit" in note.get_text())
        self.assertEqual(label, "fit 24.51 ± 0.60 days\ngrid peak 25.00 days")
        self.assertNotIn("FAP 0.001", lines(other))
        self.assertEqual(other.get_xlabel(), "frequency, 1/day")

    def test_axis_of_periods(self):
        figure = figures.periodogram([self.curve(25.0)])
        (top,) = figure.axes[0].child_axes
        figure.draw_without_rendering()
        ticks = [(tick, float(label.get_text())) for tick, label in zip(top.get_xticks(), top.get_xticklabels())]
        self.assertGreater(len(ticks), 4)
        for frequency, period in ticks:
            self.assertAlmostEqual(frequency * period, 1, delta=1e-5)
        self.assertEqual(top.get_xlabel(), "period, days")
        frequency = numpy.array([0.3, 0.4, 0.5])  # less than a decade: even steps
        figure = figures.periodogram([Power("n", frequency, frequency)], "units of 2 s")
        numpy.testing.assert_allclose(figure.axes[0].get_xticks(), [0.3, 0.35, 0.4, 0.45, 0.5], atol=1e-9)
        self.assertEqual(figure.axes[0].get_xlabel(), "frequency, 1/units of 2 s")

    def test_no_peak_is_lost(self):
        frequency = numpy.linspace(0.001, 0.5, 200001)
        power = numpy.random.default_rng(1).uniform(0, 0.1, 200001)
        power[[7, 123456]] = 0.9, 0.8
        x, y = figures.envelope(frequency, power)
        self.assertLessEqual(len(x), 1500)
        self.assertTrue((numpy.diff(x) > 0).all() and set(x) <= set(frequency))
        self.assertEqual((y[x == frequency[7]], y[x == frequency[123456]]), (0.9, 0.8))

    def test_labels_stay_on_the_figure(self):
        for period in (150, 20, 2.01):
            figure = figures.periodogram([self.curve(period, fit=1 / period, fwhm=0.004)])
            renderer = figure._get_renderer() if hasattr(figure, "_get_renderer") else figure.canvas.get_renderer()
            figure.draw(renderer)
            frame = figure.axes[0].get_window_extent(renderer)
            for note in figure.axes[0].texts:
                box = note.get_window_extent(renderer) if note.get_text() else frame
                self.assertTrue(frame.x0 - 1 <= box.x0 and box.x1 <= frame.x1 + 1, (period, note.get_text()))


class Images(unittest.TestCase):
    def panel(self, **changes):
        values = numpy.arange(12.0).reshape(3, 4) + 1
        return images.Panel("title", values, -3.0, -2.0, 2.0, "photons")._replace(**changes)

    def test_pixels_and_axes(self):
        first, second = self.panel(scale="log"), self.panel(scale="difference", unit="10³ photons", values=self.panel().values - 3)
        figure = images.images([first, second, second._replace(title="again")])
        shown = [axes.images[0] for axes in figure.axes if axes.images]
        self.assertEqual(len(figure.axes), 5)  # neighbours of one unit share a colour bar
        for image, panel in zip(shown, (first, second, second)):
            numpy.testing.assert_array_equal(image.get_array(), panel.values)
            self.assertEqual((list(image.get_extent()), image.origin), ([-4, 4, -3, 3], "lower"))
            self.assertEqual(image.axes.get_xlabel(), "x, arcsec")
        self.assertIsInstance(shown[0].norm, LogNorm)
        self.assertAlmostEqual(shown[0].norm.vmin / 12e-5, 1)
        self.assertEqual([(image.norm.vmin, image.norm.vmax) for image in shown[1:]], [(-9, 9)] * 2)
        blank = images.images([self.panel(values=numpy.full((3, 4), math.nan))])
        self.assertTrue(numpy.ma.getmaskarray(blank.axes[0].images[0].get_array()).all())

    def test_stars_and_directions(self):
        """At a detector turned by 30 deg; the arrows stay on the image for any angle."""
        for degrees in range(0, 360, 30):
            angle = math.radians(degrees)
            north, east = (math.sin(angle), math.cos(angle)), (-math.cos(angle), math.sin(angle))
            sky = images.Sky({"A": (1.0, -1.0), "B": (-1.5, 0.5)}, north, east)
            axes = images.images([self.panel(scale="log", values=numpy.ones((30, 30)), first_x=-29, first_y=-29)], sky).axes[0]
            self.assertEqual({line.get_gid(): (line.get_xdata()[0], line.get_ydata()[0]) for line in axes.get_lines()},
                             {"star-A": (1.0, -1.0), "star-B": (-1.5, 0.5)})
            arrows = [note for note in axes.texts if getattr(note, "arrow_patch", None)]
            for arrow, direction in zip(arrows, (north, east)):
                along = numpy.subtract(arrow.xy, arrow.xyann)
                numpy.testing.assert_allclose(along / numpy.hypot(*along), direction, atol=1e-9)
            for note in axes.texts:
                self.assertTrue(all(-30 < at < 30 for at in note.get_position()), (degrees, note))

    def test_cut(self):
        x = numpy.linspace(-10, 10, 41)
        figure = images.cut({"600 nm": numpy.exp(-x * x), "wide": numpy.full(41, 0.5)}, x, 0.99)
        (axes,) = figure.axes
        numpy.testing.assert_allclose(lines(axes)["600 nm"], [x, numpy.exp(-x * x)])
        figure.draw_without_rendering()
        (top,) = axes.child_axes
        numpy.testing.assert_allclose(top.get_xlim(), numpy.array(axes.get_xlim()) / 0.99)
        self.assertEqual((top.get_xlabel(), axes.get_yscale()), ("x, λ/D", "log"))

    def test_whiteness(self):
        noise = numpy.random.default_rng(3).normal(size=(5, 64, 64))
        frequency, power, error = images.radial_power(noise)
        self.assertLess(abs((power - 1) / error).max(), 4)
        smooth = (noise + numpy.roll(noise, 1, 2)) / 2**0.5  # power 1 + cos(2 pi f_x)
        frequency, power, _ = images.radial_power(smooth)
        self.assertGreater(power[0], 1.7)
        self.assertLess(power[-1], 1.0)
        wave = numpy.sin(2 * numpy.pi * 0.25 * numpy.arange(64))[None, None, :] + numpy.zeros((1, 64, 1))
        frequency, power, _ = images.radial_power(wave)
        self.assertAlmostEqual(frequency[power.argmax()], 0.25, delta=0.025)
        left, right = images.whiteness(noise).axes
        heights = left.patches[0].get_data().values
        expected = numpy.histogram(noise, numpy.linspace(-5, 5, 51), density=True)[0]
        numpy.testing.assert_allclose(heights, expected, rtol=1e-3, atol=1e-9)
        x, gaussian = lines(left)["Gaussian, sigma 1"]
        self.assertAlmostEqual(gaussian.max(), 0.3989, delta=1e-4)
        numpy.testing.assert_array_equal(lines(right)["residuals"], images.radial_power(noise)[:2])


class Comparisons(unittest.TestCase):
    def test_detection(self):
        points = numpy.array([[1e-6, 1e-5], [0.4, 831.0], [math.nan, 1.008]])
        figure = figures.detection({f"method {k}": points for k in range(12)}, numpy.array([[1e-6, 1e-5], [0.5, 829.0]]), 2.9e-7)
        top, bottom = figure.axes
        numpy.testing.assert_array_equal(lines(top)["method 3"], points[:2])
        numpy.testing.assert_array_equal(lines(top)["at the bound"], [[1e-6, 1e-5], [0.5, 829.0]])
        self.assertEqual(set(lines(top)["found: FAP 0.001"][1]), {3})
        drawn = [line for line in bottom.get_lines() if line.get_marker() != "None"]
        numpy.testing.assert_array_equal(drawn[0].get_data(), points[[0, 2]])
        self.assertEqual(len({(line.get_marker(), line.get_color()) for line in drawn}), 12)
        self.assertEqual(len({matplotlib.colors.to_hex(line.get_color()) for line in drawn[:9]}), 9)
        for axes in (top, bottom):
            self.assertIn([2.9e-7, 2.9e-7], [list(line.get_xdata()) for line in axes.get_lines()])

    def test_false_alarms(self):
        heights = [40, 0, 1, 2, 3, 0, 0, 1, 0, 3]
        faps = numpy.array([0.1 * k + 0.05 for k, height in enumerate(heights) for _ in range(height)])
        axes = figures.false_alarms({"cae": faps, "template": numpy.append(faps[1:], math.nan)}).axes[0]
        bars = {bars.get_label(): [bar.get_height() for bar in bars] for bars in axes.containers}
        self.assertEqual(bars, {"cae": heights, "template": [39, *heights[1:]]})
        self.assertEqual(set(lines(axes)["uniform, ± 1 sigma"][1]), {5})

    def test_benchmark(self):
        points = {"Chebyshev": (numpy.array([3.2e-10, 5e-13]), numpy.array([0.05, 0.07])), "other": (numpy.ones(2), numpy.ones(2))}
        axes = figures.benchmark(points, "error", "time, s").axes[0]
        numpy.testing.assert_array_equal(lines(axes)["Chebyshev"], points["Chebyshev"])
        self.assertEqual((axes.get_xlabel(), axes.get_ylabel(), axes.get_xscale()), ("error", "time, s", "log"))

    def test_training(self):
        axes = figures.training(numpy.arange(1, 4), numpy.array([1, 0.1, 0.02])).axes[0]
        self.assertEqual([list(values) for values in axes.get_lines()[0].get_data()], [[1, 2, 3], [1, 0.1, 0.02]])


class Style(unittest.TestCase):
    def test_images_keep_their_pixels(self):
        """One byte per pixel, the colours of the colour map; powers of ten are text."""
        values = numpy.random.default_rng(3).uniform(0.0, 1.0, (20, 30))
        values[4, 5] = math.nan
        figure = images.images([images.Panel("a", values, 0, 0, 1, "b")])
        data = re.findall(rb'"data:image/png;base64,([^"]*)"', style.drawn(figure, "svg"))
        (image,) = [found for found in (Image.open(io.BytesIO(base64.b64decode(one))) for one in data) if found.size == (30, 20)]
        self.assertEqual(image.mode, "P")
        shown = figure.axes[0].images[0]
        pixels, expected = numpy.asarray(image.convert("RGBA")), shown.to_rgba(values, bytes=True)
        self.assertTrue((pixels == expected).all() or (pixels == expected[::-1]).all())
        figure = images.images([images.Panel("a", values + 0.1, 0, 0, 1, "b", scale="log")])
        self.assertLessEqual({"10⁻¹", "10⁰"}, {label.get_text() for label in figure.axes[1].get_yticklabels()})

    def test_same_bytes_whatever_the_user_set(self):
        def draw(kind):
            return style.drawn(figures.training(numpy.arange(1, 9), 1.0 / numpy.arange(1, 9)), kind)

        before = {kind: draw(kind) for kind in style.FORMATS}
        self.assertEqual([data[:4] for data in before.values()], [b"<?xm", b"\x89PNG", b"%PDF"])
        with matplotlib.rc_context({"lines.linewidth": 7, "font.family": "serif", "svg.hashsalt": "x"}):
            settings = dict(matplotlib.rcParams)
            self.assertEqual({kind: draw(kind) for kind in style.FORMATS}, before)
            self.assertEqual(dict(matplotlib.rcParams), settings)


if __name__ == "__main__":
    unittest.main()
