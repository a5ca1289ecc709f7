"""Options structs: each member refuses, by its name, what its comment in the header does not allow. The comments are the
table, from which the library's checks are made: a number that is not finite, one outside the stated range, an unknown
constant, unknown flags."""
import ctypes
import math
import re
import sys
import unittest

from package import ROOT, toliman
from toliman import _raw
from toliman._library import library

sys.path.insert(0, str(ROOT / "tools" / "gen"))
import model as headers  # noqa: E402

COUNT, SIDE = 40, 256
SCENE = {
    "schema": "toliman-scene/1", "telescope": {"aperture_m": 0.1, "pupil_samples": 96}, "band": {"wavelength_nm": 580},
    "stars": {"A": {"spectrum": {"kind": "blackbody", "temperature_k": 5790}, "relative_flux": 3},
              "B": {"spectrum": {"kind": "blackbody", "temperature_k": 5260}}},
    "binary": {"separation_arcsec": 8, "position_angle_deg": 40},
    "signal": {"kind": "sinusoid", "star": "B", "amplitude_px": 1e-3, "period_days": 20},
    "cadence": {"frames": 6, "interval_days": 10, "peak_photons": 1e6},
    "detector": {"shape": [SIDE, SIDE], "pixel_scale_arcsec": 0.4}, "noise": {"photon": True, "seed": 7},
}
RANGE = re.compile(r"(?<!\w)in ([\[(])([-\d.e]+), ([-\w.^]+)([\])])")


class Callers:
    """A call for each options struct, whose other arguments are right; it returns a status."""

    def __init__(self):
        self.sim, self.out = toliman.Simulator(SCENE), ctypes.c_void_p()
        self.numbers = (ctypes.c_double * COUNT)(*[i + 0.1 * (i % 3) for i in range(COUNT)])
        self.values = (ctypes.c_double * COUNT)(*[math.sin(i) for i in range(COUNT)])
        self.power = (ctypes.c_double * 64)()
        self.cae, self.fit = toliman.CAE(self.sim), toliman.Fit(self.sim, capture_px=20)
        self.period = toliman.Periodogram(0.01, 0.01, 5)
        self.period.push_many(list(self.numbers), list(self.values))
        self.series = toliman.Measurements.of(list(self.numbers), list(self.values), 1.0)
        self.sky, self.fit = toliman.Sky("alpha-cen"), toliman.Fit(self.sim)
        self.components = toliman.Components(self.sim)
        self.calls = {
            "toliman_period_options": lambda o: library.toliman_period_create(0.1, 0.1, 3, o, self.handle("period")),
            "toliman_period_batch_options": lambda o: library.toliman_period_batch(
                0.01, 0.01, 5, self.numbers, self.values, None, COUNT, o, self.power),
            "toliman_period_bootstrap_options": lambda o: library.toliman_period_query_bootstrap(
                self.period._c, self.numbers, self.values, None, COUNT, o, 3, self.power),
            "toliman_period_noise_options": lambda o: library.toliman_measure_query_noise(
                self.series._c, 0.01, 0.01, 5, o, None, None, None, ctypes.byref(_raw.toliman_period_noise())),
            "toliman_period_noise_bootstrap_options": lambda o: library.toliman_measure_query_noise_bootstrap(
                self.series._c, 0.01, 0.01, 5, 0.1, o, 3, self.power),
            "toliman_planet_options": lambda o: library.toliman_planet_create(self.series._c, o, self.handle("planet")),
            "toliman_ingest_options": lambda o: library.toliman_ingest_create(b"nothing_meta.jsonl", o,
                                                                              self.handle("ingest")),
            "toliman_series_options": lambda o: library.toliman_series_create(o, self.handle("series")),
            "toliman_measure_options": lambda o: library.toliman_measure_load(b"1,2\n2,3\n", 8, None, o,
                                                                              self.handle("measure")),
            "toliman_sky_options": lambda o: library.toliman_sky_create(b"alpha-cen", o, self.handle("sky")),
            "toliman_sim_options": lambda o: library.toliman_sim_create_json(b"{}", 2, None, o, self.handle("sim")),
            "toliman_sim_budget_options": lambda o: library.toliman_sim_get_budget(
                self.sim._c, o, ctypes.byref(_raw.toliman_sim_budget())),
            "toliman_cae_options": lambda o: library.toliman_cae_create(self.sim._c, 3, o, self.handle("cae")),
            "toliman_cae_train_options": lambda o: library.toliman_cae_train(self.cae._c, o, None),
            "toliman_cae_save_options": lambda o: library.toliman_cae_save(self.cae._c, o, None, 0,
                                                                           ctypes.byref(ctypes.c_size_t())),
            "toliman_linear_options": lambda o: library.toliman_linear_create(self.sim._c, o, self.handle("linear")),
            "toliman_components_options": lambda o: library.toliman_components_create(self.sim._c, o,
                                                                                      self.handle("components")),
            "toliman_coadd_options": lambda o: library.toliman_coadd_create(self.fit._c, None, o, self.handle("coadd")),
            "toliman_fit_options": lambda o: library.toliman_fit_create(ctypes.byref(self.sim._c), None, 1, o, self.handle("fit")),
            "toliman_bank_options": lambda o: library.toliman_bank_plan(self.sim._c, o,
                                                                        ctypes.byref(_raw.toliman_bank_plan_info())),
            "toliman_calibration_options": lambda o: library.toliman_calibration_create(
                self.sim._c, None, 0, None, o, self.handle("calibration")),
            "toliman_components_train_options": lambda o: library.toliman_components_train(
                self.components._c, o, ctypes.byref(_raw.toliman_components_training())),
            "toliman_sky_reduce_options": lambda o: library.toliman_sky_reduce(
                self.sky._c, self.series._c, o, self.handle("measure")),
            "toliman_coadd_options": lambda o: library.toliman_coadd_create(
                self.fit._c, None, o, self.handle("coadd")),
            "toliman_mask_options": lambda o: library.toliman_mask_create(self.sim._c, o, self.handle("mask")),
            "toliman_track_options": lambda o: library.toliman_track_create(o, self.handle("track")),
        }

    def handle(self, name):
        return ctypes.byref(ctypes.POINTER(getattr(_raw, "toliman_" + name))())


