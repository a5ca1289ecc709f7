"""track, status, rebuild, merge: frames off a bad downlink, and always the period that the good ones have."""
import json
import os
import random
import re
import signal
import subprocess
import time
import unittest

import numpy
import schemas
from program import HEADER, LINE, PATIENCE, PROGRAM, SCENES, ProgramTest, one_wavelength
from shared_run import SCENE, SEED, rows_of, scene_of, shared_run

FRAMES, SIDE = 48, 64
GRID = ("--grid", "0.03:0.002:230", "--stamp", "middle")  # the scene has no exposure


class Track(ProgramTest):
    @classmethod
    def setUpClass(cls):
        scene = one_wavelength()
        scene["telescope"]["pupil_samples"] = 128
        scene["detector"]["shape"] = [SIDE, SIDE]
        scene["cadence"]["frames"] = FRAMES
        scene["binary"]["separation_arcsec"] = 9  # both stars in the frame
        scene["signal"].update(amplitude_px=1e-5, period_days=11)
        cls.scene = json.dumps(scene)

    def setUp(self):
        super().setUp()
        (self.folder / "scene.json").write_text(self.scene)
        self.succeed("simulate", "scene.json", "--out", "all", "--session", "day", "--dtype", "u32le")
        self.lines = (self.folder / "all/day_meta.jsonl").read_text().splitlines()
        self.frames = numpy.fromfile(self.folder / "all/day_frames.bin", "<u4").reshape(FRAMES, SIDE, SIDE)

    def pair(self, name, lines, frames):
        """frames: of numbers, or bytes."""
        path = self.folder / name
        path.parent.mkdir(exist_ok=True)
        data = frames if isinstance(frames, bytes) else b"".join(numpy.asarray(f, "<u4").tobytes() for f in frames)
        path.with_name(path.name + "_frames.bin").write_bytes(data)
        path.with_name(path.name + "_meta.jsonl").write_text("".join(line + "\n" for line in lines))
        return name + "_meta.jsonl"

    def single(self, k, name=None):
        return self.pair(name or f"in/{k}", [self.lines[k]], [self.frames[k]])

    def command(self, state, *more, grid=GRID):
        return [PROGRAM, "track", "--template", "scene.json", "--state", state, "--dtype", "u32le", *grid, *more]

    def track(self, state, *more, code=0, stdin=None, grid=GRID):
        """Lines of the output and the text of stderr."""
        done = subprocess.run(
            self.command(state, *more, grid=grid), cwd=self.folder, input=stdin, capture_output=True, text=True, timeout=PATIENCE
        )
        self.assertEqual(done.returncode, code, done.stderr)
        self.errors = done.stderr
        schemas.check(done.stdout)
        return [json.loads(line) for line in done.stdout.splitlines()]

    def sums(self, state):
        """The periodogram's bytes: equal bytes are equal sums."""
        checkpoint = (self.folder / state / "checkpoint.tlmc").read_bytes()
        return checkpoint[checkpoint.index(b"TLMP"):-4]

    def clean(self, ks, name="clean"):
        """A state of exactly these frames, in order."""
        self.pair(f"{name}_in/x", [self.lines[k] for k in ks], [self.frames[k] for k in ks])
        self.track(name, f"{name}_in")
        return self.sums(name)

    def counts(self, lines):
        self.assertEqual(lines[-1]["schema"], "toliman-track-update/2")
        return lines[-1]


