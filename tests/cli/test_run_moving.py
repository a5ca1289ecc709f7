"""toliman run on stars that move along their orbit and by their pointing: the fit alone, against encode --fit."""
import json
import shutil
import unittest

import numpy
from pages import Reader, Recorder, ReportTest
from shared_run import rows_of, shared_run
from test_fit import SCENE

FRAMES, PERIOD, AMPLITUDE = 60, 40, 5e-3
NETWORK_KEYS = ("latent_sigma_px", "cosine", "mmse", "photon_floor", "mssim", "decoder", "residuals", "template",
                "untrained")
FILES = ["periodogram.csv", "result.json", "scene.json", "series.csv"]
FIGURES = ["series", "folded", "periodogram", "pupil", "frame", "displacement"]


def moving_scene(**groups):
    """Alpha Centauri on 64x64 px, which moves by 0.3 px along its orbit and as much by the pointing of each frame."""
    return {**SCENE, "name": "moving", "cadence": {**SCENE["cadence"], "frames": FRAMES},
            "signal": {**SCENE["signal"], "amplitude_px": AMPLITUDE, "period_days": PERIOD},
            "systematics": {"pointing_rms_px": 0.3, "roll_rms_deg": 0.01}, **groups}


class Moving(ReportTest):
    def write(self, name="moving.json", **groups):
        (self.folder / name).write_text(json.dumps(moving_scene(**groups)))

    def setUp(self):
        super().setUp()
        self.write()

    def run_scene(self, *options, out="r"):
        done = self.run_program("run", "moving.json", "--out", out, *options)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done

    def result(self, folder="r"):
        return json.loads((self.folder / folder / "result.json").read_text())

    def encoded(self, scene, seed, frames, column):
        """A column of encode --fit on simulated frames."""
        for command in (("simulate", scene, "--seed", seed, "--frames", f"0:{frames}", "--out", "f.npy"),
                        ("encode", "--fit", "moving.json", "f.npy")):
            done = self.run_program(*command)
            self.assertEqual(done.returncode, 0, done.stderr)
        head, *lines = done.stdout.splitlines()
        return numpy.array([float(line.split(",")[head.split(",").index(column)]) for line in lines])


