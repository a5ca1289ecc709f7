"""Tests make install, and programs in every language built against the result: each finds the power of a pure sine at
its frequency, which is 1. The installation is moved first: it must not depend on where it was made. TOLIMAN_BUILD is
the build folder."""
import os
import pathlib
import re
import subprocess
import tempfile
import unittest

BUILD = pathlib.Path(os.environ["TOLIMAN_BUILD"])
ROOT = pathlib.Path(__file__).resolve().parents[2]
VERSION = (BUILD / "toliman.pc").read_text().split("Version: ")[1].split()[0]
FORMATS = "share/doc/toliman/formats.md"  # cited by the headers
C = r"""
#include <math.h>
#include <stdio.h>
#include <toliman/toliman.h>
int main(void) {
    toliman_period *period;
    toliman_machine machine = TOLIMAN_MACHINE_INIT;
    double power[10];
    if (toliman_period_create(0.05, 0.01, 10, NULL, &period) != TOLIMAN_OK)
        return 1;
    for (int i = 0; i < 100; i++)
        if (toliman_period_push(period, i, sin(2 * acos(-1.0) * i / 10), 1.0) != TOLIMAN_OK)
            return 2;
    if (toliman_period_query_power(period, TOLIMAN_PERIOD_POWER_STANDARD, 0, 10, power) != TOLIMAN_OK)
        return 3;
    toliman_period_destroy(period);
    if (toliman_get_machine(&machine) != TOLIMAN_OK || machine.blas_core[0] == '\0')
        return 4;
    printf("%s %.12f\n", toliman_version(), power[5]);
    return 0;
}
"""
CPP = r"""
#include <cmath>
#include <cstdio>
#include <toliman/toliman.hpp>
int main() {
    auto period = toliman::make<toliman::periodogram>(toliman_period_create, 0.05, 0.01, 10, nullptr);
    for (int i = 0; i < 100; i++)
        toliman::check(toliman_period_push(period.get(), i, std::sin(2 * std::acos(-1.0) * i / 10), 1.0));
    double power[10];
    toliman::check(toliman_period_query_power(period.get(), TOLIMAN_PERIOD_POWER_STANDARD, 0, 10, power));
    std::printf("%s %.12f\n", toliman_version(), power[5]);
}
"""
PYTHON = """
import importlib.metadata, math, toliman
with toliman.Periodogram(0.05, 0.01, 10) as periodogram:
    for i in range(100):
        periodogram.push(i, math.sin(2 * math.pi * i / 10))
    print(importlib.metadata.version("toliman"), "%.12f" % periodogram.power()[5])
"""
CMAKE = """
cmake_minimum_required(VERSION 3.25)
project(mine LANGUAGES {language})
find_package(toliman {VERSION} REQUIRED {components})
add_executable(mine {source})
target_link_libraries(mine PRIVATE {target} m)
"""
EXPECTED = f"{VERSION} 1.000000000000\n"


