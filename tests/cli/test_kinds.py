"""What the program says of a file of another kind than it wants, and where it looks for a scene's name."""
import json
import pathlib
import unittest

import numpy
from astropy.io import fits
from program import PROGRAM, ProgramTest, one_wavelength

SHIPPED = pathlib.Path(PROGRAM).resolve().parents[1] / "share" / "toliman" / "scenes"
FILES = {
    "w.tlmw": (b"TLMW" + bytes(300000), "toliman weights"),
    "b.tlmb": (b"TLMB" + bytes(300000), "a bank of toliman networks"),
    "s.tlmp": (b"TLMP" + bytes(100), "a saved state of toliman period"),
    "s.tlml": (b"TLML" + bytes(100), "the ledger of a toliman state folder"),
    "s.tlms": (b"TLMS" + bytes(100), "the setup of a toliman state folder"),
    "s.tlmc": (b"TLMC" + bytes(100), "the checkpoint of a toliman state folder"),
    "rv.csv": (b"t,y\n0,1\n", "a CSV file"),
    "text": (b"\n a text in \xc3\xbc\n", "a text file"),
    "p.json": (b'\xef\xbb\xbf{"n": 1,\n "schema" :\t"toliman-period/2"}', "JSON of schema toliman-period/2"),
    "s.json": (json.dumps(one_wavelength()).encode(), "a toliman scene"),
    "a.json": (b"[1]", "JSON"),
    "empty": (b"", ""),
}


FOLDERS = ("void", "state", "run", "plain", "table")


class Kinds(ProgramTest):
    def setUp(self):
        super().setUp()
        for name, (content, _) in FILES.items():
            (self.folder / name).write_bytes(content)
        numpy.save(self.folder / "f.npy", numpy.zeros((2, 8, 8)))
        fits.writeto(self.folder / "f.fits", numpy.zeros((2, 8, 8)))
        self.names = {name: what for name, (_, what) in FILES.items()} | {"f.npy": "a NumPy array", "f.fits": "a FITS file"}
        for name, inside, what in (("void", None, "an empty folder"), ("state", "ledger.tlml", "a toliman state folder"),
                                   ("run", "result.json", "a folder of toliman run"), ("plain", "x", "a folder"),
                                   ("table", "experiment.json", "a folder of toliman.experiment")):
            (self.folder / name).mkdir()
            if inside:
                (self.folder / name / inside).touch()
            self.names[name] = what

    def refuse_kinds(self, wanted, names, *commands):
        """Of each file in place of None in each command."""
        for name in names:
            reason = f"is {self.names[name]}, not {wanted}\n" if self.names[name] else "is empty\n"
            for command in commands:
                with self.subTest(name, command=command):
                    self.refuse(3, f"toliman: {name}: {reason}", arguments=[name if word is None else word for word in command])

    def test_wanted(self):
        track = ("track", "--state", "x", "--mission-days", "9", "--dtype", "u16le", "void")
        self.refuse_kinds("a toliman scene (JSON)", ("p.json", "empty", "void"), ("plan", None))  # test_frames has all kinds
        self.refuse_kinds("a toliman scene (JSON)", ("w.tlmw",), ("run", None), ("train", None, "--out", "x"), ("pupil", None),
                          ("simulate", None, "--out", "x.npy"), (*track, "--template", None))
        self.refuse_kinds("toliman weights", ("s.json", "f.npy", "s.tlmp", "void"), ("encode", "--weights", None, "f.npy"))
        self.refuse_kinds("toliman weights", ("s.json",), ("train", "s.json", "--resume", None, "--out", "x"), (*track, "--weights", None))
        self.refuse_kinds("a bank of toliman networks", ("s.json",), ("encode", "--weights", None, "--fit", "s.json", "f.npy"))
        self.refuse_kinds("a series of t, y[, sigma]", ("w.tlmw", "s.tlml", "s.json", "f.fits", "state"), ("period", None))
        self.refuse_kinds("a saved state of toliman period", ("w.tlmw", "text"), ("merge", None, "s.tlmp", "--out", "x"),
                          ("period", "--from-state", None), ("merge", None, "--out", "x"))
        (self.folder / "noise").write_bytes(bytes(range(256)))
        self.refuse(3, 'noise: ', arguments=("encode", "--weights", "noise", "f.npy"))
        self.refuse(2, "a.json: ", arguments=("plan", "a.json"))  # JSON without a word of its schema is looked at further

    def test_frames(self):
        for name, what in self.names.items():
            if name not in ("f.npy", "f.fits"):
                self.refuse(2, f"IN {name}: ", f"; it is {what or 'empty'}\n", arguments=("convert", name, "x.npy"))
        for name, suffix in (("f.fits", "npy"), ("w.tlmw", "npy"), ("f.npy", "fits")):
            (self.folder / f"x.{suffix}").write_bytes((self.folder / name).read_bytes())
            self.refuse(3, f"x.{suffix}: ", f"; it is {self.names[name]}\n", arguments=("convert", f"x.{suffix}", "y.npy"))
        (self.folder / "folder.npy").mkdir()
        self.refuse(3, "folder.npy: ", "; it is an empty folder\n", arguments=("convert", "folder.npy", "y.npy"))

    def test_folders(self):
        self.refuse(3, "void: ", f"; it is {self.names['void']}\n", arguments=("report", "void"))
        (self.folder / "loop").symlink_to("loop")  # whom nothing is forbidden, this is
        self.refuse(3, "loop/in: ", arguments=("report", "loop/in"))

    def test_frames_of_another_width(self):
        self.run_program("train", "s.json", "--steps", "1", "--out", "net")
        encode = ("encode", "--weights", "net", "--shape", "256x256", "--dtype")
        self.refuse(2, "rv.csv: ", "--dtype", "; it is a CSV file\n", arguments=("encode", "--weights", "net", "rv.csv"))
        self.refuse(3, "rv.csv: ", "; it is a CSV file\n", arguments=(*encode, "u16le", "rv.csv"))
        numpy.zeros((3, 256, 256), "<u2").tofile(self.folder / "narrow")
        self.refuse(3, " 262144, ", "--dtype u16le it has 3 frames\n", arguments=(*encode, "u32le", "narrow"))
        for dtype, words, frames in (("u16le", "--dtype u32le the file has 3 frames, with u16le 6.\n", numpy.ones((3, 256, 256), "<u4")),
                                     ("u32le", "--dtype u16le the file has 2 frames, with u32le 1.\n", numpy.zeros((2, 256, 256), "<u2"))):
            frames.tofile(self.folder / "other")
            self.assertIn(words, self.run_program(*encode, dtype, "other").stderr)


class Names(ProgramTest):
    """The file itself is looked for first, then the scenes that are shipped."""

    def test_shipped_scene(self):
        done = self.run_program("plan", "chapter.json")
        self.assertEqual((done.returncode, done.stderr), (0, f"toliman: scene {SHIPPED}/chapter.json\n"))
        (self.folder / "chapter.json").write_text("{")
        self.refuse(3, "chapter.json: ", arguments=("plan", "chapter.json"))

    def test_nowhere(self):
        self.refuse(3, "none.json: ", str(SHIPPED), arguments=("plan", "none.json"))
        self.refuse(3, "chpater.json: ", "chapter.json?", arguments=("plan", "chpater.json"))
        self.refuse(3, "./chapter.json: ", arguments=("plan", "./chapter.json"))
        for command in (("period", "chapter.json"), ("period", "other.json")):
            self.refuse(3, f"{command[1]}: ", arguments=command)


if __name__ == "__main__":
    unittest.main()
