"""toliman planet: planets of velocities and separations, limits, a map that resumes, a state folder, the page of a report."""
import json
import logging
import math
import os
import unittest

import numpy
from observed import EXPOSURE, SCALE, START, DAY, measured, mjd, toliman, write_series
from pages import Recorder, ReportTest, lines
from program import ROOT, long

DATA = ROOT / "examples" / "data" / "nu_oph_rv.csv"
NU_OPH = (DATA, "--unit", "m/s", "--max", 2, "--star-masses", 2.7, "--period-min", 400, "--period-max", 4000)
LOW = ("--system", "alpha-cen", "--altitude", 600, "--plate-scale", SCALE, "--exposure", EXPOSURE, "--time-scale", "tai")
UAS = ("--unit", "uas", "--star-masses", "1.0788,0.9092", "--parallax", 750.81)
MAP = ("--map", "--map-cells", "3x2", "--map-injections", 5)
FILES = ["limits.csv", "map.csv", "result.json", "samples_1.npy", "series.csv"]


def setUpModule():
    logging.getLogger("toliman").setLevel(logging.ERROR)


def wave(days, period, amplitude):
    return amplitude * numpy.cos(2 * numpy.pi * days / period + 0.4)


class Planet(ReportTest):
    def planet(self, *arguments):
        return json.loads(self.succeed("planet", *arguments, "--json"))

    def rejected(self, message, *arguments):
        done = self.run_program("planet", "s.csv", *UAS, *arguments)
        self.assertEqual(done.returncode, 4, done.stderr)
        self.assertIn(message + "\n", done.stderr)
        return done

    def write_uas(self, amplitude=2.0, sigma=0.3, count=80):
        """80 separations in microarcsec, plain times."""
        random = numpy.random.default_rng(7)
        days = numpy.sort(random.uniform(0, 700, count))
        y = wave(days, 140, amplitude) + sigma * random.normal(size=count)
        write_series(self.folder / "s.csv", days, y, sigma, "t")
        return days, y

    def inside(self, points, truth, most=4):
        low, middle, high = points
        self.assertLess(low, high)
        self.assertLess(abs(middle - truth), most * (high - low) / 2)


