"""Times, numbers and sessions of FITS files in track, and shards by frame id. Times are compared with astropy's."""
import datetime
import fractions
import json
import os
import random
import unittest
import warnings

import erfa
import numpy
from astropy.io import fits
from astropy.time import Time
from program import SCENES
from test_track import FRAMES, GRID, SIDE, Track

DAY = 86400 * 10**9
SYSTEM = "/usr/share/zoneinfo/leap-seconds.list"
EPOCH = Time("1970-01-01T00:00:00", scale="tai", format="isot")


def tai_ns(text, scale, form):
    """By astropy, whose two doubles hold 0.01 ns."""
    with warnings.catch_warnings(action="ignore"):  # of years to come
        time = Time(text, scale=scale, format=form).tai
    days = fractions.Fraction(time.jd1) + fractions.Fraction(time.jd2)
    return round((days - fractions.Fraction(EPOCH.jd1) - fractions.Fraction(EPOCH.jd2)) * DAY)


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
    def test_dates_and_days(self):
        chance, cases, expected = random.Random(2), {}, {}

        def add(key, text, scale, exposure=None):
            name = f"n{len(cases)}"
            form = "mjd" if key[0] == "M" else "isot"
            whole = text if "T" in text or form == "mjd" else text + "T00:00:00"
            cases[name] = {key: text if form == "mjd" else f"'{text}'", "TIMESYS": f"'{scale}'"}
            by_astropy = {"TDT": "tt", "IAT": "tai", "TT(TAI)": "tt", "GPS": "tai"}.get(scale, scale.lower())
            expected[name] = tai_ns(whole.replace("D", "E"), by_astropy, form) + (19 * 10**9 if scale == "GPS" else 0)
            if exposure:
                cases[name]["XPOSURE" if key == "MJD-BEG" else "EXPTIME"] = exposure
                expected[name] += round(fractions.Fraction(exposure.replace("D", "E")) * 10**9 / 2)

        for scale in ("UTC", "TAI", "TT", "TDT", "IAT", "GPS", "tt(tai)".upper(), "Utc"):
            for _ in range(12):
                mjd = f"{chance.randint(41317, 69000)}.{chance.randint(0, 10**15 - 1):015d}"
                add(chance.choice(["MJD-AVG", "MJD-BEG", "MJD-OBS"]), mjd, scale, "0")
                second = f"{chance.randint(0, 59):02d}" + chance.choice(["", ".", ".5", f".{chance.randint(0, 999999):06d}"])
                add("DATE-AVG", f"20{chance.randint(10, 59)}-{chance.randint(1, 12):02d}-{chance.randint(1, 28):02d}"
                    f"T{chance.randint(0, 23):02d}:{chance.randint(0, 59):02d}:{second}", scale)
        for text in ("2024-02-29T00:00:00", "2000-02-29T00:00:00", "2029-12-31T23:59:59.999999999", "2030-01-01T00:00:00"):
            add("DATE-OBS", text, "UTC", "1.5")
        add("MJD-BEG", "6.0310250000000001D+04", "TT", "8.64D4")
        add("MJD-OBS", "60310", "TAI", "3600")
        add("MJD-OBS", "60310.", "UTC", "1E-9")
        add("DATE-AVG", "1958-01-01T00:00:00", "TAI")
        add("DATE-AVG", "2099-12-31T23:59:59.5", "TT")
        found = self.times(cases)
        for name, ns in found.items():
            self.assertLessEqual(abs(ns - expected[name]), 1, cases[name])  # of astropy's rounding
        exact = {name for name, ns in found.items() if ns == expected[name]}
        self.assertGreater(len(exact), 0.95 * len(found))

    def test_last_digit(self):
        """Days as text, not as a double, which would be 600 ns off."""
        cases, expected = {}, {}
        for k, text in enumerate(("60000.000000000000011574", "60000.123456789012345678", "60000.9999999999999",
                                  "60000.00000000000000578", "60000.00000000000000579", "600001234567890123456.7E-16",
                                  "+60000.5", "60000.99999999999999999999999999999999")):
            cases[f"n{k}"] = {"MJD-AVG": text, "TIMESYS": "'TAI'"}
            expected[f"n{k}"] = int((fractions.Fraction(text) - 40587) * DAY + fractions.Fraction(1, 2))
        self.assertEqual(self.times(cases), expected)

    def test_leap_seconds(self):
        """About each of them, by the table of ERFA."""
        cases, expected, ahead = {}, {}, {}
        for year, month, seconds in erfa.leap_seconds.get():
            ahead[datetime.date(year, month, 1)] = int(seconds)
        self.assertEqual(ahead.pop(datetime.date(1972, 1, 1)), 10)
        steps = [day for day in ahead if day.year > 1972 or day.month > 1]
        steps = [day for day in steps if day > datetime.date(1972, 1, 1)]
        self.assertEqual(len(steps), 27)
        for day in steps:
            last = day - datetime.timedelta(1)
            mjd = last.toordinal() - 678576
            start = tai_ns(f"{day}T00:00:00", "utc", "isot")
            self.assertEqual(start, (day.toordinal() - 719163) * DAY + ahead[day] * 10**9)
            for label, key, value, ns in (
                ("a", "DATE-AVG", f"'{last}T23:59:59'", start - 2 * 10**9),
                ("b", "DATE-AVG", f"'{last}T23:59:60'", start - 10**9),
                ("c", "DATE-AVG", f"'{last}T23:59:60.999999999'", start - 1),
                ("d", "DATE-AVG", f"'{day}T00:00:00'", start),
                ("e", "MJD-AVG", f"{mjd}.5", tai_ns(f"{mjd}.5", "utc", "mjd")),  # the day has 86,401 s
                ("f", "MJD-AVG", f"{mjd}.999999", tai_ns(f"{mjd}.999999", "utc", "mjd")),
                ("g", "MJD-AVG", f"{mjd + 1}", start),
            ):
                cases[f"{day}{label}"] = {key: value, "TIMESYS": "'UTC'"}
                expected[f"{day}{label}"] = ns
        cases["through"] = {"DATE-OBS": "'2016-12-31T23:59:59'", "EXPTIME": "4", "TIMESYS": "'UTC'"}
        expected["through"] = tai_ns("2017-01-01T00:00:00", "utc", "isot")  # 2 s on there is 1 s of the next year less
        found = self.times(cases)
        for name, ns in expected.items():
            self.assertLessEqual(abs(found[name] - ns), 1 if name[-1] in "ef" else 0, name)

    def test_keywords(self):
        """Any start with any length, as test_ingest_header in full; the exposure goes into the ledger."""
        day, clock, start = "'2028-03-01'", "'12:34:56'", tai_ns("2028-03-01T12:34:56", "utc", "isot")
        date, end = "'2028-03-01T12:34:56'", "'2028-03-01T13:34:56'"
        cases = (({"DATE-OBS": date, "XPOSURE": "3600.0"}, "DATE-OBS + XPOSURE/2 in UTC"),
                 ({"DATE-OBS": day, "TIME-OBS": clock, "EXPTIME": "3600"}, "DATE-OBS + TIME-OBS + EXPTIME/2 in UTC"),
                 ({"DATE-BEG": date, "EXPOSURE": "3600"}, "DATE-BEG + EXPOSURE/2 in UTC"),
                 ({"DATE-BEG": date, "DATE-END": end}, "the middle of DATE-BEG and DATE-END in UTC"),
                 ({"MJD-BEG": "61831.524259259259", "DATE-END": end, "TELAPSE": "3600", "XPOSURE": "1"}, "MJD-BEG + TELAPSE/2 in UTC"),
                 ({"DATE-OBS": date, "EXPTIME": "3600", "TIMESYS": "'UTC(NIST)'"}, "DATE-OBS + EXPTIME/2 in UTC"),
                 ({"DATE-OBS": "'2028-061 12:34:56Z'", "EXPTIME": "3600"}, "DATE-OBS + EXPTIME/2 in UTC"),
                 ({"DATE-OBS": "'2028-03-01T12:36:05.184'", "EXPTIME": "3600", "TIMESYS": "'TDB'"}, "DATE-OBS + EXPTIME/2 in TDB"))
        names = [self.write(f"k{k}.fits", {"TIMESYS": "'UTC'", **cards}) for k, (cards, _) in enumerate(cases)]
        frames, issued = self.read(names)
        for k, (cards, rule) in enumerate(cases):
            self.assertAlmostEqual(frames[f"k{k}"]["tai_ns"], start + 1800 * 10**9, delta=10**5, msg=cards)
            self.assertEqual(issued[f"k{k}.fits"]["text"], "time by " + rule)

    def test_without_timesys(self):
        name = self.write("x.fits", {"DATE-OBS": "'2017-01-01T00:00:00'", "EXPTIME": "0"})
        frames, issued = self.read([name], "--strict")
        self.assertEqual(frames["x"]["tai_ns"], tai_ns("2017-01-01T00:00:00", "utc", "isot"))
        self.assertEqual(issued[name]["text"], "time by DATE-OBS + EXPTIME/2 in UTC, as TIMESYS is missing")
        self.assertIn("toliman: warning: x.fits: time by", self.errors)

    def test_without_exposure(self):
        """Taken as mid-exposure, whatever --cadence says."""
        for k, (cards, text, at) in enumerate((
            ({"MJD-BEG": "60000"}, "MJD-BEG, taken as mid-exposure as its length is missing, in TAI", ("60000", "mjd")),
            ({"DATE-OBS": "'2029-05-05T00:00:00'"}, "DATE-OBS, taken as mid-exposure as its length is missing, in TAI",
             ("2029-05-05T00:00:00", "isot")),
            ({"DATE-OBS": "'2029-05-05T00:00:00'", "EXPTIME": "0"}, "DATE-OBS + EXPTIME/2 in TAI", ("2029-05-05T00:00:00", "isot")),
        )):
            for cadence in ((), ("--cadence", "60")):
                name = self.write(f"x{k}.fits", {**cards, "TIMESYS": "'TAI'"})
                frames, issued = self.read([name], *cadence, state=f"s{k}{len(cadence)}")
                self.assertEqual(frames[f"x{k}"]["tai_ns"], tai_ns(at[0], "tai", at[1]))
                self.assertEqual(issued[name]["text"], "time by " + text)
                self.assertEqual("toliman: warning: x" in self.errors, "mid-exposure" in text)
        nights = [self.write(f"n{k}.fits", {"MJD-OBS": str(60000 + 30 * k)}) for k in range(12)]
        frames, _ = self.read(nights, "--cadence", "60", state="nights")
        self.assertEqual([frames[f"n{k}"]["tai_ns"] - frames["n0"]["tai_ns"] for k in range(12)],
                         [30 * k * DAY for k in range(12)])

    def test_refused(self):
        good = {"TIMESYS": "'UTC'", "EXPTIME": "10", "XPOSURE": "10"}
        cases = [
            ({"MJD-AVG": "NaN"}, "MJD-AVG: text = \"NaN\""), ({"MJD-AVG": "'60000.5'"}, "Modified Julian Day"),
            ({"MJD-AVG": "60000,5"}, "MJD-AVG"), ({"MJD-AVG": "6E9999"}, "MJD-AVG"), ({"MJD-AVG": "-1"}, "MJD-AVG"),
            ({"MJD-AVG": "2460000.5"}, "to 2099-12-31"), ({"MJD-AVG": "41316.99"}, "1972-01-01"),
            ({"MJD-AVG": "1E-30"}, "1972-01-01"), ({"MJD-AVG": "60000.5E"}, "MJD-AVG"), ({"MJD-AVG": "."}, "MJD-AVG"),
            ({"DATE-AVG": "'1971-12-31T23:59:59'"}, "1972-01-01"), ({"DATE-AVG": "'1971-12-31T23:59:60'"}, "1972-01-01"),
            ({"DATE-AVG": "'2017-12-31T23:59:60'"}, "no such second"), ({"DATE-AVG": "'2016-12-31T22:59:60'"}, "YYYY"),
            ({"DATE-AVG": "'2016-12-31T23:59:60'", "TIMESYS": "'TAI'"}, "no such second"),
            ({"DATE-AVG": "'2016-12-31T23:59:61'"}, "YYYY"), ({"DATE-AVG": "'2029-02-29'"}, "YYYY-MM-DD"),
            ({"DATE-AVG": "'1900-02-29'"}, "YYYY-MM-DD"), ({"DATE-AVG": "'2029-13-01'"}, "YYYY-MM-DD"),
            ({"DATE-AVG": "'31/12/99'"}, "YYYY-MM-DD"), ({"DATE-AVG": "'2029-01-01T24:00:00'"}, "YYYY"),
            ({"DATE-AVG": "'2029-01-01T12:00'"}, "YYYY"), ({"DATE-AVG": "'2029-01-01T12:00:00Z'", "TIMESYS": "'TAI'"}, "YYYY"),
            ({"DATE-AVG": "'2029-01-01T12:00:00+01:00'"}, "is +01:00 from UTC"), ({"DATE-AVG": "'2029-01-01'"}, "date without a time"),
            ({"DATE-AVG": "'2029-01-01T12:00:00'", "MJD-OBS": "62502"}, "DATE-AVG contradicts MJD-OBS"),
            ({"DATE-AVG": "'2029-01-01T12:00:00.1.2'"}, "YYYY"), ({"DATE-AVG": "'2029-01-01  12:00:00'"}, "YYYY"),
            ({"DATE-AVG": "'1957-12-31T23:59:59'", "TIMESYS": "'TT'"}, "1958-01-01"),
            ({"DATE-AVG": "'2100-01-01'", "TIMESYS": "'TAI'"}, "2099-12-31"), ({"DATE-AVG": "2029"}, "YYYY"),
            ({"MJD-BEG": "60000", "XPOSURE": "NaN"}, "XPOSURE = NaN: must be from 0 to 1e9 s"),
            ({"MJD-BEG": "60000", "XPOSURE": "-1"}, "XPOSURE = -1"), ({"MJD-OBS": "60000", "EXPTIME": "1e10"}, "EXPTIME"),
            ({"MJD-AVG": "60000", "TIMESYS": "'TCB'"}, "TIMESYS = 'TCB"), ({"MJD-AVG": "60000", "TIMESYS": "5"}, "TIMESYS"),
            ({}, "tells no time: needs --cadence"), ({"FRAME1": "1.5", "MJD-AVG": "60000"}, "FRAME1"),
            ({"FRAME1": "9223372036854775807", "MJD-AVG": "60000"}, "FRAME1"),
        ]
        names = [self.write(f"x{k}.fits", {**good, **cards}) for k, (cards, _) in enumerate(cases)]
        frames, issued = self.read(names)
        self.assertEqual(frames, {})
        for name, (cards, text) in zip(names, cases):
            self.assertEqual(issued[name]["warning"], "unreadable input", cards)
            self.assertIn(text, issued[name]["text"])
            self.assertEqual(self.errors.count(name + ":"), name in names[:10], self.errors)
        self.assertEqual(self.errors.count("\n"), 10 + 3)  # their number, no folder is left, leap seconds
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
            self.assertEqual(frames[name]["tai_ns"], tai_ns("60000.5", "tai", "mjd") + 10**9)
            self.assertEqual(frames[name]["frame_id"], 7)
            self.assertEqual(frames[name]["verdict"], "accepted")

    def test_table_of_leap_seconds(self):
        ntp = lambda day: (day - datetime.date(1900, 1, 1)).days * 86400
        table = [(datetime.date(year, month, 1), int(seconds)) for year, month, seconds in erfa.leap_seconds.get()
                 if year >= 1972]
        more = f"# leap seconds\n#@\t{ntp(datetime.date(2040, 1, 1))}\n#\n"
        more += "".join(f"{ntp(day)}\t{seconds}\t# {day}\n" for day, seconds in table)
        more += f"{ntp(datetime.date(2030, 1, 1))} 36\n"  # the first negative one
        (self.folder / "own.list").write_text(more)
        cases = {"a": {"DATE-AVG": "'2029-12-31T23:59:58'"}, "b": {"DATE-AVG": "'2030-01-01T00:00:00'"}}
        cases = {name: {**cards, "TIMESYS": "'UTC'"} for name, cards in cases.items()}
        built_in = self.times(cases)
        self.assertEqual(built_in["b"] - built_in["a"], 2 * 10**9)
        with warnings.catch_warnings(record=True) as raised:
            warnings.simplefilter("always")
            end = next(year for year in range(2017, 2099) if erfa.dat(year, 1, 1, 0) and raised)  # the first dubious year
        self.assertEqual(self.errors.count(f"leap seconds are known only before {end}-01-01"), 1)
        names = [f"{name}.fits" for name in cases]
        frames, _ = self.read(names, "--leap-seconds", "own.list", state="own")
        self.assertEqual(frames["b"]["tai_ns"], frames["a"]["tai_ns"] + 10**9)
        self.assertNotIn("are known", self.errors)
        self.read([self.write("no.fits", {"DATE-AVG": "'2029-12-31T23:59:59'", "TIMESYS": "'UTC'"})],
                  "--leap-seconds", "own.list", "--strict", code=4)
        self.assertIn("no such second", self.errors)
        command = ("track", "--state", "t", "--template", "scene.json", *GRID, "a.fits", "--leap-seconds")
        for text, why in (("", "is empty"), (more.replace("2303683200", "2303683201"), "bad:6"),
                          (more.replace("3124137600	32", "3124137600	31"), "bad:26"), (more.replace("#@", "# "), "expiry"),
                          (more.replace("2272060800	10", "2272060800	9"), "1972-01-01"), ("x\n", "bad:1")):
            (self.folder / "bad").write_text(text)
            self.refuse(3, why, arguments=(*command, "bad"))
        self.refuse(3, "none", arguments=(*command, "none"))

    @unittest.skipUnless(os.path.exists(SYSTEM), "the system has no such table")
    def test_table_of_the_system(self):
        name = self.write("x.fits", {"DATE-AVG": "'2017-01-01T00:00:00'", "TIMESYS": "'UTC'"})
        frames, _ = self.read([name], "--leap-seconds", SYSTEM)
        self.assertEqual(frames["x"]["tai_ns"], tai_ns("2017-01-01T00:00:00", "utc", "isot"))


