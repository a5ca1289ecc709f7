"""Tests the conventions of the Python package: coverage of the C interface, documentation, errors, cancellation, and
refusal of incompatible libraries."""
import ctypes
import dataclasses
import errno
import fcntl
import importlib.util
import inspect
import io
import json
import os
import pathlib
import pickle
import re
import struct
import subprocess
import sys
import tempfile
import termios
import threading
import time
import typing
import unittest
import unittest.mock
from contextlib import redirect_stderr

import numpy

from package import ROOT, toliman
from refusal import refused
from toliman import _arguments, _library, _raw
from toliman._progress import Bar
from toliman._words import words

PACKAGE = pathlib.Path(toliman.__file__).parents[1]

# The chapter's at one wavelength, which takes a tenth of the time.
SCENE = {**json.loads((ROOT / "examples" / "scenes" / "chapter.json").read_text()), "band": {"wavelength_nm": 580}}

# Functions that Python provides in another way.
NOT_NEEDED = {"toliman_mask_get_info",
              "toliman_period_push", "toliman_ingest_read_leap_seconds", "toliman_ingest_last_utc_day", "toliman_series_create", "toliman_series_destroy", "toliman_series_parse",
              "toliman_series_get_info"}


class Coverage(unittest.TestCase):
    def test_classes_cover_the_c_interface(self):
        text = "".join(path.read_text() for path in (PACKAGE / "toliman").glob("*.py") if path.name != "_raw.py")
        used = set(re.findall(r"library\.(toliman_\w+)|\"(toliman_\w+_destroy\w*)\"|found\.(toliman_\w+)", text))
        used = {name for names in used for name in names}
        self.assertEqual(set(_raw.FUNCTIONS) - used, NOT_NEEDED)

    def test_public_members_are_documented_and_typed(self):
        for name in toliman.__all__:
            thing = getattr(toliman, name)
            if inspect.ismodule(thing) or isinstance(thing, tuple):
                continue
            self.assertTrue(thing.__doc__, name)
            members = vars(thing).items() if inspect.isclass(thing) else ((name, thing),)
            for member, value in members:
                value = value.__func__ if isinstance(value, (classmethod, staticmethod)) else value
                if inspect.isfunction(value) and not member.startswith("_"):
                    self.assertTrue(value.__doc__, f"{name}.{member}")
                    self.assertIn("return", typing.get_type_hints(value), f"{name}.{member}")

    def test_words_match_the_header(self):
        self.assertEqual(tuple(words("TOLIMAN_SIM_UNIT").values()), ("photon", "electron", "dn"))
        self.assertEqual(words("TOLIMAN_TRACK_VERDICT")[_raw.TOLIMAN_TRACK_VERDICT_MERGED], "merged")
        self.assertEqual(list(toliman.REASONS.values())[-1], "no_intervals")
        for number, word in toliman.REASONS.items():
            name_in_c = _library.library.toliman_constant_name(number).decode()
            self.assertEqual(word.replace("_", " "), name_in_c)
        for number, word in words("TOLIMAN_GOODNESS").items():
            self.assertEqual(word, _library.library.toliman_constant_name(number).decode())
        for number, word in words("TOLIMAN_PERIOD_INTERVAL").items():
            self.assertEqual(word, _library.library.toliman_constant_name(number).decode())


