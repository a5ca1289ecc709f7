"""toliman budget: against Fisher matrices of finite differences of `toliman psf`, its text, its JSON, its refusals."""
import copy
import json
import math
import os
import shutil

import numpy

from program import SCENES, ProgramTest, long, unittest

EIGHT = ["flux_a", "flux_b", "shift_x", "shift_y", "roll", "scale", "focus", "background"]
JITTER = ["jitter_xx", "jitter_yy", "jitter_xy"]
NOLL = [f"zernike_{number}" for number in range(5, 11)]
TEMPERATURES = ["temperature_a", "temperature_b"]
STEPS = {"alone": [], "fluxes, shift": EIGHT[:4], "eight": EIGHT, "eight + jitter": EIGHT + JITTER,
         "eight + Noll 5-10": EIGHT + NOLL, "eight + temperatures": EIGHT + TEMPERATURES,
         "all of these": EIGHT + JITTER + NOLL + TEMPERATURES,
         "all + wavelength": EIGHT + JITTER + NOLL + TEMPERATURES + ["wavelength"]}
FULL = os.environ.get("TOLIMAN_BUDGET") == "full"  # make budget


# Where the stars of the dated scene are, as test_mission checks.
PLACES = {"A": [1.8426925875202578, -6.129572342849005], "B": [-5.927599606757647, 19.717695102881546]}


def mission():
    """The shipped mission in 2028.0, stars placed in px so that a difference moves what it names. Short form: fewer
    wavelengths, pupil samples and pixels."""
    scene = json.loads((SCENES / "mission.json").read_text())
    scene["telescope"]["mask"]["edges"] = "cell"
    scene["binary"] = {"offsets_px": PLACES}
    if not FULL:
        scene["telescope"]["pupil_samples"] = 96
        scene["band"]["step_nm"] = 10
        scene["detector"]["shape"] = [80, 80]
    return scene


def small():
    """A scene for what does not depend on its numbers."""
    scene = mission()
    scene["telescope"]["pupil_samples"] = 64
    scene["band"]["step_nm"] = 55
    scene["detector"]["shape"] = [48, 48]
    return scene


def dated():
    """The mission scene of 2028.0."""
    scene = json.loads((SCENES / "mission.json").read_text())
    scene["telescope"]["mask"]["edges"] = "cell"
    scene["binary"] = {"orbit": "alpha-cen", "date": 2028.0, "centre": "barycentre"}
    return scene


def planck(wavelength_m, temperature_k):
    """Photons of a black body per unit wavelength."""
    return wavelength_m**-4 / numpy.expm1(6.62607015e-34 * 299792458 / (wavelength_m * 1.380649e-23 * temperature_k))


