"""calibrate: fitted values against the truth of simulated frames, resumed and stopped runs, windows, refusals."""
import copy
import functools
import json
import pathlib
import resource
import shutil
import signal
import subprocess
import tempfile
import unittest

import numpy
from program import PROGRAM, ProgramTest

SIDE, CELLS = 48, 40
SCENE = {
    "schema": "toliman-scene/1",
    "telescope": {"aperture_m": 0.125, "secondary_m": 0.01875, "pupil_samples": CELLS,
                  "struts": {"count": 3, "width_m": 0.002},
                  "mask": {"kind": "spiral", "edges": "area", "opd_nm": 297.5, "terms": [{"a": 1, "f": 1.2, "m": -5, "p": 1}]}},
    "band": {"min_nm": 550, "max_nm": 600, "step_nm": 25},
    "stars": {"A": {"spectrum": {"kind": "blackbody", "temperature_k": 5790}, "photons_per_s": 7.5e8},
              "B": {"spectrum": {"kind": "blackbody", "temperature_k": 5260}, "photons_per_s": 2.5e8}},
    "binary": {"date": 2027, "orbit": "alpha-cen", "moving": True},
    "cadence": {"frames": 12, "interval_days": 20, "exposure_s": 10},
    "detector": {"shape": [SIDE, SIDE], "pixel_scale_arcsec": 0.4},
    "noise": {"photon": True, "read_e": 2.5, "seed": 7},
    "accuracy": 1e-7,
}
FREE = "scale focus zernike_5-9"
TRUTH = {"scale": 1 / 1.0005 - 1, "focus": 3, "zernike_5": 0, "zernike_6": -8, "zernike_7": 0, "zernike_8": 5, "zernike_9": 2}
FILES = ["fitted.calibration.json", "fitted.chi_map.npy", "fitted.json", "fitted.opd_change.npy", "fitted.residual_after.npy",
         "fitted.residual_before.npy"]


def with_optics(scene, **zernikes):
    """The scene of another telescope: aberrations {"zernike_8": nm}."""
    changed = copy.deepcopy(scene)
    changed["telescope"]["aberrations"] = {"zernike_rms_nm": {name.split("_")[1]: nm for name, nm in zernikes.items()}}
    return changed


def call(folder, *arguments):
    return subprocess.run([PROGRAM, *arguments], cwd=folder, capture_output=True, text=True, check=True)


@functools.lru_cache(None)
def finished():
    """A folder with scenes, frames and their calibration, and what the latter printed."""
    kept = tempfile.TemporaryDirectory()
    folder = pathlib.Path(kept.name)
    truth = with_optics(SCENE, zernike_4=3, zernike_6=-8, zernike_8=5, zernike_9=2)
    truth["detector"]["pixel_scale_arcsec"] *= 1.0005
    for name, scene in (("s.json", SCENE), ("truth.json", truth)):
        (folder / name).write_text(json.dumps(scene))
    call(folder, "simulate", "truth.json", "--frames", "0:6", "--out", "f.fits")
    return kept, folder, call(folder, "calibrate", "s.json", "f.fits", "--out", "fitted.json", "--free", FREE)


class Calibrate(ProgramTest):
    def setUp(self):
        super().setUp()
        _, folder, self.done = finished()
        for name in ("s.json", "truth.json", "f.fits"):
            shutil.copy(folder / name, self.folder)

    def take_finished(self):
        """The results of the calibration of f.fits with FREE."""
        for name in FILES:
            shutil.copy(finished()[1] / name, self.folder)

    def write(self, name, scene):
        (self.folder / name).write_text(json.dumps(scene))

    def simulate(self, scene, frames, name):
        self.succeed("simulate", scene, "--frames", frames, "--out", name)

    def calibrate(self, *arguments, frames="f.fits", free=FREE, out="fitted.json"):
        return self.run_program("calibrate", "s.json", frames, "--out", out, "--free", free, *arguments)

    def result(self, name="fitted.calibration.json"):
        return json.loads((self.folder / name).read_text())

    def new_files(self):
        return sorted(path.name for path in self.folder.iterdir() if path.name not in ("s.json", "truth.json", "f.fits"))


