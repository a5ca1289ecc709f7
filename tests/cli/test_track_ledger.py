"""State folders that someone or a disk has harmed: one writer, lost and damaged files, and what is told of them."""
import json
import os
import shutil
import unittest

from test_track import FRAMES
from test_track_mistakes import PAIRS, TEMPLATE, Mistakes


class Ledger(Mistakes):
    # promise: exit-codes-are-the-same
    def test_a_ledger_that_is_gone(self):
        self.track("s", "all")
        (self.folder / "s/ledger.tlml").unlink()
        for left in ("checkpoint.tlmc", "setup.tlms", "streams.txt"):
            text = "s/ledger.tlml: ", left
            self.refuse_track(5, *text)
            for command in (("status", "s"), ("rebuild", "s"), ("merge", "s", "--salvage", "--out", "no")):
                self.refuse(5, *text, arguments=command)
            (self.folder / "s" / left).unlink()
        self.track("s", "all")

    def test_a_ledger_that_is_no_file(self):
        """tests/unit/test_track_damage.c and test_track_folder.c have the others."""
        self.track("s", "all")
        for name in ("ledger.tlml", "checkpoint.tlmc"):
            path = self.folder / "s" / name
            path.rename(self.folder / "kept")
            path.symlink_to("../kept")
            self.refuse_track(5, f"s/{name}: ")
            self.refuse(5, f"s/{name}: ", arguments=("status", "s"))
            path.unlink()
            (self.folder / "kept").rename(path)
        self.track("s", "all")

    # promise: damage-is-told-once
    def test_damage_that_costs_nothing_is_told(self):
        """By status as long as it is there, by track once, which mends it."""
        self.track("s", "all")
        ledger, checkpoint, names = (self.folder / "s" / name for name in ("ledger.tlml", "checkpoint.tlmc", "streams.txt"))

        def flip(path):
            data = bytearray(path.read_bytes())
            data[len(data) // 2] ^= 1
            path.write_bytes(data)

        for harm, text in ((lambda: flip(checkpoint), "s/checkpoint.tlmc: "), (lambda: os.truncate(checkpoint, 1000), "s/checkpoint.tlmc: "),
                           (checkpoint.unlink, "s/checkpoint.tlmc: "),
                           (lambda: ledger.write_bytes(ledger.read_bytes() + b"torn"), "s/ledger.tlml: 4 bytes "),
                           (lambda: flip(names), "s/streams.txt: ")):
            before = ledger.read_bytes()
            harm()
            for command in (("status", "s"), ("status", "s", "--missing")):
                done = self.run_program(*command)
                self.assertEqual((done.returncode, done.stderr.count("\n")), (0, 1), done.stderr)
                self.assertIn(f"toliman: warning: {text}", done.stderr)
            if "streams.txt" in text:
                self.assert_unnamed("s")
            self.track("s", "all")
            self.assertEqual(self.errors.count(f"toliman: warning: {text}"), 1, self.errors)
            self.assertEqual(ledger.read_bytes()[:len(before)], before)
        self.assertEqual(json.loads(self.succeed("status", "s", "--json"))["streams"][0]["session"], "day")  # named again

    def assert_unnamed(self, state):
        """The one session is shown by its digest."""
        session = json.loads(self.run_program("status", state, "--json").stdout)["streams"][0]["session"]
        self.assertRegex(session, "^#[0-9a-f]{16}$")
        self.assertIn(f"  {session} ", self.run_program("status", state).stdout)
        lines = [json.loads(line) for line in self.run_program("status", state, "--records").stdout.splitlines()]
        self.assertEqual({line["session"] for line in lines}, {session})

    # promises: exit-codes-are-the-same, folders-have-one-writer
    def test_a_second_writer(self):
        run = self.start("s", "all", "--follow")
        self.read(run, 1)
        for command in (("track", *TEMPLATE, "--state", "s", *PAIRS), ("rebuild", "s")):
            self.refuse(6, "s: ", arguments=command)
            for name in ("lock", "checkpoint.tlmc", "streams.txt"):
                (self.folder / "s" / name).unlink(missing_ok=True)
        self.stop(run)
        self.assertIn("state saved: ", self.errors)
        self.assertEqual(json.loads(self.run_program("status", "s", "--json").stdout)["accepted"], FRAMES)

    # promises: folders-have-one-writer, printed-frames-are-durable
    def test_two_writers_lose_no_frame(self):
        """Whatever is removed to let the second one in: what either has printed as accepted is in the ledger."""
        for trial in range(int(os.environ.get("TOLIMAN_WRITERS", 1))):
            state, accepted = f"s{trial}", []

            def give(name, ids):
                self.pair(f"{state}_{name}/{ids[0]}", [self.side(k % 100, frame_id=k) for k in ids], self.frames[:len(ids)])

            def read(run, count):
                accepted.extend(line["frame_id"] for line in self.read(run, count) if line["verdict"] == "accepted")

            give("a", range(5))
            first = self.start(state, f"{state}_a", "--follow", "--sync", "frame")
            read(first, 1)
            for left in ("lock", "ledger.tlml.tmp"):
                (self.folder / state / left).unlink(missing_ok=True)
            give("b", range(100, 105))
            second = self.start(state, f"{state}_b", "--follow", "--sync", "frame")
            refused = second.stdout.readline() == ""
            for name, ids in (("a", range(5, 15)), ("b", range(105, 115))):
                give(name, ids)
            read(first, 14)
            if refused:
                self.assertEqual(second.wait(60), 6)
            else:
                read(second, 14)
                self.stop(second)
            self.stop(first)
            lines = [json.loads(line) for line in self.succeed("status", state, "--records").splitlines()]
            self.assertEqual(set(accepted) - {line["frame_id"] for line in lines}, set())
            self.assertEqual(set(accepted), set(range(15)))

    # promise: changed-ledgers-stop-writers
    def test_a_ledger_that_changes_under_its_writer(self):
        """Nothing more is acknowledged, and no state is called saved; tests/unit/test_track_ledger.c has other changes."""
        ledger = self.folder / "s/ledger.tlml"
        for stopped in (False, True):
            shutil.rmtree(self.folder / "s", ignore_errors=True)
            self.pair(f"in{stopped}/a", self.lines[:5], self.frames[:5])
            run = self.start("s", f"in{stopped}", "--follow", "--sync", "frame")
            self.read(run, 5)
            ledger.unlink()
            if stopped:
                self.stop(run)
            else:
                self.pair(f"in{stopped}/b", self.lines[5:9], self.frames[5:9])
                out, self.errors = run.stdout.read(), run.stderr.read()
                self.assertEqual(run.wait(60), 6, self.errors)
                self.assertNotIn("accepted", [json.loads(line).get("verdict") for line in out.splitlines()])
            self.assertEqual([text in self.errors for text in ("s/ledger.tlml: ", "state saved", "are safe")], [True, False, False])


if __name__ == "__main__":
    unittest.main()
