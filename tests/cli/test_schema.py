"""The published schema and the library agree: shipped scenes are valid, mutilated ones are refused by both."""
import copy
import json
import unittest

import jsonschema
from program import ROOT, SCENES, ProgramTest

SCHEMA = json.loads((ROOT / "tools" / "schema" / "toliman-scene-1.schema.json").read_text())


class Schema(ProgramTest):
    def setUp(self):
        super().setUp()
        jsonschema.Draft202012Validator.check_schema(SCHEMA)
        self.validator = jsonschema.Draft202012Validator(SCHEMA)

    def test_shipped_scenes_are_valid(self):
        for path in sorted(SCENES.glob("*.json")):
            with self.subTest(path.name):
                self.validator.validate(json.loads(path.read_text()))

    def test_both_refuse(self):
        chapter = json.loads((SCENES / "chapter.json").read_text())

        def telescope(scene):
            return scene["telescope"]

        for where, key, value in (
            (telescope, "aperture_m", -1),
            (telescope, "aperture_m", "wide"),
            (telescope, "unknown", 1),
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


if __name__ == "__main__":
    unittest.main()