class Detector(Calibrate):
    def test_the_response_is_in_the_fitted_scene(self):
        """All frames are used, the arrays are next to the scene, and other commands use them."""
        done = self.calibrate("--detector", "--response-rms", "0.005")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("response iteration", done.stderr)
        self.assertIn("pixels remain at the prior", done.stdout)
        scene, result = self.result("fitted.json"), self.result()
        self.assertEqual(scene["detector"]["response"], "fitted.response.npy")
        response, sigma = (numpy.load(self.folder / f"fitted.{name}.npy") for name in ("response", "response_sigma"))
        self.assertEqual((response.shape, sigma.shape), ((SIDE, SIDE),) * 2)
        self.assertTrue(0 < sigma.min() < sigma.max() <= 0.005)
        self.assertLess(numpy.abs(response - 1).max(), 0.03)
        self.assertEqual(result["response_pixels"], (sigma <= 0.7 * 0.005).sum())
        self.assertGreater(result["response_iterations"], 0)
        self.succeed("encode", "--fit", "fitted.json", "f.fits")
        response[0, 0] = 0
        numpy.save(self.folder / "fitted.response.npy", response)
        self.assertIn("element [0][0]", self.run_program("encode", "--fit", "fitted.json", "f.fits").stderr)

    def test_mistakes(self):
        for arguments, words in ((("--response-rms", "0.01"), "--detector"),
                                 (("--detector", "--windows", "30"), "--detector")):
            done = self.calibrate(*arguments)
            self.assertEqual(done.returncode, 2)
            self.assertIn(words, done.stderr)


