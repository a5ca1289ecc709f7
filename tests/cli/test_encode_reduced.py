"""toliman encode --fit --system: reduced separations of frames against Sky.predict_mean."""
import copy
import csv
import io
import json
import logging
import unittest

import numpy
from astropy.io import fits
from observed import DAY, SECOND, toliman, write_orbit
from program import ROOT, ProgramTest
from test_fit import COLUMNS, SCENE

SCALE = 0.4
OBSERVED = {**SCENE, "binary": {**SCENE["binary"], "observer": {"altitude_km": 600}},
            "stars": {name: {"spectrum": star["spectrum"], "photons_per_s": 1e6} for name, star in SCENE["stars"].items()},
            "signal": {**SCENE["signal"], "amplitude_px": 1e-5},
            "cadence": {"frames": 4, "interval_days": 30, "exposure_s": 120}, "noise": {"photon": False}}
LOW = ("--system", "alpha-cen", "--altitude", 600)


def setUpModule():
    logging.getLogger("toliman").setLevel(logging.ERROR)


class Reduced(ProgramTest):
    def rows(self, scene, *arguments, warning=None, frames="0:4", file="f.fits"):
        (self.folder / "s.json").write_text(json.dumps(scene))
        made = self.run_program("simulate", "s.json", "--frames", frames, "--out", file, "--force")
        self.assertEqual(made.returncode, 0, made.stderr)
        done = self.run_program("encode", "--fit", "s.json", file, *arguments)
        self.assertEqual(done.returncode, 0, done.stderr)
        if warning is not None:
            self.assertIn(warning, done.stderr)
        self.assertEqual(done.stdout.splitlines()[0], COLUMNS + ",mjd,factor,geometric_arcsec,reduced_px")
        return list(csv.DictReader(io.StringIO(done.stdout)))

    def check(self, rows, zero_ns, intervals, sky, scale=SCALE):
        """intervals: s from the middle of an exposure. Returns the reduced separations in uas."""
        for k, row in enumerate(rows):
            middle = zero_ns + 30 * k * DAY
            self.assertAlmostEqual(toliman.parse_time(row["mjd"], "mjd", "tai"), middle, delta=1000)
            seen = sky.predict_mean([[middle + int(a * SECOND), middle + int(b * SECOND)] for a, b in intervals])
            self.assertEqual((float(row["factor"]), float(row["geometric_arcsec"])), (seen.factor, seen.geometric_arcsec))
            expected = float(row["separation_px"]) / seen.factor - seen.geometric_arcsec / scale
            self.assertAlmostEqual(float(row["reduced_px"]), expected, delta=1e-13)
        return [float(row["reduced_px"]) * scale * 1e6 for row in rows]

    def test_exposures_of_the_scene(self):
        sky, zero_ns = toliman.Sky(altitude_km=600), toliman.parse_time("2461406.75", "jd", "tt")
        left = self.check(self.rows(OBSERVED, *LOW), zero_ns, [[-60, 60]], sky)
        planet = 4 * numpy.sin(2 * numpy.pi * 30 * numpy.arange(4) / 40)  # uas
        self.assertLess(numpy.abs(left - planet).max(), 1)
        self.assertGreater(numpy.abs(planet).max(), 3)
        self.check(self.rows(OBSERVED, *LOW, "--plate-scale", 0.401), zero_ns, [[-60, 60]], sky, 0.401)

    def test_on_target_intervals(self):
        scene = copy.deepcopy(OBSERVED)
        scene["cadence"].update(exposure_s=7200, on_target_s=[0, 600, 6000, 7000.5])
        self.check(self.rows(scene, *LOW), toliman.parse_time("2461406.75", "jd", "tt"),
                   [[-3600, -3000], [2400, 3400.5]], toliman.Sky(altitude_km=600))

    def test_epoch(self):
        """Of frames whose times are those of the scene; by default its date. One that differs is reported."""
        scene, sky = copy.deepcopy(OBSERVED), toliman.Sky(altitude_km=600)
        del scene["binary"]["observer"]
        for epoch in ("2027-060 06:00:00+00:00", toliman.parse_time("2027-03-01T06:00:00"), "61465.25"):
            rows = self.rows(scene, *LOW, "--epoch", epoch, file="f.npy", warning=f"--epoch {epoch}: ")
            self.check(rows, toliman.parse_time("2027-03-01T06:00:00"), [[-60, 60]], sky)
        self.check(self.rows(scene, *LOW, file="f.npy"), toliman.parse_time("2461406.75", "jd", "tt"), [[-60, 60]], sky)

    def test_defaults_of_the_scene(self):
        """A scene with a system and an observer needs no option, and gives what the options give."""
        write_orbit(self.folder / "low.csv", toliman.parse_time("2461406.75", "jd", "tt") - 3600 * SECOND, 120)
        for observer, options in (({"file": "low.csv"}, (*LOW[:2], "--observer", "low.csv")),
                                  ({"altitude_km": 700, "node_hours": 6}, (*LOW[:2], "--altitude", 700, "--node", 6))):
            scene = copy.deepcopy(OBSERVED)
            scene["binary"]["observer"] = observer
            given = self.rows(scene, *options, frames="0:1")
            self.assertEqual(self.rows(scene, frames="0:1"), given)
        self.rows(scene, *LOW[:2], "--altitude", 650, frames="0:1", warning="binary.observer of s.json, ")
        (self.folder / "same.json").write_text((ROOT / "examples" / "systems" / "alpha-cen.json").read_text())
        self.rows(OBSERVED, "--system", "same.json", frames="0:1", warning="--system same.json: ")

    def test_times_of_headers(self):
        """A FITS header with a time is where the frame was taken, as in track: here 3 days after the scene's frame 0."""
        zero_ns, later = toliman.parse_time("2461406.75", "jd", "tt"), 3 * DAY
        scene = copy.deepcopy(OBSERVED)
        scene["cadence"]["times_days"] = [3, 33]
        for name in ("frames", "interval_days"):
            del scene["cadence"][name]
        (self.folder / "later.json").write_text(json.dumps(scene))
        self.succeed("simulate", "later.json", "--out", "later.fits", "--force")
        with fits.open(self.folder / "later.fits") as file:
            bare = [fits.PrimaryHDU(file[0].data[k]) for k in range(2)]
        (self.folder / "s.json").write_text(json.dumps(OBSERVED))
        for k, one in enumerate(bare):
            one.header["TIMESYS"] = "TAI"
            one.header["DATE-OBS"] = str(numpy.datetime64(zero_ns + later + 30 * k * DAY - 60 * SECOND, "ns"))
            one.header["EXPTIME"] = 120
            one.writeto(self.folder / f"n{k}.fits")
        done = self.run_program("encode", "--fit", "s.json", *LOW, "n0.fits", "n1.fits")
        self.assertEqual(done.returncode, 0, done.stderr)
        rows = list(csv.DictReader(io.StringIO(done.stdout)))
        left = self.check(rows, zero_ns + later, [[-60, 60]], toliman.Sky(altitude_km=600))
        self.assertLess(numpy.abs(left).max(), 5)
        self.assertLess(max(abs(float(row["displacement_px"])) for row in rows), 1e-4)  # the stars are predicted then
        self.assertEqual((done.stderr.count("warning"), done.stderr.count("too good")), (2, 2), done.stderr)  # without noise
        del bare[0].header["TIMESYS"]
        bare[0].writeto(self.folder / "utc.fits")
        done = self.run_program("encode", "--fit", "s.json", *LOW, "utc.fits")
        self.assertIn("utc.fits: time by DATE-OBS + EXPTIME/2 in UTC", done.stderr)

    def test_frames_without_a_state(self):
        zero_ns = toliman.parse_time("2461406.75", "jd", "tt")
        write_orbit(self.folder / "low.csv", zero_ns - 3600 * SECOND, 120)
        rows = self.rows(OBSERVED, "--system", "alpha-cen", "--observer", "low.csv", frames="0:3",
                         warning="warning: 2 of 3 frames ")
        self.check(rows[:1], zero_ns, [[-60, 60]], toliman.Sky(observer=self.folder / "low.csv"))
        for row in rows[1:]:
            self.assertEqual([row[name] for name in ("factor", "geometric_arcsec", "reduced_px")], ["nan"] * 3)
            self.assertGreater(float(row["separation_px"]), 20)

    def test_refit_and_period(self):
        """The lines of encode are a series: a planet of 4 uas in separations, which refit takes, too, and in reduced ones."""
        scene = copy.deepcopy(OBSERVED)
        scene["cadence"].update(frames=60, interval_days=7.3)
        (self.folder / "s.json").write_text(json.dumps(scene))
        self.succeed("simulate", "s.json", "--out", "f.fits")
        (self.folder / "e.csv").write_text(self.succeed("encode", "--fit", "s.json", "f.fits", *LOW))
        names = ("--columns", "mjd,separation_px,separation_sigma_px", "--time-scale", "tai")
        how = (*names, "--altitude", 600, "--plate-scale", SCALE, "--exposure", 120)
        self.succeed("refit", "alpha-cen", "e.csv", *how, "--out", "refit.json")
        for series in ((*how, "--system", "alpha-cen"), ("--columns", "mjd,reduced_px,separation_sigma_px", *names[2:])):
            peak = json.loads(self.succeed("period", "e.csv", *series, "--json"))["peak"]
            self.assertAlmostEqual(peak["period"], 40, delta=0.2)
            self.assertAlmostEqual(peak["amplitude"] * 1e5, 1, delta=0.1)

    def test_mistakes(self):
        self.rows(OBSERVED, *LOW, frames="0:1")
        self.succeed("simulate", "s.json", "--frames", "0:1", "--out", "f.npy")
        for name, cadence in (("long", {"exposure_s": 900}), ("instant", {"peak_photons": 1e5})):
            scene = copy.deepcopy(OBSERVED)
            del scene["cadence"]["exposure_s"]
            scene["cadence"].update(cadence)
            if name == "instant":
                scene["stars"] = SCENE["stars"]
            (self.folder / f"{name}.json").write_text(json.dumps(scene))
        undated = copy.deepcopy(OBSERVED)
        del undated["binary"]["observer"]
        (self.folder / "undated.json").write_text(json.dumps(undated))
        undated["binary"]["orbit"] = {"period_years": 80, "epoch": 2035, "semi_major_arcsec": 17.5, "eccentricity": 0.52,
                                      "inclination_deg": 79, "node_deg": 25, "periastron_deg": 232}
        (self.folder / "elements.json").write_text(json.dumps(undated))
        for code, message, scene, arguments in (
                (2, "--plate-scale -1: ", "s", (*LOW, "--plate-scale", -1)),
                *((3, f"{name}.json: cadence.exposure_s", name, LOW) for name in ("long", "instant")),
                (2, "--observer and --altitude: ", "elements", LOW[2:]),
                (2, "--epoch : ", "undated", (*LOW, "--epoch", "")),
                (2, 'system = "": ', "s", ("--system", "", *LOW[2:])),
                (3, "missing.json: ", "s", ("--system", "missing.json", "--altitude", 600))):
            with self.subTest(message):
                self.refuse(code, message, arguments=("encode", "--fit", f"{scene}.json", "f.fits", *arguments))
        done = self.run_program("encode", "--fit", "undated.json", "f.npy", *LOW, "--epoch", 2**63 - 1)
        self.assertEqual((done.returncode, done.stdout, done.stderr.count("\n")), (3, "", 2), done.stderr)  # the epoch is told
        self.refuse(2, "--system ", "--fit", arguments=("encode", "--template", "s.json", "f.fits", *LOW))


if __name__ == "__main__":
    unittest.main()