class Results(Planet):
    @long
    def test_velocities(self):
        """The two companions of nu Ophiuchi."""
        found = self.planet(*NU_OPH)
        self.assertEqual((found["planets"], found["kind"], found["unit"], found["axis"]), (2, "velocity", "m/s", None))
        inner, outer = found["candidates"]
        for planet, published in ((inner, {"period": (530.32, 0.35), "eccentricity": (0.1256, 0.0065)}),
                                  (outer, {"period": (3186, 14), "eccentricity": (0.165, 0.013)})):  # Sato et al. 2012, PASJ 64, 135
            for name, (value, error) in published.items():
                low, middle, high = planet[name]
                self.assertLess(abs(middle - value), 2 * numpy.hypot((high - low) / 2, error), name)
        self.inside(inner["mass_a_earth"], 22.2 * 317.8)
        self.assertIsNone(inner["mass_b_earth"])
        self.assertIsNone(inner["amplitude_uas"])
        self.assertEqual(len(found["jitter"]), 3)

    def test_reduced_separations(self):
        """Unit, masses, parallax, position angles and the errors of the orbit are those of the system."""
        days = numpy.sort(numpy.random.default_rng(3).choice(1000, 120, replace=False)) + 0.25
        tai_ns = START + (days * DAY).astype(numpy.int64)
        arcsec = measured(toliman.Sky(altitude_km=600), tai_ns, wave(days, 250, 2.5))
        arcsec += 3e-7 * numpy.random.default_rng(4).normal(size=120)
        write_series(self.folder / "s.csv", mjd(tai_ns), arcsec / SCALE, 3e-7 / SCALE)
        found = self.planet("s.csv", *LOW)
        (one,) = found["candidates"]
        self.inside(one["period"], 250)
        self.inside(one["amplitude_uas"], 2.5)
        self.assertEqual((found["unit_arcsec"], found["parallax_mas"], found["star_masses"]), (SCALE, 750.81, [1.0788, 0.9092]))
        self.assertEqual((found["functions"], found["time_scale"], found["reduction"]["observer"]), (8, "TAI", "circular orbit"))
        self.assertGreater(found["axis"]["turn_deg"], 5)
        # a planet of mass m at 250 d of star A: a m/M
        semi_major_au = (1.0788 * (250 / 365.25) ** 2) ** (1 / 3)
        mass = 2.5 / (semi_major_au * 0.75081e6 * 3.00349e-6 / 1.0788)
        self.inside(one["mass_a_earth"], mass)
        text = self.succeed("planet", "s.csv", *LOW, "--star-masses", 1.0788, "--trend", 0)
        self.assertRegex(text, r"\n  epoch +6\d{4} \(.*\) MJD, 202\d-\d\d-\d\d TAI\n  amplitude .* uas\n  mass .* on A, Earths times g")
        self.assertRegex(text, r"\naxis +position angle .*\nreduced +alpha-cen seen from: ")

    def test_text(self):
        self.write_uas()
        text = self.succeed("planet", "s.csv", "--max", 2, "--limits", *MAP)
        self.assertRegex(text, r"^planet 1    log10 Bayes factor \d+\.\d\d, log10 FAP -\d+\.\d\d, of the orbit -\d+\.\d\d\n  period  +1\d\d\.\d+ \(-")
        self.assertRegex(text, r"\n  mass +unknown without --unit, --parallax, --star-masses\n")
        self.assertRegex(text, r"\ncandidate   period .* threshold 2: .* log10 FAP ")
        self.assertRegex(text, r"\naxis        fixed: .*--system")
        self.assertRegex(text, r"\n +period +upper +detectable\n +60 ")
        self.assertRegex(text, r"\nresiduals   rms .*, chi-square .* \+- .*: good, .* sigma\n")

    def test_amplitudes_in_microarcsec(self):
        """Those of all lists, of a series in px; null for a unit that is not known."""
        days, y = self.write_uas()
        write_series(self.folder / "px.csv", days, y * 1e-6 / 0.375, 0.3e-6 / 0.375, "t")
        for names, known in ((("px.csv", "--unit", "px", "--plate-scale", 0.375, "--limits"), True), (("px.csv", "--limits"), False)):
            found = self.planet(*names)
            (one, *_), limits, prior = found["candidates"], found["limits"]["periods"], found["prior"]
            pairs = [(found["rms"], found["rms_uas"]), (prior["amplitude_min"], prior["amplitude_min_uas"]),
                     (prior["amplitude_max"], prior["amplitude_max_uas"]), (one["best"]["amplitude"], one["best"]["amplitude_uas"]),
                     (one["best_error"]["amplitude"], one["best_error"]["amplitude_uas"]),
                     *((one["amplitude"][k], (one["amplitude_uas"] or [None] * 3)[k]) for k in range(3)),
                     *((limit[name], limit[name + "_uas"]) for limit in limits for name in ("upper", "detectable"))]
            for pixels, uas in pairs:
                if known and pixels is not None:
                    self.assertAlmostEqual(uas / (pixels * 0.375e6), 1, places=12)
                else:
                    self.assertIsNone(uas)

    # promise: refused-candidates-exit-with-4
    def test_candidates_that_are_no_planets(self):
        """Exit code 4, the reason in text, JSON and message; the result is printed and written all the same."""
        days, y = self.write_uas()
        y[11] += 50
        write_series(self.folder / "s.csv", days, y, 0.3, "t")
        result = self.rejected("s.csv: candidate 1 is not a planet: there are outliers", "--out", "out")
        self.assertRegex(result.stdout, r"^no planet\ncandidate 1 log10 Bayes factor .*\n  reason        there are outliers")
        self.assertIn(f"\noutliers    1, without weight in the search: t = {days[11]:.9g}\n", result.stdout)
        found = json.loads((self.folder / "out" / "result.json").read_text())
        (one,) = found["candidates"]
        self.assertEqual((found["planets"], one["verdict"], one["reasons"], found["goodness"], found["clip"]),
                         (0, "candidate", ["there are outliers"], "poor", False))
        self.assertEqual(found["outliers"], [{"index": 11, "t": days[11]}])
        self.report("out")
        self.check_page(self.folder / "out" / "report", ["planet-1", "posterior-1"])
        clipped = self.planet("s.csv", *UAS, "--clip")
        self.assertEqual((clipped["planets"], clipped["goodness"], clipped["candidates"][0]["verdict"]), (1, "good", "planet"))
        self.inside(clipped["candidates"][0]["period"], 140)

    def test_odds_at_the_threshold(self):
        self.write_uas()
        given = ("s.csv", *UAS, "--period-min", 100, "--threshold")
        odds = self.planet(*given, 2)["candidates"][0]["log10_bayes"]
        reached = self.rejected("the odds have not converged", "--period-min", 100, "--threshold", repr(odds))
        self.assertRegex(reached.stdout, r"^no planet\ncandidate 1 log10 Bayes factor ")
        self.assertRegex(self.succeed("planet", *given, repr(math.nextafter(odds, math.inf))), r"^no planet\ncandidate   period ")

    def test_jitter(self):
        random = numpy.random.default_rng(5)
        days = numpy.sort(random.uniform(0, 700, 120))
        write_series(self.folder / "s.csv", days, wave(days, 140, 3) + 0.45 * random.normal(size=120), 0.3, "t")
        found = self.planet("s.csv", *UAS)
        self.inside(found["jitter"], (0.45**2 - 0.3**2) ** 0.5)
        self.assertEqual((found["planets"], found["goodness"]), (1, "poor"))
        self.assertAlmostEqual(found["chi_square_with_jitter"], 1, delta=0.1)
        self.rejected("chi-square of the fit is too good, or poor without a jitter", "--no-jitter")


