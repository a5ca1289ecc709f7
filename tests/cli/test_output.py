"""Files that the program replaces: stale temporaries, permissions, and which file an error names; the text of JSON."""
import fcntl
import json
import os
import select
import subprocess
import resource
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
        """They are removed; those of living writers, which hold a lock, and files of other names are not."""
        made = [self.folder / f"x.npy.{number}.tmp" for number in range(100)]
        for path in (*made[:3], made[99], self.folder / "x.npy.100.tmp", self.folder / "y.npy.0.tmp"):
            path.touch()
        with open(made[1], "rb") as living:
            fcntl.flock(living, fcntl.LOCK_EX)
            self.succeed("psf", "scene.json", "--out", "x.npy")
            self.assertGreater((self.folder / "x.npy").stat().st_size, 8 * 64)
            self.assertEqual({path.name for path in self.folder.glob("*.tmp")}, {"x.npy.1.tmp", "x.npy.100.tmp", "y.npy.0.tmp"})
            made[1].rename(made[0])
            self.succeed("psf", "scene.json", "--out", "x.npy")
            self.assertTrue(made[0].exists())
        for path in made:
            path.unlink(missing_ok=True)
            path.mkdir()
        self.refuse(6, "x.npy: cannot be written: ", "x.npy.99.tmp: ", arguments=("psf", "scene.json", "--out", "x.npy"))

    def test_results_that_agree(self):
        """On a full disk all earlier files of a result folder remain."""
        series = "".join(f"{i},{(i * 7919) % 13},1\n" for i in range(200))
        (self.folder / "s.csv").write_text("t,y,sigma\n" + series)
        command = ("period", "s.csv", "--f0", "0.01", "--df", "0.001", "--nf", "2000", "--out", "r")
        self.succeed(*command)
        before = {path.name: path.read_bytes() for path in (self.folder / "r").iterdir()}
        (self.folder / "s.csv").write_text("t,y,sigma\n" + series.replace(",1\n", ",2\n"))
        done = self.run_program(*command, preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (20000, 20000)))
        self.assertEqual(done.returncode, 6, done.stderr)
        self.assertEqual({path.name: path.read_bytes() for path in (self.folder / "r").iterdir()}, before)

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
