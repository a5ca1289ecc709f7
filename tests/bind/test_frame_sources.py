"""Frames as arrays in any memory order, memory maps, datasets, lists and iterators: the bits of one array."""
import itertools
import os
import pathlib
import subprocess
import sys
import tempfile
import tracemalloc
import unittest

import numpy

from package import ROOT, toliman
from refusal import refused

SCENE = ROOT / "examples" / "data" / "moving.json"
FRAMES = 70  # more than a call takes


class Dataset:
    """What h5py and zarr have: shape, length and slices, which are arrays."""

    def __init__(self, frames):
        self._frames, self.shape, self.taken = frames, frames.shape, []

    def __len__(self):
        return len(self._frames)

    def __getitem__(self, key):
        self.taken.append(key)
        return numpy.array(self._frames[key])


class Sources(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.folder.cleanup)
        cls.simulator = toliman.Simulator(SCENE)
        times, _, frames = toliman.simulate(cls.simulator, 0, FRAMES)
        cls.times, cls.frames = times, numpy.rint(frames)
        cls.template, cls.fit = toliman.Template(cls.simulator), toliman.Fit(cls.simulator)
        path = pathlib.Path(cls.folder.name) / "frames.npy"
        numpy.save(path, cls.frames.astype("u4"))
        padded = numpy.zeros((FRAMES, 64, 100))
        padded[:, :, 10:74] = cls.frames
        cls.sources = {
            "columns first": lambda: numpy.asfortranarray(cls.frames),
            "frames last": lambda: numpy.moveaxis(numpy.ascontiguousarray(numpy.moveaxis(cls.frames, 0, -1)), -1, 0),
            "reversed twice": lambda: cls.frames[::-1].copy()[::-1],
            "a part of larger frames": lambda: padded[:, :, 10:74],
            "big-endian": lambda: cls.frames.astype(">u4"),
            "a type without pixels in C": lambda: cls.frames.astype("i8"),
            "a memory map": lambda: numpy.load(path, mmap_mode="r"),
            "a dataset": lambda: Dataset(cls.frames),
            "a list": lambda: list(cls.frames),
            "a tuple of lists": lambda: tuple(frame.tolist() for frame in cls.frames),
            "a generator": lambda: (frame for frame in cls.frames.astype("u4")),
            "other iterables": lambda: dict(enumerate(cls.frames)).values(),
        }

    def test_all_give_the_same_bits(self):
        results = {"template": lambda frames: self.template.encode(frames),
                   "fit": lambda frames: self.fit.frames(frames, times_days=self.times)["separation_px"]}
        for name, result in results.items():
            expected = result(self.frames)
            for source, frames in self.sources.items():
                with self.subTest(estimator=name, source=source):
                    numpy.testing.assert_array_equal(result(frames()), expected)

    def test_calibrations(self):
        made = [toliman.calibrate(SCENE, frames, times_days=self.times[:4], free="focus")
                for frames in (self.frames[:4], iter(self.frames[:4]))]
        self.assertEqual(made[0].values()["focus"].value, made[1].values()["focus"].value)

    def test_components(self):
        made = []
        for frames in self.frames, iter(self.frames):
            components = toliman.Components(self.simulator, capacity=FRAMES)
            components.push(frames)
            components.train()
            made.append(components.series()[0])
        numpy.testing.assert_array_equal(*made)

    def test_components_are_all_or_none(self):
        bad = numpy.array(self.frames)
        bad[66, 3, 3] = numpy.nan
        for frames, capacity in (self.frames, 65), (iter(self.frames), 65), (bad, FRAMES), (iter(bad), FRAMES):
            components = toliman.Components(self.simulator, capacity=capacity)
            with self.assertRaises(toliman.Error):
                components.push(frames)
            self.assertEqual(len(components), 0)

    def test_frames_of_a_downlink(self):
        sent = [toliman.Frame(frame, k, k) for k, frame in enumerate(self.frames[:3])]
        expected = self.template.encode(self.frames[:3])
        for frames in sent, iter(sent):
            numpy.testing.assert_array_equal(self.template.encode(frames), expected)
        masked = toliman.Frame(numpy.ma.masked_greater(self.frames[0], 3), 0, 0)
        for call in (self.template.encode, lambda frame: self.template.encode([frame]), self.fit.frame):
            with self.assertRaisesRegex(ValueError, "masked"):
                call(masked)

    def test_no_frames(self):
        for none in [], (), iter([]), self.frames[:0]:
            self.assertEqual(len(self.fit.frames(none, times_days=0)), 0)

    def test_ctrl_c_stops_a_source_that_waits(self):
        code = ("import os, signal, sys, threading, time, toliman\n"
                "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
                f"template = toliman.Template(toliman.Simulator({str(SCENE)!r}))\n"
                "def source():\n"
                "    threading.Timer(0.2, os.kill, (os.getpid(), signal.SIGINT)).start()\n"
                "    time.sleep(60)\n    yield 0\n"
                "for call in (template.encode, toliman.Tracker(template, 0.01, 0.01, 9).push_many):\n"
                "    try:\n        call(source())\n"
                "    except KeyboardInterrupt:\n        print('stopped')\n")
        done = subprocess.run([sys.executable, "-c", code], timeout=50, capture_output=True, text=True,
                              env={**os.environ, "PYTHONPATH": str(pathlib.Path(toliman.__file__).parents[1])})
        self.assertEqual(done.stdout, "stopped\nstopped\n", done.stderr)

    def test_without_predictions_an_iterator_may_have_any_length(self):
        for count in 0, 1, 64, 65:
            values, fits = self.template.encode(itertools.islice(iter(self.frames), count), goodness=True)
            self.assertEqual((len(values), len(fits)), (count, count))

    def test_only_a_block_is_in_memory(self):
        dataset = Dataset(self.frames)
        self.template.encode(dataset)
        self.assertEqual(dataset.taken, [slice(0, 64), slice(64, 128)])
        frames = numpy.asfortranarray(numpy.zeros((2000, 64, 64), "f4"))
        tracemalloc.start()
        self.template.encode(frames)
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        self.assertLess(peak, 3 * 64 * 64 * 64 * 8)

    def test_refusals(self):
        frame, times = self.frames[0], self.times
        cases = (
            (ValueError, "frames", lambda: self.fit.frames(iter(self.frames[:20]), times_days=times)),
            (ValueError, "frames", lambda: self.fit.frames(iter(self.frames), times_days=times[:3])),
            (ValueError, "frames",
             lambda: self.template.encode(iter(self.frames), windows=[[0, 0], [0, 0]])),
            (ValueError, "frame", lambda: self.template.encode([frame, frame[1:]])),
            (ValueError, "frame",
             lambda: self.template.encode(frame if k < 66 else frame[:, 1:] for k in range(FRAMES))),
            (ValueError, "frames",
             lambda: self.template.encode(numpy.ma.masked_greater(frame, 3) for _ in range(3))),
            (ValueError, "frames", lambda: self.fit.frames(frame, times_days=0)),
            (ValueError, "times_days", lambda: self.fit.frames(self.frames)),
            (ValueError, "time_days", lambda: self.fit.frame(frame)),
            (ValueError, "time_days", lambda: toliman.Coadd(self.fit)),
            (TypeError, "frames", lambda: self.template.encode("frames.npy")),
            (ZeroDivisionError, "division", lambda: self.template.encode(1 / 0 for _ in range(2))),
        )
        for case, (kind, name, call) in enumerate(cases):
            with self.subTest(case), refused(kind, name):
                call()


if __name__ == "__main__":
    unittest.main()
