"""The plots of Python: what they draw against the numbers of their objects, axes and settings of the user, mistakes."""
import copy
import dataclasses
import datetime
import math
import os
import pathlib
import pickle
import subprocess
import sys
import unittest
import unittest.mock
import warnings

import numpy

from package import toliman
from refusal import refused
from test_calibration import SCENE

try:
    import matplotlib
    import matplotlib.mathtext
    matplotlib.use("agg")
    from matplotlib import colors, pyplot
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
except ImportError:
    matplotlib = None
try:
    from astropy import units
except ImportError:
    units = None

PERIOD, SIGMA = 17.3, 0.4
PACKAGE = pathlib.Path(toliman.__file__).parents[1]


def series(count=200, seed=1):
    """Times and values with a sinusoid."""
    chance = numpy.random.default_rng(seed)
    t = numpy.sort(chance.uniform(0, 200, count))
    return t, 5 + 2 * numpy.sin(2 * math.pi * t / PERIOD + 1) + SIGMA * chance.normal(size=count)


def dates_of(t):
    return numpy.datetime64("2028-01-01T00:00:00", "ms") + (t * 86400e3).astype("m8[ms]")


def lines(axes):
    """{label: (x, y)} of lines and of points with error bars."""
    found = {line.get_label(): line.get_data() for line in axes.get_lines()}
    found.update((bars.get_label(), bars[0].get_data()) for bars in axes.containers if hasattr(bars, "has_xerr"))
    return found


def labels(axes):
    return axes.get_xlabel(), axes.get_ylabel()


def bar_of(axes):
    """The label of the colour bar."""
    return axes.figure.axes[1].get_ylabel()


class PlotTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        if matplotlib is None:
            raise unittest.SkipTest("needs matplotlib")
        cls.t, cls.y = series()
        cls.periodogram = toliman.Periodogram(0.005, 0.0005, 400, sigma_floor=SIGMA, value_offset=5, time_offset=3)
        cls.periodogram.push_many(cls.t, cls.y, SIGMA)
        cls.addClassCleanup(pyplot.close, "all")