class Order(Track):
    def test_names_on_stdin_in_any_order(self):
        clean = self.clean(range(FRAMES))
        values = {}
        for seed in (1, 2):
            names, k, chance = [], 0, random.Random(seed)
            while k < FRAMES:
                n = min(chance.randint(1, 7), FRAMES - k)
                names.append(self.pair(f"in{seed}/{k}", self.lines[k:k + n], self.frames[k:k + n]))
                k += n
            chance.shuffle(names)
            out = self.track(f"s{seed}", "-", "--jobs", str(seed), "--every", str(3 * seed), stdin="\n".join(names))
            self.assertEqual(self.errors, "")
            self.assertEqual(self.sums(f"s{seed}"), clean)
            frames = [line for line in out if line["schema"] == "toliman-frame/2"]
            self.assertEqual(sorted(line["frame_id"] for line in frames), list(range(FRAMES)))
            self.assertEqual({line["verdict"] for line in frames}, {"accepted"})
            updates = [line["n"] for line in out if line["schema"] == "toliman-track-update/2"]
            self.assertEqual(updates, [*range(3 * seed, FRAMES + 1, 3 * seed), FRAMES])
            values[seed] = {line["frame_id"]: (line["camera_ns"], line["value"]) for line in frames}
        self.assertEqual(values[1], values[2])
        rows = [f"{ns / 86400e9!r},{value!r}" for _, (ns, value) in sorted(values[1].items())]
        (self.folder / "v.csv").write_text("t,y\n" + "\n".join(rows) + "\n")
        apart = self.succeed(
            "period", "v.csv", "--follow", "--f0", "0.03", "--df", "0.002", "--nf", "230"
        ).splitlines()[-1]
        last = self.counts(out)
        for key, digits in (("period", 1e-9), ("log10_fap", 1e-5), ("log10_fap_sequential", 1e-5)):  # as printed there
            self.assertAlmostEqual(last[key] / json.loads(apart)[key], 1, delta=digits)
        self.assertAlmostEqual(last["period"], 11, delta=0.5)

    def test_grid_of_a_mission_is_that_of_run(self):
        out = self.track("s", "all", grid=("--mission-days", str(FRAMES)))
        values = [[line["frame_id"], line["value"]] for line in out if line["schema"] == "toliman-frame/2"]
        numpy.save(self.folder / "v.npy", numpy.array(values))
        fitted = json.loads(self.succeed("period", "v.npy", "--json"))
        self.assertAlmostEqual(self.counts(out)["log10_fap"] / fitted["peak"]["log10_fap"], 1, delta=0.05)
        self.assertAlmostEqual(self.counts(out)["period"] / fitted["peak"]["period"], 1, delta=1e-3)
        status = json.loads(self.succeed("status", "s", "--json"))
        peak = fitted["peak"]
        for key in ("period", "period_error", "amplitude", "amplitude_error", "offset", "log10_fap"):
            for line in (self.counts(out), status):
                self.assertAlmostEqual(line["fit"][key] / peak[key], 1, delta=1e-5, msg=key)
        self.assertTrue(all(line["fit"] is None for line in out[:-1] if "fit" in line))
        for line in (self.counts(out), status):
            self.assertAlmostEqual(line["fwhm_period"] / peak["fwhm_period"], 1, delta=0.01)
        again = self.track("s", "all", grid=())
        self.assertEqual((self.counts(again)["repeated"], self.counts(again)["accepted"]), (FRAMES, FRAMES))
        self.assertEqual(self.counts(again)["period"], self.counts(out)["period"])


class Network(ProgramTest):
    def test_values_are_those_of_encode(self):
        scene = shared_run().parent / SCENE
        self.succeed("train", scene, "--steps", "1", "--out", "w.tlmw")
        self.succeed("simulate", scene, "--frames", "0:6", "--out", "in", "--session", "day", "--dtype", "u32le")
        pair = ("--dtype", "u32le", "in/day_frames.bin")
        encoded = self.succeed("encode", "--weights", "w.tlmw", "--shape", "256x276", *pair).splitlines()[1:]
        for jobs in ("1", "2"):
            how = ("--jobs", jobs, "--every", "4", "--mission-days", "1095", "--value-limit", "1e9")
            out = self.succeed("track", "--weights", "w.tlmw", "--state", f"s{jobs}", *how, *pair)
            frames = [line for line in map(json.loads, out.splitlines()) if "value" in line]
            self.assertEqual([line["value"] for line in frames], [float(line.split(",")[2]) for line in encoded])

    def test_what_run_finds(self):
        """Frames as raw pairs, names in random order: the values of `toliman run`, and its period."""
        run, frames = shared_run(), scene_of()["cadence"]["frames"]
        scene, seed = run.parent / SCENE, ("--seed", SEED)
        self.succeed("train", scene, *seed, "--out", "w.tlmw")
        self.assertEqual((self.folder / "w.tlmw").read_bytes(), (run / "weights.tlmw").read_bytes())
        names = []
        for k in range(0, frames, 5):
            part = ("--frames", f"{k}:{k + 5}", "--session", f"part{k}", "--dtype", "u32le", *seed)
            self.succeed("simulate", scene, "--out", "in", *part)
            side = self.folder / f"in/part{k}_meta.jsonl"
            side.write_text(side.read_text().replace(f'"part{k}"', '"day"'))
            names.append(f"in/part{k}_meta.jsonl")
        random.Random(3).shuffle(names)
        how = ("--weights", "w.tlmw", "--state", "s", "--mission-days", frames, "--dtype", "u32le", "-")
        out = [json.loads(line) for line in self.succeed("track", *how, input="\n".join(names)).splitlines()]
        values = {line["frame_id"]: line["value"] for line in out if "value" in line}
        self.assertEqual(values, dict(enumerate(rows_of(run / "series.csv")["latent"])))
        found = json.loads((run / "result.json").read_text())
        self.assertLess(abs(out[-1]["period"] - found["period_days"]), found["period_error_days"])
        self.assertAlmostEqual(out[-1]["fit"]["log10_fap"] / found["log10_fap"], 1, delta=0.05)


