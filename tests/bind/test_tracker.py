"""Tests Tracker in Python: equal bits for any order and pixel type of the frames; folders, failures, user-supplied
estimators."""
import pathlib
import subprocess
import sys
import tempfile
import time
import unittest

import numpy

import package  # noqa: F401, which finds the bindings
from refusal import refused
from toliman import VERDICTS, Error, Estimate, Frame, InputError, Periodogram, StateError, Tracker

DAY = 86400 * 10**9
GRID = (0.01, 0.001, 400)
N = 60
values = numpy.sin(2 * numpy.pi * numpy.arange(N) / 17) + 2
OWN = {"estimator_id": 7, "sigma": 1.0, "value_limit": 1e6, "rows": 8, "cols": 6, "image_shape": (8, 6),
       "allow_zero_runs": True}


def corner(image):
    return image[0, 0]


def frame_of(k, dtype=numpy.float64, **more):
    return Frame(numpy.full((8, 6), values[k], dtype), frame_id=k, camera_ns=k * DAY, **more)


def tracker(estimator=corner, **more):
    return Tracker(estimator, *GRID, **{**OWN, **more})


class Pushing(unittest.TestCase):
    def test_same_bits_in_any_order(self):
        plain = Periodogram(*GRID, unit_ns=86400e9)
        for k in range(N):
            plain.push(k * DAY, values[k], ns=True)
        with tracker() as ours:
            ours.push_many([frame_of(k) for k in numpy.random.default_rng(1).permutation(N)])
            self.assertTrue((ours.period.power() == plain.power()).all())
            self.assertEqual(repr(ours.period.peak()), repr(plain.peak()))
            self.assertAlmostEqual(ours.fit().period, 17, delta=1e-9)

    def test_verdicts(self):
        with tracker(bit_depth=0) as ours:
            self.assertEqual(ours.push(frame_of(3)).verdict, "accepted")
            self.assertEqual(ours.push(frame_of(3)).verdict, "duplicate")
            self.assertEqual(ours.push(frame_of(4, roi="other")).value, values[4])
            hot = frame_of(5)
            hot.pixels[2, 1] = numpy.inf
            outcome = ours.push(hot)
            self.assertEqual((outcome.verdict, outcome.reason, outcome.row, outcome.col), ("rejected", "not_finite", 2, 1))
            self.assertEqual(ours.push(Frame(frame_of(3).pixels + 1, 3, 3 * DAY)).verdict, "quarantined")
            info = ours.info
            self.assertEqual((info.received, info.accepted, info.quarantined, info.repeated, info.rejected), (5, 1, 1, 2, 1))
            self.assertEqual(ours.rejected["not_finite"], 1)
            lines = ours.records()
            self.assertEqual([VERDICTS[verdict] for verdict in lines["verdict"]], ["quarantined", "accepted"])
            self.assertEqual(lines["frame_id"].tolist(), [3, 4])

    def test_every_pixel_type(self):
        """Each pixel type, in either byte order, and cropped from a larger frame: the same value, and the same
        content."""
        counts = numpy.arange(48).reshape(8, 6)
        for name in ("u1", "<u2", ">u2", "<u4", ">u4", "<i2", ">i2", "<i4", ">i4", "<f4", ">f4", "<f8", ">f8"):
            large = numpy.zeros((10, 9), name)
            large[1:9, 2:8] = counts
            for pixels in (counts.astype(name), large[1:9, 2:8], numpy.asfortranarray(counts.astype(name))):
                with tracker(lambda image: (image * counts).sum()) as ours:
                    self.assertEqual(ours.push(Frame(pixels, 0, 0)).value, (counts**2).sum())
        with tracker() as ours:
            for bad in (counts, counts.astype("u4")[0], counts.astype(complex)):
                with refused(TypeError, "pixels"):
                    ours.push(Frame(bad, 0, 0))
            with refused(ValueError, "pixels"):
                ours.push(Frame(numpy.ma.masked_equal(counts.astype("u4"), 3), 0, 0))
            self.assertEqual(ours.info.received, 0)

    def test_own_estimators(self):
        seen = []

        def estimate(image):
            seen.append(image.shape)
            if len(seen) == 3:
                raise RuntimeError("no value today")
            return image.sum()
        with tracker(estimate) as ours:
            self.assertEqual(ours.push(frame_of(1)).value, values[1] * 48)
            with refused(RuntimeError, "no"):
                ours.push_many([frame_of(2), frame_of(3), frame_of(4)])
            self.assertEqual((ours.info.accepted, ours.rejected["estimate"]), (2, 1))
        self.assertEqual(set(seen), {(8, 6)})
        with tracker(lambda image: numpy.nan) as ours:
            self.assertEqual(ours.push(frame_of(1)).reason, "estimate")
        with refused(TypeError, "estimator"):
            tracker("mean")

    def test_columns_hold_values_of_estimators_and_frames(self):
        def estimate(image):
            return Estimate(image[0, 0], further=(1.5, -2), covariance=numpy.arange(9).reshape(3, 3), sigma=2,
                            chi_square=1.25, flags=2**31)
        with tracker(estimate, values=("dx", "flux")) as ours:
            outcome = ours.push(frame_of(3, exposure_s=8.0, intervals=[(0, 1), (2, 4)], window=(-5, 700)))
            self.assertEqual((outcome.value, outcome.chi_square), (values[3], 1.25))
            ours.push(frame_of(4))
            lines = ours.records()
            first = {name: lines[name][0] for name in lines.dtype.names}
            row = {"value": values[3], "sigma": 2, "chi_square": 1.25, "exposure_s": 8, "shift_s": 6.5 / 3 - 4, "window_row": -5,
                   "window_col": 700, "flags": 2**31, "dx": 1.5, "flux": -2, "cov_value_dx": 1, "cov_value_flux": 2,
                   "cov_dx_dx": 4, "cov_dx_flux": 5, "cov_flux_flux": 8}
            self.assertEqual({name: first[name] for name in row}, row)
            self.assertEqual(lines["window_row"].dtype, numpy.int64)
            self.assertEqual(lines["exposure_s"].tolist(), [8, 0])
            self.assertEqual(ours.records(1)["frame_id"].tolist(), [4])
            for bad, name in (([1, 2], "intervals"), ([(0, 1, 2)], "intervals"), ([(0, 9)], "frames[0].intervals[0]")):
                with refused(ValueError, name):
                    ours.push(frame_of(5, exposure_s=8.0, intervals=bad))
        with tracker(estimate) as ours, refused(ValueError, "further"):
            ours.push(frame_of(3))
        with tracker() as ours:
            self.assertTrue(numpy.isnan(ours.push(frame_of(3)).chi_square))
        with refused(InputError, "options->estimator.values"):
            tracker(values="No.name")

    def test_options_in_force(self):
        with tempfile.TemporaryDirectory() as folder, tracker(folder=folder, sync="frame", values=["dx"]) as ours:
            have = ours.options
            self.assertEqual((have["folder"], have["sync"], have["values"]), (folder, "frame", ("dx",)))
            self.assertEqual((have["f0"], have["df"], have["nf"], have["unit_ns"]), (*GRID, 86400e9))
            self.assertEqual((have["rows"], have["zero_run_bytes"], have["threads"], have["group"]), (8, 0, 1, 64))
            ours.push(frame_of(1))
            ours.commit()
            with Tracker.open(folder) as there:
                self.assertEqual(there.options["values"], ("dx",))
                self.assertTrue(numpy.isnan(there.records()["dx"][0]))

    def test_trend(self):
        """A slow variation that has no period: the mean alone finds one, with a trend there is none."""
        slow = 1e-3 * (numpy.arange(N) - 20.0)**2
        alone, fitted, chosen = (tracker(lambda image: image[0, 0], **more)
                                 for more in ({}, {"trend": 2, "span": (0, 59)}, {"trend": 0}))
        reference = Periodogram(*GRID, trend=2, span=(0, 59), value_bound=2.0**20, time_offset_ns=0, unit_ns=DAY)
        for k in range(N):
            for ours in (alone, fitted, chosen):
                ours.push(Frame(numpy.full((8, 6), slow[k]), frame_id=k, camera_ns=k * DAY))
            reference.push(k * DAY, slow[k], ns=True)
        numpy.testing.assert_array_equal(fitted.period.power(), reference.power())
        numpy.testing.assert_array_equal(alone.period.power(), chosen.period.power())
        self.assertLess(alone.period.peak().log10_fap, -10)
        self.assertEqual((fitted.options["trend"], fitted.options["trend_end"]), (2, 59))
        late = fitted.push(Frame(numpy.zeros((8, 6)), frame_id=99, camera_ns=60 * DAY))
        self.assertEqual((late.verdict, late.reason), ("rejected", "clock"))
        with refused(InputError, "options->grid.trend_start"):
            tracker(trend=0, span=(0, 1))

    def test_time_stamps_of_a_folder(self):
        with tempfile.TemporaryDirectory() as folder:
            with tracker(folder=folder, stamp="start", exposure_s=0.5) as ours:
                self.assertEqual((ours.options["stamp"], ours.options["exposure_s"]), ("start", 0.5))
            with tracker(folder=folder) as again:
                self.assertEqual((again.options["stamp"], again.options["exposure_s"]), ("start", 0.5))
            with self.assertRaises(InputError) as raised:
                tracker(folder=folder, stamp="end")
            self.assertEqual(raised.exception.name, "TOLIMAN_E_MISMATCH")
        with tracker() as ours:
            self.assertEqual((ours.options["stamp"], ours.options["exposure_s"]), ("middle", 0.0))
        with refused(ValueError, "stamp"):
            tracker(stamp="begin")

    def test_outcomes_up_to_an_error(self):
        with tracker(capacity=2) as ours:
            with self.assertRaises(Error) as raised:
                ours.push_many([frame_of(k) for k in range(4)])
            self.assertEqual([outcome.value for outcome in raised.exception.outcomes], values[:2].tolist())
        with tracker(capacity=70) as ours:  # more than are passed to C at a time
            with self.assertRaises(Error) as raised:
                ours.push_many([frame_of(k % N, session=f"s{k}") for k in range(100)])
            self.assertEqual(len(raised.exception.outcomes), 70)
        with tracker(capacity=2) as ours:
            with self.assertRaises(Error) as raised:
                ours.push_many([frame_of(k) for k in range(3)])
            self.assertEqual(raised.exception.name, "TOLIMAN_E_CAPACITY")
        with tracker() as ours:
            with refused(InputError, "frames[0].session"):
                ours.push(frame_of(1, session="../etc"))

    def test_cancelled_between_frames(self):
        with tracker() as ours:
            with refused(Error):
                ours.push_many([frame_of(k % N, session=f"s{k}") for k in range(200)],
                               progress=lambda stage, fraction: fraction > 0.5)
            self.assertEqual(ours.info.accepted, 101)


    def test_times_and_ids_that_do_not_fit(self):
        with tracker() as ours:
            for bad in ({"frame_id": 2**63}, {"camera_ns": -2**63 - 1}, {"dropped": 2**64}, {"frame_id": 1.5}):
                with refused((ValueError, TypeError), list(bad)[0]):
                    ours.push(Frame(**{"pixels": frame_of(0).pixels, "frame_id": 0, "camera_ns": 0, **bad}))
            with refused(ValueError, "session"):
                ours.push(frame_of(1, session="a\0b"))
            with refused(TypeError, "frame"):
                ours.push(frame_of(1).pixels)
            self.assertEqual(ours.info.received, 0)
        with refused(ValueError, "clock"):
            tracker(clock=numpy.array([[0, 2**63]], numpy.uint64))

    def test_sigma_and_crop_of_a_frame(self):
        large = numpy.arange(12.0 * 11).reshape(12, 11)
        with tracker(rows=12, cols=11, crop=(3, 1)) as ours:
            self.assertEqual(ours.push(Frame(large, 0, 0, sigma=2.0)).value, large[3, 1])
            self.assertEqual(ours.records()["sigma"].tolist(), [2.0])

    def test_rows_that_overlap(self):
        overlapping = numpy.lib.stride_tricks.as_strided(numpy.arange(30.0), (8, 6), (8, 8))
        with tracker(lambda image: image.sum()) as ours:
            self.assertEqual(ours.push(Frame(overlapping, 0, 0)).value, overlapping.sum())

    def test_pixels_that_are_not_aligned(self):
        pixels = numpy.frombuffer(bytearray(385), "f8", 48, 1).reshape(8, 6)
        with tracker() as ours:
            self.assertEqual(ours.push(Frame(pixels, 0, 0)).value, 0)

    def test_an_image_may_be_kept_and_changed(self):
        kept = []

        def estimate(image):
            kept.append(image)
            image += 1
            return image[0, 0]
        with tracker(estimate) as ours:
            ours.push_many([frame_of(1), frame_of(2)])
        self.assertEqual([image[0, 0] for image in kept], [values[1] + 1, values[2] + 1])

    def test_closing_during_a_push(self):
        def estimate(image):
            with refused(StateError, "track"):  # its frames cannot be committed now
                ours.close()
            return 1.0
        ours = tracker(estimate)
        self.assertEqual(ours.push(frame_of(1)).value, 1.0)
        with refused(ValueError, "this"):
            ours.push_many([])
        self.assertEqual(repr(ours), "<closed Tracker>")

    def test_ctrl_c_interrupts_an_estimator(self):
        code = ("import os, signal, threading, time\nimport test_tracker as t\n"
                "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
                "ours = t.tracker(lambda image: time.sleep(30) or 1.0)\n"
                "threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT)).start()\n"
                "try:\n    ours.push_many([t.frame_of(k) for k in range(60)])\n"
                "except KeyboardInterrupt as stopped:\n    print('stopped', len(stopped.outcomes))\n")
        start = time.monotonic()
        done = subprocess.run([sys.executable, "-c", code], cwd=pathlib.Path(__file__).parent, capture_output=True, text=True)
        self.assertEqual((done.stderr, done.stdout[:8]), ("", "stopped "))
        self.assertLess(time.monotonic() - start, 20)


