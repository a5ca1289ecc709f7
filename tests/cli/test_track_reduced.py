"""toliman track --system: separations are reduced while frames arrive, and again by rebuild, with a definitive observer file or
a refitted system, without pixels. The values are compared with Sky.predict_mean of the Python package."""
import copy
import json
import logging
import shutil
import struct
import unittest

from observed import DAY, SECOND, SYSTEM, toliman, write_orbit
from program import ProgramTest

SCALE, HOURS = 0.75, 40
SCENE = {
    "schema": "toliman-scene/1",
    "telescope": {"aperture_m": 0.0625, "pupil_samples": 48,
                  "mask": {"kind": "spiral", "opd_nm": 292.5, "edges": "area", "terms": [{"a": 1, "f": 1.2, "m": -5, "p": 1}]}},
    "band": {"wavelength_nm": 580},
    "stars": {"A": {"spectrum": {"kind": "blackbody", "temperature_k": 5790}, "photons_per_s": 7.5e7},
              "B": {"spectrum": {"kind": "blackbody", "temperature_k": 5260}, "photons_per_s": 2.5e7}},
    "binary": {"orbit": "alpha-cen", "date": 2027.0, "moving": True},
    "cadence": {"times_days": [0.05 + 0.0617 * k for k in range(24)], "exposure_s": 60},
    "detector": {"shape": [48, 48], "pixel_scale_arcsec": SCALE},
    "noise": {"photon": False},
}
ARCS = [[5800.0 * i, 5800.0 * i + 1800] for i in range(8)]  # one side of each orbit, in an exposure of a day
GRID = ("--grid", "0.1:0.1:50")
ORBIT = ("--system", "alpha-cen", "--observer", "definitive.csv")


def setUpModule():
    logging.getLogger("toliman").setLevel(logging.ERROR)