class Damage(Track):
    def test_every_kind_is_named_counted_and_harmless(self):
        """10 % twice, all out of order, and each kind of damage: the sums are those of the frames that are left."""
        names = [self.single(k) for k in range(FRAMES)]
        out_of_range, zeros, cut, shape, line, conflict, long = range(3, FRAMES, 7)
        pixels = self.frames.copy()
        pixels[zeros].reshape(-1)[1000:2100] = 0
        self.pair(f"in/{zeros}", [self.lines[zeros]], [pixels[zeros]])
        pixels[out_of_range][5, 6] = 1 << 31
        self.pair(f"in/{out_of_range}", [self.lines[out_of_range]], [pixels[out_of_range]])
        self.pair(f"in/{cut}", [self.lines[cut]], self.frames[cut].tobytes()[:-1])
        self.pair(f"in/{shape}", [self.lines[shape].replace('"n_rows": 64', '"n_rows": 32')], [self.frames[shape][:32]])
        self.pair(f"in/{line}", [self.lines[line].replace("timestamp_ns", "timestamp-ns")], [self.frames[line]])
        self.pair(f"in/{long}", [self.lines[long]], self.frames[long].tobytes() + b"123")
        pixels[conflict][7, 8] ^= 4
        names.append(self.pair("in/other", [self.lines[conflict]], [pixels[conflict]]))
        names += [f"in/{k}_frames.bin" for k in (0, 1, 2, 4, 6)]
        names.append("in/none_meta.jsonl")
        gone = (out_of_range, zeros, cut, shape, line, conflict)
        clean = self.clean([k for k in range(FRAMES) if k not in gone])
        for seed in (1, 2, 3):
            random.Random(seed).shuffle(names)
            out = self.track(f"s{seed}", "-", "--bit-depth", "31", stdin="\n".join(names))
            self.assertEqual(self.sums(f"s{seed}"), clean)
            last = self.counts(out)
            expected = {
                "accepted": FRAMES - 6, "quarantined": 1, "repeated": 6, "rejected": 3, "received": FRAMES + 4,
                "missing": 5, "bad_lines": 1, "short_frames": 1, "long_files": 1, "unreadable_inputs": 1, "clock_jumps": 0,
            }
            self.assertEqual({key: last[key] for key in expected}, expected)
            reasons = {"shape": 1, "over range": 1, "zero run": 1, "not finite": 0, "clock": 0, "estimate": 0}
            self.assertEqual(last["rejected_by"], reasons)
            told = sorted(
                (l["reason"], l["input"]) for l in out if l["schema"] == "toliman-frame/2" and l["verdict"] == "rejected"
            )
            self.assertEqual(
                told,
                sorted(
                    (reason, f"in/{k}_meta.jsonl:1")
                    for reason, k in zip(("over range", "zero run", "short file", "shape", "bad line"), gone)
                ),
            )
            for text in ("over range, pixel 5, 6 is 2147483648, more than --bit-depth", "zero run", "ends before", "32x64", "timestamp_ns is missing", "quarantined",
                         "3 bytes more", "none_meta.jsonl: No such file"):
                self.assertEqual(self.errors.count(text), 1, self.errors)
        self.track("s1", "all", "--strict", "--bit-depth", "31", code=4)  # the quarantined one stays so

    def test_an_outlier_is_told_with_its_limit(self):
        self.single(3)
        out = self.track("far", "in", "--value-limit", "1e-12")
        self.assertEqual(out[0]["verdict"], "outlier")
        self.assertIn(f"a value of {out[0]['value']:.4g} px, beyond the 1e-12 px of --value-limit", self.errors)
        limit = abs(out[0]["value"]) * (1 - 1e-7)  # equal in six digits
        self.track("near", "in", "--value-limit", repr(limit))
        size, told = re.search(r"a value of -?(\S+) px, beyond the (\S+) px of --value-limit", self.errors).groups()
        self.assertGreater(float(size), float(told))

    def test_strict(self):
        self.track("good", "all", "--strict")
        self.pair("in/x", self.lines + ["{}"], self.frames)
        out = self.track("s", "in", "--strict", code=4)
        self.assertEqual(self.counts(out)["bad_lines"], 1)
        self.assertEqual(self.counts(out)["accepted"], FRAMES)

    def test_clock_jumps(self):
        for line, ns in ((10, 5), (20, 10**18)):
            facts = json.loads(self.lines[line])
            facts["timestamp_ns"] = ns
            self.lines[line] = json.dumps(facts)
        self.pair("in/x", self.lines, self.frames)
        out = self.track("s", "in")
        self.assertEqual(self.counts(out)["clock_jumps"], 3)  # back, far on, and back from there
        self.assertEqual(self.counts(out)["accepted"], FRAMES)
        self.assertEqual([l["input"][-3:] for l in out if "warning" in l], [":11", ":21", ":22"])

    def test_lines_that_may_shift_frames(self):
        """A line lost in the middle: what is behind it has no place, rather than the pixels of another frame."""
        broken = self.lines[:20] + [self.lines[20] + self.lines[21]] + self.lines[22:]
        self.pair("in/x", broken, self.frames)
        last = self.counts(self.track("s", "in"))
        self.assertEqual((last["accepted"], last["bad_lines"], last["short_frames"]), (20, 1, FRAMES - 22))
        self.assertEqual(self.sums("s"), self.clean(range(20)))
        wrong = [self.lines[0], self.lines[1].replace('"n_cols": 64', '"n_cols": 65536'), *self.lines[2:]]
        self.pair("wrong/x", wrong, self.frames)  # the binary's size says that it is the line
        last = self.counts(self.track("t", "wrong"))
        self.assertEqual((last["accepted"], last["bad_lines"], last["long_files"]), (FRAMES - 1, 1, 0))

    def test_side_lines(self):
        good = json.loads(self.lines[0])
        exact = 9007199254740993  # no double
        cases = [
            ("{", False), ("[]", False), ("", False), ("null", False), (json.dumps({**good, "more": 1}), False),
            (json.dumps(good)[:-1] + ', "frame_id": 1}', False), (json.dumps({**good, "host_time": "now"}), False),
            (json.dumps({**good, "timestamp_ns": exact}), True), (json.dumps({**good, "timestamp_ns": 1.5}), False),
            (json.dumps({**good, "timestamp_ns": 10**30}), False), (json.dumps({**good, "nframes_dropped": -1}), False),
            (json.dumps({**good, "session_id": "../x"}), False), (json.dumps({**good, "roi_label": ""}), False),
            *((json.dumps({k: v for k, v in good.items() if k != key}), False) for key in good),
        ]
        for number, (line, is_good) in enumerate(cases):
            name = self.pair(f"in/{number}", [line], [self.frames[0]])
            out = self.track("s", name)
            self.assertEqual(out[0]["verdict"] == "accepted", is_good, line)
            if is_good:
                self.assertEqual(out[0]["camera_ns"], exact)
            else:
                self.assertEqual(out[0]["reason"], "bad line")


