"""Simulated frames of a scene with an observer: their times are TAI, in pairs and in FITS files, and track reads them."""
import json
import unittest

import numpy
from astropy.io import fits
from astropy.time import Time
from program import ProgramTest
from test_track_stamps import DAY, GRID

TIMES = [0, 0.25, 27.4, 300.125]
ZERO = 20819 * DAY + DAY // 4 - 32184000000  # TAI of 2027.0, JD 2461406.75 of TT; 1970-01-01 is JD 2440587.5
SCENE = {
    "schema": "toliman-scene/1",
    "telescope": {"aperture_m": 0.0625, "pupil_samples": 48,
                  "mask": {"kind": "spiral", "opd_nm": 292.5, "edges": "area", "terms": [{"a": 1, "f": 1.2, "m": -5, "p": 1}]}},
    "band": {"wavelength_nm": 580},
    "stars": {"A": {"spectrum": {"kind": "blackbody", "temperature_k": 5790}, "photons_per_s": 7.5e7},
              "B": {"spectrum": {"kind": "blackbody", "temperature_k": 5260}, "photons_per_s": 2.5e7}},
    "binary": {"orbit": "alpha-cen", "date": 2027.0, "moving": True, "observer": {"altitude_km": 600}},
    "cadence": {"times_days": TIMES, "exposure_s": 60, "on_target_s": [0, 10, 20, 60]},
    "detector": {"shape": [48, 48], "pixel_scale_arcsec": 0.75},
    "noise": {"photon": True},
}


def date_of(tai_ns):
    """Date of UTC, 37 s behind TAI."""
    return str(numpy.datetime64(tai_ns - 37 * 10**9, "ns"))


def middle(day):
    return ZERO + round(day * DAY)


