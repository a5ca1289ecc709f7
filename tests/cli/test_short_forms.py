"""Commands without the options that the files answer: the pixel type of pairs, the days and the bit depth of a new state folder,
the name of the fitted scene."""
import json
import unittest

import numpy
from test_calibrate import SCENE as SKY
from test_mission_files import MissionTest, toliman

CODES = {"u16le": "<u2", "u32le": "<u4"}
ENCODE = ("encode", "--template", "mini.json")


class PixelTypes(MissionTest):
    def setUp(self):
        super().setUp()
        self.scene("mini.json", 3000)

    def scene(self, name, peak, **detector):
        scene = json.loads((self.folder / "mini.json").read_text())
        scene["cadence"]["peak_photons"] = peak
        scene["detector"].update(detector)
        (self.folder / name).write_text(json.dumps(scene))

    def counts(self, name="mini.json"):
        return toliman.Simulator(self.folder / name).frames().astype(int)

    def write(self, kind, **columns):
        """A pair of this type."""
        self.pair("obs", self.counts().astype(CODES[kind]), **columns)

    def values(self, *arguments):
        return [float(line.split(",")[2]) for line in self.succeed(*ENCODE, "obs_meta.jsonl", *arguments).splitlines()[1:]]

    def test_every_command_finds_it(self):
        """With the key dtype and without; the values are those of the type given."""
        for dtype in CODES:
            for keys in ({}, {"dtype": [dtype] * 12}):
                with self.subTest(dtype, keys=bool(keys)):
                    self.write(dtype, **keys)
                    expected = self.values("--dtype", dtype)
                    self.assertEqual(self.values(), expected)
                    lines, said = self.track("obs_meta.jsonl")
                    self.assertNotIn("dtype", said)
                    self.assertEqual([line["value"] for line in lines], expected)

    def test_contradictions(self):
        self.write("u32le", dtype=["u32le"] * 12)
        self.refuse(3, "obs_meta.jsonl: ", "u32le", "u16le", "(--dtype)\n",
                    arguments=(*ENCODE, "--dtype", "u16le", "obs_meta.jsonl"))
        self.refuse(2, "--dtype u16be: ", arguments=(*ENCODE, "--dtype", "u16be", "obs_meta.jsonl"))
        lines, said = self.track("obs_meta.jsonl", "--dtype", "u16le")
        self.assertEqual(lines, [])
        self.assertIn("warning: obs_meta.jsonl: ", said)
        self.write("u32le", dtype=["u32le"] * 6 + ["u16le"] + ["u32le"] * 5)
        lines, said = self.track("obs_meta.jsonl")
        self.assertEqual([line["frame_id"] for line in lines if line["verdict"] == "accepted"], [k for k in range(12) if k != 6])
        self.assertIn("obs_meta.jsonl:7: rejected: bad line: dtype ", said)

    def test_the_folder_takes_the_depth_of_the_first_pair(self):
        """A pair of the other type is not read, unless --bit-depth says that it is right; names come in their order."""
        small = self.counts()
        for first, other, depth in (("u16le", "u32le", 12), ("u32le", "u16le", 32)):
            with self.subTest(first):
                state, folder = f"of-{first}", self.folder / first
                folder.mkdir()
                for name, dtype in (("b", other), ("a", first)):
                    self.pair(f"{first}/{name}", small.astype(CODES[dtype]), session=name)
                lines, said = self.track(first, state=state)
                self.assertEqual([line["session"] for line in lines], ["a"] * 12)
                self.assertIn(f"b_meta.jsonl: ", said)
                self.assertIn(f"--bit-depth {depth}", said)
                lines, said = self.track(first, "--bit-depth", depth, state=state)
                self.assertEqual([(line["session"], line["verdict"]) for line in lines],
                                 [("a", "duplicate")] * 12 + [("b", "accepted")] * 12)

    def test_the_depth_of_the_scene(self):
        """Frames of 14 bits are not above those of a folder of 12 bits."""
        self.scene("deep.json", 12000, bit_depth=14)
        self.pair("obs", self.counts("deep.json").astype("<u2"))
        deep, _ = self.track("obs_meta.jsonl", template=("--template", "deep.json"))
        self.assertEqual({line["verdict"] for line in deep}, {"accepted"})
        shallow, _ = self.track("obs_meta.jsonl")
        self.assertEqual({line["verdict"] for line in shallow}, {"rejected"})

    def test_names_on_standard_input(self):
        """The bit depth of a new folder must then be given."""
        self.write("u32le")
        track = ("track", "--template", "mini.json", "--mission-days", "100", "--state")
        done = self.run_program(*track, "s", "-", input="obs_meta.jsonl\n")
        self.assertIn("--dtype", done.stderr)
        for more in (("--dtype", "u32le"), ()):  # the second time the folder is there
            done = self.run_program(*track, "s", *more, "-", input="obs_meta.jsonl\n")
            self.assertEqual(done.stdout.count('"verdict"'), 12, done.stderr)


