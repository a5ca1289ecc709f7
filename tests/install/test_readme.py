"""README's way from a clone to a first number in each language, as it is printed there, but for `make`, which was, and
`make install`, which CMake does. TOLIMAN_BUILD is the build folder."""
import os
import pathlib
import re
import subprocess
import tempfile
import unittest

BUILD = pathlib.Path(os.environ["TOLIMAN_BUILD"])
ROOT = pathlib.Path(__file__).resolve().parents[2]


def commands():
    """Pairs of a command and the number that its remark tells, if any."""
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    block = re.search(r"From a fresh clone to a first number.*?```sh\n(.*?)```", text, re.DOTALL)[1]
    for line in block.replace("\\\n", " ").splitlines():
        command, _, remark = line.partition(" #")
        number = re.search(r": (\d+\.\d+)$", remark)
        yield command.strip(), float(number[1]) if number else None


class Readme(unittest.TestCase):
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
