"""coadd: sums of simulated frames against numpy, what encode and track make of them, and kills at random moments.

Long version: `make kills`."""
import json
import os
import random
import resource
import signal
import subprocess
import time
import unittest

import numpy

from program import PROGRAM, ProgramTest

KILLS = int(os.environ.get("TOLIMAN_KILLS", 4))
FRAMES = int(os.environ.get("TOLIMAN_FRAMES", 600))
SUMS = FRAMES // 120
SCENE = {
    "schema": "toliman-scene/1", "name": "frame",
    "telescope": {"aperture_m": 0.125, "secondary_m": 0.01875, "pupil_samples": 96,
                  "struts": {"count": 3, "width_m": 0.002},
                  "mask": {"kind": "spiral", "edges": "cell", "opd_nm": 297.5,
                           "terms": [{"a": 0.819, "f": 2.918, "m": -7, "p": 4.874}, {"a": 0.93, "f": 1.829, "m": 5}]}},
    "band": {"min_nm": 550, "max_nm": 600, "step_nm": 12.5},
    "stars": {"A": {"spectrum": {"kind": "blackbody", "temperature_k": 5790}, "photons_per_s": 6e7},
              "B": {"spectrum": {"kind": "blackbody", "temperature_k": 5260}, "photons_per_s": 2e7}},
    "binary": {"separation_arcsec": 4, "position_angle_deg": 30},
    "cadence": {"frames": FRAMES, "interval_days": 1 / 86400, "exposure_s": 0.005},
    "detector": {"shape": [64, 64], "pixel_scale_arcsec": 0.2, "bit_depth": 12, "bias_dn": 100, "gain_e_per_dn": 1},
    "noise": {"photon": True, "read_e": 1.3, "seed": 5},
    "systematics": {"pointing_rms_px": 0.3},
}