class Reduced(ProgramTest):
    """A spacecraft takes 24 frames in 36 hours. Its predicted orbit is 1 s late and covers 20 hours."""

    @classmethod
    def setUpClass(cls):
        cls.zero = toliman.parse_time("2461406.75", "jd", "tt")

    def setUp(self):
        super().setUp()
        write_orbit(self.folder / "definitive.csv", self.zero, 60 * HOURS)
        write_orbit(self.folder / "predicted.csv", self.zero + SECOND, 60 * HOURS // 2)
        self.write_scene("scene.json", {"file": "definitive.csv"}, rate=8)
        self.write_scene("model.json", "none", rate=8)

    def write_scene(self, name, observer, rate=1, **cadence):
        scene = copy.deepcopy(SCENE)
        scene["binary"]["observer"] = observer
        scene["cadence"].update(cadence)
        for star in scene["stars"].values():
            star["photons_per_s"] *= rate
        (self.folder / name).write_text(json.dumps(scene))

    def simulate(self):
        done = self.run_program("simulate", "scene.json", "--out", "in", "--session", "s", "--dtype", "u32le")
        self.assertEqual(done.returncode, 0, done.stderr)

    def track(self, state, *more):
        done = self.run_program("track", "--fit", "model.json", "--state", state, "--dtype", "u32le", *GRID,
                                "--epoch", self.zero, *map(str, more), "in")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.stderr = done.stderr
        lines = map(json.loads, done.stdout.splitlines())
        return {line["frame_id"]: line for line in lines if line["schema"] == "toliman-frame/2"}

    def records(self, state):
        return {line["frame_id"]: line for line in map(json.loads, self.succeed("status", state, "--records").splitlines())}

    def sums(self, state):
        """The bytes of grid and sums in the checkpoint."""
        return (self.folder / state / "checkpoint.tlmc").read_bytes()[40:-4]

    def status(self, state):
        return json.loads(self.succeed("status", state, "--json"))

    def check(self, records, sky):
        for frame, record in records.items():
            middle = self.zero + round(SCENE["cadence"]["times_days"][frame] * DAY)
            mean = sky.predict_mean([[middle - 30 * SECOND, middle + 30 * SECOND]])
            found = record["reduction"]
            self.assertAlmostEqual(found["factor"], mean.factor, delta=1e-14)
            self.assertAlmostEqual(found["geometric_arcsec"], mean.geometric_arcsec, delta=1e-11)
            value = found["separation_px"] / found["factor"] - found["geometric_arcsec"] / SCALE
            self.assertAlmostEqual(record["value"], value, delta=1e-14)

    # promise: rebuild-gives-first-bits
    def test_predicted_then_definitive(self):
        self.simulate()
        lines = self.track("late", "--system", "alpha-cen", "--observer", "predicted.csv")
        covered = {frame for frame, line in lines.items() if line["verdict"] == "accepted"}
        self.assertEqual(covered, set(range(13)))
        self.assertEqual({line["reason"] for line in lines.values() if line["verdict"] == "unreduced"}, {"no orbit"})
        self.assertRegex(self.stderr, "11 frames .* predicted.csv .* 2027-01-01T[0-9:.]* to 2027-01-02T[0-9:.]* TAI; "
                                      "`toliman rebuild late --observer FILE`")
        status = self.status("late")
        self.assertEqual((status["accepted"], status["unreduced"], status["n"], status["received"]), (13, 11, 13, 24))
        self.assertEqual(status["plate_scale_arcsec"], SCALE)
        records = self.records("late")
        self.check({k: records[k] for k in covered}, toliman.Sky(observer=self.folder / "predicted.csv"))
        self.assertEqual(records[20]["reason"], "no orbit")
        self.assertNotEqual(records[20]["value"], 0)  # the estimate

        self.track("true", *ORBIT)
        self.assertNotIn("rebuild", self.stderr)
        self.succeed("rebuild", "late", "--observer", "definitive.csv")
        late, true = self.records("late"), self.records("true")
        self.assertEqual({k: v["value"] for k, v in late.items()}, {k: v["value"] for k, v in true.items()})
        self.assertEqual(self.sums("late"), self.sums("true"))  # the same bits as if it had been there at first
        self.assertEqual(self.status("late")["unreduced"], 0)
        self.check(true, toliman.Sky(observer=self.folder / "definitive.csv"))
        self.assertLess(max(abs(one["value"]) for one in true.values()) * SCALE * 1e6, 0.03)
        predicted = max(abs(records[k]["value"]) for k in covered) * SCALE * 1e6
        self.assertTrue(0.1 < predicted < 0.35, predicted)  # 1 s late: up to 8 m/s along the star

        # an older file afterwards: frames that it does not cover keep their reduction
        self.succeed("rebuild", "true", "--observer", "predicted.csv")
        mixed = self.records("true")
        self.assertEqual({k for k in mixed if mixed[k]["value"] == late[k]["value"]}, set(range(13, 24)))

    def test_an_observer_of_the_scene(self):
        """Frames that its file does not cover are measured, and added by the rebuild with the bits of a whole file."""
        self.simulate()
        values = {}
        for name in ("predicted", "definitive"):
            shutil.copy(self.folder / f"{name}.csv", self.folder / "known.csv")
            self.write_scene("model.json", {"file": "known.csv"}, rate=8)
            lines = self.track(name)
            self.assertEqual({frame for frame, line in lines.items() if line["verdict"] == "unreduced"},
                             set(range(13, 24)) if name == "predicted" else set())
            if name == "predicted":
                self.succeed("rebuild", name, "--observer", "definitive.csv")
            values[name] = [record["value"] for _, record in sorted(self.records(name).items())]
        for late, true in zip(values["predicted"][13:], values["definitive"][13:]):
            self.assertAlmostEqual(late, true, delta=1e-9)

    def test_day_sums(self):
        """One-sided arcs of a day: the mean over the arcs is exact; without them the frame is not reduced."""
        days = {"times_days": [0.5], "exposure_s": 86400.0, "rate": 0.5}
        self.write_scene("scene.json", {"file": "definitive.csv"}, on_target_s=[t for arc in ARCS for t in arc], **days)
        self.write_scene("model.json", "none", **days)
        self.simulate()
        self.track("day", *ORBIT)
        self.assertLess(abs(self.records("day")[0]["value"]) * SCALE * 1e6, 0.03)
        shutil.copytree(self.folder / "day", self.folder / "again")
        self.succeed("rebuild", "again", "--observer", "definitive.csv")
        self.assertEqual(self.sums("again"), self.sums("day"))  # the arcs are in the ledger
        side = self.folder / "in/s_meta.jsonl"
        line = json.loads(side.read_text())
        del line["on_target_s"]
        side.write_text(json.dumps(line) + "\n")
        lines = self.track("bare", *ORBIT)
        self.assertEqual(lines[0]["verdict"], "unreduced")
        self.assertIn("1 frame ", self.stderr)
        self.assertEqual(self.records("bare")[0]["reason"], "no intervals")
        lines = self.track("earth", "--system", "alpha-cen")  # the Earth's centre moves slowly
        self.assertEqual(lines[0]["verdict"], "accepted")

    def test_reduced_later(self):
        """A folder without a system is reduced by rebuild; another system and plate scale are a rebuild, too."""
        self.simulate()
        self.track("plain")
        self.refuse(2, "--system ", "--plate-scale", arguments=("rebuild", "plain", *ORBIT))
        self.succeed("rebuild", "plain", *ORBIT, "--plate-scale", SCALE)
        limit = struct.unpack_from("<d", (self.folder / "plain/ledger.tlml").read_bytes(), 96)[0]
        self.track("first", *ORBIT, "--value-limit", repr(limit))
        self.assertEqual(self.sums("plain"), self.sums("first"))
        system = json.loads(SYSTEM.read_text())
        system["orbit"]["semi_major_arcsec"] += 0.001
        (self.folder / "other.json").write_text(json.dumps(system))
        other = ("--system", "other.json", "--observer", "definitive.csv")
        self.refuse(2, "`toliman rebuild plain --system other.json --observer definitive.csv`",
                    arguments=("track", "--fit", "model.json", "--state", "plain", "--dtype", "u32le", *other, "in"))
        self.succeed("rebuild", "plain", *other)
        self.assertGreater(abs(self.records("plain")[3]["value"]) * SCALE, 4e-4)

    def begin_orbit_earlier(self):
        """At time 0 of a scene with this observer, half of an exposure is before it."""
        write_orbit(self.folder / "definitive.csv", self.zero - 13 * 3600 * SECOND, 75 * 60)

    def test_defaults_of_the_scene(self):
        """Epoch, system, observer, exposure and on-target intervals of the scene give what the options give."""
        self.begin_orbit_earlier()
        self.simulate()
        given = ("--system", "alpha-cen", "--observer", "definitive.csv", "--epoch", self.zero, "--exposure", "60")
        command = ("track", "--dtype", "u32le", *GRID, "--fit")
        for state, more in (("given", given), ("scene", ()), ("some", given[4:])):
            done = self.run_program(*command, "scene.json", "--state", state, *more, "in")
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertEqual((done.stderr.count("toliman: --"), self.sums(state)), (0, self.sums("given")), state)
        again = self.run_program(*command, "scene.json", "--state", "given", "in")  # the observer of a resumed folder
        self.assertEqual((again.returncode, again.stdout.count("duplicate")), (0, 24), again.stderr)
        other = ("--observer", "predicted.csv", "--epoch", self.zero + 1, "--exposure", "61", "--system", "same.json")
        (self.folder / "same.json").write_text(SYSTEM.read_text())
        done = self.run_program(*command, "scene.json", "--state", "other", *other, "in")
        for text in ("observer: predicted.csv ", f"--epoch {self.zero + 1}: ", "--exposure 61: ", "--system same.json: "):
            self.assertEqual(done.stderr.count("toliman: " + text), 1, done.stderr)

    def test_on_target_intervals_of_the_scene(self):
        """Of frames that state none: pairs of the mission, FITS files."""
        self.begin_orbit_earlier()
        self.write_scene("scene.json", {"file": "definitive.csv"}, times_days=[0.5, 1.5], exposure_s=86400.0, rate=0.5,
                         on_target_s=[second for arc in ARCS for second in arc])
        self.simulate()
        self.succeed("simulate", "scene.json", "--out", "two.fits")
        side = self.folder / "in/s_meta.jsonl"
        lines = [json.loads(line) for line in side.read_text().splitlines()]
        command = ("track", "--fit", "scene.json", *GRID, "--state")
        self.succeed(*command, "own", "--dtype", "u32le", "in")
        self.assertEqual([line.pop("on_target_s") for line in lines], [[second for arc in ARCS for second in arc]] * 2)
        side.write_text("".join(json.dumps(line) + "\n" for line in lines))
        for state, inputs in (("bare", ("--dtype", "u32le", "in")), ("cube", ("two.fits",))):
            out = self.succeed(*command, state, *inputs)
            self.assertEqual(out.count('"verdict":"accepted"'), 2)
            for frame, record in self.records(state).items():  # the counts of the pair are rounded
                self.assertAlmostEqual(record["value"], self.records("own")[frame]["value"], delta=1e-8)

    def test_length_of_exposures_over_windows(self):
        """An exposure of the scene that windows interrupt may be the time on target alone: its length is demanded."""
        self.begin_orbit_earlier()
        total = sum(end - start for start, end in ARCS)
        self.write_scene("scene.json", {"file": "definitive.csv"}, times_days=[0.5, 1.5], exposure_s=86400.0, rate=0.5,
                         on_target_s=[second for arc in ARCS for second in arc])
        self.simulate()
        self.write_scene("net.json", {"file": "definitive.csv"}, times_days=[0.5, 1.5], exposure_s=total, rate=0.5)
        begin = [self.zero + k * DAY for k in range(2)]
        (self.folder / "w.csv").write_text("start_tai_ns,end_tai_ns\n" + "".join(
            f"{start + int(a * SECOND)},{start + int(b * SECOND)}\n" for start in begin for a, b in ARCS))
        side = self.folder / "in/s_meta.jsonl"
        lines = [json.loads(line) for line in side.read_text().splitlines()]
        for line in lines:
            del line["on_target_s"]
        side.write_text("".join(json.dumps(line) + "\n" for line in lines))
        command = ("track", "--dtype", "u32le", *GRID, "--on-target", "w.csv", "--fit")
        done = self.run_program(*command, "net.json", "--state", "net", "in")
        self.assertEqual(done.returncode, 2, done.stderr)
        self.assertEqual([word in done.stderr for word in ("w.csv", f" {total:g} s ", "net.json", "--exposure SECONDS")], [True] * 4)
        self.assertFalse((self.folder / "net").exists())
        for state, model, more in (("given", "net.json", ("--exposure", "86400")), ("scene", "scene.json", ())):
            done = self.run_program(*command, model, "--state", state, *more, "in")
            self.assertEqual((done.returncode, done.stdout.count('"verdict":"accepted"')), (0, 2), done.stderr)
            self.assertNotIn("--exposure right", done.stderr)
        done = self.run_program(*command, "net.json", "--state", "short", "--exposure", str(total), "in")
        self.assertRegex(done.stderr, "2 of 2 .*--exposure right")

    def test_mistakes(self):
        self.simulate()
        self.track("s", *ORBIT)
        self.track("plain", "--value-limit", 0.25)
        model = ("track", "--fit", "model.json", "--dtype", "u32le", "in")
        new = ("--state", "new", *GRID)
        for text, more in (
                ("--observer FILE", ("--state", "s")), ("--plate-scale: ", (*new, "--plate-scale", "1")),
                ("--plate-scale -1: ", (*new, "--system", "alpha-cen", "--plate-scale", "-1")),
                (" 0.75 ", ("--state", "s", "--observer", "definitive.csv", "--plate-scale", "0.5"))):
            with self.subTest(text):
                self.refuse(2, text, arguments=(*model, *more))
        self.refuse(3, "nowhere.csv", arguments=(*model, "--state", "s", "--observer", "nowhere.csv"))
        self.refuse(3, "plain", arguments=("merge", "s", "plain", "--out", "m"))


if __name__ == "__main__":
    unittest.main()
