"""Files that the program replaces: those that it wrote and empty ones, others with --force alone, never its input; stale temporaries,
permissions; the text of JSON."""
import fcntl
import json
import os
import select
import subprocess
import resource
import unittest

import numpy
from astropy.io import fits
from pages import __main__, results, write_bench
from program import PROGRAM, SCENES, TINY, ProgramTest, one_wavelength

REASON = "exists and was not written by toliman: give --force to replace it\n"
SERIES = "t,y\n" + "".join(f"{k},{k % 7 / 7}\n" for k in range(50))


def json_text(value, tabs=1):
    """What the program prints for a value: one member per line; 15 digits, or 17 if these are another number."""
    if isinstance(value, dict):
        members = (f"{chr(9) * tabs}{json_text(key)}:\t{json_text(member, tabs + 1)}" for key, member in value.items())
        return "{\n" + ",\n".join(members) + "\n" + "\t" * (tabs - 1) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(json_text(item, tabs + 1) for item in value) + "]"
    if isinstance(value, float):
        short = "%.15g" % value
        return short if float(short) == value else "%.17g" % value
    return json.dumps(value, ensure_ascii=False)


class Output(ProgramTest):
    def setUp(self):
        super().setUp()
        (self.folder / "scene.json").write_text(json.dumps(TINY))

    def test_temporaries_of_writers_that_died(self):
        """They are removed; those of living writers, which hold a lock, and files of other names are not."""
        made = [self.folder / f"x.npy.{number}.tmp" for number in range(100)]
        for path in (*made[:3], made[99], self.folder / "x.npy.100.tmp", self.folder / "y.npy.0.tmp"):
            path.touch()
        with open(made[1], "rb") as living:
            fcntl.flock(living, fcntl.LOCK_EX)
            self.succeed("psf", "scene.json", "--out", "x.npy")
            self.assertGreater((self.folder / "x.npy").stat().st_size, 8 * 64)
            self.assertEqual({path.name for path in self.folder.glob("*.tmp")}, {"x.npy.1.tmp", "x.npy.100.tmp", "y.npy.0.tmp"})
            made[1].rename(made[0])
            self.succeed("psf", "scene.json", "--out", "x.npy")
            self.assertTrue(made[0].exists())
        for path in made:
            path.unlink(missing_ok=True)
            path.mkdir()
        self.refuse(6, "x.npy: ", "x.npy.99.tmp: ", arguments=("psf", "scene.json", "--out", "x.npy"))

    def test_results_that_agree(self):
        """On a full disk all earlier files of a result folder remain."""
        series = "".join(f"{i},{(i * 7919) % 13},1\n" for i in range(200))
        (self.folder / "s.csv").write_text("t,y,sigma\n" + series)
        command = ("period", "s.csv", "--f0", "0.01", "--df", "0.001", "--nf", "2000", "--out", "r")
        self.succeed(*command)
        before = {path.name: path.read_bytes() for path in (self.folder / "r").iterdir()}
        (self.folder / "s.csv").write_text("t,y,sigma\n" + series.replace(",1\n", ",2\n"))
        done = self.run_program(*command, preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (20000, 20000)))
        self.assertEqual(done.returncode, 6, done.stderr)
        self.assertEqual({path.name: path.read_bytes() for path in (self.folder / "r").iterdir()}, before)

    def test_json(self):
        name = 'a"b\\c\x01\t\x7f\u00e9, {[:.json'
        (self.folder / name).write_text(json.dumps(TINY))
        for arguments in (("plan", name), ("period", SCENES.parent / "data" / "nu_oph_rv.csv", "--peaks", "3")):
            with self.subTest(arguments[0]):
                out = self.succeed(*arguments, "--json")
                self.assertEqual(out, json_text(json.loads(out)) + "\n")
        self.assertEqual(json.loads(self.succeed("plan", name, "--json"))["scene"], name)

    def test_permissions_are_kept(self):
        for mode in (0o600, 0o666):
            (self.folder / "x.npy").touch()
            (self.folder / "x.npy").chmod(mode)
            self.succeed("psf", "scene.json", "--out", "x.npy")
            self.assertEqual((self.folder / "x.npy").stat().st_mode & 0o777, mode)

    def test_no_binary_for_a_terminal(self):
        (self.folder / "series.csv").write_text("".join(f"{k},{k * k % 7}\n" for k in range(50)))
        controller, terminal = os.openpty()
        self.addCleanup(os.close, controller)
        self.addCleanup(os.close, terminal)
        for command in (("simulate", "scene.json", "--out", "-"), ("psf", "scene.json", "--out", "-"),
                        ("period", "series.csv", "--save-state", "-")):
            with self.subTest(command[0]):
                done = subprocess.run([PROGRAM, *command], cwd=self.folder, stdout=terminal, stderr=subprocess.PIPE, text=True)
                self.assertEqual((done.returncode, done.stderr.count("toliman: -: ")), (2, 1))
                self.assertEqual(select.select([controller], [], [], 0)[0], [])

    def test_a_reader_that_leaves(self):
        """Silent if the reader closed the pipe, as `| head` does; a full disk is reported."""
        for command in (("plan", "scene.json", "--json"), ("psf", "scene.json", "--out", "-")):
            for full, message in ((False, ""), (True, "No space left on device")):
                read, write = os.pipe()
                os.close(read)
                with open("/dev/full", "wb") if full else os.fdopen(write, "wb") as out:
                    done = subprocess.run([PROGRAM, *command], cwd=self.folder, stdout=out, stderr=subprocess.PIPE, text=True)
                if full:
                    os.close(write)
                self.assertEqual((done.returncode, message in done.stderr, done.stderr == message), (6, True, not full), command)

    def test_a_pipe_is_no_scene(self):
        os.mkfifo(self.folder / "pipe.json")
        self.refuse(3, "pipe.json: ", arguments=("psf", "pipe.json", "--out", "x.npy"))


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

    # promise: foreign-files-need-force
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

    # promise: foreign-files-need-force
    def test_own_and_empty_files(self):
        for name, command in self.outputs:
            with self.subTest(name):
                (self.folder / name).touch()
                for _ in range(1 if name == "f.bin" else 2):  # nothing marks headerless counts
                    self.assertEqual(self.run_program(*command).returncode, 0)
        self.refuse(6, "f.bin: " + REASON, arguments=("simulate", "s.json", "--out", "f.bin"))
        (self.folder / "link.npy").symlink_to("x.npy")
        self.foreign()
        self.refuse(6, "link.npy: " + REASON, arguments=("psf", "s.json", "--out", "link.npy"))

    # promise: foreign-files-need-force
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

    # promise: foreign-files-need-force
    def test_pages(self):
        write_bench(self.folder / "r")
        page = self.folder / "r" / "report" / "report.html"
        options = __main__.parse([str(self.folder / "r")])
        for _ in range(2):
            __main__.report(options)
        page.write_bytes(b"<!DOCTYPE html>\n" + page.read_bytes()[page.read_bytes().index(b"<figure"):])  # as older versions began it
        __main__.report(options)
        page.write_bytes(b"<!DOCTYPE html>\n")
        self.refuse(6, "r/report/report.html: " + REASON, arguments=("report", "r"))
        page.unlink()
        with self.assertRaises(results.Failure):
            __main__.report(options)
        __main__.report(__main__.parse([str(self.folder / "r"), "--force"]))

    # promise: inputs-are-never-replaced
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
                self.refuse(2, f"toliman: {out}: ", f"{name}: ", arguments=(*command, *force))


if __name__ == "__main__":
    unittest.main()
