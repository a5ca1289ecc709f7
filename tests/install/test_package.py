"""Tests make package: contents and dependencies of the Debian packages, and that they work where dpkg -x extracts them,
without root. TOLIMAN_BUILD is the build folder. Prints the sizes."""
import os
import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest

from test_installed import C, EXPECTED, VERSION

BUILD = pathlib.Path(os.environ["TOLIMAN_BUILD"])
RUNTIME = "libtoliman" + VERSION.rsplit(".", 1)[0]
TOOLS = ("dpkg-deb", "dpkg-shlibdeps", "file", "strip")


def run(*command, **more):
    environment = {name: value for name, value in os.environ.items() if not name.startswith("TOLIMAN")}
    done = subprocess.run(list(map(str, command)), env={**environment, **more}, capture_output=True, text=True)
    if done.returncode != 0:
        raise AssertionError(f"{command}: {done.returncode}\n{done.stdout}{done.stderr}")
    return done.stdout


@unittest.skipUnless(all(map(shutil.which, TOOLS)), "not Debian")
class Packages(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        kept = tempfile.TemporaryDirectory()
        cls.addClassCleanup(kept.cleanup)
        cls.top, cls.root = pathlib.Path(kept.name), pathlib.Path(kept.name) / "root"
        run("cpack", "--config", BUILD / "CPackConfig.cmake", "-B", cls.top)
        cls.files = {path.name.split("_")[0]: path for path in cls.top.glob("*.deb")}
        for name, path in sorted(cls.files.items()):
            print(f"{name}: {path.stat().st_size / 1e6:.2f} MB, {cls.field(name, 'Installed-Size')} KiB installed")
            run("dpkg", "-x", path, cls.root)
        cls.usr = cls.root / "usr"

    @classmethod
    def field(cls, package, name):
        return run("dpkg-deb", "-f", cls.files[package], name).strip()

    def contents(self, package):
        return [line.split(None, 5) for line in run("dpkg-deb", "-c", self.files[package]).splitlines()]

    def test_names(self):
        optional = {"toliman-mpi"} if (BUILD / "bin" / "toliman-mpi").is_file() else set()
        self.assertEqual(set(self.files), {RUNTIME, "libtoliman-dev", "toliman", "python3-toliman"} | optional)
        architecture = run("dpkg", "--print-architecture").strip()
        for package in self.files:
            self.assertEqual(self.field(package, "Version"), VERSION)
            expected = "all" if package == "python3-toliman" else architecture
            self.assertEqual(self.field(package, "Architecture"), expected)
            self.assertTrue(self.field(package, "Description"))

    def test_dependencies(self):
        """Debian's libraries by dpkg-shlibdeps, the packages among themselves by version."""
        for library in ("libfftw3-double3", "libopenblas0", "libcjson1", "zlib1g", "liberfa1", "libexpat1", "libc6", "libstdc++6"):
            self.assertIn(library, self.field(RUNTIME, "Depends"))
        self.assertIn("libnetcdf19", self.field(RUNTIME, "Recommends"))
        self.assertIn("libcfitsio10", self.field("toliman", "Depends"))
        for package in ("python3-toliman", "python3-matplotlib", "python3-jinja2"):
            self.assertIn(package, self.field("toliman", "Recommends"))
        if "toliman-mpi" in self.files:  # starts its own ranks, or runs as a single process
            self.assertIn("openmpi-bin", self.field("toliman-mpi", "Depends"))
        for package in set(self.files) - {RUNTIME}:
            self.assertIn(f"{RUNTIME} (= {VERSION})", self.field(package, "Depends"))
        for package in self.files:
            for wanted in re.findall(r"[a-z0-9][a-z0-9.+-]+(?= \(|,|$)", self.field(package, "Depends")):
                if not wanted.startswith("libtoliman"):
                    run("dpkg-query", "-W", wanted)

    def test_contents(self):
        for package in self.files:
            lines = self.contents(package)
            self.assertEqual({line[1] for line in lines}, {"root/root"}, package)
            self.assertEqual([line for line in lines if re.match(r".....w|........w", line[0]) and line[0][0] != "l"], [])
            self.assertTrue(any(line[5].endswith(f"share/doc/{package}/copyright") for line in lines), package)
            self.assertEqual([line[5] for line in lines if "/man/" in line[5] and line[5][-1] not in "/z"], [])
            folder = self.top / package
            run("dpkg-deb", "-e", self.files[package], folder)
            sums = dict(reversed(line.split(None, 1)) for line in (folder / "md5sums").read_text().splitlines())
            self.assertEqual(len(sums), sum(line[0][0] == "-" for line in lines))
            run("sh", "-c", f"cd {self.root} && md5sum --quiet -c {folder}/md5sums")
        names = [line[5] for line in self.contents(RUNTIME) if line[0][0] != "d"]
        self.assertEqual([name for name in names if "doc" not in name and "libtoliman.so.0." not in name], [])
        self.assertIn(f"libtoliman {VERSION.rsplit('.', 1)[0]} {RUNTIME}", (self.top / RUNTIME / "shlibs").read_text())
        self.assertIn("ldconfig", (self.top / RUNTIME / "postinst").read_text())

    def test_completion(self):
        """Where the shells of Debian search."""
        for name in ("bash-completion/completions/toliman", "zsh/vendor-completions/_toliman",
                     "fish/vendor_completions.d/toliman.fish"):
            self.assertTrue((self.usr / "share" / name).is_file(), name)

    def test_stripped(self):
        for path in (*self.usr.glob("bin/*"), self.usr / "lib" / f"libtoliman.so.{VERSION.rsplit('.', 1)[0]}"):
            self.assertIn(", stripped", run("file", "-L", path))

    def test_program(self):
        program, out = self.usr / "bin/toliman", self.top / "psf.npy"
        self.assertIn(str(self.usr), run("ldd", program))
        run(program, "psf", "chapter.json", "--out", out)
        self.assertEqual(out.stat().st_size, 256 + 8 * 256 * 256)

    def test_development(self):
        source = self.top / "p.c"
        source.write_text(C)
        flags = run("pkg-config", "--cflags", "--libs", "toliman", PKG_CONFIG_PATH=str(self.usr / "lib/pkgconfig")).split()
        run("cc", source, "-o", self.top / "p", *flags, "-lm")
        self.assertEqual(run(self.top / "p", LD_LIBRARY_PATH=str(self.usr / "lib")), EXPECTED)

    def test_python(self):
        version = run("/usr/bin/python3", "-c", "import toliman; print(toliman.version())",
                      PYTHONPATH=str(self.usr / "lib/python3/dist-packages"))
        self.assertEqual(version, VERSION + "\n")
        (self.top / "a.json").write_text('{"schema": "toliman-bench/1", "machine": {}, "rows": []}')
        self.assertEqual(run(self.usr / "bin/toliman", "report", self.top), f"{self.top}/report/report.html\n")


if __name__ == "__main__":
    unittest.main()
