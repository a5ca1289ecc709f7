"""Scenes with an observer, end to end: the stars are simulated where the observer sees them, their separation is measured
with the fit, and reduced to what a planet changes. Refits of the orbit."""
import copy
import json
import logging
import pathlib
import tempfile
import unittest

import numpy

from package import toliman
from refusal import refused

DAY, SECOND, SCALE = 86400 * 10**9, 10**9, 0.75
TIMES = numpy.arange(0, 1095, 27.4)
SCENE = {
    "schema": "toliman-scene/1",
    "telescope": {"aperture_m": 0.0625, "pupil_samples": 48,
                  "mask": {"kind": "spiral", "opd_nm": 292.5, "edges": "area", "terms": [{"a": 1, "f": 1.2, "m": -5, "p": 1}]}},
    "band": {"min_nm": 530, "max_nm": 640, "step_nm": 55},
    "stars": {"A": {"spectrum": {"kind": "blackbody", "temperature_k": 5790}, "photons_per_s": 7.5e7},
              "B": {"spectrum": {"kind": "blackbody", "temperature_k": 5260}, "photons_per_s": 2.5e7}},
    "binary": {"orbit": "alpha-cen", "date": 2027.0, "moving": True},
    "cadence": {"times_days": TIMES.tolist(), "exposure_s": 60},
    "detector": {"shape": [48, 48], "pixel_scale_arcsec": SCALE},
    "noise": {"photon": False},
    "accuracy": 1e-10,
}
# On target for 30 minutes in each of 8 orbits of 96.7 minutes, in the first half of an exposure of a day.
ARCS = [[5800.0 * i, 5800.0 * i + 1800] for i in range(8)]


def setUpModule():
    logging.getLogger("toliman").setLevel(logging.ERROR)


def scene_with(**groups):
    scene = copy.deepcopy(SCENE)
    for name, keys in groups.items():
        scene.setdefault(name, {}).update(keys)
    return scene


def measure(scene):
    """Measured separations (arcsec) of the scene's frames, by a model that knows no observer; TAI of the frames."""
    simulator = toliman.Simulator(scene)
    model = copy.deepcopy(scene)
    model["binary"]["observer"] = "none"
    found = toliman.Fit(toliman.Simulator(model), capture_px=1).frames(simulator.frames(), times_days=TIMES)
    tai_ns = simulator.info.time_zero_ns + numpy.round(TIMES * DAY).astype(numpy.int64)
    return found["separation_px"] * SCALE, tai_ns


def reduce(measured, seen):
    """Separations minus the geometric ones, uas."""
    return (measured / [one.factor for one in seen] - [one.geometric_arcsec for one in seen]) * 1e6


