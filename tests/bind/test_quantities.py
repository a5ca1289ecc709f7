"""Every number that a public function takes: a Quantity of another kind raises, one of the right kind is converted."""
import dataclasses
import functools
import inspect
import pathlib
import re
import tempfile
import unittest

import numpy

from package import toliman
from shown_objects import SCENE, T, TAI_NS, Y, estimate, objects
from toliman import _arguments

try:
    from astropy import units
except ImportError:
    units = None

NUMBER = re.compile(r"\b(float|int|ArrayLike|_Pair)\b")
# Arguments that take more than numbers, which their annotations do not name.
FURTHER = {"Measurements.of": ["exposures"], "Measurements.set_trend": ["span"], "suited_grid": [], "batch": ["span"],
           "planets": ["span"], "Periodogram": ["time_offset", "span"]}
EXPOSURES = numpy.stack([TAI_NS, TAI_NS + 1000], 1)


def wide_scene(side):
    telescope = {"aperture_m": 0.125, "secondary_m": 0.01875, "pupil_samples": 96, "mask": {
        "kind": "spiral", "edges": "cell", "opd_nm": 297.5,
        "terms": [{"a": 0.819, "f": 2.918, "m": -7, "p": 4.874}, {"a": 0.93, "f": 1.829, "m": 5}]}}
    return {**SCENE, "band": {"wavelength_nm": 580}, "telescope": telescope,
            "detector": {"shape": [side, side], "pixel_scale_arcsec": 0.2}}


