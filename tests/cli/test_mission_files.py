"""Files of the mission's image service and of other grounds, written here by numpy, astropy and netCDF4: `track`, `encode` and
toliman.Pair find each frame, its pixels, times, ids and place on the detector."""
import gzip
import json
import shutil
import unittest

import numpy
from peers import fits, netCDF4, toliman
from program import ROOT, ProgramTest

DAY = 86400 * 10**9
SCENE = ROOT / "tests" / "cases" / "files" / "mini.json"  # 12 frames of 32x32, one per day
HAS_NETCDF = bool(toliman.netcdf_version())
needs_astropy = unittest.skipUnless(fits, "needs astropy")
needs_netcdf = unittest.skipUnless(netCDF4 and HAS_NETCDF, "needs netCDF4 and a library with netCDF")


class MissionTest(ProgramTest):
    def setUp(self):
        super().setUp()
        shutil.copy(SCENE, self.folder)
        self.states = 0

    def frames(self):
        """Those of the scene, 12."""
        return toliman.Simulator(SCENE).frames().astype("<u4")

    def small(self, count, rows=6, cols=5):
        return numpy.random.default_rng(7).integers(0, 4096, (count, rows, cols))

    def pair(self, name, frames, roi="single_roi", session="obs", **columns):
        """A pair; columns: frame_id, timestamp_ns, host_time, nframes_dropped and further keys, one value per frame."""
        frames.tofile(self.folder / f"{name}_frames.bin")
        lines = []
        for k, frame in enumerate(frames):
            line = {"frame_id": k, "timestamp_ns": k * DAY, "host_time": k * 86400.0, "nframes_dropped": 0, "roi_label": roi,
                    "n_rows": frame.shape[0], "n_cols": frame.shape[1], "session_id": session}
            lines.append(json.dumps({**line, **{key: values[k] for key, values in columns.items()}}))
        (self.folder / f"{name}_meta.jsonl").write_text("\n".join(lines) + "\n")

    def track(self, *inputs, code=0, state=None, template=("--template", "mini.json")):
        """The lines of frames, and standard error."""
        self.states += 1
        done = self.run_program("track", *template, "--mission-days", "100", "--state", state or f"state{self.states}", *inputs)
        self.assertEqual(done.returncode, code, done.stderr)
        lines = [json.loads(line) for line in done.stdout.splitlines()]
        return [line for line in lines if line["schema"] == "toliman-frame/2"], done.stderr