class Coadd(ProgramTest):
    def setUp(self):
        super().setUp()
        (self.folder / "s.json").write_text(json.dumps(SCENE))
        self.succeed("simulate", "s.json", "--out", "in", "--session", "night", "--dtype", "u16le")

    def command(self, out, *more):
        return [PROGRAM, "coadd", "--fit", "s.json", "--every", "2min", "--dtype", "u16le", "--out", out, *more, "in"]

    def sums(self, out):
        counts = numpy.fromfile(self.folder / out / "sums_frames.bin", "<u4").reshape(-1, 64, 64)
        return counts, [json.loads(line) for line in (self.folder / out / "sums_meta.jsonl").read_text().splitlines()]

    def test_sums_are_those_of_numpy(self):
        done = subprocess.run(self.command("out"), cwd=self.folder, check=True, capture_output=True, text=True)
        frames = numpy.fromfile(self.folder / "in/night_frames.bin", "<u2").reshape(-1, 64, 64).astype(numpy.uint32)
        counts, lines = self.sums("out")
        reports = [json.loads(line) for line in done.stdout.splitlines()]
        self.assertEqual([line["frames"] for line in lines], [120] * SUMS)
        self.assertEqual([report["frames"] for report in reports], [120] * SUMS)
        self.assertEqual([report["reason"] for report in reports], ["time"] * (SUMS - 1) + ["end"])
        self.assertEqual([report["cosmic_rays"] + report["saturated"] for report in reports], [0] * SUMS)
        numpy.testing.assert_array_equal(counts, frames.reshape(SUMS, 120, 64, 64).sum(1))
        for number, line in enumerate(lines):
            middle = line["timestamp_ns"] * 1e-9 + line["exposure_s"] / 2
            self.assertAlmostEqual(middle, 120 * number + 59.5, delta=0.3)  # weighted by photons
            self.assertAlmostEqual(line["jitter_px2"][0], 0.09, delta=6 * 0.09 * (2 / 120) ** 0.5)
            start = line["timestamp_ns"] * 1e-9
            self.assertAlmostEqual(start + line["on_target_s"][0], 120 * number - 0.0025, delta=1e-6)
            self.assertAlmostEqual(start + line["on_target_s"][-1], 120 * number + 119.0025, delta=1e-6)

    def test_regions_and_drops(self):
        """A sum has one region, and drops of any number."""
        path = self.folder / "in/night_meta.jsonl"
        lines = [json.loads(line) for line in path.read_text().splitlines()]
        for line in lines[1::2]:
            line["roi_label"] = "other"
        lines[2]["nframes_dropped"] = 72000
        path.write_text("".join(json.dumps(line) + "\n" for line in lines))
        done = self.run_program(*self.command("mixed")[1:])
        self.assertEqual((done.returncode, "region other" in done.stderr and "--roi" in done.stderr), (2, True), done.stderr)
        self.assertEqual(self.run_program(*self.command("mixed", "--roi", "other")[1:]).returncode, 2)  # another folder
        subprocess.run(self.command("out", "--roi", "other"), cwd=self.folder, check=True, capture_output=True)
        subprocess.run(self.command("rest", "--roi", lines[0]["roi_label"]), cwd=self.folder, check=True, capture_output=True)
        for out, dropped in (("out", 0), ("rest", 72000)):
            sums = self.sums(out)[1]
            self.assertEqual([line["frames"] for line in sums], [60] * SUMS)
            self.assertEqual(sums[0]["nframes_dropped"], dropped)

    def test_track_takes_sums(self):
        subprocess.run(self.command("out"), cwd=self.folder, check=True, capture_output=True)
        self.succeed("track", "--fit", "s.json", "--state", "state", "--dtype", "u32le",
                     "--mission-days", "10", "out")
        series = self.succeed("status", "state", "--series").splitlines()
        status = json.loads(self.succeed("status", "state", "--json"))
        self.assertEqual((status["accepted"], status["rejected"]), (SUMS, 0))
        self.assertEqual(len(series), SUMS + 1)

    def test_encode_and_calibrate_take_sums(self):
        subprocess.run(self.command("out"), cwd=self.folder, check=True, capture_output=True)
        head, *lines = self.succeed("encode", "--fit", "s.json", "--dtype", "u32le", "out").splitlines()
        rows = [dict(zip(head.split(","), line.split(","))) for line in lines]
        self.assertEqual([row["goodness"] for row in rows], ["good"] * SUMS)
        pulls = [float(row["displacement_px"]) / float(row["separation_sigma_px"]) for row in rows]
        self.assertLess(max(map(abs, pulls)), 4)
        self.refuse(3, "out/sums_meta.jsonl: ", "--fit",
                    arguments=("encode", "--template", "s.json", "--dtype", "u32le", "out"))
        times = {}
        for stamp in ("start", "end"):
            self.succeed("calibrate", "s.json", "--dtype", "u32le", "--stamp", stamp, "--out", f"{stamp}.json", "--free",
                         "scale focus", "out")
            result = json.loads((self.folder / f"{stamp}.calibration.json").read_text())
            self.assertEqual((len(result["separations"]), result["goodness"]), (SUMS, "good"))
            times[stamp] = numpy.array([one["time_days"] for one in result["separations"]])
        lengths = [line["exposure_s"] / 86400 for line in self.sums("out")[1]]
        numpy.testing.assert_allclose(times["start"] - times["end"], lengths, atol=1e-14)

    def test_further_inputs_and_other_arguments(self):
        subprocess.run(self.command("out"), cwd=self.folder, check=True, capture_output=True)
        before = self.sums("out")
        done = subprocess.run(self.command("out"), cwd=self.folder, check=True, capture_output=True, text=True)
        self.assertEqual(done.stdout, "")  # all frames are known
        self.assertEqual(self.sums("out")[1], before[1])
        self.refuse(2, "out/sums_coadd.tlma: ", "--gap 0", arguments=self.command("out", "--gap", "1min")[1:])
        (self.folder / "out/sums_coadd.tlma").unlink()
        self.refuse(6, "out/sums_frames.bin: ", arguments=self.command("out")[1:])

    # promise: copied-frames-are-added-once
    def test_copies(self):
        """Files with other names, in another order, with frames of others in them: each frame is in one sum."""
        subprocess.run(self.command("whole"), cwd=self.folder, check=True, capture_output=True)
        pixels = numpy.fromfile(self.folder / "in/night_frames.bin", "<u2").reshape(-1, 64, 64)
        lines = (self.folder / "in/night_meta.jsonl").read_text().splitlines(keepends=True)
        chance = random.Random(11)
        for name, count in (("in/a", 400), ("in/zz", FRAMES)):
            chosen = sorted(chance.sample(range(FRAMES), count))
            pixels[chosen].tofile(self.folder / f"{name}_frames.bin")
            (self.folder / f"{name}_meta.jsonl").write_text("".join(lines[k] for k in chosen))
        done = subprocess.run(self.command("copies", "--gap", "1d"), cwd=self.folder, check=True, capture_output=True, text=True)
        counts, sums = self.sums("copies")
        self.assertEqual(sum(line["frames"] for line in sums), FRAMES, done.stderr)
        numpy.testing.assert_array_equal(counts.sum(0), self.sums("whole")[0].sum(0))

    # promise: killed-coadds-continue
    def test_a_full_disk(self):
        """The state can be written, the sum cannot: the frames of that sum are not known."""
        subprocess.run(self.command("whole"), cwd=self.folder, check=True, capture_output=True)
        for size in (60 << 10, 70 << 10):
            limit = lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))
            done = subprocess.run(self.command("full"), cwd=self.folder, capture_output=True, preexec_fn=limit)
            self.assertEqual(done.returncode, 6, done.stderr)
        subprocess.run(self.command("full"), cwd=self.folder, check=True, capture_output=True)
        self.assertEqual(self.pair("full"), self.pair("whole"))

    def test_unsuitable_frames(self):
        """Sums and frames of other shapes among the inputs are named and left out; the others are added."""
        subprocess.run(self.command("whole"), cwd=self.folder, check=True, capture_output=True)
        sums = self.pair("whole")
        numpy.zeros((2, 8, 8), "<u2").tofile(self.folder / "in/small_frames.bin")
        line = json.loads((self.folder / "in/night_meta.jsonl").read_text().splitlines()[0])
        (self.folder / "in/small_meta.jsonl").write_text("".join(
            json.dumps({**line, "frame_id": k, "n_rows": 8, "n_cols": 8, "session_id": "small"}) + "\n" for k in range(2)))
        done = subprocess.run(self.command("out"), cwd=self.folder, check=True, capture_output=True, text=True)
        self.assertIn("small_meta.jsonl:1: frame->rows", done.stderr)
        self.assertEqual(self.pair("out"), sums)

    def test_names_of_sessions(self):
        for name in ("a b", "", ".x", "../esc"):
            self.refuse(2, "--session: ", arguments=self.command("out", "--session", name)[1:])

    # promise: killed-coadds-continue
    def test_a_death_before_the_first_state(self):
        """A file may have 32 kB: a sum fits, not the state, whose writer dies."""
        subprocess.run(self.command("whole"), cwd=self.folder, check=True, capture_output=True)
        limit = lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (32768, 32768))
        done = subprocess.run(self.command("killed"), cwd=self.folder, capture_output=True, preexec_fn=limit)
        self.assertNotEqual(done.returncode, 0)
        subprocess.run(self.command("killed"), cwd=self.folder, check=True, capture_output=True)
        self.assertEqual(self.pair("killed"), self.pair("whole"))

    # promise: killed-coadds-continue
    def test_kills(self):
        start = time.monotonic()
        subprocess.run(self.command("whole"), cwd=self.folder, check=True, capture_output=True)
        seconds = time.monotonic() - start
        chance, killed, acknowledged = random.Random(7), 0, []
        for attempt in range(4 * KILLS):
            if killed == KILLS:
                break
            run = subprocess.Popen(self.command("killed"), cwd=self.folder, stdout=subprocess.PIPE,
                                   stderr=subprocess.DEVNULL, text=True)
            time.sleep(chance.uniform(0.3, 1) * seconds)
            run.kill()
            output = run.communicate()[0]
            self.assertIn(run.returncode, (0, -signal.SIGKILL))
            killed += run.returncode < 0
            acknowledged += [json.loads(line)["number"] for line in output.splitlines() if line.endswith("}")]
            known = [line["frame_id"] for line in self.lines("killed")]
            self.assertLessEqual(set(acknowledged), set(known))
            if run.returncode == 0 or len(known) == SUMS:
                self.assertEqual(self.pair("killed"), self.pair("whole"))
                for path in (self.folder / "killed").iterdir():
                    path.unlink()
                acknowledged = []
        subprocess.run(self.command("killed"), cwd=self.folder, check=True, capture_output=True)
        self.assertEqual(self.pair("killed"), self.pair("whole"))
        print(f"killed {killed} times; undisturbed {seconds:.2f} s")
        self.assertGreater(killed, 0)

    def lines(self, out):
        path = self.folder / out / "sums_meta.jsonl"
        text = path.read_text() if path.exists() else ""
        return [json.loads(line) for line in text.splitlines(keepends=True) if line.endswith("\n")]

    def pair(self, out):
        return [(self.folder / out / f"sums_{end}").read_bytes() for end in ("frames.bin", "meta.jsonl")]


if __name__ == "__main__":
    unittest.main()