class Folder(Planet):
    # promises: maps-ignore-threads-and-stops, stopped-work-resumes
    def test_folder_map_and_page(self):
        t, y = self.write_uas()
        arguments = ("planet", "s.csv", *UAS, "--limits", *MAP)
        printed = json.loads(self.succeed(*arguments, "--out", "out", "--json"))
        self.assertEqual(sorted(os.listdir(self.folder / "out")), FILES)
        result = json.loads((self.folder / "out" / "result.json").read_text())
        self.assertEqual({key: value for key, value in result.items() if key not in ("version", "provenance")}, printed)
        series = numpy.genfromtxt(self.folder / "out" / "series.csv", delimiter=",", names=True, skip_header=1)
        numpy.testing.assert_array_equal((series["t"], series["y"]), (t, y))
        rest = series["y"] - series["residual"] - series["signal_1"]
        numpy.testing.assert_allclose(rest, rest[0], atol=1e-5)  # the mean
        samples = numpy.load(self.folder / "out" / "samples_1.npy")
        self.assertEqual(samples.shape, (4096, 10))
        numpy.testing.assert_allclose(numpy.median(samples[:, [0, 5]], axis=0),
                                      [result["candidates"][0][key][1] for key in ("period", "mass_a_earth")], rtol=0.02)
        self.check_map(arguments, result)
        self.check_report(result, series)

    def check_map(self, arguments, result):
        path = self.folder / "out" / "map.csv"
        whole = path.read_bytes()
        cells = numpy.genfromtxt(path, delimiter=",", names=True, skip_header=2)
        numpy.testing.assert_array_equal(cells["detected"].reshape(2, 3), result["map"]["detected"])
        numpy.testing.assert_array_equal(cells["cell"], numpy.arange(6))
        self.assertEqual(result["map"]["star"], "A")
        path.write_bytes(whole[:whole.index(b"\n3,") + 4])  # a stop within the line of a cell
        self.succeed(*arguments, "--out", "out", "--threads", 1)
        self.assertEqual(path.read_bytes(), whole)
        self.refuse(2, "out/map.csv: ", 'seed = "0": ', arguments=(*arguments, "--seed", 1, "--out", "out"))
        self.assertEqual(path.read_bytes(), whole)
        for text, line in ((whole.replace(b"\n2,", b"\n7,"), ":6"), (b"my notes\n", "")):
            path.write_bytes(text)
            self.refuse(3, f"out/map.csv{line}: ", arguments=(*arguments, "--out", "out"))
        path.write_bytes(whole)

    def check_report(self, result, series):
        self.report("out")
        page = self.check_page(self.folder / "out" / "report", ["planet-1", "posterior-1", "limits", "map"])
        self.assertIn("80 samples: period 1", page.text)
        self.assertRegex(page.row("mass in Earths, times g, on A")[0], r"^\d\.\d+ \(−")
        figures = Recorder(self.folder / "out").figures
        top = lines(figures["planet-1"].axes[0])
        best = result["candidates"][0]["best"]
        phase = numpy.mod((series["t"] - best["epoch"]) / best["period"], 1)
        numpy.testing.assert_array_equal(top["each sample"][0], phase)
        curve = numpy.interp(phase, *top["best orbit"])
        numpy.testing.assert_allclose(curve, series["signal_1"], atol=1e-3 * best["amplitude"])
        self.assertIn("Earth", [text.get_text() for text in figures["limits"].axes[0].texts])
        (self.folder / "out" / "map.csv").write_text("detected,injections\n1,5\n")
        self.fail_with("out/map.csv: ", "out")


