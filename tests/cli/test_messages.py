"""Messages for mistyped words, seeds, files and scenes: the name, the value and what is allowed."""
import json
import os
import signal
import subprocess
import unittest

import numpy
from program import PATIENCE, PROGRAM, SCENES, TINY, ProgramTest, one_wavelength

CHAPTER = SCENES / "chapter.json"


class Words(ProgramTest):
    def test_unknown_words(self):
        for words, text in (
            (("psf", CHAPTER, "--oot", "x.npy"), "unknown option --oot (did you mean --out?)"),
            (("psf", CHAPTER, "--oot=x.npy"), "unknown option --oot (did you mean --out?)"),
            (("--progress", "none", "rum", "x"), "unknown command rum (did you mean run?)"),
            (("rum", "x"), "unknown command rum (did you mean run?)"),
            (("swim", "x"), "unknown command swim"),
            (("psf", CHAPTER, "--elephant"), "unknown option --elephant"),
        ):
            self.refuse(2, f"toliman: {text}\n", arguments=words)
        self.refuse(2, "unknown command statsu (did you mean status?)", arguments=("statsu", "x"))  # not the first, the nearest

    def test_unknown_values(self):
        for words, *texts in (
            (("--progress", "jsn", "doctor"), "--progress jsn: must be one of auto, json, none (did you mean json?)"),
            (("period", "x", "--fap", "baluv"), "--fap baluv: must be one of bootstrap, baluev, naive, sequential, single "
                                                "(did you mean baluev?)"),
            (("train", CHAPTER, "--out", "w", "--mode", "swim"), "--mode swim: must be one of tied, unsupervised\n"),
            (("track", "--state", "x", "--sync=fram", "f"), "--sync fram: must be one of frame, group, none (did you mean "
                                                            "frame?)"),
            (("psf", CHAPTER, "--star", "C", "--out", "x.npy"), "--star C: must be one of A, B, both\n"),
            (("simulate", CHAPTER, "--dtype", "u16", "--session", "s", "--out", "x"), "(did you mean u16le?)"),
            (("experiment", CHAPTER, "--out", "x", "--methods", "cae,tamplate"), "tamplate: ", "(did you mean template?)"),
            (("experiment", CHAPTER, "--out", "x", "--tables", "reel"), "--tables reel: must be one of real, equal, robust "
                                                                        "(did you mean real?)"),
        ):
            self.refuse(2, *texts, arguments=words)

    def test_values_of_another_form(self):
        for words, text in (
            (("period", "x", "--f0", "abc"), "--f0 abc: must be a number"),
            (("period", "x", "--nf", "1.5"), "--nf 1.5: must be a whole number"),
            (("period", "x", "--peaks", "0"), "--peaks 0: must be in [1, 64]"),
            (("period", "x", "--peaks=-1"), "--peaks -1: must be in [1, 64]"),
            (("track", "--mission-days", "2", "x"), "--mission-days 2: must be in [4, 1000000]"),
            (("period", "x", "--f0"), "--f0: needs a value"),
            (("period", "x", "--f0=1", "--f0=2"), "--f0: must be given once"),
        ):
            self.refuse(2, f"toliman: {text}\n", arguments=words)

    def test_arguments_too_many(self):
        for words, text in (
            (("period", "a.csv", "b.csv"), "unexpected argument b.csv: toliman period takes one FILE"),
            (("run", CHAPTER, "b.json", "c"), "unexpected argument b.json: toliman run takes one SCENE"),
            (("convert", "a", "b", "c d"), "unexpected argument c d: toliman convert takes one "),
            (("doctor", "a", "b"), "unexpected argument b: toliman doctor takes one "),
            (("period", "a.csv", "-q"), "unknown option -q\n"),
        ):
            self.refuse(2, f"toliman: {text}", arguments=words)

    def test_odd_values(self):
        self.refuse(2, "--sync frrr", "must be one of frame", arguments=("track", "--sync", "f" + 30000 * "r", "x"))
        self.refuse(2, "--sync fr?am: must be one of frame", "did you mean frame?", arguments=("track", "--sync", "fr\nam", "x"))
        self.refuse(2, "--sync f?[31mb: must be one of", arguments=("track", "--sync", "f\x1b[31mb", "x"))
        self.refuse(2, "unknown option --a?[31mb", arguments=("track", "--a\x1b[31mb", "x"))

    def test_what_is_missing(self):
        self.refuse(2, "toliman: a command is required: toliman --help lists them\n", arguments=())
        self.refuse(2, "toliman: a command is required: toliman --help lists them\n", arguments=("--progress", "none"))
        self.refuse(2, "--out is required", arguments=("psf", CHAPTER))
        self.refuse(2, "--state is required", arguments=("track", "--weights", "w.tlmw", "f.npy"))

    def test_help_is_a_command_too(self):
        self.assertEqual(self.succeed("help"), self.succeed("--help"))
        self.assertEqual(self.succeed("help", "period"), self.succeed("period", "--help"))

    def test_seeds(self):
        for command in (["train", CHAPTER, "--out", "w"], ["simulate", CHAPTER, "--out", "f.npy"], ["run", CHAPTER],
                        ["pupil", CHAPTER]):
            for seed in ("-1", "18446744073709551616", "1e3", "0x10", "seven"):
                with self.subTest(command=command, seed=seed):
                    self.refuse(2, f"--seed: {seed}: must be a whole number from 0 to 18446744073709551615",
                                arguments=(*command, f"--seed={seed}"))


