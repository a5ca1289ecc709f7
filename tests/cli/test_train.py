"""toliman train --resume: resumes by the file, to the same bytes; what it refuses; a signal before the first epoch."""
import json
import re
import signal
import subprocess
import unittest

import numpy
from program import PATIENCE, PROGRAM, ProgramTest, one_wavelength

UNSUPERVISED = ("train", "s.json", "--mode", "unsupervised")


class Resumed(ProgramTest):
    def setUp(self):
        super().setUp()
        self.write_scene(6)

    def write_scene(self, frames, **detector):
        scene = one_wavelength()
        scene["detector"].update(detector)
        scene["cadence"]["frames"] = frames
        (self.folder / "s.json").write_text(json.dumps(scene))

    def bytes_of(self, name):
        return (self.folder / name).read_bytes()

    def test_the_file_says_how(self):
        how = (*UNSUPERVISED, "--layout", "paper", "--input", "raw", "--seed", "7")
        self.succeed(*how, "--epochs", "3", "--out", "whole")
        self.succeed(*how, "--epochs", "2", "--out", "half")
        self.succeed("train", "s.json", "--resume", "half", "--epochs", "3", "--out", "half")
        self.assertEqual(self.bytes_of("half"), self.bytes_of("whole"))
        resume = ("train", "s.json", "--resume", "half", "--out", "x")
        for option in (("--seed", "7"), ("--mode", "tied"), ("--layout", "paper"), ("--input", "raw"), ("--steps", "9")):
            self.refuse(2, "--resume", option[0], arguments=(*resume, *option))
        self.refuse(2, "--epochs 2: must be at least 3, the epochs done in half",
                    arguments=(*resume, "--epochs", "2"))

    def test_crop_that_follows_the_image(self):
        """A frame moved by a pixel has the same latent; the file says how."""
        self.refuse(2, "detector.shape = [256, 256]: must exceed [256, 256] px for a crop that follows the image",
                    arguments=("train", "s.json", "--centre", "image", "--out", "x"))
        self.refuse(2, "--centre image: the networks of a bank follow the fitted stars",
                    arguments=("train", "s.json", "--bank", "frames", "--centre", "image", "--out", "x"))
        self.write_scene(2, shape=[260, 264])
        self.succeed(*UNSUPERVISED, "--centre", "image", "--epochs", "1", "--out", "w")
        self.refuse(2, "--centre", "--resume", arguments=("train", "s.json", "--resume", "w", "--centre", "image", "--out", "x"))
        self.succeed("simulate", "s.json", "--out", "f.npy")
        numpy.save(self.folder / "moved.npy", numpy.roll(numpy.load(self.folder / "f.npy"), (1, -3), axis=(1, 2)))
        latents = [self.succeed("encode", "--weights", "w", name) for name in ("f.npy", "moved.npy")]
        self.assertEqual(*(re.sub(r"\w+\.npy", "", text) for text in latents))

    def test_log(self):
        self.write_scene(12)
        how = (*UNSUPERVISED, "--layout", "paper", "--input", "raw")
        self.succeed(*how, "--epochs", "12", "--log", "whole.csv", "--out", "whole")
        mark, head, *rows = (self.folder / "whole.csv").read_text().splitlines()
        self.assertEqual(mark, "# epochs of an unsupervised training; log10_fap: of the latents of frames")
        rows = [dict(zip(head.split(","), row.split(","))) for row in rows]
        self.assertEqual([row["epoch"] for row in rows], [str(k) for k in range(13)])
        self.assertTrue(rows[0]["log10_fap_fresh"] and not rows[0]["loss"])  # of the random weights
        for row in rows[1:]:
            self.assertTrue(0.999 < float(row["validation_loss"]) / float(row["mmse"]) < 1.001, row)
            self.assertEqual(row["log10_fap_fresh"] != "", row["epoch"] in ("10", "12"))
        self.assertFalse((self.folder / "whole.part").exists())
        # the frames of `simulate` are the fresh ones
        self.succeed("simulate", "s.json", "--out", "f.npy")
        (self.folder / "f.csv").write_text(self.succeed("encode", "--weights", "whole", "f.npy"))
        found = json.loads(self.succeed("period", "f.csv", "--columns", "frame,latent", "--json"))
        self.assertAlmostEqual(found["peak"]["log10_fap"], float(rows[-1]["log10_fap_fresh"]), delta=0.006)
        # a resumed training continues the log: to the same lines
        self.succeed(*how, "--epochs", "10", "--log", "half.csv", "--out", "half")
        self.succeed("train", "s.json", "--resume", "half", "--epochs", "12", "--log", "half.csv", "--out", "half")
        self.assertEqual(self.bytes_of("half.csv"), self.bytes_of("whole.csv"))
        self.assertEqual(self.bytes_of("half"), self.bytes_of("whole"))

    def test_logs_that_are_refused(self):
        self.refuse(2, "--log: is for unsupervised training", arguments=("train", "s.json", "--log", "l.csv", "--out", "x"))
        self.refuse(2, "--log: is for unsupervised training",
                    arguments=("train", "s.json", "--bank", "frames", "--log", "l.csv", "--out", "x"))
        (self.folder / "notes.csv").write_text("epoch\n")
        self.refuse(6, "notes.csv", arguments=(*UNSUPERVISED, "--epochs", "1", "--log", "notes.csv", "--out", "x"))
        self.succeed(*UNSUPERVISED, "--epochs", "1", "--out", "one")
        self.refuse(3, "notes.csv: is not the log of an unsupervised training",
                    arguments=("train", "s.json", "--resume", "one", "--epochs", "2", "--log", "notes.csv", "--out", "x"))
        self.write_scene(4)
        self.refuse(2, "cadence.frames = 4: must be in [5, 400000] for --log",
                    arguments=(*UNSUPERVISED, "--log", "l.csv", "--out", "x"))

    def test_dependent_nuisances(self):
        scene = json.loads((self.folder / "s.json").read_text())
        del scene["stars"]["B"]
        scene["binary"] = {"offsets_px": {"A": [4, 0]}}
        scene["preprocess"] = {"project": ["shift_y", "roll"]}
        (self.folder / "single.json").write_text(json.dumps(scene))
        done = self.run_program("train", "single.json", "--steps", "1", "--out", "x")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("single.json: preprocess.project: roll is a combination of shift_y (1.00): it is dropped", done.stderr)

    def test_nothing_to_go_on_with(self):
        self.succeed("train", "s.json", "--steps", "2", "--out", "tied")
        self.succeed(*UNSUPERVISED, "--epochs", "1", "--payload", "fp16", "--out", "narrow")
        for name in ("tied", "narrow"):
            self.refuse(2, name + ": contains no training to resume",
                        arguments=("train", "s.json", "--resume", name, "--out", "x"))

    def test_options_of_the_other_mode(self):
        self.refuse(2, "--epochs: is for unsupervised training", arguments=("train", "s.json", "--epochs", "2", "--out", "x"))
        self.refuse(2, "--steps: is for tied training", arguments=(*UNSUPERVISED, "--steps", "2", "--out", "x"))
        self.refuse(2, "--input raw", "--mode unsupervised", arguments=("train", "s.json", "--input", "raw", "--out", "x"))
        self.write_scene(1)
        self.refuse(2, "s.json: cadence.frames = 1", arguments=(*UNSUPERVISED, "--out", "x"))

    def test_a_signal_before_the_first_epoch(self):
        self.write_scene(600)
        (self.folder / "w").write_text("kept")
        command = [PROGRAM, "--progress=json", *UNSUPERVISED, "--out", "w", "--force"]
        child = subprocess.Popen(command, cwd=self.folder, stderr=subprocess.PIPE, text=True)
        while '"progress":"frames"' not in child.stderr.readline():
            pass
        child.send_signal(signal.SIGINT)
        last = child.communicate(timeout=PATIENCE)[1].splitlines()[-1]
        self.assertEqual((child.returncode, last), (130, "toliman: stopped by a signal"))
        self.assertEqual(self.bytes_of("w"), b"kept")


if __name__ == "__main__":
    unittest.main()