class Observers(unittest.TestCase):
    def test_frames_show_what_the_observer_sees(self):
        for observer, sky in (("earth", toliman.Sky()), ({"altitude_km": 600}, toliman.Sky(altitude_km=600)),
                              ({"altitude_km": 800, "node_hours": 10.5}, toliman.Sky(altitude_km=800, node_hours=10.5))):
            with self.subTest(observer=observer):
                measured, tai_ns = measure(scene_with(binary={"observer": observer}))
                seen = [sky.predict_mean([time - 30 * SECOND, time + 30 * SECOND]) for time in tai_ns]
                self.assertLess(numpy.abs(measured - [one.separation_arcsec for one in seen]).max() * 1e6, 0.03)
                self.assertLess(numpy.abs(reduce(measured, seen)).max(), 0.03)
                self.assertGreater(numpy.ptp([one.factor for one in seen]) * 1e7, 1000)  # uas at 10 arcsec

    def test_arcs_of_a_day(self):
        """Means over the intervals on target; the middle of the exposure alone is wrong by up to 250 uas."""
        flat = [number for arc in ARCS for number in arc]
        measured, tai_ns = measure(scene_with(binary={"observer": {"altitude_km": 600}},
                                              cadence={"exposure_s": 86400, "on_target_s": flat}))
        sky = toliman.Sky(altitude_km=600)
        starts = (numpy.array(ARCS) - 43200) * SECOND
        seen = [sky.predict_mean(time + starts.astype(numpy.int64)) for time in tai_ns]
        self.assertLess(numpy.abs(reduce(measured, seen)).max(), 0.03)
        middle = sky.predict(tai_ns)
        wrong = (measured / middle["factor"] - middle["geometric_arcsec"]) * 1e6
        self.assertGreater(numpy.abs(wrong).max(), 50)

    def test_the_light_is_that_of_the_intervals(self):
        whole, part = (toliman.Simulator(scene_with(cadence={"exposure_s": 100, **more})).info.total_photons
                       for more in ({}, {"on_target_s": [0, 10, 40, 55]}))
        self.assertAlmostEqual(part / whole, 0.25, places=12)

    def test_windows_are_those_of_each_exposure(self):
        """Places and light of a frame are those of a scene with the parts of the windows that are in this exposure."""
        days, zero = [0.0, 1.0, 2.5], toliman.Simulator(SCENE).info.time_zero_ns
        starts = [zero + round((day - 0.5) * 86400) * SECOND for day in days]
        arcs = [(starts[0] - 3000 * SECOND, starts[0] + 2000 * SECOND), (starts[0] + 9000 * SECOND, starts[0] + 12000 * SECOND),
                (starts[1] - 1000 * SECOND, starts[1] + 500 * SECOND), (starts[2] + 80000 * SECOND, starts[2] + 90000 * SECOND)]
        parts = [[0, 2000, 9000, 12000, 85400, 86400], [0, 500], [80000, 86400]]
        low = scene_with(binary={"observer": {"altitude_km": 600}}, cadence={"exposure_s": 86400})
        with tempfile.TemporaryDirectory() as folder:
            table = pathlib.Path(folder) / "windows.csv"
            table.write_text("start_tai_ns,end_tai_ns\n" + "".join(f"{start},{end}\n" for start, end in arcs))

            def simulator(**cadence):
                scene = copy.deepcopy(low)
                scene["cadence"].update(cadence)
                return toliman.Simulator(scene, folder=folder)

            with_windows = simulator(times_days=days, on_target="windows.csv")
            frames, total = with_windows.frames(), with_windows.info.total_photons
            for frame, day, part in zip(frames, days, parts):
                alone = simulator(times_days=[day], on_target_s=part)
                numpy.testing.assert_allclose(frame, alone.frame(0), atol=1e-8 * frame.max(), rtol=0)
            seconds = [sum(part[1::2]) - sum(part[::2]) for part in parts]
            self.assertAlmostEqual(total / simulator(times_days=days).info.total_photons, seconds[0] / 86400, places=12)
            seen = toliman.Fit(with_windows).predict(time_days=1.0)[1][0]
            self.assertAlmostEqual(seen, toliman.Fit(simulator(times_days=[1.0], on_target_s=parts[1])).predict(time_days=1.0)[1][0],
                                   places=11)
            beyond = toliman.Fit(with_windows).predict(time_days=5.0)[1][0]  # no window: as if all of it were on target
            self.assertAlmostEqual(beyond, toliman.Fit(simulator(times_days=[5.0])).predict(time_days=5.0)[1][0], places=11)
            self.assertEqual(simulator(times_days=[0.0, 5.0], on_target="windows.csv").frame(1).max(), 0)
            digest = toliman.Fit(with_windows).info.digest
            table.write_text(table.read_text() + f"{arcs[-1][1]},{arcs[-1][1] + SECOND}\n")  # grows
            self.assertEqual(toliman.Fit(simulator(times_days=days, on_target="windows.csv")).info.digest, digest)
            for change, key in (({"on_target_s": [0, 10]}, "cadence.on_target"), ({"times_days": [9.0]}, "cadence.on_target"),
                                ({"on_target": "none.csv"}, pathlib.Path(folder) / "none.csv")):
                with refused(toliman.Error, key):
                    simulator(**{"times_days": days, "on_target": "windows.csv", **change})
            low["binary"]["moving"] = False
            del low["binary"]["observer"]
            with refused(toliman.Error, "cadence.on_target"):
                simulator(times_days=days, on_target="windows.csv")

    def test_a_planet_is_recovered(self):
        """1.2 uas in noise-free frames of a moving, aberrated binary: the amplitude is right to 0.03 uas."""
        planet = {"kind": "sinusoid", "star": "A", "amplitude_px": 1.2e-6 / SCALE, "period_days": 250, "phase_rad": 0.7}
        scene = scene_with(binary={"observer": {"altitude_km": 600}}, signal=planet)
        measured, tai_ns = measure(scene)
        sky = toliman.Sky(altitude_km=600)
        reduced = reduce(measured, [sky.predict_mean([time - 30 * SECOND, time + 30 * SECOND]) for time in tai_ns])
        phase = 2 * numpy.pi * TIMES / 250
        columns = numpy.transpose([numpy.ones_like(phase), numpy.sin(phase), numpy.cos(phase)])
        _, sine, cosine = numpy.linalg.lstsq(columns, reduced, rcond=None)[0]
        self.assertAlmostEqual(numpy.hypot(sine, cosine), 1.2, delta=0.03)
        self.assertAlmostEqual(numpy.arctan2(cosine, sine), 0.7, delta=0.03)

    def test_scenes_without_an_observer_are_as_before(self):
        plain = toliman.Simulator(SCENE).frames(0, 2)
        numpy.testing.assert_array_equal(plain, toliman.Simulator(scene_with(binary={"observer": "none"})).frames(0, 2))

    def test_time_zero(self):
        """2027.0 in Julian years of TT is JD 2461406.75; stars at rest have no date."""
        for binary in ({"observer": "earth"}, {}):
            info = toliman.Simulator(scene_with(binary=binary)).info
            self.assertEqual(info.time_zero_ns, toliman.parse_time("2461406.75", "jd", "tt"))
        for binary in ({"moving": False}, {"date": 1000.0}):
            self.assertEqual(toliman.Simulator(scene_with(binary=binary)).info.time_zero_ns, 0)

    def test_a_bank_follows_the_orbit(self):
        """The spacecraft's aberration, 1e-3 px every 97 minutes, needs no networks of its own."""
        def networks(observer):
            scene = scene_with(binary={"observer": observer}, detector={"shape": [256, 256]}, telescope={"pupil_samples": 128})
            return toliman.Bank.plan(toliman.Simulator(scene), last_days=365, spacing_px=0.05).networks

        counts = {networks(observer) for observer in ("none", "earth", {"altitude_km": 600})}
        self.assertEqual(len(counts), 1, counts)

    def test_the_exposure_belongs_to_the_fit(self):
        def fit(**cadence):
            scene = scene_with(binary={"observer": {"altitude_km": 600}}, cadence=cadence)
            return toliman.Fit(toliman.Simulator(scene), capture_px=1).info.digest
        self.assertEqual(fit(on_target_s=[0, 10]), fit(on_target_s=[0, 10]))
        self.assertNotEqual(fit(on_target_s=[0, 10]), fit(on_target_s=[50, 60]))

    def test_a_system_file_is_an_orbit(self):
        with tempfile.TemporaryDirectory() as folder:
            toliman.Sky().save(pathlib.Path(folder) / "system.json")
            by_file = scene_with(binary={"orbit": "system.json", "observer": "earth"})
            (pathlib.Path(folder) / "scene.json").write_text(json.dumps(by_file))
            frames = toliman.Simulator(pathlib.Path(folder) / "scene.json").frames(3, 1)
        numpy.testing.assert_array_equal(frames, toliman.Simulator(scene_with(binary={"observer": "earth"})).frames(3, 1))

    def test_mistakes(self):
        elements = {name: value for name, (value, _) in toliman.Sky().elements.items()}
        for name, groups in (
                ("binary.observer", {"binary": {"observer": "moon"}}),
                ("binary.observer", {"binary": {"observer": "earth", "moving": False}}),
                ("binary.observer", {"binary": {"observer": "earth", "orbit": elements}}),
                ("binary.observer.altitude_km", {"binary": {"observer": {"altitude_km": 100}}}),
                ("./missing.oem", {"binary": {"observer": {"file": "missing.oem"}}}),
                ("binary.observer.altitude_km", {"binary": {"observer": {"file": "a.oem", "altitude_km": 600}}}),
                ("binary.date", {"binary": {"observer": "earth", "date": 1850}}),
                ("./missing.json", {"binary": {"orbit": "missing.json"}}),
                ("cadence.on_target_s", {"cadence": {"on_target_s": [0, 10, 20]}}),
                ("cadence.on_target_s", {"cadence": {"on_target_s": [0, 10, 10, 20]}}),
                ("cadence.on_target_s", {"cadence": {"on_target_s": [0, 61]}})):
            with self.subTest(name), refused(toliman.Error, name):
                toliman.Simulator(scene_with(**groups))


