"""The published schemas of scenes and systems agree with the library: shipped files are valid, mutilated ones are refused by
both."""
import copy
import json
import pathlib
import shutil
import subprocess
import unittest

import jsonschema
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
        cases = [(True, "binary", change) for change in (
            {}, {"moving": False}, {"orbit": elements}, {"orbit": dict(elements, source="a catalogue")}, {"orbit": "alpha-cen.json"})]
        cases += [(True, "signal", {"eccentricity": 0.9999, "argument_deg": -360, "phase_rad": 1000, "star": "A"})]
        cases += [(False, "binary", change) for change in (
            {"orbit": dict(elements, source=1)}, {"orbit": ".json"}, {"orbit": "beta-cen"}, {"orbit": dict(elements, eccentricity=1)},
            {"orbit": {k: v for k, v in elements.items() if k != "epoch"}}, {"date": 10001}, {"separation_arcsec": 4}, {"moving": 1})]
        cases += [(False, "signal", change) for change in ({"mass_earth": -1}, {"semi_major_au": 0}, {"eccentricity": 1},
                                                           {"phase_rad": 1001}, {"kind": "none"})]
        self.check(scene, cases)

    def check(self, scene, cases):
        """cases: (whether both take it, group, changes)."""
        for good, group, changes in cases:
            changed = copy.deepcopy(scene)
            changed[group].update(changes)
            with self.subTest(group=group, changes=changes):
                self.assertEqual(self.validator.is_valid(changed), good)
                (self.folder / "scene.json").write_text(json.dumps(changed))
                if good:
                    self.succeed("psf", "scene.json", "--out", "good.npy")
                else:
                    self.refuse(2, "scene.json: " + group, arguments=("psf", "scene.json", "--out", "x.npy"))

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
        every["zernike_rms_nm"] = {"5": 1, "231": {"rms": 0, "drift_per_day": 0.1}}
        scene["systematics"] = {}
        cases = [(True, "detector", every_stage), (True, "systematics", every), (True, "systematics", {}),
                 (True, "systematics", {"jitter_sigma_px": {"rms": 0.1, "drift_per_day": 0}}),
                 (True, "systematics", {"background_rms_photons": {"rms": 0, "drift_per_day": -1}}),
                 (True, "systematics", {"jitter_covariance_px2": {"xx": 0.09, "yy": 0.04, "xy": -0.06}}),
                 (True, "systematics", {"smear": {"kind": "harmonic", "length_px": 20, "angle_deg": -30}}),
                 (True, "detector", {"scale_anisotropy": -0.1, "shear": 0.1})]
        cases += [(False, "detector", change) for change in (
            {"scale_anisotropy": 0.11}, {"shear": "little"}, {"qe": 0}, {"qe": 1.01}, {"coadds": 0}, {"flat_rms": 0.11}, {"dark_e_per_s": -1},
            {"full_well_e": 0}, {"gain_e_per_dn": 0}, {"bias_dn": -1}, {"bit_depth": 0}, {"bit_depth": 33})]
        cases += [(False, "systematics", change) for change in (
            {"pointing_rms_px": -1}, {"pointing_rms_px": {"drift_per_day": 1}}, {"jitter_sigma_px": {"rms": 1, "drift_per_day": 1}},
            {"jitter_sigma_px": 11}, {"background_rms_photons": -1}, {"jitter_covariance_px2": {"xx": 0.09}},
            {"jitter_covariance_px2": {"xx": -0.09, "yy": 0.04}}, {"roll_rms_deg": "much"}, {"scale_rms": 0.02},
            {"jitter_covariance_px2": {"xx": 0, "yy": 0}, "jitter_sigma_px": 0}, {"focus_rms_nm": {"rms": 1, "drift": 1}},
            {"flux_rms": {"rms": 0, "drift_per_day": 1}}, {"shake": 1}, {"zernike_rms_nm": {"4": 1}}, {"smear": {"kind": "linear", "length_px": 1}},
            {"smear": {"kind": "linear", "length_px": 20.1, "angle_deg": 0}})]
        self.check(scene, cases)

    def test_both_refuse(self):
        chapter = json.loads((SCENES / "chapter.json").read_text())

        for path, key, value in (
            ("telescope", "aperture_m", -1), ("telescope", "aperture_m", "wide"), ("telescope", "unknown", 1),
            ("telescope", "amplitude", {"file": 0.5}), ("telescope", "aberrations", {"zernike_rms_nm": {"232": 1}}),
            ("telescope", "aberrations", {"zernike_rms_nm": {"04": 1}}), ("telescope", "aberrations", {"opd_file": 1}),
            ("telescope.mask", "edges", "soft"), ("telescope.mask", "rotation_deg", 361), ("telescope.mask", "shift_m", [0, 0, 0]),
            ("telescope", "mask", {"kind": "clear", "edges": "area"}), ("stars.A.spectrum", "modes", [0] * 12),
            ("stars.A.spectrum", "star_temperature_k", 5800), ("band", "step_nm", 0), ("", "name", "../escaped"), ("", "name", "a" * 65),
            ("", "name", ""), ("cadence", "peak_photons", 1e-7), ("detector", "pixel_scale_arcsec", 1e-7), ("cadence", "frames", 1.5),
            ("detector", "shape", [256]), ("noise", "read_e", -1), ("", "schema", "toliman-scene/9"),
        ):
            scene = copy.deepcopy(chapter)
            group = scene
            for name in filter(None, path.split(".")):
                group = group[name]
            group[key] = value
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
            ("", "schema", "toliman-scene/1"), ("", "name", 1), ("", "masses", None), ("", "distance_pc", 1.33),
            ("orbit", "period_years", 0), ("orbit", "eccentricity", 1), ("orbit", "epoch", None), ("orbit", "source", 1),
            ("barycentre", "dec_deg", -91), ("barycentre", "parallax_mas", 0), ("barycentre", "radial_velocity_kind", "optical"),
            ("barycentre", "line_shift_km_s", 0.06), ("masses", "C", 0.12), ("masses", "A", "1"), ("sigma", "orbit", {"epoch": -1}),
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
