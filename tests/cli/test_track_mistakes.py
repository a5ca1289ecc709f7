"""track and its kin where someone slips: mistyped options, wrong files, clocks and folders. What is said, and what to do."""
import contextlib
import json
import os
import pty
import resource
import shutil
import signal
import subprocess
import time
import unittest

import numpy
from program import HEADER, LINE, PATIENCE, PROGRAM
from test_track import FRAMES, GRID, SIDE, Track

TEMPLATE = ("--template", "scene.json")
PAIRS = ("--dtype", "u32le", "all")


class Mistakes(Track):
    def side(self, k, **changes):
        return json.dumps({**json.loads(self.lines[k]), **changes})

    def refuse_track(self, code, *texts, arguments=PAIRS, state="s", grid=GRID):
        self.refuse(code, *texts, arguments=("track", *TEMPLATE, "--state", state, *grid, *arguments))

    def start(self, state, *arguments, grid=GRID, **how):
        command = [PROGRAM, "track", *TEMPLATE, "--state", state, *grid, "--dtype", "u32le", *arguments]
        pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, **how}
        run = subprocess.Popen(command, cwd=self.folder, text=True, **pipes)
        self.addCleanup(self.end, run)
        return run

    def end(self, run):
        run.kill()
        run.wait()
        for pipe in filter(None, (run.stdout, run.stderr)):
            pipe.close()

    def stop(self, run):
        """Lines that were not read yet; stderr to self.errors."""
        run.send_signal(signal.SIGTERM)
        out, self.errors = run.stdout.read(), run.stderr.read()
        self.assertEqual(run.wait(60), 143)
        return [json.loads(line) for line in out.splitlines()]

    def read(self, run, count, what="verdict"):
        """So many lines of frames, or of warnings."""
        lines = []
        while len(lines) < count:
            line = json.loads(run.stdout.readline())
            if what in line:
                lines.append(line)
        return lines


def rest_of(master):
    """What a terminal shows that all writers have closed; one read may return a part."""
    shown = b""
    with contextlib.suppress(OSError):
        while True:
            shown += os.read(master, 1 << 16)
    os.close(master)
    return shown.decode()


