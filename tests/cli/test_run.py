"""toliman run: the whole job on the chapter's scene, every figure and control of its result."""
import csv
import json
import math
import unittest

from program import SCENES, ProgramTest


class ChapterRun(ProgramTest):
    def test_figures_and_files(self):
        out = self.succeed("run", SCENES / "chapter.json", "--seed", "3", "--out", "results", "--json")
        files = self.folder / "results"
        self.assertEqual(sorted(p.name for p in files.iterdir()), ["displacement.csv", "images", "periodogram.csv", "result.json", "scene.json", "series.csv", "training.csv", "weights.tlmw"])
        self.assertEqual(out, (files / "result.json").read_text())
        result = json.loads(out)
        self.assertEqual(result["schema"], "toliman-run/2")
        self.assertEqual((result["scene"], result["seed"], result["frames"]), ("chapter", 3, 1095))
        self.assertAlmostEqual(result["amplitude_uas"], 0.2, delta=1e-12)  # 1e-6 px of 0.2 arcsec
        self.assertAlmostEqual(result["crb_px"], 1.239e-6, delta=0.01e-6)
        self.assertLess(abs(result["period_days"] / 365 - 1), 0.04)  # one seed; the median of many is below 1.5 %
        self.assertLess(result["log10_fap"], -40)
        # With 2,000 frames a sigma is known to 1.6 %: three of those on either side.
        self.assertGreater(result["efficiency"], 0.94 * 0.95)
        self.assertLess(result["efficiency"], 1.05)
        self.assertGreater(result["no_signal"]["log10_fap"], -3)
        self.assertGreater(result["untrained"]["log10_fap"], -3)
        self.assertAlmostEqual(result["template"]["sigma_px"] / result["crb_px"], 1, delta=0.05)
        self.assertEqual((result["estimator"], result["fit"]), ("network", None))
        self.assertAlmostEqual(result["mmse"] / result["photon_floor"], 1, delta=0.01)
        self.assertGreater(result["mssim"], 1 - 1e-7)
        self.assertGreater(result["decoder"]["cosine"], 0.95)
        self.assertAlmostEqual(result["decoder"]["gain"], 1, delta=0.05)
        self.assertEqual(
            set(result["timings"]),
            {"setup_s", "train_s", "simulate_s", "encode_s", "fit_s", "period_s", "controls_s", "images_s", "total_s"},
        )
        with open(files / "series.csv") as file:
            rows = list(csv.DictReader(line for line in file if line[0] != "#"))
        self.assertEqual(list(rows[0]), ["frame", "t", "true", "latent", "template"])
        self.assertEqual(len(rows), 1095)
        latent = [float(row["latent"]) for row in rows]
        truth = [float(row["true"]) for row in rows]
        slope = sum(a * b for a, b in zip(latent, truth)) / sum(b * b for b in truth)
        self.assertAlmostEqual(slope, 1, delta=0.25)  # in pixels, right sign; sigma of the slope is 0.055
        with open(files / "periodogram.csv") as file:
            power = list(csv.DictReader(line for line in file if line[0] != "#"))
        self.assertEqual(list(power[0]), ["frequency", "power", "template", "true"])
        self.assertEqual(len(power), result["grid"]["nf"])
        for column, period in (("power", result["period_days"]), ("template", result["template"]["period_days"]),
                               ("true", result["true_series"]["period_days"])):
            top = max(power, key=lambda row: float(row[column]))
            self.assertAlmostEqual(float(top["frequency"]), 1 / period, delta=result["grid"]["df"])
        self.check_truth(result)
        self.check_what_a_report_needs(files, result)

    def check_truth(self, result):
        """The chapter's Table 1 has 0.33 +- 0.05 of the time span; Baluev's FAP of 1e-3 is one that noise rarely has."""
        truth = result["true_series"]
        self.assertAlmostEqual(truth["period_days"], 365, delta=1e-3)
        self.assertAlmostEqual(truth["half_width_period_days"] / 1095, 0.0499, delta=2e-4)
        self.assertLess(truth["log10_fap"], -16000)
        # exp(-N P/2) of some 550 independent frequencies is 1e-3
        self.assertAlmostEqual(result["power_at_fap_1e-3"], 2 / 1095 * math.log(550e3), delta=0.004)

    def check_what_a_report_needs(self, files, result):
        self.assertEqual((files / "scene.json").read_bytes(), (SCENES / "chapter.json").read_bytes())
        self.assertEqual(result["scene_folder"], str(SCENES))
        with open(files / "training.csv") as file:
            losses = [float(row["loss"]) for row in csv.DictReader(line for line in file if line[0] != "#")]
        self.assertEqual(len(losses), 300)
        self.assertAlmostEqual(math.sqrt(1 - losses[-1]), result["cosine"], delta=1e-3)
        self.assertGreater(losses[0], 0.9)
        self.succeed("simulate", SCENES / "chapter.json", "--seed", "3", "--frames", "0:2", "--out", "f.npy")
        latents = self.succeed("encode", "--weights", files / "weights.tlmw", "f.npy").splitlines()[-2:]
        with open(files / "series.csv") as file:
            rows = list(csv.DictReader(line for line in file if line[0] != "#"))
        for line, row in zip(latents, rows):
            self.assertEqual(float(line.split(",")[2]), float(row["latent"]))

    def test_the_default_folder_stays_here(self):
        scene = json.loads((SCENES / "chapter.json").read_text())
        inside = self.folder / "inside"
        inside.mkdir()
        for name in ("../escaped", "/escaped", ".hidden", "a/b", ""):
            scene["name"] = name
            (inside / "scene.json").write_text(json.dumps(scene))
            self.refuse(2, "scene.json: name = ", "must be 1 to 64 of A-Z", arguments=("run", "inside/scene.json"))


if __name__ == "__main__":
    unittest.main()
