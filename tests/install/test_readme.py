"""README's lines of C and Fortran, and its way from a clone to a first number in each language, as they are printed there,
but for `make`, which was, and `make install`, which CMake does. TOLIMAN_BUILD is the build folder."""
import os
import pathlib
import re
import subprocess
import tempfile
import unittest

BUILD = pathlib.Path(os.environ["TOLIMAN_BUILD"])
ROOT = pathlib.Path(__file__).resolve().parents[2]


# Around README's lines: a sinusoid of 17 days.
C = """#include <math.h>
#include <stdio.h>
#include <toliman/toliman.h>
int main(void) {
    double t[200], y[200], f0 = 0.01, df = 0.001;
    int64_t nf = 400;
    size_t n = 200;
    for (size_t i = 0; i < n; i++)
        t[i] = (double)i, y[i] = sin(2 * 3.14159265358979 * t[i] / 17);
%s    printf("%%.1f\\n", peak.period);
    toliman_period_destroy(p);
    return 0;
}
"""
FORTRAN = """program lines
%sinteger :: i
real(c_double), parameter :: f0 = 0.01d0, df = 0.001d0, t(200) = [(real(i, c_double), i = 1, 200)]
real(c_double) :: y(200), sigma(200) = 1d-6
integer(c_int64_t), parameter :: nf = 400
type(toliman_period_peak) :: peak
integer(c_int32_t) :: stat
character(len=200) :: errmsg
y = 1d-6*sin(2*3.14159265358979d0*t/17)
%sprint '(f0.1)', peak%%period
end program
"""


def lines_of(language):
    return re.search(rf"```{language}\n(.*?)```", (ROOT / "README.md").read_text(encoding="utf-8"), re.DOTALL)[1]


def commands():
    """Pairs of a command and the number that its remark tells, if any."""
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    block = re.search(r"From a fresh clone to a first number.*?```sh\n(.*?)```", text, re.DOTALL)[1]
    for line in block.replace("\\\n", " ").splitlines():
        command, _, remark = line.partition(" #")
        number = re.search(r": (\d+\.\d+)$", remark)
        yield command.strip(), float(number[1]) if number else None


class Readme(unittest.TestCase):
    def test_lines_of_c_and_fortran(self):
        kept = tempfile.TemporaryDirectory()
        self.addCleanup(kept.cleanup)
        home = pathlib.Path(kept.name)
        (home / "a.c").write_text(C % "".join("    " + line for line in lines_of("c").splitlines(keepends=True)))
        fortran = lines_of("fortran").splitlines(keepends=True)
        statements = next(i for i, line in enumerate(fortran) if line.startswith("call"))
        (home / "a.f90").write_text(FORTRAN % ("".join(fortran[:statements]),
                                               "".join(fortran[statements:])))
        library = ["-L", BUILD / "lib", f"-Wl,-rpath,{BUILD / 'lib'}", "-ltoliman"]
        for command in (
            ["cc", "-std=c11", "-Wall", "-Wextra", "-Werror", "-I", ROOT / "include", "-I", BUILD / "include", "a.c", "-lm"],
            ["gfortran", "-std=f2018", "-O0", ROOT / "bindings" / "fortran" / "toliman.f90", "a.f90"],
        ):
            subprocess.run([*command, *library], cwd=home, check=True)
            done = subprocess.run(["./a.out"], cwd=home, capture_output=True, text=True)
            self.assertEqual((done.returncode, done.stdout), (0, "17.0\n"), done.stderr)

    def test_first_numbers(self):
        kept = tempfile.TemporaryDirectory()
        self.addCleanup(kept.cleanup)
        home = pathlib.Path(kept.name)
        (home / "build").mkdir()
        (home / "build" / "bin").symlink_to(BUILD / "bin")
        for folder in ("examples", "bindings"):
            (home / folder).symlink_to(ROOT / folder)
        subprocess.run(["cmake", "--install", BUILD, "--prefix", home / "toliman"], check=True, stdout=subprocess.DEVNULL)
        environment = {name: value for name, value in os.environ.items() if not name.startswith("TOLIMAN")}
        environment.update(HOME=str(home))
        setting, numbers = "", 0
        for command, number in commands():
            if command.startswith("make"):
                continue
            if command.startswith("export"):
                setting += command + "\n"
                continue
            done = subprocess.run(["sh", "-ec", setting + command], cwd=home, env=environment,
                                  capture_output=True, text=True)
            self.assertEqual(done.returncode, 0, f"{command}\n{done.stdout}{done.stderr}")
            if number is not None:  # a little else on another processor
                found = [float(text) for text in re.findall(r"(?:period\D*|found )(\d+\.\d+)", done.stdout)]
                self.assertTrue(any(abs(value - number) < 1 for value in found), f"{command}: {number}, not\n{done.stdout}")
                numbers += 1
        self.assertEqual(numbers, 6)


if __name__ == "__main__":
    unittest.main()
