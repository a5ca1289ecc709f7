"""track and its kin where someone slips: mistyped options, wrong files, clocks and folders. What is said, and what to do."""
import json
import os
import resource
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


class Options(Mistakes):
    def test_the_wrong_word_is_blamed(self):
        for words, text in (((*TEMPLATE, "--stat", "s", *GRID, *PAIRS), "--stat"), ((*TEMPLATE, "--state", "s", *GRID, "--dtype", "u8", "all"), "--dtype u8"),
                            ((*TEMPLATE, "--state", "s", *GRID, "--jobs", "many", *PAIRS), "--jobs many"),
                            ((*TEMPLATE, "--state", "s", *GRID, *PAIRS[:2]), "INPUT"),
                            ((*TEMPLATE, "--state", "s", *GRID, "--weights", "w.tlmw", *PAIRS), "--weights, --template and --fit"),
                            (("--state", "s", *GRID, *PAIRS), "--weights, --template and --fit")):
            self.refuse(2, text, arguments=("track", *words))

    def test_a_shape_without_its_crop(self):
        """Where the image lies in a larger frame is never guessed."""
        larger = ("--shape", f"{SIDE + 2}x{SIDE}")
        self.refuse_track(2, "--shape 66x64: ", "--crop ROW,COL", arguments=(*larger, *PAIRS))
        self.refuse_track(2, "128x128", arguments=("--shape", "130x128", "--bin", "2", *PAIRS))
        self.pair("in/x", [self.side(0, n_rows=SIDE + 2)], [numpy.ones((SIDE + 2, SIDE))])
        self.track("whole", "in")
        self.assertRegex(self.errors, "shape 66x64, .* 64x64: .*--shape and --crop")
        self.track("s", "in", *larger, "--crop", "2,0")
        self.track("s", "in", *larger)  # the folder knows

    def test_a_state_folder_among_the_frames(self):
        for state in ("all", "./all"):
            self.refuse_track(2, f"--state {state}: ", state=state)

    def test_a_pair_that_is_not_there(self):
        (self.folder / "all/day_frames.bin").rename(self.folder / "x_frames.bin")
        (self.folder / "all/day_meta.jsonl").rename(self.folder / "y_meta.jsonl")
        pair = PAIRS[:2]
        for given, missing in (("x_frames.bin", "x_meta.jsonl"), ("y_meta.jsonl", "y_frames.bin")):
            self.refuse_track(3, f"toliman: {missing}: ", arguments=(*pair, given))

    def test_a_folder_without_pairs(self):
        (self.folder / "in").mkdir()
        numpy.save(self.folder / "in/x.npy", self.frames)
        out = self.track("s", "in/", "all", "--strict")
        self.assertEqual([(line["warning"], line["input"]) for line in out if "warning" in line], [("empty folder", "in/")])
        self.assertEqual(self.errors.count("toliman: warning: in/: "), 1, self.errors)

    def test_names_are_said_once(self):
        self.pair("in/x", self.lines[:1], self.frames[:1])
        (self.folder / "in/y_meta.jsonl").write_text("")
        self.track("s/", "in//", "none_meta.jsonl", code=3)
        out = self.track("s/", "-", stdin="in//\nnone_meta.jsonl\n")
        self.assertEqual(out[0]["input"], "in/x_meta.jsonl:1")
        self.assertIn("toliman: warning: none_meta.jsonl: ", self.errors)
        self.assertIn("in/y_frames.bin: ", self.errors)
        (self.folder / "s/ledger.tlml").write_bytes(b"no ledger")
        self.refuse(5, "toliman: s/ledger.tlml: ", arguments=("status", "s/"))


