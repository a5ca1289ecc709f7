"""Inputs that once failed: each row of tests/cases/*/cases.json is a call and the one result that it must have.
tests/cases/README.md describes the rows."""
import collections
import ctypes  # noqa: F401 (calls use it)
import gzip
import json
import logging
import os
import pathlib
import re
import shlex
import shutil
import sys
import unittest
import warnings

import numpy
from program import PROGRAM, ROOT, ProgramTest

os.environ.setdefault("TOLIMAN_LIBRARY", str(pathlib.Path(PROGRAM).parents[1] / "lib" / "libtoliman.so"))
sys.path.append(str(ROOT / "build" / "python"))
import toliman  # noqa: E402
from toliman._library import library  # noqa: E402, F401 (calls use it)

CASES = ROOT / "tests" / "cases"
LARGEST = 12000  # bytes of a file
KEYS = {"call", "is", "within", "refused", "says", "was", "open"}
DAY = 86400 * 10**9
START = toliman.parse_time("2027-01-01")
ORBIT = " --altitude 600 --exposure 60"
LOW = " --system alpha-cen" + ORBIT
BOTH = " --star-masses 1.08,.91 --parallax 750"


def same(found, expected, within):
    """Whether two results agree: numbers to a relative error, lists item by item."""
    if isinstance(expected, list):
        return len(found) == len(expected) and all(same(*pair, within) for pair in zip(found, expected))
    if isinstance(expected, (str, bool, type(None))):
        return found == expected
    return bool(abs(found - expected) <= within * abs(expected))


class Said(logging.Handler):
    """Keeps what the library and the program say."""

    text = ""

    def emit(self, record):
        self.text += record.getMessage() + "\n"


class Calls(ProgramTest):
    """What calls may use, in addition to the names of this file."""

    def setUp(self):
        super().setUp()
        self.addCleanup(os.chdir, os.getcwd())
        os.chdir(self.folder)
        self.enterContext(warnings.catch_warnings(action="ignore"))
        self.said, logger = Said(), logging.getLogger("toliman")
        logger.propagate = False
        logger.addHandler(self.said)
        self.addCleanup(logger.removeHandler, self.said)
        self.states = 0
        self.names = {**globals(), **{name: getattr(self, name) for name in vars(Calls) if name[0] != "_"}}

    def program(self, line, code=0):
        """The output of the program: text, or the object of --json."""
        done = self.run_program(*shlex.split(line))
        self.said.text += done.stderr
        self.assertEqual(done.returncode, code, done.stderr)
        return json.loads(done.stdout) if "--json" in line else done.stdout

    def table(self, name):
        """A table: rows, first time, value and sigma, unit, rows skipped."""
        read = toliman.Measurements(name)
        return [len(read), read.t[0], read.y[0], read.sigma[0], read.info.unit_name, read.info.left_out]

    def candidate(self, line, code=0):
        """The first candidate of `planet`."""
        return self.program(f"planet {line} --samples 200 --json", code)["candidates"][0]

    def simulator(self, name, **noise):
        scene = json.loads((self.folder / name).read_text())
        scene["noise"] = {**scene.get("noise", {}), **noise}
        return toliman.Simulator(scene, folder=self.folder)

    def fitted(self, change, **noise):
        """The fit of a changed frame of scene.json."""
        return toliman.Fit(self.simulator("scene.json", **noise)).frame(change(self.simulator("scene.json").frame(0)))[0]

    def pushed(self, change):
        """The verdict of a tracker on a changed frame of scene.json."""
        simulator = self.simulator("scene.json")
        with toliman.Tracker(toliman.Fit(simulator), 0.01, 0.01, 20) as tracker:
            frame = toliman.Frame(change(simulator.frame(0)), session="s", frame_id=0, camera_ns=0)
            return tracker.push(frame).verdict

    def mean_nm(self, name):
        """The mean wavelength of the photons of star A."""
        wavelengths, weights, _ = toliman.Simulator(name).spectrum()
        return 1e9 * (wavelengths * weights).sum() / weights.sum()

    def changed(self, late_s=0, factor=1, sigma=1e-6, outlier=0, rows=None):
        """separations.csv with other times, unit, sigma, one other value, or fewer rows."""
        lines = []
        for k, line in enumerate((self.folder / "separations.csv").read_text().splitlines()[1:][:rows]):
            t, y, _ = line.split(",")
            late = numpy.datetime64(t) + numpy.timedelta64(late_s, "s")
            lines.append(f"{late},{(float(y) + outlier * (k == 7)) * factor:.9f},{sigma}\n")
        (self.folder / "changed.csv").write_text("t,y,sigma\n" + "".join(lines))
        return "changed.csv"

    def edited(self, path, pattern, new):
        """A copy of a file with other text."""
        path = self.folder / path
        text = re.sub(pattern, new, path.read_text(encoding="latin-1"), flags=re.M)
        (self.folder / ("edited_" + path.name)).write_text(text, encoding="latin-1")
        return "edited_" + path.name

    def packed(self, name):
        (self.folder / (name + ".gz")).write_bytes(gzip.compress((self.folder / name).read_bytes()))
        return name + ".gz"

    def tracked(self, name):
        """The frame lines of `track` with the template of mini.json, in a new state folder."""
        self.states += 1
        out = self.program(f"track --template mini.json --mission-days 100 --dtype u32le --state state{self.states} {name}")
        return [line for line in map(json.loads, out.splitlines()) if line["schema"] == "toliman-frame/2"]

    def first(self, name, more=""):
        """The first frame line of `track` on a file, None without one."""
        self.states += 1
        shutil.copy(CASES / "files" / "mini.json", self.folder)
        out = self.program(f"track --template mini.json --mission-days 100 --state state{self.states} {more} {name}")
        return next((line for line in map(json.loads, out.splitlines()) if line["schema"] == "toliman-frame/2"), None)

    def stamp(self, **cards):
        """The time of a FITS file with these keywords, s of TAI."""
        cards = {"SIMPLE": "T", "BITPIX": 32, "NAXIS": 2, "NAXIS1": 32, "NAXIS2": 32, **cards}
        header = "".join(f"{key.replace('_', '-'):<8}= {value:>20}".ljust(80) for key, value in cards.items()) + "END"
        pixels = self.simulator("mini.json").frame(0).astype(">i4").tobytes()
        (self.folder / "one.fits").write_bytes(header.ljust(2880).encode() + pixels + bytes(-len(pixels) % 2880))
        return self.tracked("one.fits")[0]["tai_ns"] / 1e9

    def side_file(self, session, side, lines):
        same_in_all = {"nframes_dropped": 0, "roi_label": "r", "n_rows": side, "n_cols": side, "session_id": session}
        text = "".join(json.dumps({**same_in_all, **line}) + "\n" for line in lines)
        (self.folder / f"{session}_meta.jsonl").write_text(text)

    def verdicts(self, lost=None, kept=0, restart=0, **more):
        """How many frames of a pair have each verdict. Of the lost frame `kept` bytes are there and no line; the camera
        restarts at a frame; each line has more keys."""
        frames = self.simulator("mini.json").frames().astype("<u4")
        data = [one.tobytes()[:kept if k == lost else None] for k, one in enumerate(frames)]
        (self.folder / "s_frames.bin").write_bytes(b"".join(data))
        ids = {k: k - restart * (0 < restart <= k) for k in range(len(frames)) if k != lost}
        self.side_file("s", 32, [{"frame_id": ids[k], "timestamp_ns": ids[k] * DAY, "host_time": 86400 * k, **more} for k in ids])
        counts = collections.Counter(line["verdict"] for line in self.tracked("s_meta.jsonl"))
        return sorted(map(list, counts.items()))

    def reasons(self, lines, frames, **options):
        """The events, other than frames, of a pair with one frame of 2 x 2 px per minute."""
        numpy.arange(4 * frames, dtype="<u4").tofile("t_frames.bin")
        self.side_file("t", 2, [{"frame_id": k, "timestamp_ns": 60 * k * 10**9, "host_time": 60 * k} for k in range(lines)])
        return [event.reason for event in toliman.Pair("t_meta.jsonl", "u32le", **options).events() if event.kind != "frame"]