class Stops(Track):
    def test_killed_and_taken_up(self):
        clean = self.clean(range(FRAMES))
        for number, code in ((signal.SIGKILL, -9), (signal.SIGINT, 130), (signal.SIGTERM, 143), (signal.SIGHUP, 129)):
            state = f"s{number}"
            acknowledged = set()
            with subprocess.Popen(
                self.command(state, "-", "--sync", "frame"), cwd=self.folder, stdin=subprocess.PIPE,
                stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
            ) as run:
                for k in range(20):
                    print(self.single(k), file=run.stdin, flush=True)
                while len(acknowledged) < 20:
                    line = json.loads(run.stdout.readline())
                    if line["schema"] == "toliman-frame/2":
                        acknowledged.add(line["frame_id"])
                run.send_signal(number)
                self.assertEqual(run.wait(60), code)
            status = json.loads(self.succeed("status", state, "--json"))
            self.assertEqual(status["accepted"], 20)
            self.track(state, "all")
            self.assertEqual(self.sums(state), clean)

    def test_killed_at_any_moment(self):
        clean = self.clean(range(FRAMES))
        chance, seconds = random.Random(1), 0.4
        for _ in range(12):
            run = subprocess.Popen(self.command("s", "all", "--sync", "frame"), cwd=self.folder, stdout=subprocess.PIPE)
            time.sleep(chance.uniform(0, seconds))
            run.kill()
            told = [json.loads(line) for line in run.communicate()[0].splitlines(keepends=True) if line.endswith(b"\n")]
            told = {line["frame_id"] for line in told if line["schema"] == "toliman-frame/2"}
            if told:
                self.assertGreaterEqual(json.loads(self.succeed("status", "s", "--json"))["accepted"], len(told))
        self.track("s", "all")
        self.assertEqual(self.sums("s"), clean)

    def test_full(self):
        out = self.track("s", "all", "--capacity", "10", code=2)
        self.assertEqual(sum(line["schema"] == "toliman-frame/2" for line in out), 10)
        self.assertEqual(json.loads(self.succeed("status", "s", "--json"))["accepted"], 10)
        self.assertEqual(self.counts(self.track("s", "all"))["accepted"], FRAMES)

    def test_a_folder_that_grows(self):
        clean = self.clean(range(FRAMES))
        (self.folder / "in").mkdir()
        with subprocess.Popen(
            self.command("s", "in", "--follow"), cwd=self.folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        ) as run:
            def read_frames(count):
                seen = []
                while len(seen) < count:
                    line = json.loads(run.stdout.readline())
                    if line["schema"] == "toliman-frame/2":
                        seen.append(line["frame_id"])
                return seen

            with open(self.folder / "in/a_frames.bin", "wb") as binary, open(self.folder / "in/a_meta.jsonl", "w") as side:
                binary.write(self.frames[:3].tobytes())
                side.write("\n".join(self.lines[:5]))  # two lines more than frames, the last under way
                binary.flush(), side.flush()
                self.assertEqual(read_frames(3), [0, 1, 2])
                binary.write(self.frames[3:30].tobytes())
                side.write("\n" + "\n".join(self.lines[5:30]) + "\n")
            self.assertEqual(read_frames(27), list(range(3, 30)))
            self.pair("in/b", self.lines[30:], self.frames[30:])
            self.assertEqual(read_frames(FRAMES - 30), list(range(30, FRAMES)))
            status = json.loads(self.succeed("status", "s", "--json"))  # while the writer runs
            self.assertEqual(status["accepted"], FRAMES)
            run.send_signal(signal.SIGTERM)
            run.stdout.read()
            self.assertEqual(run.wait(60), 143)
            self.assertNotIn("warning", run.stderr.read())
        self.assertEqual(self.sums("s"), clean)

    def test_no_room_and_damage(self):
        (self.folder / "file").write_text("")
        self.track("file/s", "all", code=6)
        self.assertIn("file/s", self.errors)
        with open("/dev/full", "w") as full:
            done = subprocess.run(self.command("s", "all"), cwd=self.folder, stdout=full, stderr=subprocess.PIPE, text=True)
        self.assertEqual(done.returncode, 6, done.stderr)
        self.track("s", "all")
        ledger = self.folder / "s/ledger.tlml"
        data = bytearray(ledger.read_bytes())
        data[HEADER + 5 * LINE + 20] ^= 1
        ledger.write_bytes(data)
        self.track("s", "all", code=5)
        self.assertIn("ledger", self.errors)
        self.refuse(5, "ledger", arguments=("status", "s"))

    def test_refusals(self):
        base = ("track", "--state", "s", "--template", "scene.json")
        self.refuse(2, "--grid", "--mission-days", arguments=(*base, "--dtype", "u32le", "all"))
        self.refuse(2, "--dtype", arguments=(*base, *GRID, "all"))
        self.refuse(2, "F0:DF:NF", arguments=(*base, "--grid", "1:2", "--dtype", "u32le", "all"))
        self.refuse(3, "none", arguments=(*base, *GRID, "--dtype", "u32le", "none"))
        self.refuse(2, "-: standard input must be the only input", arguments=(*base, *GRID, "--dtype", "u32le", "-", "all"))
        numpy.save(self.folder / "x.npy", self.frames)
        self.refuse(2, "--cadence", arguments=(*base, *GRID, "x.npy"))
        self.refuse(3, "none", arguments=("status", "none"))
        self.refuse(3, "all", arguments=("status", "all"))


