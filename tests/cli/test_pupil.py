"""toliman pupil: the designed mask is better, the same in every run, and that of the scene that is written."""
import json
import os
import signal
import subprocess
import unittest

import numpy
from program import PATIENCE, PROGRAM, ProgramTest

FLUX = "540,1\n610,1.4\n"


def tiny_scene():
    """64 x 64 px, four wavelengths, a poor mask; star B has its spectrum in a file."""
    return {
        "schema": "toliman-scene/1",
        "name": "tiny",
        "telescope": {
            "aperture_m": 0.125,
            "secondary_m": 0.02,
            "pupil_samples": 64,
            "mask": {"kind": "spiral", "edges": "cell", "height_nm": 144, "terms": [{"a": 1, "f": 2, "m": 3}, {"a": 0.5, "f": 5, "p": 1}]},
        },
        "band": {"min_nm": 550, "max_nm": 600, "step_nm": 16.666666666666668},
        "stars": {
            "A": {"spectrum": {"kind": "blackbody", "temperature_k": 5790}, "relative_flux": 3},
            "B": {"spectrum": {"kind": "table", "file": "flux.csv"}},
        },
        "binary": {"separation_arcsec": 4, "position_angle_deg": 30},
        "signal": {"kind": "sinusoid", "star": "B", "amplitude_px": 1e-6, "period_days": 40},
        "cadence": {"frames": 10, "peak_photons": 1e8},
        "detector": {"shape": [64, 64], "pixel_scale_arcsec": 0.2},
        "noise": {"photon": True, "read_e": 3, "seed": 7},
    }


