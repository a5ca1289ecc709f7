"""The published schemas of scenes and systems agree with the library: shipped files are valid, mutilated ones are refused by
both."""
import copy
import json
import pathlib
import shutil
import subprocess
import unittest

import jsonschema
import numpy
from program import PROGRAM, ROOT, SCENES, ProgramTest

TEXTS = {name: (ROOT / "tools" / "schema" / f"toliman-{name}-1.schema.json").read_text() for name in ("scene", "system")}
SCHEMA = json.loads(TEXTS["scene"])
SYSTEM = ROOT / "examples" / "systems" / "alpha-cen.json"


def generated(name):
    """The schema that tools/gen/scene_schema makes from the library's tables."""
    table = subprocess.run([pathlib.Path(PROGRAM).parent / "scene_table", name], stdout=subprocess.PIPE, check=True).stdout
    return subprocess.run([ROOT / "tools" / "gen" / "scene_schema"], input=table, stdout=subprocess.PIPE,
                          check=True).stdout.decode()


class Schema(ProgramTest):
    def setUp(self):
        super().setUp()
        jsonschema.Draft202012Validator.check_schema(SCHEMA)
        self.validator = jsonschema.Draft202012Validator(SCHEMA)

    def test_generated(self):
        for name, text in TEXTS.items():
            self.assertEqual(text, generated(name), f"build/bin/scene_table {name} | tools/gen/scene_schema writes the schema")

    def test_shipped_scenes_are_valid(self):
        for path in sorted(SCENES.glob("*.json")):
            with self.subTest(path.name):
                self.validator.validate(json.loads(path.read_text()))

    def test_both_accept_every_telescope(self):
        scene = json.loads((SCENES / "chapter.json").read_text())
        numpy.save(self.folder / "half.npy", numpy.full((256, 256), 0.5))
        numpy.save(self.folder / "flat.npy", numpy.zeros((256, 256)))
        aberrations = {"zernike_rms_nm": {"4": 5, "11": -2.5, "231": 0.1}, "opd_file": "flat.npy"}
        scene["telescope"].update(amplitude={"file": "half.npy"}, aberrations=aberrations)
        scene["telescope"]["mask"].update(edges="area", rotation_deg=-1, shift_m=[1e-4, -1e-3])
        self.validator.validate(scene)
        (self.folder / "scene.json").write_text(json.dumps(scene))
        self.succeed("psf", "scene.json", "--out", "x.npy")

    def test_orbits_and_planets(self):
        """What the library takes and refuses of them, the schema does too."""
        scene = json.loads((SCENES / "chapter.json").read_text())
        scene["telescope"].update(pupil_samples=64)
        scene["band"] = {"wavelength_nm": 575}
        scene["detector"]["shape"] = [16, 16]
        scene["binary"] = {"date": 2027.0, "orbit": "alpha-cen", "distance_pc": 1.33, "centre": "A"}
        scene["stars"]["A"]["mass_sun"] = 1.0788
        scene["signal"] = {"kind": "planet", "mass_earth": 1, "semi_major_au": 1.23}
        elements = {"period_years": 80, "semi_major_arcsec": 9, "eccentricity": 0.5, "inclination_deg": 79}
        elements.update(node_deg=25, periastron_deg=52, epoch=1955.6)
        shutil.copy(SYSTEM, self.folder)
        for good, group, changes in (
            (True, "binary", {}),
            (True, "binary", {"moving": False}),
            (True, "binary", {"orbit": elements}),
            (True, "binary", {"orbit": dict(elements, source="a catalogue")}),
            (True, "binary", {"orbit": "alpha-cen.json"}),
            (False, "binary", {"orbit": dict(elements, source=1)}),
            (False, "binary", {"orbit": ".json"}),
            (True, "signal", {"eccentricity": 0.9999, "argument_deg": -360, "phase_rad": 1000, "star": "A"}),
            (False, "binary", {"orbit": "beta-cen"}),
            (False, "binary", {"orbit": dict(elements, eccentricity=1)}),
            (False, "binary", {"orbit": dict(elements, period_years=0)}),
            (False, "binary", {"orbit": dict(elements, node_deg=361)}),
            (False, "binary", {"orbit": dict(elements, inclination_deg=-1)}),
            (False, "binary", {"orbit": {k: v for k, v in elements.items() if k != "epoch"}}),
            (False, "binary", {"date": 10001}),
            (False, "binary", {"separation_arcsec": 4}),
            (False, "binary", {"position_angle_deg": 4}),
            (False, "binary", {"moving": 1}),
            (False, "binary", {"distance_pc": 0}),
            (False, "signal", {"mass_earth": -1}),
            (False, "signal", {"semi_major_au": 0}),
            (False, "signal", {"eccentricity": 1}),
            (False, "signal", {"argument_deg": 361}),
            (False, "signal", {"phase_rad": 1001}),
            (False, "signal", {"kind": "none"}),
        ):
            changed = copy.deepcopy(scene)
            changed[group].update(changes)
            with self.subTest(group=group, changes=changes):
                self.assertEqual(self.validator.is_valid(changed), good)
                (self.folder / "scene.json").write_text(json.dumps(changed))
                if good:
                    self.succeed("psf", "scene.json", "--out", "good.npy")
                else:
                    self.refuse(2, "scene.json: " + group, arguments=("psf", "scene.json", "--out", "x.npy"))

    def test_planets_move_stars_as_far_as_both_say(self):
        scene = json.loads((SCENES / "chapter.json").read_text())
        scene["telescope"].update(pupil_samples=128)
        scene["band"] = {"wavelength_nm": 575}
        scene["detector"]["shape"] = [16, 16]
        scene["binary"]["distance_pc"] = 1.33
        scene["stars"]["A"]["mass_sun"] = 1
        bound = "at most 100 px"
        self.assertIn(bound, SCHEMA["$defs"]["signal"]["properties"]["kind"]["description"])
        for pixels in (99, 101):
            share = pixels * 0.2 * 1.33 / 1e4  # m / (M + m): at 1 pc 1 au is 1 arcsec
            mass = 332946 * share / (1 - share)  # Earth masses in a solar mass
            scene["signal"] = {"kind": "planet", "mass_earth": mass, "semi_major_au": 1e4}
            self.validator.validate(scene)
            (self.folder / "scene.json").write_text(json.dumps(scene))
            if pixels < 100:
                self.succeed("psf", "scene.json", "--out", "x.npy")
            else:
                self.refuse(2, f"moves star A by up to {pixels} px: must be {bound}",
                            arguments=("psf", "scene.json", "--out", "y.npy"))

    def test_detectors_and_systematics(self):
        """What the library takes and refuses of them, the schema does too."""
        scene = json.loads((SCENES / "chapter.json").read_text())
        scene["telescope"].update(pupil_samples=64)
        scene["band"] = {"wavelength_nm": 575}
        scene["detector"]["shape"] = [16, 16]
        scene["binary"]["separation_arcsec"] = 1
        scene["cadence"] = {"frames": 11, "interval_days": 1, "exposure_s": 10}
        for star in scene["stars"].values():
            star.pop("relative_flux", None)
            star["photons_per_s"] = 1e6
        every_stage = {"qe": 0.95, "coadds": 10, "flat_rms": 0.1, "dark_e_per_s": 80, "full_well_e": 45000}
        every_stage.update(gain_e_per_dn=11.5, bias_dn=100, bit_depth=32)
        every = {"pointing_rms_px": {"rms": 1, "drift_per_day": -1}, "jitter_sigma_px": 0.2, "roll_rms_deg": 10}
        every.update(scale_rms=1e-5, focus_rms_nm={"rms": 1}, flux_rms={"rms": 0.1, "drift_per_day": 0.01})
        scene["systematics"] = {}
        for good, group, changes in (
            (True, "detector", every_stage),
            (True, "systematics", every),
            (True, "systematics", {}),
            (True, "systematics", {"jitter_sigma_px": {"rms": 0.1, "drift_per_day": 0}}),
            (True, "detector", {"scale_anisotropy": -0.1, "shear": 0.1}),
            (False, "detector", {"scale_anisotropy": 0.11}),
            (False, "detector", {"shear": "little"}),
            (False, "detector", {"qe": 0}),
            (False, "detector", {"qe": 1.01}),
            (False, "detector", {"coadds": 0}),
            (False, "detector", {"flat_rms": 0.11}),
            (False, "detector", {"dark_e_per_s": -1}),
            (False, "detector", {"full_well_e": 0}),
            (False, "detector", {"gain_e_per_dn": 0}),
            (False, "detector", {"bias_dn": -1}),
            (False, "detector", {"bit_depth": 0}),
            (False, "detector", {"bit_depth": 33}),
            (False, "systematics", {"pointing_rms_px": -1}),
            (False, "systematics", {"pointing_rms_px": {"drift_per_day": 1}}),
            (False, "systematics", {"jitter_sigma_px": {"rms": 1, "drift_per_day": 1}}),
            (False, "systematics", {"jitter_sigma_px": 11}),
            (True, "systematics", {"background_rms_photons": {"rms": 0, "drift_per_day": -1}}),
            (False, "systematics", {"background_rms_photons": -1}),
            (True, "systematics", {"jitter_covariance_px2": {"xx": 0.09, "yy": 0.04, "xy": -0.06}}),
            (False, "systematics", {"jitter_covariance_px2": {"xx": 0.09}}),
            (False, "systematics", {"jitter_covariance_px2": {"xx": -0.09, "yy": 0.04}}),
            (False, "systematics", {"jitter_covariance_px2": {"xx": 0, "yy": 0}, "jitter_sigma_px": 0}),
            (False, "systematics", {"roll_rms_deg": "much"}),
            (False, "systematics", {"scale_rms": 0.02}),
            (False, "systematics", {"focus_rms_nm": {"rms": 1, "drift": 1}}),
            (False, "systematics", {"flux_rms": {"rms": 0, "drift_per_day": 1}}),
            (False, "systematics", {"shake": 1}),
        ):
            changed = copy.deepcopy(scene)
            changed[group].update(changes)
            with self.subTest(group=group, changes=changes):
                self.assertEqual(self.validator.is_valid(changed), good)
                (self.folder / "scene.json").write_text(json.dumps(changed))
                if good:
                    self.succeed("psf", "scene.json", "--out", "good.npy")
                else:
                    self.refuse(2, "scene.json: " + group, arguments=("psf", "scene.json", "--out", "x.npy"))

    def test_both_refuse(self):
        chapter = json.loads((SCENES / "chapter.json").read_text())

        def telescope(scene):
            return scene["telescope"]

        for where, key, value in (
            (telescope, "aperture_m", -1),
            (telescope, "aperture_m", "wide"),
            (telescope, "unknown", 1),
            (telescope, "amplitude", {"file": 0.5}),
            (telescope, "aberrations", {"zernike_rms_nm": {"232": 1}}),
            (telescope, "aberrations", {"zernike_rms_nm": {"04": 1}}),
            (telescope, "aberrations", {"zernike_rms_nm": {"4": 2e6}}),
            (telescope, "aberrations", {"opd_file": 1}),
            (lambda s: s["telescope"]["mask"], "edges", "soft"),
            (lambda s: s["telescope"]["mask"], "rotation_deg", 361),
            (lambda s: s["telescope"]["mask"], "shift_m", [0, 0, 0]),
            (lambda s: s["telescope"], "mask", {"kind": "clear", "edges": "area"}),
            (lambda s: s["stars"]["A"]["spectrum"], "modes", [0] * 12),
            (lambda s: s["stars"]["A"]["spectrum"], "star_temperature_k", 5800),
            (lambda s: s["band"], "step_nm", 0),
            (lambda s: s, "name", "../escaped"),
            (lambda s: s, "name", ".hidden"),
            (lambda s: s, "name", "a" * 65),
            (lambda s: s, "name", ""),
            (telescope, "aperture_m", 1e-4),
            (lambda s: s["cadence"], "peak_photons", 1e-7),
            (lambda s: s["detector"], "pixel_scale_arcsec", 1e-7),
            (lambda s: s["cadence"], "frames", 0),
            (lambda s: s["cadence"], "frames", 1.5),
            (lambda s: s["detector"], "shape", [256]),
            (lambda s: s["noise"], "read_e", -1),
            (lambda s: s, "schema", "toliman-scene/9"),
        ):
            scene = copy.deepcopy(chapter)
            where(scene)[key] = value
            with self.subTest(key=key, value=value):
                self.assertFalse(self.validator.is_valid(scene))
                (self.folder / "scene.json").write_text(json.dumps(scene))
                self.refuse(2, "scene.json: ", key, arguments=("psf", "scene.json", "--out", "x.npy"))