@functools.lru_cache(maxsize=None)
def calls():
    """Each public function that takes numbers, by its name, and arguments that it accepts."""
    have = objects()
    simulator, fit, found, sky = have["simulator"], have["fit"], have["planets"], have["sky"]
    frames, seen = simulator.frames(0, 4), have["predictions"]["separation_arcsec"]
    large = toliman.Simulator(wide_scene(256))
    fit_256 = toliman.Fit(large)
    short = toliman.Fit(toliman.Simulator({**SCENE, "cadence": {**SCENE["cadence"], "exposure_s": 0.01}}))
    bank, network = toliman.Bank(fit_256, places=1), toliman.CAE(toliman.Simulator(wide_scene(128)))
    image, core = large.frame(0), numpy.ones((128, 128))
    series = {"t": T, "y": 1e6 * Y, "sigma": numpy.ones(40)}
    sample = {"t": 1.0, "y": 2.0, "sigma": 1.0}
    periodogram = toliman.Periodogram(0.01, 0.01, 9)
    periodogram.push_many(**series)
    measured = toliman.Measurements.of(**series).add_column("c", T)
    reduction = {"measured": EXPOSURES, "separations_arcsec": seen, "sigmas_arcsec": numpy.full(40, 1e-6)}
    components = toliman.Components(simulator)
    components.push(frames)
    grid = {"f0": 0.001, "df": 0.001, "nf": 50}
    collection = dict.fromkeys(("Bank.train", "Bank.from_bytes", "Bank.load", "CAE.load", "CAE.from_bytes"), ())
    predictions = {"times_days": numpy.zeros(4), "shifts": numpy.zeros((4, 2)), "separations": numpy.zeros(4),
                   "position_angles": numpy.zeros(4)}
    prediction = {"shift": (0, 0)}
    return {
        "Bank": (toliman.Bank, {"fit": fit_256}), "Bank.plan": (toliman.Bank.plan, {"simulator": large}),
        "Bank.encode_frame": (bank.encode_frame, {"frame": image, "window": numpy.zeros(2, int), **prediction}),
        "Bank.encode": (bank.encode, {"frames": image[None], "windows": numpy.zeros((1, 2), int),
                                      "shifts": [[0.0, 0.0]]}),
        "Bank.predict": (bank.predict, prediction), "Bank.renewal": (bank.renewal, {}), "CAE": (toliman.CAE, {
            "simulator": large}),
        "CAE.train": (network.train, {"mode": "unsupervised", "count": 20,
                                      "frames": lambda first, count: numpy.ones((count, 128, 128))}),
        "CAE.encode": (network.encode, {"frames": core, "windows": numpy.zeros((1, 2), int)}),
        "CAE.decode": (network.decode, {"latent": 0.0}), "CAE.reconstruct": (network.reconstruct, {"frame": core}),
        "Calibration.values": (have["calibration"].values, {}), "Calibration.opd": (have["calibration"].opd, {}),
        "Calibration.covariance": (have["calibration"].covariance, {}),
        "Calibration.save": (have["calibration"].save, {"path": "x.json"}),
        "Calibration.plot": (have["calibration"].plot, {}), "Calibration.plot_opd": (have["calibration"].plot_opd, {}),
        "Calibration.plot_correlations": (have["calibration"].plot_correlations, {}),
        "Coadd": (toliman.Coadd, {"fit": short, **prediction}),
        "Coadd.add": (toliman.Coadd(short).add, {"frame": frames[0].astype("u2"), "camera_ns": 0}),
        "Components": (toliman.Components, {"simulator": simulator}),
        "Components.push": (components.push, {"frames": frames}),
        "Components.train": (components.train, {}), "Components.series": (components.series, {}),
        "Fit": (toliman.Fit, {"simulator": simulator}),
        "Fit.of_windows": (toliman.Fit.of_windows, {"simulators": [simulator], "first_days": [0.0]}),
        "Fit.frame": (fit.frame, {"frame": frames[0], "window": numpy.zeros(2, int), **prediction}),
        "Fit.frames": (fit.frames, {"frames": frames, "windows": numpy.zeros((4, 2), int), **predictions}),
        "Fit.predict": (fit.predict, prediction),
        "Measurements": (toliman.Measurements, {"source": b"2030-01-01 1 1\n2030-01-02 1 1\n"}),
        "Measurements.of": (toliman.Measurements.of, {"position_angle_deg": T, "kind": "reduced", **series,
                                                      "exposures": EXPOSURES}),
        "Measurements.of_table": (toliman.Measurements.of_table, {"table": measured.to_table()}),
        "Measurements.set_trend": (measured.set_trend, {"order": 1, "span": (0.0, 2000.0)}),
        "Measurements.add_column": (measured.add_column, {"name": "d", "values": T}),
        "Measurements.set_prior": (measured.set_prior, {"function": 0, "sigma": 1.0}),
        "Periodogram": (toliman.Periodogram, {**grid, "columns": 1, "column_bounds": [1.0], "priors": [1.0, 1.0],
                                              "span": (0.0, 1.0)}),
        "Periodogram.push": (periodogram.push, sample), "Periodogram.retract": (periodogram.retract, sample),
        "Periodogram.push_many": (periodogram.push_many, series),
        "Periodogram.retract_many": (periodogram.retract_many, series), "Periodogram.fit": (periodogram.fit, series),
        "Periodogram.bootstrap": (periodogram.bootstrap, series), "Periodogram.power": (periodogram.power, {}),
        "Periodogram.peaks": (periodogram.peaks, {}), "Periodogram.aliases": (periodogram.aliases, {"frequency": 0.02}),
        "Periodogram.model": (periodogram.model, {"k": 1}),
        "Periodogram.coefficients": (periodogram.coefficients, {"k": 1}),
        "Periodogram.log10_fap": (periodogram.log10_fap, {"log10_residual": -1.0}),
        "Periodogram.threshold": (periodogram.threshold, {"log10_fap": -1.0}),
        "Periodogram.sampling": (periodogram.sampling, {"t": T}), "Planets.samples": (found.samples, {}),
        "Planets.signal": (found.signal, {"index": 0, "t": T, "position_angle_deg": T}),
        "Planets.limits": (found.limits, {"periods": [100.0]}), "Planets.plot_corner": (found.plot_corner, {}),
        "Planets.plot_folded": (found.plot_folded, {}), "Planets.plot_limits": (found.plot_limits, {"periods": [100.0]}),
        "Planets.inject": (found.inject, {"periods": (100.0, 200.0), "sizes": (1e-6, 2e-6)}),
        "Simulator": (toliman.Simulator, {"scene": SCENE}), "Simulator.budget": (simulator.budget, {}),
        "Simulator.series": (simulator.series, {}),
        "Simulator.opd_gradient": (simulator.opd_gradient, {"weights": frames[0]}),
        "Simulator.propagate": (simulator.propagate, {"displacement": 0.0}),
        "Simulator.frame": (simulator.frame, {"k": 0}), "Simulator.plot_frame": (simulator.plot_frame, {}),
        "Simulator.expect": (simulator.expect, {"displacement": 0.0}),
        "Simulator.frames": (simulator.frames, {"displacements": [0.0]}),
        "Simulator.expose": (simulator.expose, {"expected": frames[0]}), "Sky": (toliman.Sky, {}),
        "Sky.predict": (sky.predict, {"tai_ns": TAI_NS}),
        "Sky.predict_mean": (sky.predict_mean, {"intervals": EXPOSURES}),
        "Sky.predict_exposures": (sky.predict_exposures, {"tai_ns": EXPOSURES}), "Sky.reduce": (sky.reduce, reduction),
        "Sky.refit": (sky.refit, reduction), "Sky.diagnose": (sky.diagnose, reduction),
        "Sky.error_columns": (sky.error_columns, {}), "Template": (toliman.Template, {"simulator": simulator}),
        "Template.encode": (have["template"].encode, {"frames": frames, "windows": numpy.zeros((4, 2), int)}),
        "Tracker": (toliman.Tracker, {"estimator": estimate, "clock": numpy.zeros((2, 2), int), "span": (0.0, 1.0),
                                      "crop": (0, 0), "image_shape": (8, 6), **grid}),
        "Tracker.measurements": (have["tracker"].measurements, {}), "Tracker.records": (have["tracker"].records, {}),
        "Tracker.intervals": (have["tracker"].intervals, {"record": 0}), "batch": (toliman.batch, {
            **series, **grid, "rows": numpy.ones((40, 1)), "priors": [1.0, 1.0], "span": (0.0, 2000.0)}),
        "search_correlated": (toliman.search_correlated, {**series, "functions": T, "precision": [0.0]}),
        "bootstrap_correlated": (toliman.bootstrap_correlated, {**series, "rho": 0.1, "functions": T,
                                                                "precision": [0.0]}),
        "calibrate": (toliman.calibrate, {"simulator": simulator, "frames": frames, **predictions}),
        "design_mask": (toliman.design_mask, {"simulator": simulator, "dates": [2027.0], "position_angles": [3.0]}),
        "period": (toliman.period, {"t": T, "y": Y, "dy": Y**2}), "planets": (toliman.planets, {
            **series, "rows": T[:, None], "priors": [numpy.inf, 1.0, 1.0], "position_angle_deg": T, "trend": 1,
            "span": (0.0, 2000.0), "star_masses": (1.0, 1.0)}),
        "simulate": (toliman.simulate, {"scene": simulator}),
        "track": (toliman.track, {"scene": simulator, "frames": frames, "times": numpy.arange(4.0)}),
        "suited_grid": (toliman.suited_grid, {"t": T}), **collection,
    }


