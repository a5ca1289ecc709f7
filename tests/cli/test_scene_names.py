"""Where a scene's name is looked up: the file itself, then the scenes that are shipped."""
import pathlib
import unittest

from program import PROGRAM, SCENES, ProgramTest

SHIPPED = pathlib.Path(PROGRAM).resolve().parents[1] / "share" / "toliman" / "scenes"


class Names(ProgramTest):
    def test_shipped_scene(self):
        done = self.run_program("psf", "chapter.json", "--out", "shipped.npy")
        self.assertEqual((done.returncode, done.stderr), (0, f"toliman: scene {SHIPPED}/chapter.json\n"))
        self.succeed("psf", SCENES / "chapter.json", "--out", "own.npy")
        self.assertEqual((self.folder / "shipped.npy").read_bytes(), (self.folder / "own.npy").read_bytes())
        self.assertEqual(self.succeed("plan", "chapter.json").split("set-up ")[0],
                         self.succeed("plan", SCENES / "chapter.json").split("set-up ")[0])

    def test_own_file_goes_first(self):
        (self.folder / "chapter.json").write_text("{")
        self.refuse(3, "chapter.json: ", arguments=("plan", "chapter.json"))

    def test_nowhere(self):
        for command in ("plan", "run"):
            self.refuse(3, f"none.json: No such file, nor a scene in {SHIPPED}", arguments=(command, "none.json"))
        for name in ("chpater.json", "chapter", "chapter.jsn"):
            self.refuse(3, f"{name}: No such file", "(did you mean chapter.json?)", arguments=("plan", name))
        self.refuse(3, "./chapter.json: No such file", arguments=("plan", "./chapter.json"))


if __name__ == "__main__":
    unittest.main()