class Differences:
    """Images of scenes that differ by one parameter, by `toliman psf`, and the Fisher matrix of their differences."""

    def __init__(self, test, scene):
        self.test, self.scene = test, scene
        self.image = self.psf(scene)
        self.variance = self.image + scene["noise"]["read_e"]**2
        self.cache = {}

    def psf(self, scene):
        """The expected frame of a scene."""
        path, image = self.test.folder / "scene.json", self.test.folder / "psf.npy"
        path.write_text(json.dumps(scene))
        self.test.succeed("psf", path, "--out", image, "--force")
        return numpy.load(image)

    def central(self, change, step):
        """The derivative by central differences; change(scene, amount) modifies a copy."""
        images = []
        for amount in (step, -step):
            scene = copy.deepcopy(self.scene)
            change(scene, amount)
            images.append(self.psf(scene))
        return (images[0] - images[1]) / (2 * step)

    def moved(self, move, step):
        """The derivative by a motion of both stars: move([xa, ya], [xb, yb], amount) returns their new places."""

        def change(scene, amount):
            offsets = scene["binary"]["offsets_px"]
            offsets["A"], offsets["B"] = (list(place) for place in move(offsets["A"], offsets["B"], amount))

        return self.central(change, step)

    def derivative(self, name):
        """The derivative by a parameter, computed once."""
        if name not in self.cache:
            self.cache[name] = self.compute(name)
        return self.cache[name]

    def compute(self, name):
        """The derivative by a parameter, from scenes that name it in no other way than its definition."""
        if name.startswith("jitter_"):
            return self.blurred(name[-2:])
        if name.startswith("flux_"):
            star = name[-1].upper()
            return self.central(lambda scene, by: scale_flux(scene, star, by), 1e-3)
        if name.startswith("temperature_"):
            return self.central(lambda scene, by: heat(self.test, scene, name[-1].upper(), by), 20)
        if name == "wavelength":
            return self.central(lambda scene, by: redden(self.test, scene, by), 0.02)
        if name == "background":
            return numpy.ones_like(self.image)
        if name == "focus" or name.startswith("zernike_"):
            noll = 4 if name == "focus" else int(name[8:])
            return self.central(lambda scene, by: aberrate(scene, noll, by), 0.2)
        if name == "scale":
            return self.central(stretch, 1e-5)
        return self.moved(MOTIONS[name], 1e-5 if name == "roll" else 1e-3)

    def blurred(self, axes):
        """The derivative by a covariance of the jitter: half a second derivative by position, or a mixed one."""
        step = 0.02
        ways = {"xx": [(1, 0, 1), (0, 0, -2), (-1, 0, 1)], "yy": [(0, 1, 1), (0, 0, -2), (0, -1, 1)],
                "xy": [(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)]}[axes]
        total = numpy.zeros_like(self.image)
        for x, y, weight in ways:
            scene = copy.deepcopy(self.scene)
            for place in scene["binary"]["offsets_px"].values():
                place[0] += x * step
                place[1] += y * step
            total += weight * self.psf(scene)
        return total / (4 if axes == "xy" else 2) / step**2

    def covariance(self, free):
        """The inverse Fisher matrix of the separation and these parameters, by scaled columns."""
        columns = numpy.array([(self.derivative(name) / numpy.sqrt(self.variance)).ravel() for name in ["separation", *free]])
        norms = numpy.linalg.norm(columns, axis=1)
        return numpy.linalg.inv(columns @ columns.T / numpy.outer(norms, norms)) / numpy.outer(norms, norms)

    def bias(self, free, name):
        """The least-squares estimate of the separation, together with the free parameters, in one unit of a parameter."""
        columns = [(self.derivative(one) / numpy.sqrt(self.variance)).ravel() for one in ["separation", *free]]
        norms = [numpy.linalg.norm(column) for column in columns]
        scaled = numpy.array([column / norm for column, norm in zip(columns, norms)]).T
        residual = (self.derivative(name) / numpy.sqrt(self.variance)).ravel()
        return numpy.linalg.lstsq(scaled, residual, rcond=None)[0][0] / norms[0]


def along(a, b):
    """The unit vector from B to A, in which A moves."""
    length = math.hypot(a[0] - b[0], a[1] - b[1])
    return (a[0] - b[0]) / length, (a[1] - b[1]) / length


MOTIONS = {
    "separation": lambda a, b, by: ([a[i] + by * along(a, b)[i] for i in range(2)], b),
    "shift_x": lambda a, b, by: ([a[0] + by, a[1]], [b[0] + by, b[1]]),
    "shift_y": lambda a, b, by: ([a[0], a[1] + by], [b[0], b[1] + by]),
    "roll": lambda a, b, by: [[p[0] * math.cos(by) - p[1] * math.sin(by), p[0] * math.sin(by) + p[1] * math.cos(by)]
                              for p in (a, b)],
}


def scale_flux(scene, star, by):
    """Changes the photons of a star by a relative amount."""
    scene["stars"][star]["detected_per_s"] *= 1 + by


def stretch(scene, by):
    """Stretches the image about the centre of the frame."""
    scene["detector"]["pixel_scale_arcsec"] /= 1 + by
    for place in scene["binary"]["offsets_px"].values():
        place[:] = [value * (1 + by) for value in place]


def aberrate(scene, noll, by):
    """Adds an aberration, in nm."""
    scene["telescope"]["aberrations"] = {"zernike_rms_nm": {str(noll): by}}


