"""Whatever the program prints as JSON is as tools/schema says; program.py holds every output of every test against it."""
import functools
import json
import pathlib

import jsonschema

FOLDER = pathlib.Path(__file__).resolve().parents[2] / "tools" / "schema"
MOST = 100  # lines of one output: those of a table are alike


@functools.lru_cache(None)
def validators():
    """By the name that an output gives itself as `schema`."""
    found = {}
    for path in FOLDER.glob("*.json"):
        whole = json.loads(path.read_text())
        parts = [part["$ref"] for part in whole["oneOf"]] if "oneOf" in whole else [None]
        for part in parts:
            body = whole["$defs"][part.split("/")[-1]] if part else whole
            one = {"$ref": part, "$defs": whole["$defs"]} if part else whole
            found[body["properties"]["schema"]["const"]] = jsonschema.Draft202012Validator(one)
    return found


def check(text):
    """text: what was printed, one JSON text or lines of JSON; anything else passes."""
    if not text.startswith("{"):
        return
    pieces = text.splitlines()[:MOST] if text.startswith('{"') else [text]
    for piece in pieces:
        try:
            value = json.loads(piece, parse_constant=lambda word: 1 / 0)
        except ValueError:
            continue  # cut off by a signal
        validators()[value["schema"]].validate(value)
