"""Messages for mistyped words, seeds, files and scenes: the name, the value and what is allowed."""
import json
import re
import unittest

from program import ROOT, SCENES, TINY, ProgramTest

CHAPTER = SCENES / "chapter.json"


class Words(ProgramTest):
    # promises: data-goes-to-stdout, exit-codes-are-the-same
    def test_unknown_words(self):
        for words, text in (
            (("psf", CHAPTER, "--oot", "x.npy"), "unknown option --oot (did you mean --out?)"),
            (("--progress", "none", "rum", "x"), "unknown command rum (did you mean run?)"),
            (("swim", "x"), "unknown command swim"),
            (("psf", CHAPTER, "--elephant"), "unknown option --elephant"),
        ):
            self.refuse(2, f"toliman: {text}\n", arguments=words)
        self.refuse(2, " statsu ", " status?", arguments=("statsu", "x"))  # not the first, the nearest

    # promises: data-goes-to-stdout, exit-codes-are-the-same
    def test_every_command(self):
        """A wrong option, a missing input: the code of its kind, a message and no data."""
        (self.folder / "s.json").write_text(json.dumps(TINY))
        missing = {"budget": (), "calibrate": ("f.fits", "--out", "o.json"), "coadd": ("--fit", "s.json", "--every", "1h", "--out", "o"),
                   "convert": ("o.npy",), "encode": ("--template", "s.json"), "period": (), "plan": (), "planet": (),
                   "psf": ("--out", "o.npy"), "pupil": ("--out", "o.npy"), "refit": ("alpha-cen",), "run": (),
                   "simulate": ("--out", "o.npy"), "status": (), "train": ("--out", "o.tlmw")}
        commands = {path.stem for path in (ROOT / "tools" / "cli" / "help").glob("*.txt")} - {"toliman", "options"}
        for command in sorted(commands):
            with self.subTest(command):
                self.refuse(2, " --elephant\n", arguments=(command, "--elephant"))
            if command in missing:
                done = self.run_program(command, "missing.fits", *missing[command])
                with self.subTest(command, missing=True):
                    self.assertEqual((done.returncode, done.stdout), (3, ""), done.stderr)
                    self.assertIn("missing.fits", done.stderr)

    def test_unknown_values(self):
        for words, *texts in (
            (("--progress", "jsn", "doctor"), "--progress jsn: must be one of auto, json, none (did you mean json?)"),
            (("period", "x", "--fap", "baluv"), "--fap baluv: ", "bootstrap, baluev, naive, sequential, single ", "baluev?"),
            (("train", CHAPTER, "--out", "w", "--mode", "swim"), "--mode swim: ", " tied, unsupervised\n"),
            (("track", "--state", "x", "--sync=fram", "f"), "--sync fram: ", " frame, group, none ", "frame?"),
            (("psf", CHAPTER, "--star", "C", "--out", "x.npy"), "--star C: ", " A, B, both\n"),
            (("simulate", CHAPTER, "--dtype", "u16", "--session", "s", "--out", "x"), "--dtype u16: ", "u16le?"),
        ):
            self.refuse(2, *texts, arguments=words)

    def test_values_of_another_form(self):
        for words, text in (
            (("period", "x", "--f0", "abc"), "--f0 abc: "),
            (("period", "x", "--nf", "1.5"), "--nf 1.5: "),
            (("period", "x", "--peaks", "0"), "--peaks 0: must be in [1, 64]\n"),
            (("period", "x", "--trend", "-1"), "--trend -1: must be in [0, 8]\n"),
            (("period", "x", "--f0", "nan"), "--f0 nan: "),
            (("simulate", CHAPTER, "--rate", "nan", "--duration", "1s", "--out", "o"), "--rate nan: "),
            (("period", "x", "--f0"), "--f0: "),
            (("period", "x", "--f0=1", "--f0=2"), "--f0: "),
        ):
            self.refuse(2, f"toliman: {text}", arguments=words)

    def test_arguments_too_many(self):
        for words, text in (
            (("period", "a.csv", "b.csv"), "unexpected argument b.csv: "),
            (("convert", "a", "b", "c d"), "unexpected argument c d: "),
            (("period", "a.csv", "-q"), "unknown option -q\n"),
        ):
            self.refuse(2, f"toliman: {text}", arguments=words)

    def test_odd_values(self):
        self.refuse(2, "--sync frrr", arguments=("track", "--sync", "f" + 30000 * "r", "x"))
        self.refuse(2, "--sync fr?am: ", arguments=("track", "--sync", "fr\nam", "x"))
        self.refuse(2, "--sync f?[31mb: ", arguments=("track", "--sync", "f\x1b[31mb", "x"))
        self.refuse(2, " --a?[31mb", arguments=("track", "--a\x1b[31mb", "x"))

    def test_what_is_missing(self):
        self.refuse(2, "toliman --help", arguments=())
        self.refuse(2, "--out is required", arguments=("psf", CHAPTER))
        self.refuse(2, "--state is required", arguments=("track", "--weights", "w.tlmw", "f.npy"))

    def test_help_is_a_command_too(self):
        self.assertEqual(self.succeed("help"), self.succeed("--help"))
        self.assertEqual(self.succeed("help", "period"), self.succeed("period", "--help"))

    def test_texts_of_options_are_used(self):
        folder = ROOT / "tools" / "cli" / "help"
        commands = {path.stem for path in folder.glob("*.txt")} - {"toliman", "options"}
        helps = {name: " ".join(self.succeed(name, "--help").split()) for name in commands}
        for entry in re.split(r"\n(?=\S)", (folder / "options.txt").read_text()):
            key, *text = entry.split("\n")
            *names, option = key.split()
            for named in [{name} for name in names] or [commands]:
                with self.subTest(option, commands=named):
                    self.assertTrue(any(f"{option} " in helps[name] and " ".join(" ".join(text).split()) in helps[name] for name in named))

    def test_seeds(self):
        for command in (["train", CHAPTER, "--out", "w"], ["simulate", CHAPTER, "--out", "f.npy"], ["run", CHAPTER], ["pupil", CHAPTER]):
            self.refuse(2, "--seed: -1: ", " 18446744073709551615\n", arguments=(*command, "--seed=-1"))
        for seed in ("18446744073709551616", "1e3", "0x10", "seven"):
            self.refuse(2, f"--seed: {seed}: ", arguments=("train", CHAPTER, "--out", "w", f"--seed={seed}"))