def wrong_values(field):
    """Values of a member that its comment does not allow."""
    kind, doc = field.type, " ".join(field.doc.split())
    if kind.pointers or field.name == "struct_size":
        return
    if field.name == "reserved":
        yield 1
    elif field.name == "flags":
        yield 1 << 30
    elif re.match("0 or 1", doc):
        yield from (-1, 2)
    elif kind.base == "int32_t" and re.search(r"TOLIMAN_[A-Z_]+_\.\.\.", doc):
        yield from (7, 999)
    elif kind.base == "double":
        yield from (math.nan, math.inf, -math.inf)
    for low_end, low, high, high_end in RANGE.findall(doc):
        whole, low, high = kind.base != "double", float(low), float(high.replace("2^50", "1125899906842624").replace(
            "2^28", "268435456").replace("TOLIMAN_PLANET_MOST", str(_raw.TOLIMAN_PLANET_MOST)))
        below = low if low_end == "(" else low - 1 if whole else low - max(1, abs(low))
        above = high if high_end == ")" else high + 1 if whole else high + max(1, abs(high))
        if below != 0 and (below > 0 or not kind.base.startswith(("u", "size"))):  # 0 is the default
            yield int(below) if whole else below
        if math.isfinite(above):
            yield int(above) if whole else above
        if low_end == "[" and low > 0 and not whole:
            yield low / 2


class Options(unittest.TestCase):
    # promise: wrong-enumerations-are-refused
    def test_members_refuse_what_their_comments_do_not_allow(self):
        callers, table = Callers(), headers.read(str(ROOT))
        options = {item.name for item in table.all(headers.Struct) if item.name.endswith("_options")}
        self.assertEqual(options - set(callers.calls), {"toliman_load_options", "toliman_bank_train_options"})
        tried = 0
        for name, call in callers.calls.items():
            for path, field in self.members(table, table.by_name[name]):
                for value in wrong_values(field):
                    with self.subTest(f"{name}.{path} = {value}"):
                        self.assert_refused(table, name, call, path, field, value)
                        tried += 1
        self.assertGreater(tried, 300)

    def members(self, table, struct, before=""):
        for field in struct.fields:
            inner = table.by_name.get(field.type.base)
            if isinstance(inner, headers.Struct) and not field.type.pointers:
                yield from self.members(table, inner, f"{before}{field.name}.")
            elif field.type.base in headers.SCALARS and field.type.base != "char":
                yield before + field.name, field

    def assert_refused(self, table, name, call, path, field, value):
        options = getattr(_raw, name)()
        *groups, member = path.split(".")
        target = options
        for group in groups:
            target = getattr(target, group)
        if field.type.array:
            getattr(target, member)[1] = value
            path += "[1]"
        else:
            setattr(target, member, value)
        status = call(ctypes.byref(options))
        self.assertEqual(status, _raw.TOLIMAN_E_ARGUMENT, library.toliman_last_error().decode())
        self.assertEqual(library.toliman_last_error_field().decode(), "options->" + path)


if __name__ == "__main__":
    unittest.main()
