"""Dates, quantities, clock tables and times in text, in the Python package, against astropy (ERFA)."""
import datetime
import pathlib
import pickle
import subprocess
import sys
import tempfile
import unittest
import warnings

import numpy
from astropy import units
from astropy.io.fits import Header
from astropy.table import QTable
from astropy.time import Time, TimeDelta

from package import toliman
from refusal import refused
from toliman import Periodogram, suited_grid
from toliman.times import plain_times

PACKAGE = pathlib.Path(toliman.__file__).parents[1]

warnings.filterwarnings("ignore", message=".*dubious year")
GRID = {"f0": 0.01, "df": 0.001, "nf": 200}
DATES = numpy.datetime64("2016-11-20T00:00:00") + numpy.arange(80) * numpy.timedelta64(30 * 3600 + 7, "s")
DAYS = numpy.arange(80) * (30 * 3600 + 7) / 86400  # but for the leap second
Y = 5 + 2 * numpy.sin(2 * numpy.pi * DAYS / 7.3) + 0.1 * numpy.random.default_rng(1).standard_normal(80)
SIGMA = numpy.full(80, 0.1)
ULP = 2**-37  # days, of an MJD


def power(t, y, sigma=None):
    with Periodogram(**GRID) as periodogram:
        periodogram.push_many(t, y, sigma)
        return periodogram.power()


class Headers(unittest.TestCase):
    def test_header_against_astropy(self):
        header = Header([("DATE-OBS", "2028-03-01T12:00:00.25"), ("EXPTIME", 2.5), ("MJD-AVG", None)])
        time = toliman.read_header(header)
        middle = Time("2028-03-01T12:00:01.5", scale="utc").tai - Time("1970-01-01", scale="tai")
        self.assertEqual(time.tai_ns, round(2 * middle.sec) * 5 * 10**8)
        self.assertEqual((time.rule, time.assumed), ("DATE-OBS + EXPTIME/2 in UTC, as TIMESYS is missing", True))
        exact = toliman.read_header({"MJD-AVG": 60000.25, "TIMESYS": "TAI"})
        self.assertEqual((exact.tai_ns, exact.assumed, exact.expired), ((60000 - 40587) * 86400 * 10**9 + 21600 * 10**9,
                                                                       False, False))
        begun = toliman.read_header({"DATE-OBS": "2028-03-01", "TIME-OBS": "12:00:00", "EXPOSURE": 3600, "TIMESYS": "UTC(NIST)"})
        self.assertEqual((begun.tai_ns, begun.exposure_s), ((1835524837 + 1800) * 10**9, 3600))
        with refused(toliman.InputError, "DATE-BEG"):
            toliman.read_header({"DATE-BEG": "2028-03-01T12:00:00", "DATE-END": "2028-03-01T11:00:00"})
        with self.assertRaises(toliman.NotFoundError):
            toliman.read_header({"TIMESYS": "TAI"})
        with self.assertRaises(toliman.Error) as raised:
            toliman.read_header({"MJD-AVG": "x"})
        self.assertEqual(raised.exception.field, "MJD-AVG")