class ObserverFrames(ProgramTest):
    def setUp(self):
        super().setUp()
        (self.folder / "scene.json").write_text(json.dumps(SCENE))

    def simulate(self):
        self.succeed("simulate", "scene.json", "--out", "in", "--session", "day", "--dtype", "u32le")
        self.succeed("simulate", "scene.json", "--out", "day.fits")
        return [json.loads(line) for line in (self.folder / "in/day_meta.jsonl").read_text().splitlines()]

    def track(self, state, name, *more):
        done = self.run_program("track", "--fit", "scene.json", "--state", state, "--dtype", "u32le", *GRID, *map(str, more), name)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.errors = done.stderr
        return [line for line in map(json.loads, done.stdout.splitlines()) if line["schema"] == "toliman-frame/2"]

    def test_times_are_tai(self):
        lines = self.simulate()
        self.assertEqual([line["timestamp_ns"] for line in lines], [middle(day) - 30 * 10**9 for day in TIMES])
        for line in lines:
            self.assertAlmostEqual(line["host_time"], line["timestamp_ns"] / 1e9, delta=1e-6)
            self.assertEqual(line["on_target_s"], [0, 10, 20, 60])
        header = fits.getheader(self.folder / "day.fits")
        self.assertEqual(header["TIMESYS"], "TAI")
        seconds = (Time(header["DATE-AVG"], scale="tai") - Time("1970-01-01", scale="tai")).sec
        self.assertAlmostEqual(seconds, ZERO / 1e9, delta=1e-6)
        self.succeed("simulate", "scene.json", "--out", "last.fits", "--frames", "3:4")
        last = fits.getheader(self.folder / "last.fits")["DATE-AVG"]
        self.assertEqual(round((Time(last, scale="tai") - Time(header["DATE-AVG"], scale="tai")).sec * 1e3), round(TIMES[3] * 86400e3))

    def test_track_reads_them(self):
        """Pairs and FITS files have the same times and values, with the scene's own time 0 or with the same --epoch."""
        self.simulate()
        pairs, cube = self.track("a", "in"), self.track("b", "day.fits")
        for number, lines in enumerate((pairs, cube, self.track("c", "in", "--epoch", ZERO))):
            self.assertEqual([(line["verdict"], line["tai_ns"]) for line in lines], [("accepted", middle(day)) for day in TIMES])
            self.assertEqual([line["value"] for line in lines], [line["value"] for line in pairs], number)
            self.assertLess(max(abs(line["value"]) for line in lines), 1e-3)  # px, of stars that move by 1 px
        date = date_of(ZERO)
        self.assertEqual([line["value"] for line in self.track("d", "in", "--epoch", date)], [line["value"] for line in pairs])
        for epoch in ("1e18", "2027-13-01"):
            self.refuse(2, f"--epoch {epoch}: ", arguments=("track", "--fit", "scene.json", "--state", "no", "--dtype", "u32le",
                                                            *GRID, "--epoch", epoch, "in"))
        status = json.loads(self.succeed("status", "a", "--json"))
        self.assertEqual(status["grid"]["time_offset_ns"], ZERO)

    def test_calibrate_reads_them(self):
        """Pairs and FITS files have times from time 0 of the scene on: both give the same optics."""
        self.simulate()
        found = []
        for name in ("in", "day.fits"):
            self.succeed("calibrate", "scene.json", name, *(("--dtype", "u32le") if name == "in" else ()), "--free", "focus zernike_5=20",
                         "--out", f"{name}.json")
            aberrations = json.loads((self.folder / f"{name}.json").read_text())["telescope"]["aberrations"]["zernike_rms_nm"]
            found.append([aberrations[noll] for noll in ("4", "5")])
        numpy.testing.assert_allclose(*found, rtol=1e-6)
        self.assertLess(max(map(abs, found[0])), 3)  # nm, of none

    def test_exposures(self):
        """A FITS header has the exposure, unless its frames have on-target intervals, for which it has no place."""
        self.simulate()
        self.assertNotIn("XPOSURE", fits.getheader(self.folder / "day.fits"))
        scene = json.loads(json.dumps(SCENE))
        del scene["cadence"]["on_target_s"]
        scene["noise"]["photon"] = False
        (self.folder / "scene.json").write_text(json.dumps(scene))
        self.succeed("simulate", "scene.json", "--out", "whole.fits", "--force")
        self.assertEqual(fits.getheader(self.folder / "whole.fits")["XPOSURE"], 60)
        low = ("--system", "alpha-cen", "--altitude", "600", "--exposure", "0")  # none but that of the header
        lines = self.track("whole", "whole.fits", *low)
        self.assertEqual({line["verdict"] for line in lines}, {"accepted"})
        self.assertLess(max(abs(line["value"]) for line in lines) * 0.75e6, 100)  # uas, errors of the fit
        self.assertEqual({line["reason"] for line in self.track("parts", "day.fits", *low)}, {"no intervals"})
        fits.setval(self.folder / "whole.fits", "XPOSURE", value=2e9)
        done = self.run_program("track", "--fit", "scene.json", "--state", "bad", *GRID, "whole.fits")
        self.assertIn("XPOSURE = 2000000000.0: ", done.stderr)

    def test_windows_of_the_scene(self):
        """Simulated lines have their parts in each exposure. Lines of the mission have none: track and encode take the scene's."""
        scene = json.loads(json.dumps(SCENE))
        del scene["cadence"]["on_target_s"]
        scene["cadence"]["on_target"] = "windows.csv"
        (self.folder / "scene.json").write_text(json.dumps(scene))
        parts = [[0, 32], [5, 20, 30, 60], [0, 60], [7, 38]]
        windows = [(middle(day) + round((start - 30) * 1e9), middle(day) + round((end - 30) * 1e9))
                   for day, part in zip(TIMES, parts) for start, end in zip(part[::2], part[1::2])]
        (self.folder / "windows.csv").write_text("start_tai_ns,end_tai_ns\n" + "".join(f"{a},{b}\n" for a, b in windows))
        lines = self.simulate()
        self.assertEqual([line["on_target_s"] for line in lines], parts)
        for line in lines:
            del line["on_target_s"]
        own = self.track("own", "in")
        (self.folder / "in/day_meta.jsonl").write_text("".join(json.dumps(line) + "\n" for line in lines))
        self.assertEqual([line["value"] for line in self.track("windows", "in")], [line["value"] for line in own])
        reduced = self.succeed("encode", "--fit", "scene.json", "day.fits").splitlines()
        column = reduced[0].split(",").index("reduced_px")
        for row, line in zip(reduced[1:], own):
            self.assertAlmostEqual(float(row.split(",")[column]), line["value"], delta=1e-9)

    def test_frames_without_time_on_target(self):
        """They have no light, and end no command: encode does not reduce them, calibrate leaves them out."""
        scene = json.loads(json.dumps(SCENE))
        del scene["cadence"]["on_target_s"]
        scene["cadence"]["on_target"] = "windows.csv"
        (self.folder / "scene.json").write_text(json.dumps(scene))
        windows = [middle(day) - 30 * 10**9 for day in TIMES[:3]]
        (self.folder / "windows.csv").write_text(
            "start_tai_ns,end_tai_ns\n" + "".join(f"{start},{start + 60 * 10**9}\n" for start in windows))
        done = self.run_program("simulate", "scene.json", "--out", "in", "--session", "day")
        self.assertEqual(done.returncode, 2)
        self.assertIn("cadence.on_target", done.stderr)
        self.succeed("simulate", "scene.json", "--out", "day.fits")
        done = self.run_program("encode", "--fit", "scene.json", "day.fits")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("altitude 600 km, node at 18 h, is known at all times", done.stderr)
        rows = done.stdout.splitlines()
        column = rows[0].split(",").index("reduced_px")
        self.assertEqual([row.split(",")[column] == "nan" for row in rows[1:]], [False, False, False, True])
        done = self.run_program("calibrate", "scene.json", "day.fits", "--free", "focus", "--out", "fitted.json")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("day.fits: frame 3: ", done.stderr)

    def test_faint_frames_of_unknown_optics(self):
        """An exposure of few arcs has half of the light, of which 60 nm of astigmatism take a part: its stars are found."""
        truth = json.loads(json.dumps(SCENE))
        truth["telescope"]["aberrations"] = {"zernike_rms_nm": {"5": 60}}
        del truth["cadence"]["on_target_s"]
        truth["cadence"]["on_target"] = "windows.csv"
        for name in ("truth", "scene"):
            (self.folder / f"{name}.json").write_text(json.dumps(truth))
            del truth["telescope"]["aberrations"]
            truth["telescope"]["aberrations"] = {}
        lengths = [60, 60, 60, 31]
        (self.folder / "windows.csv").write_text("start_tai_ns,end_tai_ns\n" + "".join(
            f"{middle(day) - 30 * 10**9},{middle(day) + (length - 30) * 10**9}\n" for day, length in zip(TIMES, lengths)))
        self.succeed("simulate", "truth.json", "--out", "day.fits")
        self.succeed("calibrate", "scene.json", "day.fits", "--free", "zernike_5", "--out", "fitted.json")
        result = json.loads((self.folder / "fitted.calibration.json").read_text())
        self.assertEqual(len(result["separations"]), 4)
        self.assertAlmostEqual(abs(result["windows"][0]["parameters"][0]["value"]), 60, delta=1)

    def test_times_by_cadence_begin_at_time_0(self):
        """That of the scene, or of --epoch, which is reported."""
        self.simulate()
        self.succeed("simulate", "scene.json", "--out", "day.npy", "--frames", "0:2")
        later = self.track("e", "day.npy", "--cadence", DAY // 4 // 10**9, "--epoch", ZERO + 5)
        self.assertEqual([line["tai_ns"] for line in later], [ZERO + 5, ZERO + 5 + DAY // 4])
        self.assertIn(f"toliman: --epoch {ZERO + 5}: ", self.errors)
        lines = self.track("n", "day.npy", "--cadence", DAY // 4 // 10**9)
        self.assertNotIn("--epoch", self.errors)
        self.assertEqual([line["tai_ns"] for line in lines], [ZERO, ZERO + DAY // 4])
        self.assertEqual([line["value"] for line in lines], [line["value"] for line in self.track("a", "in")][:2])

    def test_time_0_of_moving_stars_is_their_date(self):
        """Also without an observer; stars at rest have no date."""
        scene = json.loads(json.dumps(SCENE))
        del scene["binary"]["observer"]
        (self.folder / "scene.json").write_text(json.dumps(scene))
        lines = self.simulate()
        self.assertEqual([line["timestamp_ns"] for line in lines], [middle(day) - 30 * 10**9 for day in TIMES])
        self.assertIn("DATE-AVG", fits.getheader(self.folder / "day.fits"))
        self.assertEqual([line["tai_ns"] for line in self.track("a", "day.fits")], [middle(day) for day in TIMES])
        del scene["binary"]["moving"]
        (self.folder / "rest.json").write_text(json.dumps(scene))
        self.succeed("simulate", "rest.json", "--out", "rest.fits")
        header = fits.getheader(self.folder / "rest.fits")
        self.assertNotIn("DATE-AVG", header)
        self.assertNotIn("TIMESYS", header)


if __name__ == "__main__":
    unittest.main()