class Periods(PlotTest):
    def test_power(self):
        axes = self.periodogram.plot()
        found, peak = lines(axes), self.periodogram.peak()
        numpy.testing.assert_array_equal(found["power"], [self.periodogram.frequency, self.periodogram.power()])
        self.assertEqual([place[0] for place in found["grid peak"]], [1 / peak.period, self.periodogram.power().max()])
        (level,) = set(found["FAP 0.001"][1])
        self.assertAlmostEqual(self.periodogram.log10_fap(math.log10(1 - level)), -3, delta=1e-6)
        self.assertEqual(labels(axes), ("frequency, 1/units of t", "power (no unit)"))
        self.assertEqual(axes.child_axes[0].get_xlabel(), "period, units of t")
        (text,) = [note.get_text() for note in axes.texts if "grid peak" in note.get_text()]
        self.assertAlmostEqual(float(text.split()[2]), PERIOD, delta=0.2)

    def test_units_of_times(self):
        plain = toliman.Periodogram(0.01, 0.01, 20)
        in_hours = toliman.Periodogram(0.01, 0.01, 20, unit_ns=3600e9)
        for made, push, unit in (
                (plain, lambda p, t, y: p.push_many(dates_of(t), y), "days"),
                (plain, lambda p, t, y: p.push(datetime.datetime(2028, 1, 1) + datetime.timedelta(t[0]), y[0]), "days"),
                (plain, lambda p, t, y: p.push(int(1e9 * t[0]), y[0], ns=True), "s"),
                (in_hours, lambda p, t, y: p.push(int(36e11 * t[0]), y[0], ns=True), "h"),
                (plain, lambda p, t, y: p.push(t[0], y[0]), "units of t")):
            with made.copy() as periodogram:
                for k in range(8):
                    push(periodogram, self.t[k:k + 1], self.y[k:k + 1])
                for one in (periodogram.copy(), pickle.loads(pickle.dumps(periodogram))):
                    axes = one.plot(pyplot.figure().add_subplot())
                    self.assertEqual(axes.child_axes[0].get_xlabel(), f"period, {unit}")
                    self.assertEqual(labels(axes)[0], f"frequency, 1/{'day' if unit == 'days' else unit}")
                    pyplot.close(axes.figure)

    def test_tracker(self):
        with toliman.Tracker(lambda image: float(image[0, 0]), 0.02, 0.001, 100, estimator_id=7, sigma=1.0, rows=4,
                             cols=4, image_shape=(4, 4), allow_zero_runs=True, value_limit=1e6) as tracker:
            for k in range(30):
                tracker.push(toliman.Frame(numpy.full((4, 4), self.y[k]), k, k * 86400 * 10**9))
            axes = tracker.period.plot()
            numpy.testing.assert_array_equal(lines(axes)["power"], [tracker.period.frequency, tracker.period.power()])
            self.assertEqual(labels(axes)[0], "frequency, 1/day")

    def test_folded(self):
        peak = toliman.period(self.t, self.y, SIGMA)
        again = self.periodogram.fit(self.t, self.y, SIGMA)
        for found in (peak, again):
            axes = found.plot()
            shown, phase = lines(axes), (self.t - self.t[0]) / found.period % 1
            numpy.testing.assert_allclose(shown["each sample"], [phase, self.y - self.y.mean()], atol=1e-8)
            matrix = numpy.stack([numpy.sin(2 * math.pi * phase), numpy.cos(2 * math.pi * phase), phase**0], 1)
            sine, cosine, mean = numpy.linalg.lstsq(matrix, self.y, rcond=None)[0]
            x, wave = shown["best sinusoid"]
            expected = sine * numpy.sin(2 * math.pi * x) + cosine * numpy.cos(2 * math.pi * x) + mean - self.y.mean()
            numpy.testing.assert_allclose(wave, expected, atol=1e-6)
            inside = phase < 1 / 24
            self.assertAlmostEqual(shown["mean of 1/24"][1][0], self.y[inside].mean() - self.y.mean(), delta=1e-9)
            self.assertEqual(labels(axes), ("phase (periods)", "value less its mean, units of y"))
            self.assertRegex(axes.get_title("left"), r"^period 17\.\d+ ± 0\.\d+ units of t, log₁₀ FAP −\d")

    @unittest.skipIf(units is None, "needs astropy")
    def test_folded_with_units(self):
        axes = toliman.period(dates_of(self.t), 1e-3 * self.y * units.mas, 1e-6 * SIGMA * units.arcsec).plot()
        self.assertEqual(labels(axes)[1], "value less its mean, 10⁻³ mas")
        self.assertIn(" days, ", axes.get_title("left"))
        numpy.testing.assert_allclose(lines(axes)["each sample"][1], self.y - self.y.mean(), atol=1e-6)
        with toliman.Periodogram(*toliman.suited_grid(self.t), value_offset=5, sigma_floor=SIGMA) as periodogram:
            given = self.t * units.day, self.y * units.km / units.s, SIGMA * units.km / units.s
            periodogram.push_many(*given)
            axes = periodogram.fit(*given).plot()
        self.assertEqual(labels(axes)[1], "value less its mean, km/s")
        self.assertIn(" days, ", axes.get_title("left"))

    def test_folded_without_nuisance_functions(self):
        rows = numpy.cos(self.t / 60)[:, numpy.newaxis]
        place = self.t / 100 - 1
        drift = 3 * place + 2 * (2 * place**2 - 1) + 4 * rows[:, 0]
        with toliman.Periodogram(*toliman.suited_grid(self.t), value_offset=5, sigma_floor=SIGMA, trend=2,
                                 span=(0, 200), columns=1, double_limb=True) as periodogram:
            periodogram.push_many(self.t, self.y + drift, SIGMA, rows=rows)
            peak = periodogram.fit(self.t, self.y + drift, SIGMA, rows=rows)
            shown = lines(peak.plot())["each sample"][1]
        angle = 2 * math.pi * self.t / peak.period
        functions = [place, 2 * place**2 - 1, rows[:, 0]]
        matrix = numpy.stack([numpy.sin(angle), numpy.cos(angle), angle**0, *functions], 1)
        found = numpy.linalg.lstsq(matrix, self.y + drift, rcond=None)[0]
        expected = self.y + drift - matrix[:, 3:] @ found[3:]
        # the library fits them at the frequency of the grid
        numpy.testing.assert_allclose(shown, expected - expected.mean(), atol=0.25 * SIGMA)

    def test_a_peak_keeps_its_series_to_itself(self):
        y = self.y.copy()
        peak, other = (toliman.period(self.t, values, SIGMA) for values in (self.y, y))
        y[:] = 0
        numpy.testing.assert_array_equal(*(lines(one.plot())["each sample"][1] for one in (peak, other)))
        self.assertEqual((peak, repr(peak)), (other, repr(other)))
        again = pickle.loads(pickle.dumps(peak))
        self.assertEqual(again, peak)
        self.assertEqual(len(pickle.dumps(peak)), len(pickle.dumps(dataclasses.replace(peak))))
        self.assertNotIn("_samples", {field.name for field in dataclasses.fields(peak)})
        for without in (again, copy.copy(peak), self.periodogram.peak(), self.periodogram.peaks()[0]):
            with refused(ValueError, "this"):
                without.plot()