def low_orbit(tai_ns, altitude=600e3, hours=18):
    """Circular sun-synchronous orbit along the axes of the ICRS: position (m) and velocity (m/s)."""
    seconds = (tai_ns - toliman.parse_time("2000-01-01T12:00:00", scale="tt")) / SECOND
    radius, gm, days = 6378137 + altitude, 3.986004418e14, seconds / 86400
    rate = numpy.sqrt(gm / radius**3)
    flat = -2 * numpy.pi / (365.2422 * 86400) * 2 * radius**2 / (3 * 1.0826e-3 * 6378137**2 * rate)
    node = numpy.radians(280.46) + 2 * numpy.pi * ((hours - 12) / 24 + days / 365.2422)
    along = numpy.array([numpy.cos(node), numpy.sin(node), 0 * node])
    across = numpy.array([-flat * numpy.sin(node), flat * numpy.cos(node), numpy.sqrt(1 - flat**2) + 0 * node])
    angle = rate * seconds
    place = radius * (numpy.cos(angle) * along + numpy.sin(angle) * across)
    turning = 2 * numpy.pi / (365.2422 * 86400) * numpy.array([-place[1], place[0], 0 * node])  # of the orbit's plane
    return place.T, (radius * rate * (numpy.cos(angle) * across - numpy.sin(angle) * along) + turning).T


