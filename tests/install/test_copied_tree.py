"""Tests that make in a copy of a tree with its build folder refuses to build the sources that it was copied from. CMake
and the installation of packages are replaced by stand-ins that record their calls."""
import os
import pathlib
import shutil
import subprocess
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]


class CopiedTree(unittest.TestCase):
    def setUp(self):
        kept = tempfile.TemporaryDirectory()
        self.addCleanup(kept.cleanup)
        self.top = pathlib.Path(os.path.realpath(kept.name))
        self.tree = self.top / "copy"
        for name in ("Makefile", "tools/cmake/own"):
            (self.tree / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(ROOT / name, self.tree / name)
        for name in ("bin/cmake", "bin/cpack", "bin/ctest", "copy/tools/deps/install"):
            path = self.top / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(f'#!/bin/sh\necho {path.name} "$@" >>{self.top}/calls\n')
            path.chmod(0o755)

    def build_of(self, sources, build="build"):
        folder = self.tree / build
        folder.mkdir(exist_ok=True)
        (folder / "build.ninja").touch()
        (folder / "CMakeCache.txt").write_text(f"CMAKE_GENERATOR:INTERNAL=Ninja\nCMAKE_HOME_DIRECTORY:INTERNAL={sources}\n")

    def make(self, *arguments, tree=None):
        """Exit code, output, and the recorded calls."""
        plain = {name: value for name, value in os.environ.items() if name not in ("MAKEFLAGS", "MAKELEVEL", "BUILD")}
        done = subprocess.run(["make", *arguments], cwd=tree or self.tree, text=True, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, env={**plain, "PATH": f"{self.top / 'bin'}:{os.environ['PATH']}"})
        calls = self.top / "calls"
        recorded = calls.read_text() if calls.exists() else ""
        calls.unlink(missing_ok=True)
        return done.returncode, done.stdout, recorded

    def test_another_trees_build_is_refused(self):
        original = self.top / "original"
        original.mkdir()
        for sources in (original, self.top / "gone"):
            self.build_of(sources)
            for target in ("all", "demo", "install", "package", "check", "everything"):
                code, output, calls = self.make(target)
                self.assertEqual((code, calls), (2, ""), target)
                self.assertIn(f"build builds the sources in {sources}, not those in {self.tree}: ", output)
                self.assertIn("`make clean`", output)

    def test_the_ways_out(self):
        self.build_of(self.top / "gone")
        code, output, calls = self.make("BUILD=other")
        self.assertEqual((code, calls.splitlines()[-1].split(" --parallel")[0]), (0, "cmake --build other"), output)
        self.assertEqual(self.make("clean")[0], 0)
        code, output, calls = self.make()
        self.assertEqual((code, calls.splitlines()[1].split(" -G")[0]), (0, "cmake -S . -B build"), output)

    @unittest.skipIf(os.geteuid() == 0, "root may write anywhere")
    def test_a_tree_that_cannot_be_written(self):
        self.tree.chmod(0o500)
        self.addCleanup(self.tree.chmod, 0o700)
        code, output, calls = self.make()
        self.assertEqual((code, calls), (2, ""), output)
        self.assertIn("build: Permission denied: ", output)

    def test_the_trees_own_build_continues(self):
        link = self.top / "link"
        link.symlink_to(self.tree)
        for sources in (self.tree, link):
            for tree in (self.tree, link):
                self.build_of(sources)
                code, output, calls = self.make("install", tree=tree)
                self.assertEqual(code, 0, output)
                self.assertIn("cmake --build build", calls)
                self.assertIn("cmake --install build", calls)


if __name__ == "__main__":
    unittest.main()