class Folders(Track):
    def shards(self, count, *more):
        """Frames dealt out in turn, the first one to all."""
        names = [f"shard_{k}" for k in range(count)]
        for k, name in enumerate(names):
            mine = sorted({0, *range(k, FRAMES, count)})
            self.pair(f"in_{k}/x", [self.lines[i] for i in mine], [self.frames[i] for i in mine])
            self.track(name, f"in_{k}", *more)
        return names

    def test_merge(self):
        clean = self.clean(range(FRAMES))
        names = self.shards(3)
        self.run_program("merge", *names, "--out", "m1")
        self.run_program("merge", *reversed(names), "--out", "m2")
        self.assertEqual(self.sums("m1"), clean)
        self.assertEqual(self.sums("m2"), clean)
        self.assertEqual(json.loads(self.succeed("status", "m1", "--json"))["repeated"], 2)
        self.refuse(3, "shard_0", "same ledger", arguments=("merge", "shard_0", "shard_1", "shard_0", "--out", "no"))
        self.run_program("merge", "m1", "m2", "--out", "m3")
        self.assertEqual(self.sums("m3"), clean)
        self.refuse(2, "only one state: give two or more, or --salvage for a damaged folder\n",
                    arguments=("merge", "shard_0", "--out", "m4"))
        self.refuse(6, "m3: exists: give a new folder to merge into\n", arguments=("merge", *names, "--out", "m3"))
        self.track("other", "in_1", "--value-limit", "1")
        self.refuse(3, "other", arguments=("merge", "shard_0", "other", "--out", "no"))
        self.refuse(3, "all", arguments=("merge", "shard_0", "all", "--out", "no"))
        self.refuse(2, "one kind", arguments=("merge", "shard_0", "scene.json", "--out", "no"))

    def test_example_of_an_array(self):
        for k in range(0, FRAMES, 5):
            self.pair(f"in/{k}", self.lines[k:k + 5], self.frames[k:k + 5])
        script = SCENES.parent / "shell" / "track_array.sh"
        done = subprocess.run([script], cwd=self.folder, capture_output=True, text=True)
        self.assertEqual((done.returncode, done.stderr.count("\n")), (2, 1))
        self.assertTrue(done.stderr.startswith("usage: "), done.stderr)
        arguments = ["shards", "in", "--template", "scene.json", "--dtype", "u32le", *GRID]
        for task in range(3):
            array = {"TOLIMAN": PROGRAM, "SLURM_ARRAY_TASK_ID": str(task), "SLURM_ARRAY_TASK_COUNT": "3"}
            subprocess.run([script, *arguments], cwd=self.folder, env={**os.environ, **array}, check=True)
        self.run_program("merge", *(f"shards/shard_{task}" for task in range(3)), "--out", "m")
        self.assertEqual(self.sums("m"), self.clean(range(FRAMES)))

    def test_clock_and_rebuild(self):
        (self.folder / "clock.csv").write_text("camera_ns,tai_ns\n# twice as slow\n0, 1000\n1000000,2001000\n")
        plain = self.clean(range(FRAMES))
        out = self.track("slow", "all", "--clock", "clock.csv")
        self.assertTrue(all(l["tai_ns"] == 2 * l["camera_ns"] + 1000 for l in out if "tai_ns" in l))
        slow = self.sums("slow")
        self.assertNotEqual(slow, plain)
        self.assertEqual(self.counts(self.track("slow", "all", grid=()))["repeated"], FRAMES)  # remembers its clock
        self.succeed("rebuild", "slow", "--clock", "camera")
        self.assertEqual(self.sums("slow"), plain)
        self.succeed("rebuild", "slow", "--clock", "clock.csv")
        self.assertEqual(self.sums("slow"), slow)
        self.track("other", "all", grid=("--grid", "0.02:0.001:50"))
        self.succeed("rebuild", "clean", "--grid", "0.02:0.001:50")
        self.assertEqual(self.sums("clean"), self.sums("other"))
        self.succeed("rebuild", "slow", "--grid", "0.02:0.001:50")  # and the clock stays
        self.track("slower", "all", "--clock", "clock.csv", grid=("--grid", "0.02:0.001:50"))
        self.assertEqual(self.sums("slow"), self.sums("slower"))
        (self.folder / "slower" / "setup.tlms").unlink()  # had the clock: nothing is guessed
        self.refuse(2, "slower: setup.tlms with grid and clock is missing: give --clock, and --grid or --mission-days",
                    arguments=("rebuild", "slower", "--grid", "0.02:0.001:50"))
        self.refuse(2, "slower: setup.tlms with grid and clock is missing: give --clock",
                    arguments=("track", "--state", "slower", "--template", "scene.json", "--dtype", "u32le",
                               "--grid", "0.02:0.001:50", "all"))
        self.succeed("rebuild", "slower", "--grid", "0.02:0.001:50", "--clock", "clock.csv", "--stamp", "start")
        self.assertEqual(self.sums("slow"), self.sums("slower"))
        self.shards(2, "--clock", "clock.csv")
        self.run_program("merge", "shard_0", "shard_1", "--out", "both")
        self.assertEqual(self.sums("both"), slow)
        (self.folder / "bad.csv").write_text("0,1\n5;6\n")
        self.refuse(3, "bad.csv:2", arguments=("rebuild", "slow", "--clock", "bad.csv"))

    def test_status_tells_what_is_there(self):
        gone = {5, 6, 7, 20}
        self.pair("in/a", [l for k, l in enumerate(self.lines) if k not in gone and k < 30],
                  [f for k, f in enumerate(self.frames) if k not in gone and k < 30])
        other = [json.dumps({**json.loads(l), "session_id": "night.2"}) for l in self.lines]
        self.pair("in/b", [other[k] for k in (31, 33)], [self.frames[k] for k in (31, 33)])
        damaged = self.frames[40].copy()
        damaged[10:] = 0
        self.pair("in/c", [self.lines[40]], [damaged])
        out = self.track("s", "in", "--epoch", str(10 * 86400 * 10**9))
        status = json.loads(self.succeed("status", "s", "--json"))
        self.assertEqual([(s["session"], s["roi"], s["first_id"], s["last_id"], s["frames"], s["missing"])
                          for s in status["streams"]],
                         [("day", "single_roi", 0, 29, 26, 4), ("night.2", "single_roi", 31, 33, 2, 1)])
        self.assertEqual((status["missing"], status["grid"]["nf"], status["clock"]), (5, 230, False))
        self.assertEqual(self.succeed("status", "s", "--missing").splitlines(),
                         ["session,roi,first,last", "day,single_roi,5,7", "day,single_roi,20,20",
                          "night.2,single_roi,32,32"])
        lines = [json.loads(line) for line in self.succeed("status", "s", "--records").splitlines()]
        printed = [line for line in out if line["schema"] == "toliman-frame/2"]
        keys = ("session", "roi", "frame_id", "camera_ns", "verdict")
        self.assertEqual([[line[k] for k in keys] for line in lines], [[line[k] for k in keys] for line in printed])
        self.assertEqual([l.get("value") for l in lines], [l.get("value") for l in printed])
        self.assertEqual(lines[-1]["reason"], "zero run")
        rows = [row.split(",") for row in self.succeed("status", "s", "--series").splitlines()]
        self.assertEqual(rows[0], ["t", "y", "sigma"])
        good = [l for l in printed if l["verdict"] == "accepted"]
        self.assertEqual([(float(t), float(y)) for t, y, _ in rows[1:]],
                         [(l["tai_ns"] / 86400e9 - 10, l["value"]) for l in good])
        text = self.succeed("status", "s")
        for part in ("day single_roi", "ids 0 to 29, 26 frames, 4 missing", "230 frequencies", "64x64 of 32 bits"):
            self.assertIn(part, text)
        self.refuse(2, "excludes", arguments=("status", "s", "--json", "--records"))

    def test_salvage(self):
        self.track("s", "all")
        ledger = self.folder / "s" / "ledger.tlml"
        lines = bytearray(ledger.read_bytes())
        lines[HEADER + 5 * LINE] ^= 1  # frame 5
        ledger.write_bytes(lines)
        self.refuse(5, "5 valid records", arguments=("status", "s"))
        self.refuse(5, "5 valid records", arguments=("rebuild", "s", "--grid", "0.02:0.001:50"))
        done = self.run_program("merge", "s", "--salvage", "--out", "saved")
        self.assertEqual((done.returncode, "s: 1 record is damaged or lost\n" in done.stderr), (0, True))
        self.assertIn("saved: 1 frame id is missing between the first and the last of a session, lost or never received: "
                      "`toliman status saved --missing`\n", done.stderr)
        self.assertEqual(self.sums("saved"), self.clean([k for k in range(FRAMES) if k != 5]))
        (self.folder / "s" / "setup.tlms").unlink()  # and grid and clock are lost, too
        self.refuse(5, "needs --clock and --grid", arguments=("merge", "s", "--salvage", "--out", "again"))
        self.succeed("merge", "s", "--salvage", *GRID, "--clock", "camera", "--out", "again")
        self.assertEqual(self.sums("again"), self.sums("saved"))
        (self.folder / "x.tlmp").write_text("")
        self.refuse(2, "--salvage, --grid, --mission-days and --clock are for state folders only", arguments=("merge", "x.tlmp", "--salvage", "--out", "y.tlmp"))

    def test_files_with_a_header(self):
        numpy.save(self.folder / "day.npy", self.frames)
        self.succeed("simulate", "scene.json", "--out", "day.fits")
        clean = [line["value"] for line in self.track("pair", "all") if "value" in line]
        for name in ("day.npy", "day.fits"):
            out = self.track("s" + name, name, "--cadence", "86400", "--bit-depth", "32")
            frames = [line for line in out if "value" in line]
            self.assertEqual([line["value"] for line in frames], clean)
            self.assertEqual([line["camera_ns"] for line in frames], [k * 86400 * 10**9 for k in range(FRAMES)])
            self.assertEqual({line["session"] for line in frames}, {"day"})
        self.assertEqual(self.sums("sday.npy"), self.sums("sday.fits"))
        holed = self.frames.astype(float)
        holed[3, 4, 5] = numpy.nan
        numpy.save(self.folder / "nan.npy", holed)
        last = self.counts(self.track("nan", "nan.npy", "--cadence", "86400", "--session", "x"))
        self.assertEqual((last["accepted"], last["rejected_by"]["not finite"]), (FRAMES - 1, 1))

    def test_crop_and_bin(self):
        wide = numpy.zeros((FRAMES, 2 * SIDE + 9, 2 * SIDE + 7), "<u4") + 1
        wide[:, 5:5 + 2 * SIDE:2, 3:3 + 2 * SIDE:2] = self.frames - 3  # of four pixels, the others are 1
        shape = f"{wide.shape[1]}x{wide.shape[2]}"
        lines = [json.dumps({**json.loads(l), "n_rows": wide.shape[1], "n_cols": wide.shape[2]}) for l in self.lines]
        self.pair("in/x", lines, wide)
        clean = [line["value"] for line in self.track("pair", "all") if "value" in line]
        out = self.track("s", "in", "--shape", shape, "--crop", "5,3", "--bin", "2")
        self.assertEqual([line["value"] for line in out if "value" in line], clean)
        self.assertEqual(self.counts(self.track("s", "in", grid=()))["repeated"], FRAMES)
        self.track("s", "in", "--crop", "5,4", code=2)


if __name__ == "__main__":
    unittest.main()
