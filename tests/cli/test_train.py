"""toliman train: resumes by the file, to the same bytes, after a signal; what it refuses; payloads, read by an independent reader."""
import json
import re
import signal
import subprocess
import sys
import unittest

import numpy
from program import PATIENCE, PROGRAM, ROOT, ProgramTest, one_wavelength

sys.path.insert(0, str(ROOT / "tests" / "support"))
import tlmw  # noqa: E402

CORE = [128, 128]  # frames of the smallest network, which take the least time
UNSUPERVISED = ("train", "s.json", "--mode", "unsupervised")


class Resumed(ProgramTest):
    def setUp(self):
        super().setUp()
        self.write_scene(6)

    def write_scene(self, frames, shape=CORE, **detector):
        scene = one_wavelength()
        scene["detector"].update(shape=shape, **detector)
        scene["cadence"]["frames"] = frames
        (self.folder / "s.json").write_text(json.dumps(scene))

    def bytes_of(self, name):
        return (self.folder / name).read_bytes()

    # promises: killed-trainings-resume, stopped-work-resumes
    def test_the_file_says_how(self):
        how = (*UNSUPERVISED, "--seed", "7")
        self.succeed(*how, "--epochs", "2", "--out", "whole")
        self.succeed(*how, "--epochs", "1", "--out", "half")
        self.succeed("train", "s.json", "--resume", "half", "--epochs", "2", "--out", "half")
        self.assertEqual(self.bytes_of("half"), self.bytes_of("whole"))
        resume = ("train", "s.json", "--resume", "half", "--out", "x")
        for option in (("--seed", "7"), ("--layout", "core"), ("--input", "raw")):
            self.refuse(2, "--resume", option[0], arguments=(*resume, *option))
        self.refuse(2, "--epochs 1: ", arguments=(*resume, "--epochs", "1"))

    def test_a_changed_file_of_the_scene(self):
        response = 1 + 0.01 * numpy.random.default_rng(1).standard_normal((128, 128))
        numpy.save(self.folder / "r.npy", response)
        self.write_scene(2, response="r.npy")
        how = (*UNSUPERVISED, "--epochs")
        self.succeed(*how, "1", "--out", "half")
        numpy.save(self.folder / "r.npy", response[::-1])
        resume = ("train", "s.json", "--resume", "half", "--epochs", "2", "--out", "half")
        self.refuse(2, "half: ", arguments=resume)
        numpy.save(self.folder / "r.npy", response)
        self.succeed(*resume)

    def test_crop_that_follows_the_image(self):
        """A frame moved by a pixel has the same latent; the file says how."""
        self.write_scene(2, shape=[256, 256])
        self.refuse(2, "detector.shape = [256, 256]: ", arguments=("train", "s.json", "--centre", "image", "--out", "x"))
        self.refuse(2, "--centre image: ",
                    arguments=("train", "s.json", "--bank", "frames", "--centre", "image", "--out", "x"))
        self.write_scene(2, shape=[260, 264])
        self.succeed(*UNSUPERVISED, "--centre", "image", "--epochs", "1", "--out", "w")
        self.refuse(2, "--centre", "--resume", arguments=("train", "s.json", "--resume", "w", "--centre", "image", "--out", "x"))
        self.succeed("simulate", "s.json", "--out", "f.npy")
        numpy.save(self.folder / "moved.npy", numpy.roll(numpy.load(self.folder / "f.npy"), (1, -3), axis=(1, 2)))
        latents = [self.succeed("encode", "--weights", "w", name) for name in ("f.npy", "moved.npy")]
        self.assertEqual(*(re.sub(r"\w+\.npy", "", text) for text in latents))

    def test_windows_of_the_camera(self):
        """Frames below 256x256 get the layout core, whose network refuses other frames; and those of 256x256 if asked."""
        self.write_scene(2, shape=[128, 140])
        how = ("train", "s.json", "--steps", "40", "--out", "core")
        self.succeed(*how)
        self.refuse(2, "detector.shape = [128, 140]: ", "[256, 256]",
                    arguments=(*how, "--layout", "flight"))
        self.refuse(2, "detector.shape = [128, 140]: ", arguments=(*how, "--layout", "paper", "--mode", "unsupervised"))
        self.succeed("simulate", "s.json", "--out", "f.npy")
        rows = self.succeed("encode", "--weights", "core", "f.npy").splitlines()[1:]
        self.assertTrue(all(abs(float(row.split(",")[2])) < 1e-3 for row in rows))
        self.write_scene(2, shape=[256, 256])
        self.succeed("simulate", "s.json", "--out", "large.npy")
        self.refuse(3, "large.npy: frames of 256x256", "128x140", arguments=("encode", "--weights", "core", "large.npy"))
        self.succeed("train", "s.json", "--out", "flight", "--steps", "10")
        self.refuse(3, "f.npy: frames of 128x140", "256x256", arguments=("encode", "--weights", "flight", "f.npy"))
        self.succeed("train", "s.json", "--layout", "core", "--steps", "40", "--out", "crop")
        self.succeed("encode", "--weights", "crop", "large.npy")

    def test_log(self):
        how = (*UNSUPERVISED, "--input", "raw")
        self.succeed(*how, "--epochs", "11", "--log", "whole.csv", "--out", "whole")
        mark, head, *rows = (self.folder / "whole.csv").read_text().splitlines()
        self.assertTrue(mark.startswith("# "))
        rows = [dict(zip(head.split(","), row.split(","))) for row in rows]
        self.assertEqual([row["epoch"] for row in rows], [str(k) for k in range(12)])
        self.assertTrue(rows[0]["log10_fap_fresh"] and not rows[0]["loss"])  # of the random weights
        for row in rows[1:]:
            self.assertTrue(0.999 < float(row["validation_loss"]) / float(row["mmse"]) < 1.001, row)
            self.assertEqual(row["log10_fap_fresh"] != "", row["epoch"] in ("10", "11"))
        self.assertFalse((self.folder / "whole.part").exists())
        # the frames of `simulate` are the fresh ones
        self.succeed("simulate", "s.json", "--out", "f.npy")
        (self.folder / "f.csv").write_text(self.succeed("encode", "--weights", "whole", "f.npy"))
        found = json.loads(self.succeed("period", "f.csv", "--columns", "frame,latent", "--json"))
        self.assertAlmostEqual(found["peak"]["log10_fap"], float(rows[-1]["log10_fap_fresh"]), delta=0.006)
        # a resumed training continues the log: to the same lines
        self.succeed(*how, "--epochs", "1", "--log", "half.csv", "--out", "half")
        self.succeed("train", "s.json", "--resume", "half", "--epochs", "2", "--log", "half.csv", "--out", "half")
        lines = (self.folder / "half.csv").read_text().splitlines()[2:]
        self.assertEqual([row["epoch"] for row in rows[:3]], [line.split(",")[0] for line in lines])
        for line, row in zip(lines, rows):
            resumed = dict(zip(head.split(","), line.split(",")))
            self.assertEqual([resumed[key] for key in ("loss", "validation_loss", "mmse")], [row[key] for key in ("loss", "validation_loss", "mmse")])

    def test_refusals(self):
        (self.folder / "notes.csv").write_text("epoch\n")
        self.succeed(*UNSUPERVISED, "--epochs", "1", "--out", "one")
        self.succeed(*UNSUPERVISED, "--epochs", "1", "--payload", "fp16", "--out", "narrow")
        self.succeed("train", "s.json", "--steps", "2", "--out", "tied")
        for code, text, *arguments in (
                (2, "--log: ", "train", "s.json", "--log", "l.csv"),
                (6, "notes.csv", *UNSUPERVISED, "--epochs", "1", "--log", "notes.csv"),
                (3, "notes.csv: ", "train", "s.json", "--resume", "one", "--epochs", "2", "--log", "notes.csv"),
                (2, "tied: ", "train", "s.json", "--resume", "tied"), (2, "narrow: ", "train", "s.json", "--resume", "narrow"),
                (2, "--epochs: ", "train", "s.json", "--epochs", "2"), (2, "--steps: ", *UNSUPERVISED, "--steps", "2"),
                (2, "--mode unsupervised", "train", "s.json", "--input", "raw")):
            self.refuse(code, text, arguments=(*arguments, "--out", "x"))
        self.write_scene(4)
        self.refuse(2, "cadence.frames = 4", arguments=(*UNSUPERVISED, "--log", "l.csv", "--out", "x"))

    def test_dependent_nuisances(self):
        scene = json.loads((self.folder / "s.json").read_text())
        del scene["stars"]["B"]
        scene["binary"] = {"offsets_px": {"A": [4, 0]}}
        scene["preprocess"] = {"project": ["shift_y", "roll"]}
        (self.folder / "single.json").write_text(json.dumps(scene))
        done = self.run_program("train", "single.json", "--steps", "1", "--out", "x")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("single.json: preprocess.project: roll ", done.stderr)

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


