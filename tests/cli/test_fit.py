"""encode --template and --fit, track --fit: the numbers of frames of a small scene, their times, warnings and refusals."""
import json
import subprocess
import unittest

import numpy

from program import PROGRAM, ProgramTest

SCENE = {
    "schema": "toliman-scene/1",
    "telescope": {"aperture_m": 0.125, "secondary_m": 0.01875, "pupil_samples": 96,
                  "mask": {"kind": "spiral", "edges": "cell", "opd_nm": 297.5, "terms": [{"a": 0.819, "f": 2.918, "m": -7, "p": 4.874},
                                                                     {"a": 0.93, "f": 1.829, "m": 5}]}},
    "band": {"min_nm": 550, "max_nm": 600, "step_nm": 12.5},
    "stars": {"A": {"spectrum": {"kind": "blackbody", "temperature_k": 5790}, "relative_flux": 3},
              "B": {"spectrum": {"kind": "blackbody", "temperature_k": 5260}}},
    "binary": {"date": 2027, "orbit": "alpha-cen", "moving": True},
    "signal": {"kind": "sinusoid", "star": "B", "amplitude_px": 1e-3, "period_days": 40},
    "cadence": {"frames": 100, "interval_days": 2, "peak_photons": 1e5},
    "detector": {"shape": [64, 64], "pixel_scale_arcsec": 0.4},
    "noise": {"photon": True, "read_e": 2.5, "seed": 7},
}
COLUMNS = ("file,frame,displacement_px,chi_square,chi_square_sigma,largest_residual,goodness,bad_pixels,separation_px,"
           "separation_sigma_px,position_angle_deg,x_px,y_px,flux_a,flux_b,background,iterations,flags")


class Fit(ProgramTest):
    def setUp(self):
        super().setUp()
        self.write("s.json", SCENE)
        self.simulate("0:6", "f.npy")

    def write(self, name, scene):
        (self.folder / name).write_text(json.dumps(scene))

    def simulate(self, frames, name):
        done = self.run_program("simulate", "s.json", "--frames", frames, "--out", name)
        self.assertEqual(done.returncode, 0, done.stderr)

    def rows(self, text):
        """The lines of encode --fit as dicts of words."""
        head, *lines = text.splitlines()
        self.assertEqual(head, COLUMNS)
        return [dict(zip(COLUMNS.split(","), line.split(","))) for line in lines]

    def fit(self, *arguments):
        return self.rows(self.succeed("encode", "--fit", "s.json", *arguments))

    def separations(self, rows):
        """Those that were predicted."""
        return [float(row["separation_px"]) - float(row["displacement_px"]) for row in rows]


