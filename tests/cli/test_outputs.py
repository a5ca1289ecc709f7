"""Frames as FITS, as the mission's pair of files and as .npy: written here and read by astropy, and the other way."""
import json
import os
import pathlib
import signal
import struct
import subprocess
import tempfile
import time
import unittest

import numpy
from astropy.io import fits
from program import PROGRAM, SCENES, ProgramTest

ROWS, COLS = 48, 32


def fnv1a(data):
    value = 0xCBF29CE484222325
    for byte in data:
        value = (value ^ byte) * 0x100000001B3 % 2**64
    return value


def write_scene(path, **changes):
    """The chapter's scene made small, fast and not square, with groups updated."""
    scene = json.loads((SCENES / "chapter.json").read_text())
    small = {"telescope": {"pupil_samples": 64}, "band": {"step_nm": 10}, "binary": {"separation_arcsec": 2},
             "detector": {"shape": [ROWS, COLS]}}
    for group, change in (*small.items(), *changes.items()):
        scene[group].update(change) if isinstance(change, dict) else scene.update({group: change})
    path.write_text(json.dumps(scene))
    return scene


class OutputTest(ProgramTest):
    def setUp(self):
        super().setUp()
        self.small = self.scene()

    def scene(self, file="scene.json", **changes):
        return write_scene(self.folder / file, **changes)

    def simulate(self, out, *options, scene="scene.json", frames="3:7"):
        return self.succeed("simulate", scene, "--frames", frames, f"--out={out}", *options)


