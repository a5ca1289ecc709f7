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
from program import PATIENCE, PROGRAM, SCENES, ProgramTest, one_wavelength

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
        for kind in ("u2", "u4", "i2", "f4"):
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
                self.assertIn("f.be: frame 0: a ", wrong.stderr)
                self.assertIn("is this frame of the network's scene", wrong.stderr)

    def test_a_damaged_frame_stands_out(self):
        """Alternating columns are 3 sigma off, which hardly changes the latent."""
        self.succeed("simulate", self.quick, "--frames", "0:3", "--out", "f.npy")
        frames = numpy.load(self.folder / "f.npy")
        frames[1] += 3 * numpy.sqrt(frames[1]) * numpy.where(numpy.arange(256) % 2, 1, -1)
        numpy.save(self.folder / "bad.npy", frames)
        done = self.run_program("encode", "--weights", "w.tlmw", "bad.npy")
        self.assertEqual(done.returncode, 0)
        self.assertRegex(done.stderr, "bad.npy: frame 1: the fit is poor: a chi-square of [0-9.]+ differs from 1 .- 0.00552, that of the scene's noise")
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
        for data, more, lines, text in (
            (b"", (), 0, "is empty"), (b"", layout, 0, "is empty"), (raw, (), 0, "is not a .npy file"),
            (npy[:-1], (), 3, "ends within a frame"), (raw[:-1], layout, 3, "ends within a frame"),
            (npy + b"x", (), 4, "has more than 3 frames of 256x256"), (raw, layout[:2], 0, "needs --shape"),
        ):
            with self.subTest(text, more=more):
                done = self.encode_input(data, *more)
                self.assertEqual(done.returncode, 2 if "--shape" in text else 3)
                self.assertEqual(done.stdout.decode(), "".join(head[:lines]))
                self.assertEqual(done.stderr.count(b"\n"), 1)
                self.assertIn("-: a" if "--shape" in text else "standard input: " + text, done.stderr.decode())

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
            self.assertIn(b"stopped by a signal", run.stderr.read())

    def test_damaged_weights(self):
        blob = bytearray((self.folder / "w.tlmw").read_bytes())
        numpy.save(self.folder / "f.npy", numpy.ones((1, 256, 256)))
        flipped = bytearray(blob)
        flipped[len(blob) // 2] ^= 1
        for name, content in (("short", blob[:-9]), ("flipped", flipped), ("long", blob + b"x")):
            (self.folder / name).write_bytes(content)
            with self.subTest(name):
                self.refuse(3, "weights", arguments=("encode", "--weights", name, "f.npy"))
        (self.folder / "empty").touch()
        self.refuse(3, "toliman: empty: is empty\n", arguments=("encode", "--weights", "empty", "f.npy"))
        self.refuse(3, "none.tlmw", "No such file", arguments=("encode", "--weights", "none.tlmw", "f.npy"))

    def test_bad_frames(self):
        frames = numpy.ones((2, 256, 256))
        frames[1, 3, 4] = numpy.nan
        numpy.save(self.folder / "nan.npy", frames)
        numpy.save(self.folder / "small.npy", numpy.ones((1, 64, 64)))
        numpy.save(self.folder / "text.npy", numpy.array(["a"]))
        numpy.save(self.folder / "order.npy", numpy.asfortranarray(numpy.ones((1, 256, 256))))
        (self.folder / "cut.npy").write_bytes((self.folder / "nan.npy").read_bytes()[:-5])
        (self.folder / "odd.bin").write_bytes(b"123")
        for name, *texts in (
            ("small.npy", "64x64", "256x256"),
            ("text.npy", "little-endian"),
            ("order.npy", "Fortran order"),
            ("cut.npy", "bytes"),
            ("missing.npy", "No such file"),
        ):
            with self.subTest(name):
                done = self.run_program("encode", "--weights", "w.tlmw", name)
                self.assertEqual(done.returncode, 3)
                self.assertIn(name, done.stderr)
                for text in texts:
                    self.assertIn(text, done.stderr)
        done = self.run_program("encode", "--weights", "w.tlmw", "nan.npy")
        self.assertEqual(done.returncode, 3)
        self.assertIn("nan.npy: frame 1", done.stderr)
        self.assertEqual(done.stdout.count("\n"), 2)  # header and the good frame
        done = self.run_program("encode", "--weights", "w.tlmw", "odd.bin")
        self.assertEqual(done.returncode, 2)
        self.assertIn("--dtype", done.stderr)


class Refusals(Frames):
    def scene(self, change):
        scene = json.loads(CHAPTER.read_text())
        change(scene)
        (self.folder / "scene.json").write_text(json.dumps(scene))

    def test_scene_content(self):
        numpy.save(self.folder / "small.npy", numpy.zeros((64, 64)))
        mask = {"kind": "file", "quantity": "opd_m"}
        cases = (
            (2, lambda s: s["telescope"].update(apertur_m=1), ("telescope.apertur_m", "aperture_m")),
            (2, lambda s: s["telescope"].update(aperture_m=-0.125), ("telescope.aperture_m = -0.125", "[0.001, 100] m")),
            (2, lambda s: s["telescope"].update(aperture_m="wide"), ("telescope.aperture_m", "number")),
            (2, lambda s: s["detector"].update(shape=[-256, 256]), ("detector.shape", "-256")),
            (2, lambda s: s["telescope"].update(aberrations={"zernike_rms_nm": {"0": 5}}), ("zernike_rms_nm.0", "Noll")),
            (3, lambda s: s["telescope"].update(aberrations={"opd_file": "none.npy"}), ("none.npy",)),
            (3, lambda s: s["telescope"].update(amplitude={"file": "small.npy"}), ("small.npy", "256")),
            (3, lambda s: s["telescope"].update(mask={**mask, "file": "none.npy"}), ("none.npy",)),
            (3, lambda s: s["telescope"].update(mask={**mask, "file": "small.npy"}), ("small.npy", "256")),
        )
        for code, change, texts in cases:
            with self.subTest(texts=texts):
                self.scene(change)
                self.refuse(code, *texts, arguments=("run", "scene.json"))

    def test_scene_that_is_no_scene(self):
        self.refuse(3, "none.json", "No such file", arguments=("run", "none.json"))
        (self.folder / "scene.json").write_text('{"schema": ')
        self.refuse(3, "scene.json", "line", arguments=("run", "scene.json"))
        (self.folder / "scene.json").write_text(CHAPTER.read_text().replace("0.125", "1e999"))
        self.refuse(3, "scene.json: line 5", "range of double", arguments=("run", "scene.json"))

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
        (self.folder / "kept.npy").touch()
        (self.folder / "link.npy").symlink_to("kept.npy")
        os.mkfifo(self.folder / "pipe.npy")
        self.succeed("psf", self.quick, "--out", "link.npy")
        whole = (self.folder / "kept.npy").read_bytes()
        self.assertTrue((self.folder / "link.npy").is_symlink())
        self.assertEqual(numpy.load(self.folder / "kept.npy").shape, (256, 256))
        with subprocess.Popen(["cp", "pipe.npy", "piped.npy"], cwd=self.folder):
            self.succeed("psf", self.quick, "--out", "pipe.npy")
        self.assertEqual((self.folder / "piped.npy").read_bytes(), whole)
        self.assertTrue((self.folder / "pipe.npy").is_fifo())
        done = subprocess.run([PROGRAM, "psf", self.quick, "--out", "-"], capture_output=True, check=True)
        self.assertEqual(done.stdout, whole)
        with open("/dev/full", "w") as full:
            done = subprocess.run([PROGRAM, "psf", self.quick, "--out", "-"], stdout=full, stderr=subprocess.PIPE, text=True)
        self.assertEqual(done.returncode, 6, done.stderr)
        self.assertIn("standard output: cannot be written: No space", done.stderr)
        (self.folder / "folder.npy").mkdir()
        self.refuse(6, "folder.npy", "directory", arguments=("psf", self.quick, "--out", "folder.npy"))

    def test_mistyped_commands_and_options(self):
        self.refuse(2, "did you mean period?", arguments=("perod",))
        self.refuse(2, "did you mean --frames?", arguments=("simulate", self.quick, "--frame", "0:2", "--out", "f.npy"))
        self.refuse(2, "--out f.png", ".npy or .bin", arguments=("simulate", self.quick, "--out", "f.png"))
        self.refuse(2, "--frames 5:2", "0:1095", arguments=("simulate", self.quick, "--frames", "5:2", "--out", "f.npy"))
        self.refuse(2, "--frames 0:9999", arguments=("simulate", self.quick, "--frames", "0:9999", "--out", "f.npy"))
        self.refuse(2, "--frames 1.5", arguments=("simulate", self.quick, "--frames", "1.5", "--out", "f.npy"))

    def test_interrupted_run_leaves_nothing(self):
        for number, code in ((signal.SIGINT, 130), (signal.SIGTERM, 143)):
            with subprocess.Popen([PROGRAM, "run", CHAPTER], cwd=self.folder, stderr=subprocess.PIPE, text=True) as run:
                for _ in range(500):  # wait for its folder: then it is at work
                    if len(os.listdir(self.folder)) > 1:
                        break
                    time.sleep(0.02)
                run.send_signal(number)
                self.assertEqual(run.wait(60), code)
            self.assertEqual(os.listdir(self.folder), ["quick.json"])


class Help(ProgramTest):
    def test_help_begins_with_examples(self):
        for command in ([], ["run"], ["psf"], ["simulate"], ["train"], ["encode"], ["convert"], ["period"], ["plan"], ["pupil"],
                        ["track"], ["status"], ["rebuild"], ["merge"], ["doctor"], ["experiment"]):
            out = self.succeed(*command, "--help")
            self.assertLess(out.index("Example"), out.index("Options:"))
            # Only examples, tables and the names of options are not wrapped.
            self.assertEqual([line for line in out.splitlines() if len(line) > 100 and not re.match(r" {2,6}\S", line)], [])
        self.assertIn("toliman 0.", self.succeed("--version"))


if __name__ == "__main__":
    unittest.main()
