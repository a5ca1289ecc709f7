"""Tests that the library and the JSON Schema of scenes accept and refuse the same keys and values."""
import copy
import json
import logging
import unittest

import jsonschema

from package import LONG, ROOT, toliman

SCHEMA = json.loads((ROOT / "tools" / "schema" / "toliman-scene-1.schema.json").read_text())
SCENE = {
    "schema": "toliman-scene/1", "name": "all", "accuracy": 1e-3,
    "telescope": {"aperture_m": 0.125, "secondary_m": 0.01, "pupil_samples": 16,
                  "struts": {"count": 3, "width_m": 0.002, "angle_deg": 4},
                  "mask": {"kind": "spiral", "opd_nm": 297.5, "edges": "area", "rotation_deg": 1, "shift_m": [1e-4, 0],
                           "terms": [{"a": 0.8, "f": 2, "l": 0.1, "m": -7, "p": 4}]},
                  "aberrations": {"zernike_rms_nm": {"4": 1, "11": 2}}},
    "band": {"min_nm": 550, "max_nm": 600, "step_nm": 25},
    "stars": {"A": {"spectrum": {"kind": "blackbody", "temperature_k": 5790}, "photons_per_s": 3e6, "mass_sun": 1.1},
              "B": {"spectrum": {"kind": "lines", "wavelength_nm": [560, 590], "weight": [1, 2]}, "photons_per_s": 1e6}},
    "binary": {"separation_arcsec": 0.4, "position_angle_deg": 30, "centre": "A", "distance_pc": 1.33},
    "signal": {"kind": "sinusoid", "star": "B", "amplitude_px": 1e-3, "period_days": 40, "phase_rad": 0.1},
    "cadence": {"frames": 10, "interval_days": 2, "exposure_s": 10},
    "detector": {"shape": [8, 8], "pixel_scale_arcsec": 0.2, "pixel": "integrated", "rotation_deg": 3, "qe": 0.9,
                 "scale_anisotropy": 0.01, "shear": -0.01,
                 "coadds": 2, "flat_rms": 0.01, "dark_e_per_s": 1, "full_well_e": 1e9, "gain_e_per_dn": 2,
                 "bias_dn": 100, "bit_depth": 32},
    "noise": {"photon": True, "read_e": 2, "seed": 7},
    "systematics": {"pointing_rms_px": {"rms": 0.01, "drift_per_day": 0.001}, "roll_rms_deg": 1e-3, "scale_rms": 1e-6,
                    "focus_rms_nm": 1, "zernike_rms_nm": {"7": 1, "8": {"rms": 1, "drift_per_day": 0.1}}, "flux_rms": {"rms": 0.01}, "background_rms_photons": 1,
                    "jitter_sigma_px": 0.1, "smear": {"kind": "linear", "length_px": 0.3, "angle_deg": 30}},
    "preprocess": {"project": ["flux_a", "focus"]},
}
ORBIT = {"period_years": 80, "semi_major_arcsec": 1, "eccentricity": 0.5, "inclination_deg": 30, "node_deg": 40,
         "periastron_deg": 50, "epoch": 1955}
OTHER = dict(
    SCENE, band={"wavelength_nm": 575}, binary={"date": 2027, "orbit": ORBIT, "moving": True, "distance_pc": 1.3},
    signal={"kind": "planet", "star": "A", "mass_earth": 1, "semi_major_au": 1, "eccentricity": 0.2, "argument_deg": 30},
    stars={name: dict({key: star[key] for key in ("spectrum", "mass_sun") if key in star}, magnitude=2.5,
                      zero_point_photons_per_s=1e7) for name, star in SCENE["stars"].items()},
    detector={"shape": [8, 8], "focal_length_m": 10, "pixel_um": 10},
    cadence={"times_days": [1, 2, 5], "exposure_s": 1})
DEVIATING = {"kind": "blackbody", "temperature_k": 5790, "modes": [0.1, -0.05]}
THIRD = dict(
    SCENE, stars={"A": dict(SCENE["stars"]["A"], spectrum=DEVIATING)}, binary={"offsets_px": {"A": [0, 1]}}, signal={"kind": "none"},
    telescope={"aperture_m": 0.125, "pupil_samples": 16, "mask": {"kind": "clear"}},
    systematics={"jitter_covariance_px2": {"xx": 0.04, "yy": 0.01, "xy": 0.01}})
# Messages about one key. What they name, the schema refuses too; relations of several keys it does not know.
OF_ONE_KEY = ("unknown key", "must be a ", "must be an ", "must be one of", "must be true or false", "needs kind",
              "needs a signal", "not allowed with", "needs magnitude", "needs focal_length_m", "give either relative", "give either peak", "give either ampl")
VALUES = (None, -1, 1.5, 1e300, "x", [])
SHARE = 1 if LONG else 2  # each place takes this share of the changes, in turn


def paths(form, before=()):
    members = form.items() if isinstance(form, dict) else enumerate(form) if isinstance(form, list) else ()
    for key, value in members:
        yield before + (key,)
        yield from paths(value, before + (key,))


def mutants(scene, other):
    """Scenes with one place changed, renamed, removed or added, with a description; not in groups that another scene has too."""
    keys = sorted({path[-1] for path in paths(SCENE) if isinstance(path[-1], str)})
    for number, path in enumerate(path for path in paths(scene) if scene[path[0]] != other.get(path[0])):
        for value in (VALUES + ("rename", "remove", "add"))[number % SHARE::SHARE]:
            changed = copy.deepcopy(scene)
            place = changed
            for key in path[:-1]:
                place = place[key]
            if value == "add" and isinstance(place[path[-1]], dict):
                place[path[-1]].setdefault(keys[7 * number % len(keys)], 1)
            elif value == "rename" and isinstance(place, dict):
                place[path[-1] + "x"] = place.pop(path[-1])
            elif value == "remove":
                del place[path[-1]]
            else:
                place[path[-1]] = value
            yield (path, value), changed


class Verdicts(unittest.TestCase):
    def setUp(self):
        logging.disable(logging.WARNING)
        self.addCleanup(logging.disable, logging.NOTSET)

    def compare(self, scene, other, least):
        validator = jsonschema.Draft202012Validator(SCHEMA)
        accepted = refused = 0
        for name, changed in mutants(scene, other):
            valid, message = validator.is_valid(changed), ""
            try:
                toliman.plan(changed)
                accepted += 1
            except toliman.Error as error:
                message = str(error)
            with self.subTest(name, message=message):
                if not message:
                    self.assertTrue(valid)
                if any(words in message for words in OF_ONE_KEY):
                    self.assertFalse(valid)
                    refused += 1
        self.assertGreater(accepted, 15 / SHARE)
        self.assertGreater(refused, least / SHARE)

    def test_sinusoid(self):
        self.compare(SCENE, {}, 250)

    def test_planet_on_an_orbit(self):
        self.compare(OTHER, SCENE, 100)

    def test_single_star(self):
        self.compare(THIRD, SCENE, 100)

    def test_every_parameter_can_be_projected(self):
        names = SCHEMA["$defs"]["preprocess"]["properties"]["project"]["items"]["enum"]
        self.assertEqual(set(names), {parameter.name for parameter in toliman.parameters()} - {"separation", "flat"})
        self.assertEqual(len(names), len(set(names)))


if __name__ == "__main__":
    unittest.main()
