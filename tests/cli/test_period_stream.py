"""toliman period --follow, --save-state, --from-state, other forms of input, and toliman merge."""
import json
import math
import unittest

import numpy
from astropy.timeseries import LombScargle
from program import ProgramTest

GRID = ("--f0", 1e-3, "--df", 1e-4, "--nf", 900)
BOUNDS = ("--sigma-floor", 0.1, "--sigma-ceiling", 3, "--value-bound", 64)


class Series(ProgramTest):
    def setUp(self):
        super().setUp()
        random = numpy.random.default_rng(4)
        t = numpy.sort(random.uniform(2451000, 2452000, 60))
        sigma = random.uniform(0.2, 1, 60)
        self.series = numpy.column_stack([t, 2 * numpy.sin(2 * math.pi * 0.043 * t) + sigma * random.normal(size=60),
                                          sigma])
        self.write("all.csv", self.series)

    def write(self, name, rows):
        lines = [",".join(repr(float(x)) for x in row) for row in rows]
        (self.folder / name).write_text("\n".join(["t,y,sigma", *lines]) + "\n")

    def bytes_of(self, name):
        return (self.folder / name).read_bytes()


class Streams(Series):
    def test_a_line_after_every_sample(self):
        lines = self.succeed("period", "all.csv", "--follow", *GRID, *BOUNDS).splitlines()
        updates = [json.loads(line) for line in lines]
        self.assertEqual([u["n"] for u in updates], list(range(5, 61)))
        t, y, sigma = self.series.T
        frequency = 1e-3 + 1e-4 * numpy.arange(900)
        for update in updates[20::10]:
            n = update["n"]
            power = LombScargle(t[:n] - t[0], y[:n], sigma[:n]).power(frequency, method="slow")
            self.assertEqual(update["schema"], "toliman-period-update/1")
            self.assertEqual(update["t"], t[n - 1])
            self.assertGreaterEqual(update["log10_fap_sequential"], update["log10_fap"])
            self.assertLess(abs(update["frequency"] - frequency[power.argmax()]), 1e-4)
            self.assertLess(abs(update["power"] - power.max()), 0.02)
        self.assertLess(updates[-1]["log10_fap"], -5)
        self.assertLess(updates[-1]["log10_fap_sequential"], -4)

    # promises: merged-files-give-same-bits, saved-sums-continue
    def test_states_go_on_to_the_same_bits(self):
        self.succeed("period", "all.csv", "--follow", *GRID, *BOUNDS, "--save-state", "whole.tlmp")
        self.write("first.csv", self.series[:25])
        self.write("second.csv", self.series[25:])
        self.succeed("period", "first.csv", "--follow", *GRID, *BOUNDS, "--save-state", "part.tlmp")
        self.succeed("period", "second.csv", "--from-state", "part.tlmp", "--save-state", "both.tlmp")
        self.assertEqual(self.bytes_of("both.tlmp"), self.bytes_of("whole.tlmp"))
        # The other shard has other references: merged, its power is that of all samples but for rounding.
        self.succeed("period", "second.csv", "--follow", *GRID, *BOUNDS[2:4], "--save-state", "2.tlmp")
        self.assertEqual(self.succeed("merge", "part.tlmp", "2.tlmp", "--out", "merged.tlmp"), "")
        results = [json.loads(self.succeed("period", "--from-state", name, "--json", "--power", name + ".npy"))
                   for name in ("whole.tlmp", "merged.tlmp")]
        self.assertEqual([r["n"] for r in results], [60, 60])
        power = [numpy.load(self.folder / (name + ".npy")) for name in ("whole.tlmp", "merged.tlmp")]
        self.assertLess(abs(power[0] - power[1]).max(), 1e-12)
        self.assertIsNone(results[0]["peak"]["frequency_error"])
        self.assertIn("half width", self.succeed("period", "--from-state", "whole.tlmp"))

    def test_json_lines_and_npy(self):
        expected = self.succeed("period", "all.csv", "--json")
        lines = [json.dumps({"frame": i, "y": row[1], "t": row[0], "sigma": row[2]})
                 for i, row in enumerate(self.series)]
        (self.folder / "all.jsonl").write_text("\n".join(lines) + "\n")
        numpy.save(self.folder / "all.npy", self.series)
        self.assertEqual(self.succeed("period", "all.jsonl", "--json"), expected)
        self.assertEqual(self.succeed("period", "-", "--json", input="\n".join(lines)), expected)
        self.assertEqual(self.succeed("period", "all.npy", "--json"), expected)
        renamed = "\n".join(lines).replace('"y"', '"latent"')
        self.assertNotEqual(self.succeed("period", "-", "--columns", "t,latent", "--json", input=renamed), expected)

    def test_several_peaks(self):
        result = json.loads(self.succeed("period", "all.csv", *GRID, "--peaks", 6, "--json"))
        peaks = result["peaks"]
        self.assertEqual(len(peaks), 6)
        self.assertAlmostEqual(peaks[0]["frequency"], result["peak"]["frequency"], delta=5e-5)
        self.assertEqual([p["power"] for p in peaks], sorted((p["power"] for p in peaks), reverse=True))
        self.assertFalse(peaks[0]["alias"])
        self.assertEqual(self.succeed("period", "all.csv", *GRID, "--peaks", 6).count("\npeak "), 5)

    def test_refusals(self):
        self.succeed("period", "all.csv", "--follow", *GRID, *BOUNDS, "--save-state", "a.tlmp")
        self.succeed("period", "all.csv", "--follow", "--f0", 2e-3, *GRID[2:], *BOUNDS, "--save-state", "b.tlmp")
        (self.folder / "bad.jsonl").write_text('{"t": 1, "y": 2\n')
        self.refuse_all(
            (2, "--follow", "all.csv", "--follow"), (2, "FILE"), (3, "none.tlmp", "--from-state", "none.tlmp"),
            (2, "--peaks", "all.csv", "--peaks", 65), (3, "bad.jsonl:1: ", "bad.jsonl"),
            (2, "--fap bootstrap: ", "--from-state", "a.tlmp", "--fap", "bootstrap"),
            (2, "--f0", "--from-state", "a.tlmp", "--f0", 1), command=("period",))
        for text, *names in (("all.csv", "all.csv", "all.csv"), ("b.tlmp: merge: ", "a.tlmp", "b.tlmp")):
            self.refuse(3, text, arguments=("merge", *names, "--out", "c"))
        for array, why in ((numpy.zeros((4, 4)), ""), (numpy.zeros(4), ""), (numpy.zeros((0, 2)), ""),
                           (numpy.array([[1, 2], [3, math.nan]]), 'row 1, y = "nan"')):
            numpy.save(self.folder / "bad.npy", array)
            self.refuse(3, "bad.npy: ", why, arguments=("period", "bad.npy"))

    def test_what_is_beyond_the_bounds_names_the_option(self):
        for name, row, option in (("value", [9, 1e6, 1], "--value-bound"), ("fine", [9, 0, 0.01], "--sigma-floor"),
                                  ("rough", [9, 0, 9], "--sigma-ceiling")):
            self.write(name + ".csv", [*self.series[:6], row])
            self.refuse(3, f"{name}.csv: sample 7: ", f"({option})", arguments=("period", name + ".csv", *GRID, *BOUNDS))
        self.succeed("period", "all.csv", *GRID, *BOUNDS, "--save-state", "all.tlmp")
        self.refuse(3, "value.csv:8: y = 1e+06: ", "(--value-bound ",
                    arguments=("period", "value.csv", "--from-state", "all.tlmp"))
        for option, value in zip(BOUNDS[::2], BOUNDS[1::2]):
            self.refuse(2, option, "--from-state",
                        arguments=("period", "all.csv", "--from-state", "all.tlmp", option, value))
        self.refuse(2, "--value-bound, --sigma-floor, --sigma-ceiling: sigma_ceiling = 0.1",
                    arguments=("period", "all.csv", "--sigma-ceiling", 0.1))