class Pairs(MissionTest):
    def test_restart(self):
        """All frames before and after a restart are there, once, also when the file is read again."""
        frames = self.frames()
        ids = [k if k < 7 else k - 7 for k in range(12)]
        self.pair("obs", frames, frame_id=ids, timestamp_ns=[k * DAY for k in ids])
        for again in (False, True):
            lines, said = self.track("obs_meta.jsonl", "--dtype", "u32le", state="same")
            self.assertEqual([line["verdict"] for line in lines], ["duplicate" if again else "accepted"] * 12)
            self.assertEqual([line["restarts"] for line in lines], [0] * 7 + [1] * 5)
            self.assertEqual([line["camera_ns"] for line in lines], [k * DAY for k in range(12)])
            self.assertEqual([line["frame_id"] for line in lines], ids)
            self.assertIn("the camera has restarted", said)
        status = json.loads(self.succeed("status", "--json", "same"))
        self.assertEqual([[s["restarts"], s["first_id"], s["last_id"], s["missing"]] for s in status["streams"]],
                         [[0, 0, 6, 0], [1, 0, 4, 0]])
        self.assertIn("obs single_roi restart 1", self.succeed("status", "same"))
        records = [json.loads(line) for line in self.succeed("status", "--records", "same").splitlines()]
        self.assertEqual([line["restarts"] for line in records], [0] * 7 + [1] * 5)

    def test_drops_without_bound(self):
        """12 minutes at 100 Hz are 72,000 frames, and one of a counter that went wild."""
        drops = [0] * 9 + [72000, 2**24 + 5, 2**40]
        self.pair("obs", self.frames(), nframes_dropped=drops)
        lines, _ = self.track("obs_meta.jsonl", "--dtype", "u32le", state="s")
        self.assertEqual({line["verdict"] for line in lines}, {"accepted"})
        records = [json.loads(line) for line in self.succeed("status", "--records", "s").splitlines()]
        kept = drops[:10] + [2**24 - 1] * 2
        self.assertEqual([line["dropped"] for line in records], kept)
        self.assertEqual(json.loads(self.succeed("status", "--json", "s"))["dropped"], sum(kept))

    def test_regions(self):
        """Regions of one shape never share a folder, whether they are files of a folder, of a command or of several."""
        frames = self.frames()
        (self.folder / "in").mkdir()
        for roi in ("left", "right"):
            self.pair(f"in/obs_{roi}", frames if roi == "left" else numpy.roll(frames, 1, 0), roi)
        for inputs in (("in",), ("in/obs_left_meta.jsonl", "in/obs_right_frames.bin")):
            self.assertIn("frames of the regions left, right: --roi LABEL", self.track(*inputs, "--dtype", "u32le", code=2)[1])
        lines, _ = self.track("in", "--dtype", "u32le", "--roi", "left", state="s")
        self.assertEqual([line["roi"] for line in lines], ["left"] * 12)
        lines, said = self.track("in", "--dtype", "u32le", "--roi", "right", state="s")
        self.assertEqual({(line["roi"], line["verdict"], line["reason"]) for line in lines},
                         {("right", "rejected", "other region")})
        self.assertIn("region right: ", said)

    def test_encode_and_calibrate_read_pairs(self):
        """With the values of `track`; a region must be chosen."""
        frames = self.frames()
        self.pair("obs_a", frames, "a")
        tracked, _ = self.track("obs_a_meta.jsonl", "--dtype", "u32le")
        text = self.succeed("encode", "--template", "mini.json", "obs_a_meta.jsonl", "--dtype", "u32le")
        values = [float(line.split(",")[2]) for line in text.splitlines()[1:]]
        self.assertEqual(values, [line["value"] for line in tracked])
        self.pair("obs_b", frames, "b")
        for command in (("encode", "--template", "mini.json"), ("calibrate", "mini.json", "--out", "out.json")):
            done = self.run_program(*command, ".", "--dtype", "u32le")
            self.assertEqual(done.returncode, 2, done.stderr)
            self.assertIn("regions a, b", done.stderr)
        chosen = self.succeed("encode", "--template", "mini.json", ".", "--dtype", "u32le", "--roi", "a")
        self.assertEqual([line.split(",")[1:] for line in chosen.splitlines()],
                         [line.split(",")[1:] for line in text.splitlines()])