class Installed(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        kept = tempfile.TemporaryDirectory()
        cls.addClassCleanup(kept.cleanup)
        cls.top = pathlib.Path(kept.name)
        (cls.top / "p.c").write_text(C)
        (cls.top / "p.cpp").write_text(CPP)
        cls.run_tool("cmake", "--install", BUILD, "--prefix", cls.top / "first")
        cls.prefix = (cls.top / "first").rename(cls.top / "moved")
        cls.lib, cls.share = cls.prefix / "lib", cls.prefix / "share"

    @classmethod
    def run_tool(cls, *command, folder=None, **more):
        path = {} if not hasattr(cls, "lib") else {"PKG_CONFIG_PATH": str(cls.lib / "pkgconfig")}
        environment = {name: value for name, value in os.environ.items() if not name.startswith("TOLIMAN")}
        done = subprocess.run(command, cwd=folder or cls.top, env={**environment, **path, **more}, capture_output=True,
                              text=True)
        if done.returncode != 0:
            raise AssertionError(f"{command}: {done.returncode}\n{done.stdout}{done.stderr}")
        return done.stdout

    def pkg_config(self, *arguments):
        return self.run_tool("pkg-config", *arguments, "toliman").split()

    def test_c_shared(self):
        self.run_tool("cc", "-std=c99", "-pedantic", "-Werror", "p.c", "-o", "p", *self.pkg_config("--cflags", "--libs"),
                      "-lm", f"-Wl,-rpath,{self.lib}")
        self.assertEqual(self.run_tool("./p"), EXPECTED)
        self.assertIn(str(self.lib), self.run_tool("ldd", "p"))

    def test_c_static(self):
        libraries = self.pkg_config("--static", "--libs")
        libraries[libraries.index("-ltoliman")] = "-l:libtoliman.a"
        self.run_tool("cc", "p.c", "-o", "p", *self.pkg_config("--cflags"), *libraries)
        self.assertEqual(self.run_tool("./p"), EXPECTED)
        self.assertNotIn("libtoliman", self.run_tool("ldd", "p"))

    def test_fortran(self):
        """The example's period of nu Ophiuchi."""
        libraries = self.pkg_config("--static", "--libs")
        libraries[libraries.index("-ltoliman")] = "-l:libtoliman.a"
        self.run_tool("gfortran", "-O0", "-c", self.share / "toliman/fortran/toliman.f90", ROOT / "examples/fortran/search.f90")
        for how in ([*self.pkg_config("--libs"), f"-Wl,-rpath,{self.lib}"], libraries):
            self.run_tool("gfortran", "search.o", "toliman.o", "-o", "p", *how)
            found = self.run_tool("./p", ROOT / "examples/data/nu_oph_rv.csv")
            self.assertIn("period 531.93 +- 1.69 days", found)

    def test_python(self):
        """With Debian's Python, without configuring the library's path."""
        packages = self.lib / "python3/dist-packages"
        self.assertEqual(self.run_tool("/usr/bin/python3", "-c", PYTHON, PYTHONPATH=str(packages)), EXPECTED)
        found = self.run_tool("/usr/bin/python3", "-c", "import toliman, re; toliman.version(); print(toliman.__file__, re.findall("
                              "r'\\S*libtoliman\\S*', open('/proc/self/maps').read())[0])", PYTHONPATH=str(packages))
        for path in found.split():
            self.assertIn(str(self.prefix), path)

    def build_by_cmake(self, language, source, target, components=""):
        folder = pathlib.Path(tempfile.mkdtemp(dir=self.top))
        (folder / "CMakeLists.txt").write_text(CMAKE.format(VERSION=VERSION, **locals()).replace(source, f"../{source}"))
        self.run_tool("cmake", "-S", folder, "-B", folder / "b", f"-DCMAKE_PREFIX_PATH={self.prefix}")
        self.run_tool("cmake", "--build", folder / "b")
        self.assertEqual(self.run_tool(folder / "b" / "mine"), EXPECTED)
        return self.run_tool("ldd", folder / "b" / "mine")

    def test_cmake(self):
        self.assertIn(str(self.lib), self.build_by_cmake("C", "p.c", "toliman::toliman"))
        self.assertNotIn("libtoliman", self.build_by_cmake("CXX", "p.cpp", "toliman::toliman_static", "COMPONENTS static"))

    def test_static_library_has_no_other_names(self):
        """A name of the library's internals could collide with one of the host's."""
        table = self.run_tool("nm", "-g", "--defined-only", self.lib / "libtoliman.a")
        names = {line.split()[-1] for line in table.splitlines() if len(line.split()) == 3}
        self.assertEqual({name for name in names if not name.startswith("toliman_")}, set())
        self.assertIn("toliman_period_push", names)

    def test_cmake_refuses(self):
        folder = pathlib.Path(tempfile.mkdtemp(dir=self.top))
        for version, components, text in (("9", "", "compatible"), ("", "COMPONENTS nonsense", "FALSE")):
            (folder / "CMakeLists.txt").write_text("cmake_minimum_required(VERSION 3.25)\nproject(mine LANGUAGES C)\n"
                                                   f"find_package(toliman {version} REQUIRED {components})\n")
            with self.assertRaisesRegex(AssertionError, text):
                self.run_tool("cmake", "-S", folder, "-B", folder / "b", f"-DCMAKE_PREFIX_PATH={self.prefix}")

    def test_static_library_requires_its_dependencies(self):
        """Without the pkg-config files of its dependencies, the shared library is found, the static one is not,
        and the reason is reported."""
        folder, text = pathlib.Path(tempfile.mkdtemp(dir=self.top)), "find_package(toliman REQUIRED COMPONENTS static)"
        hidden = {"PKG_CONFIG_LIBDIR": str(folder), "PKG_CONFIG_PATH": str(folder)}
        for find, refused in ((text.replace(" COMPONENTS static", ""), False), (text, True)):
            (folder / "CMakeLists.txt").write_text(f"cmake_minimum_required(VERSION 3.25)\nproject(m LANGUAGES C)\n{find}\n"
                                                   "if(TARGET toliman::toliman_static)\nmessage(FATAL_ERROR x)\nendif()\n")
            command = ("cmake", "-S", folder, "-B", folder / "b", f"-DCMAKE_PREFIX_PATH={self.prefix}")
            if not refused:
                self.run_tool(*command, **hidden)
                continue
            with self.assertRaisesRegex(AssertionError, "toliman_static needs pkg-config"):
                self.run_tool(*command, **hidden)

    def test_program(self):
        program = self.prefix / "bin" / "toliman"
        self.assertIn(VERSION, self.run_tool(program, "--version"))
        self.assertIn(str(self.prefix), self.run_tool("ldd", program))
        folder = pathlib.Path(tempfile.mkdtemp(dir=self.top))
        self.run_tool(program, "psf", "chapter.json", "--out", "psf.npy", folder=folder)
        self.assertEqual((folder / "psf.npy").stat().st_size, 256 + 8 * 256 * 256)

    def test_report(self):
        """By the Python package of the same prefix."""
        folder = pathlib.Path(tempfile.mkdtemp(dir=self.top))
        (folder / "a.json").write_text('{"schema": "toliman-bench/1", "machine": {}, "rows": []}')
        self.assertEqual(self.run_tool(self.prefix / "bin" / "toliman", "report", folder), f"{folder}/report/report.html\n")
        self.assertIn("toliman report", (folder / "report" / "report.html").read_text())
        (self.lib / "python3").rename(self.lib / "hidden")
        self.addCleanup((self.lib / "hidden").rename, self.lib / "python3")
        with self.assertRaisesRegex(AssertionError, "report needs the Python package toliman: apt-get install python3-toliman"):
            self.run_tool(self.prefix / "bin" / "toliman", "report", folder)

    def test_files(self):
        names = {str(path.relative_to(self.prefix)) for path in self.prefix.rglob("*") if not path.is_dir()}
        for name in ("share/man/man1/toliman.1.gz", "share/man/man1/toliman-run.1.gz", "share/man/man3/libtoliman.3.gz",
                     "share/bash-completion/completions/toliman", "share/zsh/site-functions/_toliman",
                     "share/fish/vendor_completions.d/toliman.fish", "share/toliman/scenes/chapter.json",
                     "share/toliman/scenes/g2v.csv", "share/toliman/schema/toliman-scene-1.schema.json", FORMATS):
            self.assertIn(name, names)
        headers = {f"include/toliman/{path.name}" for path in (ROOT / "include/toliman").glob("*.h*")}
        headers = {name.replace("version.h.in", "version.h") for name in headers}
        self.assertEqual({name for name in names if name.startswith("include/")}, headers)
        documents = {f"share/doc/toliman/{path.name}" for path in (ROOT / "tools/docs").glob("*.md")}
        documents.remove("share/doc/toliman/README.md")
        self.assertLessEqual(documents, names)
        unasked = [name for name in names - documents if re.search(r"__pycache__|\.md$|\.in$|share/doc", name)]
        self.assertEqual(unasked, [])

    def test_nothing_names_the_tree(self):
        for path in (self.lib / "cmake/toliman").iterdir():
            self.assertNotIn(str(BUILD), path.read_text())
            self.assertNotRegex(path.read_text(), r'"/[a-z]+/[^"]*lib')

    @unittest.skipUnless((BUILD / "bin" / "toliman-mpi").is_file(), "built without MPI")
    def test_mpi(self):
        self.assertIn(str(self.prefix), self.run_tool("ldd", self.prefix / "bin" / "toliman-mpi"))
        self.assertTrue((self.share / "man/man1/toliman-mpi.1.gz").is_file())


class Staged(unittest.TestCase):
    def test_destdir(self):
        """With DESTDIR, as packagers do: all files below it, none outside."""
        with tempfile.TemporaryDirectory() as top:
            subprocess.run(["cmake", "--install", BUILD, "--prefix", "/opt/toliman"], check=True, capture_output=True,
                           env={**os.environ, "DESTDIR": top})
            self.assertEqual(os.listdir(top), ["opt"])
            done = subprocess.run([f"{top}/opt/toliman/bin/toliman", "--version"], capture_output=True, text=True)
            self.assertIn(VERSION, done.stdout)


if __name__ == "__main__":
    unittest.main()