class Dates(unittest.TestCase):
    def test_datetime64_against_astropy(self):
        random = numpy.random.default_rng(2)
        ns = random.integers(63072000, 4102444800, 1000) * 10**9 + random.integers(0, 10**9, 1000)
        for unit in ("ns", "us", "ms", "s", "m", "h", "D", "M", "Y"):
            dates = ns.astype("M8[ns]").astype(f"M8[{unit}]")
            found = plain_times("t", dates)
            numpy.testing.assert_allclose(found, Time(dates.astype("M8[ns]"), scale="utc").tai.mjd, rtol=0, atol=ULP)
            self.assertEqual(plain_times("t", dates[3]), found[3])
            numpy.testing.assert_array_equal(plain_times("t", list(dates[:5])), found[:5])
        numpy.testing.assert_array_equal(plain_times("t", dates[::-2]), found[::-2])
        numpy.testing.assert_array_equal(plain_times("t", dates.astype(">M8[s]")), found)

    def test_datetime(self):
        """Without time zone as UTC, with one converted; in lists, tuples and arrays, as numbers and as TAI."""
        naive = [datetime.datetime(2028, 3, 1, 12, 0, k, 250000) for k in range(3)]
        expected = [1835524837250000000 + k * 10**9 for k in range(3)]
        zone = datetime.timezone(datetime.timedelta(hours=5, minutes=30))
        aware = [date.replace(tzinfo=datetime.timezone.utc).astimezone(zone) for date in naive]
        for dates in (naive, aware, tuple(naive), numpy.array(naive), numpy.array(aware), numpy.array(naive, "M8[us]"),
                      [str(date) for date in naive], [date.isoformat() + "+00:00" for date in naive]):
            found = toliman.parse_time(dates)
            self.assertEqual((found.tolist(), found.dtype), (expected, "int64"))
            if not isinstance(dates[0], str):
                numpy.testing.assert_allclose(plain_times("t", dates), 40587 + numpy.array(expected) / 86400e9, rtol=0, atol=ULP)
        for date in (naive[1], aware[1], numpy.datetime64(naive[1])):
            self.assertEqual(toliman.parse_time(date), expected[1])
            self.assertIs(type(toliman.parse_time(date)), int)
        self.assertEqual(toliman.parse_time(datetime.date(2028, 3, 1)), toliman.parse_time("2028-03-01"))
        self.assertEqual(toliman.parse_time(numpy.array(naive).reshape(3, 1)).shape, (3, 1))
        self.assertEqual(toliman.period(DATES.tolist(), Y, SIGMA), toliman.period(DATES, Y, SIGMA))
        for bad, error, why in (([naive[0], None], TypeError, "a"), (5, TypeError, "time"),
                                ([5], TypeError, "time"), ([datetime.datetime(1971, 1, 1)], ValueError, "time")):
            with refused(error, why):
                toliman.parse_time(bad)
        with refused(ValueError, "format='iso',"):
            toliman.parse_time(naive, scale="tai")

    def test_leap_second(self):
        second = 1 / 86400
        for text, seconds in (("2016-12-31T23:59:59", -2), ("2016-12-31T23:59:60", -1), ("2017-01-01T00:00:00", 0)):
            expected = 57754 + 37 * second + seconds * second
            self.assertAlmostEqual(plain_times("t", Time(text, scale="utc")), expected, delta=ULP)
            self.assertEqual(toliman.parse_time(text), (57754 - 40587) * 86400 * 10**9 + (37 + seconds) * 10**9)
            if ":60" not in text:
                self.assertAlmostEqual(plain_times("t", numpy.datetime64(text)), expected, delta=ULP)

    def test_scales_of_time(self):
        for scale in ("utc", "tai", "tt", "tdb", "tcb"):
            times = Time(57700.25 + DAYS, format="mjd", scale=scale)
            numpy.testing.assert_array_equal(plain_times("t", times), times.tai.mjd)
        for text, scale in (("60000.123456789", "tt"), ("60000.5", "utc")):
            mjd = Time(text, format="mjd", scale=scale).tai.mjd
            self.assertAlmostEqual(40587 + toliman.parse_time(text, "mjd", scale) / 86400e9, mjd, delta=2 * ULP)

    def test_same_result_in_every_form(self):
        times = Time(DATES, scale="utc")
        expected = power(times.tai.mjd, Y)
        numpy.testing.assert_allclose(power(DATES, Y), expected, rtol=0, atol=1e-7)
        for same in (times, Time(times.tt), list(times.tai.mjd)):
            numpy.testing.assert_allclose(power(same, Y), expected, rtol=0, atol=1e-7)
        self.assertEqual(suited_grid(times), suited_grid(times.tai.mjd))
        self.assertEqual(suited_grid(times, 300 * units.day), suited_grid(times.tai.mjd, 300))
        self.assertAlmostEqual(toliman.period(DATES, Y, SIGMA).period, 7.3, delta=0.01)
        self.assertEqual(toliman.period(times, Y, SIGMA), toliman.period(times.tai.mjd, Y, SIGMA))
        numpy.testing.assert_array_equal(toliman.batch(**GRID, t=times, y=Y), toliman.batch(**GRID, t=times.tai.mjd, y=Y))

    def test_one_by_one(self):
        times = Time(DATES, scale="utc")
        with Periodogram(**GRID, time_offset=times[0]) as periodogram, \
                Periodogram(**GRID, time_offset=times[0].tai.mjd) as plain:
            plain.push_many(times.tai.mjd, Y)
            for k, (t, y) in enumerate(zip(times, Y)):
                periodogram.push(t if k % 2 else t.tai.mjd, y)
            self.assertEqual(periodogram.to_bytes(), plain.to_bytes())
            self.assertIs(type(periodogram.epoch), Time)
            self.assertEqual((periodogram.epoch, plain.epoch), (times[0], times[0].tai.mjd))
            self.assertEqual(Periodogram.from_bytes(plain.to_bytes()).epoch, times[0].tai.mjd)
            self.assertEqual(repr(periodogram.fit(times, Y)), repr(plain.fit(times.tai.mjd, Y)))  # no chi-square: nan
            self.assertEqual(periodogram.sampling(times), plain.sampling(times.tai.mjd))
            for t, y in zip(times[:9], Y[:9]):
                periodogram.retract(t, y)
            plain.retract_many(times[:9], Y[:9])
            self.assertEqual(periodogram.to_bytes(), plain.to_bytes())
        with Periodogram(**GRID, time_offset=DATES[0]) as periodogram:
            self.assertEqual((periodogram.epoch, periodogram.copy().epoch), (DATES[0], DATES[0]))
            self.assertEqual(periodogram.info.time_offset, times[0].tai.mjd)

    def test_refused(self):
        masked = Time(DATES, scale="utc")
        masked[3] = numpy.ma.masked
        dates = DATES.copy()
        dates[7] = numpy.datetime64("NaT")
        with Periodogram(**GRID) as periodogram:
            for bad in (dates, dates[7], DATES - numpy.timedelta64(50 * 365, "D"), numpy.datetime64("2100-01-01"),
                        numpy.array(["1970-01-01"] * 80, "M8[D]"), numpy.datetime64(2**62, "Y"), masked,
                        numpy.ma.masked_greater(DATES, DATES[70])):
                with refused(ValueError, "t"):
                    (periodogram.push_many if numpy.ndim(bad) else periodogram.push)(bad, Y if numpy.ndim(bad) else 1)
            with refused(TypeError, "t"):
                periodogram.push_many(TimeDelta(DAYS, format="jd"), Y)
            with refused(units.UnitConversionError, "t"):
                periodogram.push_many(DAYS * units.m, Y)
            self.assertEqual(len(periodogram), 0)
        for text, why in (("2028-02-30", "text"), ("1950-01-01", "text"), ("\0", "time")):
            with refused(ValueError, why):
                toliman.parse_time(text)
        with refused(ValueError, "scale"):
            toliman.parse_time("2028-01-01", scale="ut1")
        with refused(ValueError, "format"):
            toliman.parse_time("2028-01-01", "days")


