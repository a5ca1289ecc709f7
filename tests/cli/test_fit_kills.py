"""track --fit of frames in any order, repeated, with the program killed at random moments: the same numbers as undisturbed.

Long version: TOLIMAN_FRAMES=20000."""
import json
import os
import random
import subprocess
import time
import unittest

from program import PROGRAM, ProgramTest
from test_fit import SCENE as SMALL

FRAMES = int(os.environ.get("TOLIMAN_FRAMES", 240))
FILES = 20 if FRAMES > 1000 else 6
KILLS = FRAMES // 400 if FRAMES > 1000 else 4
SCENE = {**SMALL, "systematics": {"pointing_rms_px": 0.5},
         "cadence": {"frames": FRAMES, "interval_days": 730 / FRAMES, "peak_photons": 1e5}}


class Kills(ProgramTest):
    def command(self, state, *inputs, jobs="0"):
        return [PROGRAM, "track", "--fit", "s.json", "--state", state, "--dtype", "u32le", "--mission-days", "800",
                "--jobs", jobs, "--every", "1000", *inputs]

    def results(self, state):
        """The periodogram, and the values of the ledger without the order of arrival."""
        self.succeed("status", state, "--out", "out")
        return (self.folder / "out/periodogram.csv").read_bytes(), sorted(self.succeed("status", state, "--series").splitlines())

    # promise: committed-frames-survive-kills
    def test_same_bits(self):
        (self.folder / "s.json").write_text(json.dumps(SCENE))
        size = FRAMES // FILES
        for number in range(FILES):
            self.succeed("simulate", "s.json", "--frames", f"{number * size}:{(number + 1) * size}", "--out", "in",
                         "--session", f"n{number}", "--dtype", "u32le")
        inputs = [f"in/n{number}_meta.jsonl" for number in range(FILES)]
        start = time.monotonic()
        subprocess.run(self.command("whole", *inputs, jobs="1"), cwd=self.folder, check=True, capture_output=True)
        seconds = time.monotonic() - start
        chance, killed = random.Random(3), 0
        for _ in range(KILLS):
            chance.shuffle(inputs)
            run = subprocess.Popen(self.command("killed", *inputs, *inputs[:2]), cwd=self.folder,
                                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            try:
                run.wait(chance.uniform(0, 2 * seconds / KILLS))
            except subprocess.TimeoutExpired:
                run.kill()
                run.wait()
                killed += 1
        chance.shuffle(inputs)
        subprocess.run(self.command("killed", *inputs), cwd=self.folder, check=True, capture_output=True)
        status = json.loads(self.succeed("status", "killed", "--json"))
        print(f"{FRAMES} frames, killed {killed} times, {status['repeated']} repeated; undisturbed {seconds:.1f} s")
        self.assertEqual((status["accepted"], status["outlier"], status["quarantined"]), (FRAMES, 0, 0))
        self.assertGreater(killed, 0)
        self.assertEqual(self.results("killed"), self.results("whole"))


if __name__ == "__main__":
    unittest.main()