class Small(ProgramTest):
    def scene(self, file="s.json", **groups):
        (self.folder / file).write_text(json.dumps({**TINY, **groups}))

    def psf_refused(self, code, *texts):
        self.refuse(code, *texts, arguments=("psf", "s.json", "--out", "x.npy"))

    def test_what_psf_cannot_do(self):
        self.scene()
        self.refuse(2, "--star B: s.json has only star A", arguments=("psf", "s.json", "--star", "B", "--out", "x.npy"))
        self.refuse(2, "--out x.txt: must end in .npy or .fits", arguments=("psf", "s.json", "--out", "x.txt"))

    def test_folder_that_is_a_file(self):
        (self.folder / "taken").write_text("")
        self.refuse(6, "taken: is not a folder", arguments=("run", CHAPTER, "--out", "taken"))

    def test_keys_and_ranges(self):
        self.scene(noise={"zebra": 1})
        self.psf_refused(2, "s.json: noise.zebra: unknown key; allowed keys: photon, read_e, seed")
        self.scene(noise={"sead": 1})
        self.psf_refused(2, "s.json: noise.sead: unknown key; did you mean \"seed\"?")
        self.scene(stars={"A": {"spectrum": {"kind": "blackbdy", "temperature_k": 5790}}})
        self.psf_refused(2, 's.json: stars.A.spectrum.kind = "blackbdy": must be one of ', 'did you mean "blackbody"?')
        self.scene(noise={"seed": 1e17})
        self.psf_refused(2, "s.json: noise.seed = 1e+17: must be in [0, 9007199254740991]")
        self.scene(detector={"shape": [2048, 2048], "pixel_scale_arcsec": 3})
        self.psf_refused(2, "s.json: telescope.pupil_samples = 32: must be at least ", "the maximum is 2048: ",
                         "reduce detector.shape or detector.pixel_scale_arcsec")

    def test_files_that_a_scene_names(self):
        missing = "No such file or directory"
        self.scene(stars={"A": {"spectrum": {"kind": "table", "file": "star.csv"}}})
        self.psf_refused(3, "s.json: stars.A.spectrum.file: ./star.csv: " + missing)
        for key, group in (("mask.file", {"mask": {"kind": "file", "file": "m.npy", "quantity": "opd_m"}}),
                           ("amplitude.file", {"amplitude": {"file": "m.npy"}}),
                           ("aberrations.opd_file", {"aberrations": {"opd_file": "m.npy"}})):
            self.scene(telescope={**TINY["telescope"], **group})
            self.psf_refused(3, f"s.json: telescope.{key}: ./m.npy: {missing}")

    def test_scene_files_from_elsewhere(self):
        for text in ("", " \n"):
            (self.folder / "s.json").write_text(text)
            self.psf_refused(3, "s.json: is empty")
        self.scene()
        self.succeed("psf", "s.json", "--out", "plain.npy")
        text = (self.folder / "s.json").read_bytes()
        (self.folder / "s.json").write_bytes(b"\xef\xbb\xbf" + text)
        self.succeed("psf", "s.json", "--out", "marked.npy")
        self.assertEqual((self.folder / "plain.npy").read_bytes(), (self.folder / "marked.npy").read_bytes())


