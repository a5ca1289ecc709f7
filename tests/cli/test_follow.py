"""toliman period --follow when things go wrong: bad lines, signals, a reader that leaves, a machine that dies."""
import contextlib
import json
import math
import pathlib
import select
import signal
import subprocess
import time
import unittest

from program import PATIENCE, PROGRAM, ProgramTest

GRID = ("--f0", 1e-2, "--df", 1e-4, "--nf", 900)
ROWS = [f"{k},{math.sin(k) + 0.1 * (k % 3)!r}\n" for k in range(40)]


class Follow(ProgramTest):
    def follow(self, text, *options):
        return self.run_program("period", "-", "--follow", *GRID, *options, input=text)

    def start(self, *options, **how):
        command = [PROGRAM, "period", "-", "--follow", *map(str, GRID), *options]
        pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE, **how}
        child = subprocess.Popen(command, cwd=self.folder, text=True, **pipes)
        self.addCleanup(self.end, child)
        return child

    def end(self, child):
        child.kill()
        child.wait()
        for pipe in (child.stdin, child.stdout, child.stderr):
            with contextlib.suppress(BrokenPipeError):
                pipe.close()

    def feed(self, child, rows):
        """Returns when the child has taken the last of them, which must be the fifth of all or later."""
        child.stdin.write("".join(rows))
        child.stdin.flush()
        while json.loads(child.stdout.readline())["t"] != float(rows[-1].split(",")[0]):
            pass

    @staticmethod
    def catches(child, number):
        caught = pathlib.Path(f"/proc/{child.pid}/status").read_text().split("SigCgt:")[1].split()[0]
        return int(caught, 16) >> (number - 1) & 1

    def samples(self, name):
        return json.loads(self.succeed("period", "--from-state", name, "--json"))["n"]

    def state_of(self, rows):
        """The bytes of these samples' state, undisturbed."""
        self.follow("".join(rows), "--save-state", "calm.tlmp")
        return (self.folder / "calm.tlmp").read_bytes()

    def assert_state(self, name, rows):
        self.assertEqual((self.folder / name).read_bytes(), self.state_of(rows))

    # Lines that are no samples.

    def test_bad_lines_are_told_and_passed_over(self):
        bad = {11: "junk\n", 13: "1,2,3\n", 15: "1,x\n", 17: "1e200,1\n", 19: '{"t": 1, "y": 2}\n', 21: "2,1e30\n"}
        lines = ["t,y\n", *ROWS]
        for number in sorted(bad):
            lines.insert(number - 1, bad[number])
        done = self.follow("".join(lines), "--save-state", "s.tlmp")
        self.assertEqual(done.returncode, 0, done.stderr)
        messages = done.stderr.splitlines()
        for number, line in zip(sorted(bad), messages):
            self.assertTrue(line.startswith(f"toliman: warning: standard input:{number}: "), line)
            self.assertTrue(line.endswith(": skipped"), line)
        self.assertIn("(--value-bound)", messages[5])
        self.assertEqual(messages[7:], ["toliman: warning: standard input: 6 lines skipped"])
        self.assertEqual(len(done.stdout.splitlines()), len(ROWS) - 4)
        self.assert_state("s.tlmp", ROWS)
        done = self.follow("".join(lines), "--save-state", "s.tlmp", "--strict")
        self.assertEqual((done.returncode, done.stderr.splitlines()[-1]), (4, "toliman: standard input: 6 lines skipped"))
        self.assert_state("s.tlmp", ROWS)
        self.assertEqual(self.follow("".join(ROWS), "--strict").returncode, 0)

    def test_bad_first_lines_settle_nothing(self):
        done = self.follow("9,x,1\n9,8,7,6\n" + "".join(ROWS), "--save-state", "s.tlmp")
        self.assertEqual((done.returncode, done.stderr.count("skipped\n")), (0, 3), done.stderr)
        self.assert_state("s.tlmp", ROWS)

    def test_references_come_from_the_first_sample_that_is_taken(self):
        rows = [row.replace("\n", ",1\n") for row in ROWS]
        bounds = ("--sigma-floor", "0.5", "--sigma-ceiling", "2", "--save-state")
        done = self.follow("-900,1e7,9\n" + "".join(rows), *bounds, "s.tlmp")
        self.assertIn("standard input:1: sigma = 9: ", done.stderr)
        self.assertIn("(--sigma-ceiling)", done.stderr)
        self.follow("".join(rows), *bounds, "calm.tlmp")
        self.assertEqual((self.folder / "s.tlmp").read_bytes(), (self.folder / "calm.tlmp").read_bytes())

    def test_a_wrong_line_of_names_is_an_error(self):
        done = self.follow("y,colour\n" + "".join(ROWS))
        self.assertEqual((done.returncode, done.stdout, "standard input:1: " in done.stderr), (3, "", True))

    def test_a_last_line_that_may_be_cut(self):
        done = self.follow("".join(ROWS) + "40,1", "--save-state", "s.tlmp")
        self.assertEqual(done.returncode, 0)
        self.assertIn("standard input:41: ", done.stderr)
        self.assert_state("s.tlmp", ROWS)
        whole = [self.succeed("period", "-", *GRID, "--json", input="".join(ROWS) + last) for last in ("40,1", "40,1\n")]
        self.assertEqual(whole[0], whole[1])

    # Ends.

    # promise: streams-save-their-sums
    def test_signals_save_the_state(self):
        for number, code in ((signal.SIGINT, 130), (signal.SIGTERM, 143), (signal.SIGHUP, 129)):
            child = self.start("--save-state", "s.tlmp")
            self.feed(child, ROWS[:10])
            child.stdin.write("10,1")  # the signal comes in the middle of a line
            child.stdin.flush()
            time.sleep(0.2)
            child.send_signal(number)
            _, messages = child.communicate(timeout=PATIENCE)
            self.assertEqual(child.returncode, code)
            self.assertEqual(messages, "toliman: state saved: 10 samples\ntoliman: stopped by a signal\n")
            self.assert_state("s.tlmp", ROWS[:10])

    def test_a_signal_to_the_producer_as_well(self):
        """Ctrl-C: the pipe ends with the signal, and what it held of a line is not a sample."""
        child = self.start("--save-state", "s.tlmp")
        self.feed(child, ROWS[:10])
        child.stdin.write("10,1")
        child.send_signal(signal.SIGINT)
        messages = child.communicate(timeout=PATIENCE)[1]
        self.assertEqual((child.returncode, "state saved: 10 samples" in messages), (130, True), messages)

    def test_a_signal_before_the_first_sample(self):
        for how in (["--follow", *map(str, GRID)], []):
            child = subprocess.Popen([PROGRAM, "period", "-", *how], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                     stderr=subprocess.PIPE, text=True)
            self.addCleanup(self.end, child)
            while not self.catches(child, signal.SIGINT):
                time.sleep(0.02)
            child.send_signal(signal.SIGINT)
            messages = child.communicate(timeout=PATIENCE)[1]
            self.assertEqual((child.returncode, messages), (130, "toliman: stopped by a signal\n"))

    def test_an_ignored_hangup_stays_ignored(self):
        child = self.start(preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_IGN))
        self.feed(child, ROWS[:10])
        child.send_signal(signal.SIGHUP)
        self.feed(child, ROWS[10:20])
        self.assertEqual(child.communicate(timeout=PATIENCE)[1], "")
        self.assertEqual(child.returncode, 0)

    # promise: streams-save-their-sums
    def test_a_reader_that_leaves(self):
        child = self.start("--save-state", "s.tlmp")
        self.feed(child, ROWS[:10])
        child.stdout.close()
        child.stdin.write(ROWS[10])
        child.stdin.close()
        messages = child.stderr.read()
        self.assertEqual(child.wait(timeout=PATIENCE), 6)
        self.assertEqual(messages, "toliman: state saved: 11 samples\n")
        self.assert_state("s.tlmp", ROWS[:11])

    def test_a_signal_while_nobody_reads(self):
        child = self.start("--save-state", "s.tlmp")
        child.stdin.write("".join(f"{k},{k % 7}\n" for k in range(2000)))  # more lines than a pipe holds
        child.stdin.flush()
        select.select([child.stdout], [], [], PATIENCE)
        time.sleep(0.5)
        child.send_signal(signal.SIGTERM)
        self.assertEqual(child.wait(timeout=PATIENCE), 143)
        self.assertIn("state saved: ", child.stderr.read())

    # promise: streams-save-their-sums
    def test_the_state_is_saved_meanwhile(self):
        """Every minute by SIGALRM, which the test sends earlier; then the machine dies."""
        child = self.start("--save-state", "s.tlmp")
        for n in (10, 20):
            self.feed(child, ROWS[n - 10:n])
            child.send_signal(signal.SIGALRM)
            deadline = time.monotonic() + 10
            while not ((self.folder / "s.tlmp").exists() and self.samples("s.tlmp") == n):
                self.assertLess(time.monotonic(), deadline)
                time.sleep(0.05)
        child.kill()
        child.wait()
        self.assert_state("s.tlmp", ROWS[:20])
        done = self.run_program("period", "-", "--follow", "--from-state", "s.tlmp", "--save-state", "s.tlmp",
                                input="".join(ROWS[20:]))
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assert_state("s.tlmp", ROWS)

    # What is said.

    def test_silence_is_explained(self):
        for text in ("".join(ROWS[:3]), "".join(f"{k},7\n" for k in range(9))):
            done = self.follow(text)
            self.assertEqual((done.returncode, done.stdout, done.stderr.count("warning: ")), (0, "", 1))
        self.follow("".join(ROWS), "--save-state", "s.tlmp")
        done = self.run_program("period", "-", "--follow", "--from-state", "s.tlmp", input="")
        self.assertIn("warning: ", done.stderr)
        self.assertEqual(self.follow("").returncode, 3)

    def test_a_coarse_grid_is_warned_of_once(self):
        """1/(5 T) falls below df when T passes 2000."""
        rows = [f"{100 * k},{k % 7}\n" for k in range(60)]
        self.assertEqual(self.follow("".join(rows[:15])).stderr, "")
        messages = self.follow("".join(rows)).stderr
        self.assertEqual(messages.count("--df 0.0001 "), 1, messages)
        span = 1 / (5 * float(messages.split("1/(5 T) = ")[1].split(",")[0]))
        self.assertTrue(2000 < span < 2200, messages)

    def test_options_that_a_stream_has_not(self):
        (self.folder / "s.csv").write_text("".join(ROWS))
        for option in (("--power", "p.npy"), ("--peaks", 3), ("--fap", "naive"), ("--normalisation", "log"),
                       ("--resamplings", 10), ("--seed", 1)):
            self.refuse(2, option[0], "--follow", arguments=("period", "s.csv", "--follow", *GRID, *option))
        self.refuse(2, "--strict", "--follow", arguments=("period", "s.csv", "--strict"))
        self.refuse(2, "--save-state -", arguments=("period", "s.csv", "--follow", *GRID, "--save-state", "-"))
        self.refuse(2, "FILE", arguments=("period", "--follow", "--from-state", "s.tlmp"))


if __name__ == "__main__":
    unittest.main()
