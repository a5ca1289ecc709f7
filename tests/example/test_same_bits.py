"""Examples that promise bits: a tracker that gets frames late, twice, out of order, in two passes and killed, beside the
same frames pushed one after the other; and shards of several threads beside one."""
import ctypes
import math
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import time
import unittest

TOP = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(TOP / "bindings" / "python"))
sys.dont_write_bytecode = True

from toliman import _raw

library = ctypes.CDLL(os.environ["TOLIMAN_LIBRARY"])
_raw.declare(library)
PROGRAMS = pathlib.Path(os.environ["TOLIMAN"]).parent
SCENE = TOP / "examples" / "scenes" / "chapter.json"
N, DAY_NS, PERIOD = 1095, 86400 * 10**9, 365


def must(status):
    if status != _raw.TOLIMAN_OK:
        raise AssertionError(library.toliman_last_error().decode())


def made(kind, create, *arguments):
    handle = ctypes.POINTER(kind)()
    must(create(*arguments, ctypes.byref(handle)))
    return handle


def bytes_of(period):
    needed = ctypes.c_size_t()
    must(library.toliman_period_save(period, None, 0, ctypes.byref(needed)))
    state = ctypes.create_string_buffer(needed.value)
    must(library.toliman_period_save(period, state, needed.value, ctypes.byref(needed)))
    return state.raw


def pushed_in_order():
    """A periodogram of its own, and one frame after the other."""
    sim = made(_raw.toliman_sim, library.toliman_sim_create, os.fsencode(SCENE), None)
    linear = made(_raw.toliman_linear, library.toliman_linear_create, sim, None)
    sigma, value, day, moved = (ctypes.c_double() for _ in range(4))
    must(library.toliman_linear_get_sigma(linear, ctypes.byref(sigma)))
    options = _raw.toliman_period_options()
    library.toliman_period_options_init(ctypes.byref(options))
    options.sigma_floor, options.unit_ns = sigma, DAY_NS
    options.value_bound = 2.0 ** math.ceil(math.log2(10000 * sigma.value))
    period = made(_raw.toliman_period, library.toliman_period_create, 1.5 / N, 0.1 / N, 5461, ctypes.byref(options))
    image = (ctypes.c_double * 256**2)()
    for k in range(N):
        must(library.toliman_sim_get_series(sim, k, 1, ctypes.byref(day), ctypes.byref(moved)))
        must(library.toliman_sim_frame(sim, moved, 1, k, image, 256))
        must(library.toliman_linear_encode(linear, image, 256, ctypes.byref(value)))
        must(library.toliman_period_push_ns(period, k * DAY_NS, value, sigma))
    return bytes_of(period)


def tracked(folder):
    """The periodogram that a folder holds."""
    options, name = _raw.toliman_track_options(), os.fsencode(folder)
    must(library.toliman_track_load_options(name, ctypes.byref(options)))  # which keeps the name
    options.flags = _raw.TOLIMAN_TRACK_READ_ONLY
    track = made(_raw.toliman_track, library.toliman_track_create, ctypes.byref(options))
    return bytes_of(made(_raw.toliman_period, library.toliman_track_get_period, track))


def found(output):
    return [float(number) for number in re.search(r"period (\S+) \+- (\S+) days of 1095 frames\n$", output).groups()]


class Incremental(unittest.TestCase):
    def setUp(self):
        kept = tempfile.TemporaryDirectory()
        self.addCleanup(kept.cleanup)
        self.folder = pathlib.Path(kept.name)

    def command(self, first, end, state="state"):
        return [PROGRAMS / "incremental", SCENE, self.folder / state, str(first), str(end)]

    def track(self, first, end, state="state"):
        return subprocess.run(self.command(first, end, state), check=True, capture_output=True, text=True).stdout

    def test_two_passes_and_a_kill(self):
        lines = self.track(0, 600).splitlines()
        self.assertEqual(lines[0], "0 frames are in")
        changes = [re.fullmatch(r"frame \d+: period (\S+) days, log10 FAP (\S+)", line) for line in lines[1:-1]]
        self.assertGreater(len(changes), 3)
        periods = [float(change[1]) for change in changes]
        self.assertTrue(all(abs(a - b) >= 0.049 * b for a, b in zip(periods, periods[1:])), periods)
        self.assertTrue(all(float(change[2]) < -3 for change in changes), lines)
        ledger = self.folder / "state" / "ledger.tlml"
        before = ledger.stat().st_size
        with subprocess.Popen(self.command(500, N), stdout=subprocess.DEVNULL) as killed:
            while killed.poll() is None and ledger.stat().st_size < before + 64 * 64:
                time.sleep(0.001)
            killed.kill()
        self.assertEqual(killed.returncode, -9)
        output = self.track(500, N)
        self.assertGreater(int(output.split()[0]), 600)
        period, error = found(output)
        self.assertLess(abs(period - PERIOD), 3 * error)
        self.assertLess(error, 5)
        self.assertEqual(tracked(self.folder / "state"), pushed_in_order())


class Shards(unittest.TestCase):
    def run_shards(self, scene, threads):
        return subprocess.run([PROGRAMS / "shards", scene, str(threads)], capture_output=True, text=True)

    def test_any_number_of_threads(self):
        alone, three = (self.run_shards(SCENE, threads) for threads in (1, 3))
        self.assertEqual((alone.returncode, alone.stdout), (0, three.stdout))
        self.assertAlmostEqual(float(alone.stdout.split()[1]), PERIOD, delta=10)

    def test_failure_of_a_thread_is_told(self):
        missing = self.run_shards("none.json", 2)
        self.assertEqual((missing.returncode, missing.stdout), (1, ""))
        self.assertEqual(missing.stderr, "TOLIMAN_E_NOT_FOUND: none.json: No such file or directory\n")


if __name__ == "__main__":
    unittest.main()
