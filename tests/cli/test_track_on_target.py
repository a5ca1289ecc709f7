"""On-target intervals in track: those of the side file, and --on-target. The ledger's columns of exposure and mean time
are compared with plain loops over fractions."""
import fractions
import json
import struct
import unittest

from program import HEADER, LINE, leap_seconds
from test_track import FRAMES
from test_track_stamps import DAY, EXPOSURE, GRID, HALF, Exposed

SECOND = 10**9
OWN = [0, 9000.25, 20000, 30000, 30000.5, 43200]  # of every exposure


class OnTarget(Exposed):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.plain = cls.scene
        scene = json.loads(cls.scene)
        scene["cadence"]["on_target_s"] = OWN
        cls.scene = json.dumps(scene)

    def columns(self, state):
        """Exposure and mean on-target time, in s after the middle of the exposure, by frame."""
        data = (self.folder / state / "ledger.tlml").read_bytes()
        records = [data[at:at + LINE] for at in range(HEADER, len(data), LINE)]
        return {struct.unpack_from("<q", record, 12)[0]: struct.unpack_from("<dd", record, 64)
                for record in records if record[52] in (1, 2)}

    def follow(self, state, *more, inputs=("all",), code=0):
        out = self.track(state, *more, *inputs, grid=GRID, code=code)
        return {line["frame_id"]: line for line in out if line["schema"] == "toliman-frame/2"}

    def without_intervals(self):
        """The same frames, their lines with the mission's eight keys."""
        lines = [json.loads(line) for line in self.lines]
        for line in lines:
            del line["on_target_s"]
        self.pair("bare/x", [json.dumps(line) for line in lines], self.frames)
        return ("bare",)

    def put(self, windows, name="w.csv"):
        (self.folder / name).write_text("start_tai_ns,end_tai_ns\n" + "".join(f"{a},{b}\n" for a, b in windows))
        return ("--on-target", name)

    def check(self, columns, windows, own=((0, EXPOSURE),)):
        """windows: camera time in ns."""
        for k, (exposure, mean) in columns.items():
            start, length, moment = k * DAY - HALF, 0, 0
            for a, b in own:
                for c, d in windows:
                    first = max(fractions.Fraction(a), fractions.Fraction(c - start, SECOND))
                    last = min(fractions.Fraction(b), fractions.Fraction(d - start, SECOND))
                    if first < last:
                        length += last - first
                        moment += (last - first) * (first + last) / 2
            self.assertEqual(exposure, EXPOSURE)
            self.assertAlmostEqual(mean, float(moment / length - fractions.Fraction(EXPOSURE, 2)), delta=1e-9, msg=k)


OWN_PAIRS = list(zip(OWN[::2], OWN[1::2]))
ALL = [(-100 * DAY, 100 * DAY)]


class SideFile(OnTarget):
    def test_a_pair_has_the_intervals_of_its_scene(self):
        for line in map(json.loads, self.lines):
            self.assertEqual(line["on_target_s"], OWN)
            self.assertEqual(len(line), 10)
        self.follow("s")
        self.assertEqual(self.errors, "")
        columns = self.columns("s")
        self.assertEqual(len(columns), FRAMES)
        self.check(columns, ALL, OWN_PAIRS)
        (self.folder / "plain.json").write_text(self.plain)
        self.succeed("simulate", "plain.json", "--out", "plain", "--session", "day", "--dtype", "u32le")
        line = json.loads((self.folder / "plain/day_meta.jsonl").read_text().splitlines()[0])
        self.assertEqual(sorted(line), sorted(key for key in json.loads(self.lines[0]) if key != "on_target_s"))

    def test_too_many_intervals_for_a_line(self):
        scene = json.loads(self.scene)
        scene["cadence"]["on_target_s"] = list(range(130))
        (self.folder / "many.json").write_text(json.dumps(scene))
        self.refuse(2, "many.json: cadence ", "--session",
                    arguments=("simulate", "many.json", "--out", "many", "--session", "day", "--dtype", "u32le"))


