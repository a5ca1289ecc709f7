"""Schemas of results: real ones are valid (program.py sees to it), mutilated ones are not, and lists of names are the code's."""
import copy
import json
import re
import unittest

import jsonschema
import schemas
from program import ROOT, SCENES, ProgramTest

FORMATS = (ROOT / "tools/docs/formats.md").read_text()
DATA = ROOT / "examples/data/nu_oph_rv.csv"
NAMES = ("doctor", "experiment", "period", "run", "track")


def objects(schema):
    """Every object that a schema describes."""
    if isinstance(schema, dict):
        if "properties" in schema and schema.get("type") == "object":
            yield schema
        for value in schema.values():
            yield from objects(value)
    elif isinstance(schema, list):
        for value in schema:
            yield from objects(value)


def path_of(name):
    """Of its only version."""
    path, = schemas.FOLDER.glob(f"toliman-{name}-*.schema.json")
    return path


def read(name):
    return json.loads(path_of(name).read_text())


class Results(ProgramTest):
    def outputs(self):
        """One of each kind."""
        scene = json.loads((SCENES / "chapter.json").read_text())
        scene["telescope"]["pupil_samples"] = 96
        scene["band"] = {"wavelength_nm": 575}
        for star in scene["stars"].values():
            star["spectrum"] = {"kind": "blackbody", "temperature_k": 5800}
        scene["cadence"]["frames"] = 12
        (self.folder / "s.json").write_text(json.dumps(scene))
        yield from [self.run_program("doctor", "--json").stdout, self.succeed("period", DATA, "--json", "--peaks", 3, "--f0", 1e-3, "--df", 1e-4, "--nf", 99)]
        self.succeed("simulate", "s.json", "--out", "in", "--session", "day", "--dtype", "u32le")
        with open(self.folder / "in/day_frames.bin", "ab") as stream:
            stream.write(b"extra")
        yield from self.run_program("track", "--template", "s.json", "--state", "m", "--dtype", "u32le", "--mission-days",
                                    100, "in").stdout.splitlines()[-4:]
        yield self.succeed("status", "m", "--json")
        yield self.succeed("status", "m", "--records").splitlines()[0]

    def test_schemas_are_schemas(self):
        for path in schemas.FOLDER.glob("*.json"):
            jsonschema.Draft202012Validator.check_schema(json.loads(path.read_text()))

    def test_mutilated_ones_are_refused(self):
        kinds = set()
        for text in self.outputs():
            good = json.loads(text)
            kinds.add(good["schema"])
            schemas.check(json.dumps(good))
            for change in (lambda o: o.update(unknown=1), lambda o: o.pop(list(o)[2]), lambda o: o.update({list(o)[1]: []})):
                bad = copy.deepcopy(good)
                change(bad)
                with self.subTest(good["schema"]), self.assertRaises(jsonschema.ValidationError):
                    schemas.check(json.dumps(bad))
        self.assertEqual(kinds, {"toliman-doctor/1", "toliman-period/2", "toliman-frame/2", "toliman-track-warning/1",
                                 "toliman-track-update/2", "toliman-track-status/2", "toliman-record/1"})

    def test_everything_is_closed_and_described(self):
        for name in NAMES:
            schema = read(name)
            self.assertEqual(schema["$id"], path_of(name).name)
            self.assertTrue(f"tools/schema/{schema['$id']}" in FORMATS, name)
            for part in objects(schema):
                self.assertIs(part["additionalProperties"], False)
                for key, value in part["properties"].items():
                    self.assertTrue({"description", "$ref", "const", "enum", "oneOf", "properties", "items"} & value.keys(), (name, key))

    def test_names_are_those_of_the_program(self):
        def listed(command, option):
            return re.search(rf"  --{option} [^ {{]*:\{{([^}}]*)\}}", self.succeed(command, "--help")).group(1).split(",")
        self.assertEqual(read("period")["$defs"]["result"]["properties"]["fap_method"]["enum"], sorted(listed("period", "fap")))
        code = (ROOT / "lib/api/names.cpp").read_text().split("TOLIMAN_TRACK_REASON_NONE")[1].split("}}")[0]
        self.assertEqual(read("track")["$defs"]["line"]["properties"]["reason"]["enum"], re.findall('"([a-z ]+)"', code)[1:])


if __name__ == "__main__":
    unittest.main()
