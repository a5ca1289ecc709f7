"""The examples that follow a growing pair: all of them read the same files while these are written in pieces."""
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import time
import unittest

TOP = pathlib.Path(__file__).resolve().parents[2]
TOLIMAN = os.environ["TOLIMAN"]
PROGRAMS = pathlib.Path(TOLIMAN).parent
FRAMES, PERIOD = 200, 17


class Follow(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        scene = json.loads((TOP / "examples/scenes/chapter.json").read_text())
        scene["detector"]["shape"] = [96, 96]
        scene["signal"].update(amplitude_px=1e-4, period_days=PERIOD)
        scene["cadence"]["frames"] = FRAMES
        self.scene = self.folder / "small.json"
        self.scene.write_text(json.dumps(scene))
        subprocess.run([TOLIMAN, "simulate", str(self.scene), "--session", "day1", "--dtype", "u32le", "--out",
                        str(self.folder / "whole")], check=True, capture_output=True)

    def test_all_examples(self):
        names = ("day1_meta.jsonl", "day1_frames.bin")
        whole = {name: (self.folder / "whole" / name).read_bytes() for name in names}
        for name in names:
            (self.folder / name).touch()
        stem = str(self.folder / "day1")
        programs = [[str(PROGRAMS / "follow")], [str(PROGRAMS / "fortran_follow")],
                    [sys.executable, str(TOP / "examples/python/follow.py")]]
        running = [subprocess.Popen([*program, str(self.scene), stem, str(FRAMES)], stdout=subprocess.PIPE,
                                    stderr=subprocess.PIPE, text=True) for program in programs]
        for program in running:
            self.addCleanup(program.kill)
        for part in range(1, 5):
            time.sleep(0.3)
            self.assertEqual([program.poll() for program in running], [None] * 3)
            for name in names if part % 2 else reversed(names):
                with (self.folder / name).open("ab") as stream:
                    stream.write(whole[name][len(whole[name]) * (part - 1) // 4:len(whole[name]) * part // 4])
        outputs = set()
        for program in running:
            output, errors = program.communicate(timeout=600)
            self.assertEqual(errors, "")
            self.assertEqual(program.returncode, 0)
            self.assertRegex(output, r"^period \d+\.\d{3} \+- \d+\.\d{3} days\n$")
            self.assertAlmostEqual(float(output.split()[1]), PERIOD, delta=0.2)
            outputs.add(output)
        self.assertEqual(len(outputs), 1)


if __name__ == "__main__":
    unittest.main()
