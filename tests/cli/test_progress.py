"""Progress on a terminal of any width: a line that never wraps, and no time left that is not known."""
import fcntl
import json
import os
import pathlib
import re
import select
import shutil
import struct
import subprocess
import tempfile
import termios
import unittest

from pages import write_bench
from program import LONG, PATIENCE, PROGRAM, ProgramTest, one_wavelength

WIDTHS = (120, 80, 50, 20) if LONG else (80, 20)
TRAIN = ("train", "large.json", "--steps", 4, "--out", "w.tlmw")
ENCODE = ("encode", "--weights", "w.tlmw")
TRACK = ("track", "--template", "small.json", "--state", "s", "--mission-days", 12, "--dtype", "u32le", "pair")


class Terminal:
    """A pseudo terminal, and what a program writes to it."""

    def __init__(self, test, columns):
        try:
            self.controller, self.end = os.openpty()
        except OSError as error:
            test.skipTest(f"no pseudo terminal here: {error}")
        test.addCleanup(os.close, self.controller)
        self.folder = test.folder
        self.resize(columns)

    def resize(self, columns):
        fcntl.ioctl(self.controller, termios.TIOCSWINSZ, struct.pack("HHHH", 24, columns, 0, 0))

    def run(self, *arguments, given=b"", until=None, **variables):
        """Exit code and text on stderr. given: bytes on standard input, which stays open if until = (pattern, what to do
        with the child once the text has it)."""
        environment = {name: value for name, value in os.environ.items() if name != "COLUMNS"}
        with subprocess.Popen([PROGRAM, *map(str, arguments)], cwd=self.folder, stdout=subprocess.DEVNULL,
                              stdin=subprocess.PIPE, stderr=self.end, env={**environment, **variables}) as child:
            os.close(self.end)
            child.stdin.write(given)
            child.stdin.flush()
            if not until:
                child.stdin.close()
            text = ""
            while select.select([self.controller], [], [], PATIENCE)[0]:
                try:
                    text += os.read(self.controller, 65536).decode()
                except OSError:  # the child has ended
                    break
                if until and re.search(until[0], text):
                    until[1](child)
                    until = None
            return child.wait(PATIENCE), text


def drawn(text):
    """The lines of progress, each as it was drawn; messages and results, which begin like them, end with a newline."""
    return re.findall(r"\r\x1b\[K([^\r\n]+)(?!\r\n)(?=\r|$)", text)


class Progress(ProgramTest):
    @classmethod
    def setUpClass(cls):
        kept = tempfile.TemporaryDirectory()
        cls.addClassCleanup(kept.cleanup)
        cls.inputs = pathlib.Path(kept.name)
        scene = one_wavelength()
        scene["telescope"]["pupil_samples"] = 72
        scene["cadence"]["frames"] = 12
        (cls.inputs / "large.json").write_text(json.dumps(scene))
        scene["detector"]["shape"] = [64, 64]
        scene["binary"]["separation_arcsec"] = 4
        (cls.inputs / "small.json").write_text(json.dumps(scene))
        (cls.inputs / "series.csv").write_text("".join(f"{k},{k * k % 7}\n" for k in range(50)))
        for arguments in (TRAIN, ("simulate", "large.json", "--out", "f.npy"),
                          ("simulate", "large.json", "--out", ".", "--session", "large", "--dtype", "u32le"),
                          ("simulate", "small.json", "--out", "pair", "--session", "day", "--dtype", "u32le")):
            subprocess.run([PROGRAM, *map(str, arguments)], cwd=cls.inputs, check=True, capture_output=True)

    def setUp(self):
        super().setUp()
        shutil.copytree(self.inputs, self.folder, dirs_exist_ok=True)

    def on(self, columns, *arguments, code=0, **options):
        found, text = Terminal(self, columns).run(*arguments, **options)
        self.assertEqual(found, code, text)
        return drawn(text)

    def test_every_command_at_every_width(self):
        commands = (
            (TRAIN, "train"), (("simulate", "large.json", "--out", "g.npy"), "simulate"), ((*ENCODE, "f.npy"), "encode"),
            (("convert", "f.npy", "f.fits"), "convert"), (("period", "series.csv"), "period"),
            (("psf", "large.json", "--out", "p.npy"), "propagate"), (("pupil", "small.json", "--iterations", 4, "--out", "b"), "polish"),
            (("report", "e"), "report"), (TRACK, "propagate"),
        )
        write_bench(self.folder / "e")
        for columns in WIDTHS:
            shutil.rmtree(self.folder / "s", ignore_errors=True)
            for command, stage in commands if LONG or columns == WIDTHS[-1] else commands[:3]:
                with self.subTest(columns=columns, command=command[0]):
                    lines = self.on(columns, *command)
                    self.assertTrue([line for line in lines if line.startswith(stage[:columns - 4])], lines)
                    self.assertLess(max(map(len, lines)), columns)

    def test_the_bar_gives_way_first_then_the_note(self):
        wide, middle, narrow = (self.on(columns, *TRAIN)[-1] for columns in (120, 80, 36))
        note = r"step 4 of 4, loss \d\.\d+, cosine \d\.\d+"
        self.assertRegex(wide, rf"^train      \[#{{20,32}}\] 100 %  0 s left  {note}$")
        self.assertRegex(middle, rf"^train      (\[#+\] )?100 %  0 s left  {note}$")
        self.assertEqual(narrow, "train      100 %  0 s left  step...")

    def test_notes_without_a_bar(self):
        frames = (self.folder / "large_frames.bin").read_bytes()
        for columns, note in ((80, "encode     1 frames"), (16, "encode     1..."), (3, "..")):
            with self.subTest(columns=columns):
                lines = self.on(columns, *ENCODE, "--dtype", "u32le", "--shape", "256x256", "-", given=frames)
                self.assertEqual(lines[0], note)

    def test_the_result_that_stays_is_whole(self):
        _, text = Terminal(self, 20).run(*TRACK)
        self.assertRegex(text, r"\x1b\[Ktrack      period [^\r]*log10 FAP [-0-9.]+[^\r]*, 12 frames\r\n$")

    def test_resized_while_it_runs(self):
        frames = (self.folder / "f.npy").read_bytes()
        half = len(frames) // 2
        terminal = Terminal(self, 120)

        def resize(child):
            terminal.resize(40)
            child.stdin.write(frames[half:])
            child.stdin.close()
        code, text = terminal.run(*ENCODE, "-", given=frames[:half], until=(" s left|estimating", resize))
        self.assertEqual(code, 0, text)
        lines = drawn(text)
        self.assertRegex(lines[0], r"^encode     \[#{3}\.{29}\]   8 %  estimating$")
        self.assertRegex(lines[-1], r"^encode     \[#{10}\] 100 %  0 s left$")
        self.assertEqual(len(lines[-1]), 39)

    def test_terminals_that_do_not_know_their_width(self):
        pupil = ("pupil", "small.json", "--iterations", 4, "--out", "b")
        for variables, columns in (({"COLUMNS": "50"}, 50), ({}, 80), ({"COLUMNS": "wide"}, 80), ({"COLUMNS": "0"}, 80)):
            with self.subTest(variables):
                self.assertEqual(max(map(len, self.on(0, *pupil, **variables))), columns - 1)

    def test_time_left_is_told_once_it_is_known(self):
        convert = ("convert", "f.npy", "f.fits")
        lines = self.on(120, *convert)
        self.assertTrue(lines[0].endswith("]   8 %  estimating"), lines)
        self.assertTrue(lines[-1].endswith("] 100 %  0 s left"), lines)
        lines = [json.loads(line) for line in self.run_program("--progress=json", *convert).stderr.splitlines()]
        self.assertEqual([(line["progress"], line["fraction"], line["seconds_left"]) for line in (lines[0], lines[-1])],
                         [("convert", 0.0833, None), ("convert", 1, 0)])