class Folders(unittest.TestCase):
    def setUp(self):
        kept = tempfile.TemporaryDirectory()
        self.addCleanup(kept.cleanup)
        self.folder = pathlib.Path(kept.name)

    def test_resumed_read_and_merged(self):
        clock = [[0, 5], [DAY, DAY + 7]]
        for name, some in (("a", range(0, N, 2)), ("b", range(1, N, 2))):
            with tracker(folder=self.folder / name, clock=clock) as ours:
                ours.push_many([frame_of(k, session="night") for k in some])
                ours.save()
        with tracker(folder=self.folder / "a") as ours:
            self.assertEqual(len(ours.period), N // 2)
            self.assertEqual(ours.clock().tolist(), clock)
            self.assertEqual(ours.streams()[0].session, "night")
            self.assertEqual(ours.streams()[0].missing, N // 2 - 1)
            self.assertEqual(ours.merge(self.folder / "b"), 0)
            power = ours.period.power()
        with Tracker.open(self.folder / "a") as reader, tracker(clock=clock) as whole:
            whole.push_many([frame_of(k, session="night") for k in range(N)])
            self.assertTrue((reader.period.power() == power).all())
            self.assertTrue((whole.period.power() == power).all())
            self.assertEqual(reader.streams()[0].missing, 0)
            with refused(Error, self.folder / "a"):
                reader.push(frame_of(1))
        with self.assertRaises(FileNotFoundError):
            Tracker.open(self.folder / "c")

    def test_damage_is_logged(self):
        with tracker(folder=self.folder / "a") as ours:
            ours.push(frame_of(0))
            ours.save()
        checkpoint = self.folder / "a/checkpoint.tlmc"
        checkpoint.write_bytes(checkpoint.read_bytes()[:-1])
        for take_up in (lambda: Tracker.open(self.folder / "a"), lambda: tracker(folder=self.folder / "a")):
            with self.assertLogs("toliman", "WARNING") as logged:
                take_up().close()
            self.assertIn("checkpoint.tlmc: is damaged", logged.output[0])
        with self.assertNoLogs("toliman"):
            Tracker.open(self.folder / "a").close()

    def test_accepted_frames_are_kept(self):
        """Left by `with`, closed, garbage-collected, or at the end of Python: without save() or commit()."""
        with tracker(folder=self.folder / "a") as ours:
            ours.push(frame_of(0))
        ours = tracker(folder=self.folder / "a")
        ours.push(frame_of(1))
        ours.close()
        ours.close()
        ours = tracker(folder=self.folder / "a")
        ours.push(frame_of(2))
        del ours
        code = "import sys, test_tracker as t\nours = t.tracker(folder=sys.argv[1])\nours.push(t.frame_of(3))"
        subprocess.run([sys.executable, "-c", code, self.folder / "a"], cwd=pathlib.Path(__file__).parent, check=True)
        with Tracker.open(self.folder / "a") as reader:
            self.assertEqual(reader.records()["frame_id"].tolist(), [0, 1, 2, 3])
            self.assertEqual(len(reader.records(2, 2**40)), 2)

    def test_period_follows_its_tracker_and_closes_with_it(self):
        ours = tracker()
        period = ours.period
        ours.push(frame_of(1))
        self.assertEqual(len(period), 1)
        with self.assertRaises(AttributeError):
            period.push(0, 0)
        kept = period.copy()
        ours.close()
        with refused(ValueError, "this"):
            period.power()
        self.assertEqual(len(kept), 1)

    def test_invalid_clocks(self):
        for bad in ([[0.0, 1.0]], [0, 1], [[0, 1, 2]]):
            with refused(ValueError, "clock"):
                tracker(clock=bad)


if __name__ == "__main__":
    unittest.main()