class Results(Calibrate):
    def test_values_are_the_truth(self):
        self.take_finished()
        done = self.done
        self.assertTrue(done.stdout.startswith("converged; the model is complete\n"), done.stdout)
        self.assertRegex(done.stderr, r"calibrate: parameters iteration 2: chi-square [0-9.]+, ")
        names = {path.name for path in finished()[1].iterdir()} - {"s.json", "truth.json", "f.fits"}
        self.assertEqual(sorted(names), FILES)
        result = self.result()
        (window,) = result["windows"]
        self.assertEqual([one["name"] for one in window["parameters"]], list(TRUTH))
        for one in window["parameters"]:
            with self.subTest(one["name"]):
                self.assertLess(abs(one["value"] - TRUTH[one["name"]]), 4.5 * one["sigma"])
                self.assertIn(f"\n{one['name']} ", done.stdout)
        sigmas = [one["sigma"] for one in window["parameters"]]
        numpy.testing.assert_allclose(numpy.diag(window["covariance"]), numpy.square(sigmas), rtol=1e-12)
        self.assertEqual((result["frames"], result["complete"], result["held"]), (6, True, False))
        self.assertEqual(len(result["steps"]), result["iterations"])
        self.assertEqual([(one["file"], one["frame"], one["time_days"]) for one in result["separations"]],
                         [("f.fits", k, 20 * k) for k in range(6)])

    def test_the_fitted_scene_fits_the_frames(self):
        """Each separation is that of encode with the fitted scene, and has its noise only."""
        self.take_finished()
        text = self.succeed("encode", "--fit", "fitted.json", "f.fits").splitlines()
        rows = [dict(zip(text[0].split(","), line.split(","))) for line in text[1:]]
        for row, one in zip(rows, self.result()["separations"]):
            self.assertLess(abs(float(row["separation_px"]) - one["separation_px"]), 1e-5)
            self.assertLess(abs(float(row["displacement_px"])), 5 * one["separation_sigma_px"])
            self.assertEqual(row["flags"], "")
        nominal = self.succeed("encode", "--fit", "s.json", "f.fits").splitlines()[1:]
        self.assertGreater(min(abs(float(line.split(",")[2])) for line in nominal), 100 * one["separation_sigma_px"])

    def test_arrays(self):
        self.take_finished()
        before, after, chi = (numpy.load(self.folder / f"fitted.{name}.npy")
                              for name in ("residual_before", "residual_after", "chi_map"))
        self.assertEqual((before.shape, after.shape, chi.shape), ((SIDE, SIDE),) * 3)
        self.assertGreater(before.std(), 5)
        self.assertLess(abs(after.std() - 1), 0.1)
        self.assertLess(abs(chi.mean() - 1), 0.1)
        opd = numpy.load(self.folder / "fitted.opd_change.npy")
        self.assertEqual(opd.shape, (1, CELLS, CELLS))
        nm = 1e9 * opd[opd != 0].std()
        self.assertLess(abs(nm - numpy.sqrt(3**2 + 8**2 + 5**2 + 2**2)), 1.5)  # coefficients are of the full aperture

    def test_json_and_threads(self):
        text = self.succeed("calibrate", "s.json", "f.fits", "--out", "three.json", "--free", FREE, "--json", "--threads", 3)
        self.assertEqual(json.loads(text), self.result("three.calibration.json"))
        self.take_finished()
        for key in ("windows", "separations", "steps"):
            one, other = json.loads(text)[key], self.result()[key]
            self.assertEqual(json.dumps(one).replace("three.", "fitted."), json.dumps(other))

    def test_an_incomplete_model(self):
        done = self.calibrate(free="scale focus")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("warning: ", done.stderr)
        self.assertIn("telescope.pupil_samples = 40", done.stderr)
        result = self.result()
        self.assertEqual((result["complete"], result["goodness"], result["lacks"], result["attempts"]),
                         (False, "poor", ["pupil samples", "spectral modes", "map"], []))
        self.assertEqual([int(name in done.stderr) for name in (*result["lacks"], "--map", "--improve")], [1] * 5)
        self.assertEqual([name in done.stdout for name in ("use: toliman", "--improve", "--detector")], [False, True, True])
        self.check_travels(result)

    def check_travels(self, result):
        """Each command that uses the scene warns once; a scene of a complete calibration is used without a word."""
        calibration = json.loads((self.folder / "fitted.json").read_text())["calibration"]
        self.assertEqual([calibration[key] for key in ("goodness", "complete", "frames", "chi_square")],
                         ["poor", False, 6, result["chi_square"]])
        shutil.copy(finished()[1] / "fitted.json", self.folder / "good.json")
        track = ("track", "--state", "st", "--mission-days", 300, "--free", "none", "f.fits", "--fit")
        for wanted, *command in (*((1, *words, "fitted.json") for words in (("encode", "f.fits", "--fit"), ("plan",), ("budget",), track,
                                                                            ("simulate", "--frames", "0:1", "--out", "x.npy"))),
                                 (0, "encode", "f.fits", "--fit", "good.json")):
            with self.subTest(command):
                done = self.run_program(*command)
                self.assertEqual((done.returncode, done.stderr.count(": its calibration")), (0, wanted), done.stderr)

    def test_names_are_added(self):
        """+NAME: to the default parameters that the scene has, or another prior of one of these."""
        lists = []
        for free in ((), ("--free", "+spectrum_a_1=0.05 +anisotropy")):
            done = self.run_program("calibrate", "truth.json", "f.fits", "--out", "fitted.json", *free)
            self.assertIn(done.returncode, (0, 4), done.stderr)
            lists.append([(one["name"], one["prior_sigma"]) for one in self.result()["windows"][0]["parameters"]])
        self.assertIn(("spectrum_a_1", 0.1), lists[0])
        wanted = [(name, 0.05 if name == "spectrum_a_1" else sigma) for name, sigma in lists[0]]
        self.assertEqual(lists[1], wanted + [("anisotropy", 0.01)])

    def test_noise_that_is_too_large(self):
        self.write("s.json", {**SCENE, "noise": {"photon": True, "read_e": 3000, "seed": 7}})
        done = self.calibrate()
        self.assertEqual([name in done.stderr for name in ("noise.read_e", "detector.bias_dn", "detector.gain_e_per_dn")], [True] * 3)
        self.assertEqual((self.result()["complete"], self.result()["goodness"]), (False, "too good"))

    def test_improve(self):
        """A model with whole cells for a mask with edges."""
        scene = copy.deepcopy(SCENE)
        scene["telescope"]["mask"]["edges"] = "cell"
        self.write("s.json", scene)
        done = self.calibrate("--improve")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("\nadded to the model: mask edges\n", done.stdout)
        (attempt,) = self.result()["attempts"]
        self.assertEqual((attempt["change"], attempt["kept"], self.result()["changes"]), ("mask edges", True, ["mask edges"]))
        self.assertEqual(json.loads((self.folder / "fitted.json").read_text())["telescope"]["mask"]["edges"], "area")
        self.succeed("encode", "--fit", "fitted.json", "f.fits")

    def test_parameters_that_are_left_out_are_named(self):
        scene = copy.deepcopy(SCENE)
        scene["telescope"]["mask"]["edges"] = "cell"
        scene["stars"]["B"]["spectrum"] = {"kind": "lines", "wavelength_nm": [560, 590], "weight": [1, 1]}
        self.write("s.json", scene)
        self.simulate("s.json", "0:2", "cell.fits")
        done = self.run_program("calibrate", "s.json", "cell.fits", "--out", "fitted.json")
        self.assertEqual(done.returncode, 0, done.stderr)
        for name, reason in (("mask_rotation", 'needs a spiral mask with mask.edges = "area"'),
                             ("temperature_b", "the spectrum consists of lines")):
            self.assertEqual((f" {name}: {reason}\n" in done.stdout, f"warning: {name} " in done.stderr), (True, True))
            self.assertIn({"name": name, "reason": reason}, self.result()["left_out"])

    def test_several_files_and_cadence(self):
        """Frames of each file have the times of their numbers."""
        cube = numpy.stack([numpy.asarray(frame) for frame in self.cube()])
        for name, part in (("a.npy", cube[:3]), ("b.npy", 1.01 * cube[:4])):
            numpy.save(self.folder / name, part)
        done = self.run_program("calibrate", "s.json", "a.npy", "b.npy", "--out", "fitted.json", "--free", FREE, "--cadence",
                                str(20 * 86400))
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual([(one["file"], one["time_days"]) for one in self.result()["separations"]],
                         [("a.npy", 0), ("a.npy", 20), ("a.npy", 40), ("b.npy", 0), ("b.npy", 20), ("b.npy", 40), ("b.npy", 60)])

    def cube(self):
        self.simulate("truth.json", "0:4", "cube.npy")
        return numpy.load(self.folder / "cube.npy")