class Stopped(ProgramTest):
    def setUp(self):
        super().setUp()
        scene = one_wavelength()
        scene["detector"]["shape"] = CORE
        (self.folder / "s.json").write_text(json.dumps(scene))
        (self.folder / "other.json").write_text(json.dumps({**scene, "band": {"wavelength_nm": 590}}))

    def stop(self, *arguments):
        """Last two lines of a training that gets a signal as soon as it is under way."""
        child = subprocess.Popen([PROGRAM, "--progress=json", "train", "s.json", *arguments], cwd=self.folder, stderr=subprocess.PIPE,
                                 text=True)
        while '"progress":"train"' not in child.stderr.readline():
            pass
        child.send_signal(signal.SIGINT)
        lines = child.communicate(timeout=PATIENCE)[1].splitlines()[-2:]
        self.assertEqual((child.returncode, lines[1]), (130, "toliman: stopped by a signal"))
        return lines[0]

    def test_a_stopped_training_resumes(self):
        tied = ("--steps", "120")
        how = (*tied, "--seed", "5", "--payload", "bf16", "--out", "half")
        self.assertIn("--resume continues from half.part", self.stop(*how))
        self.assertEqual(sorted(path.name for path in self.folder.iterdir()), ["half.part", "other.json", "s.json"])
        self.succeed("train", "s.json", "--resume", "half.part", "--out", "resumed")
        self.assertIn("--resume half.part continues from half.part", self.stop("--resume", "half.part", "--out", "half"))
        self.succeed("train", "s.json", *tied, "--seed", "5", "--out", "whole")
        whole = (self.folder / "whole").read_bytes()
        self.assertEqual((self.folder / "resumed").read_bytes(), whole)
        self.assertNotEqual((self.folder / "half.part").read_bytes(), whole)
        self.refuse(2, "other.json", arguments=("train", "other.json", "--resume", "half.part", "--out", "x"))
        numpy.save(self.folder / "f.npy", numpy.zeros(CORE))
        self.refuse(3, "half.part: ", arguments=("encode", "--weights", "half.part", "f.npy"))
        self.succeed("train", "s.json", *how, "--resume")
        self.assertFalse((self.folder / "half.part").exists())
        # Such a dark frame is none of the scene's, which is told once; two files have one head.
        done = self.run_program("encode", "--weights", "whole", "f.npy", "f.npy")
        self.assertEqual((done.returncode, done.stderr.count("of the network's scene"), done.stdout.count("\n")), (0, 1, 3), done.stderr)