class SystemSchema(ProgramTest):
    """Both accept and refuse the same system files."""

    def setUp(self):
        super().setUp()
        schema = json.loads(TEXTS["system"])
        jsonschema.Draft202012Validator.check_schema(schema)
        self.validator = jsonschema.Draft202012Validator(schema)
        self.system = json.loads(SYSTEM.read_text())

    def both(self, good, system, *texts):
        self.assertEqual(self.validator.is_valid(system), good)
        (self.folder / "binary.json").write_text(json.dumps(system))
        arguments = ("predict", "binary.json", "--altitude", 600, "--times", "2027-01-01")
        if good:
            self.succeed(*arguments)
        else:
            self.refuse(2, "binary.json: ", *texts, arguments=arguments)

    def test_accept(self):
        self.both(True, self.system)
        self.both(True, {key: value for key, value in self.system.items() if key not in ("name", "sigma")})
        self.system["barycentre"].update(radial_velocity_kind="spectroscopic", line_shift_km_s=-0.06)
        del self.system["orbit"]["source"]
        self.system["sigma"] = {"orbit": {}}
        self.both(True, self.system)

    def test_refuse(self):
        for group, key, value in (
            ("", "schema", "toliman-scene/1"),
            ("", "name", 1),
            ("", "masses", None),
            ("", "distance_pc", 1.33),
            ("orbit", "period_years", 0),
            ("orbit", "eccentricity", 1),
            ("orbit", "inclination_deg", 181),
            ("orbit", "epoch", None),
            ("orbit", "source", 1),
            ("barycentre", "dec_deg", -91),
            ("barycentre", "parallax_mas", 0),
            ("barycentre", "radial_velocity_kind", "optical"),
            ("barycentre", "line_shift_km_s", 0.06),
            ("masses", "C", 0.12),
            ("masses", "A", "1"),
            ("sigma", "orbit", {"epoch": -1}),
            ("sigma", "orbit", {"period_days": 1}),
        ):
            system = copy.deepcopy(self.system)
            part = system[group] if group else system
            part[key] = value
            if value is None:
                del part[key]
            with self.subTest(group=group, key=key, value=value):
                self.both(False, system, key)


if __name__ == "__main__":
    unittest.main()
