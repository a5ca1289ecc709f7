"""The API reference: Doxygen gives no warning, every function has a description, every header's diagram all its functions."""
import html
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools/gen"))
import model

SYMBOLS = re.findall(r"\b(toliman_\w+);", (ROOT / "lib/api/toliman.sym").read_text())
HEADERS = sorted(path.stem for path in (ROOT / "include/toliman").glob("*.h") if path.stem not in ("toliman", "export"))
DOCS = {item.name: item.doc for item in model.read(ROOT).items}
MODULES = "measure|sim|cae|calibration|bank|linear|fit|coadd|components|mask|ingest|period|planet|series|sky|track"


def make(output, top=ROOT):
    """What Doxygen says of a tree, "" if nothing."""
    done = subprocess.run(["doxygen", "tools/docs/Doxyfile"], cwd=top, capture_output=True, text=True,
                          env={**os.environ, "OUTPUT": str(output), "VERSION": "0"})
    return done.stderr + done.stdout + ("" if done.returncode == 0 else f"ended with {done.returncode}")


class Reference(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        kept = tempfile.TemporaryDirectory()
        cls.addClassCleanup(kept.cleanup)
        cls.folder = pathlib.Path(kept.name)
        cls.said = make(cls.folder)

    def page(self, name):
        return (self.folder / "html" / name).read_text().replace("&#160;", "&nbsp;")  # of older and newer Doxygen

    def test_no_warnings(self):
        self.assertEqual(self.said, "")

    def assert_described(self, name, page):
        """The page has the comment of a declaration: its first words and its last ones."""
        text, doc = (" ".join(re.findall(r"\w+", part)) for part in (html.unescape(re.sub("<[^>]*>", "", page)), DOCS[name]))
        self.assertGreater(len(doc.split()), 1, name)
        for part in (doc.split()[:8], doc.split()[-8:]):
            self.assertIn(" ".join(part), text, name)

    def test_every_function_is_described(self):
        pages = {header: self.page(f"{header.replace('_', '__')}_8h.html") for header in HEADERS}
        for name in SYMBOLS:
            found = [page for page in pages.values() if f"&#9670;&nbsp;</a></span>{name}()" in page]
            self.assertEqual(len(found), 1, name)
            item = found[0].split(f"&#9670;&nbsp;</a></span>{name}()")[1].split('<h2 class="memtitle">')[0]
            self.assert_described(name, item.split('<div class="memdoc">')[1])

    def test_every_struct_is_described(self):
        pages = list((self.folder / "html").glob("structtoliman__*.html"))
        self.assertGreater(len(pages), 25)
        for path in pages:
            name = path.stem.replace("struct", "", 1).replace("__", "_")
            self.assert_described(name, path.read_text().split("Detailed Description")[-1])

    def test_the_core_suffices_for_the_first_examples(self):
        """The 15 functions of its diagram, destructors, properties and the name of a status."""
        first = (ROOT / "include/toliman/core.h").read_text().split("*/")[0].replace("save_file, load_file", "cae_save_file cae_load_file")
        core = {name for name in SYMBOLS if re.search(rf"\b{name.removeprefix('toliman_')}\b", first)}
        self.assertEqual(len(core), 15, core)
        more = re.compile(r"toliman_(\w+_destroy|\w+_get_info|sim_get_series|constant_name|period_query_fit|period_push_many)")
        for example in ("first_light", "period"):
            used = set(re.findall(r"\b(toliman_\w+)\(", (ROOT / f"examples/c/{example}.c").read_text()))
            self.assertEqual({name for name in used - core if not more.fullmatch(name)}, set(), example)

    def test_diagrams_have_all_functions_of_their_headers(self):
        drawn = set()
        for header in HEADERS:
            text = (ROOT / "include/toliman" / f"{header}.h").read_text()
            first = text.split("*/")[0]
            self.assertIn("Data flow", first)
            names = [name for name in SYMBOLS if re.search(rf"^(?! \*).*\b{name}\(", text, re.M)]
            drawn.update(names)
            missing = [name for name in names
                       if not re.search(rf"\b{re.sub(f'^toliman_({MODULES})_', '', name)}\b", first)]
            self.assertEqual(missing, [], header)
        self.assertEqual(drawn, set(SYMBOLS))


class Warnings(unittest.TestCase):
    def test_a_reference_to_nothing_is_told(self):
        with tempfile.TemporaryDirectory() as folder:
            top = pathlib.Path(folder)
            shutil.copytree(ROOT / "tools/docs", top / "tools/docs")
            (top / "include/toliman").mkdir(parents=True)
            (top / "include/toliman/base.h").write_text("/* A file. */\n\n/* Cuts a_<b>. */\nvoid cut(void);\n")
            (top / "tools/docs/index.dox").write_text("/** \\mainpage X\n\\ref base.h and \\ref swim.h */\n")
            said = make(top, top)
            self.assertIn("swim.h", said)
            self.assertNotIn("base.h", said)
            self.assertIn("ended with 1", said)


if __name__ == "__main__":
    unittest.main()