class Weights(ProgramTest):
    def test_what_encode_cannot_read(self):
        (self.folder / "w.tlmw").write_bytes(b"not weights at all" * 20)
        self.refuse(3, "w.tlmw: is a text file, not toliman weights", arguments=("encode", "--weights", "w.tlmw", "f.npy"))
        (self.folder / "s.json").write_text(json.dumps(one_wavelength()))
        self.assertEqual(self.run_program("train", "s.json", "--steps", "1", "--out", "w.tlmw", "--force").returncode, 0)
        encode = ("encode", "--weights", "w.tlmw")
        raw = (*encode, "--dtype", "u16le", "--shape", "256x256")
        (self.folder / "short.bin").write_bytes(bytes(1000))
        for name in ("e.npy", "e.fits", "e.bin"):
            (self.folder / name).write_bytes(b"")
        numpy.save(self.folder / "f.npy", numpy.zeros((256, 256)))
        # `refuse` also holds that not even the head of the table is printed.
        self.refuse(3, "none.npy: No such file", arguments=(*encode, "none.npy"))
        self.refuse(3, "e.npy: is empty", arguments=(*encode, "e.npy"))
        self.refuse(3, "e.fits: is empty", arguments=(*encode, "e.fits"))
        self.refuse(3, "e.bin: is empty", arguments=(*raw, "e.bin"))
        self.refuse(3, "short.bin: has 1000 bytes: must be a multiple of 131072, the size of a frame of 256x256",
                    arguments=(*raw, "short.bin"))
        self.refuse(2, "f.npy: --dtype and --shape are for files without header", arguments=(*raw, "f.npy"))
        out = self.succeed(*encode, "f.npy", "f.npy").splitlines()
        self.assertEqual([out[0], len(out)], ["file,frame,latent_px,chi_square,chi_square_sigma,largest_residual,goodness,bad_pixels", 3])


class Stopped(ProgramTest):
    def setUp(self):
        super().setUp()
        (self.folder / "s.json").write_text(json.dumps(one_wavelength()))
        (self.folder / "other.json").write_text(json.dumps({**one_wavelength(), "band": {"wavelength_nm": 590}}))

    def stop(self, number, *arguments):
        """Exit code and last two lines of a training that gets a signal as soon as it is under way."""
        command = [PROGRAM, "--progress=json", "train", "s.json", *arguments]
        child = subprocess.Popen(command, cwd=self.folder, stderr=subprocess.PIPE, text=True)
        while '"progress":"train"' not in child.stderr.readline():
            pass
        child.send_signal(number)
        lines = child.communicate(timeout=PATIENCE)[1].splitlines()[-2:]
        return child.returncode, lines

    def test_a_signal_during_training(self):
        for number, code in ((signal.SIGINT, 130), (signal.SIGTERM, 143)):
            returned, lines = self.stop(number, "--steps", "100000", "--out", "w")
            self.assertEqual(returned, code)
            self.assertEqual(lines[0], "toliman: the same command with --resume continues from w.part")
            self.assertEqual(sorted(os.listdir(self.folder)), ["other.json", "s.json", "w.part"])
            self.assertEqual(lines[1], "toliman: stopped by a signal")

    def test_a_stopped_training_goes_on(self):
        tied = ("--steps", "400")
        how = (*tied, "--seed", "5", "--payload", "bf16", "--out", "half")
        self.stop(signal.SIGINT, *how)
        self.succeed("train", "s.json", "--resume", "half.part", "--out", "resumed")
        self.assertEqual(self.stop(signal.SIGINT, "--resume", "half.part", "--out", "half")[1][0],
                         "toliman: the same command with --resume half.part continues from half.part")
        self.succeed("train", "s.json", *tied, "--seed", "5", "--out", "whole")
        whole = (self.folder / "whole").read_bytes()
        self.assertEqual((self.folder / "resumed").read_bytes(), whole)
        self.assertNotEqual((self.folder / "half.part").read_bytes(), whole)
        self.refuse(2, "was trained for another scene",
                    arguments=("train", "other.json", "--resume", "half.part", "--out", "x"))
        numpy.save(self.folder / "f.npy", numpy.zeros((256, 256)))
        self.refuse(3, "half.part: contains an interrupted training, not a trained network",
                    arguments=("encode", "--weights", "half.part", "f.npy"))
        self.succeed("train", "s.json", *how, "--resume")
        self.assertFalse((self.folder / "half.part").exists())
        # Such a dark frame is none of the scene's.
        done = self.run_program("encode", "--weights", "whole", "f.npy", "f.npy")
        self.assertEqual((done.returncode, done.stderr.count("is this frame of the network's scene")), (0, 1))


if __name__ == "__main__":
    unittest.main()
