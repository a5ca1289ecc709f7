"""toliman period --noise: correlated noise, and the warning without the option."""
import json
import unittest

import numpy
from program import ProgramTest


def correlated(rho, days=300, seed=4, signal=0.0):
    """A series of AR(1) noise with a signal of 20 days."""
    random = numpy.random.default_rng(seed)
    y = numpy.zeros(days)
    for i in range(days):
        y[i] = (rho * y[i - 1] if i else 0) + numpy.sqrt(1 - rho**2 if i else 1) * random.normal()
    t = numpy.arange(days, dtype=float)
    return numpy.c_[t, y + signal * numpy.sin(2 * numpy.pi * t / 20)]


class CorrelatedNoise(ProgramTest):
    def saved(self, series):
        numpy.savetxt(self.folder / "series.csv", series, delimiter=",", header="t,y", comments="")
        return "series.csv"

    def test_correlated_series(self):
        file = self.saved(correlated(0.7))
        plain = self.run_program("period", file, "--json")
        self.assertEqual(plain.returncode, 0)
        self.assertIn("values are correlated (whiteness: log10 p = -", plain.stderr)
        self.assertIn("--noise ar1", plain.stderr)
        white = json.loads(plain.stdout)
        self.assertLess(white["peak"]["log10_fap"], -2)
        self.assertEqual(white["noise"]["model"], "white")
        fitted = self.run_program("period", file, "--json", "--noise", "ar1")
        self.assertNotIn("values are correlated", fitted.stderr)
        noise = json.loads(fitted.stdout)["noise"]
        self.assertAlmostEqual(noise["rho"], 0.7, delta=4 * noise["rho_error"])
        self.assertAlmostEqual(noise["rho_error"], numpy.sqrt((1 - noise["rho"]**2) / 300), delta=0.01)
        self.assertAlmostEqual(noise["tau"], -1 / numpy.log(noise["rho"]), delta=1e-9)
        self.assertEqual(noise["log10_p_white"], white["noise"]["log10_p_white"])
        self.assertLess(noise["log10_p_white"], -20)
        self.assertGreater(noise["peak"]["log10_fap"], -2)
        text = self.succeed("period", file, "--noise", "ar1")
        self.assertIn(f"noise       ar1: correlation {noise['rho']:.3f} +- {noise['rho_error']:.2g} over 1,", text)
        self.assertIn("with ar1    period ", text)

    def test_signal_in_correlated_noise(self):
        file = self.saved(correlated(0.5, signal=1.0))
        peak = json.loads(self.succeed("period", file, "--json", "--noise", "ar1"))["noise"]["peak"]
        self.assertLess(peak["log10_fap"], -6)
        self.assertAlmostEqual(peak["period"], 20, delta=4 * peak["period_error"])
        self.assertAlmostEqual(peak["amplitude"], 1, delta=4 * peak["amplitude_error"])

    def test_white_series(self):
        plain = self.run_program("period", self.saved(correlated(0)), "--json")
        self.assertNotIn("correlated", plain.stderr)
        self.assertGreater(json.loads(plain.stdout)["noise"]["log10_p_white"], -3)

    def test_refusals(self):
        series = correlated(0.5)
        series[7, 0] = series[6, 0]
        file = self.saved(series)
        self.assertNotIn("noise", json.loads(self.succeed("period", file, "--json")))
        self.refuse(3, "sample 7: t = 6: must differ from that of sample 6",
                    arguments=("period", file, "--noise", "ar1"))
        self.refuse(2, "--noise", arguments=("period", file, "--noise", "ar1", "--fixed-mean"))
        self.refuse(2, "--noise", arguments=("period", file, "--noise", "pink"))


if __name__ == "__main__":
    unittest.main()
