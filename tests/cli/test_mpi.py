"""toliman-mpi: the same bits for any number of ranks, and errors that end all. TOLIMAN_MPI is the program."""
import json
import os
import subprocess
import sys
import unittest

import numpy
import schemas
from astropy.timeseries import LombScargle
from program import PATIENCE, ROOT, ProgramTest
from shared_run import FRAMES, PERIOD, SCENE, SEED, rows_of, scene_of, shared_run

sys.path.append(str(ROOT / "build" / "python"))
PROGRAM = os.environ.get("TOLIMAN_MPI", "")
# When a rank fails, the others end at once, without a second to end by themselves.
MPIRUN = ["mpirun", "--quiet", "--oversubscribe", "--bind-to", "none", "--mca", "mpi_yield_when_idle", "1",
          "--mca", "odls_base_sigkill_timeout", "0"]
if os.geteuid() == 0:
    MPIRUN.append("--allow-run-as-root")
SEEDED = ("--seed", SEED, "--json")


def digest(data):
    """FNV-1a of 64 bits."""
    value = 0xCBF29CE484222325
    for byte in data:
        value = (value ^ byte) * 0x100000001B3 % 2**64
    return f"{value:016x}"


class Mpi(ProgramTest):
    def setUp(self):
        super().setUp()
        self.scene("s.json", FRAMES)

    def scene(self, name, frames):
        """The shared run's scene."""
        (self.folder / name).write_text(json.dumps(scene_of(cadence={"frames": frames})))

    def ranks(self, count, *arguments, more=()):
        command = [*MPIRUN, "-n", str(count), PROGRAM, *map(str, arguments), *map(str, more)]
        plain = {key: value for key, value in os.environ.items() if key != "LD_PRELOAD"}  # a sanitizer's, for Python
        return subprocess.run(command, cwd=self.folder, env=plain, capture_output=True, text=True, timeout=PATIENCE)

    @staticmethod
    def messages(stderr):
        """The program's own lines: MPI may add others, of the machine."""
        return [line for line in stderr.splitlines() if line.startswith("toliman")]

    def output(self, count, *arguments):
        done = self.ranks(count, *arguments)
        self.assertEqual((done.returncode, self.messages(done.stderr)), (0, []), done.stderr)
        schemas.check(done.stdout)
        return done.stdout

    def end(self, code, text, count, *arguments, more=()):
        done = self.ranks(count, *arguments, more=more)
        self.assertEqual((done.returncode, done.stdout), (code, ""), done.stderr)
        messages = self.messages(done.stderr)
        self.assertEqual(len(messages), 1, done.stderr)
        self.assertTrue(messages[0].startswith("toliman-mpi: " + text), messages[0])

    def state_of(self, times, values, grid):
        """Digest of the state of one periodogram that takes the samples backwards."""
        from toliman import Periodogram
        with Periodogram(grid["f0"], grid["df"], grid["nf"], time_offset=times[0], double_limb=True) as periodogram:
            for t, y in zip(reversed(times), reversed(values)):
                periodogram.push(t, y)
            periodogram.save(str(self.folder / "state.tlmp"))
        return digest((self.folder / "state.tlmp").read_bytes())

    def test_template_on_1_2_3_ranks_is_that_of_run(self):
        outputs = {self.output(count, shared_run().parent / SCENE, *SEEDED) for count in (1, 2, 3)}
        self.assertEqual(len(outputs), 1)
        found = json.loads(outputs.pop())
        run = json.loads((shared_run() / "result.json").read_text())
        self.assertEqual((found["grid"], found["frames"], found["seed"]), (run["grid"], FRAMES, SEED))
        rows = rows_of(shared_run() / "series.csv")
        times, values = rows["t"].tolist(), rows["template"].tolist()
        self.assertEqual(found["digest"], self.state_of(times, values, found["grid"]))
        grid = found["grid"]
        frequency = grid["f0"] + grid["df"] * numpy.arange(grid["nf"])
        power = LombScargle(times, values).power(frequency, method="slow")
        self.assertLess(abs(1 / found["period_days"] - frequency[power.argmax()]), grid["df"])
        self.assertLess(abs(found["power"] - power.max()), 1e-2)
        self.assertLess(found["log10_fap"], -2)
        self.assertLess(abs(found["period_days"] - PERIOD), 0.05 * PERIOD)

    def test_weights_encode_as_the_program_does(self):
        self.succeed("train", "s.json", "--steps", 20, "--out", "w.tlmw")
        outputs = {self.output(count, "s.json", "--weights", "w.tlmw", "--json") for count in (1, 3)}
        self.assertEqual(len(outputs), 1)
        found = json.loads(outputs.pop())
        self.assertEqual(found["estimator"], "cae")
        self.succeed("simulate", "s.json", "--out", "frames.npy")
        lines = self.succeed("encode", "--weights", "w.tlmw", "frames.npy").splitlines()[1:]
        times, values = [float(k) for k in range(FRAMES)], [float(line.split(",")[2]) for line in lines]
        self.assertEqual(found["digest"], self.state_of(times, values, found["grid"]))

    def test_a_campaign_is_its_series(self):
        campaign = self.output(2, "s.json", "--campaign", 2, "--seed", 8)
        self.assertEqual(campaign, "".join(self.output(1, "s.json", "--seed", s, "--json") for s in (8, 9)))
        self.assertEqual(len({json.loads(line)["digest"] for line in campaign.splitlines()}), 2)

    # promise: maps-ignore-threads-and-stops
    def test_a_map_of_planets_is_that_of_the_program(self):
        """On any number of ranks, and resumed after a stop."""
        random = numpy.random.default_rng(7)
        t = numpy.sort(random.uniform(0, 700, 60))
        rows = numpy.stack([t, numpy.cos(t / 20) + 0.3 * random.normal(size=60), numpy.full(60, 0.3)], 1)
        numpy.savetxt(self.folder / "y.csv", rows, delimiter=",", header="t,y,sigma", comments="")
        arguments = ("planet", "y.csv", "--map", "--map-cells", "5x3", "--map-injections", 4, "--json", "--out")
        found = self.succeed(*arguments, "alone")
        whole = (self.folder / "alone" / "map.csv").read_bytes()
        path = self.folder / "ranks" / "map.csv"
        for count in 3, 2:
            self.assertEqual(self.output(count, *arguments, "ranks"), found)
            self.assertEqual(path.read_bytes(), whole)
            path.write_bytes(whole[:whole.index(b"\n7,") + 1])
        self.assertEqual(self.alone("planet", "--help").stdout.count("Examples:"), 1)
        self.end(3, "none.csv: ", 2, "planet", "none.csv")
        path.write_text("my notes\n")
        self.end(3, "rank 0: ranks/map.csv: ", 2, *arguments, "ranks")

    def test_more_ranks_than_frames(self):
        self.scene("five.json", 5)
        self.assertEqual(self.output(6, "five.json"), self.output(1, "five.json"))

    def test_text_and_help(self):
        found = json.loads(self.output(1, "s.json", "--json"))
        text = self.output(2, "s.json")
        for part in (f"{found['period_days']:.2f} days", f"log10 FAP {found['log10_fap']:.1f}", found["digest"]):
            self.assertIn(part, text)
        self.assertEqual(self.output(2, "--help").count("Examples:"), 1)

    def alone(self, *arguments):
        """In an environment in which MPI_Init fails."""
        environment = {**os.environ, "OMPI_MCA_pml": "none_of_these"}
        return subprocess.run([PROGRAM, *arguments], cwd=self.folder, env=environment, capture_output=True, text=True)

    def test_help_and_refusals_need_no_mpi(self):
        self.assertNotEqual(self.alone("s.json").returncode, 0)
        done = self.alone("--help")
        self.assertEqual((done.returncode, done.stdout.count("Examples:"), done.stderr), (0, 1, ""))
        done = self.alone("--version")
        self.assertRegex(done.stdout, r"\Atoliman-mpi \d+\.\d+\.\d+\n\Z")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        done = self.alone("s.json", "--sede", "1")
        self.assertEqual((done.returncode, done.stdout), (2, ""))
        self.assertEqual(done.stderr.partition(" (")[0], "toliman-mpi: unknown option --sede")

    def test_what_fails_everywhere_is_reported_once(self):
        self.scene("few.json", 4)
        for code, text, *arguments in ((2, "unknown option --sede", "s.json", "--sede", 1), (2, "--campaign", "s.json", "--campaign", 0),
                                       (2, "--campaign 2: ", "s.json", "--seed", 2**64 - 1, "--campaign", 2),
                                       (2, "--seed", "s.json", "--seed", -1), (3, "", "none.json"), (3, "", "s.json", "--weights", "none.tlmw"),
                                       (2, "few.json: cadence.frames = 4", "few.json")):
            self.end(code, text, 2, *arguments)

    def test_what_fails_on_one_rank_ends_all(self):
        self.end(3, "rank 1: ", 1, "s.json", more=(":", "-n", 1, PROGRAM, "none.json"))
        self.end(2, "rank 0: ", 1, "s.json", "--campaign", 0, more=(":", "-n", 2, PROGRAM, "s.json"))

    def test_a_full_disk_is_an_output_that_cannot_be_written(self):
        with open("/dev/full", "w") as full:
            done = subprocess.run([PROGRAM, "s.json"], cwd=self.folder, stdout=full, stderr=subprocess.PIPE, text=True)
        self.assertEqual(done.returncode, 6, done.stderr)
        self.assertIn("toliman-mpi: ", done.stderr)


if __name__ == "__main__":
    if not PROGRAM:
        sys.exit(77)
    unittest.main()
