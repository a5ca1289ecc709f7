"""toliman period --follow, --save-state, --from-state, other forms of input, and toliman merge."""
import json
import math
import unittest

import numpy
from astropy.timeseries import LombScargle
from program import ProgramTest

GRID = ("--f0", 1e-3, "--df", 1e-4, "--nf", 900)
BOUNDS = ("--sigma-floor", 0.1, "--sigma-ceiling", 3, "--value-bound", 64)


class Streams(ProgramTest):
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

    def test_states_go_on_to_the_same_bits(self):
        self.succeed("period", "all.csv", "--follow", *GRID, *BOUNDS, "--save-state", "whole.tlmp")
        self.write("first.csv", self.series[:25])
        self.write("second.csv", self.series[25:])
        self.succeed("period", "first.csv", "--follow", *GRID, *BOUNDS, "--save-state", "part.tlmp")
        self.succeed("period", "second.csv", "--from-state", "part.tlmp", "--save-state", "both.tlmp")
        self.assertEqual(self.bytes_of("both.tlmp"), self.bytes_of("whole.tlmp"))
        # The other shard has other references: merged, its power is that of all samples but for rounding.
        self.succeed("period", "second.csv", "--follow", *GRID, *BOUNDS[:4], "--value-bound", 32, "--save-state", "2.tlmp")
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
        self.refuse(2, "--follow needs --f0, --df and --nf", arguments=("period", "all.csv", "--follow"))
        self.refuse(2, "FILE is required", arguments=("period",))
        self.refuse(3, "none.tlmp", arguments=("period", "--from-state", "none.tlmp"))
        self.refuse(3, "all.csv", arguments=("merge", "all.csv", "--out", "x.tlmp"))
        self.refuse(2, "--peaks", arguments=("period", "all.csv", "--peaks", 65))
        self.succeed("period", "all.csv", "--follow", *GRID, *BOUNDS, "--save-state", "a.tlmp")
        self.succeed("period", "all.csv", "--follow", "--f0", 2e-3, "--df", 1e-4, "--nf", 900, *BOUNDS,
                     "--save-state", "b.tlmp")
        self.refuse(3, "b.tlmp: merge: a grid of 900 frequencies", arguments=("merge", "a.tlmp", "b.tlmp", "--out", "c"))
        self.refuse(2, "--fap bootstrap draws from the samples", arguments=("period", "--from-state", "a.tlmp", "--fap", "bootstrap"))
        self.refuse(2, "--from-state", "--f0", arguments=("period", "--from-state", "a.tlmp", "--f0", 1))
        for text, why in (('{"t": 1, "y": 2}\n3,4\n', "3,4"), ('1,2\n{"t": 1, "y": 2}\n', "is a JSON object"),
                          ('{"t": 1}\n', 'has no number "y"'), ('{"t": 1, "y": "x"}\n', 'has no number "y"'),
                          ('{"t": 1, "y": 2, "sigma": -1}\n', "must be above 0"), ('{"t": 1, "y": 2\n', "is no JSON"),
                          ('{"t": 1, "y": 2, "sigma": 1}\n{"t": 1, "y": 2}\n', "sigma in all or none")):
            (self.folder / "bad.jsonl").write_text(text)
            self.refuse(3, "bad.jsonl:", why if why != "3,4" else "is no JSON object, as the lines before",
                        arguments=("period", "bad.jsonl"))
        for array, why in ((numpy.zeros((4, 4)), "of shape [samples][2 or 3]"), (numpy.zeros(4), "of shape"),
                           (numpy.zeros((0, 2)), "holds no samples"),
                           (numpy.array([[1, 2], [3, math.nan]]), "row 1, y = nan")):
            numpy.save(self.folder / "bad.npy", array)
            self.refuse(3, "bad.npy: ", why, arguments=("period", "bad.npy"))
        far = [[1, 1e6, 1]] + [[i, 0, 1] for i in range(5)]
        self.write("far.csv", far[1:3] + far[:1])
        self.refuse(3, "far.csv: sample 3: y = 1e+06: further than value_bound = 64",
                    arguments=("period", "far.csv", "--follow", *GRID, *BOUNDS))


if __name__ == "__main__":
    unittest.main()
