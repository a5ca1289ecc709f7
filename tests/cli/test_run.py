"""toliman run: the whole job on the chapter's scene, every figure and control of its result."""
import csv
import json
import unittest

from program import SCENES, ProgramTest


class ChapterRun(ProgramTest):
    def test_figures_and_files(self):
        out = self.succeed("run", SCENES / "chapter.json", "--seed", "3", "--out", "results", "--json")
        files = self.folder / "results"
        self.assertEqual(sorted(p.name for p in files.iterdir()), ["periodogram.csv", "result.json", "series.csv"])
        self.assertEqual(out, (files / "result.json").read_text())
        result = json.loads(out)
        self.assertEqual(result["schema"], "toliman-run/1")
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
        self.assertAlmostEqual(result["mmse"] / result["photon_floor"], 1, delta=0.01)
        self.assertGreater(result["mssim"], 1 - 1e-7)
        self.assertGreater(result["decoder"]["cosine"], 0.95)
        self.assertAlmostEqual(result["decoder"]["gain"], 1, delta=0.05)
        self.assertEqual(
            set(result["timings"]),
            {"setup_s", "train_s", "simulate_s", "encode_s", "period_s", "controls_s", "total_s"},
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
        self.assertEqual(len(power), result["grid"]["nf"])
        top = max(power, key=lambda row: float(row["power"]))
        self.assertAlmostEqual(float(top["frequency"]), 1 / result["period_days"], delta=result["grid"]["df"])

    def test_seed_is_told_in_full(self):
        scene = json.loads((SCENES / "chapter.json").read_text())
        scene["cadence"]["frames"] = 20
        scene["band"] = {"wavelength_nm": 580}
        scene["name"] = "short.1"
        for star in scene["stars"].values():
            star["spectrum"] = {"kind": "blackbody", "temperature_k": 5800}
        (self.folder / "scene.json").write_text(json.dumps(scene))
        out = self.succeed("run", "scene.json", "--seed", "9007199254740993", "--json")
        self.assertIn('"seed":\t9007199254740993,', out)
        self.assertEqual(json.loads((self.folder / "short.1.run" / "result.json").read_text())["seed"], 2**53 + 1)

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