def functions():
    """Yields name and function of each public function, constructor and method."""
    for name in toliman.__all__:
        thing = getattr(toliman, name)
        if inspect.isfunction(thing):
            yield name, thing
        is_handle = inspect.isclass(thing) and hasattr(thing, "_create")
        for member, value in inspect.getmembers(thing, inspect.isroutine) if is_handle else ():
            if member == "__init__":
                yield name, value
            elif not member.startswith("_") and (inspect.isfunction(value) or inspect.ismethod(value)):
                yield f"{name}.{member}", value


def numbers_of(name, function):
    given = [one.name for one in inspect.signature(function).parameters.values() if NUMBER.search(str(one.annotation))]
    return given + FURTHER.get(name, [])


@unittest.skipIf(units is None, "needs astropy")
class Refused(unittest.TestCase):
    def refuses(self, name, member, function, given):
        """Whether the call names the wrong unit in its error."""
        value = given.get(member)
        wrong = (numpy.ones(numpy.shape(value)) if value is not None else 3) * units.kg
        with self.subTest(name, argument=member):
            with self.assertRaisesRegex((TypeError, ValueError), r"\bkg\b"):
                function(**{**given, member: wrong})

    def test_every_number(self):
        known, checked = calls(), 0
        for name, function in functions():
            members = numbers_of(name, function)
            if not members or name.startswith("Pair") or known.get(name) == ():
                continue
            self.assertIn(name, known, "has no entry in calls()")
            for member in members:
                self.refuses(name, member, *known[name])
                checked += 1
        self.assertGreater(checked, 230)

    def test_threads(self):
        """All functions with no other number convert it in the same way."""
        for member in ("threads", "seed"):
            with self.assertRaisesRegex(TypeError, r"\bkg\b"):
                _arguments.whole(member, 3 * units.kg)

    def test_members(self):
        have = objects()
        for member in ("sigma", "exposure_s", "intervals", "frame_id", "camera_ns", "dropped", "restarts"):
            frame = dataclasses.replace(have["frame"], **{member: numpy.ones((2, 2) if member == "intervals" else ())
                                                          * units.kg})
            with self.assertRaisesRegex((TypeError, ValueError), r"\bkg\b", msg=member):
                have["tracker"].push(frame)
        for member in ("frames", "xx", "yy", "xy"):
            with self.assertRaisesRegex(TypeError, r"\bkg\b", msg=member):
                have["fit"].predict(spread=toliman.Spread(**{member: 3 * units.kg}))
        with tempfile.TemporaryDirectory() as folder:
            for more in ({"exposure_s": 3 * units.kg}, {"rows": 3 * units.kg}):
                with self.assertRaisesRegex((TypeError, ValueError), r"\bkg\b"):
                    toliman.Pair(pathlib.Path(folder) / "x", **more)

    def test_masks_of_columns_with_a_unit(self):
        """Which their conversion would drop."""
        from astropy.table import MaskedColumn
        from astropy.utils.masked import Masked
        have = objects()
        for unit, call in (
                ("arcsec", lambda values: have["sky"].reduce(EXPOSURES[:3], values, [1e-6] * 3)),
                ("deg", lambda values: toliman.Measurements.of([1, 2, 3], [1, 2, 3], position_angle_deg=values)),
                ("d", lambda values: have["fit"].frames(have["simulator"].frames(0, 3), times_days=values))):
            with self.assertRaisesRegex(ValueError, "masked"):
                call(MaskedColumn([1.0, 2.0, 3.0], mask=[False, True, False], unit=unit))
        for one in Masked(3 * units.s, mask=True), numpy.ma.masked:
            with self.assertRaisesRegex(ValueError, "masked"):
                _arguments.real("exposure_s", one)

    def test_durations_are_no_numbers(self):
        with self.assertRaisesRegex(TypeError, "^exposure_s is a timedelta64"):
            toliman.Measurements(b"1 2\n", exposure_s=numpy.timedelta64(60, "s"))


