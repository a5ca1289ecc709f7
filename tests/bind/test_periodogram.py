"""Tests the Python periodogram: sigmas, arguments, states, limits and false alarms."""
import json
import os
import pathlib
import subprocess
import tempfile
import unittest
import warnings

import numpy
from astropy.timeseries import LombScargle

from package import toliman
from refusal import refused
from toliman import AccuracyWarning, Error, Periodogram, suited_grid

t = numpy.arange(200.0)
y = 1e-3 * numpy.sin(2 * numpy.pi * t / 17)
sigma = numpy.where(t % 2 == 0, 1e-3, 2e-3)
GRID = {"f0": 0.01, "df": 0.001, "nf": 400}


class SmallSigmas(unittest.TestCase):
    def test_bounds_from_the_sigmas(self):
        with Periodogram(*suited_grid(t), sigma_floor=min(sigma), sigma_ceiling=max(sigma)) as periodogram:
            periodogram.push_many(t, y, sigma)
            self.assertRegex(str(periodogram.fit(t, y, sigma)), r"(?m)^period +(16\.9999|17$|17\.0000)")


class Arguments(unittest.TestCase):
    def test_masks_and_units_are_not_dropped(self):
        class Quantity(numpy.ndarray):
            unit = "d"

        with Periodogram(**GRID) as periodogram:
            with refused(ValueError, "y"):
                periodogram.push_many(t, numpy.ma.masked_greater(y, 0))
            with refused(TypeError, "t"):
                periodogram.push_many(t.view(Quantity), y)
            self.assertEqual(len(periodogram), 0)
            periodogram.push_many(numpy.ma.array(t, mask=False), y)
            self.assertEqual(len(periodogram), 200)
            with refused(ValueError, "normalisation"):
                periodogram.power("lombscargle")
            with refused(ValueError, "method"):
                periodogram.log10_fap(-1, "davies")
        with self.assertRaises(TypeError):
            Periodogram(0.01, 0.001, 400.5)
        self.assertEqual(Periodogram(0.01, 0.001, 400.0).info.nf, 400)

    def test_one_sigma_for_all(self):
        powers = []
        for errors in (2.0, numpy.full(200, 2.0)):
            with Periodogram(**GRID) as periodogram:
                periodogram.push_many(t, y, errors)
                powers.append(periodogram.power())
        self.assertTrue((powers[0] == powers[1]).all())

    def test_inaccurate_powers_raise_a_warning(self):
        """A thousandth of a cycle in one night, and less."""
        night = 2460000.3 + 0.35 * t / t.size
        grid = {"f0": 1e-4, "df": 1e-4, "nf": 30, "time_offset": night[0]}
        values = numpy.sin(5 * t / t.size) + 0.1 * numpy.cos(31 * t)
        with Periodogram(**grid) as narrow, Periodogram(**grid, double_limb=True) as wide, \
             Periodogram(*suited_grid(t)) as even, warnings.catch_warnings(record=True) as found:
            warnings.simplefilter("always")
            for periodogram, times in ((narrow, night), (wide, night), (even, t)):
                periodogram.push_many(times, values)
                queries = (periodogram.power, periodogram.peak, periodogram.peaks, lambda: periodogram.model(0),
                           lambda: periodogram.fit(times, values))
                for query in queries:
                    found.clear()
                    query()
                    if periodogram is narrow:
                        self.assertEqual([(one.category, one.filename) for one in found], [(AccuracyWarning, __file__)])
                        self.assertIn("double_limb=True", str(found[0].message))
                    else:
                        self.assertEqual(found, [])
            self.assertTrue(narrow.peak().inaccurate and narrow.sampling().inaccurate and narrow.model(0).inaccurate)
            self.assertFalse(even.sampling().inaccurate or wide.sampling().inaccurate)

    def test_double_limb_sums_keep_their_digits(self):
        """A hundredth of a cycle in total, against a parabola: a sinusoid cannot be distinguished from it."""
        small = {"f0": 1e-6, "df": 1e-6, "nf": 2}
        values = numpy.cos(0.3 * t)
        with Periodogram(**small, double_limb=True) as wide, Periodogram(**small) as narrow:
            for periodogram in (wide, narrow):
                periodogram.push_many(t, values)
            x = numpy.polynomial.Legendre.fit(t, values, 2)
            expected = 1 - ((values - x(t)) ** 2).sum() / ((values - values.mean()) ** 2).sum()
            self.assertAlmostEqual(wide.power()[0] / expected, 1, delta=1e-4)
            self.assertTrue(narrow.sampling().needs_double_limb)
            self.assertFalse(wide.sampling().needs_double_limb)


    def test_numbers_of_other_types(self):
        class Quantity(float):
            unit = "d"
        with Periodogram(**GRID) as periodogram:
            for bad, why in (((Quantity(1), 1), "t"), ((1, None), "y"),
                             ((t, 1), "t"), (("2020-01-01", 1), "t")):
                with refused(TypeError, why):
                    periodogram.push(*bad)
            for bad in (t.astype("m8[D]"), t.astype(str)):
                with refused(TypeError, "t"):
                    periodogram.push_many(bad, y)
            with refused(ValueError, "t"):
                periodogram.push_many(numpy.arange(200) + 2**53, y)
            for bad in (2**63, -2**63 - 1):
                with refused(ValueError, "t"):
                    periodogram.push(bad, 0, ns=True)
            self.assertEqual(len(periodogram), 0)
            periodogram.push(numpy.float32(1), numpy.array(2.0))
            periodogram.push(2**63 - 1, 0, ns=True)
            with refused(ValueError, "path"):
                periodogram.save("/nowhere/a\0b")
            with refused(TypeError, "other"):
                periodogram.merge(None)
        with refused(ValueError, "time_offset_ns"):
            Periodogram(**GRID, time_offset_ns=2**64)

    def test_push_with_all_time_types(self):
        """Floats, pairs and nanoseconds give the same sums; mixed sigmas and a sigma of 0 are refused."""
        with Periodogram(**GRID) as plain, Periodogram(**GRID) as other, Periodogram(**GRID) as none:
            plain.push_many(t[:20].round(), y[:20])
            for k in range(20):
                whole = int(t[k].round())
                other.push(whole * 10**9, y[k], ns=True) if k % 2 else other.push(whole - 0.5, y[k], t_low=0.5)
            self.assertEqual(plain.to_bytes(), other.to_bytes())
            with refused(toliman.StateError, "sigma"):
                plain.push(1.0, 2.0, 3.0)
            with refused(ValueError, "sigma"):
                plain.push(1.0, 2.0, 0)
            other.retract(int(t[1].round()) * 10**9, y[1], ns=True)
            other.retract(t[2].round() - 0.5, y[2], t_low=0.5)
            plain.retract_many(t[1:3].round(), y[1:3])
            self.assertEqual(plain.to_bytes(), other.to_bytes())
            plain.retract_many(numpy.delete(t[:20], [1, 2]).round(), numpy.delete(y[:20], [1, 2]))
            self.assertEqual(plain.to_bytes(), none.to_bytes())

    def test_period_in_one_call(self):
        """Against astropy on the same grid, and the fit of a Periodogram."""
        random = numpy.random.default_rng(3)
        t = 2460000 + numpy.sort(random.uniform(0, 200, 150))
        dy = random.uniform(0.5, 2, t.size)
        y = 40 + 3 * numpy.sin(2 * numpy.pi * t / 17.3) + random.normal(0, dy)
        found = toliman.period(t, y, dy)
        self.assertLess(abs(found.period - 17.3), 4 * found.period_error)
        self.assertLess(found.log10_fap, -20)
        grid = suited_grid(t)
        power = LombScargle(t, y, dy).power(grid.f0 + grid.df * numpy.arange(grid.nf))
        best = grid.f0 + grid.df * int(power.argmax())
        self.assertLess(abs(found.frequency - best), grid.df)
        self.assertFalse(toliman.period(t, y).at_edge)
        with self.assertRaises(toliman.StateError):
            toliman.period([1, 1, 1], [1, 2, 3])
        with self.assertRaises(ValueError):
            toliman.period(t, y, -dy)

    def test_suggested_grid(self):
        """The same as the program's for the same times."""
        for times in (numpy.arange(1095.0), numpy.sort(numpy.random.default_rng(1).uniform(0, 50, 70))):
            with tempfile.TemporaryDirectory() as folder:
                numpy.savetxt(f"{folder}/a.csv", numpy.stack([times, numpy.sin(times)], 1), delimiter=",", fmt="%.17g")
                output = json.loads(subprocess.run([os.environ["TOLIMAN"], "period", f"{folder}/a.csv", "--json"], check=True,
                                                   capture_output=True, text=True).stdout)
            grid = suited_grid(times[::-1])
            self.assertEqual(grid.nf, output["grid"]["nf"])
            self.assertAlmostEqual(grid.f0 / output["grid"]["f0"], 1, delta=1e-15)
            self.assertAlmostEqual(grid.df / output["grid"]["df"], 1, delta=1e-15)
            Periodogram(*grid).close()
        for bad, why in (([1.0], "t"), ([2.0, 2.0], "t"), ([0, numpy.nan], "t")):
            with refused(Error, why):
                suited_grid(bad)
        self.assertEqual(suited_grid([], 1095), suited_grid(numpy.arange(1095.0)))

    def test_bootstrap_reports_progress(self):
        seen = []
        with Periodogram(**GRID) as periodogram:
            periodogram.push_many(t, y)
            periodogram.bootstrap(t, y, count=20, progress=lambda stage, fraction: seen.append(fraction))
        self.assertGreater(len(seen), 1)