class Results(unittest.TestCase):
    def test_tables(self):
        machine = toliman.machine()
        self.assertRegex(str(machine), rf"(?m)^processors +{machine.processors}$")
        self.assertIn(f"<td>{machine.fftw}</td>", machine._repr_html_())
        self.assertEqual(dataclasses.replace(machine, isa="<b>").isa, "<b>")
        self.assertIn("&lt;b&gt;", dataclasses.replace(machine, isa="<b>")._repr_html_())
        with self.assertRaises(dataclasses.FrozenInstanceError):
            machine.isa = "mmx"
        self.assertIn("isa='", repr(machine))

    def test_errors_are_also_python_exceptions(self):
        for status, kinds in ((_raw.TOLIMAN_E_ARGUMENT, ValueError), (_raw.TOLIMAN_E_NOT_FOUND, FileNotFoundError),
                              (_raw.TOLIMAN_E_WRITE, OSError), (_raw.TOLIMAN_E_LOST, toliman.LostError),
                              (_raw.TOLIMAN_E_MEMORY, MemoryError),
                              (_raw.TOLIMAN_E_UNSUPPORTED, NotImplementedError), (999, toliman.Error)):
            with self.assertRaises(kinds) as raised:
                _library.check(status)
            self.assertIsInstance(raised.exception, toliman.Error)
            self.assertEqual(raised.exception.status, status)
            again = raised.exception.__reduce__()
            self.assertEqual(str(again[0](*again[1])), str(raised.exception))
        self.assertEqual(f"{toliman.Error.__module__}.{toliman.Error.__name__}", "toliman.Error")

    # promise: errors-name-the-field
    def test_errors_name_what_was_wrong(self):
        with self.assertRaises(toliman.InputError) as raised:
            toliman.Periodogram(0.1, -1, 3)
        self.assertEqual(raised.exception.field, "df")
        with toliman.Periodogram(0.1, 0.1, 3) as periodogram, tempfile.TemporaryDirectory() as folder:
            with self.assertRaises(toliman.StateError) as raised:
                periodogram.peak()
            self.assertEqual(raised.exception.field, "")
            for call, path, reason in (
                    (toliman.Periodogram.load, "no/such/state", errno.ENOENT),
                    (toliman.Periodogram.load, folder, None),  # exists, but is not a file
                    (periodogram.save, "no/such/state", errno.ENOENT),
                    (periodogram.save, __file__ + "/state", errno.ENOTDIR)):
                with self.assertRaises(OSError) as raised:
                    call(path)
                error = raised.exception
                self.assertEqual((error.filename, error.field, error.errno), (path, path, reason))
                self.assertTrue(str(error).startswith(path + ": "), str(error))
                again = pickle.loads(pickle.dumps(error))
                self.assertEqual((str(again), again.filename, again.errno), (str(error), path, reason))

    def test_numbers_at_the_limit(self):
        self.assertEqual(_arguments.whole("n", 3, 4), 3)
        for bad in (4, -1):
            with refused(ValueError, "n"):
                _arguments.whole("n", bad, 4)

    def test_words_of_a_newer_library(self):
        outcome = toliman.Outcome._of(_raw.toliman_track_outcome(verdict=_raw.TOLIMAN_TRACK_VERDICT_REJECTED, reason=99))
        self.assertEqual((outcome.verdict, outcome.reason), ("rejected", "99"))

    def test_closed_objects(self):
        periodogram = toliman.Periodogram(0.1, 0.1, 3)
        self.assertTrue(periodogram)  # although it is empty
        periodogram.close()
        periodogram.close()
        for use in (periodogram.peak, lambda: periodogram.push(1, 1), lambda: len(periodogram)):
            with refused(ValueError, "this"):
                use()