class Choice(Calibrate):
    """Frames that are chosen: good ones, spread in time and pointing."""

    def chosen(self, cube, *arguments, cadence=86400):
        numpy.save(self.folder / "cube.npy", cube)
        done = self.calibrate("--cadence", cadence, *arguments, frames="cube.npy", free="focus")
        self.assertEqual(done.returncode, 0, done.stderr)
        return [one["frame"] for one in self.result()["separations"]], done.stderr

    def setUp(self):
        super().setUp()
        self.simulate("truth.json", "0:12", "many.npy")
        self.cube = numpy.load(self.folder / "many.npy").astype(float)

    def test_bad_frames_are_left_out(self):
        faults = {1: "row 2, column 3: must be a finite number", 4: "24 rows of zeros", 6: "3.", 7: "0."}
        self.cube[1, 2, 3] = numpy.nan
        self.cube[4, 24:] = 0
        self.cube[6] *= 3
        self.cube[7] *= 0.3
        numpy.save(self.folder / "again.npy", self.cube[:1])
        frames, said = self.chosen(self.cube)
        self.assertEqual(frames, [k for k in range(12) if k not in (1, 4, 6, 7)])
        for frame, fault in faults.items():
            self.assertRegex(said, rf"cube.npy: frame {frame}: {fault}.*left out")
        done = self.run_program("calibrate", "s.json", "cube.npy", "again.npy", "--out", "other.json", "--cadence", "86400",
                                "--free", "focus")
        self.assertIn("toliman: 1 of 13 frames ", done.stderr)

    def test_times_are_spread(self):
        frames, said = self.chosen(self.cube, "--choose", 5)
        self.assertEqual((len(frames), frames[0], frames[-1]), (5, 0, 11))
        self.assertEqual(max(numpy.diff(frames)), 3)
        self.assertIn(" 5 of 12 frames, ", said)
        windows, _ = self.chosen(self.cube, "--choose", 2, "--windows", 4)
        self.assertEqual(windows, [0, 3, 4, 7, 8, 11])

    def test_pointings_are_spread(self):
        """Frames of one time: the first, the one at (3, 3) px, 4.2 px away, then that with the largest least distance."""
        shifts = (0, 0), (1, 0), (0, 4), (4, 0), (3, 3)
        moved = numpy.stack([numpy.roll(self.cube[0], shift, axis=(0, 1)) for shift in shifts])
        frames, _ = self.chosen(moved, "--choose", 3, cadence=1e-6)
        self.assertEqual((len(frames), frames[0], frames[-1]), (3, 0, 4))