def spectrum_of(scene, star):
    """The table of a star's spectrum: wavelength (nm) and photons."""
    lines = (SCENES / scene["stars"][star]["spectrum"]["file"]).read_text().splitlines()
    return numpy.array([[float(word) for word in line.split(",")] for line in lines if line[0].isdigit()])


def write_spectrum(test, scene, star, table):
    """Gives a star a table as its spectrum."""
    path = test.folder / f"{star}.csv"
    numpy.savetxt(path, table, delimiter=",", fmt="%.17g")
    scene["stars"][star]["spectrum"]["file"] = str(path)


def heat(test, scene, star, by):
    """Multiplies a spectrum by the ratio of black bodies."""
    table, temperature = spectrum_of(scene, star), {"A": 5790, "B": 5260}[star]
    table[:, 1] *= planck(table[:, 0] * 1e-9, temperature + by) / planck(table[:, 0] * 1e-9, temperature)
    write_spectrum(test, scene, star, table)


def redden(test, scene, by):
    """Moves band and spectra to longer wavelengths, in nm."""
    for star in ("A", "B"):
        table = spectrum_of(scene, star)
        table[:, 0] += by
        write_spectrum(test, scene, star, table)
    for key in ("min_nm", "max_nm"):
        scene["band"][key] += by


class Budget(ProgramTest):
    def budget(self, scene, *arguments):
        """The JSON of the budget of a scene."""
        (self.folder / "mission.json").write_text(json.dumps(scene))
        return json.loads(self.succeed("budget", self.folder / "mission.json", "--json", *arguments))

    def setUp(self):
        super().setUp()
        for name in ("g2v.csv", "k1v.csv"):
            shutil.copy(SCENES / name, self.folder)

    @long
    def test_fisher_matrix_of_finite_differences(self):
        """From the images alone; tests/unit/test_budget.c has the matrix of derivative images."""
        scene = mission()
        found = self.budget(scene, "--free", ",".join(EIGHT), "--frames", "20")
        differences = Differences(self, scene)
        mask = found["scene_mask"]
        for step, (name, free) in zip(mask["steps"], STEPS.items()):
            self.assertEqual(step["name"], name)
            ours = math.sqrt(differences.covariance(free)[0, 0])
            self.assertAlmostEqual(step["crb_px"] / ours, 1, delta=1e-4, msg=name)
        rows = {row["name"]: row for row in mask["parameters"]}
        for name in [*NOLL, *TEMPERATURES, *JITTER, "wavelength"]:
            ours = differences.bias(EIGHT, name)
            self.assertAlmostEqual(rows[name]["bias_px"] / ours, 1, delta=5e-4, msg=name)
        scaled = differences.covariance(EIGHT)
        for i, name in enumerate(EIGHT, 1):
            self.assertAlmostEqual(rows[name]["deviation"] / math.sqrt(scaled[i, i]), 1, delta=1e-4, msg=name)

    @long
    def test_second_order(self):
        """Against least squares of the whole change of the frame by an aberration."""
        scene = mission()
        free = ["flux_a", "flux_b", "shift_x", "shift_y", "zernike_5"]
        row = {row["name"]: row for row in self.budget(scene, "--free", ",".join(free))["scene_mask"]["parameters"]}["zernike_5"]
        differences = Differences(self, scene)
        amount = 2.0
        change = numpy.zeros_like(differences.image)
        for sign in (1, -1):
            changed = copy.deepcopy(scene)
            aberrate(changed, 5, sign * amount)
            change += (differences.psf(changed) - differences.image) / 2
        differences.cache["change"] = change / amount**2
        self.assertAlmostEqual(row["curvature_px"] / differences.bias(free, "change"), 1, delta=2e-3)
        self.assertIsNone(row["bias_px"])
        self.assertAlmostEqual(row["earth_amount"]**2 * abs(row["curvature_px"]) / 6.8e-6, 1, delta=1e-9)

    def table(self, *arguments):
        """The sections of the text: title line to rows of words."""
        sections = {}
        for section in self.succeed("budget", self.folder / "mission.json", *arguments).split("\n\n"):
            title, *lines = section.splitlines()
            sections[title.split("  ")[0]] = [line.split() for line in lines]
        return sections

    def test_text_is_that_of_the_json(self):
        found = self.budget(small(), "--free", "flux_a,shift_x", "--frames", "9", "--without-mask")
        tables = self.table("--free", "flux_a,shift_x", "--frames", "9", "--without-mask")
        self.assertEqual(found["frames"], 9)
        with_mask, without = found["scene_mask"], found["without_mask"]
        self.assertLess(with_mask["crb_px"], with_mask["steps"][-1]["crb_px"])
        for line, step, clear in zip(tables["bounds per frame, free"], with_mask["steps"], without["steps"]):
            self.assertEqual(" ".join(line[:-5]), step["name"])
            self.assertEqual(line[-5], f"{step['crb_px']:.3e}")
            self.assertEqual(line[-2:], [f"{step['crb_shared_px']:.3e}", f"{clear['crb_px']:.3e}"])
        fixed = {line[0]: line[1:] for line in tables["not fitted"]}
        for row in with_mask["parameters"]:
            if row["name"] in fixed:
                self.assertEqual(fixed[row["name"]][0], f"{row['bias_px']:.2e}")
                self.assertEqual(fixed[row["name"]][1], "none" if row["earth_amount"] is None else f"{row['earth_amount']:.2g}")
        self.assertNotIn("zernike_12", fixed)
        self.assertEqual([line[0] for line in tables["fitted"]], ["flux_a", "shift_x"])
        self.assertEqual(tables["fitted"][0][1:4], ["0.00e+00", "none", "none"])
        self.assertIn("zernike_36", [line[0] for line in self.table("--all")["not fitted"]])

    def test_without_mask_is_the_scene_with_a_clear_pupil(self):
        found = self.budget(small(), "--without-mask")
        scene = small()
        del scene["telescope"]["mask"]
        clear = self.budget(scene)
        self.assertEqual(found["without_mask"], clear["scene_mask"])
        self.assertIsNone(clear["without_mask"])
        self.assertNotEqual(found["scene_mask"], clear["scene_mask"])

    def test_refusals(self):
        (self.folder / "mission.json").write_text(json.dumps(small()))
        for text, *arguments in (("--free: \"zernike_4\"", "--free", "zernike_4"), ("--free: \"roll\"", "--free", "roll,roll"),
                                 ("mask_rotation", "--free", "mask_rotation"), ("--frames", "--frames", "0"),
                                 ("--earth-px", "--earth-px", "0")):
            with self.subTest(arguments):
                self.refuse(2, text, arguments=("budget", self.folder / "mission.json", *arguments))
        self.refuse(3, "nothing.json: ", arguments=("budget", "nothing.json"))

    @unittest.skipUnless(FULL, "make budget")
    def test_mission(self):
        """The bounds and the amounts that resemble an Earth, of the scene of 2028.0."""
        differences = Differences(self, mission())
        numpy.testing.assert_allclose(differences.psf(dated()), differences.image, rtol=0, atol=1e-8 * differences.image.max())
        mask = self.budget(dated(), "--free", ",".join(EIGHT))["scene_mask"]
        expected = [1.031e-6, 2.733e-6, 3.286e-6, 3.287e-6, 3.287e-6, 3.860e-6, 3.862e-6, 1.572e-5]
        for step, bound in zip(mask["steps"], expected):
            self.assertAlmostEqual(step["crb_px"] / bound, 1, delta=1e-3, msg=step["name"])
        rows = {row["name"]: row["earth_amount"] for row in mask["parameters"]}
        for name, amount in {"zernike_7": 0.005, "zernike_9": 0.012, "zernike_10": 0.028, "zernike_8": 0.064,
                             "zernike_5": 0.102, "temperature_a": 0.1885, "temperature_b": 0.813}.items():
            self.assertAlmostEqual(rows[name] / amount, 1, delta=2e-2, msg=name)


if __name__ == "__main__":
    unittest.main()
