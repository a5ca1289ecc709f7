"""Files that the program replaces: stale temporaries, permissions, and which file an error names; the text of JSON."""
import json
import os
import select
import subprocess
import unittest

from program import PROGRAM, SCENES, TINY, ProgramTest


def json_text(value, tabs=1):
    """What the program prints for a value: one member per line; 15 digits, or 17 if these are another number."""
    if isinstance(value, dict):
        members = (f"{chr(9) * tabs}{json_text(key)}:\t{json_text(member, tabs + 1)}" for key, member in value.items())
        return "{\n" + ",\n".join(members) + "\n" + "\t" * (tabs - 1) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(json_text(item, tabs + 1) for item in value) + "]"
    if isinstance(value, float):
        short = "%.15g" % value
        is_same = abs(float(short) - value) <= 2**-52 * max(abs(float(short)), abs(value))
        return short if is_same else "%.17g" % value
    return json.dumps(value, ensure_ascii=False)


class Output(ProgramTest):
    def setUp(self):
        super().setUp()
        (self.folder / "scene.json").write_text(json.dumps(TINY))

    def test_temporaries_of_writers_that_died(self):
        for number in range(3):
            (self.folder / f"x.npy.{number}.tmp").touch()
        self.succeed("psf", "scene.json", "--out", "x.npy")
        self.assertGreater((self.folder / "x.npy").stat().st_size, 8 * 64)
        self.assertFalse((self.folder / "x.npy.3.tmp").exists())
        for number in range(3, 100):
            (self.folder / f"x.npy.{number}.tmp").touch()
        self.refuse(6, "x.npy: cannot be written: ", "x.npy.99.tmp: ", arguments=("psf", "scene.json", "--out", "x.npy"))

    def test_json(self):
        name = 'a"b\\c\x01\t\x7f\u00e9, {[:.json'
        (self.folder / name).write_text(json.dumps(TINY))
        for arguments in (("plan", name), ("period", SCENES.parent / "data" / "nu_oph_rv.csv", "--peaks", "3")):
            with self.subTest(arguments[0]):
                out = self.succeed(*arguments, "--json")
                self.assertEqual(out, json_text(json.loads(out)) + "\n")
        self.assertEqual(json.loads(self.succeed("plan", name, "--json"))["scene"], name)

    def test_permissions_are_kept(self):
        for mode in (0o600, 0o666):
            (self.folder / "x.npy").touch()
            (self.folder / "x.npy").chmod(mode)
            self.succeed("psf", "scene.json", "--out", "x.npy")
            self.assertEqual((self.folder / "x.npy").stat().st_mode & 0o777, mode)

    def test_no_binary_for_a_terminal(self):
        (self.folder / "series.csv").write_text("".join(f"{k},{k * k % 7}\n" for k in range(50)))
        controller, terminal = os.openpty()
        self.addCleanup(os.close, controller)
        self.addCleanup(os.close, terminal)
        for command in (("simulate", "scene.json", "--out", "-"), ("psf", "scene.json", "--out", "-"),
                        ("period", "series.csv", "--save-state", "-")):
            with self.subTest(command[0]):
                done = subprocess.run([PROGRAM, *command], cwd=self.folder, stdout=terminal, stderr=subprocess.PIPE, text=True)
                self.assertEqual((done.returncode, done.stderr),
                                 (2, "toliman: -: standard output is a terminal: redirect it or give a file\n"))
                self.assertEqual(select.select([controller], [], [], 0)[0], [])

    def test_a_reader_that_leaves(self):
        """Silent if the reader closed the pipe, as `| head` does; a full disk is reported."""
        for command in (("plan", "scene.json", "--json"), ("psf", "scene.json", "--out", "-")):
            for full, message in ((False, ""), (True, "No space left on device")):
                read, write = os.pipe()
                os.close(read)
                with open("/dev/full", "wb") if full else os.fdopen(write, "wb") as out:
                    done = subprocess.run([PROGRAM, *command], cwd=self.folder, stdout=out, stderr=subprocess.PIPE, text=True)
                if full:
                    os.close(write)
                self.assertEqual((done.returncode, message in done.stderr, done.stderr == message), (6, True, not full), command)

    def test_a_pipe_is_no_scene(self):
        os.mkfifo(self.folder / "pipe.json")
        self.refuse(3, "pipe.json: not a regular file", arguments=("psf", "pipe.json", "--out", "x.npy"))


if __name__ == "__main__":
    unittest.main()