class Windows(OnTarget):
    def windows(self):
        """Some of every kind, in ns of camera time: several in an exposure, across its ends, one for several frames, none
        for frame 4."""
        windows = [(-3 * DAY, -2 * DAY), (-HALF + 1000 * SECOND, HALF - 2000 * SECOND)]
        for k in range(1, 20):
            middle = k * DAY
            windows += {0: [(middle - HALF - 5, middle + 7), (middle + 8, middle + HALF + 5 * SECOND)],
                        1: [(middle - 30000 * SECOND, middle - 20000 * SECOND), (middle - 20000 * SECOND, middle + 1)],
                        2: [(middle + 20000 * SECOND + 123456789, middle + 30000 * SECOND)]}[k % 3] if k != 4 else []
        return windows + [(20 * DAY - HALF, 23 * DAY), (24 * DAY - HALF, 60 * DAY)]

    def test_windows(self):
        windows, bare = self.windows(), self.without_intervals()
        given = self.put(windows)
        lines = self.follow("s", *given, "--strict", inputs=bare, code=4)
        off = lines.pop(4)
        self.assertEqual((off["verdict"], off["reason"], off["camera_ns"], off["value"], off["input"]),
                         ("rejected", "off target", 4 * DAY, None, "bare/x_meta.jsonl:5"))
        self.assertEqual(self.errors.splitlines()[0].partition(": ")[2].partition(" ")[0], "--on-target:")
        self.assertIn(f"warning: bare/x_meta.jsonl:5: rejected: off target: no window of w.csv contains on-target time of frame 4, "
                      f"exposed from {4 * DAY - HALF} to {4 * DAY + HALF} ns", self.errors)
        self.assertEqual({line["verdict"] for line in lines.values()}, {"accepted"})
        columns = self.columns("s")
        self.assertEqual(sorted(columns), [k for k in range(FRAMES) if k != 4])
        self.check(columns, windows)
        again = self.follow("s", *given, inputs=bare)
        self.assertEqual({line["verdict"] for k, line in again.items() if k != 4}, {"duplicate"})
        batch = self.follow("batch", *given, "--jobs", "3", "--every", "10", inputs=bare)
        self.assertEqual(batch[4]["reason"], "off target")
        self.assertEqual(self.columns("batch"), columns)
        self.assertEqual(self.sums("batch"), self.sums("s"))
        other = self.follow("s", inputs=bare)  # the whole exposure is other content
        self.assertEqual(other[5]["verdict"], "quarantined")

    def test_frames_with_intervals_of_their_own(self):
        windows = self.windows()
        lines = self.follow("s", *self.put(windows))
        self.assertEqual(lines[4]["reason"], "off target")
        self.check(self.columns("s"), windows, OWN_PAIRS)
        between = [(k * DAY - HALF + 9001 * SECOND, k * DAY - HALF + 20000 * SECOND) for k in range(FRAMES)]
        lines = self.follow("none", *self.put(between), "--strict", code=4)  # on target by one of the two only
        self.assertEqual({line["reason"] for line in lines.values()}, {"off target"})

    def test_windows_are_tai(self):
        """TAI of the camera's time is 10^9 ns + 1.005 of it up to 10 days, and then 0.995."""
        bare, knee = self.without_intervals(), 10 * DAY
        table = [(0, SECOND), (knee, SECOND + knee * 1005 // 1000), (knee + 1000, SECOND + knee * 1005 // 1000 + 995)]
        (self.folder / "clock.csv").write_text("".join(f"{a},{b}\n" for a, b in table))

        def tai(camera):
            return SECOND + camera * 1005 // 1000 if camera < knee else table[1][1] + (camera - knee) * 995 // 1000
        windows = [(200 * (a // 200), 200 * (b // 200)) for a, b in self.windows()]
        lines = self.follow("s", "--clock", "clock.csv", *self.put([(tai(a), tai(b)) for a, b in windows]), inputs=bare)
        self.assertEqual((lines[4]["reason"], lines[12]["tai_ns"]), ("off target", tai(12 * DAY)))
        self.check(self.columns("s"), windows)

    def test_times_are_rounded_down(self):
        """Camera time is 2/3 of TAI: exact to the nanosecond, also before time 0 and between two of them."""
        bare = self.without_intervals()
        (self.folder / "clock.csv").write_text(f"{-40 * DAY},{-60 * DAY}\n{60 * DAY},{90 * DAY}\n")
        windows = [(camera * 3 // 2 + 1, (camera + 10**9) * 3 // 2 + 2) for camera in range(-6, 10**13, 10**12)]
        lines = self.follow("s", "--clock", "clock.csv", *self.put(windows), inputs=bare)
        self.assertEqual(lines[0]["verdict"], "accepted")
        columns = self.columns("s")
        self.assertEqual(list(columns), [0])
        inside = [(max(2 * a // 3, -HALF), min(2 * b // 3, HALF)) for a, b in windows]
        length = sum(b - a for a, b in inside)
        mean = fractions.Fraction(sum((b - a) * (a + b) for a, b in inside), 2 * length * SECOND)
        self.assertAlmostEqual(columns[0][1], float(mean), delta=1e-11)

    def test_a_table_that_does_not_cover_an_exposure(self):
        bare = self.without_intervals()
        for name, windows, text in (("begins", [(5 * DAY, 60 * DAY)], "frame 5 "), ("ends", [(-DAY, 7 * DAY + 1)], "frame 7 "),
                                    ("gaps", self.windows(), None),
                                    # The last exposure ends after its arc, as all others do.
                                    ("arcs", [(k * DAY - HALF // 2, k * DAY + HALF // 2) for k in range(-1, FRAMES)], None)):
            self.follow(name, *self.put(windows), inputs=bare)
            warnings = [line for line in self.errors.splitlines() if f"w.csv: {name} in the exposure" in line]
            self.assertEqual([text in line for line in warnings], [True] if text else [])

    def test_an_exposure_at_the_end_of_the_range(self):
        """Its start is beyond 64 bits."""
        line = json.loads(self.lines[0])
        del line["on_target_s"]
        line["timestamp_ns"] = -2**63
        self.pair("far/x", [json.dumps(line)], self.frames[:1])
        lines = self.follow("s", "--stamp", "middle", "--exposure", "43200", *self.put([(0, DAY)]), inputs=("far",))
        self.assertEqual(lines[0]["reason"], "off target")
        self.assertIn(f"from {-2**63} to {HALF - 2**63} ns", self.errors)

    def test_windows_in_utc(self):
        """About a further leap second at the end of 2027-05-31, MJD 61556; tests/unit/test_ingest_on_target.c has the scales."""
        bare = self.without_intervals()
        (self.folder / "list").write_text(leap_seconds(61557))
        (self.folder / "clock.csv").write_text(f"0,{(61557 - 40587) * DAY - 13 * DAY + 37 * SECOND}\n")
        (self.folder / "w.csv").write_text("start_utc,end_utc\n2027-05-31T23:59:30,2027-151 23:59:60.5+00:00\n")
        self.follow("s", "--clock", "clock.csv", "--on-target", "w.csv", "--leap-seconds", "list", inputs=bare)
        columns = self.columns("s")
        self.assertEqual(list(columns), [13])  # at 0 h minus the leap second
        self.check(columns, [(13 * DAY - 30 * SECOND, 13 * DAY + SECOND // 2)])

    def test_fits_frames_have_the_exposure_of_the_folder(self):
        self.succeed("simulate", "scene.json", "--out", "day.fits")
        windows = self.windows()
        lines = self.follow("s", *self.put(windows), "--exposure", "43200", inputs=("day.fits",))
        self.assertEqual((lines[4]["reason"], lines[4]["input"]), ("off target", "day.fits:4"))
        self.check(self.columns("s"), windows)

    def test_mistakes(self):
        """tests/unit/test_ingest_on_target.c has the tables."""
        command = ("track", "--template", "scene.json", "--state", "s", "--dtype", "u32le", *GRID, "all")
        self.refuse(3, "w.csv: ", arguments=(*command, "--on-target", "w.csv"))
        self.put([(5, 6), (6, 6)])
        self.refuse(3, "w.csv:3: end_tai_ns = 6: ", arguments=(*command, "--on-target", "w.csv"))
        self.put([(5, 6)])
        self.follow("s", "--on-target", "w.csv", "--exposure", "0", code=2)
        self.assertIn("--exposure SECONDS", self.errors)
        self.assertFalse((self.folder / "s").exists())


if __name__ == "__main__":
    unittest.main()