class Series(PlotTest):
    def test_values(self):
        t, y = dates_of(self.t), self.y
        for measured, expected in (
                (toliman.Measurements.of(self.t, y, SIGMA), ("time, days", "value, units of y")),
                (toliman.Measurements.of(t, y, SIGMA, kind="reduced", unit=1),
                 ("time, MJD (TAI)", "reduced separation, arcsec")),
                (toliman.Measurements.of(self.t, y, SIGMA, kind="velocity", unit=1000, time_unit_days=365.25),
                 ("time, units of 365.25 days", "velocity, km/s")),
                (toliman.Measurements.of(self.t, y, SIGMA, unit=0.375), ("time, days", "value, units of 0.375 arcsec")),
                (toliman.Measurements(b"bjd_tdb,y,sigma\n2461000.5,1,0.1\n2461002.5,2,0.1\n", kind="value"),
                 ("time, MJD (TDB)", "value, units of y"))):
            axes = measured.plot()
            self.assertEqual(labels(axes), expected)
            (bars,) = axes.containers
            numpy.testing.assert_array_equal(bars[0].get_data(), [measured.t, measured.y])
            ends = numpy.array(bars[2][0].get_segments())[:, :, 1].T
            numpy.testing.assert_allclose(ends, [measured.y - measured.sigma, measured.y + measured.sigma], rtol=1e-12)

    @unittest.skipIf(units is None, "needs astropy")
    def test_units(self):
        """Labels and columns of tables have one unit."""
        for t, y, more, shown, unit in (
                (self.t, self.y * units.uas, {}, ("days", "value, µas"), "uas"),
                (self.t * units.h, self.y * units.K, {}, ("days", "value, K"), "K"),
                (self.t, self.y * units.km / units.s, {}, ("days", "value, km/s"), "km / s"),
                (dates_of(self.t), self.y, {}, ("MJD (TAI)", "value, units of y"), None),
                (self.t, self.y, {"unit": 3600}, ("days", "value, deg"), "deg"),
                (self.t, self.y, {"unit": 1e-6}, ("days", "value, µas"), "uas"),
                (self.t, self.y, {"unit": 0.01, "kind": "velocity"}, ("days", "velocity, cm/s"), "cm / s"),
                (self.t, self.y, {"unit": 0.375}, ("days", "value, units of 0.375 arcsec"), None)):
            measured = toliman.Measurements.of(t, y, **more)
            for one in (measured, toliman.Measurements.of_table(measured.to_table())):
                axes = one.plot(pyplot.figure().add_subplot())
                self.assertEqual(labels(axes), (f"time, {shown[0]}", shown[1]))
                self.assertEqual(one.to_table()["y"].unit, unit and units.Unit(unit))
                pyplot.close(axes.figure)

    def test_an_empty_series(self):
        with refused(ValueError, "these"):
            toliman.Measurements.of([], []).plot()

    def test_instruments(self):
        measured = toliman.Measurements.of(self.t, self.y)
        names = numpy.array(["one", "two_b"])[(numpy.arange(len(self.t)) % 3 == 1).astype(int)]
        measured.set_instruments(list(names))
        axes = measured.plot()
        for name in ("one", "two_b"):
            numpy.testing.assert_array_equal(lines(axes)[name], [self.t[names == name], self.y[names == name]])
        self.assertEqual([text.get_text() for text in axes.get_legend().texts], ["one", "two_b"])
        of_file = toliman.Measurements(b'mjd,y,who\n61000,1,"HARPS N"\n61001,2,ESPRESSO\n', instrument="who")
        legend = of_file.plot().get_legend()
        self.assertEqual([text.get_text() for text in legend.texts], ["HARPS N", "ESPRESSO"])

    def test_long_series(self):
        measured = toliman.Measurements.of(numpy.arange(7000.0), numpy.ones(7000))
        axes = measured.plot()
        self.assertEqual(axes.get_title("left"), "one of 3 samples")
        numpy.testing.assert_array_equal(axes.containers[0][0].get_xdata(), numpy.arange(0.0, 7000, 3))