class Cube(OutputTest):
    def test_header_values_and_table(self):
        self.simulate("f.fits", "--seed", str(2**64 - 1))
        self.simulate("f.npy", "--seed", str(2**64 - 1))
        self.assertEqual(sorted(os.listdir(self.folder)), ["f.fits", "f.npy", "scene.json"])
        scene = self.small
        self.simulate("again.fits", "--seed", str(2**64 - 1))
        self.assertEqual((self.folder / "again.fits").read_bytes(), (self.folder / "f.fits").read_bytes())
        with fits.open(self.folder / "f.fits") as cube:
            cube.verify("exception")
            self.assertTrue((cube[0].data == numpy.load(self.folder / "f.npy")).all())
            self.assertEqual((cube[0].data.dtype, cube[0].data.shape), (numpy.uint32, (4, ROWS, COLS)))
            header = cube[0].header
            self.assertEqual(header["BUNIT"], "photon")
            self.assertEqual(header["SCENE"], scene["name"])
            self.assertEqual(header["SCENEID"], "%016x" % fnv1a((self.folder / "scene.json").read_bytes()))
            self.assertEqual((header["SEED"], header["FRAME1"], header["FRAMEN"]), (2**64 - 1, 3, 6))
            self.assertEqual(header["PIXSCALE"], scene["detector"]["pixel_scale_arcsec"])
            self.assertEqual(header["APERTURE"], scene["telescope"]["aperture_m"])
            self.assertAlmostEqual(header["WAVEMIN"], scene["band"]["min_nm"], delta=1e-9)
            self.assertAlmostEqual(header["WAVEMAX"], scene["band"]["max_nm"], delta=1e-9)
            self.assertTrue(header["CREATOR"].startswith("toliman 0."))
            table = cube["FRAMES"]
            self.assertEqual([(c.name, c.format, c.unit) for c in table.columns],
                             [("frame", "K", None), ("time_days", "D", "d"), ("displacement_px", "D", "pixel")])
            days = numpy.arange(3, 7) * scene["cadence"]["interval_days"]
            self.assertEqual(table.data["frame"].tolist(), [3, 4, 5, 6])
            self.assertEqual(table.data["time_days"].tolist(), days.tolist())
            signal_of = scene["signal"]
            phases = 2 * numpy.pi * days / signal_of["period_days"] + signal_of["phase_rad"]
            truth = signal_of["amplitude_px"] * numpy.sin(phases)
            self.assertLess(abs(table.data["displacement_px"] - truth).max(), 1e-12 * signal_of["amplitude_px"])

    def test_what_is_no_count_stays_float64(self):
        self.scene("read.json", noise={"read_e": 1.3})
        self.scene("bright.json", cadence={"peak_photons": 3e9})
        self.scene("still.json", noise={"photon": False})
        for name in ("read", "bright", "still"):
            with self.subTest(name):
                for suffix in ("fits", "npy"):
                    self.simulate(f"{name}.{suffix}", scene=f"{name}.json", frames="0:2")
                data = fits.getdata(self.folder / f"{name}.fits")
                self.assertEqual(data.dtype, numpy.dtype(">f8"))
                self.assertTrue((data == numpy.load(self.folder / f"{name}.npy")).all())

    def test_quantised_counts_are_whole_whatever_the_noise(self):
        detector = {"gain_e_per_dn": 2, "bias_dn": 100, "bit_depth": 20}
        self.scene("dn.json", noise={"read_e": 1.3}, detector=detector, cadence={"peak_photons": 3000})
        for name in ("dn.fits", "dn.npy", "dn.bin"):
            self.simulate(name, scene="dn.json", frames="0:2")
        with fits.open(self.folder / "dn.fits") as cube:
            self.assertEqual((cube[0].header["BUNIT"], cube[0].data.dtype), ("adu", numpy.uint32))
            data = cube[0].data
        self.assertTrue((data == numpy.load(self.folder / "dn.npy")).all())
        self.assertTrue((data.ravel() == numpy.fromfile(self.folder / "dn.bin", "<u4")).all())
        self.assertGreater(data.min(), 90)
        self.simulate("pair", "--session", "t", "--dtype", "u16le", "--bit-depth", "12", scene="dn.json", frames="0:2")
        self.assertTrue((data.ravel() == numpy.fromfile(self.folder / "pair" / "t_frames.bin", "<u2")).all())

    def test_names_are_only_names(self):
        """To CFITSIO brackets, mem://, !, ~ and blanks are a language."""
        os.mkdir(self.folder / "mem:")
        self.simulate("plain.fits", frames="0")
        for name in ("f[1].fits", "mem://f.fits", "!f.fits", " f.fits", "-f.fits"):
            with self.subTest(name):
                self.succeed("convert", "--", "plain.fits", name)
                self.assertEqual(fits.getdata(self.folder / name).shape, (1, ROWS, COLS))
                self.succeed("convert", "--", name, "back.npy")
                self.assertEqual(numpy.load(self.folder / "back.npy").shape, (1, ROWS, COLS))
        self.assertFalse((self.folder / "f.fits").exists())
        # CFITSIO would open its compressed neighbour instead.
        (self.folder / "g.fits.gz").write_bytes(b"")
        self.refuse(3, "g.fits: ", arguments=("convert", "g.fits", "x.npy"))

    def test_places_that_cannot_be_written(self):
        self.refuse(6, "no/f.fits: ", arguments=("simulate", "scene.json", "--frames", "0", "--out", "no/f.fits"))
        os.mkfifo(self.folder / "pipe.fits")
        with subprocess.Popen(["cat", "pipe.fits"], cwd=self.folder, stdout=subprocess.PIPE):
            self.refuse(6, "pipe.fits: ", arguments=("simulate", "scene.json", "--frames", "0", "--out", "pipe.fits"))
        # A file may not grow beyond 200 KiB: a part is written, then nothing is left. SIGXFSZ, if not ignored, would end the program.
        for out, ignored in ((["f.fits"], 'trap "" XFSZ; '), (["f.npy"], ""), (["pair", "--session", "s", "--dtype", "u32le"], "")):
            with self.subTest(out):
                before = sorted(os.listdir(self.folder))
                done = subprocess.run(["bash", "-c", ignored + 'ulimit -f 200; exec "$@"', "-", PROGRAM, "simulate", "scene.json",
                                       "--frames", "0:64", "--out", *out], cwd=self.folder, capture_output=True, text=True)
                self.assertEqual((done.returncode, done.stderr.count("\n")), (6, 1), done.stderr)
                self.assertEqual(sorted(os.listdir(self.folder)), before)

    def test_interruption_leaves_nothing(self):
        self.scene("long.json", cadence={"frames": 500000})
        before = sorted(os.listdir(self.folder))
        for out in (["new.fits"], ["pair", "--session", "s", "--dtype", "u32le"]):
            with subprocess.Popen([PROGRAM, "simulate", "long.json", "--out", *out], cwd=self.folder,
                                  stderr=subprocess.PIPE, text=True) as run:
                for _ in range(500):  # wait for its temporary: then it is at work
                    if sorted(os.listdir(self.folder)) != before:
                        break
                    time.sleep(0.01)
                run.send_signal(signal.SIGTERM)
                self.assertEqual(run.wait(10), 143)  # writing zeros for the rest would take longer
            self.assertEqual(sorted(os.listdir(self.folder)), before)

    def test_more_than_the_disk_holds(self):
        """1e7 frames of 512x512 are 10 TB of u32: refused at once, before anything is written."""
        self.scene("endless.json", cadence={"frames": 10000000}, detector={"shape": [512, 512], "pixel_scale_arcsec": 0.05},
                   band={"step_nm": 50})
        for size, *out in (("21.0 TB", "f.npy"), ("10.5 TB", "f.fits"), ("10.5 TB", "pair", "--session", "s", "--dtype", "u32le")):
            with self.subTest(out):
                line = self.refuse(6, size, arguments=("simulate", "endless.json", "--out", *out))
                self.assertRegex(line, r" (\d{3}|\d\d\.\d|\d\.\d\d) [kMGT]B free\n")