class Options(Mistakes):
    def test_the_wrong_word_is_blamed(self):
        for estimator in (TEMPLATE, ("--weights", "w.tlmw")):
            for words, text in (
                (("--stat", "s", *GRID, *PAIRS), "unknown option --stat (did you mean --state?)"),
                (("--state", "s", *GRID, "--dtype", "u8", "all"), "--dtype u8: must be one of u16le, u32le"),
                (("--state", "s", *GRID, "--jobs", "many", *PAIRS), "--jobs many"),
                (("--state", "s", *GRID, *PAIRS[:2]), "INPUT is required"),
            ):
                self.refuse(2, text, arguments=("track", *estimator, *words))
        self.refuse_track(2, "give only one of --weights, --template and --fit, or --fit with the --weights of a bank\n",
                          arguments=("--weights", "w.tlmw", *PAIRS))
        self.refuse(2, "give one of --weights, --template and --fit\n", arguments=("track", "--state", "s", *GRID, *PAIRS))

    def test_a_shape_without_its_crop(self):
        """Where the image lies in a larger frame is never guessed."""
        larger = ("--shape", f"{SIDE + 2}x{SIDE}")
        self.refuse_track(2, "--shape 66x64: is larger than the 64x64", "--crop ROW,COL", arguments=(*larger, *PAIRS))
        self.refuse_track(2, "larger than the 128x128", arguments=("--shape", "130x128", "--bin", "2", *PAIRS))
        self.pair("in/x", [self.side(0, n_rows=SIDE + 2)], [numpy.ones((SIDE + 2, SIDE))])
        self.track("whole", "in")
        self.assertIn("rejected: shape 66x64, must be 64x64: a new folder takes others by --shape and --crop", self.errors)
        self.track("s", "in", *larger, "--crop", "2,0")
        self.track("s", "in", *larger)  # the folder knows

    def test_a_pair_that_is_not_there(self):
        (self.folder / "all/day_frames.bin").rename(self.folder / "x_frames.bin")
        (self.folder / "all/day_meta.jsonl").rename(self.folder / "y_meta.jsonl")
        pair = PAIRS[:2]
        for given, missing in (("x_frames.bin", "x_meta.jsonl"), ("y_meta.jsonl", "y_frames.bin")):
            self.refuse_track(3, f"toliman: {missing}: No such file", arguments=(*pair, given))

    def test_a_folder_without_pairs(self):
        (self.folder / "in").mkdir()
        numpy.save(self.folder / "in/x.npy", self.frames)
        out = self.track("s", "in/", "all", "--strict")
        text = "contains neither X_frames.bin nor X_meta.jsonl; .npy and FITS files must be named"
        self.assertEqual([(line["warning"], line["input"], line["text"]) for line in out if "warning" in line],
                         [("empty folder", "in/", text)])
        self.assertEqual(self.errors, f"toliman: warning: in/: {text}\n")

    def test_names_are_said_once(self):
        self.pair("in/x", self.lines[:1], self.frames[:1])
        (self.folder / "in/y_meta.jsonl").write_text("")
        self.track("s/", "in//", "none_meta.jsonl", code=3)
        out = self.track("s/", "-", stdin="in//\nnone_meta.jsonl\n")
        self.assertEqual(out[0]["input"], "in/x_meta.jsonl:1")
        self.assertIn("toliman: warning: none_meta.jsonl: No such file or directory\n", self.errors)
        self.assertIn("in/y_frames.bin: No such file", self.errors)
        (self.folder / "s/ledger.tlml").write_bytes(b"no ledger")
        self.refuse(5, "toliman: s/ledger.tlml: ", arguments=("status", "s/"))

    def test_one_terminal_for_both_outputs(self):
        """What a reader sees last is the result, and that the state is saved."""
        self.pair("first/x", self.lines[:3], self.frames[:3])
        for follow, code, end in (((), 0, "3 frames\r\n"), (("--follow",), 130, " 3 frames\r\n.*state saved: 3 frames\r\n.*")):
            master, terminal = pty.openpty()
            run = subprocess.Popen(self.command(f"s{code}", "first", *follow), cwd=self.folder, stdout=terminal, stderr=terminal)
            shown = ""
            while shown.count('"frame_id"') < 3:
                shown += os.read(master, 1 << 16).decode()
            if follow:
                run.send_signal(signal.SIGINT)
            self.assertEqual(run.wait(PATIENCE), code)
            os.close(terminal)
            shown += rest_of(master)
            self.assertRegex(shown[shown.rindex("}\r\n"):], rf"(?s)^\}}\r\n.*track +(no )?period .*{end}$")

    def test_a_summary_for_who_watches(self):
        """On a terminal the last note stays; elsewhere nothing is said of a run without faults."""
        master, terminal = pty.openpty()
        run = self.start("s", "all", stderr=terminal)
        run.stdout.read()
        self.assertEqual(run.wait(60), 0)
        os.close(terminal)
        shown = rest_of(master)
        self.assertRegex(shown.split("\x1b[K")[-1], rf"^track +period .*, {FRAMES} frames\r?\n$")
        self.track("t", "all")
        self.assertEqual(self.errors, "")


