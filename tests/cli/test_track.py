"""track, status, rebuild, merge: frames off a bad downlink, and always the period that the good ones have."""
import functools
import json
import os
import pathlib
import random
import re
import shutil
import signal
import subprocess
import tempfile
import unittest

import numpy
import schemas
from program import HEADER, LINE, PATIENCE, PROGRAM, SCENES, ProgramTest, one_wavelength
from shared_run import SCENE, SEED, rows_of, scene_of, shared_run

FRAMES, SIDE = 48, 64
GRID = ("--grid", "0.03:0.002:230", "--stamp", "middle")  # the scene has no exposure
SIZE = SIDE * SIDE * 4  # bytes of a frame


@functools.lru_cache(None)
def simulated(scene):
    """A folder with a scene and the pair all/day of its frames."""
    kept = tempfile.TemporaryDirectory()
    folder = pathlib.Path(kept.name)
    (folder / "scene.json").write_text(scene)
    command = [PROGRAM, "simulate", "scene.json", "--out", "all", "--session", "day", "--dtype", "u32le"]
    subprocess.run(command, cwd=folder, check=True, capture_output=True)
    return kept, folder


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
        shutil.copytree(simulated(self.scene)[1], self.folder, dirs_exist_ok=True)
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
    # promises: data-goes-to-stdout, track-gives-same-bits
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


class Network(ProgramTest):
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
    # promise: damage-does-not-stop-track
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
        for seed in (1, 2):
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
            for text in ("pixel 5, 6 is 2147483648, more than --bit-depth", "32x64", "timestamp_ns", "quarantined", "3 bytes",
                         "none_meta.jsonl: "):
                self.assertEqual(self.errors.count(text), 1, self.errors)
        self.track("s1", "all", "--strict", "--bit-depth", "31", code=4)  # the quarantined one stays so

    def test_an_outlier_is_told_with_its_limit(self):
        self.single(3)
        out = self.track("far", "in", "--value-limit", "1e-12")
        self.assertEqual(out[0]["verdict"], "outlier")
        self.assertIn(f" {out[0]['value']:.4g} px, ", self.errors)
        limit = abs(out[0]["value"]) * (1 - 1e-7)  # equal in six digits
        self.track("near", "in", "--value-limit", repr(limit))
        size, told = re.search(r" -?(\S+) px, beyond the (\S+) px of --value-limit", self.errors).groups()
        self.assertGreater(float(size), float(told))

    # promise: damage-does-not-stop-track
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


class Stops(Track):
    # promises: printed-frames-are-durable, track-gives-same-bits
    def test_killed_and_taken_up(self):
        clean = self.clean(range(FRAMES))
        for number, code in ((signal.SIGKILL, -9), (signal.SIGTERM, 143)):  # test_track_stops.py has the others
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

    def test_full(self):
        out = self.track("s", "all", "--capacity", "10", code=2)
        self.assertEqual(sum(line["schema"] == "toliman-frame/2" for line in out), 10)
        self.assertEqual(json.loads(self.succeed("status", "s", "--json"))["accepted"], 10)
        self.assertEqual(self.counts(self.track("s", "all"))["accepted"], FRAMES)

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
        base, pairs = ("track", "--state", "s", "--template", "scene.json"), ("--dtype", "u32le", "all")
        numpy.save(self.folder / "x.npy", self.frames)
        self.refuse_all(
            (2, "F0:DF:NF", "--grid", "1:2", *pairs), (3, "none", *GRID, *pairs[:2], "none"),
            (2, "-: ", *GRID, *pairs[:2], "-", "all"), (2, "--cadence", *GRID, "x.npy"), command=base)
        self.refuse(2, "s: ", "--grid", "--mission-days",
                    arguments=("track", "--state", "s", "--weights", "w.tlmw", "all"))
        for name in ("none", "all"):
            self.refuse(3, name, arguments=("status", name))


