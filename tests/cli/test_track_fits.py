"""Times, numbers and sessions of FITS files in track, and shards by frame id. tests/unit/test_ingest_header.c has the keywords."""
import json
import random
import unittest
import numpy
from astropy.io import fits
from program import leap_seconds
from test_track import FRAMES, GRID, Track

DAY = 86400 * 10**9


def utc_ns(day, ahead=37):
    """TAI of the beginning of a day of UTC."""
    return int(numpy.datetime64(day, "ns").astype(int)) + ahead * 10**9


class Fits(Track):
    def write(self, name, cards, images=None):
        """A FITS file by hand, so that a value is written exactly as given: cards {key: text}."""
        images = numpy.asarray(self.frames[0] if images is None else images, ">i4")
        axes = {f"NAXIS{k + 1}": n for k, n in enumerate(reversed(images.shape))}
        lines = [f"{key:<8}= {value:>20}" for key, value in
                 {"SIMPLE": "T", "BITPIX": 32, "NAXIS": images.ndim, **axes, **cards}.items()] + ["END"]
        header = "".join(f"{line:<80}" for line in lines)
        data = images.tobytes()
        content = f"{header:<{-(-len(header) // 2880) * 2880}}".encode() + data + bytes(-len(data) % 2880)
        (self.folder / name).write_bytes(content)
        return name

    def read(self, names, *more, state="s", code=0):
        """Frame lines by session, the first warning by file: every file has one."""
        self.out = self.track(state, *more, "-", code=code, stdin="\n".join(names))
        frames = {line["session"]: line for line in self.out if line["schema"] == "toliman-frame/2"}
        issued = {line["input"]: line for line in reversed(self.out) if line["schema"] == "toliman-track-warning/1"}
        self.assertEqual(sorted(issued), sorted(names))
        return frames, issued

    def times(self, cases, *more):
        """What the program makes of {name: cards}: TAI, which is the camera's time as well."""
        names = [self.write(f"{name}.fits", cards) for name, cards in cases.items()]
        random.Random(1).shuffle(names)
        frames, _ = self.read(names, *more)
        self.assertEqual(frames.keys(), cases.keys(), self.errors)
        self.assertTrue(all(line["verdict"] == "accepted" for line in frames.values()))
        self.assertTrue(all(line["tai_ns"] == line["camera_ns"] for line in frames.values()))
        return {name: line["tai_ns"] for name, line in frames.items()}


