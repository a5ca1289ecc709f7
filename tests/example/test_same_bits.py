"""Examples that promise equal bits: a tracker that receives frames out of order, duplicated, in two passes and killed between
them, compared with the same frames pushed in order; and shards of several threads, compared with one."""
# promises: arrival-order-changes-no-bit, track-gives-same-bits
import json
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
sys.path.append(str(TOP / "build" / "python"))
sys.dont_write_bytecode = True

from toliman import Periodogram, Simulator, Template, Tracker

PROGRAMS = pathlib.Path(os.environ["TOLIMAN"]).parent
KEPT = tempfile.TemporaryDirectory()
SCENE, SMALL = (pathlib.Path(KEPT.name) / f"{name}.json" for name in ("scene", "small"))
N, DAY_NS, PERIOD = 1095, 86400 * 10**9, 365


def setUpModule():
    """The chapter's frames at one wavelength, also of 96 x 96 px, which a larger signal makes up for."""
    unittest.addModuleCleanup(KEPT.cleanup)
    scene = json.loads((TOP / "examples" / "scenes" / "chapter.json").read_text())
    scene["band"] = {"wavelength_nm": 580}
    SCENE.write_text(json.dumps(scene))
    scene["detector"]["shape"] = [96, 96]
    scene["signal"]["amplitude_px"] *= 1.5
    SMALL.write_text(json.dumps(scene))


def pushed_in_order():
    """The bytes of a periodogram of its own, that takes one frame after the other."""
    simulator = Simulator(SCENE)
    template = Template(simulator)
    period = Periodogram(1.5 / N, 0.1 / N, 5461, sigma_floor=template.sigma, unit_ns=DAY_NS,
                         value_bound=2.0 ** math.ceil(math.log2(10000 * template.sigma)))
    for k in range(N):
        period.push(k * DAY_NS, template.encode(simulator.frame(k)), ns=True)
    return period.to_bytes()


def tracked(folder):
    """Those of the periodogram that a folder holds."""
    with Tracker.open(folder) as tracker:
        return tracker.period.to_bytes()


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
        self.assertEqual(lines[0], "0 frames tracked so far")
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
        alone, three = (self.run_shards(SMALL, threads) for threads in (1, 3))
        self.assertEqual((alone.returncode, alone.stdout), (0, three.stdout))
        self.assertAlmostEqual(float(alone.stdout.split()[1]), PERIOD, delta=10)

    def test_failure_of_a_thread_is_told(self):
        missing = self.run_shards("none.json", 2)
        self.assertEqual((missing.returncode, missing.stdout), (1, ""))
        self.assertEqual(missing.stderr, "TOLIMAN_E_NOT_FOUND: none.json: No such file or directory\n")


if __name__ == "__main__":
    unittest.main()
