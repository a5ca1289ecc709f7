"""repr() in one line and a notebook view for every public class, and the names that dir() and `import *` show."""
import html.parser
import inspect
import pydoc
import unittest

import numpy

from package import toliman
from shown_objects import estimate, objects

try:
    from astropy.table import Table
except ImportError:
    Table = None

LONGEST = 160


class Balanced(html.parser.HTMLParser):
    """Raises if a tag is not closed; collects the text."""

    def __init__(self, text):
        super().__init__()
        self.open, self.text = [], ""
        self.feed(text)
        if self.open:
            raise AssertionError(f"{self.open} is not closed in {text[:200]}")

    def handle_starttag(self, tag, attrs):
        if tag != "br":
            self.open.append(tag)

    def handle_endtag(self, tag):
        if self.open.pop() != tag:
            raise AssertionError(f"</{tag}> closes no <{tag}>")

    def handle_data(self, data):
        self.text += data


def public_classes():
    for name in toliman.__all__:
        thing = getattr(toliman, name)
        if inspect.isclass(thing) and not issubclass(thing, (Exception, Warning)):
            yield name, thing


class Shown(unittest.TestCase):
    def test_every_class(self):
        for name, thing in public_classes():
            self.assertTrue(hasattr(thing, "_repr_html_"), name)
            self.assertIsNot(thing.__repr__, object.__repr__, name)
            self.assertNotIn("dataclasses", getattr(thing.__repr__, "__qualname__", ""), name)
        self.assertGreater(len(list(public_classes())), 60)

    def test_every_object(self):
        for name, thing in objects().items():
            with self.subTest(name):
                text = repr(thing)
                self.assertLessEqual(len(text), LONGEST)
                self.assertNotIn("\n", text)
                self.assertNotIn(" object at 0x", text)
                self.assertGreater(len(Balanced(thing._repr_html_()).text), 20)

    def test_numbers_that_matter(self):
        shown = objects()
        self.assertEqual(repr(shown["measurements"]), "<Measurements: 40 of kind reduced in arcsec, 4 functions>")
        self.assertEqual(repr(shown["frame"])[:38], "Frame(pixels=<8x6 float64>, frame_id=0")
        self.assertEqual(repr(shown["records"]), "<9 records of Record>")
        self.assertIn("alpha Centauri AB, observer circular", repr(shown["sky"]))
        self.assertIn("1 more", Balanced(toliman.Rows([toliman.machine()] * 21)._repr_html_()).text)
        frame = toliman.Frame(numpy.zeros((2, 2)), 1, 2, session="<b>")
        self.assertIn("&lt;b&gt;", frame._repr_html_())

    def test_closed(self):
        with toliman.Periodogram(0.1, 0.1, 3) as periodogram:
            pass
        simulator = toliman.Simulator("chapter.json")
        self.assertEqual(simulator.info.rows, 256)  # which is kept
        simulator.close()
        calibration = toliman.calibration._SoFar._adopt(None)  # as progress functions get it
        tracker = toliman.Tracker(estimate, 0.001, 0.001, 100, estimator_id=7, sigma=1.0, rows=8, cols=6,
                                  image_shape=(8, 6))
        view = tracker.period
        self.assertEqual(view.to_table().meta["object"] if Table else "View", "View")
        tracker.close()
        for thing, name in ((periodogram, "Periodogram"), (simulator, "Simulator"), (calibration, "Calibration"),
                            (view, "View")):
            self.assertEqual(repr(thing), f"<closed {name}>")
            self.assertEqual(Balanced(thing._repr_html_()).text, repr(thing))
        with self.assertRaisesRegex(ValueError, "^this Calibration is closed"):
            calibration.values()


class Help(unittest.TestCase):
    def test_names(self):
        self.assertEqual(dir(toliman), sorted(toliman.__all__))
        names = {}
        exec("from toliman import *", names)
        self.assertEqual(set(names) - {"__builtins__"}, set(toliman.__all__))
        self.assertFalse([name for name in toliman.__all__ if inspect.ismodule(names[name])])

    def test_signatures(self):
        """Each parameter of a public function has a type."""
        for name in toliman.__all__:
            thing = getattr(toliman, name)
            if not callable(thing) or isinstance(thing, type) and issubclass(thing, (Exception, list, numpy.ndarray)):
                continue
            for member, value in [(name, thing)] + (inspect.getmembers(thing, inspect.isfunction)
                                                    if inspect.isclass(thing) else []):
                if not member.startswith("_"):
                    for place, one in enumerate(inspect.signature(value).parameters.values()):
                        self.assertTrue(one.annotation is not one.empty or place == 0 and one.name == "self",
                                        f"{name}.{member}: {one}")

    def test_texts_are_of_python(self):
        """No names of C that Python does not have, nor traces of the generator."""
        for name in toliman.__all__:
            text = pydoc.plain(pydoc.render_doc(getattr(toliman, name)))
            for trace in (r"Alias for field", r"\(promise:", r"\bFlags?: ", r"\bas a word\b",
                          r"\btoliman_(?!track_record|fit_result|frame_goodness|bank_result|coadd_options)\w+\b"):
                self.assertNotRegex(text, trace, name)
        self.assertIn("long (bool): period above T/2", toliman.Peak.__doc__)
        self.assertIn("verdict (str): accepted, duplicate,", toliman.Outcome.__doc__)
        self.assertIn('"tied": squared distance', toliman.Training.__doc__)
        self.assertIn("first frequency", toliman.Grid.f0.__doc__)
        for kind, line in ((toliman.Plan, "open_area_m2 (float): of the pupil\n"),
                           (toliman.SkyInfo, "altitude_km (tuple[float, ...]): lowest and highest of all states")):
            self.assertIn(f"    {line}", kind.__doc__)  # without the comment of their group
        self.assertIn("inclination_deg", toliman.Planets.samples.__doc__)


if __name__ == "__main__":
    unittest.main()