class Folders(Track):
    def shards(self, count, *more):
        """Frames dealt out in turn, the first one to all."""
        names = [f"shard_{k}" for k in range(count)]
        for k, name in enumerate(names):
            mine = sorted({0, *range(k, FRAMES, count)})
            self.pair(f"in_{k}/x", [self.lines[i] for i in mine], [self.frames[i] for i in mine])
            self.track(name, f"in_{k}", *more)
        return names

    # promise: nothing-is-merged-twice
    def test_merge(self):
        clean = self.clean(range(FRAMES))
        names = self.shards(3)
        self.run_program("merge", *names, "--out", "m1")
        self.run_program("merge", *reversed(names), "--out", "m2")
        self.assertEqual(self.sums("m1"), clean)
        self.assertEqual(self.sums("m2"), clean)
        self.assertEqual(json.loads(self.succeed("status", "m1", "--json"))["repeated"], 2)
        self.run_program("merge", "m1", "m2", "--out", "m3")
        self.assertEqual(self.sums("m3"), clean)
        self.track("other", "in_1", "--value-limit", "1")
        for code, text, out, *folders in (
                (3, "shard_0", "no", "shard_0", "shard_1", "shard_0"), (2, "--salvage", "m4", "shard_0"), (6, "m3: ", "m3", *names),
                (3, "other", "no", "shard_0", "other"), (3, "all: ", "no", "shard_0", "all"), (3, "all: ", "no", "all"),
                (2, "merge: ", "no", "shard_0", "scene.json"), (3, "none: ", "no", "none", "shard_0"),
                (3, "none: ", "no", "none", "--salvage")):
            self.refuse(code, text, arguments=("merge", *folders, "--out", out))

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
        self.track("days", "all", grid=("--mission-days", "40"))
        self.succeed("rebuild", "clean", "--mission-days", "40")
        self.assertEqual(self.sums("clean"), self.sums("days"))
        (self.folder / "slower" / "setup.tlms").unlink()  # had the clock: nothing is guessed
        grid = ("--grid", "0.02:0.001:50")
        for command in (("rebuild", "slower", *grid),
                        ("track", "--state", "slower", "--template", "scene.json", "--dtype", "u32le", *grid, "all")):
            self.refuse(2, "slower: setup.tlms", "--clock", arguments=command)
        self.succeed("rebuild", "slower", *grid, "--clock", "clock.csv", "--stamp", "start")
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
                         ["session,roi,first,last,restarts", "day,single_roi,5,7,0", "day,single_roi,20,20,0",
                          "night.2,single_roi,32,32,0"])
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
        for part in ("day single_roi", "0 to 29", "26 frames", "230 frequencies", "64x64"):
            self.assertIn(part, text)
        self.refuse(2, "--json", arguments=("status", "s", "--json", "--records"))

    # promise: salvage-counts-what-is-lost
    def test_salvage(self):
        self.track("s", "all")
        ledger = self.folder / "s" / "ledger.tlml"
        lines = bytearray(ledger.read_bytes())
        lines[HEADER + 5 * LINE] ^= 1  # frame 5
        ledger.write_bytes(lines)
        for command in (("status", "s"), ("rebuild", "s/")):
            self.refuse(5, "5 valid records", "`toliman merge s --salvage --out NEW`", arguments=command)
        done = self.run_program("merge", "s", "--salvage", "--out", "saved")
        self.assertEqual((done.returncode, "s: 1 record " in done.stderr), (0, True))
        self.assertIn("`toliman status saved --missing`\n", done.stderr)
        self.assertEqual(self.sums("saved"), self.clean([k for k in range(FRAMES) if k != 5]))
        (self.folder / "s" / "setup.tlms").unlink()  # and grid and clock are lost, too
        self.refuse(5, "--clock and --grid", arguments=("merge", "s", "--salvage", "--out", "again"))
        self.succeed("merge", "s", "--salvage", *GRID, "--clock", "camera", "--out", "again")
        self.assertEqual(self.sums("again"), self.sums("saved"))
        (self.folder / "x.tlmp").write_text("")
        self.refuse(2, "--salvage", arguments=("merge", "x.tlmp", "--salvage", "--out", "y.tlmp"))

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


