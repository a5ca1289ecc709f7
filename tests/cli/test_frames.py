"""psf, simulate, train, encode: files in, files out, and what is refused."""
import io
import json
import os
import pathlib
import re
import signal
import subprocess
import tempfile
import time
import unittest

import numpy
from program import PATIENCE, PROGRAM, SCENES, TINY, ProgramTest, one_wavelength

CHAPTER = SCENES / "chapter.json"


class Frames(ProgramTest):
    def setUp(self):
        super().setUp()
        self.quick = self.folder / "quick.json"
        self.quick.write_text(json.dumps(one_wavelength()))


class Images(Frames):
    def test_psf_of_each_star(self):
        for star in ("A", "B", "both"):
            self.succeed("psf", self.quick, "--out", f"{star}.npy", "--star", star)
        a, b, both = (numpy.load(self.folder / f"{star}.npy") for star in ("A", "B", "both"))
        self.assertEqual((both.shape, both.dtype), ((256, 256), numpy.float64))
        self.assertLess(abs(a + b - both).max() / both.max(), 1e-15)
        self.assertAlmostEqual(both.max() / 1e9, 1, delta=1e-12)

    def test_frames_by_random_access(self):
        self.succeed("simulate", self.quick, "--frames", "0:6", "--out", "six.npy")
        self.succeed("simulate", self.quick, "--frames", "4:6", "--out", "two.npy")
        self.succeed("simulate", self.quick, "--frames", "0:6", "--out", "six.bin")
        self.succeed("simulate", self.quick, "--frames", "4", "--seed", "9", "--out", "other.npy")
        six, two, other = (numpy.load(self.folder / f"{name}.npy") for name in ("six", "two", "other"))
        self.assertEqual(six.shape, (6, 256, 256))
        self.assertTrue((six[4:] == two).all())
        self.assertTrue((numpy.fromfile(self.folder / "six.bin", "<u4").reshape(six.shape) == six).all())
        self.assertGreater((other != six[4]).mean(), 0.9)