class Normalisations(unittest.TestCase):
    def test_against_astropy(self):
        random = numpy.random.default_rng(2)
        times = numpy.sort(random.uniform(0, 300, 120))
        errors = random.uniform(0.3, 2, 120)
        values = 5 + numpy.sin(0.7 * times) + errors * random.normal(size=120)
        frequency = GRID["f0"] + GRID["df"] * numpy.arange(GRID["nf"])
        for fit_mean in (True, False):
            with Periodogram(**GRID, fit_mean=fit_mean, value_offset=5, value_bound=32, sigma_floor=0.3) as ours:
                ours.push_many(times, values, errors)
                for name in ("standard", "model", "log", "psd"):
                    peer = LombScargle(times, values, errors, fit_mean=fit_mean, normalization=name)
                    numpy.testing.assert_allclose(ours.power(name), peer.power(frequency, method="slow"), rtol=1e-9,
                                                  atol=1e-9)
                with self.assertRaises(ValueError):
                    ours.power("loud")


class Handle(unittest.TestCase):
    def made(self, **options):
        periodogram = Periodogram(**GRID, sigma_floor=1e-3, **options)
        self.addCleanup(periodogram.close)
        periodogram.push_many(t, y, sigma)
        return periodogram

    def test_sigma_below_its_floor(self):
        with Periodogram(**GRID) as periodogram:
            with refused(Error, "sigma"):
                periodogram.push_many(t, y, sigma)

    def test_edge(self):
        self.assertFalse(self.made().fit(t, y, sigma).at_edge)
        with Periodogram(0.06, 0.0005, 5, sigma_floor=1e-3) as periodogram:
            periodogram.push_many(t, y, sigma)
            self.assertTrue(periodogram.fit(t, y, sigma).at_edge)
            self.assertTrue(periodogram.peak().at_edge)

    def test_saved_and_loaded(self):
        first = self.made()
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "state.tlmp"
            first.save(path)
            with Periodogram.load(path) as second:
                self.assertEqual((len(second), second.info.nf), (200, 400))
                self.assertTrue((second.power() == first.power()).all())
                for one in (first, second):
                    one.push(200.0, 0.0, 0.02)
                    with refused(toliman.StateError, "sigma"):
                        one.push(201.0, 0.0)
                self.assertTrue((second.power() == first.power()).all())
            path.write_bytes(b"no state")
            with refused(Error, path):
                Periodogram.load(path)

    def test_fap(self):
        periodogram = self.made()
        peak = periodogram.peak()
        self.assertAlmostEqual(periodogram.log10_fap(peak.log10_residual), peak.log10_fap, delta=1e-12)
        self.assertEqual(periodogram.log10_fap(0.0), 0.0)


if __name__ == "__main__":
    unittest.main()
