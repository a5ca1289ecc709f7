"""Tables of everything that has rows, written and read by astropy and pandas, and series of tables."""
import copy
import dataclasses
import functools
import io
import pathlib
import pickle
import sys
import tempfile
import unittest
import unittest.mock
import warnings

import numpy

from package import toliman
from shown_objects import START_NS, TAI_NS, T, Y, objects
from toliman import Measurements, _raw

try:
    from astropy import units
    from astropy.table import MaskedColumn, QTable, Table
    from astropy.time import Time
except ImportError:
    Table = None
try:
    import pandas
except ImportError:
    pandas = None

NOT_TABLES = {"simulator", "fit", "template", "frame", "estimate", "spread", "grid"}
MJD = 40587 + TAI_NS // (86400 * 10**9) + TAI_NS % (86400 * 10**9) / 86400e9


def ignored_warnings(test):
    """Ignores those of leap seconds in the future."""
    @functools.wraps(test)
    def run(self):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            test(self)
    return run


def tables():
    return {name: thing for name, thing in objects().items() if name not in NOT_TABLES}


def plain(column):
    """Values as an array: text without masks of empty fields, which ECSV has, and not as bytes, as FITS has."""
    values = numpy.asarray(column.filled("") if getattr(column, "mask", None) is not None and column.dtype.kind in "SU"
                           else column)
    return numpy.char.decode(values) if values.dtype.kind == "S" else values


def series_of(made):
    """All that a series has, as a dictionary."""
    info = made.info
    found = {name: made.values(name) for name in ("t", "y", "sigma", *(one.name for one in made.functions))}
    found["priors"] = [(one.name, one.sigma) for one in made.functions]
    found["info"] = [getattr(info, name) for name in ("kind", "n", "time_format", "time_scale", "is_weighted",
                                                      "instrument_names", "trend", "columns", "unit")]
    return found


