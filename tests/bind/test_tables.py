"""Tables that astropy writes, read by toliman.Measurements: the same numbers, units and missing values."""
import io
import itertools
import random
import unittest
import warnings

import numpy

from package import toliman

try:
    from astropy import units
    from astropy.io import ascii as writers
    from astropy.table import MaskedColumn, Table
except ImportError:
    Table = None

FORMATS = ("ecsv", "ecsv,", "ipac", "mrt", "rdb", "csv", "tab", "basic", "commented_header", "fixed_width",
           "fixed_width_two_line")
WITH_UNITS = ("ecsv", "ecsv,", "ipac", "mrt")
NAMES = (("bjd_tdb", "rv", "e_rv"), ("t", "y", "sigma"), ("RJD", "VRAD", "SVRAD"), ("HJD", "RadVel", "err_RadVel"),
         ("time", "separation", "separation_err"), ("Days", "Flux", "Uncertainty"))
UNITS = (("km / s", "m / s"), ("m / s", "m / s"), ("mas", "uarcsec"), ("deg", "arcsec"), (None, None))


def table_of(chance, names, stated, masked):
    """A table with a column more, in any order."""
    count = 12
    t = numpy.sort(numpy.array([chance.uniform(59000, 60000) for _ in range(count)]).round(4))
    columns = {names[0]: t + (2400000 if "jd_" in names[0].lower() or names[0] == "HJD" else 0),
               names[1]: numpy.array([chance.gauss(0, 20) for _ in t]).round(3),
               names[2]: numpy.array([chance.uniform(0.5, 4) for _ in t]).round(3)}
    table = Table()
    for name in chance.sample([*columns, "Night"], 4):
        if name == "Night":
            table[name] = [f"n{k}" for k in range(count)]
            continue
        mask = [masked and name != names[0] and chance.random() < 0.15 for _ in t]
        table[name] = MaskedColumn(columns[name], mask=mask) if any(mask) else columns[name]
    for name, unit in zip(names[1:], stated):
        if unit is not None:
            table[name].unit = units.Unit(unit)
    return table


def text_of(table, form):
    out = io.StringIO()
    if form.startswith("ecsv"):
        table.write(out, format="ascii.ecsv", delimiter="," if form.endswith(",") else " ")
    else:
        with_fill = {} if form in ("ipac", "mrt") else {"fill_values": [(writers.masked, "nan")]}
        writers.write(table, out, format=form, **with_fill)
    return out.getvalue()


def known(table, name):
    return ~numpy.ma.getmaskarray(numpy.ma.asarray(table[name]))


class Units(unittest.TestCase):
    def test_a_unit_is_a_number(self):
        series = toliman.Measurements.of([1.0, 2.0], [3.0, 4.0], 0.1, kind="reduced", unit=0.375).add_column("c", [1.0, 2.0])
        self.assertEqual((series.info.unit, series.functions[0].unit), (0.375, 1.0))


@unittest.skipIf(Table is None, "needs astropy")
class Tables(unittest.TestCase):
    def check(self, table, names, stated, form):
        text = text_of(table, form)
        read = toliman.Measurements(text.encode())
        used = known(table, names[1]) & known(table, names[2])
        y, sigma = (numpy.asarray(table[name])[used] for name in names[1:])
        factor = 1
        if form in WITH_UNITS and stated[0] is not None:
            factor = units.Unit(stated[1]).to(units.Unit(stated[0]))
        numpy.testing.assert_array_equal(read.y, y, text)
        numpy.testing.assert_allclose(read.sigma, sigma * factor, rtol=1e-14)
        self.assertEqual(read.info.left_out, len(table) - used.sum())
        t = numpy.asarray(table[names[0]])[used]
        numpy.testing.assert_allclose(read.t - read.t[0], t - t[0], rtol=0, atol=1e-6)

    def test_what_astropy_writes(self):
        chance = random.Random(11)
        for form, names, masked in itertools.product(FORMATS, NAMES, (False, True)):
            stated = chance.choice(UNITS)
            table = table_of(chance, names, stated, masked)
            with self.subTest(form=form, names=names, stated=stated), warnings.catch_warnings(action="ignore"):
                self.check(table, names, stated, form)

    def test_cut_tables_are_refused_or_shorter(self):
        """A table that ends anywhere gives the first of its rows, an error, or a last number with fewer digits."""
        chance = random.Random(12)
        for form in FORMATS:
            table = table_of(chance, NAMES[1], UNITS[0], False)
            with warnings.catch_warnings(action="ignore"):
                text = text_of(table, form)
                lines = text[:-1].rindex("\n") + 1
                for end in range(lines + 1, len(text) - 1):
                    try:
                        read = toliman.Measurements(text[:end].encode())
                    except toliman.Error:
                        continue
                    count = len(read)
                    self.assertGreaterEqual(count, len(table) - 1, text[:end])
                    numpy.testing.assert_array_equal(read.y[:len(table) - 1], table["y"][:len(table) - 1])


if __name__ == "__main__":
    unittest.main()