class Run(Moving):
    def test_the_fit_finds_the_period(self):
        text = self.run_scene("--controls", "quick").stdout
        result, series, power = self.result(), rows_of(self.folder / "r/series.csv"), rows_of(self.folder / "r/periodogram.csv")
        fit = result["fit"]
        self.assertEqual(result["estimator"], "fit")
        self.assertLess(abs(result["period_days"] - PERIOD), 3 * result["period_error_days"])
        self.assertLess(result["log10_fap"], -30)
        self.assertGreater(result["no_signal"]["log10_fap"], -3)
        self.assertEqual([fit[key] for key in ("period_days", "log10_fap", "no_signal_log10_fap", "efficiency")],
                         [result["period_days"], result["log10_fap"], result["no_signal"]["log10_fap"], result["efficiency"]])
        self.assertAlmostEqual(fit["efficiency"], 1, delta=0.15)  # of 200 frames: 5 %
        self.assertAlmostEqual(fit["efficiency_error"] / fit["efficiency"], 1 / 20, delta=1e-12)
        self.assertAlmostEqual(fit["chi_square"], 1, delta=4 * numpy.sqrt(2 / (FRAMES * 64**2)))
        self.assertEqual(fit["lost"], 0)
        self.assertEqual([result[key] for key in NETWORK_KEYS], [None] * len(NETWORK_KEYS))
        self.assertEqual(sorted(path.name for path in (self.folder / "r").iterdir()), FILES)
        self.assertEqual(list(series), ["frame", "t", "true", "fit"])
        self.assertEqual(list(power), ["frequency", "true", "fit"])
        self.assertAlmostEqual(power["frequency"][power["fit"].argmax()], 1 / PERIOD, delta=result["grid"]["df"])
        self.assertIn("period found  40", text)
        self.assertNotIn("template", text)
        slope = numpy.polyfit(series["true"], series["fit"], 1)[0]
        self.assertAlmostEqual(slope, 1, delta=0.1)
        numpy.testing.assert_array_equal(self.encoded("moving.json", 7, FRAMES, "displacement_px"), series["fit"])
        sigma = self.encoded("moving.json", 7, FRAMES, "separation_sigma_px")
        self.assertAlmostEqual(numpy.sqrt((sigma**2).mean()) / fit["bound_px"], 1, delta=0.01)

    def test_controls_move_as_the_scene_does(self):
        """Frames 0 ... 59 without signal again and again, each time with another seed."""
        self.run_scene("--controls", "quick")
        self.write("still.json", signal={"kind": "none"})
        values = numpy.concatenate([self.encoded("still.json", 7 + (k << 32), min(FRAMES, 200 - 60 * (k - 1)), "displacement_px")
                                    for k in (1, 2, 3, 4)])
        self.assertEqual(len(values), 200)
        self.assertAlmostEqual(self.result()["fit"]["sigma_px"] / values.std(ddof=1), 1, delta=1e-9)

    def test_without_controls_over_the_results_of_a_network(self):
        """The network's files do not remain next to results of the fit."""
        shutil.copytree(shared_run(), self.folder / "r")
        text = self.run_scene("--controls", "none").stdout
        self.assertIn("controls      none: ", text)
        result = self.result()
        self.assertEqual([result["fit"][key] for key in ("sigma_px", "efficiency", "no_signal_log10_fap")], [None] * 3)
        self.assertEqual(sorted(path.name for path in (self.folder / "r").iterdir()), FILES)

    def test_lost_frames(self):
        """Stars that the pointing throws out of the frame."""
        self.write(systematics={"pointing_rms_px": 8})
        done = self.run_scene("--controls", "quick")
        lost = int(numpy.isnan(rows_of(self.folder / "r/series.csv")["fit"]).sum())
        self.assertGreater(lost, 0)
        self.assertEqual(self.result()["fit"]["lost"], lost)
        self.assertIn(f" {lost} of 60 frames", done.stderr)
        time = Recorder(self.folder / "r").figures["series"].axes[0].get_lines()[0].get_xdata()
        self.assertEqual(len(time), FRAMES - lost)

    def test_no_frame_is_fitted(self):
        """Stars that are too faint."""
        self.write(cadence={**SCENE["cadence"], "frames": FRAMES, "peak_photons": 1e-2})
        done = self.run_program("run", "moving.json", "--out", "x")
        self.assertEqual((done.returncode, done.stdout), (2, ""))
        self.assertIn("moving.json: ", done.stderr)
        self.assertFalse((self.folder / "x").exists())

    def test_what_moves(self):
        """The orbit alone, the roll alone; a scene that only jitters needs the network's frames."""
        at_rest = {"separation_arcsec": 7, "position_angle_deg": 30}
        for groups in ({"systematics": {}}, {"binary": at_rest, "systematics": {"roll_rms_deg": 0.01}}):
            self.write(**groups)
            self.run_scene("--controls", "none")
            self.assertEqual(self.result()["estimator"], "fit")
        self.write(binary=at_rest, systematics={"jitter_sigma_px": 0.1})
        self.refuse(2, "[256, 256] px", arguments=("run", "moving.json", "--out", "x"))

    def test_bank_of_networks(self):
        """In frames of 256x256 px, of one date: nine networks, the latents of which are those of their file."""
        self.write(binary={"separation_arcsec": 7, "position_angle_deg": 30}, detector={**SCENE["detector"], "shape": [256, 256]},
                   telescope={**SCENE["telescope"], "pupil_samples": 128}, cadence={**SCENE["cadence"], "frames": 30}, signal={**SCENE["signal"], "amplitude_px": AMPLITUDE, "period_days": 15})
        text = self.run_scene("--controls", "quick").stdout
        result, series, power = self.result(), rows_of(self.folder / "r/series.csv"), rows_of(self.folder / "r/periodogram.csv")
        bank, fit = result["bank"], result["fit"]
        self.assertEqual((result["estimator"], bank["networks"], bank["dates"], bank["places"]), ("bank", 9, 1, 9))
        self.assertEqual([bank[key] for key in ("period_days", "log10_fap", "no_signal_log10_fap", "efficiency", "sigma_px")],
                         [result["period_days"], result["log10_fap"], result["no_signal"]["log10_fap"], result["efficiency"],
                          result["latent_sigma_px"]])
        self.assertLess(abs(result["period_days"] / 15 - 1), 0.05)
        self.assertEqual(list(series), ["frame", "t", "true", "latent", "efficiency", "fit"])
        self.assertEqual(list(power), ["frequency", "power", "true", "fit"])
        self.assertEqual(bank["least_efficiency"], series["efficiency"].min())
        self.assertAlmostEqual(bank["mean_efficiency"], series["efficiency"].mean(), delta=1e-12)
        self.assertGreater(bank["least_efficiency"], 0.9)
        self.assertAlmostEqual(bank["efficiency"] / fit["efficiency"], bank["mean_efficiency"], delta=0.05)
        self.assertLess(abs(series["latent"] - series["fit"]).max(), 2 * fit["sigma_px"])
        self.assertGreater(abs(series["latent"] - series["fit"]).max(), 0)
        self.assertIn("bank          9 networks", text)
        done = self.run_program("simulate", "moving.json", "--seed", 7, "--out", "f.npy")
        self.assertEqual(done.returncode, 0, done.stderr)
        done = self.run_program("encode", "--weights", "r/weights.tlmb", "--fit", "moving.json", "f.npy")
        self.assertEqual(done.returncode, 0, done.stderr)
        head, *lines = done.stdout.splitlines()
        column = head.split(",").index("displacement_px")
        numpy.testing.assert_array_equal([float(line.split(",")[column]) for line in lines], series["latent"])
        page = Recorder(self.folder / "r")
        self.assertEqual(list(page.figures)[:5], FIGURES[:3] + ["bank", "pupil"])
        read = Reader(page.html())
        self.assertEqual(read.row("bank")[1], f"{bank['efficiency']:.3f}")
        self.assertEqual(read.row("bank, no signal")[3].replace("−", "-"), f"{result['no_signal']['log10_fap']:.1f}")

    def test_more_dates_than_a_bank_can_have(self):
        """A circular orbit of 20 px radius, once around: 126 px of 0.5 px each, of nine networks."""
        orbit = {"period_years": 1, "semi_major_arcsec": 4, "eccentricity": 0, "inclination_deg": 0, "node_deg": 40,
                 "periastron_deg": 0, "epoch": 2027}
        self.write(binary={"date": 2027, "moving": True, "orbit": orbit}, band={"wavelength_nm": 580},
                   detector={"shape": [256, 256], "pixel_scale_arcsec": 0.2}, systematics={},
                   cadence={**SCENE["cadence"], "frames": 6, "interval_days": 72})
        self.run_scene("--controls", "none")
        result = self.result()
        self.assertEqual((result["estimator"], result["bank"], result["fit"]["lost"]), ("fit", None, 0))

    def test_one_star(self):
        scene = moving_scene(systematics={"pointing_rms_px": 0.3}, signal={**SCENE["signal"], "star": "A"})
        del scene["binary"], scene["stars"]
        scene["stars"] = {"A": SCENE["stars"]["A"]}
        (self.folder / "moving.json").write_text(json.dumps(scene))
        done = self.run_program("run", "moving.json", "--out", "x")
        self.assertEqual((done.returncode, done.stdout), (2, ""))
        self.assertIn("moving.json: stars: ", done.stderr)

    def test_report(self):
        self.run_scene("--controls", "quick")
        result, page = self.result(), Recorder(self.folder / "r")
        self.assertEqual(list(page.figures), FIGURES)
        read = Reader(page.html())
        self.assertIn("Period found: 40", read.text)
        self.assertEqual(read.row("fit")[1], f"{result['fit']['efficiency']:.3f}")
        self.assertEqual(read.row("fit, no signal")[3].replace("−", "-"), f"{result['no_signal']['log10_fap']:.1f}")
        for words in ("template", "network", "decoder", "nan"):
            self.assertNotIn(words, read.text)


if __name__ == "__main__":
    unittest.main()
