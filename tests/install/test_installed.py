"""make install, and programs built against the result far from the tree. TOLIMAN_BUILD is the build folder."""
import os
import pathlib
import shutil
import subprocess
import tempfile
import unittest

BUILD = os.environ["TOLIMAN_BUILD"]
PROGRAM = r"""
#include <stdio.h>
#include <toliman/toliman.h>
int main(void) {
    toliman_period *period;
    if (toliman_period_create(0.01, 0.01, 5, NULL, &period) != TOLIMAN_OK)
        return 1;
    toliman_period_destroy(period);
    return puts(toliman_version()) < 0;
}
"""


class Installed(unittest.TestCase):
    def setUp(self):
        kept = tempfile.TemporaryDirectory()
        self.addCleanup(kept.cleanup)
        self.top = pathlib.Path(kept.name)
        self.run_tool("cmake", "--install", BUILD, "--prefix", self.top / "first")
        shutil.move(self.top / "first", self.top / "moved")
        self.lib = self.top / "moved" / "lib"
        (self.top / "p.c").write_text(PROGRAM)
        self.version = (pathlib.Path(BUILD) / "toliman.pc").read_text().split("Version: ")[1].split()[0]

    def run_tool(self, *command):
        path = {} if not hasattr(self, "lib") else {"PKG_CONFIG_PATH": str(self.lib / "pkgconfig")}
        return subprocess.run(command, cwd=self.top, env={**os.environ, **path}, capture_output=True, text=True,
                              check=True).stdout

    def pkg_config(self, *arguments):
        return self.run_tool("pkg-config", *arguments, "toliman").split()

    def test_shared(self):
        self.run_tool("cc", "-std=c99", "-pedantic", "-Werror", "p.c", "-o", "p", *self.pkg_config("--cflags", "--libs"),
                      f"-Wl,-rpath,{self.lib}")
        self.assertEqual(self.run_tool("./p").strip(), self.version)

    def test_static(self):
        libraries = self.pkg_config("--static", "--libs")
        libraries[libraries.index("-ltoliman")] = "-l:libtoliman.a"
        self.run_tool("cc", "p.c", "-o", "p", *self.pkg_config("--cflags"), *libraries)
        self.assertEqual(self.run_tool("./p").strip(), self.version)
        self.assertNotIn("libtoliman", self.run_tool("ldd", "p"))

    def test_program_and_manual(self):
        self.assertIn(self.version, self.run_tool(self.top / "moved" / "bin" / "toliman", "--version"))
        self.assertIn(str(self.top / "moved"), self.run_tool("ldd", self.top / "moved" / "bin" / "toliman"))
        self.assertTrue((self.top / "moved" / "share" / "man" / "man1" / "toliman.1").is_file())

    @unittest.skipUnless((pathlib.Path(BUILD) / "bin" / "toliman-mpi").is_file(), "built without MPI")
    def test_mpi(self):
        self.assertIn(str(self.top / "moved"), self.run_tool("ldd", self.top / "moved" / "bin" / "toliman-mpi"))
        self.assertTrue((self.top / "moved" / "share" / "man" / "man1" / "toliman-mpi.1").is_file())


if __name__ == "__main__":
    unittest.main()