class Pair(OutputTest):
    """<session>_frames.bin and <session>_meta.jsonl."""

    KEYS = ["frame_id", "timestamp_ns", "host_time", "nframes_dropped", "roi_label", "n_rows", "n_cols", "session_id", "dtype"]

    def test_u32_and_its_side_file(self):
        scene = self.scene(cadence={"interval_days": 0.3})
        self.simulate("f.npy")
        self.simulate("pair", "--session", "day-1.A_b", "--dtype", "u32le")
        self.assertEqual(sorted(os.listdir(self.folder / "pair")), ["day-1.A_b_frames.bin", "day-1.A_b_meta.jsonl"])
        frames = numpy.load(self.folder / "f.npy")
        counts = numpy.fromfile(self.folder / "pair" / "day-1.A_b_frames.bin", "<u4")
        self.assertTrue((counts == frames.ravel()).all())
        lines = [json.loads(line) for line in (self.folder / "pair" / "day-1.A_b_meta.jsonl").read_text().splitlines()]
        self.assertEqual(len(lines), 4)
        for k, line in enumerate(lines, 3):
            self.assertEqual(list(line), self.KEYS)
            days = k * scene["cadence"]["interval_days"]
            self.assertEqual((type(line["timestamp_ns"]), type(line["host_time"])), (int, float))
            self.assertLessEqual(abs(line["timestamp_ns"] - round(days * 86400 * 10**9)), 16)
            self.assertAlmostEqual(line["host_time"], days * 86400, delta=1e-6)
            self.assertEqual([line[key] for key in self.KEYS if key not in ("timestamp_ns", "host_time")],
                             [k, 0, "single_roi", ROWS, COLS, "day-1.A_b", "u32le"])

    def test_u16_at_its_bit_depth(self):
        self.scene("faint.json", cadence={"peak_photons": 3000})
        self.scene("full.json", cadence={"peak_photons": 60000})
        self.simulate("f.npy", scene="faint.json")
        self.simulate("pair", "--session", "s", "--dtype", "u16le", scene="faint.json")
        counts = numpy.fromfile(self.folder / "pair" / "s_frames.bin", "<u2")
        self.assertTrue((counts == numpy.load(self.folder / "f.npy").ravel()).all())
        self.simulate("pair", "--session", "t", "--dtype", "u16le", "--bit-depth", "16", scene="full.json")
        self.assertGreater(numpy.fromfile(self.folder / "pair" / "t_frames.bin", "<u2").max(), 59000)

    def test_bit_depth_of_the_scene(self):
        """The default of --bit-depth is what the scene's detector has."""
        self.scene("deep.json", detector={"bit_depth": 14}, cadence={"peak_photons": 12000})
        command = ("simulate", "deep.json", "--frames", "0", "--out", "pair", "--session", "s", "--dtype", "u16le")
        self.succeed(*command)
        self.assertGreater(numpy.fromfile(self.folder / "pair" / "s_frames.bin", "<u2").max(), 4095)
        for suffix in ("frames.bin", "meta.jsonl"):
            self.refuse(6, f"pair/s_{suffix}: ", "--session", arguments=command)
            (self.folder / "pair" / f"s_{suffix}").unlink()
        self.refuse(2, "[0, 4095]", arguments=(*command, "--bit-depth", "12"))
        self.scene("deep.json", detector={"bit_depth": 20}, cadence={"peak_photons": 12000})
        self.refuse(2, "deep.json: detector.bit_depth = 20: ", arguments=command)
        self.succeed(*command, "--bit-depth", "16")

    def test_default_pixel_type(self):
        """Of a pair: that of the bit depth, of the scene or given; u32le if it is not known."""
        for name, detector, more, dtype in (("none", {}, (), "u32le"), ("d12", {"bit_depth": 12}, (), "u16le"),
                                            ("d16", {"bit_depth": 16}, (), "u16le"), ("d17", {"bit_depth": 17}, (), "u32le"),
                                            ("given", {}, ("--bit-depth", "16"), "u16le"), ("wide", {}, ("--bit-depth", "17"), "u32le")):
            with self.subTest(name):
                self.scene(f"{name}.json", detector=detector, cadence={"peak_photons": 3000})
                self.succeed("simulate", f"{name}.json", "--frames", "0", "--out", "pair", "--session", name, *more)
                line = json.loads((self.folder / "pair" / f"{name}_meta.jsonl").read_text())
                size = (self.folder / "pair" / f"{name}_frames.bin").stat().st_size
                self.assertEqual((line["dtype"], size), (dtype, ROWS * COLS * (2 if dtype == "u16le" else 4)))

    def test_bit_depth_overflow(self):
        self.scene(cadence={"peak_photons": 5000})
        self.simulate("f.npy")
        image = numpy.load(self.folder / "f.npy")[0]
        at = numpy.flatnonzero(image > 4095)[0]
        command = ("simulate", "scene.json", "--frames", "3:7", "--out")
        place = f"frame 3, row {at // COLS}, column {at % COLS}: {image.flat[at]:.0f} counts: "
        self.refuse(2, "pair/s_frames.bin: " + place, "[0, 4095]",
                    arguments=(*command, "pair", "--session", "s", "--dtype", "u16le"))
        self.refuse(2, "[0, 1]", arguments=(*command, "pair", "--session", "s", "--dtype", "u32le", "--bit-depth", "1"))
        self.scene(cadence={"peak_photons": 5e9})
        self.refuse(2, "[0, 4294967295]", arguments=(*command, "f.bin"))

    def test_counts_below_zero(self):
        """Cut off at 0 they would bias the light: 16 counts a dark pixel at read_e = 40."""
        self.scene("dark.json", cadence={"peak_photons": 3000}, noise={"read_e": 40})
        self.simulate("f.npy", scene="dark.json")
        image = numpy.rint(numpy.load(self.folder / "f.npy")[0])
        at = numpy.flatnonzero(image < 0)[0]
        text = f"frame 3, row {at // COLS}, column {at % COLS}: {image.flat[at]:.0f} counts"
        for out in (["f.bin"], ["pair", "--session", "s", "--dtype", "u16le"]):
            self.refuse(2, text, "noise.read_e", arguments=("simulate", "dark.json", "--frames", "3:7", "--out", *out))
        self.scene("quiet.json", cadence={"peak_photons": 3000}, noise={"read_e": 0.05})  # rounds to 0 at the least
        self.simulate("f.bin", scene="quiet.json")

    def test_options(self):
        command = ("simulate", "scene.json", "--frames", "0", "--out")
        self.refuse_all(
            *((2, "--session", "pair", "--session", name, "--dtype", "u32le")
                for name in ("", ".s", "a/b", "é", 65 * "x")),
            (2, "--dtype", "pair", "--session", "s", "--dtype", "u8"),
            (2, "--bit-depth 17", "pair", "--session", "s", "--dtype", "u16le", "--bit-depth", "17"),
            (2, "--session", "f.npy", "--dtype", "u16le"),
            (6, "no/pair", "no/pair", "--session", "s", "--dtype", "u32le"), command=command)