class Files(Fits):
    def test_cubes(self):
        """Frame 0 has the header's time; the others follow the table FRAMES, or --cadence."""
        start = tai_ns("2029-01-01T00:00:00", "utc", "isot")
        keys = {"DATE-AVG": "'2029-01-01T00:00:00'", "TIMESYS": "'UTC'"}
        images = self.frames.astype("i4")
        self.write("cube.fits", keys, images)
        out = [line for line in self.track("s", "cube.fits", "--cadence", "43200.5") if "value" in line]
        self.assertEqual([line["tai_ns"] for line in out], [start + k * 43200500000000 for k in range(FRAMES)])
        self.assertIn("time by DATE-AVG in UTC, from there on by --cadence", self.errors)
        self.track("t", "cube.fits", "--strict", code=4)
        self.assertIn("needs --cadence", self.errors)
        with fits.open(self.folder / "cube.fits") as cube:
            days = numpy.arange(FRAMES) * 1.25 - 3
            table = fits.BinTableHDU.from_columns([fits.Column("time_days", "D", array=days)], name="FRAMES")
            fits.HDUList([cube[0], table]).writeto(self.folder / "both.fits")
            fits.HDUList([cube[0], fits.BinTableHDU(table.data[:5], name="FRAMES")]).writeto(self.folder / "few.fits")
        for cadence in ((), ("--cadence", "5")):  # what the file says goes before
            out = [line for line in self.track(f"u{len(cadence)}", "both.fits", *cadence) if "value" in line]
            self.assertEqual([line["tai_ns"] for line in out], [start + k * DAY * 5 // 4 for k in range(FRAMES)])
        self.assertIn("from there on by its table FRAMES", self.errors)
        self.track("v", "few.fits", "--strict", code=4)
        self.assertIn("5 rows: must have 48", self.errors)

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
            self.assertIn("c2.fits: time by FRAME1 and --cadence, by the camera's clock", self.errors)
        before = self.write("before.fits", {"FRAME1": "-3"}, self.frames[:2])
        out = self.track("before", before, "--cadence", "2")
        self.assertEqual([line["camera_ns"] for line in out if "value" in line], [-6 * 10**9, -4 * 10**9])
        far = self.write("far.fits", {"FRAME1": str(2**62)})
        self.track("far", far, "--cadence", "2", "--strict", code=4)
        self.assertIn("is more than 4e9 s from frame 0", self.errors)

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
            self.assertIn(f"its times by --cadence overlap those of {names[0]}: FRAME1 or a time", told[names[1]])
            self.assertEqual(self.errors.count("warning: "), 2, self.errors)
        self.track("apart", "t0.fits", "t1.fits", "t2.fits", "--cadence", "3600")
        self.assertNotIn("warning", self.errors)

    def test_cubes_of_simulate(self):
        """The table gives what the pair of files gives: numbers, camera's time, bits."""
        for name in ("whole", "part"):
            some = ("--frames", "5:30") if name == "part" else ()
            self.succeed("simulate", "scene.json", "--out", f"{name}.fits", *some)
            out = [line for line in self.track(name, f"{name}.fits") if "value" in line]
            self.assertIn("time by its table FRAMES, by the camera's clock", self.errors)
            first, end = (5, 30) if name == "part" else (0, FRAMES)
            self.assertEqual(self.sums(name), self.clean(range(first, end), f"pairs_{name}"))
            lines = [json.loads(line) for line in self.lines[first:end]]
            self.assertEqual([(line["frame_id"], line["camera_ns"]) for line in out],
                             [(line["frame_id"], line["timestamp_ns"]) for line in lines])

    def test_single_images(self):
        """An image a file with a date each, in any order: the period of the pair."""
        start = tai_ns("2029-01-01T00:00:00", "utc", "isot")
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
        self.assertIn("no key FRAME1", issued[bare[1]]["text"])

    def test_clock(self):
        """A time that is TAI is not converted by a clock table."""
        (self.folder / "clock.csv").write_text("0,1000\n")
        (self.folder / "same.csv").write_text("0,0\n5,5\n")
        self.write("x.fits", {"MJD-AVG": "60000", "TIMESYS": "'TAI'"})
        self.track("s", "x.fits", "--clock", "clock.csv", code=2)
        self.assertIn("x.fits: its time (MJD-AVG in TAI) is TAI, but the state folder has a clock table", self.errors)
        self.assertFalse((self.folder / "s").exists())  # as it has no frame
        self.succeed("simulate", "scene.json", "--out", "day.fits")
        out = self.track("s", "day.fits", "--clock", "clock.csv")  # the camera's time
        self.assertTrue(all(line["tai_ns"] == line["camera_ns"] + 1000 for line in out if "value" in line))
        self.track("s", "-", code=2, stdin="x.fits")  # the clock is remembered
        self.assertIn("the state folder has a clock table", self.errors)
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
        self.assertIn("ends before", self.errors)

    def test_refused(self):
        command = ("track", "--state", "s", "--template", "scene.json", "--dtype", "u32le", *GRID, "all", "--frames")
        for text in ("5", "5:5", "6:5", "a:b", "1:2:3", "1:", "5:6x"):
            self.refuse(2, f"--frames {text}: must be A:B", arguments=(*command, text))


if __name__ == "__main__":
    unittest.main()
