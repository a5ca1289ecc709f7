"""Pairs of files in the Python package: frames, events, growth, and the classes that take the frames."""
import json
import logging
import os
import pathlib
import signal
import tempfile
import threading
import time
import unittest

import numpy

from package import toliman
from refusal import refused
from toliman import Pair, Tracker

PACKAGE = pathlib.Path(toliman.__file__).parents[1]

PIXELS = (numpy.arange(6 * 3 * 4) * 7919 % 4096).astype("<u2").reshape(6, 3, 4)


def line(k, **changes):
    return json.dumps({"frame_id": k, "timestamp_ns": k * 10**9, "host_time": float(k), "nframes_dropped": 2,
                       "roi_label": "single_roi", "n_rows": 3, "n_cols": 4, "session_id": "day1", **changes})


class Pairs(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.stem = pathlib.Path(folder.name) / "day1"
        self.side, self.pixels = (pathlib.Path(f"{self.stem}{end}") for end in ("_meta.jsonl", "_frames.bin"))
        self.write([line(k) for k in range(6)], PIXELS)

    def write(self, lines, pixels, mode="w"):
        with self.pixels.open(mode + "b") as stream:
            stream.write(pixels.tobytes())
        with self.side.open(mode) as stream:
            stream.writelines(text + "\n" for text in lines)


class Frames(Pairs):
    def test_frames(self):
        for path in (self.stem, str(self.side), self.pixels):
            frames = list(Pair(path, "u16le", exposure_s=0.5))
            self.assertEqual([(frame.session, frame.roi, frame.frame_id, frame.camera_ns, frame.dropped, frame.exposure_s)
                              for frame in frames],
                             [("day1", "single_roi", k, k * 10**9 + 250_000_000, 2, 0.5) for k in range(6)])
            numpy.testing.assert_array_equal([frame.pixels for frame in frames], PIXELS)
            self.assertEqual(frames[0].pixels.dtype, numpy.uint16)
        self.write([line(0)], PIXELS[:2])
        (frame,) = Pair(self.stem, "u32le")
        numpy.testing.assert_array_equal(frame.pixels, PIXELS[:2].view("<u4").reshape(3, 4))

    def test_on_target_intervals(self):
        self.write([line(0, on_target_s=[0, 0.125, 0.25, 0.5]), line(1), line(2, on_target_s=[0.25, 0.5])], PIXELS[:3])
        frames = list(Pair(self.stem, "u16le", exposure_s=0.5))
        self.assertEqual([None if frame.intervals is None else frame.intervals.tolist() for frame in frames],
                         [[[0, 0.125], [0.25, 0.5]], None, [[0.25, 0.5]]])
        with self.assertLogs("toliman", logging.WARNING) as logged:
            self.assertEqual([frame.frame_id for frame in Pair(self.stem, "u16le")], [1])
        self.assertIn("_meta.jsonl:1: on_target_s needs the length of the exposure", logged.output[0])

    def test_views_keep_the_memory_of_a_closed_reader(self):
        with Pair(self.stem, "u16le", copy=False) as pair:
            for k, frame in enumerate(pair):
                numpy.testing.assert_array_equal(frame.pixels, PIXELS[k])
                self.assertEqual(frame.pixels.ctypes.data % 64, 0)
                last = frame.pixels
        numpy.testing.assert_array_equal(last, PIXELS[5])
        self.assertRaises(ValueError, next, iter(pair))

    def test_stamps_and_ids(self):
        frames = list(Pair(self.stem, "u16le", stamp="end", exposure_s=1, frame_ids=range(2, 4)))
        self.assertEqual([frame.camera_ns for frame in frames], [1_500_000_000, 2_500_000_000])
        pair = Pair(self.stem, "u16le", stamp="middle", frame_ids=range(-5, 1))
        self.assertEqual([frame.camera_ns for frame in pair], [0])
        info = pair.info()
        self.assertEqual((info.stamp, info.lines, info.frames, info.skipped, info.bytes), ("middle", 6, 1, 5, 144))
        self.assertEqual((info.side_file, info.pixel_file), (str(self.side), str(self.pixels)))

    def test_frames_go_to_a_tracker_and_to_estimators(self):
        def estimate(image):
            return float(image.mean())

        with Tracker(estimate, 0.1, 0.1, 5, estimator_id=1, sigma=1.0, rows=3, cols=4, image_shape=(3, 4),
                     value_limit=1e9, unit_ns=1e9) as tracker:
            outcomes = [tracker.push(frame) for frame in Pair(self.stem, "u16le", copy=False)]
            self.assertEqual([outcome.verdict for outcome in outcomes], ["accepted"] * 6)
            self.assertEqual([outcome.value for outcome in outcomes], [image.mean() for image in PIXELS])
        simulator = toliman.Simulator("chapter.json")
        rows, cols = simulator.shape
        self.write([line(0, n_rows=rows, n_cols=cols)], numpy.rint(simulator.frame(0)).astype("<u4"))
        (frame,) = Pair(self.stem, "u32le")
        template = toliman.Template(simulator)
        self.assertEqual(template.encode(frame), template.encode(numpy.rint(simulator.frame(0))))

    def test_type_is_found(self):
        """By the key dtype, otherwise by the size of complete files; the same pixels as with the type given."""
        for dtype, code in (("u16le", "<u2"), ("u32le", "<u4")):
            for key in ({}, {"dtype": dtype}):
                self.write([line(k, **key) for k in range(6)], PIXELS.astype(code))
                pair = Pair(self.stem)
                self.assertEqual(pair.info().pixel, "0")
                frames = [frame.pixels for frame in pair]
                numpy.testing.assert_array_equal(frames, PIXELS)
                self.assertEqual({frame.dtype for frame in frames}, {numpy.dtype(code)})
                self.assertEqual(pair.info().pixel, dtype[:3])
        self.write([line(0, dtype="u32le")], PIXELS[:2])
        with refused(toliman.InputError, self.side):
            list(Pair(self.stem, "u16le"))

    def test_arguments(self):
        for arguments, error in (({"dtype": "u16"}, "dtype"),
                                 ({"stamp": "begin"}, "stamp"),
                                 ({"rows": 3}, "options->cols"), ({"exposure_s": -1}, "options->exposure_s"),
                                 ({"frame_ids": range(3, 3)}, "frame_ids"), ({"frame_ids": range(0, 9, 2)}, "frame_ids"),
                                 ({"frame_ids": range(2**63)}, "frame_ids.stop")):
            with refused(ValueError, error):
                Pair(self.stem, **{"dtype": "u16le", **arguments})
        with refused(FileNotFoundError, "nothing_meta.jsonl"):
            Pair("nothing", "u16le")
        self.write([line(0)], PIXELS[:2])
        with refused(toliman.InputError, self.pixels):
            list(Pair(self.stem, "u16le"))


class Events(Pairs):
    def test_damage_and_warnings(self):
        lines = [line(k) for k in range(6)]
        lines[1] = "{}"
        lines[2] = line(2, n_rows=0)
        lines[4] = line(4, timestamp_ns=0)
        self.write(lines, PIXELS)
        events = list(Pair(self.stem, "u16le").events())
        self.assertEqual([(event.kind, event.reason, event.line) for event in events], [
            ("frame", "none", 1), ("damage", "bad_line", 2), ("damage", "bad_line", 3), ("frame", "none", 4),
            ("warning", "clock_jump", 5), ("frame", "none", 5), ("frame", "none", 6)])
        self.assertEqual([event.key for event in events[:3]], [("day1", "single_roi", 0, 0), None, ("day1", "single_roi", 2, 0)])
        self.assertEqual(str(events[1]), f"{self.side}:2: session_id is missing")
        self.assertIsNone(events[2].frame)
        self.assertEqual((events[3].stamp_ns, events[3].host_s), (3 * 10**9, 3.0))
        with self.assertLogs("toliman", logging.WARNING) as logged:
            self.assertEqual([frame.frame_id for frame in Pair(self.stem, "u16le")], [0, 3, 4, 5])
        self.assertEqual([record.getMessage() for record in logged.records],
                         [str(event) for event in events if event.kind != "frame"])

    def test_growth(self):
        pair = Pair(self.stem, "u16le", growing=True)
        self.assertEqual(len(list(pair)), 6)
        self.assertEqual(list(pair), [])
        self.write([line(6), line(7)], PIXELS[:1], "a")
        self.assertEqual([frame.frame_id for frame in pair], [6])
        self.assertEqual(list(pair.events()), [])
        pair.finish()
        (event,) = pair.events()
        self.assertEqual((event.kind, event.reason, event.key), ("damage", "short_file", ("day1", "single_roi", 7, 0)))
        self.assertEqual(pair.info().damaged, 1)

    def test_follow(self):
        pair, seen = Pair(self.stem, "u16le", growing=True), []

        def write():
            while len(seen) < 6:
                time.sleep(0.005)
            self.write([line(6)], PIXELS[:1], "a")
            while len(seen) < 7:
                time.sleep(0.005)
            os.kill(os.getpid(), signal.SIGUSR1)

        before = signal.signal(signal.SIGUSR1, lambda *_: pair.finish())
        self.addCleanup(signal.signal, signal.SIGUSR1, before)
        writer = threading.Thread(target=write)
        writer.start()
        for frame in pair.follow(interval_s=0.01):
            seen.append(frame.frame_id)
        writer.join()
        self.assertEqual(seen, list(range(7)))

    def test_a_complete_pair_is_not_followed(self):
        """It would be examined for ever."""
        with refused(ValueError, "growing"):
            next(Pair(self.stem, "u16le").follow())


if __name__ == "__main__":
    unittest.main()