class Cancellation(unittest.TestCase):
    def setUp(self):
        self.simulator = toliman.Simulator(SCENE)

    def test_progress_is_called_and_cancels(self):
        seen = []
        network = toliman.CAE(self.simulator)
        untrained = network.to_bytes()
        with self.assertRaises(toliman.Cancelled):
            network.train(progress=lambda stage, fraction: seen.append((stage, fraction)) or fraction > 0.3)
        self.assertEqual(network.to_bytes(), untrained)
        self.assertTrue(seen[0][0].startswith("train: step 1 of 300"))
        self.assertTrue(0.3 < seen[-1][1] < 0.5)
        with self.assertRaises(ZeroDivisionError):
            network.train(progress=lambda stage, fraction: 1 / 0)
        network.train(steps=50)
        other = toliman.CAE(self.simulator)
        other.train(steps=50)
        self.assertEqual(network.to_bytes(), other.to_bytes())  # a cancelled training resumes

    @unittest.mock.patch.dict(sys.modules, {"tqdm.auto": None})
    def test_bar(self):
        shown = io.StringIO()
        with redirect_stderr(shown):
            self.simulator.frames(0, 3, progress=True)
        self.assertEqual(shown.getvalue(), "100 % frames\n")  # no bar in a file
        shown.isatty = lambda: True
        with redirect_stderr(shown):
            self.simulator.frames(0, 3, progress=True)
        self.assertEqual(shown.getvalue().rstrip().split("\r")[-1], "100 % frames")

    @unittest.mock.patch.dict(sys.modules, {"tqdm.auto": None})
    def test_bar_never_wraps(self):
        try:
            controller, terminal = os.openpty()
        except OSError as error:
            self.skipTest(f"no pseudo terminal here: {error}")
        for columns, width in ((50, 49), (20, 19), (0, 79)):
            fcntl.ioctl(controller, termios.TIOCSWINSZ, struct.pack("HHHH", 24, columns, 0, 0))
            with open(os.dup(terminal), "w") as stream, redirect_stderr(stream):
                bar = Bar()
                bar("train: " + 20 * "step ", 0.5)
                bar.close(False)
            shown = b""
            while not shown.endswith(b"\n"):  # the terminal may pass on a part of what was written
                shown += os.read(controller, 1000)
            self.assertEqual(len(shown.decode().strip("\r\n")), width)
        os.close(controller)
        os.close(terminal)

    def test_bar_in_a_notebook(self):
        """With a stand-in for IPython, which the tests do not require."""
        with tempfile.TemporaryDirectory() as folder:
            package = pathlib.Path(folder) / "IPython"
            package.mkdir()
            (pathlib.Path(folder) / "tqdm.py").write_text("raise ImportError\n")
            (package / "__init__.py").write_text("def get_ipython():\n    class Shell:\n        has_trait = staticmethod("
                                                 "lambda name: name == 'kernel')\n    return Shell()\n")
            (package / "display.py").write_text("class HTML(str): pass\nclass display:\n    def __init__(self, html, "
                                                "display_id): pass\n    def update(self, html): print(html)\n")
            done = subprocess.run([sys.executable, "-c", f"import toliman; toliman.Simulator({SCENE})"
                                   ".frames(0, 2, progress=True)"], env={**os.environ, "PYTHONPATH": f"{PACKAGE}:{folder}"},
                                  capture_output=True, text=True)
        self.assertIn("<progress value='1.0000'></progress> frames", done.stdout)
        self.assertEqual(done.stderr, "")

    @unittest.skipUnless(importlib.util.find_spec("tqdm"), "needs tqdm")
    def test_bar_of_tqdm(self):
        shown = io.StringIO()
        shown.isatty = lambda: True
        with redirect_stderr(shown):
            bar = Bar()
            for stage, fraction in (("first", 0.5), ("first", 1), ("second", 0.25)):
                bar(stage, fraction)
            bar.close(True)
        lines = re.sub(r"#+|\x1b\S+", "", shown.getvalue()).split("\r")
        for text in ("first: 100%", "second: 100%"):
            self.assertTrue(any(line.startswith(text) for line in lines), lines)
        self.assertTrue(re.search(r"\d\d:\d\d<\d\d:\d\d", lines[-1]), lines)

    def test_ctrl_c(self):
        """Interrupts a training after it has started, without any callback of the user."""
        code = ("import os, signal, threading, toliman\n"
                "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
                f"network = toliman.CAE(toliman.Simulator({SCENE}))\n"
                "threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT)).start()\n"
                "try:\n    network.train(steps=100000)\n"
                "except KeyboardInterrupt:\n    print('stopped', network.info.trained)\n"
                "assert signal.getsignal(signal.SIGINT) is signal.default_int_handler\n")
        start = time.monotonic()
        done = subprocess.run([sys.executable, "-c", code], env={**os.environ, "PYTHONPATH": str(PACKAGE)}, timeout=600,
                              capture_output=True, text=True)
        self.assertEqual((done.stdout, done.stderr), ("stopped False\n", ""))
        self.assertLess(time.monotonic() - start, 30)

    def test_other_threads_run_meanwhile(self):
        ticks, done = [], threading.Event()

        def tick():
            while not done.wait(0.01):
                ticks.append(1)
        thread = threading.Thread(target=tick)
        thread.start()
        network = toliman.CAE(self.simulator)
        network.train(steps=100)
        done.set()
        thread.join()
        self.assertGreater(len(ticks), 5)

    # promise: const-calls-run-together
    def test_const_calls_from_several_threads(self):
        frames = [None] * 4

        def make(place):
            frames[place] = self.simulator.frames(0, 20)
        threads = [threading.Thread(target=make, args=(place,)) for place in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        for same in frames[1:]:
            self.assertTrue((same == frames[0]).all())


class PatchedLibrary:
    """The library, with some functions replaced."""

    def __init__(self, **functions):
        self._name = "libold.so"
        self.__dict__.update(functions)

    def __getattr__(self, name):
        if name == "toliman_missing":
            raise AttributeError("libold.so: undefined symbol: toliman_missing")
        return getattr(_library.library, name)


class Importing(unittest.TestCase):
    def test_missing_library(self):
        with tempfile.TemporaryDirectory() as folder:
            package = pathlib.Path(folder) / "lib/python3/dist-packages"
            package.mkdir(parents=True)
            (package / "toliman").symlink_to(PACKAGE / "toliman")
            environment = {**os.environ, "PYTHONPATH": str(package), "TOLIMAN_LIBRARY": "/nowhere/libtoliman.so"}
            done = subprocess.run([sys.executable, "-c", "from toliman import CAE"], env=environment, capture_output=True, text=True)
        self.assertRegex(done.stderr, r"(?s)ImportError: libtoliman\.so\.0\.3 was not found: build it, install it, or set "
                                      r"TOLIMAN_LIBRARY to its path\. Tried:\n  /nowhere/libtoliman\.so: ")

    def test_package_at_any_location(self):
        """In a folder too close to the root to have a prefix; the system then searches for the library by name."""
        for path in ("/a/_library.py", "/_library.py"):
            with unittest.mock.patch.object(_library, "__file__", path), unittest.mock.patch.dict(os.environ):
                os.environ["TOLIMAN_LIBRARY"] = ""
                self.assertEqual(list(_library._candidates())[-1], _library.SONAME)

    def test_every_path_that_was_tried_is_named(self):
        with tempfile.TemporaryDirectory() as folder:
            package = pathlib.Path(folder) / "lib/python3/dist-packages/toliman"
            package.mkdir(parents=True)
            for source in (PACKAGE / "toliman").glob("*.py"):
                (package / source.name).write_text(source.read_text())
            environment = {name: value for name, value in os.environ.items() if name not in ("PYTHONPATH", "TOLIMAN_LIBRARY")}
            done = subprocess.run([sys.executable, "-S", "-c", f"import sys; sys.path += [{str(package.parent)!r}, "
                                   "'/usr/lib/python3/dist-packages']; import toliman; print(toliman.library_path())"],
                                  env=environment, capture_output=True, text=True)
            if done.returncode == 0:  # installed where the system searches
                self.assertEqual(done.stdout, "libtoliman.so.0.3\n")
                return
            for tried in (f"{package}/libtoliman.so.0.3", f"{folder}/lib/libtoliman.so.0.3", "\n  libtoliman.so.0.3"):
                self.assertIn(tried, done.stderr)

    def test_incompatible_library(self):
        def refused(why, **functions):
            with self.assertRaisesRegex(ImportError, f"libold.so does not fit these bindings.*{why}"):
                _library._fit(PatchedLibrary(**functions))
        refused("its ABI is 7, expected 2", toliman_abi_version=lambda: 7)

        def larger(name):
            return _library.library.toliman_get_struct_size(name) + 8
        _library._fit(PatchedLibrary(toliman_get_struct_size=larger))  # a newer library

        def smaller(name):
            return _library.library.toliman_get_struct_size(name) - (8 if name == b"toliman_period_peak" else 0)
        refused(r"its toliman_period_peak has \d+ bytes, expected \d+", toliman_get_struct_size=smaller)
        _raw.FUNCTIONS["toliman_missing"] = (None, (), "")
        self.addCleanup(_raw.FUNCTIONS.pop, "toliman_missing")
        refused("undefined symbol: toliman_missing")

    def test_struct_sizes_match_the_library(self):
        structs = [(name, kind) for name, kind in vars(_raw).items()
                   if inspect.isclass(kind) and issubclass(kind, ctypes.Structure) and getattr(kind, "_fields_", None)]
        self.assertGreater(len(structs), 25)
        for name, kind in structs:
            self.assertEqual(_library.library.toliman_get_struct_size(name.encode()), ctypes.sizeof(kind), name)

    def test_slow_kernels_are_reported_once(self):
        """With OpenBLAS forced to its oldest kernels."""
        code = ("import warnings, toliman\nwith warnings.catch_warnings(record=True) as caught:\n"
                f"    warnings.simplefilter('always')\n    toliman.Simulator({SCENE})\n    toliman.Simulator({SCENE})\n"
                "print(toliman.machine().blas_is_slow, [str(warning.message) for warning in caught])")
        done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True,
                              env={**os.environ, "PYTHONPATH": str(PACKAGE), "OPENBLAS_CORETYPE": "Prescott"})
        self.assertEqual(done.stderr, "")
        if done.stdout.startswith("True"):  # except on processors as old as that
            self.assertEqual(done.stdout.count("set OPENBLAS_CORETYPE="), 1)


if __name__ == "__main__":
    numpy.seterr(all="raise")
    unittest.main()
