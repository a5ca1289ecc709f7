"""On-target intervals in track. The ledger's columns of exposure and mean time are compared with plain loops over
fractions."""
import fractions
import json
import struct
import unittest

from program import HEADER, LINE
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
            self.assertEqual(len(line), 9)
        self.follow("s")
        self.assertEqual(self.errors, "")
        columns = self.columns("s")
        self.assertEqual(len(columns), FRAMES)
        self.check(columns, ALL, OWN_PAIRS)
        (self.folder / "plain.json").write_text(self.plain)
        self.succeed("simulate", "plain.json", "--out", "plain", "--session", "day", "--dtype", "u32le")
        line = json.loads((self.folder / "plain/day_meta.jsonl").read_text().splitlines()[0])
        self.assertEqual(sorted(line), sorted(key for key in json.loads(self.lines[0]) if key != "on_target_s"))

    def test_intervals_need_an_exposure(self):
        lines = self.follow("s", "--exposure", "0", "--strict", code=4)
        self.assertEqual({(line["verdict"], line["reason"]) for line in lines.values()}, {("rejected", "bad line")})
        self.assertIn("all/day_meta.jsonl:1: rejected: bad line: on_target_s needs the length of the exposure", self.errors)
        self.assertIn("--exposure", self.errors)

    def test_too_many_intervals_for_a_line(self):
        scene = json.loads(self.scene)
        scene["cadence"]["on_target_s"] = list(range(130))
        (self.folder / "many.json").write_text(json.dumps(scene))
        self.refuse(2, "many.json: cadence.on_target_s has 65 intervals: must be at most 64 for --session",
                    arguments=("simulate", "many.json", "--out", "many", "--session", "day", "--dtype", "u32le"))
        scene["cadence"]["on_target_s"] = [second + 0.1234567890123456 for second in range(128)]
        (self.folder / "many.json").write_text(json.dumps(scene))
        self.succeed("simulate", "many.json", "--out", "many", "--session", "day", "--dtype", "u32le", "--frames", "0:2")
        self.follow("s", inputs=("many",))
        self.check(self.columns("s"), ALL, [(second + 0.1234567890123456, second + 1.1234567890123456) for second in range(0, 128, 2)])


if __name__ == "__main__":
    unittest.main()
