"""Frames after bytes that a file of pixels has lost or gained: found again where the size of the file tells how, else
named as misfits; never in the sums at a wrong place."""
import json
import unittest

from test_track import FRAMES, Track

SIZE = 64 * 64 * 4  # bytes of a frame


class Realigned(Track):
    def put(self, pieces, lines):
        (self.folder / "in").mkdir(exist_ok=True)
        (self.folder / "in/x_frames.bin").write_bytes(b"".join(pieces))
        (self.folder / "in/x_meta.jsonl").write_text("".join(line.rstrip("\n") + "\n" for line in lines))

    def series(self, state):
        return self.succeed("status", state, "--series")

    def test_holes(self):
        raw = [frame.astype("<u4").tobytes() for frame in self.frames]
        self.assertEqual((FRAMES, len(raw[0])), (48, SIZE))
        inside = lambda cut, kept: [raw[k][:kept] if k == cut else raw[k] for k in range(FRAMES)]
        without = lambda *ids: [line for k, line in enumerate(self.lines) if k not in ids]
        cases = (  # what, pieces of the file, lines, frames that cannot be found, steps at which frames are found
            ("a frame without line", inside(12, 6000), without(12), {12}, [6000]),
            ("bytes that are no whole pixels", inside(12, 6001), without(12), {12}, [6001]),
            ("a frame whose rest is lost", inside(12, 6000), self.lines, {12}, [6000 - SIZE]),
            ("the same near the end", inside(46, 100), self.lines, {46, 47}, []),  # as if the last were not yet there
            ("two of one sign", [raw[k][:5000] if k in (9, 30) else raw[k] for k in range(FRAMES)], without(9, 30), {9, 30},
             [5000, 10000]),
            ("bytes before the first frame", [b"\1" * 3000, *raw], self.lines, set(range(FRAMES)), []),
            ("noise inserted", [*raw[:20], b"\7\0\0\1" * 1500, *raw[20:]], self.lines, set(), [6000]),
        )
        whole = self.track("whole", "all")
        value = {line["frame_id"]: line["value"] for line in whole if "verdict" in line}
        for number, (what, pieces, lines, lost, steps) in enumerate(cases):
            with self.subTest(what):
                self.put(pieces, lines)
                for jobs in ("1", "8"):
                    state = f"s{number}-{jobs}"
                    out = [line for line in self.track(state, "in", "--jobs", jobs, "--every", "8") if "verdict" in line]
                    good = {line["frame_id"]: line["value"] for line in out if line["verdict"] == "accepted"}
                    self.assertEqual(set(good), set(range(FRAMES)) - lost)
                    self.assertTrue(all(good[k] == value[k] for k in good))
                    self.assertTrue({line["verdict"] for line in out} <= {"accepted", "misfit", "outlier", "rejected"})
                    damaged = [line for line in out if line["verdict"] != "accepted" and line["goodness"] != "good"]
                    self.assertEqual({line["shift_bytes"] for line in damaged} - {0}, set())
                    shifts = [line["shift_bytes"] for line in out if line["verdict"] == "accepted"]
                    self.assertEqual(sorted(set(shifts) - {0}, key=shifts.index), steps)
                    again = self.track(state, "in")  # known frames are found again, too
                    self.assertEqual({line["verdict"] for line in again if "verdict" in line} - {"rejected"}, {"duplicate"})
                self.assertEqual(self.series(f"s{number}-1"), self.series(f"s{number}-8"))
                if steps:
                    self.assertIn("realigned: the frame is", self.errors)

    def test_frames_of_another_telescope(self):
        """All frames are wrong: none is accepted, and the reason is told."""
        scene = json.loads(self.scene)
        scene["detector"]["pixel_scale_arcsec"] *= 1.03
        (self.folder / "scene.json").write_text(json.dumps(scene))
        out = self.track("s", "all")
        self.assertNotIn("accepted", {line["verdict"] for line in out if "verdict" in line})
        self.assertIn("frames of this run is accepted", self.errors)


if __name__ == "__main__":
    unittest.main()