class Realigned(Track):
    def put(self, pieces, lines):
        (self.folder / "in").mkdir(exist_ok=True)
        (self.folder / "in/x_frames.bin").write_bytes(b"".join(pieces))
        (self.folder / "in/x_meta.jsonl").write_text("".join(line.rstrip("\n") + "\n" for line in lines))

    def series(self, state):
        return self.succeed("status", state, "--series")

    # promise: shifted-frames-are-found
    def test_holes(self):
        raw = [frame.astype("<u4").tobytes() for frame in self.frames]
        self.assertEqual((FRAMES, len(raw[0])), (48, SIZE))
        inside = lambda cut, kept: [raw[k][:kept] if k == cut else raw[k] for k in range(FRAMES)]
        without = lambda *ids: [line for k, line in enumerate(self.lines) if k not in ids]
        cases = (  # what, pieces of the file, lines, frames that cannot be found, steps at which frames are found
            ("a frame without line", inside(12, 6000), without(12), {12}, [6000]),
            ("bytes that are no whole pixels", inside(12, 6001), without(12), {12}, [6001]),
            ("a frame whose rest is lost", inside(12, 6000), self.lines, {12}, [6000 - SIZE]),
            ("the same near the end", inside(46, 100), self.lines, {46, 47}, []),  # as if the last were not yet there
            ("two of one sign", [raw[k][:5000] if k in (9, 30) else raw[k] for k in range(FRAMES)], without(9, 30), {9, 30},
             [5000, 10000]),
            ("bytes before the first frame", [b"\1" * 3000, *raw], self.lines, set(range(FRAMES)), []),
            ("noise inserted", [*raw[:20], b"\7\0\0\1" * 1500, *raw[20:]], self.lines, set(), [6000]),
        )
        whole = self.track("whole", "all")
        value = {line["frame_id"]: line["value"] for line in whole if "verdict" in line}
        for number, (what, pieces, lines, lost, steps) in enumerate(cases):
            with self.subTest(what):
                self.put(pieces, lines)
                every = number in (0, 4)  # also on more processors
                for jobs in ("1", "8")[:1 + every]:
                    state = f"s{number}-{jobs}"
                    out = [line for line in self.track(state, "in", "--jobs", jobs, "--every", "8") if "verdict" in line]
                    good = {line["frame_id"]: line["value"] for line in out if line["verdict"] == "accepted"}
                    self.assertEqual(set(good), set(range(FRAMES)) - lost)
                    self.assertTrue(all(good[k] == value[k] for k in good))
                    self.assertTrue({line["verdict"] for line in out} <= {"accepted", "misfit", "outlier", "rejected"})
                    damaged = [line for line in out if line["verdict"] != "accepted" and line["goodness"] != "good"]
                    self.assertEqual({line["shift_bytes"] for line in damaged} - {0}, set())
                    shifts = [line["shift_bytes"] for line in out if line["verdict"] == "accepted"]
                    self.assertEqual(sorted(set(shifts) - {0}, key=shifts.index), steps)
                if every:
                    again = self.track(state, "in")  # known frames are found again, too
                    self.assertEqual({line["verdict"] for line in again if "verdict" in line} - {"rejected"}, {"duplicate"})
                    self.assertEqual(self.series(f"s{number}-1"), self.series(f"s{number}-8"))
                if steps:
                    self.assertIn("realigned: ", self.errors)

    def test_frames_of_another_telescope(self):
        """All frames are wrong: none is accepted, and the reason is told."""
        scene = json.loads(self.scene)
        scene["detector"]["pixel_scale_arcsec"] *= 1.03
        (self.folder / "scene.json").write_text(json.dumps(scene))
        out = self.track("s", "all")
        self.assertNotIn("accepted", {line["verdict"] for line in out if "verdict" in line})
        self.assertIn("frames of this run is accepted", self.errors)


if __name__ == "__main__":
    unittest.main()