class States(Series):
    """Sums that one run saves and another continues."""

    def test_margins(self):
        """Other samples than those at hand may come."""
        more = numpy.array([[2453000 + i, 3e5 * (-1) ** i, 0.9] for i in range(6)])
        self.write("more.csv", more)
        self.succeed("period", "all.csv", *GRID, "--save-state", "all.tlmp")
        self.succeed("period", "more.csv", "--from-state", "all.tlmp", "--save-state", "both.tlmp")
        self.write("both.csv", [*self.series, *more])
        both, at_once = [json.loads(self.succeed("period", *how, "--json"))
                         for how in (("--from-state", "both.tlmp"), ("both.csv", *GRID))]
        self.assertEqual(both["n"], 66)
        self.assertAlmostEqual(both["peak"]["power"], at_once["peak"]["power"], delta=0.01)
        self.write("s.csv", [[i, math.sin(i), 33 if i % 2 else 1] for i in range(20)])
        self.succeed("period", "s.csv", "--f0", 0.1, "--df", 0.01, "--nf", 30, "--save-state", "s.tlmp")
        for sigma, option in ((1 / 8, None), (0.1249, "floor"), (132, None), (132.1, "ceiling")):
            self.write("next.csv", [[30, 0, sigma]])
            done = self.run_program("period", "next.csv", "--from-state", "s.tlmp")
            self.assertEqual(done.returncode, 0 if option is None else 3, done.stderr)
            self.assertIn("" if option is None else f"(--sigma-{option} ", done.stderr)

    def test_sigmas_in_all_or_none(self):
        self.write("first.csv", self.series[:30])
        self.write("plain.csv", self.series[30:, :2])
        plain = (self.folder / "plain.csv").read_text().replace("t,y,sigma", "t,y")
        (self.folder / "plain.csv").write_text(plain)
        for name in ("first", "plain"):
            for how in ("", "--follow"):
                self.succeed("period", name + ".csv", *GRID, *how.split(), "--save-state", f"{name}{how}.tlmp")
        for how in ("", "--follow"):
            self.refuse(3, "plain.csv:2: ", arguments=("period", "plain.csv", "--from-state", f"first{how}.tlmp"))
            self.refuse(3, "first.csv:2: ", arguments=("period", "first.csv", "--from-state", f"plain{how}.tlmp"))
            self.refuse(3, "plain--follow.tlmp: ",
                        arguments=("merge", f"first{how}.tlmp", "plain--follow.tlmp", "--out", "x.tlmp"))
        # Those without, saved either way, weigh the same.
        self.succeed("merge", "plain--follow.tlmp", "plain.tlmp", "--out", "x.tlmp")
        t, y, _ = self.series[30:].T
        self.succeed("period", "--from-state", "x.tlmp", "--power", "x.npy")
        frequency = 1e-3 + 1e-4 * numpy.arange(900)
        power = LombScargle(t - t[0], y).power(frequency, method="slow")
        self.assertLess(abs(numpy.load(self.folder / "x.npy") - power).max(), 1e-9)

    # promise: nothing-is-merged-twice
    def test_nothing_is_counted_twice(self):
        self.succeed("period", "all.csv", *GRID, "--save-state", "a.tlmp")
        (self.folder / "copy.tlmp").write_bytes(self.bytes_of("a.tlmp"))
        self.write("other.csv", self.series[:20])
        self.succeed("period", "other.csv", *GRID, "--save-state", "b.tlmp")
        self.write("far.csv", self.series + [0, 1e9, 0])
        self.succeed("period", "far.csv", *GRID, "--save-state", "far.tlmp")
        for code, text, out, *names in ((3, "a.tlmp: ", "c", "a.tlmp", "a.tlmp"), (2, "merge: ", "c", "a.tlmp"),
                                        (3, "copy.tlmp: ", "c", "a.tlmp", "b.tlmp", "copy.tlmp"),
                                        (6, "no/c: ", "no/c", "a.tlmp", "b.tlmp"),
                                        (3, "far.tlmp: merge: ", "c", "a.tlmp", "far.tlmp")):
            self.refuse(code, text, arguments=("merge", *names, "--out", out))
        self.refuse(3, "a.tlmp: ", "--from-state", arguments=("period", "a.tlmp"))

    def test_what_cannot_be_written_is_told_first(self):
        (self.folder / "bad.csv").write_text("t,y\n1,junk\n")  # an error if it were read
        for options in (("--save-state",), ("--power",), ("--follow", *GRID, "--save-state")):
            self.refuse(6, "no/x: ", arguments=("period", "bad.csv", *options, "no/x"))

    def test_follow_keeps_all_digits(self):
        """Over a small part of a cycle, and from frequency 0 on, a stream has the power of the whole file."""
        few = ("--f0", 0, "--df", 1e-6, "--nf", 4)
        self.succeed("period", "all.csv", *few, "--power", "file.npy")
        lines = self.run_program("period", "all.csv", "--follow", *few, "--save-state", "few.tlmp").stdout.splitlines()
        self.run_program("period", "--from-state", "few.tlmp", "--power", "stream.npy")
        powers = [numpy.load(self.folder / name) for name in ("file.npy", "stream.npy")]
        self.assertEqual(powers[0][0], 0)
        self.assertLess(abs(powers[1][1:] / powers[0][1:] - 1).max(), 1e-12)
        for line in lines:
            update = json.loads(line, parse_constant=self.fail)  # no inf, no NaN
            self.assertEqual(update["period"] is None, update["frequency"] == 0)


if __name__ == "__main__":
    unittest.main()