class Quantities(unittest.TestCase):
    def test_complete_series(self):
        t, y, sigma = DAYS * 24 * units.hour, Y * units.km / units.s, SIGMA * 1000 * units.m / units.s
        expected, found = toliman.period(DAYS, Y, SIGMA), toliman.period(t, y, sigma)
        for name in ("period", "period_error", "amplitude", "amplitude_error", "offset"):
            self.assertAlmostEqual(getattr(found, name) / getattr(expected, name), 1, delta=1e-9)
        numpy.testing.assert_allclose(toliman.batch(**GRID, t=t, y=y, sigma=sigma), toliman.batch(**GRID, t=DAYS, y=Y, sigma=SIGMA),
                                      rtol=0, atol=1e-7)
        table = QTable({"t": t, "y": y, "dy": sigma})
        self.assertEqual(toliman.period(table["t"], table["y"], table["dy"]), found)
        self.assertEqual(toliman.period(t, y, 100 * units.m / units.s), found)
        with refused(TypeError, "sigma"):
            toliman.period(t, y, SIGMA)
        with refused(TypeError, "sigma"):
            toliman.period(t, Y, sigma)
        with self.assertRaises(units.UnitConversionError):
            toliman.period(t, y, SIGMA * units.m)

    def test_first_sample_determines_the_unit(self):
        with Periodogram(**GRID) as periodogram, Periodogram(**GRID) as plain:
            self.assertIsNone(periodogram.value_unit)
            with self.assertRaises(ValueError):
                periodogram.push(numpy.nan, 1 * units.m)
            self.assertIsNone(periodogram.value_unit)
            periodogram.push(0 * units.day, 2 * units.pix, 1 * units.pix)
            periodogram.push_many([24, 48] * units.hour, [3000, 4000] * units.mpix, [2000, 1000] * units.mpix)
            plain.push_many([0, 1, 2], [2, 3, 4], [1, 2, 1])
            self.assertEqual(periodogram.value_unit, units.pix)
            self.assertEqual(periodogram.to_bytes(), plain.to_bytes())
            with refused(TypeError, "y"):
                periodogram.push(3, 4.0)
            with refused(TypeError, "y"):
                plain.push(3, 4 * units.pix)
            self.assertEqual(periodogram.copy().value_unit, units.pix)
            periodogram.retract(1, 3 * units.pix, 2 * units.pix)
            self.assertEqual(pickle.loads(pickle.dumps(periodogram)).value_unit, units.pix)
            loaded = toliman.Periodogram.from_bytes(periodogram.to_bytes())
            with refused(TypeError, "y"):
                loaded.push(3, 4 * units.pix)
            loaded.value_unit = units.mpix
            loaded.push(3, 4 * units.mpix)
            self.assertEqual(len(loaded), 3)


