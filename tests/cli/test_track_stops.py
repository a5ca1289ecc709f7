"""track stopped by a signal: no word on frames that were not read, and no line of the output cut."""
import fcntl
import json
import signal
import threading
import time
import unittest

from program import PATIENCE
from test_track import FRAMES
from test_track_mistakes import Mistakes

STOPS = ((signal.SIGINT, 130), (signal.SIGTERM, 143), (signal.SIGHUP, 129))


class Stopped(Mistakes):
    def start_narrow(self, state, *arguments):
        """A run that cannot continue unless its output is read, of which a page is buffered."""
        run = self.start(state, *arguments, bufsize=0)
        fcntl.fcntl(run.stdout, fcntl.F_SETPIPE_SZ, 4096)
        return run

    def stop_amid(self, state, number, code, *arguments):
        run = self.start_narrow(state, *arguments, "--sync", "frame")
        first = run.stdout.readline()
        run.send_signal(number)
        out, self.errors = first + run.stdout.read(), run.stderr.read()
        self.assertEqual(run.wait(PATIENCE), code)
        self.assertTrue(out.endswith("\n"))
        return [json.loads(line) for line in out.splitlines()]

    # promise: printed-frames-are-durable
    def test_no_verdict_on_what_was_not_read(self):
        for number, code in STOPS:
            for how in ((), ("--follow",)):
                state = f"s{number}{len(how)}"
                out = self.stop_amid(state, number, code, *how, "all")
                accepted = [line["frame_id"] for line in out if "verdict" in line]
                self.assertEqual({line["verdict"] for line in out if "verdict" in line}, {"accepted"})
                self.assertEqual(accepted, list(range(len(accepted))))
                self.assertLess(len(accepted), FRAMES)
                self.assertEqual([line for line in out if "warning" in line], [])
                self.assertRegex(self.errors, r"^toliman: state saved: \d+ frames\n[^\n]*\n$")
                again = self.track(state, "all", "--strict")
                known = [line["frame_id"] for line in again if line.get("verdict") == "duplicate"]
                self.assertEqual(known[:len(accepted)], accepted)  # what was printed is safe
                self.assertEqual((self.counts(again)["accepted"], self.counts(again)["missing"]), (FRAMES, 0))

    def test_amid_a_folder(self):
        """What was read of the other pairs keeps its verdicts."""
        self.pair("in/a", self.lines[:3], self.frames[:2])
        self.pair("in/b", [self.side(k, session_id="b") for k in range(FRAMES)], self.frames[:-1])
        run = self.start_narrow("s", "in", "--follow", "--sync", "frame")
        self.read(run, 4)
        self.assertEqual([line for line in self.stop(run) if line.get("verdict") == "rejected"], [])
        last = self.counts(self.track("s", "in"))
        self.assertEqual((last["accepted"], last["short_frames"]), (FRAMES + 1, 2))

    def test_while_nobody_reads(self):
        run = self.start_narrow("s", "all", "--follow")
        run.stdout.readline()
        time.sleep(0.3)
        run.send_signal(signal.SIGTERM)
        self.assertEqual(run.wait(PATIENCE), 143)
        self.assertIn("state saved: ", run.stderr.read())
        self.assertTrue(all(json.loads(line) for line in run.stdout))

    def test_files_that_rest_are_judged(self):
        """A frame that never came is told at the stop, one that may be on its way is not."""
        self.pair("in/x", self.lines[:4], self.frames[:3])
        run = self.start("s", "in", "--follow")
        self.read(run, 3)
        time.sleep(1.5)
        left = [(line["frame_id"], line["reason"]) for line in self.stop(run) if "verdict" in line]
        self.assertEqual(left, [(3, "short file")])

    def test_a_pair_that_is_being_written(self):
        folder = self.folder / "in"
        folder.mkdir()
        over = threading.Event()

        def write():
            """Half a frame behind each line, until the stop; whole frames then."""
            data = self.frames.tobytes()
            size = len(data) // FRAMES
            with open(folder / "x_frames.bin", "wb", 0) as binary, open(folder / "x_meta.jsonl", "w", 1) as side:
                for k, line in enumerate(self.lines):
                    print(line, file=side)
                    half = k * size + size // 2
                    binary.write(data[k * size:half])
                    over.wait(0.05)
                    binary.write(data[half:(k + 1) * size])

        writer = threading.Thread(target=write)
        writer.start()
        self.addCleanup(writer.join)
        self.addCleanup(over.set)
        run = self.start("s", "in", "--follow", "--sync", "frame")
        self.read(run, 1)
        left = self.stop(run)
        self.assertEqual({line["verdict"] for line in left if "verdict" in line} - {"accepted"}, set())
        self.assertNotIn("warning", self.errors)
        over.set()
        writer.join()
        self.assertEqual(self.counts(self.track("s", "in", "--strict"))["accepted"], FRAMES)


if __name__ == "__main__":
    unittest.main()
