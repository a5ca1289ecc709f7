"""Runs the code of README.md and tools/docs/guide.md as printed, with no more packages than `make` installs. Not run: `make`,
`make install` (CMake installs instead) and apt-get (its packages are made visible instead). TOLIMAN_BUILD is the build
folder."""
import json
import os
import pathlib
import re
import shutil
import subprocess
import tempfile
import textwrap
import unittest

from debian import System, installed_by_make

BUILD = pathlib.Path(os.environ["TOLIMAN_BUILD"])
ROOT = pathlib.Path(__file__).resolve().parents[2]


README, GUIDE = ROOT / "README.md", ROOT / "tools/docs/guide.md"

# What the lines of README are part of.
C_PROGRAM = """#include <stdio.h>
#include <toliman/toliman.h>
enum { n = 200 };
int main(void) {
    double t[n], y[n];
    for (int i = 0; i < n; i++) t[i] = i, y[i] = i %% 17;
%s    printf("%%.1f\\n", peak.period);
    toliman_period_destroy(p);
}
"""
FORTRAN_PROGRAM = """program samples
%s    integer :: i
    real(c_double) :: t(200) = [(i, i = 1, 200)], y(200)
    y = modulo(t, 17d0)
%s    print '(f0.1)', peak%%period
end program
"""


def lines_of(language, document=README):
    return re.search(rf"```{language}\n(.*?)```", document.read_text(encoding="utf-8"), re.DOTALL)[1]


def fortran_program():
    lines = lines_of("fortran").splitlines(keepends=True)
    declarations = [line for line in lines if re.match(r"use\b|type\(", line)]
    return FORTRAN_PROGRAM % ("".join(declarations), "".join(lines[len(declarations):]))


def lines_after(words, document=README):
    """Pairs of a command and its comment, of the first block of shell lines after these words."""
    text = document.read_text(encoding="utf-8")
    block = re.search(rf"{re.escape(words)}.*?```sh\n(.*?)```", text, re.DOTALL)[1]
    for line in block.replace("\\\n", " ").splitlines():
        command, _, comment = line.partition(" #")
        yield command.strip(), comment


def small_scene(folder, name):
    """A shipped scene with one wavelength and few frames in the folder, where its name is looked for first."""
    scene = json.loads((ROOT / "examples" / "scenes" / name).read_text())
    scene["band"] = {"wavelength_nm": 580}
    scene["telescope"].update(pupil_samples=144, mask={"kind": "spiral", "edges": "cell", "opd_nm": 290, "terms": [{"a": 1, "f": 2, "m": 5}]})
    scene["cadence"]["frames"] = 25
    for star in scene["stars"].values():
        star["spectrum"] = {"kind": "blackbody", "temperature_k": 5800}
    scene["signal"] = {"kind": "sinusoid", "star": "A", "amplitude_px": 1e-4, "period_days": 10}
    if scene["binary"].get("moving"):
        scene["detector"]["shape"] = [64, 64]  # no network, which needs more
    (folder / name).write_text(json.dumps(scene))


