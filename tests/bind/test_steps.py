"""One call for each step: simulate, track and planets, with the numbers of the objects and of the program."""
import datetime
import json
import os
import pathlib
import subprocess
import tempfile
import unittest
import warnings

import numpy

from package import ROOT, toliman
from refusal import refused
from toliman.times import tai_ns_of

MOVING = json.loads((ROOT / "examples" / "data" / "moving.json").read_text())
FRAMES = 40
SCENE = {**MOVING, "cadence": {**MOVING["cadence"], "frames": FRAMES, "exposure_s": 100}}
OBSERVED = {**SCENE, "binary": {**SCENE["binary"], "observer": {"altitude_km": 600}}}
del SCENE["cadence"]["peak_photons"]
for star, photons in ("A", 3e6), ("B", 1e6):
    SCENE["stars"][star].pop("relative_flux", None)
    SCENE["stars"][star]["detected_per_s"] = photons
DAY = 86400 * 10**9


class Simulations(unittest.TestCase):
    def test_frames_and_series_of_a_simulator(self):
        simulator = toliman.Simulator(SCENE)
        for first, count in (0, None), (3, 5):
            made = toliman.simulate(SCENE, first, count, seed=4)
            numpy.testing.assert_array_equal(made.frames, simulator.frames(first, count, seed=4))
            numpy.testing.assert_array_equal((made.times_days, made.displacements_px), simulator.series(first, count))
        with refused(TypeError, "scene"):
            toliman.simulate(3)


