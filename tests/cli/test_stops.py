"""Signals: at any moment a command ends soon, with its exit code and one message, and leaves no part of a result."""
import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import time
import unittest

from pages import __main__, write_bench
from program import PATIENCE, PROGRAM, SCENES, ProgramTest, long, one_wavelength

STOPPED = "toliman: stopped by a signal"
SOON = 6  # s, including 1 s in which the program may stop by itself; a call for the slow scene takes twice as long
WAIT = 0.002  # s, between two views of a folder


def slow_scene():
    """Its frames are propagated one by one: 48 of them, one call, take 12 s on one processor."""
    scene = json.loads((SCENES / "chapter.json").read_text())
    scene["telescope"]["pupil_samples"] = 512
    scene["band"] = {"min_nm": 530, "max_nm": 640, "step_nm": 1}
    scene["binary"] = {"orbit": "alpha-cen", "date": 2028, "moving": True}
    scene["cadence"].update(frames=48, interval_days=30)
    return scene


def on_one_processor():
    os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})


class Stops(ProgramTest):
    def setUp(self):
        super().setUp()
        self.inputs = self.folder / "inputs"
        self.inputs.mkdir()
        self.work = self.folder / "work"
        self.work.mkdir()

    def start(self, *arguments, **options):
        return subprocess.Popen([PROGRAM, "--progress=json", *map(str, arguments)], cwd=self.work, stdout=subprocess.PIPE,
                                stderr=subprocess.PIPE, text=True, **options)

    def left(self):
        return sorted(str(path.relative_to(self.work)) for path in self.work.rglob("*"))

    def stop(self, child, number):
        """Sends the signal; exit code, seconds and the last line on stderr."""
        self.assertIsNone(child.poll(), child)
        start = time.monotonic()
        child.send_signal(number)
        out, err = child.communicate(timeout=PATIENCE)
        self.assertEqual(out, "")
        return child.returncode, time.monotonic() - start, err.splitlines()[-1]

    # promise: signals-leave-no-part
    @long
    def test_during_a_long_call_of_the_library(self):
        """The folder shows that the command is past the set-up, or before it in case of train."""
        scene = self.inputs / "slow.json"
        scene.write_text(json.dumps(slow_scene()))
        cases = ((("simulate", scene, "--out", "x.npy"), "x.npy.0.tmp", STOPPED),
                 (("simulate", scene, "--out", "x.fits"), "x.fits.0.tmp", STOPPED),
                 (("simulate", scene, "--out", "p", "--session", "s", "--dtype", "u32le"), "p/s_meta.jsonl.0.tmp", STOPPED),
                 (("run", scene, "--out", "r"), "r/weights.tlmb.0.tmp", STOPPED),
                 (("train", scene, "--mode", "unsupervised", "--out", "w"), "w.0.tmp", STOPPED))
        for (arguments, mark, message), (number, code) in zip(cases, 2 * ((signal.SIGTERM, 143), (signal.SIGINT, 130),
                                                                            (signal.SIGHUP, 129))):
            with self.subTest(command=arguments[0], mark=mark):
                with self.start(*arguments, preexec_fn=on_one_processor) as child:
                    while child.poll() is None and not (self.work / mark).exists():
                        time.sleep(WAIT)
                    returned, seconds, last = self.stop(child, number)
                self.assertEqual((returned, last.partition(";")[0]), (code, message))
                self.assertLess(seconds, SOON)
                self.assertEqual(self.left(), [])

    # promise: signals-leave-no-part
    def test_at_each_stage(self):
        scene = one_wavelength()
        scene["detector"]["shape"] = [128, 128]
        scene["cadence"]["frames"] = 2000
        few, short, long = (self.inputs / f"{name}.json" for name in ("few", "short", "long"))
        short.write_text(json.dumps(scene))
        few.write_text(json.dumps({**scene, "cadence": {**scene["cadence"], "frames": 50}}))
        scene["telescope"]["pupil_samples"] = 1024
        long.write_text(json.dumps(scene))
        for stage, scene in (("propagate", long), ("frames", short), ("controls", few)):
            with self.subTest(stage):
                with self.start("run", scene, "--out", "r") as child:
                    while f'"progress":"{stage}"' not in child.stderr.readline():
                        self.assertIsNone(child.poll())
                    returned, _, last = self.stop(child, signal.SIGTERM)
                self.assertEqual((returned, last), (143, STOPPED))
                self.assertEqual(self.left(), [])

    # promises: exit-codes-are-the-same, signals-leave-no-part
    def test_report(self):
        """Also while Python starts: the signal is blocked until Python handles it."""
        write_bench(self.work / "b")
        before = self.left()
        for number, code in ((signal.SIGINT, 130), (signal.SIGTERM, 143)):
            with self.subTest(number), self.start("report", "b") as child:
                child.stderr.readline()  # the stage report
                returned, _, last = self.stop(child, number)
                self.assertEqual((returned, last), (code, STOPPED))
                self.assertEqual(self.left(), before)

    def test_report_writes_all_files_or_none(self):
        """A signal while the temporary files are written removes them; one between two renames is handled after the last."""
        write_bench(self.work / "b")
        before = self.left()
        __main__.report(__main__.parse([str(self.work / "b")]))
        whole = self.left()
        self.assertGreater(len(whole), len(before) + 3)
        code = """
import os, signal, sys
from toliman import _output
from toliman.report import __main__
owner, name = {"Temporary": _output, "replace": os}[sys.argv[1]], sys.argv[1]
work = getattr(owner, name)
def interrupted(*arguments):
    os.kill(os.getpid(), signal.SIGTERM)
    return work(*arguments)
setattr(owner, name, interrupted)
sys.exit(__main__.main(["b"]))
"""
        for moment, left in (("Temporary", before), ("replace", whole)):
            with self.subTest(moment):
                shutil.rmtree(self.work / "b" / "report", ignore_errors=True)
                done = subprocess.run([sys.executable, "-c", code, moment], cwd=self.work, capture_output=True, text=True,
                                      env={**os.environ, "PYTHONPATH": str(pathlib.Path(PROGRAM).parents[1] / "python")})
                self.assertEqual((done.returncode, done.stderr), (143, STOPPED + "\n"))
                self.assertEqual(self.left(), left)


if __name__ == "__main__":
    unittest.main()