class Files(unittest.TestCase):
    def test_clock(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "clock.csv"
            path.write_text("camera_ns,tai_ns\n# one\n-5,9007199254740993\n1000,9007199254741998\n")
            clock = toliman.read_clock(path)
            self.assertEqual((clock.dtype, clock.tolist()), (numpy.int64, [[-5, 2**53 + 1], [1000, 2**53 + 1006]]))
            path.write_text("0,0\n10,20\n")
            with self.assertLogs("toliman", "WARNING") as logged:
                toliman.read_clock(path)
            self.assertEqual(len(logged.records), 1)
            self.assertIn("clock.csv:2: TAI advances by 2 ns", logged.output[0])
            path.write_text("0,0\n10,x\n")
            with self.assertRaisesRegex(toliman.InputError, r"clock.csv:2: must be camera_ns,tai_ns"):
                toliman.read_clock(path)
            with self.assertRaises(toliman.NotFoundError):
                toliman.read_clock(path.with_name("none"))

    def test_on_target(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "windows.csv"
            path.write_text("start_utc,end_utc # day\n2028-03-01T12:00:00,2028-03-01T12:00:01.5Z\n"
                            "2028-061T12:10:00,2028-061T12:20:00\n")
            windows = toliman.read_on_target(path)
            times = Time(["2028-03-01T12:00:00", "2028-03-01T12:00:01.5", "2028-03-01T12:10:00", "2028-03-01T12:20:00"],
                         scale="utc").tai - Time("1970-01-01", scale="tai")
            self.assertEqual(windows.dtype, numpy.int64)
            self.assertEqual(windows.ravel().tolist(), [round(2 * seconds) * 5 * 10**8 for seconds in times.sec])
            path.write_text("start_utc,end_utc\n2028-03-01T12:00:00,2028-03-01T11:00:00\n")
            with self.assertRaisesRegex(toliman.InputError, r"windows.csv:2: end_utc = .*: must be after start_utc"):
                toliman.read_on_target(path)
            with self.assertRaises(toliman.NotFoundError):
                toliman.read_on_target(path.with_name("none"))

    def test_astropy_is_not_imported(self):
        code = (f"import sys; sys.path.insert(0, {str(PACKAGE)!r}); import numpy, toliman; "
                "t = numpy.datetime64('2028-01-01') + numpy.arange(50); toliman.period(t, numpy.sin(numpy.arange(50.0))); "
                "sys.exit('astropy' in sys.modules)")
        self.assertEqual(subprocess.run([sys.executable, "-c", code]).returncode, 0)


if __name__ == "__main__":
    unittest.main()