class Tracking(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.times, _, cls.frames = toliman.simulate(SCENE)

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def test_defaults_of_the_program(self):
        """The records and options of `toliman track --fit`, for stars with and without a reference orbit."""
        for name, scene in ("moving", SCENE), ("observed", OBSERVED):
            path, frames, state = (str(self.folder / f"{name}{end}") for end in (".json", ".npy", ""))
            pathlib.Path(path).write_text(json.dumps(scene))
            times, _, images = toliman.simulate(path)
            numpy.save(frames, images)
            subprocess.run([os.environ["TOLIMAN"], "track", "--fit", path, "--state", state, "--cadence", "86400",
                            "--session", "session", frames], check=True, capture_output=True)
            found, expected = toliman.track(path, images, times), toliman.Tracker.open(state)
            options = [{key: value for key, value in tracker.options.items() if key not in ("folder", "flags", "threads")}
                       for tracker in (found, expected)]
            self.assertEqual(*options)
            records = [tracker.records() for tracker in (found, expected)]
            self.assertEqual(len(records[0]), FRAMES)
            for column in "value", "sigma", "tai_ns", "separation_px", "verdict", "frame_id":
                numpy.testing.assert_array_equal(*(record[column] for record in records), err_msg=f"{name}: {column}")
            numpy.testing.assert_array_equal(found.period.power(), expected.period.power())

    def test_a_folder_of_another_bit_depth_is_continued(self):
        state = self.folder / "mission"
        scene = {**SCENE, "detector": {**SCENE["detector"], "bit_depth": 24}}
        with toliman.track(scene, self.frames[:9], self.times[:9], folder=state):
            pass
        with toliman.track(scene, self.frames[9:], self.times[9:], folder=state, first_id=9) as tracker:
            self.assertEqual(tracker.info.accepted, FRAMES)

    def test_a_failure_keeps_what_was_accepted(self):
        def source():
            yield from self.frames[:9]
            raise ConnectionError("the link is down")
        folder = self.folder / "mission"
        kept = []
        for failing in (lambda: toliman.track(SCENE, source(), self.times, folder=folder),
                        lambda: toliman.track(SCENE, source(), self.times)):
            try:
                failing()
            except ConnectionError as error:
                kept.append(error)
        self.assertEqual([len(error.outcomes) for error in kept], [9, 9])
        self.assertEqual(kept[1].tracker.info.accepted, 9)
        with toliman.track(SCENE, self.frames, self.times, folder=folder) as tracker:  # the folder is not locked
            self.assertEqual((tracker.info.accepted, tracker.info.repeated), (FRAMES, 9))
        with self.assertRaises(ValueError):
            toliman.track(SCENE, self.frames, self.times[1:], folder=self.folder / "never")
        self.assertFalse((self.folder / "never").exists())

    def test_frames_before_a_bad_one_are_pushed(self):
        good = [toliman.Frame(image, k, k * DAY) for k, image in enumerate(self.frames[:3])]
        with toliman.Tracker(toliman.Template(toliman.Simulator(SCENE)), 0.01, 0.01, 9) as tracker:
            with self.assertRaises(TypeError) as caught:
                tracker.push_many([*good, toliman.Frame(self.frames[0][0], 3, 3 * DAY)])
            self.assertEqual((len(caught.exception.outcomes), tracker.info.received), (3, 3))

    def test_progress(self):
        seen = []
        toliman.track(SCENE, self.frames, self.times, progress=lambda stage, share: seen.append((stage, share)))
        self.assertEqual(seen[-1], ("frames", 1))

    def test_a_folder_is_continued(self):
        folder = self.folder / "mission"
        for part in slice(0, 25), slice(25, None):
            with toliman.track(SCENE, iter(self.frames[part]), self.times[part], folder=folder,
                               first_id=part.start) as tracker:
                accepted = tracker.info.accepted
        self.assertEqual(accepted, FRAMES)
        with toliman.track(SCENE, self.frames, self.times, folder=folder) as tracker:  # again: all are duplicates
            self.assertEqual((tracker.info.accepted, tracker.info.repeated), (FRAMES, FRAMES))
            whole = toliman.track(SCENE, self.frames, self.times)
            numpy.testing.assert_array_equal(tracker.period.power(), whole.period.power())

    def test_other_frames_with_the_same_ids(self):
        """A forgotten first_id would quarantine accepted frames."""
        folder = self.folder / "mission"
        with toliman.track(SCENE, self.frames[:20], self.times[:20], folder=folder):
            pass
        with self.assertRaisesRegex(ValueError, "first_id = 0: .* give 20, the next one"):
            toliman.track(SCENE, self.frames[20:], self.times[20:], folder=folder)
        with self.assertWarnsRegex(toliman.FrameWarning, "20 of 20 frames were not accepted: 20 quarantined"):
            toliman.track(SCENE, self.frames[20:], self.times[:20], folder=folder).close()

    def test_the_same_ids_of_other_sessions(self):
        """Also of several, with an overlap of the same frames."""
        folder = self.folder / "mission"
        parts = (("a", 0, 8, 0), ("b", 8, 12, 0), ("a", 6, 9, 6), ("b", 11, 15, 3))
        for session, first, end, first_id in parts:
            with toliman.track(SCENE, self.frames[first:end], self.times[first:end], folder=folder, session=session,
                               first_id=first_id) as tracker:
                accepted, repeated = tracker.info.accepted, tracker.info.repeated
        self.assertEqual((accepted, repeated), (16, 3))
        with self.assertRaisesRegex(ValueError, "of session 'b' .* give 7, the next one"):
            toliman.track(SCENE, self.frames[:3], self.times[:3], folder=folder, session="b", first_id=2)

    def test_a_folder_that_is_open(self):
        folder = self.folder / "mission"
        with toliman.track(SCENE, self.frames[:5], self.times[:5], folder=folder):
            with self.assertRaisesRegex(toliman.StateError, "must be closed first"):
                toliman.track(SCENE, self.frames[5:], self.times[5:], folder=folder, first_id=5)

    def test_frames_with_times_of_their_own(self):
        zero = toliman.Simulator(SCENE).info.time_zero_ns
        given = [toliman.Frame(image, frame_id=k, camera_ns=zero + round(t * DAY))
                 for k, (t, image) in enumerate(zip(self.times, self.frames))]
        by_frames, by_images = toliman.track(SCENE, given), toliman.track(SCENE, self.frames, self.times)
        numpy.testing.assert_array_equal(by_frames.period.power(), by_images.period.power())

    def test_planets_of_a_folder(self):
        options = {"period_min": 5, "period_max": 30, "samples": 100, "amplitude_min": 1e-5, "amplitude_max": 0.1}
        folder = self.folder / "mission"
        with toliman.track(SCENE, self.frames, self.times, folder=folder) as tracker:
            found = [toliman.planets(source, **options) for source in (tracker, folder, str(folder),
                                                                       tracker.measurements())]
        self.assertAlmostEqual(found[0].candidates[0].period[1], 17, delta=0.5)
        for other in found[1:]:
            self.assertEqual(other.samples().tobytes(), found[0].samples().tobytes())

    def test_planets_in_the_first_days_of_a_mission(self):
        """The trend of the folder has the span of the mission; that of the search, of the samples."""
        long = {**SCENE, "cadence": {**SCENE["cadence"], "frames": 2000}}
        options = {"period_min": 5, "period_max": 30, "samples": 100}
        with toliman.track(long, self.frames, self.times) as tracker:
            series = tracker.measurements()
            found = toliman.planets(series, **options)
        expected = toliman.planets(series.t, series.y, series.sigma, trend=series.info.trend, frame_chi_square=1, **options)
        self.assertEqual(series.info.trend, 4)
        self.assertEqual(found.candidates[0].period, expected.candidates[0].period)

    def test_mistakes(self):
        frames, times = self.frames[:3], self.times[:3]
        cases = (
            (TypeError, "scene", lambda: toliman.track(3, frames, times)),
            (TypeError, "times", lambda: toliman.track(SCENE, frames)),
            (TypeError, "frame", lambda: toliman.track(SCENE, list(frames))),
            (ValueError, "times", lambda: toliman.track(SCENE, frames, times[:2])),
            (ValueError, "times", lambda: toliman.track(SCENE, iter(frames), times[:2])),
            (ValueError, "times", lambda: toliman.track(SCENE, iter(frames), [*times, 9])),
            (ValueError, "times", lambda: toliman.track(SCENE, frames, times * DAY)),
            (ValueError, "times", lambda: toliman.track(SCENE, frames, times * numpy.nan)),
            (TypeError, "times", lambda: toliman.track(SCENE, [toliman.Frame(frames[0], 0, 0)], [0])),
        )
        for case, (kind, name, call) in enumerate(cases):
            with self.subTest(case), refused(kind, name):
                call()


class Dates(unittest.TestCase):
    def test_fits_and_skies_take_dates(self):
        times, _, frames = toliman.simulate(SCENE, 0, 3)
        fit, zero = toliman.Fit(SCENE), toliman.Simulator(SCENE).info.time_zero_ns
        tai = zero + numpy.rint(times * DAY).astype("i8")
        utc = (tai - 37 * 10**9).astype("M8[ns]")
        expected = fit.frames(frames, times_days=times)
        numpy.testing.assert_allclose(fit.frames(frames, times_days=utc)["separation_px"], expected["separation_px"], rtol=1e-9)
        sky = toliman.Sky("alpha-cen", altitude_km=600)
        numpy.testing.assert_array_equal(sky.predict(utc)["factor"], sky.predict(tai)["factor"])

    def test_dates_of_arrays_stay_dates(self):
        tai = toliman.parse_time("2027-01-01") + numpy.arange(9) * DAY
        utc = (tai - 37 * 10**9).astype("M8[ns]")
        numpy.testing.assert_array_equal(toliman.Measurements.of(utc, numpy.arange(9.0)).tai_ns, tai)

    def test_units_of_values(self):
        try:
            from astropy import units
        except ImportError:
            self.skipTest("needs astropy")
        for unit, kind, number in (("mas", "reduced", 1e-3), (units.uas, "reduced", 1e-6), (2 * units.mas, "reduced", 2e-3),
                                   (units.km / units.s, "velocity", 1e3), (0.5, "reduced", 0.5)):
            made = toliman.Measurements.of(numpy.arange(9.0), numpy.arange(9.0), kind=kind, unit=unit)
            self.assertAlmostEqual(made.info.unit / number, 1, delta=1e-12)
        with refused(ValueError, "unit"):
            toliman.Measurements.of([1, 2], [1, 2], kind="reduced", unit="kg")

    def test_fits_that_are_lost_are_a_warning(self):
        times, _, frames = toliman.simulate(SCENE, 0, 4)
        frames[2:] = 0
        with self.assertWarnsRegex(toliman.FitWarning, "of 2 did not converge, their values are NaN"):
            toliman.Fit(SCENE).frames(frames, times_days=times)


class Times(unittest.TestCase):
    def test_days_and_dates(self):
        zero = toliman.parse_time("2027-01-01")
        noon = datetime.datetime(2027, 1, 1, 12)
        for times in ([0.5], numpy.array([0.5]), [noon], numpy.array([noon], "M8[s]")):
            numpy.testing.assert_array_equal(tai_ns_of("times", times, zero), [zero + DAY // 2])

    def test_times_of_astropy(self):
        try:
            from astropy import units
            from astropy.time import Time
        except ImportError:
            self.skipTest("needs astropy")
        zero = toliman.parse_time("2027-01-01")
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # a stale table of leap seconds
            texts = ["2027-01-01T00:00:00.123456789", "2027-06-30T23:59:59.000000001"]
            found = tai_ns_of("times", Time(texts, scale="utc"), 0)
        expected = [toliman.parse_time(text) for text in texts]
        self.assertEqual(found.tolist(), expected)
        self.assertEqual(tai_ns_of("times", [12] * units.hour, zero).tolist(), [zero + DAY // 2])


if __name__ == "__main__":
    unittest.main()