class Cases(Calls):
    def check(self, row):
        self.said.text = ""
        if "refused" in row:
            with self.assertRaises(toliman.Error) as caught:
                eval(row["call"], self.names)
            found, row = [type(caught.exception).__name__, caught.exception.field], {**row, "is": row["refused"]}
        else:
            found = eval(row["call"], self.names)
        if "is" in row:
            self.assertTrue(same(found, row["is"], row.get("within", 1e-12)), f"{found} for {row['is']}")
        self.assertIn(row.get("says", ""), self.said.text)

    def check_all(self, kind):
        shutil.copytree(CASES / kind, self.folder, dirs_exist_ok=True)
        for row in json.loads((self.folder / "cases.json").read_text()):
            with self.subTest(row["call"], was=row.get("was")):
                self.check(row)

    def test_optics(self):
        self.check_all("optics")

    def test_files(self):
        self.check_all("files")

    def test_period(self):
        self.check_all("period")

    def test_faults(self):
        self.check_all("faults")

    def test_structure(self):
        self.check_all("structure")

    def test_public(self):
        self.check_all("public")

    def test_every_row_tests_something(self):
        for file in CASES.glob("*/cases.json"):
            text = file.read_text() + pathlib.Path(__file__).read_text()
            for row in json.loads(file.read_text()):
                self.assertTrue({"call"} <= row.keys() <= KEYS and row.keys() & {"is", "refused", "says"}, row)
                self.assertTrue(file.parent.name == "public" or "was" in row, row)
                self.assertLessEqual(len(row.get("was", "").split()), 6, row)
            for used in file.parent.rglob("*.*"):
                self.assertLess(used.stat().st_size, LARGEST, used)
                self.assertTrue(used == file or used.stem in text, f"{used}: no row reads it")

    def test_another_result_fails(self):
        (self.folder / "bad.csv").write_text("t,y\n1,2\n2,x\n")
        bad = "toliman.Measurements('bad.csv')"
        self.check({"call": bad, "refused": ["InputError", "y"]})
        self.check({"call": "[1, 'a', None]", "is": [1 + 1e-9, "a", None], "within": 2e-9})
        for row in ({"call": bad, "refused": ["InputError", "t"]}, {"call": bad, "refused": ["StateError", "y"]},
                    {"call": "1", "refused": ["InputError", "y"]}, {"call": "1.0", "is": 1 + 1e-9}, {"call": "'a'", "is": "b"},
                    {"call": "[1]", "is": [1, 2]}, {"call": "toliman.Sky(altitude_km=600)", "says": "nothing such"}):
            with self.assertRaises(AssertionError, msg=row):
                self.check(row)


if __name__ == "__main__":
    unittest.main()
