"""simulate --rate: the stream of the camera. Its files agree with the table of true values; its sums give its separation."""
import csv
import json
import os
import shutil
import signal
import subprocess
import time
import unittest

import numpy
from peers import fits, netCDF4, toliman
from program import PATIENCE, PROGRAM, ProgramTest

SIDE = 48
SCENE = {
    "schema": "toliman-scene/1", "name": "frame",
    "telescope": {"aperture_m": 0.125, "secondary_m": 0.01875, "pupil_samples": 96, "struts": {"count": 3, "width_m": 0.002},
                  "mask": {"kind": "spiral", "edges": "area", "opd_nm": 297.5,
                           "terms": [{"a": 0.819, "f": 2.918, "m": -7, "p": 4.874}, {"a": 0.93, "f": 1.829, "m": 5}]}},
    "band": {"min_nm": 550, "max_nm": 600, "step_nm": 12.5},
    "stars": {"A": {"spectrum": {"kind": "blackbody", "temperature_k": 5790}, "photons_per_s": 6e7},
              "B": {"spectrum": {"kind": "blackbody", "temperature_k": 5260}, "photons_per_s": 2e7}},
    "binary": {"separation_arcsec": 3, "position_angle_deg": 30},
    "cadence": {"frames": 1, "interval_days": 1, "exposure_s": 0.005},
    "detector": {"shape": [SIDE, SIDE], "pixel_scale_arcsec": 0.2, "bit_depth": 12, "bias_dn": 100, "gain_e_per_dn": 1},
    "noise": {"photon": True, "read_e": 1.3, "seed": 5},
}
FORMS = ["pair"] + ["netcdf"] * bool(netCDF4 and toliman.netcdf_version()) + ["fits"] * bool(fits)


class StreamTest(ProgramTest):
    def setUp(self):
        super().setUp()
        (self.folder / "s.json").write_text(json.dumps(SCENE))

    def stream(self, out, *more, duration="12s", session="night"):
        return self.succeed("simulate", "s.json", "--rate", "50", "--duration", duration, "--session", session, "--out", out, *more)

    def truth(self, out, session="night"):
        """All exposures; those that are not dropped."""
        with open(self.folder / out / f"{session}_truth.csv") as file:
            rows = [{key: value if key == "session" else float(value) for key, value in row.items()} for row in csv.DictReader(file)]
        return rows, [row for row in rows if not row["dropped"]]

    def pair(self, out, session="night"):
        pixels = numpy.fromfile(self.folder / out / f"{session}_frames.bin", "<u2").reshape(-1, SIDE, SIDE)
        return pixels, [json.loads(line) for line in (self.folder / out / f"{session}_meta.jsonl").read_text().splitlines()]


EVENTS = ("--jitter", "0.3:5", "--drift", "0.5:20s", "--cosmic-rays", "0.05", "--drops", "0.03:4", "--restarts", "5s")


