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
from program import ProgramTest
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
    def rows(self, scene, *arguments, warning=None, frames="0:4"):
        (self.folder / "s.json").write_text(json.dumps(scene))
        made = self.run_program("simulate", "s.json", "--frames", frames, "--out", "f.fits", "--force")
        self.assertEqual(made.returncode, 0, made.stderr)
        done = self.run_program("encode", "--fit", "s.json", "f.fits", *arguments)
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
        """Of a scene without an observer."""
        scene = copy.deepcopy(OBSERVED)
        del scene["binary"]["observer"]
        self.check(self.rows(scene, *LOW, "--epoch", "2027-03-01T06:00:00"),
                   toliman.parse_time("2027-03-01T06:00:00"), [[-60, 60]], toliman.Sky(altitude_km=600))
        for epoch in (toliman.parse_time("2027-03-01T06:00:00"), "61465.25"):
            self.check(self.rows(scene, *LOW, "--epoch", epoch), toliman.parse_time("2027-03-01T06:00:00"), [[-60, 60]],
                       toliman.Sky(altitude_km=600))
        self.refuse(2, "s.json: has no binary.observer, so the date of its time 0 is not exact: give it by --epoch",
                    arguments=("encode", "--fit", "s.json", "f.fits", *LOW))

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
        bare[0].header["TIMESYS"] = ""
        del bare[0].header["TIMESYS"]
        bare[0].writeto(self.folder / "utc.fits")
        done = self.run_program("encode", "--fit", "s.json", *LOW, "utc.fits")
        self.assertIn("utc.fits: time by DATE-OBS + EXPTIME/2 in UTC, as TIMESYS is missing", done.stderr)

    def test_frames_without_a_state(self):
        zero_ns = toliman.parse_time("2461406.75", "jd", "tt")
        write_orbit(self.folder / "low.csv", zero_ns - 3600 * SECOND, 120)
        rows = self.rows(OBSERVED, "--system", "alpha-cen", "--observer", "low.csv", frames="0:3",
                         warning="warning: 2 of 3 frames are not reduced, as the observer is not known for their times: low.csv "
                                 "has states from ")
        self.check(rows[:1], zero_ns, [[-60, 60]], toliman.Sky(observer=self.folder / "low.csv"))
        for row in rows[1:]:
            self.assertEqual([row[name] for name in ("factor", "geometric_arcsec", "reduced_px")], ["nan"] * 3)
            self.assertGreater(float(row["separation_px"]), 20)

    def test_refit_and_period(self):
        """The lines of encode are a series: a planet of 4 uas in separations that are reduced to the refitted orbit."""
        scene = copy.deepcopy(OBSERVED)
        scene["cadence"].update(frames=60, interval_days=7.3)
        (self.folder / "s.json").write_text(json.dumps(scene))
        self.succeed("simulate", "s.json", "--out", "f.fits")
        (self.folder / "e.csv").write_text(self.succeed("encode", "--fit", "s.json", "f.fits", *LOW))
        names = ("--columns", "mjd,separation_px,separation_sigma_px", "--time-scale", "tai")
        how = (*names, "--altitude", 600, "--plate-scale", SCALE, "--exposure", 120)
        self.succeed("refit", "alpha-cen", "e.csv", *how, "--out", "refit.json")
        self.succeed("refit", "alpha-cen", "e.csv", *how, "--out", "refit.json")  # it may be replaced
        for series in ((*how, "--system", "refit.json"), ("--columns", "mjd,reduced_px,separation_sigma_px", *names[2:])):
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
        undated["cadence"].update(times_days=[30])
        for name in ("frames", "interval_days"):
            del undated["cadence"][name]
        (self.folder / "later.json").write_text(json.dumps(undated))
        for code, message, scene, arguments in (
                (2, "--epoch 2027-01-01: the scene has a date", "s", (*LOW, "--epoch", "2027-01-01")),
                (2, "--plate-scale -1: must be above 0 arcsec per px and finite", "s", (*LOW, "--plate-scale", -1)),
                (3, "long.json: cadence.exposure_s = 900: must be in (0, 600] s for an observer in orbit, or with "
                 "cadence.on_target_s", "long", LOW),
                (3, "instant.json: cadence.exposure_s = 0: must be in (0, 600] s for an observer in orbit", "instant", LOW),
                (2, "--altitude requires --system", "s", LOW[2:]),
                (3, "its exposure must be within 64 bits", "undated", (*LOW, "--epoch", 2**63 - 1)),
                (3, "a frame at 30 days: must be within 100,000 days of time 0", "later", (*LOW, "--epoch", 2**63 - 10**15)),
                (2, "--epoch : must be YYYY-MM-DD", "undated", (*LOW, "--epoch", "")),
                (2, 'system = "": must be "alpha-cen" or a system file', "s", ("--system", "", *LOW[2:])),
                (3, "missing.json: No such file", "s", ("--system", "missing.json", "--altitude", 600))):
            frames = "f.npy" if "its exposure" in message or scene == "later" else "f.fits"  # without a time in its header
            with self.subTest(message):
                self.refuse(code, message, arguments=("encode", "--fit", f"{scene}.json", frames, *arguments))
        self.refuse(2, "--system requires --fit", arguments=("encode", "--template", "s.json", "f.fits", *LOW))


if __name__ == "__main__":
    unittest.main()