class Times(Fits):
    def test_rules(self):
        """Of the library, which the program tells; a time without exposure is mid-exposure, whatever --cadence says."""
        day, clock, half = "'2028-03-01'", "'12:34:56'", 1800 * 10**9
        start = utc_ns("2028-03-01") + (12 * 3600 + 34 * 60 + 56) * 10**9
        cases = (({"DATE-OBS": day, "TIME-OBS": clock, "EXPTIME": "3600"}, start + half, "DATE-OBS + TIME-OBS + EXPTIME/2 in UTC"),
                 ({"DATE-BEG": "'2028-03-01T12:34:56'", "DATE-END": "'2028-03-01T13:34:56'"}, start + half, "DATE-BEG and DATE-END in UTC"),
                 ({"DATE-OBS": "'2028-03-01T12:34:56'", "EXPTIME": "3600", "TIMESYS": "'TAI'"}, start + half - 37 * 10**9, "in TAI"),
                 ({"DATE-AVG": "'2016-12-31T23:59:60.5'"}, utc_ns("2017-01-01") - 5 * 10**8, "DATE-AVG in UTC"),
                 ({"MJD-AVG": "60000.123456789012345678", "TIMESYS": "'TAI'"}, 19413 * DAY + 10666666570667, "MJD-AVG in TAI"),
                 ({"MJD-BEG": "60000", "TIMESYS": "'TAI'"}, 19413 * DAY, "MJD-BEG, taken as mid-exposure"))
        for cadence in ((), ("--cadence", "60")):
            names = [self.write(f"k{k}.fits", {"TIMESYS": "'UTC'", **cards}) for k, (cards, _, _) in enumerate(cases)]
            frames, issued = self.read(names, *cadence, state=f"s{len(cadence)}")
            for k, (cards, ns, rule) in enumerate(cases):
                self.assertEqual((frames[f"k{k}"]["tai_ns"], frames[f"k{k}"]["camera_ns"]), (ns, ns), cards)
                self.assertIn(rule, issued[f"k{k}.fits"]["text"])
                self.assertEqual(f"toliman: warning: k{k}.fits" in self.errors, "mid-exposure" in rule)
        name = self.write("x.fits", {"DATE-OBS": "'2017-01-01T00:00:00'", "EXPTIME": "0"})
        frames, issued = self.read([name], "--strict", state="x")
        self.assertEqual(frames["x"]["tai_ns"], utc_ns("2017-01-01"))
        self.assertIn("TIMESYS", issued[name]["text"])
        self.assertIn("toliman: warning: x.fits: ", self.errors)

    def test_refused(self):
        """Each has its line on standard output; ten of a kind are told."""
        cases = [{"MJD-AVG": "-1"}, {"DATE-AVG": "'2029-13-01'"}, {"DATE-AVG": "'2017-12-31T23:59:60'"}, {"DATE-AVG": "'2029-01-01'"},
                 {"DATE-AVG": "'2029-01-01T12:00:00'", "MJD-OBS": "62502"}, {"MJD-BEG": "60000", "XPOSURE": "-1"},
                 {"MJD-AVG": "60000", "TIMESYS": "5"}, {"MJD-AVG": "60000", "FRAME1": "1.5"},
                 {"MJD-AVG": "60000", "FRAME1": "9223372036854775807"}, {"MJD-AVG": "."}, {}, {"DATE-AVG": "2029"}]
        names = [self.write(f"x{k}.fits", {"TIMESYS": "'UTC'", "XPOSURE": "10", **cards}) for k, cards in enumerate(cases)]
        frames, issued = self.read(names)
        self.assertEqual(frames, {})
        for name, cards in zip(names, cases):
            self.assertEqual(issued[name]["warning"], "unreadable input", cards)
            self.assertIn([*cards, "--cadence"][len(cards) - 1 if cards else 0], issued[name]["text"])
            self.assertEqual(self.errors.count(name + ":"), name in names[:10], self.errors)
        self.assertEqual(self.counts(self.out)["unreadable_inputs"], len(cases))
        self.read(names[:1], "--strict", code=4)

    def test_extensions(self):
        """The image's header goes before the file's."""
        primary = fits.Header([("MJD-OBS", 60000.5), ("EXPTIME", 100.0), ("TIMESYS", "TAI"), ("FRAME1", 7)])
        image = self.frames[0].astype("i4")
        for name, unit in (("plain", fits.ImageHDU), ("tiles", fits.CompImageHDU)):
            of_image = fits.Header([("EXPTIME", 2.0)])
            fits.HDUList([fits.PrimaryHDU(header=primary), unit(image, header=of_image)]).writeto(self.folder / f"{name}.fits")
            frames, _ = self.read([f"{name}.fits"])
            self.assertEqual(frames[name]["tai_ns"], 19413 * DAY + DAY // 2 + 10**9)
            self.assertEqual(frames[name]["frame_id"], 7)
            self.assertEqual(frames[name]["verdict"], "accepted")

    def test_what_follows_the_image(self):
        """Further images of its name and size are named; others, and bytes that are no HDU, change nothing."""
        def image(name):
            return fits.ImageHDU(self.frames[0].astype("i4"), name=name)

        cases = (("one", ["SCI"], b"", None), ("two", ["SCI", "SCI"], b"", "HDU 1 is read alone: images of its name and size in HDU 2 "),
                 ("hubble", ["SCI", "ERR", "SCI", "ERR", "SCI"], b"", "in HDU 3, 5 "), ("unnamed", [None, None], b"", "in HDU 2 "),
                 ("core", ["RAW", "CORE", "RAW"], b"", None), ("junk", ["SCI"], b"x" * 2880, None),
                 ("cut", ["SCI"], b"XTENSION= 'IMAGE   '", None))
        for name, units, more, note in cases:
            with self.subTest(name):
                primary = fits.PrimaryHDU()
                primary.header["DATE-AVG"], primary.header["TIMESYS"] = "2028-03-01T12:00:00", "UTC"
                fits.HDUList([primary, *map(image, units)]).writeto(self.folder / f"{name}.fits")
                with open(self.folder / f"{name}.fits", "ab") as stream:
                    stream.write(more)
                out = self.track(name, f"{name}.fits")
                self.assertEqual([line["verdict"] for line in out if line["schema"] == "toliman-frame/2"], ["accepted"])
                told = [line["text"] for line in out if line.get("warning") == "other images"]
                self.assertEqual(len(told), note is not None)
                self.assertTrue(note is None or note in told[0], told)
                if name == "hubble":
                    self.assertFalse([line for line in self.track("third", "--hdu", "3", f"{name}.fits")
                                      if line.get("warning") == "other images"])

    def test_table_of_leap_seconds(self):
        """A further leap second at the end of 2029, MJD 62501; tests/unit/test_ingest_time.c has the files that are refused."""
        (self.folder / "own.list").write_text(leap_seconds(62502))
        cases = {"a": {"DATE-AVG": "'2029-12-31T23:59:58'"}, "b": {"DATE-AVG": "'2030-01-01T00:00:00'"}}
        names = [self.write(f"{name}.fits", {**cards, "TIMESYS": "'UTC'"}) for name, cards in cases.items()]
        for state, more, apart, told in (("s", (), 2, 1), ("own", ("--leap-seconds", "own.list"), 3, 0)):
            frames, _ = self.read(names, *more, state=state)
            self.assertEqual(frames["b"]["tai_ns"] - frames["a"]["tai_ns"], apart * 10**9)
            self.assertEqual(self.errors.count("leap seconds are known"), told)
        command = ("track", "--state", "t", "--template", "scene.json", *GRID, "a.fits", "--leap-seconds")
        (self.folder / "bad").write_text("x\n")
        for name, why in (("bad", "bad:1"), ("none", "none")):
            self.refuse(3, why, arguments=(*command, name))


class Files(Fits):
    def test_cubes(self):
        """Frame 0 has the header's time; the others follow the table FRAMES, or --cadence."""
        start = utc_ns("2029-01-01")
        keys = {"DATE-AVG": "'2029-01-01T00:00:00'", "TIMESYS": "'UTC'"}
        images = self.frames.astype("i4")
        self.write("cube.fits", keys, images)
        out = [line for line in self.track("s", "cube.fits", "--cadence", "43200.5") if "value" in line]
        self.assertEqual([line["tai_ns"] for line in out], [start + k * 43200500000000 for k in range(FRAMES)])
        self.assertIn("by --cadence", self.errors)
        self.track("t", "cube.fits", "--strict", code=4)
        self.assertIn("--cadence", self.errors)
        with fits.open(self.folder / "cube.fits") as cube:
            days = numpy.arange(FRAMES) * 1.25 - 3
            table = fits.BinTableHDU.from_columns([fits.Column("time_days", "D", array=days)], name="FRAMES")
            fits.HDUList([cube[0], table]).writeto(self.folder / "both.fits")
            fits.HDUList([cube[0], fits.BinTableHDU(table.data[:5], name="FRAMES")]).writeto(self.folder / "few.fits")
        for cadence in ((), ("--cadence", "5")):  # what the file says goes before
            out = [line for line in self.track(f"u{len(cadence)}", "both.fits", *cadence) if "value" in line]
            self.assertEqual([line["tai_ns"] for line in out], [start + k * DAY * 5 // 4 for k in range(FRAMES)])
        self.assertIn("by its table FRAMES", self.errors)
        self.track("v", "few.fits", "--strict", code=4)
        self.assertRegex(self.errors, "few.fits: .*5 rows")

    def test_numbers_times_cadence(self):
        """Without a time FRAME1 tells a file's place, by --session or names; the same files again are no overlap."""
        cubes = [self.write(f"c{k}.fits", {"FRAME1": str(4 * k)} if k else {}, self.frames[4 * k:4 * k + 4]) for k in range(3)]
        for session in ((), ("--session", "one")):
            files = cubes[::-1] if not session else [*cubes[:0:-1], *cubes[1:]]  # of one session all need FRAME1
            out = self.track(f"s{len(session)}", "-", "--cadence", "0.7", *session, stdin="\n".join(files))
            frames = [line for line in out if line.get("verdict") == "accepted"]
            self.assertEqual(sorted(line["frame_id"] for line in frames), list(range(4 if session else 0, 12)))
            self.assertEqual([line["camera_ns"] for line in frames], [line["frame_id"] * 700000000 for line in frames])
            self.assertNotIn("warning", self.errors)
            self.assertIn("c2.fits: time by FRAME1 and --cadence", self.errors)
        before = self.write("before.fits", {"FRAME1": "-3"}, self.frames[:2])
        out = self.track("before", before, "--cadence", "2")
        self.assertEqual([line["camera_ns"] for line in out if "value" in line], [-6 * 10**9, -4 * 10**9])
        far = self.write("far.fits", {"FRAME1": str(2**62)})
        self.track("far", far, "--cadence", "2", "--strict", code=4)
        self.assertIn("far.fits", self.errors)

    def test_same_times_by_cadence(self):
        """Files of which nothing tells the time."""
        for k in range(3):
            numpy.save(self.folder / f"a{k}.npy", self.frames[4 * k:4 * k + 4])
            self.write(f"b{k}.fits", {"FRAME1": str(3 * k)}, self.frames[4 * k:4 * k + 4])
            self.write(f"t{k}.fits", {"MJD-AVG": str(60000 + 3 * k), "TIMESYS": "'TAI'"}, self.frames[4 * k:4 * k + 4])
        for kind, names in (("a", ["a0.npy", "a1.npy", "a2.npy", "a0.npy"]), ("b", [f"b{k}.fits" for k in range(3)]),
                            ("t", [f"t{k}.fits" for k in range(3)])):
            out = self.track(kind, *names, "--cadence", "86400", "--strict")
            told = {line["input"]: line["text"] for line in out if line.get("warning") == "same times"}
            self.assertEqual(list(told), names[1:3])
            self.assertIn(names[0], told[names[1]])
            self.assertEqual(self.errors.count("warning: "), 2, self.errors)
        self.track("apart", "t0.fits", "t1.fits", "t2.fits", "--cadence", "3600")
        self.assertNotIn("warning", self.errors)

    def test_single_images(self):
        """An image a file with a date each, in any order: the period of the pair."""
        start = utc_ns("2029-01-01")
        pair = self.counts(self.track("pair", "all"))
        names = []
        for k in range(FRAMES):
            keys = {"MJD-OBS": f"{62502 + k}", "EXPTIME": "86400", "TIMESYS": "'UTC'"}
            names.append(self.write(f"sky.{k:04d}.fits", {**keys, "FRAME1": str(100 + k)}, self.frames[k]))
        for seed, session in ((1, ()), (2, ("--session", "sky"))):
            random.Random(seed).shuffle(names)
            again = [*names, *names[:5]]
            out = self.track(f"s{seed}", "-", *session, "--epoch", str(start), stdin="\n".join(again))
            last = self.counts(out)
            self.assertEqual((last["accepted"], last["repeated"], last["missing"]), (FRAMES, 5, 0))
            self.assertEqual(last["sessions"], 1 if session else FRAMES)
            frames = {(line["session"], line["frame_id"]) for line in out if line["schema"] == "toliman-frame/2"}
            self.assertEqual(frames, {("sky" if session else f"sky.{k:04d}", 100 + k) for k in range(FRAMES)})
            self.assertAlmostEqual(last["period"] / pair["period"], 1, delta=1e-9)
            self.assertAlmostEqual(last["log10_fap"] / pair["log10_fap"], 1, delta=1e-9)
        self.assertEqual(self.sums("s1"), self.sums("s2"))
        bare = [self.write(f"bare{k}.fits", {"MJD-AVG": f"{62502 + k}", "TIMESYS": "'UTC'"}) for k in range(3)]
        frames, issued = self.read(bare, "--session", "one", state="bare")
        self.assertEqual(len(frames), 1)
        self.assertIn("FRAME1", issued[bare[1]]["text"])

    def test_clock(self):
        """A time that is TAI is not converted by a clock table."""
        (self.folder / "clock.csv").write_text("0,1000\n")
        (self.folder / "same.csv").write_text("0,0\n5,5\n")
        self.write("x.fits", {"MJD-AVG": "60000", "TIMESYS": "'TAI'"})
        self.track("s", "x.fits", "--clock", "clock.csv", code=2)
        self.assertIn("x.fits: its time (MJD-AVG in TAI)", self.errors)
        self.assertFalse((self.folder / "s").exists())  # as it has no frame
        self.succeed("simulate", "scene.json", "--out", "day.fits")
        out = self.track("s", "day.fits", "--clock", "clock.csv")  # the camera's time
        self.assertTrue(all(line["tai_ns"] == line["camera_ns"] + 1000 for line in out if "value" in line))
        self.track("s", "-", code=2, stdin="x.fits")  # the clock is remembered
        out = self.track("same", "x.fits", "--clock", "same.csv")
        self.assertEqual(self.counts(out)["accepted"], 1)


class Shards(Fits):
    def test_by_frame_id(self):
        clean = self.clean(range(FRAMES))
        self.succeed("simulate", "scene.json", "--out", "day.fits")
        for name in ("all", "day.fits"):
            parts = []
            for first, end in ((-5, 17), (17, 18), (18, 1000)):
                state = f"{name}_{first}"
                out = self.track(state, name, "--frames", f"{first}:{end}")
                mine = [k for k in range(FRAMES) if first <= k < end]
                self.assertEqual([line["frame_id"] for line in out if "value" in line], mine)
                last = self.counts(out)
                self.assertEqual((last["accepted"], last["passed_over"]), (len(mine), FRAMES - len(mine)))
                self.assertEqual((last["received"], last["rejected"]), (len(mine), 0))
                parts.append(state)
            self.run_program("merge", *parts, "--out", f"m{name}")
            self.assertEqual(self.sums(f"m{name}"), clean)

    def test_others_are_silent(self):
        """Damage of a frame that is not asked for is told by the shard that has it."""
        pixels = self.frames.copy()
        pixels[3].reshape(-1)[1000:2100] = 0
        facts = json.loads(self.lines[5])
        facts["timestamp_ns"] = 10**18
        self.lines[5] = json.dumps(facts)
        self.pair("in/x", self.lines, pixels[:-1])  # the last one is missing
        whole = self.counts(self.track("whole", "in"))
        self.assertEqual((whole["rejected"], whole["short_frames"], whole["clock_jumps"], whole["passed_over"]), (1, 1, 2, 0))
        out = self.track("s", "in", "--frames", "10:40", "--strict")
        self.assertEqual(self.errors, "")
        self.assertEqual((self.counts(out)["accepted"], self.counts(out)["passed_over"]), (30, FRAMES - 30))
        self.track("t", "in", "--frames", "40:48", "--strict", code=4)
        self.assertIn("x_frames.bin", self.errors)

    def test_refused(self):
        command = ("track", "--state", "s", "--template", "scene.json", "--dtype", "u32le", *GRID, "all", "--frames")
        for text in ("5", "5:5", "6:5", "a:b", "1:2:3", "1:", "5:6x"):
            self.refuse(2, f"--frames {text}: ", arguments=(*command, text))


if __name__ == "__main__":
    unittest.main()