class Pixels(Mistakes):
    def test_another_depth_than_the_folder_was_made_for(self):
        self.pair("narrow/x", self.lines[:2], self.frames[:2].astype("<u2").tobytes())
        for dtype, other, depth, given in (("u16le", "u32le", "12", "narrow"), ("u32le", "u16le", "32", "all")):
            self.run_program("track", *TEMPLATE, "--state", dtype, *GRID, "--dtype", dtype, given)
            self.refuse_track(2, f"--dtype {other}: the frames of {dtype} have {depth} bits: give --dtype {dtype}, or "
                              f"a new folder; if these {other} files also have {depth} bits, add --bit-depth {depth}\n",
                              state=dtype, arguments=("--dtype", other, "all"))
            meant = ("--dtype", other, "--bit-depth", depth, "-")
            self.succeed("track", *TEMPLATE, "--state", dtype, *GRID, *meant, input="")

    def test_sizes_of_another_width(self):
        """A binary of twice or half the bytes asked for is of the other dtype: nothing is taken of it."""
        self.pair("wide/x", self.lines[:2], self.frames[:2])
        self.pair("narrow/x", self.lines[:2], self.frames[:2].astype("<u2").tobytes())
        for folder, dtype, size, other in (("wide", "u16le", "twice", "u32le"), ("narrow", "u32le", "half", "u16le")):
            text = f"{size} those of 2 frames of {dtype[:3]}: is the pixel type {other[:3]}?"
            done = self.run_program("track", *TEMPLATE, "--state", folder + "_s", *GRID, "--dtype", dtype, folder)
            self.assertEqual((done.returncode, done.stderr.count("\n")), (0, 2), done.stderr)
            self.assertIn(text, done.stderr)
            self.assertIn(f"{folder}_s: removed again, as no frame was read\n", done.stderr)
            self.assertFalse((self.folder / (folder + "_s")).exists())  # binds no later command
            out = [json.loads(line) for line in done.stdout.splitlines()]
            self.assertEqual([line for line in out if "verdict" in line], [])
            self.assertEqual((out[-1]["unreadable_inputs"], out[-1]["received"], out[-1]["long_files"]), (1, 0, 0))
        run = self.start("grown", "narrow", "--follow")  # half of its frames are there, or all of them: not known yet
        self.assertIn(text, self.read(run, 1, "warning")[0]["text"])
        self.pair("narrow/x", self.lines[:3], self.frames[:3])
        self.assertEqual([line["frame_id"] for line in self.read(run, 3)], [0, 1, 2])
        self.stop(run)

    def test_when_nothing_is_good(self):
        odd = self.frames | numpy.uint32(1 << 31)
        self.pair("in/x", self.lines[:3], odd[:3])
        check = "none of the 3 frames of this run is accepted, all were rejected or are outliers or misfits: check the scene or weights, " \
                "the unit and gain of the counts, --dtype, --bit-depth, --shape, and known bad pixels (--bad-pixels)\n"
        self.track("s", "in", "--bit-depth", "31")
        self.assertEqual(self.errors.count("none of"), 1)
        self.assertTrue(self.errors.endswith(check), self.errors)
        self.track("t", "all", "--value-limit", "1e-9")
        goodness = json.loads(self.succeed("status", "t", "--json"))["goodness"]
        self.assertEqual((goodness["frames"], round(goodness["chi_square"], 1), goodness["goodness"]), (0, 1.0, "good"))
        self.assertIn(f"none of the {FRAMES} frames of this run is accepted", self.errors)
        self.pair("in/y", self.lines[3:4], self.frames[3:4])
        for _ in range(2):  # also when they are known
            self.track("s", "in", "--bit-depth", "31")
            self.assertEqual(self.errors.count("rejected"), 2)
            self.assertNotIn("none of", self.errors)

    def test_values_that_noise_does_not_reach(self):
        """The separation of one frame differs, as by no planet."""
        scene = json.loads(self.scene)
        scene["signal"]["amplitude_px"] *= 100
        (self.folder / "far.json").write_text(json.dumps(scene))
        self.succeed("simulate", "far.json", "--out", "far", "--session", "day", "--dtype", "u32le")
        far = numpy.fromfile(self.folder / "far/day_frames.bin", "<u4").reshape(FRAMES, SIDE, SIDE)
        self.pair("in/x", self.lines, [far[k] if k == 5 else frame for k, frame in enumerate(self.frames)])
        out = self.track("s", "in")
        value = [line["value"] for line in out if "verdict" in line][5]
        sigma = json.loads(self.succeed("status", "s", "--json"))["sigma"]
        self.assertGreater(abs(value), 20 * sigma)
        self.assertEqual(self.errors.count("warning"), 1, self.errors)
        self.assertIn(f"in/x_meta.jsonl:6: accepted, but its value of {value:.4g} px is {abs(value) / sigma:.3g} sigma",
                      self.errors)
        self.track("strong", "in", "--strict")  # no damage for sure
        last = self.counts(self.track("t", "in", "--value-limit", str(20 * sigma)))
        self.assertEqual((last["accepted"], last["outlier"]), (FRAMES - 1, 1))

    def test_damaged_pixels(self):
        """A few are left out of the estimate; a frame with many is a misfit, or an outlier if its value is too large."""
        places = numpy.arange(SIDE * SIDE).reshape(SIDE, SIDE)
        def damaged(few):
            return [frame | (places % (SIDE * SIDE // few) == 7) * (k == 5) * (1 << 31) for k, frame in enumerate(self.frames)]
        clean = [line for line in self.track("clean", "all") if "verdict" in line][5]
        for few, verdict, count in ((1, "accepted", 1), (25, "accepted", 26), (64, "outlier", 0)):
            self.pair(f"in{few}/x", self.lines, damaged(few))
            line = [line for line in self.track(f"s{few}", f"in{few}") if "verdict" in line][5]
            self.assertEqual((line["verdict"], line["bad_pixels"]), (verdict, count), few)
            if verdict == "accepted":
                self.assertLess(abs(line["value"] - clean["value"]), 5e-6)  # a sigma: some of the light is left out
                self.assertEqual(line["goodness"], "good")
            else:
                self.assertGreater(line["chi_square"], 1e6)
                line = [line for line in self.track("wide", "in64", "--value-limit", "10") if "verdict" in line][5]
                self.assertEqual(line["verdict"], "misfit")
                self.assertIn("in64/x_meta.jsonl:6: misfit: a chi-square of ", self.errors)
        status = json.loads(self.succeed("status", "s25", "--json"))["goodness"]
        self.assertEqual((status["bad_pixels"], status["cleaned"], status["misfit"]), (26, 1, 0))

    def test_many_warnings_of_a_file(self):
        self.pair("in/x", self.lines, self.frames[:10])
        out = self.track("s", "in")
        short = [line["camera_ns"] for line in out if line.get("reason") == "short file"]
        self.assertEqual(short, [json.loads(line)["timestamp_ns"] for line in self.lines[10:]])
        self.assertEqual(self.errors.count("ends before this frame"), 1)
        self.assertIn("in/x_meta.jsonl:11: rejected: short file: ", self.errors)
        self.assertTrue(self.errors.endswith(f"rejected: short file: {FRAMES - 10} times, of which the first was told; the "
                                             "lines on standard output have all\n"), self.errors)

    def test_each_kind_of_warning_is_told_once(self):
        """Two kinds of rejections, clock jumps and outliers, in two files; then files that cannot be read."""
        early = [self.side(k, timestamp_ns=k // 2) for k in range(1, 9)]  # three times twice
        empty = numpy.zeros_like(self.frames[0])
        for name, first in (("x", 0), ("y", 30)):
            lines = [*self.lines[first:first + 8], *("{}" for _ in range(8))]
            self.pair(f"in/{name}", lines, [self.frames[first], *[empty] * 7, *self.frames[first:first + 8]])
        self.pair("in/z", early, self.frames[1:9])
        for k in range(14):
            self.pair(f"half/{k:02}", self.lines[:1], self.frames[:1])
            (self.folder / f"half/{k:02}_frames.bin").unlink()
        out = self.track("s", "in", "half")
        told = [line for line in self.errors.splitlines() if "warning: " in line]
        for text, count, shown in (("rejected: zero run", 14, 1), ("rejected: bad line", 16, 1), ("clock jump", 3, 1),
                                   ("unreadable input", 14, 10)):
            named = [line for line in out if text.endswith(str(line.get("reason") or line.get("warning")))]
            self.assertEqual(len(named), count, text)  # standard output has all
            ends = [line for line in told if f" {text}: {count} times, of which the first" in line]
            self.assertEqual(len(ends), 1, (text, told))
        self.assertEqual(sum("_frames.bin: No such file" in line for line in told), 10)
        self.assertEqual(len(told), 4 + 10 + 4, told)  # clocks differ: once

    def test_frames_that_arrive_late(self):
        """Frames of one file in another order are no fault of the clock; a time that goes back between frame ids is."""
        order = [*range(0, 20, 2), *range(19, 0, -2), 5, 30, 31]
        self.pair("in/x", [self.lines[k] for k in order], [self.frames[k] for k in order])
        out = self.track("s", "in", "--strict")
        self.assertNotIn("warning", self.errors)
        self.assertEqual((self.counts(out)["clock_jumps"], self.counts(out)["accepted"]), (0, 22))

    def test_what_quarantine_means(self):
        self.pair("in/x", [self.lines[0], self.side(0, timestamp_ns=5)], [self.frames[0]] * 2)
        self.track("s", "in")
        text = "quarantined: frame 0 of session day arrived before with other pixels, time or count of drops; neither copy " \
               "counts, nor does any later one"
        self.assertIn(f"in/x_meta.jsonl:2: {text}\n", self.errors)

    def test_bad_lines_name_the_key_and_keep_the_frame(self):
        good = json.loads(self.lines[7])
        twice = self.lines[7][:-1] + ', "n_rows": 64}'
        for line, why, id in ((json.dumps({**good, "gain": 3}), 'unknown key "gain"', 7),
                              (json.dumps({**good, "\033[2J": 3}), 'unknown key "?[2J"', 7),
                              (twice, 'duplicate key "n_rows"', 7),
                              (json.dumps({**good, "timestamp_ns": "x"}), "timestamp_ns must be", 7),
                              (json.dumps({**good, "frame_id": 7.5}), "frame_id must be", None)):
            name = self.pair("in/x", [line], [self.frames[7]])
            record = self.track("s", name)[0]
            self.assertIn(why, self.errors)
            self.assertNotIn("\033", self.errors)
            named = ("day", "single_roi", 7) if id else (None, None, None)
            self.assertEqual((record["session"], record["roi"], record["frame_id"]), named)
            self.assertEqual((record["reason"], record["camera_ns"]), ("bad line", None))


class Clocks(Mistakes):
    def rebuild(self, text):
        (self.folder / "c.csv").write_text(text)
        return self.run_program("rebuild", "s", "--clock", "c.csv")

    def test_tables(self):
        self.track("s", "all")
        for text in ("# x\n\n  # y\ncamera_ns, tai_ns\n0,5 # z\n# between\n 1000,1005\n", "-3,5\r\n", "camera_ns,tai_ns\n1,2"):
            done = self.rebuild(text)
            self.assertEqual((done.returncode, done.stderr), (0, ""), text)
        header = "c.csv:2: the header must be camera_ns,tai_ns"
        for text, why in (
            ("\ntai_ns,camera_ns\n0,5\n", header), ("#\nns,tai_ns\n0,5\n", header), ("# y\ncamera_s,tai_s\n0,5\n", header),
            ("0,5\ncamera_ns,tai_ns\n", "c.csv:2: must be camera_ns,tai_ns"),
            ("0,5\n6\n", "c.csv:2: must be"), ("0,5,7\n", "c.csv:1: must be"), ("0,1e9\n", "c.csv:1: must be"),
            ("# y\n0,5\n\n7,5\n", "c.csv:4: 7,5: must exceed the pair before, 0,5,"), ("5,1\n5,2\n", "c.csv:2: 5,2"),
            ("5,1\n4,2\n", "c.csv:2: 4,2"), (f"{-2**62},0\n1,9\n", "by 2^62 ns at most"), ("# y\n", "contains no pair"),
        ):
            done = self.rebuild(text)
            self.assertEqual((done.returncode, done.stderr.count("\n")), (3, 1), done.stderr)
            self.assertIn(why, done.stderr)

    def test_a_clock_of_another_unit(self):
        self.track("s", "all")
        for slope, odd in ((0.989, True), (0.991, False), (1.009, False), (1.011, True), (1e9, True)):
            done = self.rebuild(f"0,0\n1000000,1000000\n2000000,{1000000 + round(slope * 1e6)}\n")
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertEqual(done.stderr.count("warning: c.csv:3: TAI advances by"), int(odd), slope)

    def test_beyond_the_table(self):
        times = [json.loads(line)["timestamp_ns"] for line in self.lines]
        text = "frames outside the clock table: "
        for first, last, beyond in ((times[0], times[-1], 0), (times[0] + 1, times[-1], 1), (times[5], times[-3], 7)):
            (self.folder / "c.csv").write_text(f"{first},{first + 5}\n{last},{last + 5}\n")
            state = f"s{beyond}"
            self.track(state, "all", "--clock", "c.csv")
            self.assertEqual(self.errors.count(f"warning: {text}{beyond}; "), int(beyond > 0), self.errors)
            self.track(state, "all", grid=())  # all are known
            self.assertEqual(self.errors, "")
        (self.folder / "c.csv").write_text("1,2\n")  # a difference has no ends
        self.track("t", "all", "--clock", "c.csv")
        self.assertEqual(self.errors, "")

    def test_clocks_that_differ(self):
        """The camera's against the host's: 1 s and 1 % of the time between are usual."""
        day = 86400
        for k, (host, told) in enumerate((
            (lambda t: t + 1.9e9 + (t > 5 * day) * 0.9, None), (lambda t: 1.009 * t, None), (lambda t: 0.991 * t, None),
            (lambda t: t + (t > 0) * 0.012 * day, 2), (lambda t: 1.02 * t, 2), (lambda t: t + (t > 5 * day) * 0.2 * day, 7),
            (lambda t: t / 1000, 2), (lambda t: 7, 2),
        )):
            lines = [json.dumps({**json.loads(line), "host_time": host(i * day)}) for i, line in enumerate(self.lines)]
            self.pair(f"in{k}/x", lines, self.frames)
            out = self.track(f"s{k}", f"in{k}", "--strict")
            warnings = [line for line in out if "warning" in line]
            self.assertEqual([(line["warning"], line["input"]) for line in warnings],
                             [("clocks differ", f"in{k}/x_meta.jsonl:{told}")] if told else [])
            self.assertEqual(self.errors.count("warning"), len(warnings))
        self.assertIn("since line 1 timestamp_ns has advanced by 86400 s, host_time by 0 s", self.errors)

    def test_jumps_behind_bad_lines_and_standstills(self):
        times = [json.loads(line)["timestamp_ns"] for line in self.lines[:16]]
        times[4:6] = [0, 1]                 # back, behind two bad lines
        times[9] = times[10] = times[8]     # repeated, and then advances
        lines = [self.side(k, timestamp_ns=t) for k, t in enumerate(times)]
        lines[2] = lines[3] = "{}"
        lines.append(lines[15])  # the same frame again
        lines.append(self.side(15, frame_id=99, roi_label="other"))  # two regions of one time
        lines.append(self.side(17))  # two days on, where one is usual
        self.pair("in/x", lines, [*self.frames[:16], *self.frames[15:18]])
        out = self.track("s", "in")
        jumps = {line["input"].split(":")[1]: line["text"] for line in out if line.get("warning") == "clock jump"}
        self.assertEqual(sorted(jumps), ["10", "5"])
        self.assertIn("goes back by 86400 s", jumps["5"])
        self.assertEqual(jumps["10"], f"timestamp_ns is {times[8]}, as in the frame before")
        self.assertEqual(self.counts(out)["clock_jumps"], 2)


class Followed(Mistakes):
    def test_files_that_are_replaced(self):
        def put(name, *ks):
            self.pair(name, [self.lines[k] for k in ks], self.frames[list(ks)])

        put("in/longer", 10, 11), put("in/shorter", 20, 21, 22), put("in/same", 30, 31)
        run = self.start("s", "in", "--follow")
        self.assertEqual({line["frame_id"] for line in self.read(run, 7)}, {10, 11, 20, 21, 22, 30, 31})
        put("next/longer", 12, 13, 14), put("in/shorter", 23, 24), put("in/same", 32, 33)
        for suffix in ("_frames.bin", "_meta.jsonl"):
            (self.folder / f"next/longer{suffix}").rename(self.folder / f"in/longer{suffix}")
        self.assertEqual({line["frame_id"] for line in self.read(run, 7)}, {12, 13, 14, 23, 24, 32, 33})
        self.stop(run)
        self.assertEqual(self.errors.count("warning"), 0, self.errors)
        self.assertEqual(self.sums("s"), self.clean([*range(10, 15), *range(20, 25), *range(30, 34)]))

    def test_half_a_pair_that_never_comes(self):
        self.pair("in/a", self.lines[:2], self.frames[:2])
        (self.folder / "in/x_frames.bin").write_bytes(b"1234")
        (self.folder / "in/y_meta.jsonl").write_text(self.lines[3] + "\n")
        run = self.start("s", "in", "--follow")
        self.read(run, 2)
        time.sleep(1)
        left = self.stop(run)
        halves = {(line["warning"], line["input"]) for line in left if "warning" in line}
        self.assertEqual(halves, {("unreadable input", f"in/{name}_meta.jsonl") for name in "xy"})
        self.assertIn("in/x_meta.jsonl: No such file or directory, required next to in/x_frames.bin\n", self.errors)
        self.assertIn("in/y_frames.bin: No such file or directory, required next to in/y_meta.jsonl\n", self.errors)

    def test_what_is_gone_and_comes_back(self):
        folder = self.folder / "in"
        self.pair("in/a", self.lines[:2], self.frames[:2])
        self.pair("b/b", self.lines[2:4], self.frames[2:4])
        run = self.start("s", "in/", "b/b_frames.bin", "--follow")
        self.read(run, 4)
        folder.rename(self.folder / "away")
        (self.folder / "b/b_meta.jsonl").unlink()
        self.assertEqual({(line["warning"], line["input"]) for line in self.read(run, 2, "warning")},
                         {("unreadable input", "in/"), ("unreadable input", "b/b_frames.bin")})
        time.sleep(2)
        (self.folder / "away").rename(folder)
        self.pair("in/c", self.lines[4:6], self.frames[4:6])
        self.pair("b/b", self.lines[2:5], self.frames[2:5])
        warnings = {(line["warning"], line["input"]) for line in self.read(run, 2, "warning")}
        self.assertEqual(warnings, {("back", "in/"), ("back", "b/b_frames.bin")})
        while json.loads(run.stdout.readline()).get("frame_id") != 4:
            pass
        left = self.stop(run)
        self.assertEqual(self.errors.count("has disappeared, waiting for it: "), 2, self.errors)
        self.assertEqual((left or [None])[-1]["unreadable_inputs"], 2)

    def test_the_last_update_after_a_signal(self):
        self.pair("in/x", [*self.lines[:8], "{}"], self.frames[:9])
        run = self.start("s", "in", "--follow", "--every", "1000")
        self.read(run, 9)
        last = self.counts(self.stop(run))
        self.assertEqual((last["n"], last["accepted"], last["bad_lines"], last["fit"]), (8, 8, 1, None))


class Folders(Mistakes):
    def test_another_grid_clock_frames_or_scene(self):
        self.track("s", "all")
        folder, files = self.folder / "s", ("ledger.tlml", "setup.tlms", "checkpoint.tlmc")
        before = [(folder / name).read_bytes() for name in files]
        (self.folder / "c.csv").write_text("0,5\n")
        command = ("--grid", "0.02:0.001:50", "--epoch", "7", "--clock", "c.csv")
        self.refuse_track(2, f"`toliman rebuild s {' '.join(command)}`, or give a new folder", grid=command)
        self.refuse_track(2, "has another frequency grid", "`toliman rebuild s --epoch 7`", grid=("--epoch", "7"))
        self.refuse_track(2, "has another clock", "`toliman rebuild s --clock c.csv`", grid=("--clock", "c.csv"))
        frames = "leave out --shape, --crop, --bin, --bit-depth and --value-limit, or give a new folder"
        for options in (("--shape", "70x70"), ("--bin", "2"), ("--crop", "1,1"), ("--bit-depth", "31"), ("--value-limit", "3")):
            self.refuse_track(2, frames, arguments=(*options, *PAIRS))
        scene = json.loads(self.scene)
        for group, change in (("binary", {"separation_arcsec": 8}), ("detector", {"shape": [SIDE, SIDE - 2]})):
            (self.folder / "scene.json").write_text(json.dumps({**scene, group: {**scene[group], **change}}))
            self.refuse_track(2, "its frames were measured with another scene, calibration or estimator", "into a new folder: ids ")
        self.assertEqual([(folder / name).read_bytes() for name in files], before)

    def test_rebuild_takes_what_track_takes(self):
        other = ("--mission-days", "100", "--epoch", "86400000000000")
        self.track("s", "all")
        self.track("other", "all", grid=other)
        self.assertNotEqual(self.sums("s"), self.sums("other"))
        self.succeed("rebuild", "s", *other)
        self.assertEqual(self.sums("s"), self.sums("other"))
        self.assertEqual(self.counts(self.track("s", "all", grid=other))["repeated"], FRAMES)

    def test_folders_that_cannot_be_opened(self):
        for command in ("status", "rebuild"):
            self.refuse(3, "none: No such file or directory", arguments=(command, "none"))
        os.symlink("loop", self.folder / "loop")
        self.refuse_track(3, "loop: cannot be opened: Too many levels of symbolic links", state="loop")
        self.refuse(3, "loop: cannot be opened: Too many levels", arguments=("status", "loop"))
        if os.geteuid() == 0:  # whom nothing is forbidden
            return
        self.track("closed", "all")
        self.addCleanup((self.folder / "closed").chmod, 0o700)
        for mode in (0o000, 0o100):
            (self.folder / "closed").chmod(mode)
            self.refuse_track(3, "closed: ", "Permission denied", state="closed")
            self.refuse(3, "closed: ", "Permission denied", arguments=("status", "closed"))

    def test_merge(self):
        self.track("s", "all")
        (self.folder / "rv.csv").write_text("t,y\n1,2\n")
        for given, code, text in ((("none", "nor", "--out", "s"), 3, "none: No such file"), (("s", "--out", "no"), 2, "only one state"),
                                  (("rv.csv", "--out", "no"), 3, 'rv.csv: is a CSV file, not a saved state of toliman period'),
                                  (("all", "--out", "no"), 3, "all: is not a state folder of `toliman track`"),
                                  (("s", "all", "--out", "no"), 3, "all: is not a state folder of `toliman track`"),
                                  (("none", "--salvage", "--out", "no"), 3, "none: No such file")):
            self.refuse(code, text, arguments=("merge", *given))
        self.refuse(3, "toliman: nodir: No such file or directory", arguments=("merge", "s", "nodir", "--out", "no"))
        ledger = self.folder / "s/ledger.tlml"
        data = bytearray(ledger.read_bytes())
        data[HEADER + 5 * LINE] ^= 1
        ledger.write_bytes(data)
        shutil.copytree(self.folder / "s", self.folder / "t")
        self.track("u", "all")
        for command in (("status", "s"), ("rebuild", "s/"), ("merge", "u", "s", "--out", "no")):
            self.refuse(5, "`toliman merge s --salvage --out NEW`", arguments=command)
        self.refuse_track(5, "`toliman merge s --salvage --out NEW`")

    def test_a_full_disk(self):
        """Here a limit of the files' size. What was printed is in the folder, and the same command resumes."""
        self.pair("in/a", self.lines, self.frames)
        self.pair("in/b", [self.side(k, frame_id=100 + k) for k in range(FRAMES)], self.frames)
        limit = lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (4000, 4000))
        small = ("--grid", "0.03:0.002:2")
        run = self.start("s", "in", "--sync", "frame", grid=small, preexec_fn=limit)
        out, errors = run.communicate(timeout=PATIENCE)
        self.assertEqual(run.returncode, 6, errors)
        self.assertIn("toliman: printed lines are safe on the disk; the same command resumes\n", errors)
        self.assertIn("s/ledger.tlml: File too large", errors)
        printed = sum("verdict" in json.loads(line) for line in out.splitlines())
        self.assertEqual(printed, (4000 - HEADER) // LINE)
        self.assertEqual(json.loads(self.succeed("status", "s", "--json"))["accepted"], printed)
        self.assertEqual(self.counts(self.track("s", "in", grid=small))["accepted"], 2 * FRAMES)
        run = self.start("t", "-", "--sync", "frame", stdin=subprocess.PIPE)
        run.stdin.write("all\n")
        run.stdin.flush()
        self.read(run, FRAMES)
        resource.prlimit(run.pid, resource.RLIMIT_FSIZE, (4000, 4000))  # too little for the checkpoint in the end
        errors = run.communicate(timeout=PATIENCE)[1]
        self.assertEqual((run.returncode, errors),
                         (6, "toliman: printed lines are safe on the disk; the same command resumes\n"
                             "toliman: t/checkpoint.tlmc.tmp: File too large\n"))
        self.track("t", "all")
        self.assertEqual(self.sums("t"), self.clean(range(FRAMES)))


if __name__ == "__main__":
    unittest.main()
