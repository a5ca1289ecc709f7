"""What the program says of a file of another kind than it wants: what the file is."""
import json
import unittest

import numpy
from astropy.io import fits
from program import ProgramTest, one_wavelength

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
                                   ("table", "experiment.json", "a folder of toliman experiment")):
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

    def test_scenes(self):
        others = [name for name in self.names if name not in ("s.json", "a.json")]
        self.refuse_kinds("a toliman scene (JSON)", others, ("psf", None, "--out", "x.npy"), ("plan", None))
        self.refuse_kinds("a toliman scene (JSON)", ("w.tlmw", "text"), ("run", None), ("train", None, "--out", "x"),
                          ("simulate", None, "--out", "x.npy"), ("pupil", None), ("experiment", None, "--out", "x"),
                          ("track", "--template", None, "--state", "x", "--mission-days", "9", "--dtype", "u16le", "void"))
        # What is JSON without a word of its schema is looked at further.
        self.refuse(2, "a.json: ", arguments=("plan", "a.json"))

    def test_weights(self):
        others = [name for name in self.names if name not in ("w.tlmw", "b.tlmb")]
        self.refuse_kinds("toliman weights", others, ("encode", "--weights", None, "f.npy"))
        self.refuse_kinds("a bank of toliman networks", others, ("encode", "--weights", None, "--fit", "s.json", "f.npy"))
        self.refuse_kinds("toliman weights", ("s.json", "f.npy"), ("train", "s.json", "--resume", None, "--out", "x"),
                          ("track", "--weights", None, "--state", "x", "--mission-days", "9", "--dtype", "u16le", "void"))
        (self.folder / "noise").write_bytes(bytes(range(256)))
        self.refuse(3, 'noise: weights blob: does not start with "TLMW"', arguments=("encode", "--weights", "noise", "f.npy"))

    def test_series_and_sums(self):
        self.refuse_kinds("a series of t, y[, sigma]", ("w.tlmw", "s.tlml", "s.json", "f.fits", "state"), ("period", None))
        others = [name for name in self.names if name not in ("s.tlmp", *FOLDERS)]
        self.refuse_kinds("a saved state of toliman period", others, ("merge", None, "s.tlmp", "--out", "x"))
        self.refuse_kinds("a saved state of toliman period", ("w.tlmw",), ("period", "--from-state", None),
                          ("merge", None, "--out", "x"))

    def test_the_name_of_a_shipped_scene(self):
        track = ("track", "--weights", "chapter.json", "--state", "x", "--mission-days", "9", "--dtype", "u16le", "void")
        for wanted, command in (("a series of t, y[, sigma]", ("period", "chapter.json")), ("toliman weights", track)):
            self.refuse(3, f"chapter.json: No such file; the shipped scene of this name is not {wanted}\n",
                        arguments=command)
        self.refuse(3, "other.json: No such file or directory\n", arguments=("period", "other.json"))

    def test_frames(self):
        for name, what in self.names.items():
            if name not in ("f.npy", "f.fits"):
                self.refuse(2, f"IN {name}: must end in .npy, .fits or .fits.fz; it is {what or 'empty'}\n",
                            arguments=("convert", name, "x.npy"))
        for name, suffix, wanted in (("f.fits", "npy", ".npy"), ("w.tlmw", "npy", ".npy"), ("f.npy", "fits", "FITS")):
            (self.folder / f"x.{suffix}").write_bytes((self.folder / name).read_bytes())
            self.refuse(3, f"x.{suffix}: is not a {wanted} file; it is {self.names[name]}\n",
                        arguments=("convert", f"x.{suffix}", "y.npy"))
        (self.folder / "folder.npy").mkdir()
        self.refuse(3, "folder.npy: is not a regular file; it is an empty folder\n", arguments=("convert", "folder.npy", "y.npy"))

    def test_folders(self):
        for name in ("w.tlmw", "s.json", "rv.csv"):
            self.refuse(3, f"{name}: is not a folder: ", f"; it is {self.names[name]}\n", arguments=("report", name))
        self.refuse(3, "void: contains neither result.json", "; it is an empty folder\n", arguments=("report", "void"))
        self.refuse(3, "plain: contains neither result.json", "; it is a folder\n", arguments=("report", "plain"))

    def test_a_forbidden_folder(self):
        (self.folder / "loop").symlink_to("loop")  # whom nothing is forbidden, this is
        self.refuse(3, "loop: Too many levels of symbolic links\n", arguments=("report", "loop"))
        self.refuse(3, "loop/in: Too many levels of symbolic links\n", arguments=("report", "loop/in"))
        (self.folder / "run").chmod(0)
        self.addCleanup((self.folder / "run").chmod, 0o700)
        done = self.run_program("report", "run")
        self.assertEqual(done.returncode, 3)
        self.assertNotIn("contains neither", done.stderr)

    def test_frames_of_another_width(self):
        self.run_program("train", "s.json", "--steps", "1", "--out", "net")
        encode = ("encode", "--weights", "net", "--shape", "256x256", "--dtype")
        for name in ("s.json", "rv.csv", "s.tlmp"):
            self.refuse(2, f"{name}: a file without header needs --dtype", f"; it is {self.names[name]}\n",
                        arguments=("encode", "--weights", "net", name))
            self.refuse(3, f"{name}: has ", f"the size of a frame of 256x256; it is {self.names[name]}\n", arguments=(*encode, "u16le", name))
        numpy.zeros((3, 256, 256), "<u2").tofile(self.folder / "narrow")
        self.refuse(3, "must be a multiple of 262144, the size of a frame of 256x256; with --dtype u16le it has 3 frames\n",
                    arguments=(*encode, "u32le", "narrow"))
        self.succeed("simulate", "s.json", "--frames", "0:3", "--out", "wide.bin")
        done = self.run_program(*encode, "u16le", "wide.bin")
        self.assertIn("exposure? With --dtype u32le the file has 3 frames, with u16le 6.\n", done.stderr)
        numpy.zeros((2, 256, 256), "<u2").tofile(self.folder / "narrow")
        done = self.run_program(*encode, "u32le", "narrow")
        self.assertIn("exposure? With --dtype u16le the file has 2 frames, with u32le 1.\n", done.stderr)


if __name__ == "__main__":
    unittest.main()