class Readme(unittest.TestCase):
    def test_lines_of_c_and_fortran(self):
        kept = tempfile.TemporaryDirectory()
        self.addCleanup(kept.cleanup)
        home = pathlib.Path(kept.name)
        (home / "a.c").write_text(C_PROGRAM % textwrap.indent(lines_of("c"), "    "))
        (home / "a.f90").write_text(fortran_program())
        library = ["-L", BUILD / "lib", f"-Wl,-rpath,{BUILD / 'lib'}", "-ltoliman"]
        for command in (
            ["cc", "-std=c11", "-Wall", "-Wextra", "-Werror", "-I", ROOT / "include", "-I", BUILD / "include", "a.c"],
            ["gfortran", "-std=f2018", "-O0", BUILD / "fortran" / "toliman.f90", "a.f90"],
        ):
            subprocess.run([*command, *library], cwd=home, check=True)
            done = subprocess.run(["./a.out"], cwd=home, capture_output=True, text=True)
            self.assertEqual((done.returncode, done.stdout), (0, "17.0\n"), done.stderr)

    def setUp(self):
        kept = tempfile.TemporaryDirectory()
        self.addCleanup(kept.cleanup)
        self.home = pathlib.Path(kept.name) / "home"
        self.home.mkdir()
        (self.home / "build").mkdir()
        (self.home / "build" / "bin").symlink_to(BUILD / "bin")
        (self.home / "build" / "python").symlink_to(BUILD / "python")
        self.settings = ""
        try:
            self.system = System(pathlib.Path(kept.name), installed_by_make())
        except OSError as error:
            self.skipTest(f"not on this system: {error}")

    def run_line(self, command):
        """Its standard output, after the exports before it and in the folder that they are given in."""
        if command.startswith("export"):
            self.settings += command + "\n"
            return ""
        self.assertTrue(self.system.has(command), f"{command}: no package before this line has it")
        environment = {name: value for name, value in os.environ.items() if not name.startswith("TOLIMAN")}
        environment.update(self.system.environment(), HOME=str(self.home))
        done = subprocess.run(["/bin/sh", "-ec", self.settings + command], cwd=self.home, env=environment,
                              capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, f"{command}\n{done.stdout}{done.stderr}")
        return done.stdout

    def test_lines_of_python(self):
        small_scene(self.home, "chapter.json")
        (self.home / "program.py").write_text(lines_of("python"))
        command = re.search(r"\*\*Python\.\*\*.*?In the clone:\s`(.*?)`", README.read_text(), re.DOTALL)[1].replace("\n", " ")
        self.system.add(["python3-numpy"])
        self.assertRegex(self.run_line(command), r"(?m)^period +(9\.9|10\.0)")

    def test_keys_of_a_planet(self):
        small_scene(self.home, "mission.json")
        for file in (ROOT / "examples" / "scenes").glob("*.csv"):
            shutil.copy(file, self.home)
        scene = json.loads((self.home / "mission.json").read_text())
        scene.update(json.loads("{" + lines_of("json", GUIDE).strip().rstrip(",") + "}"))
        (self.home / "mission.json").write_text(json.dumps(scene))
        self.settings = "PATH=$PWD/build/bin:$PATH\n"
        self.assertRegex(self.run_line("toliman plan ./mission.json"), r"modelled .*signal")

    def test_lines_of_the_shell(self):
        for name in ("chapter.json", "mission.json", "sky.json"):
            small_scene(self.home, name)
        (self.home / "examples").symlink_to(ROOT / "examples")
        count = 0
        for command, _ in [*lines_after("**Shell.**"), *lines_after("## Track", GUIDE)]:
            self.run_line(command)
            count += 1
        self.assertEqual(count, 12)
        self.assertTrue((self.home / "chapter.run/result.json").is_file())

    @unittest.skipUnless(os.environ.get("TOLIMAN_LONG"), "trains three networks of the shipped scene: make long")
    def test_first_numbers(self):
        (self.home / "examples").symlink_to(ROOT / "examples")
        numbers = 0
        for command, comment in lines_after("From a fresh clone to a first number", GUIDE):
            if command.startswith("apt-get install"):
                self.system.add([word for word in command.split()[2:] if not word.startswith("-")])
            elif command.startswith("make install"):
                prefix = re.search(r"PREFIX=\$HOME/(\S+)", command)[1]
                self.assertNotEqual(prefix, "toliman")  # where a clone may be
                subprocess.run(["cmake", "--install", BUILD, "--prefix", self.home / prefix], check=True,
                               stdout=subprocess.DEVNULL)
            elif command != "make":
                out = self.run_line(command)
                number = re.search(r": (\d+\.\d+)$", comment)
                if number:  # a little else on another processor
                    found = [float(text) for text in re.findall(r"(?:period\D*|found )(\d+\.\d+)", out)]
                    self.assertTrue(any(abs(value - float(number[1])) < 1 for value in found), f"{command}: {number}, not\n{out}")
                    numbers += 1
        self.assertEqual(numbers, 6)


if __name__ == "__main__":
    unittest.main()