class State(Planet):
    """State folders of a tracker, whose estimates are a planet of 2.5 uas and 250 d."""

    SIGMA = 3e-7 / SCALE

    def write_state(self, folder, **options):
        days = numpy.sort(numpy.random.default_rng(3).choice(1000, 120, replace=False)) + 0.25
        times = START + (days * DAY).astype(numpy.int64)
        planet, noise = wave(days, 250, 2.5), numpy.random.default_rng(4).normal(size=120)
        self.px = (measured(toliman.Sky(altitude_km=600), times, planet) if options else 1e-6 * planet) / SCALE
        self.px += self.SIGMA * noise

        def estimate(image):
            return toliman.Estimate(self.px[int(image[0, 0])] - self.px[0], [self.px[int(image[0, 0])]])
        with toliman.Tracker(estimate, 1e-3, 1e-3, 20, folder=self.folder / folder, sigma=self.SIGMA, estimator_id=5,
                             values=["separation_px"], rows=4, cols=4, image_shape=(4, 4), allow_zero_runs=True,
                             time_offset_ns=START, sync="none", double_limb=True, value_limit=1, **options) as tracker:
            tracker.push_many(toliman.Frame(numpy.full((4, 4), float(k)), frame_id=k, camera_ns=int(times[k]), exposure_s=60)
                              for k in range(120))
            tracker.save()

    def test_with_a_system(self):
        sky = toliman.Sky("alpha-cen", altitude_km=600)
        self.write_state("state", sky=sky, plate_scale_arcsec=SCALE)
        found = self.planet("state")
        self.inside(found["candidates"][0]["period"], 250)
        self.inside(found["candidates"][0]["amplitude_uas"], 2.5)
        self.assertEqual((found["unit_arcsec"], found["star_masses"], found["functions"], found["time_scale"], found["n"]),
                         (SCALE, [1.0788, 0.9092], 8, "TAI", 120))
        self.assertGreater(found["axis"]["turn_deg"], 5)
        for option in ("--unit", "uas"), ("--system", "alpha-cen"), ("--trend", 2), ("--columns", "t,y"), ("--plate-scale", 1):
            self.refuse(2, f"{option[0]}: ", arguments=("planet", "state", *option))

    def test_without_a_system(self):
        self.write_state("state")
        found = self.planet("state", "--plate-scale", SCALE, *UAS[2:])
        self.inside(found["candidates"][0]["amplitude_uas"], 2.5)
        self.assertEqual((found["axis"], found["functions"]), (None, 1))
        self.assertIsNone(self.planet("state")["unit_arcsec"])


class Refusals(Planet):
    def test_options(self):
        self.write_uas(count=20)
        write_series(self.folder / "plain.csv", numpy.arange(20.0), numpy.arange(20.0), name="t")
        write_series(self.folder / "few.csv", numpy.arange(3.0), numpy.arange(3.0), 0.1, "t")
        self.refuse_all(
            (2, "--unit px: ", "s.csv", "--unit", "px"), (2, "--plate-scale: ", "s.csv", "--plate-scale", 0.4),
            (2, "--unit pc: ", "s.csv", "--unit", "pc"),
            (2, "excludes", "s.csv", "--unit", "uas", "--system", "alpha-cen"),
            (2, "--star-masses -1: ", "s.csv", "--star-masses", -1),
            (2, "--star-masses: ", "s.csv", "--unit", "m/s", "--star-masses", "1,2"),
            (2, "--parallax: ", "s.csv", "--unit", "m/s", "--parallax", 700), (2, "--max 5: ", "s.csv", "--max", 5),
            (2, "--threshold -1: ", "s.csv", "--threshold", -1), (2, "--fap 1: ", "s.csv", "--fap", 1),
            (2, "--period-min 2000: ", "s.csv", "--period-min", 2000),
            (2, "--map-cells 3: ", "s.csv", "--map", "--map-cells", 3),
            (2, "--map-masses 2,1: ", "s.csv", *UAS, "--map", "--map-masses", "2,1"),
            (2, "--map-masses: ", "s.csv", "--map", "--map-masses", "1,2"),
            (2, "--map-masses ", "s.csv", "--map-masses", "1,2"),
            *((3, f"{name}: ", name, *more)
                for name, *more in (("plain.csv", "--no-jitter"), ("few.csv",), ("missing.csv",))),
            command=("planet",))
        (self.folder / "out").mkdir()
        (self.folder / "out" / "series.csv").write_text("my notes\n")
        self.refuse(6, "out/series.csv: ", arguments=("planet", "s.csv", "--out", "out"))
        (self.folder / "empty").mkdir()
        self.refuse(3, "empty: ", arguments=("planet", "empty"))


if __name__ == "__main__":
    unittest.main()