@needs_astropy
class FrameProc(MissionTest):
    """frame_proc_CAMTIME.fits.gz."""

    def write(self, name, core, order="PCS", unit="CORE", **keys):
        header = fits.Header([("SEQNUM", 12), ("CAMTIME", "22541562552104"), ("COMTIME", "2025-04-08 15:55:45.020529"),
                              ("EXPOSURE", 46.0), ("XOFF", 912), ("YOFF", 4), ("CENTR_X", 1823), ("CENTR_Y", 1824), *keys.items()])
        for key, value in keys.items():
            header[key] = value
        images = {"C": fits.CompImageHDU(core, name=unit), "S": fits.CompImageHDU(numpy.full((72, 24), 9, "i2"), name="SIDELOBES")}
        fits.HDUList([fits.PrimaryHDU(header=header), *(images[k] for k in order if k in images)]).writeto(self.folder / name)

    def test_frames(self):
        """The core, in any order of the extensions, with the camera's time, id, exposure in us, and place."""
        frames = self.frames().astype("i4")
        for k in range(12):
            camera = 22541562552104 + k * DAY
            self.write(f"frame_proc_{camera}.fits.gz", frames[k], order="PSC" if k % 2 else "PCS", SEQNUM=12 + k,
                       CAMTIME=camera if k % 3 == 0 else str(camera), CENTR_X=1823 + k)
        lines, said = self.track(".", state="s")
        lines.sort(key=lambda line: line["frame_id"])  # files are read in the order of their names
        self.assertEqual([line["verdict"] for line in lines], ["accepted"] * 12)
        self.assertEqual([line["frame_id"] for line in lines], list(range(12, 24)))
        self.assertEqual([line["camera_ns"] for line in lines], [22541562552104 + k * DAY + 23000 for k in range(12)])
        self.assertIn("by the camera's clock", said)
        self.pair("same", self.frames())
        expected, _ = self.track("same_meta.jsonl", "--dtype", "u32le")
        self.assertEqual([line["value"] for line in lines], [line["value"] for line in expected])
        with toliman.Tracker.open(self.folder / "s") as tracker:
            columns = numpy.sort(tracker.records(), order="frame_id")
        self.assertEqual(list(columns["window_col"]), [912 + 1823 + k - 64 for k in range(12)])
        self.assertEqual(set(columns["window_row"]), {4 + 1824 - 64})
        self.assertEqual(set(columns["exposure_s"]), {46e-6})

    def test_units(self):
        """--hdu, and files that are refused."""
        frame = self.frames()[0].astype("i4")
        self.write("other.fits", frame, unit="WIDE")
        self.write("edge.fits", frame, order="PSC", CENTR_X=20, CENTR_Y=10)
        self.assertEqual(len(self.track("other.fits")[0]), 1)  # the first image
        self.assertEqual(len(self.track("edge.fits", "--hdu", "2")[0]), 1)
        self.assertIn("72x24", self.track("edge.fits", "--hdu", "SIDELOBES")[1])
        self.assertIn("--hdu NONE: there is no such image", self.track("edge.fits", "--hdu", "NONE")[1])
        self.track("edge.fits", state="e")
        with toliman.Tracker.open(self.folder / "e") as tracker:
            self.assertEqual([tracker.records()[name][0] for name in ("window_row", "window_col")], [4, 912])
        self.write("bad.fits", frame, CAMTIME="soon")
        self.assertIn("CAMTIME = soon: must be a whole number", self.track("bad.fits")[1])
        self.write("whole.fits", frame)
        packed = gzip.compress((self.folder / "whole.fits").read_bytes())
        (self.folder / "cut.fits.gz").write_bytes(packed[:len(packed) // 2])
        self.assertIn("cut.fits.gz", self.track("cut.fits.gz")[1])


@needs_netcdf
class Batches(MissionTest):
    def write(self, name, frames, first=0, kind=None, bulk=False, **changes):
        """A batch as the service writes it: `bulk` by the older writer. changes: other variables, None for none."""
        count, rows, cols = frames.shape
        steps = numpy.diff(frames, axis=0) if not bulk else frames[1:] - frames[0]
        kind = kind or ("i1" if abs(steps).max(initial=0) <= 127 else "i2")
        reference, differences = ("ref_core", "diff_core") if bulk else ("centre_reference", "centre_differences")
        variables = {reference: ("u2", ("row", "col"), frames[0]), differences: (kind, ("step", "row", "col"), steps)}
        if not bulk:
            ids = first + numpy.arange(count)
            variables.update(timestamp_ns=("i8", ("frame",), ids * 10**7 + 3), frame_id=("i8", ("frame",), ids),
                             host_time=("f8", ("frame",), ids * 0.01), nframes_dropped=("i4", ("frame",), ids * 0 + 70000))
        variables.update(changes)
        with netCDF4.Dataset(self.folder / name, "w") as out:
            for dimension, length in (("row", rows), ("col", cols), ("step", count - 1), ("frame", count), ("other", 3)):
                out.createDimension(dimension, length)
            for variable, (kind, dimensions, values) in (item for item in variables.items() if item[1]):
                made = out.createVariable(variable, kind, dimensions, zlib=True, complevel=5)
                made.set_auto_maskandscale(False)
                made[:] = values
                if variable == differences:
                    made.scale_factor = 1.0
                if variable == reference:
                    made.valid_max = numpy.uint16(4095)
            out.session_id, out.batch_size, out.conventions = "obs", count, "CF-1.8"
            for k in range(count * bulk):
                for key, value in (("SEQNUM", 5 + k), ("CAMTIME", str(10**7 * k + 3)), ("XOFF", 912), ("YOFF", 4),
                                   ("CENTR_X", 100 + k), ("CENTR_Y", 90)):
                    out.setncattr(f"{k}_{key}", value)

    def read(self, name, **options):
        return list(toliman.Pair(self.folder / name, **options))

    def test_pixels_and_numbers(self):
        """Sums of int8 and int16 are exact, by either convention; times to 1 ns."""
        smooth = 2000 + numpy.cumsum(numpy.random.default_rng(1).integers(-127, 128, (40, 6, 5)), 0) // 4
        for frames in (self.small(20), smooth, self.small(1), numpy.array([[[0, 4095]], [[4095, 0]], [[0, 4095]]])):
            for bulk in (False, True):
                self.write("obs_batch0000.nc", frames, bulk=bulk)
                found = self.read("obs_batch0000.nc", exposure_s=0.005)
                numpy.testing.assert_array_equal([frame.pixels for frame in found], frames)
                self.assertEqual(found[0].pixels.dtype, numpy.uint16)
                numbers = range(len(frames))
                self.assertEqual([frame.camera_ns for frame in found], [10**7 * k + 3 + 2500000 for k in numbers])
                self.assertEqual([frame.frame_id for frame in found], [5 * bulk + k for k in numbers])
                self.assertEqual({(frame.session, frame.roi, frame.restarts) for frame in found},
                                 {("obs_batch0000" if bulk else "obs", "centre", 0)})
                self.assertEqual({frame.dropped for frame in found}, {0 if bulk else 70000})
                self.assertEqual([frame.window for frame in found], [(30, 948 + k) if bulk else (0, 0) for k in numbers])

    def test_parts(self):
        """Views of several frames at once, frames of some ids, and those of no other region."""
        frames = self.small(9)
        self.write("obs_batch0000.nc", frames)
        found = self.read("obs_batch0000.nc", frame_ids=range(3, 6))
        self.assertEqual([frame.frame_id for frame in found], [3, 4, 5])
        numpy.testing.assert_array_equal([frame.pixels for frame in found], frames[3:6])
        self.assertEqual(self.read("obs_batch0000.nc", roi="left"), [])
        pair = toliman.Pair(self.folder / "obs_batch0000.nc")
        self.assertEqual(len(list(pair)), 9)
        self.assertEqual(list(pair), [])
        self.assertEqual(pair.info().frames, 9)

    def test_restarts(self):
        """Ids that begin again within a batch or before it never meet those of other batches."""
        keys = set()
        for number, first in ((0, 0), (1, 10), (2, 3), (3, 13)):
            self.write(f"obs_batch{number:04}.nc", self.small(10), first)
            keys |= {(frame.restarts, frame.frame_id) for frame in self.read(f"obs_batch{number:04}.nc")}
        self.assertEqual(len(keys), 40)
        ids, times = [20, 21, 22, 0, 1, 2], numpy.array([0, 1, 2, 9, 10, 11])
        self.write("obs_batch0000.nc", self.small(6), frame_id=("i8", ("frame",), ids), host_time=("f8", ("frame",), times),
                   timestamp_ns=("i8", ("frame",), 10**9 * numpy.array([50, 51, 52, 7, 8, 9])))
        found = self.read("obs_batch0000.nc")
        self.assertEqual([frame.restarts for frame in found], [0, 0, 0, 1, 1, 1])
        self.assertEqual([frame.camera_ns // 10**9 for frame in found], list(50 + times))

    def test_refused(self):
        """Each with the name of what is wrong."""
        frames = self.small(5)
        wrong = {
            "centre_reference": {"centre_reference": None},
            "frame_id: must have 5 numbers": {"frame_id": ("i8", ("other",), [0, 1, 2])},
            "no variable host_time": {"host_time": None},
            "timestamp_ns must be of integers": {"timestamp_ns": ("f8", ("frame",), numpy.zeros(5))},
            "centre_differences must be of integers": {"centre_differences": ("f4", ("step", "row", "col"), numpy.zeros((4, 6, 5)))},
            "centre_differences: must have 3 dim": {"centre_differences": ("i2", ("other", "col", "row"), numpy.zeros((3, 5, 6)))},
            "frame 1: the differences are damaged": {"centre_differences": ("i2", ("step", "row", "col"), numpy.full((4, 6, 5), 4095))},
            "frame 2: the differences are damaged": {"centre_differences": ("i2", ("step", "row", "col"),
                                                                            [-frames[0], *numpy.full((3, 6, 5), -1)])},
            "nframes_dropped = -1": {"nframes_dropped": ("i4", ("frame",), numpy.full(5, -1))}}
        for what, changes in wrong.items():
            with self.subTest(what):
                self.write("bad.nc", frames, **changes)
                with self.assertRaisesRegex(toliman.InputError, what):
                    self.read("bad.nc")
        with netCDF4.Dataset(self.folder / "huge.nc", "w") as out:
            for name in "abc":
                out.createDimension(name, 60000)
            out.createVariable("centre_reference", "u2", ("a", "b"), zlib=True)
        with self.assertRaisesRegex(toliman.InputError, "33554432"):
            self.read("huge.nc")

    def test_truncated(self):
        """A file that is cut off anywhere gives its frames or an error, never other pixels."""
        frames = self.small(8)
        self.write("obs_batch0000.nc", frames)
        whole = (self.folder / "obs_batch0000.nc").read_bytes()
        refused = 0
        for at in range(0, len(whole), 611):
            (self.folder / "bad.nc").write_bytes(whole[:at])
            try:
                found = [frame.pixels for frame in self.read("bad.nc")]
                numpy.testing.assert_array_equal(found, frames[:len(found)])
            except (toliman.InputError, toliman.NotFoundError):
                refused += 1
        self.assertGreater(refused, 20)

    def test_crash(self):
        """Bytes on which HDF5 crashes: the program says so, and reads the other files."""
        self.write("obs_batch0000.nc", self.small(8))
        whole = (self.folder / "obs_batch0000.nc").read_bytes()
        for at in range(0, len(whole), 1709):
            (self.folder / f"bad{at:06}.nc").write_bytes(whole[:at] + bytes(64) + whole[at + 64:])
        names = [path.name for path in sorted(self.folder.glob("*.nc"))]
        lines, said = self.track(*names)  # frames of another size
        self.assertEqual(sum(line["input"].startswith("obs_batch0000.nc") for line in lines), 8, said)

    def test_track(self):
        """A folder of batches gives the values of a pair with the same counts; `encode` too."""
        scene = json.loads(SCENE.read_text())
        scene["cadence"]["peak_photons"] = 3000
        (self.folder / "mini.json").write_text(json.dumps(scene))
        frames = toliman.Simulator(self.folder / "mini.json").frames().astype("<u2")
        for number in range(2):
            part = slice(6 * number, 6 * number + 6)
            days = DAY * numpy.arange(12)[part]
            self.write(f"obs_batch000{number}.nc", frames[part].astype("i8"), 6 * number,
                       timestamp_ns=("i8", ("frame",), days), host_time=("f8", ("frame",), days / 1e9))
        lines, _ = self.track(".", state="s")
        self.assertEqual([line["verdict"] for line in lines], ["accepted"] * 12)
        self.assertEqual([(line["frame_id"], line["camera_ns"]) for line in lines], [(k, k * DAY) for k in range(12)])
        encoded = self.succeed("encode", "--template", "mini.json", ".").splitlines()[1:]
        self.pair("same", frames)
        expected = [line["value"] for line in self.track("same_meta.jsonl", "--dtype", "u16le")[0]]
        self.assertEqual([line["value"] for line in lines], expected)
        self.assertEqual([float(line.split(",")[2]) for line in encoded], expected)


class Orbits(ProgramTest):
    """One orbit in each format: the same velocities."""

    TIMES = [numpy.datetime64("2028-03-01T00:00:00") + numpy.timedelta64(60 * k, "s") for k in range(30)]
    META = {"OBJECT_NAME": "T", "OBJECT_ID": "2028-001A", "CENTER_NAME": "EARTH", "REF_FRAME": "EME2000", "TIME_SYSTEM": "TDB",
            "START_TIME": "2028-03-01T00:00:00", "STOP_TIME": "2028-03-01T00:29:00"}
    NAMES = ("X", "Y", "Z", "X_DOT", "Y_DOT", "Z_DOT")

    def states(self):
        """A circular orbit, km and km/s."""
        radius, rate = 6978.0, numpy.sqrt(398600.4418 / 6978.0**3)
        angle = rate * 60 * numpy.arange(30)
        along, across = numpy.cos(angle), numpy.sin(angle)
        tilt = numpy.radians(97.4)
        place = radius * numpy.stack((along, across * numpy.cos(tilt), across * numpy.sin(tilt)), 1)
        speed = radius * rate * numpy.stack((-across, along * numpy.cos(tilt), along * numpy.sin(tilt)), 1)
        return [[f"{number:.12f}" for number in row] for row in numpy.hstack((place, speed))]

    def kvn(self, **changes):
        lines = ["CCSDS_OEM_VERS = 2.0", "CREATION_DATE = 2028-01-01T00:00:00", "ORIGINATOR = X", "META_START"]
        lines += [f"{key} = {value}" for key, value in {**self.META, **changes}.items()] + ["META_STOP"]
        lines += [" ".join((str(time), *row)) for time, row in zip(self.TIMES, self.states())]
        return "\n".join(lines) + "\n"

    def xml(self, units=True, head="", unit="km", state=""):
        unit_of = lambda name: f' units="{"km/s" if "DOT" in name else unit}"' if units else ""
        body = "".join(f"<{key}>{value}</{key}>\n" for key, value in self.META.items())
        data = "".join(f"<stateVector><EPOCH>{time}</EPOCH>"
                       + "".join(f"<{name}{unit_of(name)}>{value}</{name}>" for name, value in zip(self.NAMES, row))
                       + f"{state}</stateVector>\n" for time, row in zip(self.TIMES, self.states()))
        cover = '<covarianceMatrix><EPOCH>2028-03-01T00:00:00</EPOCH><CX_X units="km**2">1</CX_X></covarianceMatrix>'
        return (f'<?xml version="1.0" encoding="UTF-8"?>\n{head}<ndm xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance">\n'
                '<oem id="CCSDS_OEM_VERS" version="2.0"><header><COMMENT>a &amp; b</COMMENT><CREATION_DATE>2028-01-01T00:00:00'
                f"</CREATION_DATE>\n<ORIGINATOR>X</ORIGINATOR></header><body><segment><metadata>{body}</metadata>"
                f"<data><COMMENT>1</COMMENT>{data}{cover}</data></segment></body></oem></ndm>\n")

    def horizons(self, **changes):
        said = {"Center body name": "Earth (399)", "Center-site name": "BODY CENTER", "Output units": "KM-S",
                "Output type": "GEOMETRIC cartesian states", "Reference frame": "ICRF", **changes}
        days = [2461831.5 + k / 1440 for k in range(30)]
        lines = ["*" * 40, *(f"{key} : {value}" for key, value in said.items()), "*" * 40,
                 "            JDTDB,            Calendar Date (TDB),   X,   Y,   Z,  VX,  VY,  VZ,  LT,", "*" * 40, "$$SOE"]
        lines += [f"{day:.9f}, A.D. 2028-Mar-01 00:00:00.0000, {', '.join(row)}, 2.0E-02," for day, row in zip(days, self.states())]
        return "\n".join([*lines, "$$EOE", "*" * 40, ""])

    def velocities(self, content):
        (self.folder / "orbit").write_bytes(content if isinstance(content, bytes) else content.encode())
        times = [toliman.parse_time(f"2028-03-01T00:{minute:02}:37", scale="tdb") for minute in range(5, 25, 4)]
        return toliman.Sky("alpha-cen", self.folder / "orbit").predict(times)["separation_arcsec"]

    def test_formats_agree(self):
        expected = self.velocities(self.kvn())
        xml = self.xml()
        for content in (self.kvn(REF_FRAME="J2000"), gzip.compress(self.kvn().encode()), xml, self.xml(units=False),
                        gzip.compress(xml[:99].encode()) + gzip.compress(xml[99:].encode()), b"\xef\xbb\xbf" + xml.encode()):
            numpy.testing.assert_array_equal(self.velocities(content), expected)
        found = self.velocities(self.horizons())
        numpy.testing.assert_allclose(found, expected, rtol=0, atol=1e-10)  # 1e-4 uas: JDTDB has 9 decimals
        self.assertFalse(numpy.array_equal(found, toliman.Sky("alpha-cen").predict([0])["separation_arcsec"]))

    def test_refused(self):
        """Each with its line or reason, and without the bytes of a binary file."""
        packed = gzip.compress(self.kvn().encode())
        bomb = '<!DOCTYPE x [<!ENTITY a "b"><!ENTITY c "&a;&a;">]>'
        cases = [(packed[:300], "damaged or truncated gzip"), (packed[:40] + b"x" * 20 + packed[60:], "damaged or truncated gzip"),
                 (gzip.compress(b"\0" * 1000), "is not a text file"), (bytes(range(256)), "is not a text file"),
                 (b"BZh91AY&SY" + b"\xfe" * 50, "is not a text file"), (self.xml(head=bomb), "document type is not allowed"),
                 (self.xml()[:-50], "not valid XML"), (self.xml(unit="m"), 'units="m">: must be km'),
                 (self.xml(state="<X>1</X>"), "twice in a state"), (self.xml(state="<W>1</W>"), "unknown element of a state"),
                 (self.xml(units=False).replace("Y_DOT>", "X_DDOT>"), "Y_DOT is missing"),
                 (self.xml().replace("EME2000", "TEME"), ":7: REF_FRAME = TEME"),
                 (self.xml().replace("oem", "aem"), "<aem>: unknown element"), ("<svg></svg>", "must be an Orbit Ephemeris"),
                 (self.horizons(**{"Output units": "AU-D"}), ":4: \"Output units"), (self.horizons(**{"Reference frame": "B1950"}), "ICRF"),
                 (self.horizons(**{"Center body name": "Sun (10)"}), "Sun"), (self.horizons().split("$$EOE")[0], "ends before \\$\\$EOE"),
                 (self.horizons().replace("JDTDB", "JDUT"), "no column JDTDB"), (self.horizons().replace("2461831.5", "x", 1), "JDTDB = ")]
        for content, what in cases:
            with self.subTest(what):
                with self.assertRaisesRegex(toliman.InputError, what) as caught:
                    self.velocities(content)
                self.assertRegex(str(caught.exception), r"^[\x20-\x7e]*$")


if __name__ == "__main__":
    unittest.main()