class Encode(Fit):
    def test_template(self):
        self.write("s.json", {**SCENE, "binary": {"separation_arcsec": 7, "position_angle_deg": 30}})
        self.simulate("0:6", "f.npy")
        text = self.succeed("encode", "--template", "s.json", "f.npy").splitlines()
        self.assertEqual(text[0], "file,frame,displacement_px,chi_square,chi_square_sigma,largest_residual,goodness,bad_pixels")
        self.assertEqual([line.split(",")[:2] for line in text[1:]], [["f.npy", str(k)] for k in range(6)])
        self.assertLess(abs(float(text[1].split(",")[2])), 0.01)

    def test_numbers(self):
        rows = self.fit("f.npy")
        self.assertEqual([row["frame"] for row in rows], [str(k) for k in range(6)])
        for row in rows:
            self.assertLess(abs(float(row["displacement_px"])), 0.01)
            self.assertLess(abs(float(row["chi_square"]) - 1), 0.15)
            self.assertGreater(float(row["separation_sigma_px"]), 0)
            self.assertGreater(int(row["iterations"]), 0)
            self.assertEqual(row["flags"], "")

    def test_times(self):
        """By the scene, by the table FRAMES, and by --cadence."""
        by_scene = self.separations(self.fit("f.npy"))
        self.assertEqual(len(set(by_scene)), 6)  # the stars move
        self.simulate("2:6", "f.fits")
        by_table = self.separations(self.fit("f.fits"))
        numpy.testing.assert_allclose(by_table, by_scene[2:], rtol=0, atol=1e-9)
        by_cadence = self.separations(self.fit("f.npy", "--cadence", str(4 * 86400)))
        numpy.testing.assert_allclose(by_cadence[:3], by_scene[::2], rtol=0, atol=1e-9)
        numpy.save(self.folder / "long.npy", numpy.load(self.folder / "f.npy")[numpy.arange(101) % 6])
        self.refuse(3, "long.npy: ", "101", "--cadence", arguments=("encode", "--fit", "s.json", "long.npy"))

    def test_many_frames_keep_their_order(self):
        """More than a batch, of a file and of a pipe, which gives its frames one by one."""
        frames = numpy.load(self.folder / "f.npy")[numpy.arange(150) % 6]
        numpy.save(self.folder / "many.npy", frames)
        text = self.succeed("encode", "--fit", "s.json", "--cadence", "60", "many.npy")
        self.assertEqual([int(row["frame"]) for row in self.rows(text)], list(range(150)))
        piped = subprocess.run([PROGRAM, "encode", "--fit", "s.json", "--cadence", "60", "-"], cwd=self.folder,
                               input=(self.folder / "many.npy").read_bytes(), capture_output=True, check=True)
        self.assertEqual(piped.stdout.decode(), text.replace("many.npy,", "-,"))

    def test_a_bad_frame_of_a_batch(self):
        """The lines before it are complete."""
        frames = numpy.load(self.folder / "f.npy").astype(float)
        frames[4, 5, 6] = numpy.nan
        numpy.save(self.folder / "bad.npy", frames)
        for options, lines in (("--fit", 5), ("--template", 5)):
            done = self.run_program("encode", options, "s.json", "bad.npy")
            self.assertEqual(done.returncode, 3)
            self.assertEqual(done.stdout.count("\n"), lines)
            self.assertIn("bad.npy: frame 4: counts[5][6] = nan", done.stderr)

    def test_warnings(self):
        """The first frame of each kind, and their number."""
        frames = numpy.load(self.folder / "f.npy").astype(float)
        frames[[1, 2]] = 0
        frames[[4, 5]] += 3 * numpy.sqrt(frames[[4, 5]].clip(10)) * numpy.where(numpy.arange(64) % 2, 1, -1)
        numpy.save(self.folder / "bad.npy", frames)
        done = self.run_program("encode", "--fit", "s.json", "bad.npy")
        self.assertEqual(done.returncode, 0)
        rows = self.rows(done.stdout)
        self.assertIn("not_converged", rows[1]["flags"].split("+"))
        self.assertEqual([rows[1][name] for name in ("displacement_px", "separation_px", "flux_a")], ["nan"] * 3)
        self.assertEqual(done.stderr.count("bad.npy: frame 1: "), 1)
        self.assertEqual(done.stderr.count("bad.npy: frame 4: "), 1)
        self.assertEqual([row["goodness"] for row in rows], ["good", "unknown", "unknown", "good", "poor", "poor"])
        self.assertEqual(done.stderr.count("2 of 6 frames"), 2)

    def test_bad_pixels(self):
        """A cosmic ray is left out and counted; a file of bad pixels changes the fit; frames in another unit are too good."""
        frames = numpy.load(self.folder / "f.npy").astype(float)
        frames[1, 20, 30] += 2e4
        frames[2] /= 2
        numpy.save(self.folder / "hit.npy", frames)
        done = self.run_program("encode", "--fit", "s.json", "hit.npy")
        rows = self.rows(done.stdout)
        self.assertEqual([row["bad_pixels"] for row in rows], ["0", "1", "0", "0", "0", "0"])
        self.assertEqual([row["goodness"] for row in rows[:3]], ["good", "good", "too good"])
        self.assertIn("hit.npy: frame 2: ", done.stderr)
        bad = numpy.zeros((64, 64), bool)
        bad[20, 30] = bad[40] = True
        numpy.save(self.folder / "bad.npy", bad)
        masked = self.rows(self.run_program("encode", "--fit", "s.json", "hit.npy", "--bad-pixels", "bad.npy").stdout)
        self.assertEqual(masked[1]["bad_pixels"], "0")
        self.assertGreater(float(masked[1]["separation_sigma_px"]), float(rows[1]["separation_sigma_px"]))
        for text, *arguments in (("none.npy", "--fit", "s.json", "--bad-pixels", "none.npy"),
                                 ("--fit or --template", "--weights", "w.tlmw", "--bad-pixels", "bad.npy")):
            failed = self.run_program("encode", *arguments, "f.npy")
            self.assertEqual((failed.returncode > 0, text in failed.stderr), (True, True), failed.stderr)

    def test_bad_pixels_of_a_file(self):
        """Their counts change nothing, whatever estimates: as the option, and as a key of the scene."""
        scene = {**SCENE, "binary": {"separation_arcsec": 7, "position_angle_deg": 30}}
        self.write("s.json", scene)
        self.simulate("0:6", "f.npy")
        bad = numpy.zeros((64, 64), numpy.uint8)
        bad[12] = bad[:, 40] = 1  # more than are found in a frame
        numpy.save(self.folder / "bad.npy", bad)
        self.write("masked.json", {**scene, "detector": {**scene["detector"], "bad_pixels": "bad.npy"}})
        frames = numpy.load(self.folder / "f.npy")
        (self.folder / "dead").mkdir()
        numpy.save(self.folder / "dead/f.npy", numpy.where(bad, 0, frames))
        tracked = ("--cadence", "172800", "--epoch", "0", "--mission-days", "12", "--state")
        for number, (command, scene_option, *options) in enumerate((
                ("encode", "--fit"), ("track", "--template", *tracked), ("calibrate", "", "--free", "scale", "--out"))):
            made = {}
            for name, scene_file, option in (("all", "s.json", []), ("option", "s.json", ["--bad-pixels", "bad.npy"]),
                                             ("key", "masked.json", [])):
                for file in ("f.npy", "dead/f.npy") if name == "option" else ("f.npy",) if name == "all" else ("dead/f.npy",):
                    out = [f"{name}{number}{file[0]}.json"] if options else []
                    words = [word for word in (scene_option, scene_file) if word]
                    done = self.run_program(command, *words, *options, *out, *option, file)
                    text = self.values_of(out[0]) if command == "calibrate" else done.stdout
                    made[name, file] = text.replace("dead/", "")
            self.assertNotEqual(made["all", "f.npy"], made["option", "f.npy"], command)
            self.assertEqual(made["option", "f.npy"], made["option", "dead/f.npy"], command)
            self.assertEqual(made["option", "f.npy"], made["key", "dead/f.npy"], command)

    def values_of(self, name):
        """Those that a calibration has fitted, if it could."""
        path = self.folder / name.replace(".json", ".calibration.json")
        return json.dumps(json.loads(path.read_text())["windows"][0]["parameters"]) if path.exists() else ""

    def test_refusals(self):
        numpy.save(self.folder / "small.npy", numpy.ones((1, 8, 8)))
        self.refuse_all(
            (2, "--weights, --template and --fit", "f.npy"),
            (2, "--weights, --template and --fit", "--fit", "s.json", "--template", "s.json", "f.npy"),
            (2, "--free scale: ", "--template", "s.json", "--free", "scale", "f.npy"),
            (2, "--cadence 60: ", "--template", "s.json", "--cadence", "60", "f.npy"),
            *((2, f'--free: "{name}": ', "--fit", "s.json", "--free", name, "f.npy") for name in ("scal", "roll", "focus")),
            (3, "small.npy: ", "--fit", "s.json", "small.npy"), command=("encode",))