class Pixels(Mistakes):
    def plain(self, count):
        """Lines of the mission, which do not name the pixel type."""
        return [line.replace(', "dtype": "u32le"', "") for line in self.lines[:count]]

    def test_another_depth_than_the_folder_was_made_for(self):
        self.pair("narrow/x", self.plain(2), self.frames[:2].astype("<u2").tobytes())
        for dtype, other, depth, given in (("u16le", "u32le", "12", "narrow"), ("u32le", "u16le", "32", "all")):
            self.run_program("track", *TEMPLATE, "--state", dtype, *GRID, "--dtype", dtype, given)
            self.refuse_track(2, f"--dtype {other}: ", f"--dtype {dtype}", f"--bit-depth {depth}\n",
                              state=dtype, arguments=("--dtype", other, "all"))
            meant = ("--dtype", other, "--bit-depth", depth, "-")
            self.succeed("track", *TEMPLATE, "--state", dtype, *GRID, *meant, input="")

    def test_sizes_of_another_width(self):
        """Nothing is taken of a binary of twice the bytes, and no folder is left; tests/unit/test_ingest.c has half of them."""
        self.pair("wide/x", self.plain(2), self.frames[:2])
        done = self.run_program("track", *TEMPLATE, "--state", "s", *GRID, "--dtype", "u16le", "wide")
        self.assertEqual((done.returncode, done.stderr.count("\n")), (0, 2), done.stderr)
        self.assertRegex(done.stderr, "2 frames of u16le: .*--dtype u32le")
        self.assertFalse((self.folder / "s").exists())  # binds no later command
        out = [json.loads(line) for line in done.stdout.splitlines()]
        self.assertEqual([line for line in out if "verdict" in line], [])
        self.assertEqual((out[-1]["unreadable_inputs"], out[-1]["received"], out[-1]["long_files"]), (1, 0, 0))

    def test_when_nothing_is_good(self):
        odd = self.frames | numpy.uint32(1 << 31)
        self.pair("in/x", self.lines[:3], odd[:3])
        self.track("s", "in", "--bit-depth", "31")
        self.assertEqual(self.errors.count("none of the 3 frames"), 1, self.errors)
        for option in ("--dtype", "--bit-depth", "--shape", "(--bad-pixels)\n"):
            self.assertIn(option, self.errors)
        self.track("t", "all", "--value-limit", "1e-9")
        goodness = json.loads(self.succeed("status", "t", "--json"))["goodness"]
        self.assertEqual((goodness["frames"], round(goodness["chi_square"], 1), goodness["goodness"]), (0, 1.0, "good"))
        self.assertIn(f"none of the {FRAMES} frames", self.errors)
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
        self.assertIn(f"in/x_meta.jsonl:6: accepted, ", self.errors)
        self.track("strong", "in", "--strict")  # no damage for sure
        last = self.counts(self.track("t", "in", "--value-limit", str(20 * sigma)))
        self.assertEqual((last["accepted"], last["outlier"]), (FRAMES - 1, 1))

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

    def test_bad_lines_name_the_key_and_keep_the_frame(self):
        good = json.loads(self.lines[7])
        twice = self.lines[7][:-1] + ', "n_rows": 64}'
        for line, why, id in ((twice, '"n_rows"', 7), (json.dumps({**good, "timestamp_ns": "x"}), "timestamp_ns", 7),
                              (json.dumps({**good, "frame_id": 7.5}), "frame_id", None)):
            name = self.pair("in/x", [line], [self.frames[7]])
            record = self.track("s", name)[0]
            self.assertIn(why, self.errors)
            self.assertNotIn("\033", self.errors)
            named = ("day", "single_roi", 7) if id else (None, None, None)
            self.assertEqual((record["session"], record["roi"], record["frame_id"]), named)
            self.assertEqual((record["reason"], record["camera_ns"]), ("bad line", None))

    def test_further_keys_are_named_once(self):
        for key, shown in (("gain", '"gain"'), ("\033[2J", '"?[2J"')):
            lines = [json.dumps({**json.loads(line), key: 3}) for line in self.lines[3:5]]
            name = self.pair("in/x", lines, self.frames[3:5])
            out = self.track("s" + key[-1], name)
            self.assertEqual([line["verdict"] for line in out if "verdict" in line], ["accepted"] * 2)
            self.assertEqual([line["warning"] for line in out if "warning" in line], ["unknown key"])
            self.assertIn(shown, self.errors)
            self.assertNotIn("\033", self.errors)