class Pupil(ProgramTest):
    def setUp(self):
        super().setUp()
        (self.folder / "flux.csv").write_text(FLUX)
        self.write(tiny_scene())

    def write(self, scene, name="tiny.json"):
        (self.folder / name).write_text(json.dumps(scene))

    def design(self, *arguments, **options):
        return json.loads(self.succeed("pupil", *arguments, "--json", **options))

    def test_better_and_true(self):
        """Two position angles; the scores are those of the scene that is written."""
        made = self.design("tiny.json", "--position-angles", "30,50", "--free", "flux_a,flux_b,shift_x,shift_y", "--light", 0.3,
                           "--iterations", 60, "--out", "made")
        self.assertEqual(made, json.loads((self.folder / "made/pupil.json").read_text()))
        self.assertEqual((made["schema"], made["scene"], made["free"]),
                         ("toliman-pupil/1", "tiny", ["flux_a", "flux_b", "shift_x", "shift_y"]))
        self.assertTrue(made["improved"])
        self.assertEqual(len(made["descent_px"]), made["iterations"])
        cells = numpy.load(self.folder / "made/mask.npy")
        self.assertEqual((cells.shape, cells.dtype, set(cells.ravel())), ((64, 64), numpy.uint8, {0, 1}))
        scene = json.loads((self.folder / "made/scene.json").read_text())
        self.assertEqual(scene["telescope"].pop("mask"), made["mask"])
        expected = tiny_scene()
        del expected["telescope"]["mask"]
        expected["stars"]["B"]["spectrum"]["file"] = "../flux.csv"
        self.assertEqual(scene, expected)
        self.assertEqual([place["position_angle_deg"] for place in made["places"]], [30, 50])
        for place in made["places"]:
            own, designed = place["scene_mask"], place["designed"]
            self.assertLess(designed["crb_px"], 0.9 * own["crb_px"])
            self.assertLessEqual(designed["peak_to_mean"], own["peak_to_mean"])
            self.assertEqual(designed["crb_px"], designed["crb_flux_shift_px"])
            self.assertLess(place["quantum_px"], designed["crb_alone_px"])
        first = made["places"][0]
        budget = json.loads(self.succeed("budget", "made/scene.json", "--json"))
        steps = {step["name"]: step["crb_px"] for step in budget["scene_mask"]["steps"]}
        self.assertAlmostEqual(first["designed"]["crb_alone_px"] / steps["alone"], 1, delta=1e-6)
        self.assertAlmostEqual(first["designed"]["crb_flux_shift_px"] / steps["fluxes, shift"], 1, delta=1e-6)
        self.succeed("psf", "made/scene.json", "--out", "psf.npy")
        image = numpy.load(self.folder / "psf.npy")
        self.assertAlmostEqual(image.max() / image.mean() / first["designed"]["peak_to_mean"], 1, delta=1e-6)

    # promise: masks-ignore-threads
    def test_same_seed_same_mask_on_any_number_of_processors(self):
        arguments = ("tiny.json", "--iterations", 5, "--seed", 3)
        first = self.design(*arguments)
        one = min(os.sched_getaffinity(0))
        self.assertEqual(first, self.design(*arguments, preexec_fn=lambda: os.sched_setaffinity(0, {one})))
        self.assertNotEqual(first["descent_px"], self.design(*arguments[:-1], 4)["descent_px"])
        out = self.succeed("pupil", "tiny.json", "--iterations", 1)
        for word in ("fluxes, shift", "peak-to-mean", "light", "gradient", "r50, px", "r80, px", "quantum", "iterations", "not better"):
            self.assertIn(word, out)

    def test_dates(self):
        scene = tiny_scene()
        scene["binary"] = {"orbit": "alpha-cen", "date": 2027, "centre": "barycentre"}
        self.write(scene)
        made = self.design("tiny.json", "--dates", "2027,2028.5", "--iterations", 1)
        self.assertEqual([place["date"] for place in made["places"]], [2027, 2028.5])
        self.assertNotEqual(made["places"][0]["scene_mask"], made["places"][1]["scene_mask"])

    def test_interrupt_keeps_the_mask(self):
        arguments = [PROGRAM, "--progress=json", "pupil", "tiny.json", "--iterations", "100000", "--json", "--out", "made"]
        with subprocess.Popen(arguments, cwd=self.folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as run:
            for line in run.stderr:
                if '"descend' in line:
                    break
            run.send_signal(signal.SIGTERM)
            out, _ = run.communicate(timeout=PATIENCE)
        made = json.loads(out)
        self.assertEqual((run.returncode, made["stopped"]), (143, True))
        self.assertEqual(made, json.loads((self.folder / "made/pupil.json").read_text()))
        self.succeed("psf", "made/scene.json", "--out", "psf.npy")

    def test_refusals(self):
        for option, value in (
            ("--iterations", 0), ("--iterations", "many"), ("--seed", -1), ("--seed", "x"), ("--light", 1), ("--light", "nan"),
            ("--peak-to-mean", 0.5), ("--feature", 0), ("--feature", 17), ("--symmetry", "threefold"), ("--dates", "2027,x"),
            ("--position-angles", "nan"), ("--free", "flux"), ("--free", "focus,focus"), ("--free", "zernike_5"),
        ):
            with self.subTest(option=option, value=value):
                self.refuse(2, option, arguments=("pupil", "tiny.json", *(() if option == "--iterations" else ("--iterations=1",)), f"{option}={value}"))
        self.refuse_all(
            (2, "--dates", "tiny.json", "--dates=2027", "--position-angles=30"),
            (2, "tiny.json: binary.orbit: ", "tiny.json", "--dates=2027"), (3, "none.json", "none.json"),
            (6, "no/made", "tiny.json", "--out", "no/made"), command=("pupil", "--iterations=1"))
        (self.folder / "made").mkdir()
        (self.folder / "made/mask.npy").write_text("mine")
        self.refuse(6, "mask.npy", arguments=("pupil", "tiny.json", "--iterations=1", "--out", "made"))
        self.assertEqual((self.folder / "made/mask.npy").read_text(), "mine")


if __name__ == "__main__":
    unittest.main()