class Track(Fit):
    def track(self, *arguments):
        return self.succeed("track", "--mission-days", "200", "--cadence", str(2 * 86400), *arguments)

    def test_values_and_sigmas_are_those_of_encode(self):
        """The sigma of the folder is the median of the frames', not the bound of stars at rest."""
        lines = [json.loads(line) for line in self.track("--fit", "s.json", "--state", "st", "f.npy").splitlines()]
        values = [line["value"] for line in lines if line["schema"] == "toliman-frame/2"]
        self.assertEqual(values, [float(row["displacement_px"]) for row in self.fit("f.npy")])
        sigmas = sorted(json.loads(line)["sigma"] for line in self.succeed("status", "st", "--records").splitlines())
        sigma = json.loads(self.succeed("status", "st", "--json"))["sigma"]
        self.assertEqual(sigma, sigmas[3])
        self.assertIn(f" {sigma:.3g} px", self.succeed("status", "st"))

    # promise: calibrations-are-not-mixed
    def test_another_scene_or_estimator_is_refused(self):
        self.track("--fit", "s.json", "--state", "st", "f.npy")
        self.write("other.json", {**SCENE, "cadence": {**SCENE["cadence"], "peak_photons": 1.1e5}})
        for estimator in (("--fit", "other.json"), ("--fit", "s.json", "--free", "scale"), ("--template", "s.json")):
            with self.subTest(estimator):
                done = self.run_program("track", "--state", "st", "--cadence", str(2 * 86400), *estimator, "f.npy")
                self.assertEqual((done.returncode, done.stdout, "ids 0 to 5 of session f\n" in done.stderr), (2, "", True), done.stderr)


if __name__ == "__main__":
    unittest.main()