class Stream(StreamTest):
    def test_numbers_and_times(self):
        """Ids, stamps and drops of the lines follow from the true values, across restarts and sessions."""
        self.stream("in", *EVENTS, "--sessions", "8s", "--roi", "centre", duration="20s")
        rows, kept = self.truth("in")
        lines = []
        for session in ("night", "night-2", "night-3"):
            lines += self.pair("in", session)[1]
        self.assertEqual(len(lines), len(kept))
        self.assertEqual(len(rows), 1000 - 4 * 50)  # 1 s without frames: 3 restarts, of which one after a session, 2 sessions
        last, power_on, epoch = -1, 0, (0, 0)
        for row, line in zip(kept, lines):
            if (row["session"], row["restarts"]) != epoch:
                last = -1
                starts_again = row["restarts"] > 0
                epoch = (row["session"], row["restarts"])
                power_on = row["index"] - row["frame_id"] if starts_again else power_on
            self.assertEqual([line["session_id"], line["frame_id"], line["nframes_dropped"], line["roi_label"]],
                             [row["session"], row["frame_id"], row["frame_id"] - last - 1, "centre"])
            self.assertEqual(line["timestamp_ns"] // 10**7, (row["index"] - power_on) * 2)
            self.assertEqual(line["timestamp_ns"] % 1000, 0)
            self.assertAlmostEqual(line["host_time"], (row["index"] + 1) / 50, delta=1e-9)
            last = row["frame_id"]
        self.assertEqual({row["restarts"] for row in rows}, {0, 1})
        first = [frame for frame in toliman.Pair(self.folder / "in/night_meta.jsonl", "u16le", exposure_s=0.005)]
        of_first = [row for row in kept if row["session"] == "night"]
        self.assertEqual([frame.restarts for frame in first], [row["restarts"] for row in of_first])
        self.assertEqual([frame.camera_ns for frame in first], [row["index"] * 20000000 + 2500000 for row in of_first])

    def test_frames_alone_and_again(self):
        """A frame depends on scene, options, seed and number only."""
        self.stream("all", *EVENTS)
        pixels, lines = self.pair("all")
        self.stream("part", *EVENTS, "--frames", "290:400")
        rows, kept = self.truth("part")
        first = len([row for row in self.truth("all")[1] if row["index"] < 290])
        found, numbers = self.pair("part")
        numpy.testing.assert_array_equal(found, pixels[first:first + len(kept)])
        self.assertEqual(numbers, lines[first:first + len(kept)])
        subprocess.run(["taskset", "-c", str(min(os.sched_getaffinity(0))), PROGRAM, "simulate", "s.json", "--rate", "50", "--duration", "12s",
                               "--session", "night", "--out", "one", *EVENTS], cwd=self.folder, check=True)
        self.assertEqual((self.folder / "one/night_frames.bin").read_bytes(), (self.folder / "all/night_frames.bin").read_bytes())
        self.stream("other", *EVENTS, "--seed", "6")
        self.assertNotEqual((self.folder / "one/night_frames.bin").read_bytes()[:9000], (self.folder / "other/night_frames.bin").read_bytes()[:9000])

    def test_statistics(self):
        """Jitter has its rms and spectrum, drift its circle, losses and hits their rates; frames are those of the model."""
        scene = {**SCENE, "detector": {**SCENE["detector"], "shape": [8, 8]}, "binary": {"separation_arcsec": 0.6, "position_angle_deg": 30}}
        (self.folder / "s.json").write_text(json.dumps(scene))
        self.stream("in", "--jitter", "0.3:2", "--drops", "0.1:5", "--cosmic-rays", "0.2", duration="400s")
        rows, _ = self.truth("in")
        n = len(rows)
        for key in ("x_px", "y_px"):
            place = numpy.array([row[key] for row in rows])
            memory = numpy.exp(-2 * numpy.pi * 2 / 50)
            independent = n * (1 - memory) / (1 + memory)
            self.assertAlmostEqual(place.var() / 0.09, 1, delta=5 * (2 / independent)**0.5)
            for lag in (1, 3):
                self.assertAlmostEqual((place[lag:] * place[:-lag]).mean() / place.var(), memory**lag, delta=0.05)
        self.assertLess(abs(numpy.corrcoef([row["x_px"] for row in rows], [row["y_px"] for row in rows])[0, 1]), 0.1)
        dropped = numpy.array([row["dropped"] for row in rows])
        runs = (numpy.diff(dropped) > 0).sum()
        self.assertAlmostEqual(dropped.mean(), 0.1, delta=5 * (0.1 * 0.9 * 9 / n)**0.5)
        self.assertAlmostEqual(dropped.sum() / runs, 5, delta=5 * 5 / runs**0.5)
        self.assertAlmostEqual(sum(row["cosmic_rays"] for row in rows) / n, 0.2, delta=5 * (0.2 / n)**0.5)
        self.stream("circle", "--drift", "0.4:80s", duration="80s")
        for row in self.truth("circle")[0][::100]:
            angle = 2 * numpy.pi * row["index"] / 4000
            numpy.testing.assert_allclose([row["x_px"], row["y_px"]], [0.4 * numpy.cos(angle), 0.4 * numpy.sin(angle)], atol=2e-9)

    def test_images(self):
        """Frames without noise are the image of a scene whose stars are there, but for rounding and the charge of cosmic rays. The
        images before are so to 1e-3 of the noise of a pixel, and bias no parameter of a sum of 1e5 frames by 0.05 of its bound."""
        (self.folder / "s.json").write_text(json.dumps({**SCENE, "noise": {"seed": 5}}))
        self.stream("in", "--jitter", "0.5", "--cosmic-rays", "0.5", duration="0.2s")
        rows, _ = self.truth("in")
        pixels, _ = self.pair("in")
        simulator = toliman.Simulator(SCENE)
        still, fit = simulator.offsets(), toliman.Fit(simulator)
        for row, frame in zip(rows, pixels):
            places = still + [row["x_px"], row["y_px"]]
            self.assertAlmostEqual(numpy.hypot(*(places[1] - places[0])), row["separation_px"], delta=1e-9)
            moved = {**SCENE, "binary": {"offsets_px": {"A": places[0], "B": places[1]}}}
            exact = toliman.Simulator(moved).image()
            error = (fit.predict(shift=(row["x_px"], row["y_px"]))[0] - exact) / (exact - 100 + 1.3**2 + 1 / 12)**0.5
            self.assertLess(abs(error).max(), 1e-3)
            self.assertLess(1e5**0.5 * (error**2).sum()**0.5, 0.05)  # Cauchy and Schwarz: of any bias over its bound
            excess = frame - exact
            hit = excess > 0.6
            self.assertLess(abs(excess[~hit]).max(), 0.5 + 1e-6)
            self.assertEqual(hit.sum(), row["cosmic_rays"])
            self.assertTrue((excess[hit] >= 799).all())

    def test_refused(self):
        base = ("simulate", "s.json", "--rate", "50", "--duration", "1s", "--session", "n", "--out", "x")
        for text, more in {"--jitter 1:x: ": ("--jitter", "1:x"), "--drift 3y": ("--drift", "2:3y"),
                           " 14 px": ("--drift", "12", "--jitter", "0.5"), "--drops 0.7": ("--drops", "0.7"),
                           "--restarts 2s: ": ("--restarts", "2s"), "u16le": ("--dtype", "u32le"),
                           "--bit-depth": ("--bit-depth", "12", "--dtype", "u16le"), "--roi: ": ("--format", "fits", "--roi", "centre"),
                           "--frames 60:70": ("--frames", "60:70")}.items():
            with self.subTest(text):
                self.refuse(2, text, arguments=(*base, *more))
        self.refuse(2, "--duration", arguments=("simulate", "s.json", "--rate", "50", "--session", "n", "--out", "x"))
        self.refuse(2, "--session", arguments=("simulate", "s.json", "--rate", "50", "--duration", "1s", "--out", "x"))
        self.refuse(6, "x", " TB", arguments=(*base[:5], "30000d", *base[6:]))
        for key, text, change in (("cadence", "cadence.exposure_s", {"frames": 1, "interval_days": 1, "peak_photons": 400}),
                                  ("cadence", "exposure_s = 0.03: ", {**SCENE["cadence"], "exposure_s": 0.03}),
                                  ("systematics", "systematics: ", {"pointing_rms_px": 1}),
                                  ("signal", "signal: ", {"kind": "sinusoid", "amplitude_px": 1e-5, "period_days": 5}),
                                  ("detector", "bit_depth = 0", {"shape": [48, 48], "pixel_scale_arcsec": 0.2})):
            (self.folder / "s.json").write_text(json.dumps({**SCENE, key: change}))
            self.refuse(2, text, arguments=base)
        (self.folder / "s.json").write_text(json.dumps(SCENE))
        self.succeed(*base)
        self.assertIn("x/n_truth.csv: ", self.run_program(*base).stderr)

    def test_signal_leaves_nothing(self):
        run = subprocess.Popen([PROGRAM, "simulate", "s.json", "--rate", "50", "--duration", "1h", "--session", "n", "--out", "x"],
                               cwd=self.folder, stderr=subprocess.PIPE, text=True)
        end = time.monotonic() + PATIENCE
        while not list(self.folder.glob("x/n_frames.bin*")) and time.monotonic() < end:
            time.sleep(0.02)
        run.send_signal(signal.SIGINT)
        self.assertIn("stopped by a signal", run.communicate(timeout=PATIENCE)[1])
        self.assertEqual(run.returncode, 130)
        self.assertFalse((self.folder / "x").exists())


class Sums(StreamTest):
    def test_from_stream_to_separation(self):
        """simulate, coadd and track --fit without --sigma: the separation within its error, chi-square 1, and every loss counted."""
        self.stream("in", *EVENTS, duration="60s")
        done = self.run_program("coadd", "--fit", "s.json", "--every", "5s", "--dtype", "u16le", "--out", "sums", "in")
        self.assertEqual(done.returncode, 0, done.stderr)
        sums = [json.loads(line) for line in done.stdout.splitlines()]
        rows, kept = self.truth("in")
        hits = sum(row["cosmic_rays"] for row in kept)
        self.assertEqual(sum(one["frames"] for one in sums), len(kept))
        self.assertEqual(sum(one["cosmic_rays"] + one["saturated"] for one in sums), hits)
        self.assertEqual(sum(sum(one[key] for key in ("lost", "faint", "not_found", "outside", "misfit")) for one in sums), 0)
        _, lines = self.pair("in")
        side = [json.loads(line) for line in (self.folder / "sums/sums_meta.jsonl").read_text().splitlines()]
        self.assertEqual(sum(line["nframes_dropped"] for line in side), sum(line["nframes_dropped"] for line in lines))
        for one in sums:
            part = [row for row in kept if one["first_ns"] <= row["host_time"] * 1e9 - 2e7 + 1e5 <= one["last_ns"]]
            self.assertEqual(len(part), one["frames"])
            for axis in "xy":
                self.assertAlmostEqual(one[f"{axis}_px"], numpy.mean([row[f"{axis}_px"] for row in part]), delta=3e-3)
        self.run_program("track", "--fit", "s.json", "--state", "state", "--dtype", "u32le", "--mission-days", "10", "sums")
        series = numpy.array([[float(x) for x in line.split(",")] for line in self.succeed("status", "state", "--series").splitlines()[1:]])
        status = json.loads(self.succeed("status", "state", "--json"))
        self.assertEqual((status["accepted"], status["rejected"]), (len(sums), 0))
        self.assertLess(abs((series[:, 1] / series[:, 2]**2).sum() / (1 / series[:, 2]**2).sum()**0.5), 4)  # mean over its error
        self.assertLess((series[:, 1]**2 / series[:, 2]**2).sum(), len(sums) + 5 * (2 * len(sums))**0.5)
        text = self.succeed("status", "state", "--records")
        chi = [json.loads(line)["chi_square"] for line in text.splitlines()]
        self.assertAlmostEqual(numpy.mean(chi), 1, delta=5 * (2 / SIDE**2 / len(chi))**0.5)

    def test_what_a_sum_cannot_be(self):
        """Pixels that are no counts, and stars that moved too far for a fit of the sum, are said."""
        simulator = toliman.Simulator(SCENE)
        images = numpy.rint(simulator.expose(numpy.array([simulator.image()] * 3)))
        images[1, 5, 7] += 0.5
        numpy.save(self.folder / "f.npy", images)
        done = self.run_program("coadd", "--fit", "s.json", "--out", "sums", "--cadence", "0.02", "f.npy")
        self.assertIn("f.npy:1: row 5, column 7: ", done.stderr)
        self.assertEqual(json.loads(done.stdout)["frames"], 2)
        self.stream("in", "--drift", "3.5:2s", duration="2s")
        done = self.run_program("coadd", "--fit", "s.json", "--dtype", "u16le", "--out", "wide", "in")
        self.assertIn("sum 0: ", done.stderr)

    def test_sums_of_every_format(self):
        """Files are read in the order of their times, whatever the number of digits: sums have the bytes of those of a pair."""
        found = {}
        for form in FORMS:
            self.stream(form, "--jitter", "0.3", "--format", form, duration="3s")
            self.run_program("coadd", "--fit", "s.json", "--every", "1s", "--dtype", "u16le", "--out", f"{form}_sums", form)
            found[form] = (self.folder / f"{form}_sums/sums_frames.bin").read_bytes()
            self.assertEqual(len(found[form]), 3 * 4 * SIDE**2, form)
            self.assertEqual(found[form], found["pair"], form)
        if "netcdf" not in FORMS:
            return
        for number, path in enumerate(sorted((self.folder / "netcdf").glob("*.nc"))):
            path.rename(path.with_name(f"night_batch{9999 + number}.nc"))
        self.run_program("coadd", "--fit", "s.json", "--every", "1s", "--out", "later", "netcdf")
        self.assertEqual((self.folder / "later/sums_frames.bin").read_bytes(), found["pair"])

    def test_sums_know_their_noise(self):
        """The standard deviation of a sum is that of a frame over sqrt(frames) without jitter; a folder takes sums of 4 to 60 times
        as many frames as the one with which it was created."""
        self.stream("in", duration="33s")
        for every, least in (("1s", 50), ("30s", 1500)):
            self.run_program("coadd", "--fit", "s.json", "--every", every, "--dtype", "u16le", "--out", "sums", "--session", f"e{every}", "in")
            self.run_program("track", "--fit", "s.json", "--state", "state", "--dtype", "u32le", "--mission-days", "10",
                             f"sums/e{every}_meta.jsonl")
        self.run_program("track", "--fit", "s.json", "--state", "frame", "--dtype", "u16le", "--mission-days", "10", "--frames", "0:1", "in")
        frame = float(self.succeed("status", "frame", "--series").splitlines()[1].split(",")[2])
        status = json.loads(self.succeed("status", "state", "--json"))
        self.assertEqual((status["accepted"], status["rejected"]), (33 + 2, 0))
        sigma = sorted({round(float(line.split(",")[2]) / frame * 50**0.5, 1) for line in self.succeed("status", "state", "--series").splitlines()[1:]})
        self.assertEqual(sigma, [0.2, 0.6, 1.0])  # sums of 1500, 150 and 50 frames

    def follow(self, *inputs):
        run = subprocess.Popen([PROGRAM, "track", "--fit", "s.json", "--state", "state", "--mission-days", "10", "--follow", *inputs],
                               cwd=self.folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.addCleanup(run.communicate)
        self.addCleanup(run.kill)
        return run

    def frames(self, run, count):
        """The next lines of frames."""
        found = []
        while len(found) < count:
            line = json.loads(run.stdout.readline())
            found += [line] if line["schema"] == "toliman-frame/2" else []
        return found

    def test_track_waits_for_the_first_sum(self):
        """With --follow, before coadd has written one."""
        self.stream("in", "--jitter", "0.3", duration="4s")
        (self.folder / "sums").mkdir()
        run = self.follow("sums", "--dtype", "u32le")
        while "waiting" not in run.stderr.readline():
            self.assertIsNone(run.poll())
        self.assertFalse((self.folder / "state").exists())
        self.run_program("coadd", "--fit", "s.json", "--every", "2s", "--dtype", "u16le", "--out", "sums", "in")
        self.assertEqual([frame["verdict"] for frame in self.frames(run, 2)], ["accepted"] * 2)

    def test_batches_are_followed(self):
        """As they arrive in a folder; one that was cut, again once it is whole."""
        if "netcdf" not in FORMS:
            self.skipTest("needs netCDF")
        self.stream("all", "--format", "netcdf", duration="3s")
        (self.folder / "in").mkdir()
        first, second, third = sorted((self.folder / "all").glob("*.nc"))
        shutil.copy(first, self.folder / "in")
        (self.folder / "in" / second.name).write_bytes(second.read_bytes()[:-5000])
        run = self.follow("in")
        ids = [frame["frame_id"] for frame in self.frames(run, 50)]
        while "damage" not in run.stdout.readline():
            self.assertIsNone(run.poll())
        shutil.copy(second, self.folder / "in")
        shutil.copy(third, self.folder / "in")
        ids += [frame["frame_id"] for frame in self.frames(run, 100)]
        self.assertEqual(sorted(ids), list(range(150)))
        run.send_signal(signal.SIGTERM)
        self.assertIn("state saved", run.communicate(timeout=PATIENCE)[1])

    # promise: copied-frames-are-added-once
    def test_copies_of_fits_files(self):
        """Files of other folders with the same names are the same frames, those with other names are not."""
        self.stream("in", "--format", "fits", duration="0.2s")
        shutil.copytree(self.folder / "in", self.folder / "copy")
        one = sorted((self.folder / "copy").glob("*.fits.gz"))[3]
        shutil.copy(one, one.with_name("other_7.fits.gz"))
        self.succeed("coadd", "--fit", "s.json", "--every", "1s", "--gap", "1d", "--out", "sums", "copy", "in")
        (line,) = (self.folder / "sums" / "sums_meta.jsonl").read_text().splitlines()
        self.assertEqual(json.loads(line)["frames"], 11)

    def test_fits_files_are_followed(self):
        self.stream("all", "--format", "fits", duration="0.06s")
        (self.folder / "in").mkdir()
        first, second, third = sorted((self.folder / "all").glob("*.fits.gz"))
        shutil.copy(first, self.folder / "in")
        run = self.follow("in")
        self.assertEqual(len(self.frames(run, 1)), 1)
        for path in (second, third):
            shutil.copy(path, self.folder / "in")
        self.assertEqual([frame["verdict"] for frame in self.frames(run, 2)], ["accepted"] * 2)


if __name__ == "__main__":
    unittest.main()