class Files(unittest.TestCase):
    """Observer files, from the text to predictions and frames: the states of an orbit that is known otherwise."""

    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.folder.cleanup)
        cls.path = pathlib.Path(cls.folder.name) / "low.csv"
        cls.start = toliman.parse_time("2027-01-01T11:00:00", scale="tt")  # date 2027.0 is at 6 h of this day, TT
        cls.start -= 6 * 3600 * SECOND
        times = cls.start + 60 * SECOND * numpy.arange(240)
        place, velocity = low_orbit(times)
        rows = numpy.c_[place / 1e3, velocity / 1e3]
        cls.path.write_text("t_tai_ns,x_km,y_km,z_km,vx_km_s,vy_km_s,vz_km_s\n" + "".join(
            f"{time}," + ",".join(repr(float(number)) for number in row) + "\n" for time, row in zip(times, rows)))
        cls.sky, cls.times = toliman.Sky(observer=cls.path), times

    def test_predictions(self):
        inside = self.times[10:-10:7] + 17 * SECOND
        file, computed = self.sky.predict(inside), toliman.Sky(altitude_km=600).predict(inside)
        for name in ("separation_arcsec", "geometric_arcsec", "factor"):
            self.assertLess(numpy.abs(file[name] - computed[name]).max(), 1e-9, name)  # 1e-3 uas
        self.assertGreater(numpy.ptp(file["separation_arcsec"]), 400e-6)
        info = self.sky.info
        self.assertEqual((info.observer, info.segments, info.first_ns, info.last_ns),
                         ("file", 1, self.times[0], self.times[-1]))

    def test_means_need_all_states(self):
        end = int(self.times[-1])
        self.assertFalse(numpy.isnan(self.sky.predict_mean([end - 600 * SECOND, end]).factor))
        self.assertTrue(numpy.isnan(self.sky.predict_mean([end - 600 * SECOND, end + 1]).factor))
        with refused(toliman.Error, self.path):
            self.sky.predict(end + SECOND)

    def test_reduction(self):
        """Measurements without a state of the spacecraft are left out, the others reduced by their means."""
        starts = self.times[0] + numpy.array([[300], [-86400], [6000], [400000]]) * SECOND
        exposures = starts + numpy.array([0, 120]) * SECOND
        reduced, seen = self.sky.reduce(exposures, 9.8), self.sky.predict_exposures(exposures)
        expected = [self.sky.predict_mean(exposures[i]) for i in (0, 2)]
        self.assertEqual((len(reduced), reduced.info.left_out), (2, 2))
        self.assertEqual(reduced.y.tolist(), [9.8 / one.factor - one.geometric_arcsec for one in expected])
        self.assertEqual(reduced.values("factor").tolist(), [one.factor for one in expected])
        self.assertEqual(reduced.tai_ns.tolist(), exposures[[0, 2]].mean(1).astype(int).tolist())
        for name in seen.dtype.names:
            self.assertTrue(numpy.isnan(seen[name][[1, 3]]).all(), name)
        self.assertEqual(seen["factor"][[0, 2]].tolist(), [one.factor for one in expected])
        with refused(toliman.InputError, "intervals"):
            self.sky.reduce(starts[:, 0], 9.8)
        long = exposures[:1, :1] + numpy.array([0, 900]) * SECOND
        for more in ({}, {"on_target": False}):
            with refused(toliman.InputError, "intervals"):
                self.sky.reduce(long, 9.8, **more)
            with refused(toliman.InputError, "intervals"):
                self.sky.refit(long, 9.8, 1, **more)
        for known in ({"tai_ns": long, "on_target": True}, {"tai_ns": long[:, None]}):
            self.assertEqual(self.sky.predict_exposures(**known)["factor"][0],
                             self.sky.predict_mean(long).factor)
        with refused(ValueError, "tai_ns"):
            self.sky.reduce([exposures[0], exposures[:2]], 9.8)
        self.assertEqual(self.sky.refit(exposures, 9.8, 1)[1].left_out, 2)
        with refused(toliman.InputError, "measured"):
            self.sky.refit(exposures[[1, 3]], 9.8, 1)
        with refused(ValueError, "on_target=False"):
            self.sky.reduce([exposures[:2]], 9.8, on_target=False)
        with refused(toliman.InputError, "time"):  # not a matter of the file
            self.sky.reduce([[-(2**62), 1 - 2**62]], 9.8, on_target=True)
        with refused(toliman.InputError, "measured"):
            self.sky.reduce([], [])

    def test_scenes(self):
        """A relative path in a scene, whose time 0 is within the file."""
        frames = []
        for observer in ({"file": "low.csv"}, {"altitude_km": 600}):
            scene = scene_with(binary={"observer": observer}, cadence={"times_days": [0, 0.02, 0.04]})
            path = pathlib.Path(self.folder.name) / "scene.json"
            path.write_text(json.dumps(scene))
            frames.append(toliman.Simulator(path).frames())
        numpy.testing.assert_allclose(*frames, rtol=0, atol=1e-9 * frames[0].max())