class Calibrations(PlotTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.nominal = toliman.Simulator(SCENE)
        cls.found = toliman.calibrate(cls.nominal, cls.nominal.frames(), free=["scale=1e-3", "focus", "zernike_5-7"])

    def test_parameters(self):
        values = self.found.values()
        for options, names, label in (({}, ["focus", "zernike_5", "zernike_6", "zernike_7"], "change, nm"),
                                      ({"unit": ""}, ["scale"], "change (no unit)")):
            axes = self.found.plot(**options)
            bars, errors = axes.containers[::-1]
            self.assertEqual([label.get_text() for label in axes.get_xticklabels()], names)
            self.assertEqual([bar.get_height() for bar in bars], [values[name].value for name in names])
            segments = errors[2][0].get_segments()
            numpy.testing.assert_allclose([numpy.ptp(segment[:, 1]) / 2 for segment in segments],
                                          [values[name].sigma for name in names], rtol=1e-6)
            self.assertEqual(axes.get_ylabel(), label)

    def test_images(self):
        axes, opd = self.found.plot_opd(), 1e9 * self.found.opd()
        shown = axes.images[0].get_array()
        numpy.testing.assert_array_equal(numpy.ma.getmaskarray(shown), opd == 0)
        numpy.testing.assert_array_equal(shown[opd != 0], opd[opd != 0])
        self.assertEqual((*labels(axes), bar_of(axes)), ("x, cells", "y, cells", "change of the OPD, nm"))
        figure = self.found.plot_residual()
        for axes, is_fitted in zip(figure.axes, (False, True)):
            numpy.testing.assert_array_equal(axes.images[0].get_array(), self.found.residual(is_fitted))
        self.assertEqual([axes.get_ylabel() for axes in figure.axes[2:]],
                         [f"residual {name}, σ of the pixel" for name in ("before", "after")])

    def test_correlations(self):
        axes, covariance = self.found.plot_correlations(), self.found.covariance()
        n = range(len(covariance))
        expected = [[covariance[i, j] / math.sqrt(covariance[i, i] * covariance[j, j]) for j in n] for i in n]
        numpy.testing.assert_allclose(axes.images[0].get_array(), expected, rtol=1e-12)
        self.assertEqual([label.get_text() for label in axes.get_yticklabels()], list(self.found.values()))

    def test_mistakes(self):
        failed = toliman.calibrate(self.nominal, self.nominal.frames(seed=9), most_iterations=1)
        self.assertTrue(failed.info.not_converged)
        for plot in (failed.plot, failed.plot_opd, failed.plot_residual, failed.plot_correlations):
            with refused(ValueError, "this"):
                plot()
        with refused(ValueError, "unit"):
            self.found.plot(unit="km")
        with refused(toliman.InputError, "window"):
            self.found.plot(window=3)


class Searches(PlotTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        chance = numpy.random.default_rng(3)
        cls.days = numpy.sort(chance.uniform(0, 1000, 120))
        cls.noise = 0.3 * chance.normal(size=120)
        cls.wave = 1.2 * numpy.sin(2 * math.pi * cls.days / 310)
        cls.found = toliman.planets(cls.days, 1e-6 * (cls.wave + cls.noise), 0.3e-6, unit=1, parallax_arcsec=0.75,
                                    star_masses=(1.08, 0.91), samples=500)

    def test_folded(self):
        figure = self.found.plot_folded()
        (planet,) = self.found.candidates
        residual, signal = self.found.residuals(), self.found.signal(0, self.days)
        phase = (self.days - planet.best[3]) / planet.best[0] % 1
        for axes, values in zip(figure.axes, (signal + residual, residual)):
            numpy.testing.assert_allclose(lines(axes)["each sample"], [phase, 1e6 * values], atol=1e-6)
        x, orbit = lines(figure.axes[0])["best orbit"]
        numpy.testing.assert_allclose(orbit, 1e6 * self.found.signal(0, planet.best[3] + x * planet.best[0]), atol=1e-6)
        self.assertEqual([axes.get_ylabel() for axes in figure.axes], ["signal, µas", "residual, µas"])
        self.assertEqual(figure.axes[1].get_xlabel(), "phase since periastron (periods)")
        self.assertRegex(figure.axes[0].get_title("left"), r"^planet 1, period 3\d\d\.\d ± \d\.\d days$")

    def test_a_candidate_that_is_not_in_the_fit(self):
        """Its signal is in the residuals of the fit, and so in the values that are drawn."""
        found = toliman.planets(self.days, self.noise + 3, 0.3, samples=100)
        (candidate,) = found.candidates
        self.assertTrue(candidate.reasons)
        top, bottom = found.plot_folded().axes
        order = numpy.argsort(lines(top)["each sample"][0])
        expected = numpy.argsort((self.days - candidate.best[3]) / candidate.best[0] % 1)
        numpy.testing.assert_allclose(lines(top)["each sample"][1][order], 1e3 * found.residuals()[expected], rtol=1e-6)
        left = found.residuals() - found.signal(0, self.days)
        numpy.testing.assert_allclose(lines(bottom)["each sample"][1][order], 1e3 * left[expected], rtol=1e-6)
        self.assertEqual(top.get_ylabel(), "signal, 10⁻³ units of y")

    def test_corner(self):
        figure, samples = self.found.plot_corner(), self.found.samples()
        columns = {"period, days": samples["period"], "eccentricity": samples["eccentricity"],
                   "amplitude, µas": 1e6 * samples["amplitude"], "mass on A, Earths": samples["mass_a"]}
        last = figure.axes[12:]
        self.assertEqual([axes.get_xlabel() for axes in last], list(columns))
        self.assertEqual([figure.axes[4 * row].get_ylabel() for row in (1, 2, 3)], list(columns)[1:])
        for place, values in enumerate(columns.values()):
            axes = figure.axes[5 * place]
            marks = [line.get_xdata()[0] for line in axes.get_lines()]
            numpy.testing.assert_allclose(marks, numpy.percentile(values, (16, 50, 84)))
            heights = [bar.get_height() for bar in axes.patches]
            low, high = numpy.percentile(values, (0.1, 99.9))
            self.assertEqual(sum(heights), ((values >= low) & (values <= high)).sum())

    def test_limits(self):
        periods = numpy.array([100.0, 300, 500])
        expected = self.found.limits(periods)
        (planet,) = self.found.planets
        axes = self.found.plot_limits(periods[::-1])
        numpy.testing.assert_array_equal(lines(axes)["upper limit"], [periods, expected["upper_mass_a"]])
        numpy.testing.assert_array_equal(lines(axes)["detectable"], [periods, expected["detectable_mass_a"]])
        star = [place[0] for place in lines(axes)["planets of this series"]]
        self.assertEqual(star, [planet.period[1], planet.mass_a[1]])
        self.assertIn("Earth", [note.get_text() for note in axes.texts])
        self.assertEqual(labels(axes), ("period, days", "mass on A, Earths"))

    @unittest.skipIf(units is None, "needs astropy")
    def test_periods_with_a_unit(self):
        axes, plain = self.found.plot_limits([0.5, 1] * units.yr), self.found.plot_limits([182.625, 365.25])
        numpy.testing.assert_allclose(lines(axes)["upper limit"], lines(plain)["upper limit"], rtol=1e-9)
        with self.assertRaisesRegex(ValueError, "^periods is in m"):
            self.found.plot_limits([1, 2] * units.m)

    def test_other_units(self):
        """Times in years, values without a known unit; velocities."""
        found = toliman.planets(self.days / 365.25, self.wave + self.noise, 0.3, time_unit_days=365.25, period_min=0.2,
                                period_max=2.5, samples=100)
        axes = found.plot_limits()
        x, upper = lines(axes)["upper limit"]
        numpy.testing.assert_allclose([x[0], x[-1]], [0.2 * 365.25, 2.5 * 365.25])
        factor = upper[0] / found.limits(x[:1] / 365.25)["upper"][0]
        self.assertEqual(labels(axes)[1], "amplitude, 10⁻³ units of y" if factor > 10 else "amplitude, units of y")
        self.assertAlmostEqual(numpy.log10(factor) % 3, 0, delta=1e-6)
        marks = [line.get_xdata()[0] for line in found.plot_corner().axes[0].get_lines()]
        self.assertAlmostEqual(marks[1], 365.25 * found.planets[0].period[1], delta=1)
        found = toliman.planets(self.days, self.wave + self.noise, 0.3, velocity=True, unit=1, star_masses=(1.08, 0),
                                samples=100)
        self.assertEqual(labels(found.plot_limits([100, 400]))[1], "mass, Earths")
        self.assertEqual(found.plot_folded().axes[0].get_ylabel(), "signal, m/s")

    def test_mistakes(self):
        for name, plot in (("index", lambda: self.found.plot_corner(1)), ("index", lambda: self.found.plot_folded(-1)),
                           ("periods", lambda: self.found.plot_limits([300])),
                           ("periods", lambda: self.found.plot_limits([]))):
            with refused(ValueError, name):
                plot()
        with unittest.mock.patch.object(toliman.Planets, "candidates", []):
            with refused(ValueError, "these"):
                self.found.plot_corner()


class Scenes(PlotTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.simulator = toliman.Simulator({**SCENE, "detector": {"shape": [24, 40], "pixel_scale_arcsec": 0.375}})

    def test_frame(self):
        axes = self.simulator.plot_frame(2)
        (image,) = axes.images
        numpy.testing.assert_array_equal(image.get_array(), self.simulator.frame(2))
        self.assertEqual((list(image.get_extent()), image.origin), ([-20, 20, -12, 12], "lower"))
        self.assertEqual((*labels(axes), axes.get_title()), ("x, px", "y, px", "frame 2"))
        self.assertEqual(bar_of(axes), "photons")

    def test_pupil(self):
        axes, (amplitude, opd_m) = self.simulator.plot_pupil(), self.simulator.pupil()
        shown = axes.images[0].get_array()
        numpy.testing.assert_array_equal(numpy.ma.getmaskarray(shown), amplitude == 0)
        numpy.testing.assert_array_equal(shown[amplitude > 0], 1e9 * opd_m[amplitude > 0])
        numpy.testing.assert_allclose(axes.images[0].get_extent(), [-62.5, 62.5, -62.5, 62.5])
        self.assertEqual((*labels(axes), bar_of(axes)), ("x, mm", "y, mm", "optical path difference, nm"))

    def test_budget(self):
        budget = self.simulator.budget()
        axes = budget.plot()
        bounds, places = lines(axes)["bound of a frame"]
        numpy.testing.assert_array_equal(bounds, [step.crb_px for step in budget.steps])
        names = [label.get_text() for label in axes.get_yticklabels()]
        self.assertEqual(dict(zip(places, names)), {7 - k: step.name for k, step in enumerate(budget.steps)})
        self.assertEqual(axes.get_xlabel(), "standard deviation of the separation, px")
        infinite = budget._replace(steps=[dataclasses.replace(budget.steps[0], crb_px=math.inf)])
        with refused(ValueError, "this"):
            infinite.plot()

    def test_mask(self):
        cells = (numpy.arange(64).reshape(8, 8) % 3 == 0).astype(numpy.uint8)
        axes = toliman.DesignedMask(cells, {}, [], numpy.zeros(0)).plot()
        numpy.testing.assert_array_equal(axes.images[0].get_array(), cells + 1)
        self.assertEqual(labels(axes), ("x, cells", "y, cells"))

    def test_closed(self):
        with toliman.Simulator(SCENE) as simulator, toliman.Measurements.of([1, 2], [3, 4]) as measured:
            pass
        for plot in (simulator.plot_frame, simulator.plot_pupil, measured.plot):
            with refused(ValueError, "this"):
                plot()
        self.assertEqual(simulator.close(), None)


class AxesOfTheUser(PlotTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        simulator = toliman.Simulator(SCENE)
        calibration = toliman.calibrate(simulator, simulator.frames(), free=["focus", "zernike_5"])
        planets = toliman.planets(10 * cls.t, cls.y, SIGMA, unit=1, parallax_arcsec=0.75, star_masses=(1, 1),
                                  samples=100)
        with warnings.catch_warnings():  # of pyparsing, for what matplotlib parses first
            warnings.simplefilter("ignore")
            matplotlib.mathtext.MathTextParser("agg").parse("$10^1$")
        peak = toliman.period(cls.t, cls.y)
        mask = toliman.DesignedMask(numpy.eye(8, dtype=numpy.uint8), {}, [], numpy.zeros(0))
        cls.plots = {
            "periodogram": cls.periodogram.plot, "peak": peak.plot,
            "measurements": toliman.Measurements.of(cls.t, cls.y).plot, "calibration": calibration.plot,
            "opd": calibration.plot_opd, "correlations": calibration.plot_correlations,
            "limits": lambda ax=None: planets.plot_limits([100, 200], ax),
            "frame": lambda ax=None: simulator.plot_frame(1, ax), "pupil": simulator.plot_pupil, "mask": mask.plot,
            "budget": simulator.budget().plot,
            "folded": lambda ax=None: planets.plot_folded(0, ax)}
        cls.figures = planets.plot_corner, calibration.plot_residual, planets.plot_folded

    def test_new_figures(self):
        """One of pyplot each, in one style whatever the user's; the settings are unchanged."""
        for plot, kind in [(plot, Axes) for name, plot in self.plots.items() if name != "folded"] + [
                (plot, Figure) for plot in self.figures]:
            pyplot.close("all")
            with matplotlib.rc_context({"axes.facecolor": "red", "lines.linewidth": 7}), warnings.catch_warnings():
                warnings.simplefilter("error")
                settings = dict(matplotlib.rcParams)
                made = plot()
                self.assertEqual(dict(matplotlib.rcParams), settings)
                self.assertIsInstance(made, kind)
                figure = made if kind is Figure else made.figure
                self.assertEqual([pyplot.figure(number) for number in pyplot.get_fignums()], [figure])
                figure.canvas.draw()
            self.assertNotIn(colors.to_rgba("red"), [axes.get_facecolor() for axes in figure.axes])
            for axes in figure.axes:
                self.assertRegex(axes.get_xlabel(), "^$|, |\\(|^eccentricity$")

    def test_axes_of_the_user(self):
        for name, plot in self.plots.items():
            with pyplot.style.context("dark_background"):
                _, (one, other) = pyplot.subplots(1, 2)
                numbers, settings = pyplot.get_fignums(), dict(matplotlib.rcParams)
                self.assertIs(plot(ax=one), one, name)
                self.assertEqual((pyplot.get_fignums(), dict(matplotlib.rcParams)), (numbers, settings))
                self.assertTrue(one.has_data() and not other.has_data())
                self.assertEqual(colors.to_hex(one.figure.get_facecolor()), "#000000")
                if name == "periodogram":
                    self.assertGreater(min(colors.to_rgb(one.get_lines()[1].get_color())), 0.5)
                    self.assertEqual(one.texts[0].get_bbox_patch().get_facecolor()[:3], (0, 0, 0))
        for wrong in (pyplot.figure(), pyplot.subplots(2)[1], "ax"):
            for plot in self.plots.values():
                with self.assertRaisesRegex(TypeError, "^ax is a (Figure|ndarray|str): must be one Axes of matplotlib"):
                    plot(ax=wrong)

    def test_a_failure_leaves_no_figure(self):
        from toliman.report import figures
        before = pyplot.get_fignums()
        with unittest.mock.patch.object(figures, "draw_power", side_effect=KeyboardInterrupt):
            with self.assertRaises(KeyboardInterrupt):
                self.periodogram.plot()
        with refused(toliman.StateError):
            toliman.Periodogram(0.1, 0.1, 5).plot()
        for f0, nf in ((0.1, 1), (0, 2)):
            with toliman.Periodogram(f0, 0.1, nf) as periodogram, refused(ValueError, "this"):
                periodogram.push_many(self.t, self.y)
                periodogram.plot()
        self.assertEqual(pyplot.get_fignums(), before)


class Matplotlib(unittest.TestCase):
    def test_it_is_imported_at_the_first_plot(self):
        code = ("import sys, toliman\ntoliman.period([1, 2, 3, 4, 5, 6], [1, 2, 1, 2, 1, 3])\n"
                "print([name for name in ('matplotlib', 'PIL', 'astropy', 'toliman.report') if name in sys.modules])")
        done = subprocess.run([sys.executable, "-c", code], env={**os.environ, "PYTHONPATH": str(PACKAGE)},
                              capture_output=True, text=True)
        self.assertEqual((done.stdout, done.stderr), ("[]\n", ""))

    def test_without_it(self):
        with unittest.mock.patch.dict(sys.modules, {"matplotlib": None}), self.assertRaises(ImportError) as raised:
            toliman.Measurements.of([1, 2], [3, 4]).plot()
        self.assertEqual(str(raised.exception), "matplotlib is needed for plots: install it (Debian: "
                                                "python3-matplotlib, pip: matplotlib)")


if __name__ == "__main__":
    unittest.main()