class Clocks(Mistakes):
    def rebuild(self, text):
        (self.folder / "c.csv").write_text(text)
        return self.run_program("rebuild", "s", "--clock", "c.csv")

    def test_tables(self):
        """tests/unit/test_ingest_time.c has the tables."""
        self.track("s", "all")
        done = self.rebuild("# x\n\n  # y\ncamera_ns, tai_ns\n0,5 # z\n# between\n 1000,1005\n")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        for text, why in (("#\nns,tai_ns\n0,5\n", "c.csv:2: "), ("# y\n0,5\n\n7,5\n", "c.csv:4: 7,5: "), ("# y\n", "c.csv")):
            done = self.rebuild(text)
            self.assertEqual((done.returncode, done.stderr.count("\n"), why in done.stderr), (3, 1, True), done.stderr)
        for slope, odd in ((1.009, False), (1.011, True)):
            done = self.rebuild(f"0,0\n1000000,1000000\n2000000,{1000000 + round(slope * 1e6)}\n")
            self.assertEqual((done.returncode, done.stderr.count("warning: c.csv:3: ")), (0, int(odd)), done.stderr)

    def test_beyond_the_table(self):
        times = [json.loads(line)["timestamp_ns"] for line in self.lines]
        for first, last, beyond in ((times[0], times[-1], 0), (times[5], times[-3], 7)):
            (self.folder / "c.csv").write_text(f"{first},{first + 5}\n{last},{last + 5}\n")
            state = f"s{beyond}"
            self.track(state, "all", "--clock", "c.csv")
            self.assertEqual(self.errors.count(f"clock table: {beyond}; "), int(beyond > 0), self.errors)
            self.track(state, "all", grid=())  # all are known
            self.assertEqual(self.errors, "")
        (self.folder / "c.csv").write_text("1,2\n")  # a difference has no ends
        self.track("t", "all", "--clock", "c.csv")
        self.assertEqual(self.errors, "")

    def test_clocks_that_differ(self):
        """The camera's against the host's; tests/unit/test_ingest_clock.c has what is usual."""
        day = 86400
        for k, (host, told) in enumerate(((lambda t: t + 1.9e9 + (t > 5 * day) * 0.9, None),
                                          (lambda t: t + (t > 5 * day) * 0.2 * day, 7), (lambda t: 7, 2))):
            lines = [json.dumps({**json.loads(line), "host_time": host(i * day)}) for i, line in enumerate(self.lines)]
            self.pair(f"in{k}/x", lines, self.frames)
            out = self.track(f"s{k}", f"in{k}", "--strict")
            warnings = [line for line in out if "warning" in line]
            self.assertEqual([(line["warning"], line["input"]) for line in warnings],
                             [("clocks differ", f"in{k}/x_meta.jsonl:{told}")] if told else [])
            self.assertEqual(self.errors.count("warning"), len(warnings))
        self.assertRegex(self.errors, "line 1 .* 86400 s, host_time .* 0 s")


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
        for missing, there in (("x_meta.jsonl", "x_frames.bin"), ("y_frames.bin", "y_meta.jsonl")):
            self.assertRegex(self.errors, f"in/{missing}: .* in/{there}\n")

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
        for other in (("--grid", "0.02:0.001:50", "--epoch", "7", "--clock", "c.csv"), ("--epoch", "7"), ("--clock", "c.csv")):
            self.refuse_track(2, f"`toliman rebuild s {' '.join(other)}`", grid=other)
        for options in (("--shape", "70x70"), ("--bin", "2"), ("--crop", "1,1"), ("--bit-depth", "31"), ("--value-limit", "3")):
            self.refuse_track(2, options[0], arguments=(*options, *PAIRS))
        scene = json.loads(self.scene)
        for group, change in (("binary", {"separation_arcsec": 8}), ("detector", {"shape": [SIDE, SIDE - 2]})):
            (self.folder / "scene.json").write_text(json.dumps({**scene, group: {**scene[group], **change}}))
            self.refuse_track(2, "ids ")
        self.assertEqual([(folder / name).read_bytes() for name in files], before)

    def test_folders_that_cannot_be_opened(self):
        for command in ("status", "rebuild"):
            self.refuse(3, "none: ", arguments=(command, "none"))
        os.symlink("loop", self.folder / "loop")
        self.refuse_track(3, "loop: ", state="loop")
        self.refuse(3, "loop: ", arguments=("status", "loop"))
        if os.geteuid() == 0:  # whom nothing is forbidden
            return
        self.track("closed", "all")
        self.addCleanup((self.folder / "closed").chmod, 0o700)
        for mode in (0o000, 0o100):
            (self.folder / "closed").chmod(mode)
            self.refuse_track(3, "closed: ", state="closed")
            self.refuse(3, "closed: ", arguments=("status", "closed"))

    def test_a_full_disk(self):
        """Here a limit of the files' size. What was printed is in the folder, and the same command resumes."""
        self.pair("in/a", self.lines, self.frames)
        self.pair("in/b", [self.side(k, frame_id=100 + k) for k in range(FRAMES)], self.frames)
        limit = lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (4000, 4000))
        small = ("--grid", "0.03:0.002:2")
        run = self.start("s", "in", "--sync", "frame", grid=small, preexec_fn=limit)
        out, errors = run.communicate(timeout=PATIENCE)
        self.assertEqual(run.returncode, 6, errors)
        self.assertIn("s/ledger.tlml: ", errors)
        printed = sum("verdict" in json.loads(line) for line in out.splitlines())
        self.assertEqual(printed, (4000 - HEADER) // LINE)
        self.assertEqual(json.loads(self.succeed("status", "s", "--json"))["accepted"], printed)
        self.assertEqual(self.counts(self.track("s", "in", grid=small))["accepted"], 2 * FRAMES)


if __name__ == "__main__":
    unittest.main()
