"""Small objects of every class, which the tests of tables, repr() and notebook views share."""
import functools

import numpy

from package import toliman

SCENE = {
    "schema": "toliman-scene/1",
    "telescope": {"aperture_m": 0.125, "secondary_m": 0.032, "pupil_samples": 32,
                  "mask": {"kind": "spiral", "opd_nm": 292.5, "edges": "area",
                           "terms": [{"a": 1, "f": 1.2, "m": -5, "p": 1}]}},
    "band": {"min_nm": 530, "max_nm": 640, "step_nm": 55},
    "stars": {"A": {"spectrum": {"kind": "blackbody", "temperature_k": 5790}, "photons_per_s": 7.5e6},
              "B": {"spectrum": {"kind": "blackbody", "temperature_k": 5260}, "photons_per_s": 2.5e6}},
    "binary": {"separation_arcsec": 4, "position_angle_deg": 30},
    "signal": {"kind": "sinusoid", "star": "B", "amplitude_px": 1e-3, "period_days": 20},
    "cadence": {"frames": 6, "interval_days": 15, "exposure_s": 100},
    "detector": {"shape": [40, 40], "pixel_scale_arcsec": 0.375},
    "noise": {"photon": True, "read_e": 1.3, "seed": 7},
    "accuracy": 1e-7,
}
START_NS = 1_900_000_000 * 10**9
TAI_NS = START_NS + (numpy.arange(40) * 25.25 * 86400e9).astype(numpy.int64)
T = numpy.arange(40) * 25.25
Y = 1e-6 * numpy.random.default_rng(1).normal(size=40)


def estimate(image):
    return toliman.Estimate(float(image[0, 0]), chi_square=1.0)


@functools.lru_cache(maxsize=None)
def objects():
    """Every object, by a name; created once."""
    simulator = toliman.Simulator(SCENE)
    fit, frames = toliman.Fit(simulator), simulator.frames(0, 4)
    series = toliman.Measurements.of(T, Y, 1e-6, kind="reduced", unit=1, position_angle_deg=T / 10)
    series.set_instruments(["a", "b"] * 20).set_trend(2).add_column("column", T**2, 3.0).set_prior(0, 0.5)
    velocities = toliman.Measurements.of(None, 1e6 * Y, 1.0, kind="velocity", unit=1000, exposures=TAI_NS)
    periodogram = toliman.Periodogram(*toliman.suited_grid(T))
    periodogram.push_many(T, 1e6 * Y, 1.0)
    sky = toliman.Sky("alpha-cen", altitude_km=600)
    tracker = toliman.Tracker(estimate, 0.001, 0.001, 100, estimator_id=7, sigma=1.0, value_limit=1e6, rows=8, cols=6,
                              image_shape=(8, 6), allow_zero_runs=True)
    pushed = [toliman.Frame(numpy.full((8, 6), 1 + Y[k]), k, int(TAI_NS[k])) for k in range(9)]
    outcomes = tracker.push_many([*pushed, pushed[2]])
    found = toliman.planets(series, samples=100, star_masses=(1.08, 0.91), parallax_arcsec=0.75, threads=1)
    calibration = toliman.calibrate(simulator, frames, free="focus scale")
    seen = sky.predict(TAI_NS)
    return {
        "simulator": simulator, "series of a scene": simulator.series(), "spectrum": simulator.spectrum(),
        "budget": simulator.budget(["flux_a"]), "parameters": toliman.parameters(), "scene": simulator.info, "fit": fit,
        "fits": fit.frames(frames), "template": toliman.Template(simulator), "measurements": series,
        "velocities": velocities, "functions": series.functions, "instruments": series.instruments,
        "periodogram": periodogram, "peaks": periodogram.peaks(), "peak": periodogram.peak(),
        "aliases": periodogram.aliases(periodogram.peak().frequency), "sampling": periodogram.sampling(T), "sky": sky,
        "predictions": seen,
        "tracker": tracker, "tracked": tracker.period, "records": tracker.records(), "outcomes": outcomes,
        "streams": tracker.streams(), "planets": found, "candidates": found.candidates,
        "limits": found.limits([100, 300]), "samples": found.samples(), "calibration": calibration,
        "windows": calibration.windows, "calibrated frames": calibration.frames, "frame": pushed[0], "estimate": estimate(pushed[0].pixels),
        "spread": toliman.Spread(), "grid": toliman.suited_grid(T), "machine": toliman.machine(),
    }
