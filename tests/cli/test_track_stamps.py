"""track: raw pairs whose time stamps are the start, middle or end of the exposure."""
import json
import unittest

from test_track import FRAMES, Track

GRID = ("--grid", "0.03:0.002:230")
EXPOSURE = 43200
HALF = EXPOSURE * 10**9 // 2
DAY = 86400 * 10**9
NOTE = r"x_meta\.jsonl:1: .* the %s of the exposure: --exposure SECONDS .*\n"


class Stamps(Track):
    def setUp(self):
        super().setUp()
        self.stamps = [json.loads(line)["timestamp_ns"] for line in self.lines]
        self.pair("in/x", self.lines, self.frames)

    def times(self, state, *more, inputs="in", code=0):
        out = self.track(state, *more, inputs, grid=GRID, code=code)
        if code == 0:
            self.last = self.counts(out)
        return [line["camera_ns"] for line in out if line["schema"] == "toliman-frame/2"]

    def test_a_pair_is_stamped_at_the_start(self):
        for number, (more, shift, stamp, exposure) in enumerate((
            ((), 0, "start", None), (("--exposure", "43200"), HALF, "start", EXPOSURE),
            (("--stamp", "end", "--exposure", "43200"), -HALF, "end", EXPOSURE), (("--stamp", "end"), 0, "end", None),
            (("--stamp", "middle", "--exposure", "43200"), 0, "middle", EXPOSURE), (("--exposure", "3e-9"), 2, "start", 3e-9),
        )):
            state = f"s{number}"
            self.assertEqual(self.times(state, *more), [ns + shift for ns in self.stamps], more)
            status = json.loads(self.succeed("status", state, "--json"))
            for line in (self.last, status):
                self.assertEqual((line["stamp"], line["exposure_s"]), (stamp, exposure))
            noted = exposure is None and stamp != "middle"
            self.assertRegex(self.errors, f"^toliman: in/{NOTE % stamp}$" if noted else "^$")
            if number == 2:  # the folder keeps both
                self.assertEqual(self.times(state), self.times(state, *more))
                self.assertEqual(self.errors, "")
        self.assertRegex(self.succeed("status", "s1"), "exposures   43200 s, .* start")
        self.assertRegex(self.succeed("status", "s0"), "exposures   .* start")

    def test_another_stamp_or_exposure_is_refused(self):
        self.times("s", "--exposure", "43200")
        before = (self.folder / "s/ledger.tlml").read_bytes()
        for more in (("--stamp", "end"), ("--exposure", "43201"), ("--stamp", "middle", "--exposure", "43200")):
            self.times("s", *more, code=2)
            self.assertRegex(self.errors, "s/setup.tlms: .* start .* 43200 s.*--stamp and --exposure")
        self.refuse(2, "start", arguments=("rebuild", "s", "--stamp", "end"))
        self.assertEqual((self.folder / "s/ledger.tlml").read_bytes(), before)
        self.times("t", "--stamp", "middle")
        self.refuse(3, "middle", arguments=("merge", "s", "t", "--out", "no"))
        self.run_program("merge", "s", "--salvage", "--out", "copy")
        self.assertEqual(json.loads(self.succeed("status", "copy", "--json"))["exposure_s"], EXPOSURE)
        for option, value in (("--stamp", "begin"), ("--exposure", "-1"), ("--exposure", "2e9"), ("--exposure", "nan")):
            self.times("u", option, value, code=2)
            self.assertIn(option, self.errors)

    def test_other_files_have_the_middle_by_their_own_rules(self):
        self.succeed("simulate", "scene.json", "--out", "day.fits")
        done = self.run_program("track", "--template", "scene.json", "--state", "s", *GRID, "day.fits")
        self.assertEqual(done.returncode, 0, done.stderr)
        last = self.counts([json.loads(line) for line in done.stdout.splitlines()])
        self.assertEqual((last["stamp"], last["exposure_s"]), ("middle", None))
        self.assertNotIn("--exposure", done.stderr)
        self.times("s")  # the folder remains as it is
        self.assertEqual((self.last["stamp"], self.last["repeated"]), ("middle", FRAMES))
        out = self.track("t", "day.fits", "--exposure", "43200", grid=GRID)
        self.assertEqual([line["camera_ns"] for line in out if "value" in line], self.stamps)


class Exposed(Track):
    """Pairs of a scene with an exposure."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        scene = json.loads(cls.scene)
        for star in scene["stars"].values():
            star.pop("relative_flux", None)
            star["photons_per_s"] = 1e7
        del scene["cadence"]["peak_photons"]
        scene["cadence"]["exposure_s"] = EXPOSURE
        cls.scene = json.dumps(scene)


class Simulated(Exposed):
    def test_start_of_each_exposure(self):
        """The file has the start, the scene the length: the times are those of the cadence again."""
        lines = [json.loads(line) for line in self.lines]
        self.assertEqual([line["timestamp_ns"] for line in lines], [k * DAY - HALF for k in range(FRAMES)])
        self.assertEqual([line["host_time"] for line in lines], [k * 86400 - EXPOSURE / 2 for k in range(FRAMES)])
        out = self.track("s", "all", grid=GRID)
        self.assertEqual((self.errors, self.counts(out)["exposure_s"]), ("", EXPOSURE))
        self.assertEqual([line["tai_ns"] for line in out if "value" in line], [k * DAY for k in range(FRAMES)])
        self.succeed("simulate", "scene.json", "--out", "day.fits")
        self.track("cube", "day.fits", grid=GRID)
        self.assertEqual(self.sums("cube"), self.sums("s"))
        other = self.track("t", "all", "--exposure", "10", grid=GRID)  # takes precedence
        self.assertEqual([line["tai_ns"] for line in other if "value" in line],
                         [k * DAY - HALF + 5 * 10**9 for k in range(FRAMES)])


if __name__ == "__main__":
    unittest.main()