def bf16(values):
    fraction, exponent = numpy.frexp(values)
    return numpy.ldexp(numpy.rint(fraction * 256), exponent - 8)


def fp16(values, scale):
    return numpy.ldexp(numpy.ldexp(values, -scale).astype(numpy.float16).astype(float), scale)


class Payloads(ProgramTest):
    @classmethod
    def setUpClass(cls):
        cls.scene = json.dumps({**one_wavelength(), "preprocess": {"project": ["flux_a", "shift_x"]}})

    def blob(self, *arguments):
        (self.folder / "s.json").write_text(self.scene)
        self.succeed("train", "s.json", "--steps", "9", "--out", "w.tlmw", *arguments)
        return tlmw.Blob(self.folder / "w.tlmw")

    def test_numbers_are_the_nearest(self):
        exact, coarse, fine = self.blob(), self.blob("--payload", "bf16"), self.blob("--payload", "fp16")
        self.assertEqual((exact.weights_encoding, exact.planes_encoding, exact.projected), (0, 0, 2))
        self.assertEqual((coarse.weights_encoding, coarse.planes_encoding), (1, 1))
        self.assertEqual((fine.weights_encoding, fine.planes_encoding), (2, 2))
        for plane in range(2):  # the reference
            self.assertTrue((coarse.planes[plane] == exact.planes[plane]).all())
            self.assertTrue((fine.planes[plane] == exact.planes[plane]).all())
        self.assertGreater(abs(exact.planes[1]).max(), 1)  # without its low half it would be off by counts
        tensors = exact.weights + exact.planes[2:]
        for values, narrow in zip(tensors, coarse.weights + coarse.planes[2:]):
            self.assertTrue((narrow == bf16(values)).all())
        self.assertEqual(len(fine.scales), len(tensors))
        for values, narrow, scale in zip(tensors, fine.weights + fine.planes[2:], fine.scales):
            self.assertTrue((narrow == fp16(values, scale)).all())
            largest = numpy.ldexp(abs(narrow).max(), -scale)
            self.assertTrue(2**15 <= largest <= 65504 or (largest == 0 and scale == 0), largest)
        self.assertLess(coarse.size, 0.7 * exact.size)
        self.assertLess(fine.size, 0.75 * exact.size)
        self.succeed("simulate", "s.json", "--frames", "0:2", "--out", "f.npy")  # the narrow weights encode
        self.assertEqual(len(self.succeed("encode", "--weights", "w.tlmw", "f.npy").splitlines()), 3)


if __name__ == "__main__":
    unittest.main()
