"""Which files an output replaces: those that toliman wrote and empty ones; others with --force alone, and never its input."""
import json
import os
import unittest

import numpy
from astropy.io import fits
from pages import write_bench
from program import TINY, ProgramTest, one_wavelength

REASON = "exists and was not written by toliman: give --force to replace it\n"
SERIES = "t,y\n" + "".join(f"{k},{k % 7 / 7}\n" for k in range(50))


class Replace(ProgramTest):
    def setUp(self):
        super().setUp()
        (self.folder / "s.json").write_text(json.dumps(TINY))
        (self.folder / "rv.csv").write_text(SERIES)
        numpy.save(self.folder / "in.npy", numpy.ones((2, 8, 8)))
        self.succeed("period", "rv.csv", "--save-state", "in.tlmp")
        self.outputs = (  # what the program writes quickly: file, command
            ("psf.npy", ("psf", "s.json", "--out", "psf.npy")),
            ("psf.fits", ("psf", "s.json", "--out", "psf.fits")),
            ("f.npy", ("simulate", "s.json", "--out", "f.npy")),
            ("f.fits", ("simulate", "s.json", "--out", "f.fits")),
            ("f.bin", ("simulate", "s.json", "--out", "f.bin")),
            ("c.npy", ("convert", "in.npy", "c.npy")),
            ("c.fits", ("convert", "in.npy", "c.fits")),
            ("s.tlmp", ("period", "rv.csv", "--save-state", "s.tlmp")),
            ("p.npy", ("period", "rv.csv", "--power", "p.npy")),
            ("m.tlmp", ("merge", "in.tlmp", "b.tlmp", "--out", "m.tlmp")),
        )
        (self.folder / "b.csv").write_text(SERIES.replace("0,0.0\n", ""))
        self.succeed("period", "b.csv", "--from-state", "in.tlmp", "--save-state", "b.tlmp")

    def foreign(self):
        """Files of others, by suffix: such as differ from toliman's own in no more than who wrote them."""
        numpy.save(self.folder / "x.npy", numpy.ones((2, 8, 8)))
        fits.writeto(self.folder / "x.fits", numpy.ones((8, 8)), fits.Header({"CREATOR": "telescope"}), overwrite=True)
        return {suffix: (self.folder / f"x.{suffix}").read_bytes() for suffix in ("npy", "fits")} | {
            "bin": bytes(5 * 64), "tlmp": b"notes\n", "json": b'{"schema": "other/1"}', "csv": b"t,y\n0,1\n", "html": b"<!DOCTYPE html>\n"}

    def test_files_of_others(self):
        foreign = self.foreign()
        for name, command in self.outputs:
            with self.subTest(name):
                path, text = self.folder / name, foreign[name.partition(".")[2]]
                path.write_bytes(text)
                self.refuse(6, f"toliman: {name}: " + REASON, arguments=command)
                self.assertEqual(path.read_bytes(), text)
                self.assertEqual(self.run_program(*command, "--force").returncode, 0)
                self.assertNotEqual(path.read_bytes(), text)

    def test_own_and_empty_files(self):
        for name, command in self.outputs:
            with self.subTest(name):
                (self.folder / name).touch()
                for _ in range(1 if name == "f.bin" else 3):  # nothing marks headerless counts
                    self.assertEqual(self.run_program(*command).returncode, 0)
        self.refuse(6, "f.bin: " + REASON, arguments=("simulate", "s.json", "--out", "f.bin"))
        (self.folder / "link.npy").symlink_to("x.npy")
        self.foreign()
        self.refuse(6, "link.npy: " + REASON, arguments=("psf", "s.json", "--out", "link.npy"))

    def test_before_the_work(self):
        """What takes long looks first: at every file that it will write."""
        quick = self.folder / "quick.json"
        quick.write_text(json.dumps(one_wavelength()))
        (self.folder / "w").write_text("notes")
        (self.folder / "v.part").write_text("notes")
        self.refuse(6, "w: " + REASON, arguments=("train", quick, "--steps", "100000", "--out", "w"))
        self.refuse(6, "v.part: " + REASON, arguments=("train", quick, "--steps", "100000", "--out", "v"))
        for name in ("mask.npy", "scene.json", "pupil.json"):
            (self.folder / name[:4]).mkdir()
            (self.folder / name[:4] / name).write_text("notes")
            self.refuse(6, f"{name[:4]}/{name}: " + REASON, arguments=("pupil", quick, "--out", name[:4]))
        for name in ("experiment.csv", "experiment.md", "experiment.json"):
            (self.folder / name[-4:]).mkdir()
            (self.folder / name[-4:] / name).write_text("notes")
            self.refuse(6, f"{name[-4:]}/{name}: " + REASON, arguments=("experiment", quick, "--out", name[-4:]))

    def test_pages(self):
        write_bench(self.folder / "r")
        page = self.folder / "r" / "report" / "report.html"
        for _ in range(2):
            self.succeed("report", "r")
        for figures in (b"", page.read_bytes()[page.read_bytes().index(b"<figure"):]):  # as older versions began it
            page.write_bytes(b"<!DOCTYPE html>\n" + figures)
            if figures:
                self.succeed("report", "r")
            else:
                self.refuse(6, "r/report/report.html: " + REASON, arguments=("report", "r"))
        page.unlink()
        self.refuse(6, "r/report/figures/bench-b.svg: " + REASON, arguments=("report", "r"))
        self.succeed("report", "r", "--force")

    def test_the_input(self):
        """Under any name, and also with --force."""
        self.succeed("psf", "s.json", "--out", "x.npy")
        os.link(self.folder / "x.npy", self.folder / "hard.npy")
        (self.folder / "soft.npy").symlink_to("x.npy")
        os.link(self.folder / "s.json", self.folder / "s.npy")
        for command, out, name in (
            (("convert", "x.npy", "x.npy"), "x.npy", ""), (("convert", "x.npy", "./x.npy"), "./x.npy", " x.npy"),
            (("convert", "x.npy", "hard.npy"), "hard.npy", " x.npy"), (("convert", "soft.npy", "x.npy"), "x.npy", " soft.npy"),
            (("psf", "s.json", "--out", "s.npy"), "s.npy", " s.json"), (("simulate", "s.json", "--out", "s.npy"), "s.npy", " s.json"),
            (("train", "s.json", "--out", "s.json"), "s.json", ""),
        ):
            for force in ((), ("--force",)):
                self.refuse(2, f"toliman: {out}: is the input{name}: give another output\n", arguments=(*command, *force))

    def test_who_has_the_option(self):
        for name, has in (("run", 1), ("experiment", 1), ("psf", 1), ("simulate", 1), ("train", 1), ("convert", 1), ("period", 1),
                          ("merge", 1), ("pupil", 1), ("report", 1), ("encode", 0), ("track", 0), ("plan", 0)):
            self.assertEqual("--force" in self.succeed(name, "--help"), bool(has), name)


if __name__ == "__main__":
    unittest.main()