@unittest.skipIf(Table is None, "needs astropy")
class Written(unittest.TestCase):
    def read(self, table, extension):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / f"table.{extension}"
            table.write(path)
            return Table.read(path, **({"astropy_native": True} if extension == "fits" else {}))

    def test_both_formats_keep_all_bits(self):
        for name, thing in tables().items():
            table = thing.to_table()
            for extension in ("ecsv", "fits"):
                with self.subTest(name, extension=extension):
                    again = self.read(table, extension)
                    self.assertEqual(again.colnames, table.colnames)
                    for column in table.colnames:
                        given, read = table[column], again[column]
                        if isinstance(given, Time):
                            self.assertTrue((given.jd1 == read.jd1).all() and (given.jd2 == read.jd2).all())
                            self.assertEqual(given.scale, read.scale)
                            continue
                        numpy.testing.assert_array_equal(plain(read), plain(given), column)
                        self.assertEqual(read.description, given.description, column)
                        if given.unit is not None:
                            self.assertEqual((1 * read.unit).to_value(given.unit), 1, column)

    def test_units_and_properties(self):
        """Units by the names of the members, and those of the series."""
        shown = objects()
        for name, wanted in (
                ("measurements", {"t": "d", "y": "arcsec", "sigma": "arcsec", "position_angle_deg": "deg"}),
                ("velocities", {"y": "km/s", "sigma": "km/s"}),
                ("fits", {"separation_px": "pix", "position_angle_sigma_deg": "deg", "chi_square": None}),
                ("predictions", {"separation_arcsec": "arcsec", "approach_m_s": "m/s", "barycentric_offset_s": "s"}),
                ("candidates", {"period": "d", "amplitude": "arcsec", "inclination_deg": "deg", "eccentricity": None}),
                ("samples", {"period": "d", "amplitude": "arcsec", "node_deg": "deg"}),
                ("limits", {"period": "d", "upper": "arcsec"}), ("records", {"tai_ns": "ns"}),
                ("tracked", {"frequency": "1/d", "period": "d", "power": None}), ("periodogram", {"frequency": None}),
                ("series of a scene", {"times_days": "d", "displacements_px": "pix"}),
                ("spectrum", {"wavelength_m": "m"}), ("functions", {"bound": None}),
                ("windows", {"first_days": "d"}), ("scene", {"amplitude_uas": "uarcsec", "aperture_m": "m"})):
            table = shown[name].to_table()
            for column, unit in wanted.items():
                self.assertEqual(table[column].unit, unit and units.Unit(unit), f"{name}: {column}")
            self.assertEqual(table.meta["toliman"], toliman.__version__)
            self.assertTrue(all(len(key) <= 8 for key in table.meta))
        self.assertEqual(shown["measurements"].to_table().meta["kind"], "reduced")
        self.assertEqual(shown["fits"].to_table()["separation_sigma_px"].description,
                         "standard deviations: from the inverse Fisher matrix")

    def test_values(self):
        shown = objects()
        table = shown["periodogram"].to_table()
        numpy.testing.assert_array_equal(table["power"], shown["periodogram"].power())
        numpy.testing.assert_allclose(table["period"] * table["frequency"], 1, rtol=1e-15)
        table = shown["calibration"].to_table()
        self.assertEqual({row["name"]: row["value"] for row in table},
                         {name: one.value for name, one in shown["calibration"].values().items()})
        table = shown["sky"].to_table()
        self.assertEqual(dict(zip(table["name"], zip(table["value"], table["sigma"]))), shown["sky"].elements)
        table = shown["planets"].to_table()
        numpy.testing.assert_array_equal(table["period"], [one.period for one in shown["candidates"]])

    def test_constants_are_words_and_flags_columns(self):
        array, table = objects()["records"], objects()["records"].to_table()
        self.assertEqual(list(table["verdict"]), [toliman.VERDICTS[number] for number in array["verdict"]])
        array = objects()["fits"]
        changed = array.copy()
        changed["flags"][1] |= _raw.TOLIMAN_FIT_EDGE
        self.assertEqual(list(changed.to_table()["edge"]), [False, True, False, False])
        self.assertEqual(set(changed.to_table()["goodness"]), {"good"})
        self.assertIs(type(array["flags"]), numpy.ndarray)
        self.assertEqual(pickle.loads(pickle.dumps(array)).to_table()["x_px"].unit, "pix")
        records = objects()["records"].copy()
        records["flags"][1] = 6  # of the estimator, which have no names
        self.assertEqual(list(records.to_table()["flags"])[:3], [0, 6, 0])

    def test_arrays_of_records(self):
        """Joined records know their class and units, those that differ apart; comparisons are plain arrays."""
        fits, samples, limits = (objects()[name] for name in ("fits", "samples", "limits"))
        joined = numpy.concatenate([fits, fits[:1]])
        self.assertEqual((repr(joined), joined.to_table()["x_px"].unit), ("<5 records of FitResult>", units.pix))
        numpy.testing.assert_array_equal(numpy.concatenate([fits["x_px"], fits["x_px"]]), [*fits["x_px"]] * 2)
        other = toliman.planets(T * 24, Y, 1e-6, time_unit_days=1 / 24, samples=100, threads=1).samples()
        table = numpy.concatenate([samples, other]).to_table()
        self.assertEqual((len(table), table["period"].unit, table["node_deg"].unit), (200, None, units.deg))
        self.assertEqual(numpy.concatenate([limits, limits]).to_table()["period"].unit, units.d)
        for found, expected in ((fits == fits, [True] * 4), (fits != fits, [False] * 4),
                                (fits == fits.view(numpy.ndarray), [True] * 4)):
            self.assertEqual((type(found), list(found)), (numpy.ndarray, expected))

    def test_lists_of_results(self):
        rows = objects()["candidates"]
        for made, count in ((rows.copy(), 1), (rows + rows, 2), (rows + [rows[0]], 2), (rows[:1], 1)):
            self.assertEqual((type(made), len(made)), (toliman.Rows, count))
            self.assertEqual(made.to_table()["period"].unit, units.d)
        plain_times = dataclasses.replace(rows[0])  # whose units are not known
        table = (rows + [plain_times]).to_table()
        self.assertEqual((table["period"].unit, table["node_deg"].unit), (None, units.deg))
        sky = objects()["sky"].info
        with self.assertRaisesRegex(ValueError, "^altitude_km has 1, 2 values: must have one number"):
            toliman.Rows([sky, dataclasses.replace(sky, altitude_km=(600.0,))]).to_table()

    @ignored_warnings
    def test_units_of_periodograms(self):
        """Of dates and quantities, also in copies and results."""
        days = Time(MJD, format="mjd", scale="tai")
        plain_units = None, None
        for t, y, (time, value) in ((T, Y, plain_units), (days, Y * units.uas, (units.d, units.uas)),
                                    (T * 24 * units.h, Y, (units.d, None)),
                                    (TAI_NS.view("M8[ns]"), Y * units.K, (units.d, units.K))):
            made = toliman.Periodogram(*toliman.suited_grid(t), sigma_floor=1e-6, value_bound=1)
            made.push_many(t, y)
            peaks = [toliman.period(t, y), made.fit(t, y), pickle.loads(pickle.dumps(toliman.period(t, y)))]
            for one in (made, made.copy(), pickle.loads(pickle.dumps(made)), copy.copy(made)):
                self.assertEqual(one.to_table()["period"].unit, time)
                self.assertEqual(one.to_table()["frequency"].unit, time and 1 / time)
                peaks += [one.peak(), one.peaks(), one.peaks()[0], one.model(3)]
                self.assertEqual(one.aliases(0.01).to_table()["frequency"].unit, time and 1 / time)
                self.assertEqual(one.sampling().to_table()["baseline"].unit, time)
            for peak in peaks:
                table = peak.to_table()
                self.assertEqual(table["amplitude"].unit, value)
                if "period" in table.colnames:
                    self.assertEqual((table["period"].unit, table["frequency"].unit), (time, time and 1 / time))
        by_ns = toliman.Periodogram(0.01, 0.01, 20, unit_ns=3600e9)
        by_ns.push(10**9, 5, ns=True)
        by_epoch = toliman.Periodogram(0.01, 0.01, 20, time_offset=0 * units.d)
        by_epoch.push(1, 5)
        for one, unit in ((by_ns, units.h), (by_epoch, units.d)):
            self.assertEqual(one.to_table()["period"].unit, unit)
        found, *_ = toliman.search_correlated(days, Y * units.uas, 1e-6 * units.uas)
        self.assertEqual((found.to_table()["period"].unit, found.to_table()["amplitude"].unit), (units.d, units.uas))

    def test_dates(self):
        table = objects()["velocities"].to_table()
        self.assertEqual((table["t"].scale, type(table["t"])), ("tai", Time))
        numpy.testing.assert_array_equal(table["t"].mjd, MJD)
        self.assertEqual(toliman.parse_time(Time(40587, 3 / 86400, format="mjd", scale="tai")), 3 * 10**9)
        days, parts = numpy.arange(-9000, 60000, 977), numpy.arange(71) * 65535 // 71  # of 1/65536 day
        exact = toliman.parse_time(Time(2440587.5 + days, parts / 65536, format="jd", scale="tai"))
        numpy.testing.assert_array_equal(exact, days * 86400 * 10**9 + parts * 1318359375)
        with self.assertRaises(ValueError):
            masked = Time(MJD[:3], format="mjd", scale="tai")
            masked[1] = numpy.ma.masked
            toliman.parse_time(masked)

    @ignored_warnings
    def test_dates_of_orbits(self):
        """Passages through periastron are dates if the times of the series are."""
        series = Measurements.of(None, Y, 1e-6, kind="reduced", unit=1, exposures=TAI_NS)
        found = toliman.planets(series, samples=100, threads=1)
        for thing, values in ((found, [one.epoch for one in found.candidates]),
                              (found.samples(), found.samples()["epoch"]), (found.candidates[:1], [found.candidates[0].epoch])):
            table = thing.to_table()
            numpy.testing.assert_array_equal(table["epoch"].mjd, values)
            for extension in ("ecsv", "fits"):
                again = self.read(table, extension)
                self.assertTrue((again["epoch"].jd1 == table["epoch"].jd1).all())
                self.assertTrue((again["epoch"].jd2 == table["epoch"].jd2).all())
        self.assertEqual(objects()["samples"].to_table()["epoch"].unit, "d")
        days = Time(MJD, format="mjd", scale="tai")
        for t in (days, days.tt, list(days.utc.datetime)):
            table = Measurements.of(t, Y, 1e-6).to_table()
            self.assertEqual((type(table["t"]), table["t"].scale), (Time, "tai"))
            numpy.testing.assert_allclose((table["t"] - days).sec, 0, atol=1e-5)
        self.assertEqual(type(toliman.planets(days, Y, 1e-6, samples=100, threads=1).to_table()["epoch"]), Time)

    def test_state_folders(self):
        """Separations of frames are in px, and so are the columns of the ledger; the partial derivatives are not."""
        sky = objects()["sky"]
        seen = sky.predict(TAI_NS)["separation_arcsec"] / 0.375
        with tempfile.TemporaryDirectory() as folder, toliman.Tracker(
                lambda image: toliman.Estimate(0.0, further=(float(image[0, 0]),)), 0.001, 0.001, 50, folder=folder,
                estimator_id=7, sigma=1e-3, rows=8, cols=6, image_shape=(8, 6), values=["separation_px"], sky=sky,
                plate_scale_arcsec=0.375, exposure_s=60, time_offset_ns=START_NS) as tracker:
            tracker.push_many([toliman.Frame(numpy.full((8, 6), seen[k]), k, int(TAI_NS[k]), exposure_s=60)
                               for k in range(40)])
            tracker.save()
            table, series = tracker.to_table(), (tracker.measurements(), Measurements(folder))
        self.assertEqual((len(table), table.meta["system"]), (40, "alpha Centauri AB"))
        for name, unit in (("separation_px", "pix"), ("value", "pix"), ("d_period_years", "arcsec / yr"),
                           ("d_node_deg", "arcsec / deg"), ("d_epoch", None), ("cov_value_separation_px", None)):
            self.assertEqual(table[name].unit, unit and units.Unit(unit), name)
        for one in series:
            table = one.to_table()
            self.assertEqual((table["y"].unit, table["t"].scale), ("pix", "tai"))
            again = Measurements.of_table(table)
            self.assertEqual((again.kind, again.info.unit), ("reduced", 0.375))
            self.assertEqual([(f.name, f.sigma) for f in again.functions], [(f.name, f.sigma) for f in one.functions])
            numpy.testing.assert_array_equal(again.values("position_angle_deg"), one.values("position_angle_deg"))

    def test_mixed_rows(self):
        with self.assertRaisesRegex(TypeError, "Machine, Peak"):
            toliman.Rows([toliman.machine(), objects()["peak"]]).to_table()

    def test_missing_packages(self):
        for package, call in (("astropy", "to_table"), ("pandas", "to_pandas")):
            with unittest.mock.patch.dict(sys.modules, {package: None, f"{package}.table": None}):
                with self.assertRaisesRegex(ImportError, rf"{package} is needed for {call}\(\): install it \(Debian: "
                                            rf"python3-{package}, pip: {package}\)"):
                    getattr(objects()["peak"], call)()