class Weights(Frames):
    @classmethod
    def setUpClass(cls):
        kept = tempfile.TemporaryDirectory()
        cls.addClassCleanup(kept.cleanup)
        scene = pathlib.Path(kept.name) / "quick.json"
        scene.write_text(json.dumps(one_wavelength()))
        cls.weights = pathlib.Path(kept.name) / "w.tlmw"
        subprocess.run([PROGRAM, "train", scene, "--steps", "40", "--out", cls.weights], stderr=subprocess.DEVNULL, check=True)

    def setUp(self):
        super().setUp()
        (self.folder / "w.tlmw").symlink_to(self.weights)

    def test_encode_every_input(self):
        self.succeed("simulate", self.quick, "--frames", "0:4", "--out", "f.npy")
        self.succeed("simulate", self.quick, "--frames", "0:4", "--out", "f.bin")
        from_npy = self.succeed("encode", "--weights", "w.tlmw", "f.npy").splitlines()
        from_bin = self.succeed(
            "encode", "--weights", "w.tlmw", "--dtype", "u32le", "--shape", "256x256", "f.bin"
        ).splitlines()
        self.assertEqual(from_npy[0], "file,frame,latent_px,chi_square,chi_square_sigma,largest_residual,goodness,bad_pixels")
        self.assertEqual(len(from_npy), 5)
        for line in from_npy[1:]:
            self.assertLess(abs(float(line.split(",")[3]) - 1), 5 * (2 / 65536) ** 0.5)
        self.assertEqual([line.split(",")[1:] for line in from_npy], [line.split(",")[1:] for line in from_bin])

    def test_either_byte_order_gives_the_same_latents(self):
        """Of the same numbers; numpy swaps them. In the other order they are no frames of the scene."""
        encode = ("encode", "--weights", "w.tlmw", "--shape", "256x256", "--dtype")
        self.succeed("simulate", self.quick, "--frames", "0:2", "--out", "f.npy")
        frames = numpy.load(self.folder / "f.npy")
        for kind in ("u2", "u4", "f4"):
            word, values = f"{kind[0]}{8 * int(kind[1])}", frames if kind in ("u4", "f4") else frames / 1e6
            for order, numpy_order in (("le", "<"), ("be", ">")):
                values.astype(numpy_order + kind).tofile(self.folder / f"f.{order}")
            expected = self.run_program(*encode, word + "le", "f.le")
            swapped = self.run_program(*encode, word + "be", "f.be")
            self.assertEqual([expected.returncode, expected.stdout.count("\n")], [0, 3])
            self.assertEqual(swapped.stdout, expected.stdout.replace("f.le", "f.be"))
            if kind == "u4":
                self.assertEqual(swapped.stderr, "")
                wrong = self.run_program(*encode, "u32le", "f.be")
                self.assertIn("f.be: frame 0: ", wrong.stderr)

    def test_a_damaged_frame_stands_out(self):
        """Alternating columns are 3 sigma off, which hardly changes the latent."""
        self.succeed("simulate", self.quick, "--frames", "0:3", "--out", "f.npy")
        frames = numpy.load(self.folder / "f.npy")
        frames[1] += 3 * numpy.sqrt(frames[1]) * numpy.where(numpy.arange(256) % 2, 1, -1)
        numpy.save(self.folder / "bad.npy", frames)
        done = self.run_program("encode", "--weights", "w.tlmw", "bad.npy")
        self.assertEqual(done.returncode, 0)
        self.assertRegex(done.stderr, "bad.npy: frame 1: .* [0-9.]+ .* 0.00552")
        squares = [float(line.split(",")[3]) for line in done.stdout.splitlines()[1:]]
        self.assertEqual([abs(square - 1) > 5 * (2 / 65536) ** 0.5 for square in squares], [False, True, False])

    def encode_input(self, data, *more):
        return subprocess.run([PROGRAM, "encode", "--weights", "w.tlmw", *more, "-"], cwd=self.folder, input=data,
                              capture_output=True, timeout=PATIENCE)

    def test_encode_standard_input(self):
        for name in ("f.npy", "f.bin"):
            self.succeed("simulate", self.quick, "--frames", "0:3", "--out", name)
        expected = self.succeed("encode", "--weights", "w.tlmw", "f.npy").replace("f.npy", "-")
        npy, raw = ((self.folder / name).read_bytes() for name in ("f.npy", "f.bin"))
        layout = ("--dtype", "u32le", "--shape", "256x256")
        second = io.BytesIO()
        numpy.lib.format.write_array(second, numpy.load(self.folder / "f.npy"), version=(2, 0))
        for data, more in ((npy, ()), (second.getvalue(), ()), (raw, layout)):
            done = self.encode_input(data, *more)
            self.assertEqual((done.returncode, done.stdout.decode(), done.stderr), (0, expected, b""))
        head = expected.splitlines(keepends=True)
        for data, more, lines, code in (
            (b"", (), 0, 3), (b"", layout, 0, 3), (raw, (), 0, 3), (npy[:-1], (), 3, 3), (raw[:-1], layout, 3, 3), (npy + b"x", (), 4, 3),
            (raw, layout[:2], 0, 2),
        ):
            with self.subTest(lines=lines, more=more):
                done = self.encode_input(data, *more)
                self.assertEqual((done.returncode, done.stdout.decode(), done.stderr.count(b"\n")), (code, "".join(head[:lines]), 1))
                self.assertIn("-: " if code == 2 else "standard input: ", done.stderr.decode())

    def test_encode_as_frames_come(self):
        """A frame's line before the next frame is there, and a signal in between."""
        frame = numpy.ones((256, 256), "<u2").tobytes()
        with subprocess.Popen([PROGRAM, "encode", "--weights", "w.tlmw", "--dtype", "u16le", "--shape", "256x256", "-"],
                              cwd=self.folder, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as run:
            for k in range(3):
                run.stdin.write(frame)
                run.stdin.flush()
                lines = [run.stdout.readline() for _ in range(2 if k == 0 else 1)]
                self.assertTrue(lines[-1].startswith(b"-,%d," % k), lines)
            run.stdin.write(frame[:1000])
            run.stdin.flush()
            time.sleep(0.3)
            run.send_signal(signal.SIGTERM)
            self.assertEqual(run.wait(timeout=PATIENCE), 143)

    def test_bad_files(self):
        """tests/unit/test_npy.c and test_cae_damage.c have the others."""
        blob = bytearray((self.folder / "w.tlmw").read_bytes())
        blob[len(blob) // 2] ^= 1
        frames = numpy.ones((2, 256, 256))
        frames[1, 3, 4] = numpy.nan
        numpy.save(self.folder / "nan.npy", frames)
        numpy.save(self.folder / "small.npy", numpy.ones((1, 64, 64)))
        numpy.save(self.folder / "f.npy", numpy.ones((1, 256, 256)))
        (self.folder / "cut.npy").write_bytes((self.folder / "nan.npy").read_bytes()[:-5])
        raw = ("--dtype", "u16le", "--shape", "256x256")
        for name, data in (("flipped", blob), ("e.npy", b""), ("e.fits", b""), ("e.bin", b""), ("short.bin", bytes(1000)), ("odd.bin", b"123")):
            (self.folder / name).write_bytes(data)
        for weights in ("flipped", "e.bin", "none.tlmw"):
            self.refuse(3, f"{weights}: ", arguments=("encode", "--weights", weights, "f.npy"))
        self.refuse_all(
            *((3, f"{name}: ", name) for name in ("small.npy", "cut.npy", "missing.npy", "e.npy", "e.fits")),
            (3, "e.bin: ", *raw, "e.bin"), (3, "short.bin: ", *raw, "short.bin"), (2, "--dtype", "odd.bin"),
            (2, "f.npy: ", *raw, "f.npy"), command=("encode", "--weights", "w.tlmw"))
        done = self.run_program("encode", "--weights", "w.tlmw", "nan.npy")
        self.assertEqual((done.returncode, "nan.npy: frame 1" in done.stderr), (3, True))
        self.assertEqual(done.stdout.count("\n"), 2)  # header and the good frame


class Refusals(Frames):
    def test_scene_that_is_no_scene(self):
        self.refuse(3, "none.json: ", arguments=("run", "none.json"))
        (self.folder / "scene.json").write_text('{"schema": ')
        self.refuse(3, "scene.json: line ", arguments=("run", "scene.json"))
        (self.folder / "scene.json").write_text(CHAPTER.read_text().replace("0.125", "1e999"))
        self.refuse(3, "scene.json: line 5", arguments=("run", "scene.json"))

    def test_unwritable_outputs(self):
        (self.folder / "file").write_text("")
        self.refuse(6, "no/w.tlmw", arguments=("train", self.quick, "--out", "no/w.tlmw"))
        self.refuse(6, "file/x.npy", arguments=("psf", self.quick, "--out", "file/x.npy"))
        self.refuse(6, "file/run", arguments=("run", self.quick, "--out", "file/run"))
        self.refuse(6, "file", arguments=("run", self.quick, "--out", "file"))
        with open("/dev/full", "w") as full:
            done = subprocess.run([PROGRAM, "doctor", "--json"], stdout=full, stderr=subprocess.PIPE, text=True)
        self.assertEqual(done.returncode, 6, done.stderr)
        self.assertIn("standard output", done.stderr)

    def test_links_pipes_and_devices_as_output(self):
        """None of them is ever replaced by a file."""
        self.quick.write_text(json.dumps(TINY))
        (self.folder / "kept.npy").touch()
        (self.folder / "link.npy").symlink_to("kept.npy")
        os.mkfifo(self.folder / "pipe.npy")
        self.succeed("psf", self.quick, "--out", "link.npy")
        whole = (self.folder / "kept.npy").read_bytes()
        self.assertTrue((self.folder / "link.npy").is_symlink())
        self.assertEqual(numpy.load(self.folder / "kept.npy").shape, (8, 8))
        with subprocess.Popen(["cp", "pipe.npy", "piped.npy"], cwd=self.folder):
            self.succeed("psf", self.quick, "--out", "pipe.npy")
        self.assertEqual((self.folder / "piped.npy").read_bytes(), whole)
        self.assertTrue((self.folder / "pipe.npy").is_fifo())
        done = subprocess.run([PROGRAM, "psf", self.quick, "--out", "-"], capture_output=True, check=True)
        self.assertEqual(done.stdout, whole)
        with open("/dev/full", "w") as full:
            done = subprocess.run([PROGRAM, "psf", self.quick, "--out", "-"], stdout=full, stderr=subprocess.PIPE, text=True)
        self.assertEqual(done.returncode, 6, done.stderr)
        self.assertIn("standard output: ", done.stderr)
        (self.folder / "folder.npy").mkdir()
        self.refuse(6, "folder.npy", arguments=("psf", self.quick, "--out", "folder.npy"))

    def test_mistyped_options(self):
        for option, value in (("--out", "f.png"), ("--frames", "5:2"), ("--frames", "0:9999"), ("--frames", "1.5")):
            self.refuse(2, f"{option} {value}", arguments=("simulate", self.quick, "--out=f.npy", option, value)
                        if option != "--out" else ("simulate", self.quick, option, value))


class Help(ProgramTest):
    def test_help_begins_with_examples(self):
        for command in ([], ["run"], ["psf"], ["simulate"], ["train"], ["encode"], ["convert"], ["period"], ["plan"], ["pupil"],
                        ["track"], ["status"], ["rebuild"], ["merge"], ["doctor"]):
            out = self.succeed(*command, "--help")
            self.assertLess(out.index("Example"), out.index("Options:"))
            # Only examples, tables and the names of options are not wrapped.
            self.assertEqual([line for line in out.splitlines() if len(line) > 100 and not re.match(r" {2,6}\S", line)], [])
        self.assertIn("toliman 0.", self.succeed("--version"))


if __name__ == "__main__":
    unittest.main()