class Refits(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.random = numpy.random.default_rng(1)
        cls.truth = toliman.Sky(altitude_km=600)
        cls.tai_ns = toliman.parse_time("2027-01-01", scale="tai") + numpy.sort(
            cls.random.choice(1095 * 24, 150, replace=False)) * (DAY // 24)
        cls.measured = cls.truth.predict(cls.tai_ns)["separation_arcsec"]
        cls.exposures = cls.tai_ns[:, None] + numpy.array([-10**6, 10**6])  # short, so that instants are their means
        cls.years = (cls.tai_ns - cls.tai_ns[0]) / DAY / 365.25

    def wrong(self):
        """The system with elements that are wrong by their errors."""
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "system.json"
            self.truth.save(path)
            system = json.loads(path.read_text())
            for name, (value, sigma) in self.truth.elements.items():
                system["orbit"][name] = value + sigma * self.random.normal()
            path.write_text(json.dumps(system))
            return toliman.Sky(path, altitude_km=600)

    def annual(self, sky, measured):
        """Annual wave and rms of the reduced separations, uas."""
        seen = sky.predict(self.tai_ns)
        left = (measured / seen["factor"] - seen["geometric_arcsec"]) * 1e6
        columns = numpy.c_[numpy.polynomial.chebyshev.chebvander(self.years / 1.5 - 1, 5),
                           numpy.cos(2 * numpy.pi * self.years), numpy.sin(2 * numpy.pi * self.years)]
        solution = numpy.linalg.lstsq(columns, left, rcond=None)[0]
        return numpy.hypot(*solution[-2:]), numpy.sqrt(numpy.mean(left**2))

    def test_wrong_elements_are_corrected(self):
        waves, rms = [], []
        for _ in range(20):
            sky, fit = self.wrong().refit(self.exposures, self.measured, 0.375e-6)
            wave, one = self.annual(sky, self.measured)
            waves.append(wave)
            rms.append(one)
            self.assertLess(fit.iterations, 8)
        self.assertLess(numpy.percentile(waves, 95), 0.03)
        self.assertLess(max(rms), 0.1)
        self.assertGreater(self.annual(self.wrong(), self.measured)[1], 100)

    def test_errors_are_right(self):
        """Elements, with noise, within their errors; the prior holds what the separations do not tell."""
        pulls, sigma = [], 3e-4
        for _ in range(30):
            noisy = self.measured + sigma * self.random.normal(size=len(self.measured))
            sky, fit = self.wrong().refit(self.exposures, noisy, sigma)
            pulls.append([(sky.elements[name][0] - self.truth.elements[name][0]) / sky.elements[name][1]
                          for name in sky.elements])
            self.assertAlmostEqual(fit.chi_square, 1, delta=0.5)
            numpy.testing.assert_allclose(numpy.sqrt(numpy.diag(numpy.reshape(fit.covariance, (7, 7)))),
                                          [error for _, error in sky.elements.values()], rtol=1e-12)
        rms = numpy.sqrt(numpy.mean(numpy.square(pulls), 0))
        self.assertTrue((rms > 0.6).all() and (rms < 1.5).all(), rms)
        self.assertLess(sky.elements["period_years"][1], 0.99 * self.truth.elements["period_years"][1])
        self.assertLess(sky.elements["node_deg"][1], self.truth.elements["node_deg"][1])

    def test_the_plate_scale_is_found(self):
        with tempfile.TemporaryDirectory() as folder:  # the semi-major axis is known exactly
            path = pathlib.Path(folder) / "system.json"
            self.truth.save(path)
            system = json.loads(path.read_text())
            del system["sigma"]["orbit"]["semi_major_arcsec"]
            path.write_text(json.dumps(system))
            exact = toliman.Sky(path, altitude_km=600)
        sky, fit = exact.refit(self.exposures, self.measured * 1.0002, 1e-5, scale_sigma=1e-3)
        self.assertAlmostEqual(fit.scale, 2e-4, delta=1e-5)
        self.assertLess(fit.scale_sigma, 1.5e-4)

    def test_the_residuals_are_those_of_the_result(self):
        noisy = self.measured + 1e-6 * self.random.normal(size=len(self.measured))
        sky, fit = self.wrong().refit(self.exposures, noisy, 1e-6)
        reduced = sky.reduce(self.exposures, noisy)
        left, factor = reduced.y, reduced.values("factor")
        self.assertAlmostEqual(fit.rms_arcsec, numpy.sqrt(numpy.mean(left**2)), delta=1e-12)
        # The data determine as much of an element as its variance falls below that of the prior.
        before = [error for _, error in self.wrong().elements.values()]
        determined = 7 - numpy.sum(numpy.diag(numpy.reshape(fit.covariance, (7, 7))) / numpy.square(before))
        self.assertAlmostEqual(fit.chi_square, numpy.sum((left * factor / 1e-6)**2) / (len(left) - determined),
                               places=5)

    def test_mistakes(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "system.json"
            self.truth.save(path)
            system = json.loads(path.read_text())
            del system["sigma"]["orbit"]
            path.write_text(json.dumps(system))
            exact = toliman.Sky(path, altitude_km=600)
        with refused(toliman.InputError, "intervals"):
            self.truth.refit(self.tai_ns, self.measured, 1e-6)
        for sky, separations, sigma, scale, message in (
                (exact, self.measured, 1e-6, 0, "sky"),
                (self.truth, self.measured * numpy.nan, 1e-6, 0, "y[0]"),
                (self.truth, self.measured, 0, 0, "sigma[0]"),
                (self.truth, self.measured, 1e-6, -1, "scale_sigma"),
                (self.truth, self.measured * 3, 1e-6, 0, "measured")):
            with self.subTest(message), refused(toliman.Error, message):
                sky.refit(self.exposures, separations, sigma, scale_sigma=scale)


if __name__ == "__main__":
    unittest.main()