class Resume(Calibrate):
    # promises: killed-calibrations-resume, unconverged-scenes-are-not-written
    def test_too_few_iterations(self):
        """No scene is written; the journal is, and a resumed run ends with the bits of an undisturbed one."""
        done = self.calibrate("--iterations", 1)
        self.assertEqual((done.returncode, done.stdout), (4, ""))
        self.assertIn("fitted.part", done.stderr)
        self.assertEqual(self.new_files(), ["fitted.part"])
        resumed = self.calibrate("--resume")
        self.assertEqual(resumed.returncode, 0, resumed.stderr)
        self.assertIn("iteration 1, chi-square ", resumed.stderr)
        self.assertEqual(self.new_files(), FILES)
        parts, scene = self.result(), (self.folder / "fitted.json").read_bytes()
        self.take_finished()
        whole = self.result()
        del parts["provenance"], whole["provenance"]
        self.assertEqual(parts, whole)
        self.assertEqual(scene, (self.folder / "fitted.json").read_bytes())

    # promise: killed-calibrations-resume
    def test_a_full_disk(self):
        """It stops the command while it writes the journal, which a resumed run continues."""
        full = {"preexec_fn": lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (4000, 4000))}
        done = self.run_program("calibrate", "s.json", "f.fits", "--out", "fitted.json", "--free", FREE, **full)
        self.assertEqual(done.returncode, 6, done.stderr)
        self.assertEqual(self.new_files(), ["fitted.part"])
        self.assertEqual(self.calibrate("--resume").returncode, 0)
        self.assertEqual(self.new_files(), FILES)

    def test_other_inputs(self):
        """They are refused; without --resume the journal is replaced."""
        self.calibrate("--iterations", 1)
        self.refuse(2, "fitted.part: ", arguments=("calibrate", "s.json", "f.fits", "--out", "fitted.json", "--free", "scale",
                                                   "--resume"))
        self.calibrate("--iterations", 1, free="focus")
        self.assertEqual(self.calibrate("--resume", free="focus").returncode, 0)

    # promise: stopped-work-resumes
    def test_a_signal_keeps_the_state(self):
        self.take_finished()
        finished = (self.folder / "fitted.json").read_bytes()
        command = ("calibrate", "s.json", "f.fits", "--out", "fitted.json", "--free", FREE + " mask_rotation zernike_10-21")
        run = subprocess.Popen([PROGRAM, *command], cwd=self.folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        for line in run.stderr:
            if "iteration" in line:
                break
        run.send_signal(signal.SIGTERM)
        out, errors = run.communicate(timeout=60)
        if run.returncode == 0:
            self.skipTest("ended before the signal")
        self.assertEqual((run.returncode, out), (143, ""))
        self.assertEqual((self.folder / "fitted.json").read_bytes(), finished)
        self.assertIn("fitted.part", self.new_files())
        self.succeed(*command, "--resume")
        self.assertEqual(self.new_files(), FILES)


class Windows(Calibrate):
    def test_list_of_scenes(self):
        """Optics that change linearly from one start of a window to the next."""
        ends = {0: {"zernike_8": 5, "zernike_9": 2}, 100: {"zernike_8": 6, "zernike_9": 1}}
        for k in range(6):
            share = k / 5
            self.write("now.json", with_optics(SCENE, **{name: (1 - share) * ends[0][name] + share * ends[100][name]
                                                         for name in ends[0]}))
            self.simulate("now.json", f"{k}:{k + 1}", f"{k}.npy")
        numpy.save(self.folder / "all.npy", numpy.concatenate([numpy.load(self.folder / f"{k}.npy") for k in range(6)]))
        done = self.run_program("calibrate", "s.json", "all.npy", "--out", "fitted.json", "--free", "zernike_7-10", "--windows",
                                100, "--smoothness", 1)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(json.loads((self.folder / "fitted.json").read_text()),
                         {"schema": "toliman-calibration/1", "windows": [{"first_days": 0, "scene": "fitted.1.json"},
                                                                         {"first_days": 100, "scene": "fitted.2.json"}]})
        result = self.result()
        self.assertEqual([window["scene"] for window in result["windows"]], ["fitted.1.json", "fitted.2.json"])
        for window, truth in zip(result["windows"], ends.values()):
            for one in window["parameters"]:
                self.assertLess(abs(one["value"] - truth.get(one["name"], 0)), 4.5 * one["sigma"])
        text = self.succeed("encode", "--fit", "fitted.json", "all.npy").splitlines()
        self.assertNotIn("outlier", "".join(text))
        for k, scene in ((0, "fitted.1.json"), (5, "fitted.2.json")):  # at the starts
            self.assertEqual(text[1 + k], self.succeed("encode", "--fit", scene, "all.npy").splitlines()[1 + k])

    def test_a_last_start_without_frames(self):
        """The last window has a start alone; an incomplete calibration is told once, not for each window."""
        self.calibrate("--windows", 40)
        listed = json.loads((self.folder / "fitted.json").read_text())["windows"]
        scenes = [json.loads((self.folder / one["scene"]).read_text()) for one in listed]
        self.assertEqual(scenes[-1]["calibration"]["frames"], 0)
        for one, scene in zip(listed, scenes):
            scene["calibration"]["complete"] = False
            self.write(one["scene"], scene)
        done = self.run_program("encode", "--fit", "fitted.json", "f.fits")
        self.assertEqual((done.returncode, done.stderr.count(": its calibration")), (0, 1), done.stderr)

    def test_frames_calibrate_themselves(self):
        """The default of track with a calibrated scene: named once, the same with --free self, another estimator with none."""
        self.take_finished()
        track = ("track", "--state", "st", "--fit", "fitted.json", "--mission-days", 300, "f.fits")
        told = self.run_program(*track).stderr
        self.assertIn("jitter_xx jitter_yy jitter_xy focus zernike_5 zernike_6 zernike_7 zernike_8 zernike_9 zernike_10 "
                      "zernike_11 (--free self)\n", told)
        again = self.run_program(*track, "--free", "self")
        self.assertEqual((again.returncode, "calibrated" in again.stderr), (0, False), again.stderr)
        other = self.run_program(*track, "--free", "none")
        self.assertEqual((other.returncode, "--free" in other.stderr), (2, True), other.stderr)

    def test_damaged_lists(self):
        one = {"first_days": 0, "scene": "s.json"}
        other = copy.deepcopy(SCENE)
        other["cadence"]["interval_days"] = 7
        self.write("other.json", other)
        for windows, text in (([], "windows"), ([one, {"first_days": 5}], "windows[1].scene"), ([one, one], "first_days[1] = 0"),
                              ([{"scene": "s.json"}], "windows[0].first_days"),
                              ([one, {"first_days": 5, "scene": "other.json"}], "other.json: cadence"),
                              ([{"first_days": 0, "scene": "none.json"}], "none.json: ")):
            self.write("list.json", {"schema": "toliman-calibration/1", "windows": windows})
            with self.subTest(text):
                self.refuse(3, text, arguments=("encode", "--fit", "list.json", "f.fits"))
        self.write("list.json", {"schema": "toliman-calibration/1",
                                 "windows": [{"first_days": k, "scene": "s.json"} for k in (0, 50)]})
        self.refuse(2, "2 windows", arguments=("train", "list.json", "--bank", "frames", "--out", "x.tlmb"))


class Refusals(Calibrate):
    def test_messages(self):
        frames = numpy.full((2, SIDE, SIDE), 1000.0)
        frames[0, 3, 4], frames[1, 3, 4] = 2000, numpy.nan
        numpy.save(self.folder / "nan.npy", frames)
        numpy.save(self.folder / "small.npy", numpy.ones((2, 8, 8)))
        numpy.save(self.folder / "one.npy", numpy.ones((1, SIDE, SIDE)))
        (self.folder / "notes.json").write_text('{"mine": 1}')
        out = ("--out", "fitted.json")
        self.refuse_all(
            *((3, f"{name}: ", name, *out) for name in ("missing.fits", "small.npy", "one.npy")),
            (3, "nan.npy: frame 1: row 3, column 4: ", "nan.npy", *out),
            *((2, text, "f.fits", *out, option, value)
                for text, option, value in (('--free: "scal": ', "--free", "scal"),
                    ('--free: "shift_x"', "--free", "shift_x"),
                    ("spectrum_a_1", "--free", "+spectrum_a_1 +spectrum_a_1"),
                    ("--free", "--free", "scale +spectrum_a_1"), ("--map-rms 3: ", "--map-rms", "3"),
                    ("--smoothness 1: ", "--smoothness", "1"))),
            *((code, text, "f.fits", "--out", name)
                for code, text, name in ((2, "--out fitted: ", "fitted"), (2, "s.json: ", "s.json"),
                    (6, "none/fitted.json: ", "none/fitted.json"), (6, "notes.json: ", "notes.json"))),
            command=("calibrate", "s.json"))


if __name__ == "__main__":
    unittest.main()
