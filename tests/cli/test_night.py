"""toliman night, and the shell of a night: one line of a mission, what has changed since the last one, and the exit code of a wrong
instrument. Numbers are those of `toliman planet` and `status`."""
import argparse
import json
import logging
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

import numpy
from program import PROGRAM, ROOT, ProgramTest

sys.path += [str(ROOT / "build" / "python"), str(ROOT / "tests" / "bind"), str(ROOT / "examples" / "sky")]
import mission  # noqa: E402
from test_sky_campaign import SCENE  # noqa: E402

PERIOD, UAS = 120, 30


def setUpModule():
    logging.getLogger("toliman").setLevel(logging.ERROR)


class Night(ProgramTest):
    @classmethod
    def setUpClass(cls):
        """Frames of 240 days with a planet; their scene is known."""
        cls.top = pathlib.Path(cls.enterClassContext(tempfile.TemporaryDirectory()))
        (cls.top / "telescope.json").write_text(json.dumps(SCENE))
        mission.draw(argparse.Namespace(
            folder=cls.top / "run", seed=3, planet=[f"{PERIOD}:{UAS}"], none=False, frames=80, photons=1e11, side=0, cells=0, mid=0, drift=0,
            detector=False, scene=cls.top / "telescope.json"))
        scene = json.loads((cls.top / "run/truth/scene.json").read_text())
        scene["binary"]["orbit"] = "alpha-cen"
        (cls.top / "run/known.json").write_text(json.dumps(scene))
        wrong = json.loads(json.dumps(scene))
        wrong["telescope"]["aberrations"]["zernike_rms_nm"]["5"] += 3
        (cls.top / "run/wrong.json").write_text(json.dumps(wrong))

    def setUp(self):
        super().setUp()
        shutil.copytree(self.top, self.folder, dirs_exist_ok=True)

    def track(self, scene, state, *inputs):
        self.succeed("track", "--fit", f"run/{scene}", "--state", state, *inputs)

    def test_nights(self):
        """Orbit and windows are known up to the last frame, and grow."""
        pairs = sorted(path.name for path in (self.folder / "run/downlink").glob("*_meta.jsonl"))
        whole = {name: (self.folder / "run" / name).read_text() for name in ("craft.oem", "windows.csv")}
        (self.folder / "run/craft.oem").write_text("META_START".join(whole["craft.oem"].split("META_START")[:62]))
        last = mission.tai_ns(mission.START) + 62 * 3 * 86400 * 10**9
        lines = whole["windows.csv"].splitlines()
        (self.folder / "run/windows.csv").write_text(
            "\n".join(lines[:1] + [line for line in lines[1:] if int(line.split(",")[0]) < last]) + "\n")
        self.track("known.json", "state", *(f"run/downlink/{name}" for name in pairs[:2]))
        first = self.succeed("night", "state")
        for name, text in whole.items():
            (self.folder / "run" / name).write_text(text)
        self.track("known.json", "state", f"run/downlink/{pairs[2]}")
        done = self.run_program("night", "state", "--json")
        self.assertEqual(done.returncode, 0, done.stderr)
        said = json.loads(done.stdout)
        status, planet = (json.loads(self.succeed(*words, "--json")) for words in (("status", "state"), ("planet", "state")))
        best = planet["candidates"][0]
        self.assertEqual((said["frames"], said["log10_bayes"], said["is_planet"]), (status["accepted"], best["log10_bayes"], True))
        last = max(json.loads(line)["tai_ns"] for line in self.succeed("status", "state", "--records").splitlines())
        self.assertEqual(said["day"], str(numpy.datetime64(last, "ns"))[:10])
        earlier = int(first.split(": ")[1].split(" frames")[0])
        self.assertIn(f"{said['frames']} frames (+{said['frames'] - earlier} since 2029-11-", said["text"])
        self.assertAlmostEqual(float(said["text"].split("planet ")[1].split(" +-")[0]), best["period"][1], delta=0.1)
        self.assertTrue(said["text"].endswith("; instrument good"), said["text"])
        (self.folder / "state/night.json").write_text("")
        done = self.run_program("night", "state")
        self.assertEqual(done.returncode, 0)
        self.assertIn("state/night.json: ", done.stderr)
        self.assertNotIn("since", done.stdout)

    def test_a_wrong_instrument(self):
        """The log has the line, and the exit code is 4, also of the shell of a night."""
        script = [ROOT / "examples/shell/night.sh", "run/wrong.json", "state", "run/downlink", "--chi-limit", "1000"]
        done = subprocess.run(script, cwd=self.folder, capture_output=True, text=True, env={"TOLIMAN": PROGRAM})
        self.assertEqual(done.returncode, 4, done.stderr)
        self.assertIn("; INSTRUMENT: the chi-square of its frames is ", done.stdout)
        self.assertEqual((self.folder / "state.log").read_text(), done.stdout)
        script[1] = "no.json"
        done = subprocess.run(script, cwd=self.folder, capture_output=True, text=True, env={"TOLIMAN": PROGRAM})
        self.assertEqual((done.returncode, done.stdout), (3, ""))


if __name__ == "__main__":
    unittest.main()