class ScenesSay(MissionTest):
    def test_days(self):
        """Of the cadence; of times_days from the first to the last; never below 4. Only without a scene they are required."""
        scene = json.loads((self.folder / "mini.json").read_text())
        frames = self.frames()
        self.pair("obs", frames)
        for days, cadence in ((36, {"frames": 12, "interval_days": 3}), (4, {"frames": 2, "interval_days": 1}),
                              (90, {"times_days": [10, 20, 100]})):
            name = f"d{days}.json"
            kept = {key: value for key, value in scene["cadence"].items() if key not in ("frames", "interval_days")}
            (self.folder / name).write_text(json.dumps({**scene, "cadence": {**kept, **cadence}}))
            grids = []
            for more in ((), ("--mission-days", days)):
                state = f"{days}-{len(more)}"
                done = self.run_program("track", "--template", name, "--state", state, *more, "obs_meta.jsonl")
                self.assertEqual(done.returncode, 0, done.stderr)
                self.assertEqual(done.stderr.count(f"--mission-days {days}: the cadence of {name}"), 0 if more else 1, done.stderr)
                self.assertEqual("2 days" in done.stderr, days == 4 and not more)
                grids.append([line for line in self.succeed("status", state).splitlines() if "  grid  " in line])
                self.assertEqual(len(grids[-1]), 1)
            self.assertEqual(*grids)


class Order(MissionTest):
    def test_late_frames_are_no_jump_of_the_clock(self):
        """Each is as late as it was sent: its id, stamp and host time go back together."""
        order = numpy.random.default_rng(3).permutation(12)
        self.pair("obs", self.frames()[order], frame_id=order.tolist(), timestamp_ns=[int(k) * 86400 * 10**9 for k in order],
                  host_time=[86400.0 * k for k in order])
        lines, said = self.track("obs_meta.jsonl")
        self.assertEqual([(line["frame_id"], line["verdict"]) for line in lines], [(k, "accepted") for k in order])
        self.assertNotIn("warning", said)


class ThreeLines(MissionTest):
    def test_calibrate_track_planet(self):
        """With no more options than the three lines of the guide."""
        sky = json.loads(json.dumps(SKY))
        sky["binary"]["observer"] = {"altitude_km": 600}
        sky["cadence"] = {"frames": 30, "interval_days": 3, "exposure_s": 600}
        for star in ("A", "B"):
            sky["stars"][star]["photons_per_s"] /= 60
        (self.folder / "scene.json").write_text(json.dumps(sky))
        for k in range(3):
            self.succeed("simulate", "scene.json", "--frames", f"{10 * k}:{10 * k + 10}", "--out", "downlink", "--session", f"s{k}")
        done = self.run_program("calibrate", "scene.json", "downlink")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("fitted.json", done.stderr)
        done = self.run_program("track", "--fit", "fitted.json", "--state", "mission", "downlink/")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertNotIn("warning", done.stderr)
        self.assertIn("--mission-days 90: ", done.stderr)
        frames = [json.loads(line) for line in done.stdout.splitlines()]
        self.assertEqual([line["verdict"] for line in frames if "verdict" in line], ["accepted"] * 30)
        text = self.succeed("planet", "mission")
        self.assertRegex(text, r"amplitudes from [0-9.]+ uas")
        prior = json.loads(self.succeed("planet", "mission", "--json"))["prior"]
        self.assertAlmostEqual(prior["amplitude_min_uas"] / prior["amplitude_min"], 0.4e6, delta=1)

    def test_the_name_of_the_fitted_scene(self):
        """A scene that was not fitted is not replaced."""
        (self.folder / "scene.json").write_text(json.dumps(SKY))
        (self.folder / "fitted.json").write_text(json.dumps(SKY))
        numpy.save(self.folder / "f.npy", numpy.zeros((2, 48, 48)))
        self.refuse(6, "fitted.json: ", "--force",
                    arguments=("calibrate", "scene.json", "f.npy"))


del MissionTest

if __name__ == "__main__":
    unittest.main()