class Small(ProgramTest):
    def scene(self, file="s.json", **groups):
        (self.folder / file).write_text(json.dumps({**TINY, **groups}))

    def psf_refused(self, code, *texts):
        self.refuse(code, *texts, arguments=("psf", "s.json", "--out", "x.npy"))

    def test_what_psf_cannot_do(self):
        self.scene()
        self.refuse(2, "--star B: s.json ", arguments=("psf", "s.json", "--star", "B", "--out", "x.npy"))
        self.refuse(2, "--out x.txt: ", ".npy", ".fits", arguments=("psf", "s.json", "--out", "x.txt"))

    def test_folder_that_is_a_file(self):
        (self.folder / "taken").write_text("")
        self.refuse(6, "taken: ", arguments=("run", CHAPTER, "--out", "taken"))

    # promise: unknown-keys-are-refused
    def test_keys_and_ranges(self):
        self.scene(noise={"zebra": 1})
        self.psf_refused(2, "s.json: noise.zebra: ", ": photon, read_e, seed\n")
        self.scene(noise={"sead": 1})
        self.psf_refused(2, "s.json: noise.sead: ", '"seed"?')
        self.scene(stars={"A": {"spectrum": {"kind": "blackbdy", "temperature_k": 5790}}})
        self.psf_refused(2, 's.json: stars.A.spectrum.kind = "blackbdy": ', '"blackbody"?')
        self.scene(noise={"seed": 1e17})
        self.psf_refused(2, "s.json: noise.seed = 1e+17: ", "[0, 9007199254740991]")
        self.scene(detector={"shape": [2048, 2048], "pixel_scale_arcsec": 3})
        self.psf_refused(2, "s.json: telescope.pupil_samples = 32: ", " 2048: ",
                         "detector.shape", "detector.pixel_scale_arcsec")

    def test_files_that_a_scene_names(self):
        self.scene(stars={"A": {"spectrum": {"kind": "table", "file": "star.csv"}}})
        self.psf_refused(3, "s.json: stars.A.spectrum.file: ./star.csv: ")
        for key, group in (("mask.file", {"mask": {"kind": "file", "file": "m.npy", "quantity": "opd_m"}}),
                           ("amplitude.file", {"amplitude": {"file": "m.npy"}}),
                           ("aberrations.opd_file", {"aberrations": {"opd_file": "m.npy"}})):
            self.scene(telescope={**TINY["telescope"], **group})
            self.psf_refused(3, f"s.json: telescope.{key}: ./m.npy: ")

    def test_scene_files_from_elsewhere(self):
        for text in ("", " \n"):
            (self.folder / "s.json").write_text(text)
            self.psf_refused(3, "s.json: ")
        self.scene()
        self.succeed("psf", "s.json", "--out", "plain.npy")
        text = (self.folder / "s.json").read_bytes()
        (self.folder / "s.json").write_bytes(b"\xef\xbb\xbf" + text)
        self.succeed("psf", "s.json", "--out", "marked.npy")
        self.assertEqual((self.folder / "plain.npy").read_bytes(), (self.folder / "marked.npy").read_bytes())


if __name__ == "__main__":
    unittest.main()