class Encode(OutputTest):
    """On frames of 256x256, as the network takes them."""

    SHAPE = {"shape": [256, 256]}

    @classmethod
    def setUpClass(cls):
        kept = tempfile.TemporaryDirectory()
        cls.addClassCleanup(kept.cleanup)
        cls.weights = pathlib.Path(kept.name) / "w.tlmw"
        write_scene(cls.weights.parent / "scene.json", detector=cls.SHAPE)
        subprocess.run([PROGRAM, "train", cls.weights.parent / "scene.json", "--steps", "1", "--out", cls.weights],
                       capture_output=True, check=True)

    def latents(self, *names):
        """{file: lines without the file's name} of encode."""
        rows = {name: [] for name in names}
        for line in self.succeed("encode", "--weights", self.weights, *names).splitlines()[1:]:
            name, _, row = line.partition(",")
            rows[name].append(row)
        return rows

    def test_every_kind_of_fits(self):
        self.scene(cadence={"peak_photons": 20000}, detector=self.SHAPE)  # its counts fit every type
        self.simulate("f.npy", frames="0:3")
        self.simulate("own.fits", frames="0:3")
        frames = numpy.load(self.folder / "f.npy")
        names = ["own.fits"]
        for dtype in ("i2", "u2", "i4", "u4", "i8", "f4", "f8"):
            names.append(f"{dtype}.fits")
            fits.writeto(self.folder / names[-1], frames.astype(dtype))
        for kind in ("RICE_1", "GZIP_1", "GZIP_2"):
            names.append(f"{kind}.fits.fz")
            hdu = fits.CompImageHDU(frames.astype("i4"), compression_type=kind)
            fits.HDUList([fits.PrimaryHDU(), hdu]).writeto(self.folder / names[-1])
        # BITPIX 8 with BSCALE and BZERO; one image in an extension behind a table.
        hdu = fits.PrimaryHDU((frames[0] // 80).astype("u1"))
        hdu.header["BSCALE"], hdu.header["BZERO"] = 2.5, -7.0
        hdu.writeto(self.folder / "scaled.fits")
        with open(self.folder / "scaled.fits", "r+b") as file:  # astropy drops the scale when it writes
            block = file.read(2880)
            cards = [block[i:i + 80] for i in range(0, 2880, 80)]
            end = cards.index(b"END".ljust(80))
            scale = (b"BSCALE  =                  2.5", b"BZERO   =                 -7.0", b"END")
            cards[end:end + 3] = [card.ljust(80) for card in scale]
            file.seek(0)
            file.write(b"".join(cards)[:2880])
        numpy.save(self.folder / "scaled.npy", frames[0] // 80 * 2.5 - 7)
        table = fits.BinTableHDU.from_columns([fits.Column("x", "D", array=[1.0])])
        fits.HDUList([fits.PrimaryHDU(), table, fits.ImageHDU(frames[1])]).writeto(self.folder / "later.fits")
        found = self.latents("f.npy", *names, "scaled.fits", "scaled.npy", "later.fits")
        expected = found["f.npy"]
        self.assertEqual(len(expected), 3)
        for name in names:
            self.assertEqual(found[name], expected, name)
        self.assertEqual(found["scaled.fits"], found["scaled.npy"])
        self.assertEqual([line.split(",")[1] for line in found["later.fits"]], [expected[1].split(",")[1]])

    def test_bad_fits(self):
        good = numpy.ones((2, 256, 256))
        fits.writeto(self.folder / "good.fits", good)
        whole = (self.folder / "good.fits").read_bytes()
        blank = good.copy()
        blank[1, 3, 4] = numpy.nan
        fits.writeto(self.folder / "nan.fits", blank)
        counts = good.astype("i4")
        counts[1, 3, 4] = -99
        fits.writeto(self.folder / "blank.fits", counts, fits.Header({"BLANK": -99}))
        fits.writeto(self.folder / "small.fits", numpy.ones((64, 32)))
        fits.writeto(self.folder / "line.fits", numpy.ones(256))
        fits.writeto(self.folder / "four.fits", numpy.ones((1, 1, 256, 256)))
        fits.HDUList([fits.PrimaryHDU()]).writeto(self.folder / "none.fits")
        def altered(axis, old, new):
            return whole.replace(b"%s  = %20d" % (axis, old), b"%s  = %20d" % (axis, new))

        for name, content in (("empty", b""), ("header", whole[:1000]), ("last", whole[:-1]),
                              ("junk", os.urandom(9000)), ("huge", altered(b"NAXIS1", 256, 10**11)),
                              ("many", altered(b"NAXIS3", 2, 10**13)), ("long", altered(b"NAXIS3", 2, 10**6))):
            (self.folder / f"{name}.fits").write_bytes(content)
        (self.folder / "folder.fits").mkdir()
        os.mkfifo(self.folder / "pipe.fits")
        bad = dict.fromkeys(("nan", "blank"), "frame 1: counts[3][4] = nan: ")
        bad.update(small="64x32", line=" 1 ax", four=" 4 axes", last=f"byte {len(whole)}", huge=" 16384",
                   many=" 16777216 ", long="byte 524")
        for name in (*bad, "none", "empty", "junk", "header", "missing", "folder", "pipe"):
            with self.subTest(name):
                done = self.run_program("encode", "--weights", self.weights, f"{name}.fits")
                self.assertEqual(done.returncode, 3, done.stderr)
                complaints = [line for line in done.stderr.splitlines() if ": warning: " not in line]
                self.assertEqual(len(complaints), 1, done.stderr)  # a frame before may be far from the scene's
                for text in (f"toliman: {name}.fits: ", bad.get(name, "")):
                    self.assertIn(text, complaints[0])

    @unittest.skipIf(os.environ.get("TOLIMAN_SANITIZE"), "sanitizers need more addresses than are left")
    def test_bad_npy(self):
        """Shapes that wrap around or are beyond all memory; tests/unit/test_npy.c has other headers."""
        for name, shape in (("wraps", f"({1 << 24}, {1 << 24}, {1 << 24})"), ("large", "(9999, 16384, 16384)")):  # 2^75 bytes, 0 modulo 2^64
            text = ("{'descr': '<f8', 'fortran_order': False, 'shape': %s, }\n" % shape).encode()
            (self.folder / f"{name}.npy").write_bytes(b"\x93NUMPY\1\0" + struct.pack("<H", len(text)) + text)
            done = subprocess.run(  # 400 MB of address space hold the program, none of these shapes
                ["bash", "-c", 'ulimit -v 400000; exec "$@"', "-", PROGRAM, "convert", f"{name}.npy", "x.npy"],
                cwd=self.folder, capture_output=True, text=True)
            self.assertEqual((done.returncode, f"toliman: {name}.npy: " in done.stderr), (3, True), done.stderr)
            self.assertFalse((self.folder / "x.npy").exists())


class Convert(OutputTest):
    def test_there_and_back(self):
        rng = numpy.random.default_rng(1)
        for name, shape in (("image", (30, 20)), ("cube", (3, 30, 20))):
            with self.subTest(name):
                values = rng.normal(0, 1e-7, shape)
                numpy.save(self.folder / f"{name}.npy", values)
                self.succeed("convert", f"{name}.npy", f"{name}.fits")
                self.assertTrue((fits.getdata(self.folder / f"{name}.fits") == values).all())
                self.succeed("convert", f"{name}.fits", "back.npy")
                back = numpy.load(self.folder / "back.npy")
                self.assertEqual(back.shape, shape)
                self.assertTrue((back == values).all())
        done = subprocess.run([PROGRAM, "convert", "cube.fits", "-"], cwd=self.folder, capture_output=True, check=True)
        self.assertEqual(done.stdout, (self.folder / "back.npy").read_bytes())

    def test_mask_of_a_scene(self):
        """The library reads .npy and says how to come by it."""
        opd = numpy.where(numpy.indices((64, 64)).sum(0) % 14 < 7, 280e-9, 0.0)
        numpy.save(self.folder / "direct.npy", opd)
        fits.writeto(self.folder / "mask.fits", opd)
        self.succeed("convert", "mask.fits", "mask.npy")
        for name in ("direct.npy", "mask.npy", "mask.fits"):
            self.scene(f"{name}.json", telescope={"mask": {"kind": "file", "file": name, "quantity": "opd_m"}})
        for name in ("direct", "mask"):
            self.succeed("psf", f"{name}.npy.json", "--out", f"{name}_psf.npy")
        self.succeed("psf", "mask.npy.json", "--out", "psf.fits")
        direct, mask = (numpy.load(self.folder / f"{name}_psf.npy") for name in ("direct", "mask"))
        self.assertTrue((direct == mask).all())
        self.assertTrue((direct == fits.getdata(self.folder / "psf.fits")).all())
        header, text = fits.getheader(self.folder / "psf.fits"), (self.folder / "mask.npy.json").read_bytes()
        self.assertEqual((header["SCENE"], header["SCENEID"]), ("chapter", "%016x" % fnv1a(text)))
        self.assertEqual((header["BUNIT"], header["PIXSCALE"], header["NWAVES"]), ("photon", 0.2, 6))
        self.assertTrue(header["CREATOR"].startswith("toliman 0."))
        self.assertNotIn("SEED", header)  # nothing random in it
        self.refuse(3, "mask.fits: ", "toliman convert IN.fits OUT.npy", arguments=("psf", "mask.fits.json", "--out", "x.npy"))

    def test_refusals(self):
        numpy.save(self.folder / "a.npy", numpy.array([[1.0, numpy.nan]]))
        self.refuse_all(
            (2, "IN a.csv", "a.csv", "b.npy"), (2, "OUT b.png", "a.npy", "b.png"),
            (6, "no/b.fits: ", "a.npy", "no/b.fits"), (3, "a.npy: frame 0, row 0, column 1", "a.npy", "b.fits"),
            (3, "none.npy: ", "none.npy", "b.fits"), command=("convert",))


if __name__ == "__main__":
    unittest.main()