@unittest.skipIf(Table is None, "needs astropy")
class Read(unittest.TestCase):
    def test_values_of_any_unit(self):
        for y in (Y * units.K, Y * units.s, Y * units.uas, Y * units.km / units.s):
            for made in (Measurements.of(T, y), Measurements.of_table(Table({"t": T, "y": y}))):
                for table in (made.to_table(), Measurements.of_table(made.to_table()).to_table()):
                    self.assertEqual(table["y"].unit, y.unit)

    @ignored_warnings
    def test_the_span_of_a_trend(self):
        """It is that of the times, whose scale becomes TAI."""
        text = "".join(f"{day:.17g} {value:.17g}\n" for day, value in zip(MJD, Y)).encode()
        for scale, seconds in (("tai", 0), ("tt", 32.184), ("gps", -19), ("tdb", 32.184)):
            series = Measurements(text, time_format="mjd", time_scale=scale).set_trend(2)
            in_tt = series.to_table()
            in_tt["t"] = in_tt["t"].tt
            for table in (series.to_table(), in_tt) + ((series.to_pandas(),) if pandas else ()):
                made = Measurements.of_table(table)
                self.assertEqual((made.info.trend_start, made.info.trend_end), (made.t[0], made.t[-1]))
                self.assertLess(abs(made.t - MJD + seconds / 86400).max() * 86400, 0.002 if scale == "tdb" else 1e-5)

    def test_facts_of_other_tables(self):
        for key, value in (("UNIT", "arcsec"), ("kind", "RV"), ("TREND", "none"), ("chi2", 1.3), ("unit_d", "d"),
                           ("refitted", "no"), ("fn1", "f"), ("units", "m/s"), ("scales", 3)):
            for table in [Table({"t": T, "y": Y}, meta={key: value})] + ([pandas.DataFrame({"t": T, "y": Y})]
                                                                         if pandas else []):
                if not isinstance(table, Table):
                    table.attrs = {key: value}
                info = Measurements.of_table(table).info
                self.assertEqual((info.unit, info.trend, info.frame_chi_square, info.time_unit_days), (0, 0, 0, 1))

    def test_format_and_scale_of_columns(self):
        """A column of dates has both, and without a format, numbers are no dates."""
        for t, why, more in (
                (Time(MJD, format="mjd", scale="tt"), None, {}),
                (Time(MJD, format="mjd", scale="tt"), "^time_format = 'mjd': must not be given, as t has dates in TT",
                 {"time_format": "mjd", "time_scale": "gps"}),
                (Time(MJD, format="mjd", scale="tai"), "^time_scale = 'tdb': must not", {"time_scale": "tdb"}),
                (MJD, "^time_scale = 'tdb': must be given with time_format", {"time_scale": "tdb"}),
                (MJD, "^time_scale = 'tai': must be given with", {"time_format": "days", "time_scale": "tai"}),
                (MJD, "^time_format = 'julian': must be one of", {"time_format": "julian"}), (MJD, None, {}),
                (MJD, None, {"time_format": "days"}), (MJD, None, {"time_format": "mjd", "time_scale": "gps"})):
            with tempfile.TemporaryDirectory() as folder, self.subTest(why, **more):
                Table({"t": t, "y": Y}).write(f"{folder}/q.fits")
                if why is None:
                    self.assertEqual(len(Measurements(f"{folder}/q.fits", **more)), 40)
                    continue
                with self.assertRaisesRegex(ValueError, why):
                    Measurements(f"{folder}/q.fits", **more)

    def test_an_empty_series(self):
        for made in (Measurements.of([], []), Measurements.of(None, [], exposures=[])):
            table = made.to_table()
            self.assertEqual((len(table), table.colnames[:2], len(made.t)), (0, ["t", "y"], 0))
            self.assertEqual(len(Measurements.of_table(table)), 0)
            with self.assertRaises(toliman.NotFoundError):
                made.values("position_angle_deg")

    def test_names_of_instruments(self):
        for wrong in ("HARPS N", "", " C", "C,D", "C\t"):
            with self.assertRaisesRegex(ValueError, "^names: .*: must not be empty or have spaces or commas"):
                Measurements.of(T, Y).set_instruments(["B"] * 39 + [wrong])

    def test_a_series_comes_back(self):
        for name in ("measurements", "velocities"):
            series, wanted = objects()[name], series_of(objects()[name])
            with tempfile.TemporaryDirectory() as folder:
                paths = [f"{folder}/series.ecsv", f"{folder}/series.fits"]
                for path in paths:
                    series.to_table().write(path)
                made = [Measurements(path) for path in paths]
            made += [Measurements.of_table(series.to_table())]
            made += [Measurements.of_table(series.to_pandas())] if pandas else []
            for one in made:
                for key, value in series_of(one).items():
                    if isinstance(value, numpy.ndarray):
                        error = 1e-14 if key[0] == "T" else 0  # FITS has 16 digits of the span
                        numpy.testing.assert_allclose(value, wanted[key], rtol=error, atol=error, err_msg=key)
                    else:
                        self.assertEqual(value, wanted[key])

    def test_units_and_dates(self):
        day = Time(MJD, format="mjd", scale="tai")
        for y, sigma, unit, kind in (("mas", "uarcsec", 1e-3, "value"), ("km/s", "m/s", 1e3, "velocity"),
                                     (None, None, 0, "value"), ("pix", "pix", 0, "value")):
            table = QTable({"when": day.tt, "rv": Y, "e": numpy.full(40, 2.0)})
            table = Table(table)
            table["rv"].unit, table["e"].unit = y, sigma
            made = Measurements.of_table(table, columns="when,rv,e")
            self.assertEqual((made.kind, made.info.time_scale), (kind, _raw.TOLIMAN_INGEST_SCALE_TAI))
            self.assertAlmostEqual(made.info.unit, unit, delta=1e-12)
            factor = 1 if y is None else (2 * units.Unit(sigma)).to_value(y) / 2
            numpy.testing.assert_allclose(made.sigma, 2 * factor, rtol=1e-15)
            numpy.testing.assert_array_equal(made.y, Y)
            self.assertLess(abs(made.tai_ns - TAI_NS).max(), 1000)
        hours = Table({"t": 24 * T, "y": Y}, units={"t": "h"})
        numpy.testing.assert_allclose(Measurements.of_table(hours).t, T, rtol=1e-15)
        numbers = Table({"t": MJD, "y": Y, "sigma": Y**0})
        text = io.BytesIO()
        numbers.write(text, format="fits")
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "numbers.fits"
            path.write_bytes(text.getvalue())
            self.assertEqual(Measurements(path).info.time_scale, 0)
            dated = Measurements(path, time_format="mjd", time_scale="tai", exposure_s=60)
            with self.assertRaisesRegex(ValueError, "^functions: must not be given"):
                Measurements(path, functions="columns.csv")
        self.assertLess(abs(dated.tai_ns - TAI_NS).max(), 1000)
        self.assertTrue(dated.info.has_exposures)

    @unittest.skipIf(pandas is None, "needs pandas")
    def test_pandas(self):
        dates = numpy.datetime64("2030-01-01T00:00:00", "ns") + numpy.arange(5) * numpy.timedelta64(86400, "s")
        frame = pandas.DataFrame({"t": dates, "y": Y[:5], "sigma": 1.0, "by": list("aabba")})
        made = Measurements.of_table(frame, instrument="by")
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            numpy.testing.assert_array_equal(made.tai_ns, toliman.parse_time(dates))
        self.assertEqual(made.info.instrument_names.strip(","), "a,b")
        frame.loc[2, "y"] = numpy.nan
        with self.assertRaisesRegex(ValueError, "^y has 1 missing or masked values"):
            Measurements.of_table(frame)
        numbers = pandas.DataFrame({"t": pandas.array([1, 2, 3], "Int64"), "y": pandas.array([1.5, 2, 4], "Float64")})
        numpy.testing.assert_array_equal(Measurements.of_table(numbers).y, [1.5, 2, 4])
        for name in ("t", "y"):
            missing = numbers.copy()
            missing.loc[1, name] = pandas.NA
            with self.assertRaisesRegex(ValueError, f"^{name} has 1 missing or masked values"):
                Measurements.of_table(missing)

    def test_refused(self):
        good = {"t": T, "y": Y, "sigma": numpy.ones(40)}
        masked = MaskedColumn(Y, mask=T == T[3])
        for kind, why, table, more in (
                (TypeError, "^table is a dict", good, {}),
                (ValueError, "^y is not a column: the table has t, sigma", {"t": T, "sigma": T}, {}),
                (ValueError, "^y has 1 missing or masked", {**good, "y": masked}, {}),
                (ValueError, "^t has 40 missing", {**good, "t": T * numpy.nan}, {}),
                (TypeError, "^t is in m: must be in a unit of d", {**good, "t": T * units.m}, {}),
                (TypeError, "^sigma is in m: must be in a unit of mas",
                 {**good, "y": Y * units.mas, "sigma": T * units.m}, {}),
                (TypeError, "^y has no unit", {**good, "sigma": T * units.mas}, {}),
                (TypeError, "^sigma has no unit: must have one, as y is in mas", {**good, "y": Y * units.mas}, {}),
                (TypeError, "^y is in km / s: must be an angle", {"t": T, "y": Y * units.km / units.s},
                 {"kind": "reduced"}),
                (ValueError, "^unit = 1.0: must not be given", {"t": T, "y": Y * units.mas}, {"unit": 1.0}),
                (TypeError, "^t is an array of", {**good, "t": numpy.full(40, "2030-01-01")}, {}),
                (ValueError, "^exposure_s = 60: must not be given", good, {"exposure_s": 60}),
                (ValueError, "^columns = 't'", good, {"columns": "t"})):
            with self.assertRaisesRegex(kind, why):
                Measurements.of_table(table if why == "^table is a dict" else Table(table), **more)

    def test_units_of_arrays(self):
        """Quantities in arrays have the unit of the values, not that of plain numbers."""
        milli = Measurements.of(T, Y * 1e3 * units.mas, 1e-3 * units.mas, kind="reduced")
        self.assertAlmostEqual(milli.info.unit, 1e-3, delta=1e-15)
        with self.assertRaisesRegex(TypeError, "^y is in m: must be an angle"):
            Measurements.of(T, Y * units.m, kind="reduced")
        sky = toliman.Sky("alpha-cen", altitude_km=600)
        seen = sky.predict(TAI_NS)["separation_arcsec"] + Y
        exposures = numpy.stack([TAI_NS, TAI_NS + 1000], 1)
        arcsec = sky.reduce(exposures, seen, 1e-6)
        mas = sky.reduce(exposures, seen * units.arcsec.to("mas") * units.mas, 1e-3 * units.mas)
        numpy.testing.assert_allclose(arcsec.y, mas.y, rtol=0, atol=1e-14)
        numpy.testing.assert_allclose(mas.sigma, arcsec.sigma, rtol=1e-12)


@unittest.skipIf(pandas is None, "needs pandas")
class Frames(unittest.TestCase):
    def test_columns_and_attributes(self):
        for name, thing in tables().items():
            frame = thing.to_pandas()
            self.assertEqual(len(frame.attrs["units"]), sum(bool(one.unit) for one in thing._columns().values()), name)
            self.assertEqual(frame.attrs["toliman"], toliman.__version__)
        frame, series = objects()["velocities"].to_pandas(), objects()["velocities"]
        numpy.testing.assert_array_equal(frame["t"], series.t)
        self.assertEqual((frame.attrs["scales"], frame.attrs["units"]["y"]), ({"t": "tai"}, "km / s"))
        seen = objects()["predictions"]
        numpy.testing.assert_array_equal(seen.to_pandas()["partials_6"], seen["partials"][:, 6])
        self.assertEqual(START_NS, series.tai_ns[0])


if __name__ == "__main__":
    unittest.main()