@unittest.skipIf(units is None, "needs astropy")
class Converted(unittest.TestCase):
    def test_one_number(self):
        for name, value, number in (
                ("exposure_s", 2 * units.min, 120), ("window_days", 12 * units.h, 0.5),
                ("altitude_km", 6e5 * units.m, 600), ("parallax_arcsec", 750 * units.mas, 0.75),
                ("position_angle_deg", numpy.pi * units.rad, 180),
                ("map_rms_nm", 1e-8 * units.m, 10), ("unit_ns", 1 * units.s, 1e9), ("node_hours", 1 * units.d, 24)):
            self.assertAlmostEqual(_arguments.real(name, value), number, delta=1e-12 * number)
            numpy.testing.assert_allclose(_arguments.plain(name, [value, value]), [number] * 2, rtol=1e-12)
        for name in ("capture_px", "probability", "sigma", "unit"):
            for unit in (units.pix, units.d, units.dimensionless_unscaled):
                with self.assertRaises(TypeError):
                    _arguments.real(name, 1 * unit)

    def test_calls(self):
        have = objects()
        fit, sky = have["fit"], have["planets"]
        for one, other in (
                (fit.predict(time_days=12 * units.h, separation=10, position_angle=0.5 * units.rad)[0],
                 fit.predict(time_days=0.5, separation=10, position_angle=numpy.degrees(0.5))[0]),
                (sky.limits([0.5, 1] * units.yr)["upper"], sky.limits([182.625, 365.25])["upper"]),
                (toliman.Sky("alpha-cen", altitude_km=6e5 * units.m).predict(TAI_NS)["factor"],
                 have["predictions"]["factor"])):
            numpy.testing.assert_allclose(one, other, rtol=1e-12, atol=1e-9 * numpy.abs(other).max())
        for period_min in (70, 70 * units.d, 70 * 24 * units.h):
            found = toliman.planets(have["measurements"], period_min=period_min, amplitude_min=0.1 * units.uarcsec,
                                    amplitude_max=1e-4, samples=100, threads=1)
            self.assertAlmostEqual(found.info.period_min, 70, delta=1e-9)
            self.assertAlmostEqual(found.info.amplitude_min, 1e-7, delta=1e-18)
        grid = toliman.suited_grid(T, 4000)
        for t, mission_span in ((T * units.d, 4000 * units.d), (T * units.d, 4000), (24 * T * units.h, 96000 * units.h)):
            numpy.testing.assert_allclose(toliman.suited_grid(t, mission_span), grid, rtol=1e-9)
        with self.assertRaisesRegex(TypeError, "^mission_span is in d: give plain numbers"):
            toliman.suited_grid(T, 4000 * units.d)
        hours = toliman.Measurements.of(24 * T, Y, 1e-6, time_unit_days=1 / 24)
        for name, call in (("t", lambda: toliman.planets(T * units.d, Y, 1e-6, time_unit_days=1 / 24)),
                           ("t", lambda: toliman.Measurements.of(T * units.d, Y, 1e-6, time_unit_days=1 / 24)),
                           ("span", lambda: hours.set_trend(1, (0 * units.d, 2000 * units.d)))):
            with self.assertRaisesRegex(ValueError, f"^{name}: must be plain numbers in units of 0.0416667 days"):
                call()


if __name__ == "__main__":
    unittest.main()
