"""The API reference: Doxygen has nothing to say, every function has its text, every room's picture all its functions."""
import html
import os
import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
SYMBOLS = re.findall(r"\b(toliman_\w+);", (ROOT / "lib/api/toliman.sym").read_text())
ROOMS = sorted(path.stem for path in (ROOT / "include/toliman").glob("*.h") if path.stem not in ("toliman", "export"))
MODULES = "sim|cae|linear|components|period|track"


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
        return (self.folder / "html" / name).read_text()

    def test_no_warnings(self):
        self.assertEqual(self.said, "")

    def test_every_function_has_its_text(self):
        """All of the comment that stands above a function in its header, the one that it shares with others too."""
        pages = {room: self.page(f"{room.replace('_', '__')}_8h.html") for room in ROOMS}
        for name in SYMBOLS:
            found = [page for page in pages.values() if f"&#9670;&nbsp;</a></span>{name}()" in page]
            self.assertEqual(len(found), 1, name)
            item = found[0].split(f"&#9670;&nbsp;</a></span>{name}()")[1].split('<h2 class="memtitle">')[0]
            text = html.unescape(re.sub("<[^>]*>", "", item.split('<div class="memdoc">')[1]))
            self.assertRegex(text, r"Since\s+0\.\d", name)

    def test_every_struct_has_its_text(self):
        pages = list((self.folder / "html").glob("structtoliman__*.html"))
        self.assertGreater(len(pages), 25)
        for path in pages:
            self.assertRegex(path.read_text().split("Detailed Description")[-1], r"Since\s+0\.\d", path.name)

    def test_pictures_have_all_functions_of_their_rooms(self):
        drawn = set()
        for room in ROOMS:
            text = (ROOT / "include/toliman" / f"{room}.h").read_text()
            first = text.split("*/")[0]
            self.assertIn("Data flow", first)
            names = [name for name in SYMBOLS if re.search(rf"^(?! \*).*\b{name}\(", text, re.M)]
            drawn.update(names)
            missing = [name for name in names
                       if not re.search(rf"\b{re.sub(f'^toliman_({MODULES})_', '', name)}\b", first)]
            self.assertEqual(missing, [], room)
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