class WithoutTerminal(unittest.TestCase):
    """Standard error is a pipe, as in the log of a service."""

    def shown(self, *calls, style=()):
        """Standard error after calls of (seconds, stage, fraction or note)."""
        given = "".join(" ".join(map(str, call)) + "\n" for call in calls)
        done = subprocess.run([pathlib.Path(PROGRAM).parent / "progress_at", *style], input=given, capture_output=True, text=True,
                              check=True)
        self.assertEqual(done.stdout, "")
        return done.stderr.splitlines()

    def test_short_stages_show_nothing(self):
        self.assertEqual(self.shown((0, "train", 0.01), (9.9, "train", 0.99), (9.9, "frames", 0.1), (19.8, "frames", 0.9),
                                    (20, "frames", 1), (20, "controls", 0.1)), [])

    def test_a_message_after_every_10_s(self):
        lines = self.shown(*((k / 10, "controls", k / 3150) for k in range(3151)))
        self.assertEqual(len(lines), 31)
        self.assertEqual(lines[:5], ["toliman: controls 3 %, about 5 min left", "toliman: controls 6 %, about 5 min left",
                                     "toliman: controls 10 %, about 5 min left", "toliman: controls 13 %, about 5 min left",
                                     "toliman: controls 16 %, about 4 min left"])
        self.assertEqual(lines[21:23], ["toliman: controls 70 %, about 2 min left", "toliman: controls 73 %, about 85 s left"])
        self.assertEqual(lines[-1], "toliman: controls 98 %, about 5 s left")

    def test_time_left(self):
        self.assertEqual(self.shown((0, "train", 0), (10, "train", 0.0199), (20, "train", 0.02), (30, "train", 0.001),
                                    (40, "train", 0.5)),
                         ["toliman: train 2 %", "toliman: train 2 %, about 16 min left", "toliman: train 50 %, about 10 s left"])
        self.assertEqual(self.shown((0, "train", 0), (3600, "train", 0.25)), ["toliman: train 25 %, about 3.0 h left"])

    def test_work_of_unknown_length_shows_nothing(self):
        self.assertEqual(self.shown(*((k, "track", "note") for k in range(100))), [])

    def test_json(self):
        lines = self.shown((0, "train", 0.0), (0.05, "train", 0.2), (0.4, "train", 0.25), (10, "train", 0.25), (20, "track", "note"),
                           style=("json",))
        self.assertEqual([json.loads(line) for line in lines], [
            {"progress": "train", "fraction": 0, "seconds_left": None, "note": "note"},
            {"progress": "train", "fraction": 0.25, "seconds_left": None, "note": "note"},
            {"progress": "train", "fraction": 0.25, "seconds_left": 30, "note": "note"},
            {"progress": "track", "note": "note"}])


if __name__ == "__main__":
    unittest.main()
