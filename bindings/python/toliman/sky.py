"""Separation of a binary as an observer sees it. Reference: include/toliman/sky.h."""
from __future__ import annotations

import ctypes
import os
import typing

import numpy
from numpy.typing import ArrayLike

from . import _raw
from ._arguments import file_name, in_unit, options_of, real
from ._handle import Handle
from ._library import check, library
from ._log import log
from ._predictions import structured
from ._results import Diagnosis, Hypothesis, Refit, SkyInfo, SkyPrediction
from ._table import Column, Records, Tabular
from ._units import unit_of_name
from .measure import Exposures, Measurements, nanoseconds
from .sim import Scene, Simulator, simulator_of

_EFFECTS = ("earth_aberration", "spacecraft_aberration", "parallax", "roemer", "light_time", "radial_motion",
            "transverse_motion", "deflection")
_int64 = ctypes.POINTER(ctypes.c_int64)


def _measured(measured: Measurements | ArrayLike, separations: ArrayLike | None, sigmas: ArrayLike | None,
              on_target: bool | None) -> Measurements:
    """The series, or that of arrays."""
    if isinstance(measured, Measurements):
        if separations is not None or sigmas is not None or on_target is not None:
            raise TypeError("measured is a series: separations, sigmas and on_target must not be given")
        return measured
    if separations is None:
        raise TypeError("separations_arcsec: must be given with exposures")
    values, deviations = (in_unit(name, one, "arcsec") for name, one in (("separations_arcsec", separations),
                                                                         ("sigmas_arcsec", sigmas)))
    return Measurements.of(None, values, deviations, kind="separation", exposures=measured, on_target=on_target, unit=1)


class Sky(Handle, Tabular):
    """Predicts the separation of a binary as an observer sees it.

        sky = Sky("alpha-cen", "spacecraft.oem")
        seen = sky.predict(tai_ns)                    # structured array: seen["separation_arcsec"], seen["factor"]
        reduced = sky.reduce(intervals, measured_arcsec, sigma_arcsec)     # Measurements, for planets()

    system: "alpha-cen" (Akeson et al. 2021), a system file (schema toliman-system/1), or its JSON text.
    observer: observer file, CCSDS OEM or CSV; None: the Earth's centre, with a warning, or a circular orbit.
    altitude_km: altitude of a circular sun-synchronous orbit, for simulations; 0: none.
    node_hours: its local mean time at the ascending node; 0 means 18.
    without: effects to leave out: "earth_aberration", "spacecraft_aberration", "parallax", "roemer", "light_time",
        "radial_motion", "transverse_motion", "deflection".

    Times are TAI nanoseconds since 1970-01-01T00:00:00 TAI (parse_time). Raises NotFoundError and InputError for bad
    files, and InputError for times that the observer file does not cover.
    """

    _kind, _destroy = _raw.toliman_sky, "toliman_sky_destroy"

    def __init__(self, system: str | os.PathLike[str] = "alpha-cen", observer: str | os.PathLike[str] | None = None, *,
                 altitude_km: float = 0, node_hours: float = 0, without: str | typing.Iterable[str] = ()):
        left_out = [without] if isinstance(without, str) else list(without)
        for name in left_out:
            if name not in _EFFECTS:
                raise ValueError(f"without: {name!r}: must be one of {', '.join(_EFFECTS)}")
        options = options_of(_raw.toliman_sky_options,
                             observer=None if observer is None else file_name(observer),
                             altitude_km=real("altitude_km", altitude_km), node_hours=real("node_hours", node_hours),
                             without=sum(1 << _EFFECTS.index(name) for name in set(left_out)), log=log)
        super().__init__(self._create(library.toliman_sky_create, file_name(system), ctypes.byref(options)))

    @classmethod
    def of(cls, scene: Simulator | Scene) -> Sky:
        """Returns the Sky of a scene: its binary.orbit and binary.observer. Raises UnsupportedError without an observer."""
        simulator = simulator_of("scene", scene)
        options = options_of(_raw.toliman_sky_options, scene=simulator._c, log=log)
        return cls._adopt(cls._create(library.toliman_sky_create, None, ctypes.byref(options)))

    def predict(self, tai_ns: ArrayLike) -> Records:
        """Returns what the observer sees at each time: a structured array of the times' shape, with the members of
        SkyPrediction."""
        times = nanoseconds("tai_ns", tai_ns)
        made = (_raw.toliman_sky_prediction * max(times.size, 1))()
        made[0].struct_size = ctypes.sizeof(_raw.toliman_sky_prediction)
        check(library.toliman_sky_predict(self._c, times.ctypes.data_as(_int64), times.size, made))
        return structured(made)[:times.size].reshape(times.shape)

    def predict_mean(self, intervals: ArrayLike) -> SkyPrediction:
        """Returns the mean over on-target intervals, [start, end] or [n][2], weighted with their lengths. Its numbers are NaN
        if the observer file does not cover them completely."""
        given = nanoseconds("intervals", intervals)
        if given.ndim == 0 or given.ndim > 2 or (given.size > 0 and given.shape[-1] != 2):
            raise ValueError(f"intervals has shape {given.shape}: must be (2,) or (n, 2)")
        given = given.reshape(-1, 2)
        made = _raw.toliman_sky_prediction()
        number = ctypes.c_size_t(len(given))
        check(library.toliman_sky_predict_mean(self._c, given.ctypes.data_as(_int64), ctypes.byref(number), 1,
                                               ctypes.byref(made)))
        return SkyPrediction._of(made)

    def predict_exposures(self, tai_ns: ArrayLike, on_target: bool | None = None) -> Records:
        """Returns the means over exposures: a structured array as that of predict, with NaN where the observer file has
        no state.

        tai_ns, on_target: as exposures of Measurements.of."""
        exposures = Exposures(tai_ns, on_target)
        made = (_raw.toliman_sky_prediction * max(exposures.count, 1))()
        made[0].struct_size = ctypes.sizeof(_raw.toliman_sky_prediction)
        check(library.toliman_sky_predict_mean(self._c, exposures.intervals, exposures.counts, exposures.count, made))
        return structured(made)[:exposures.count]

    def reduce(self, measured: Measurements | ArrayLike, separations_arcsec: ArrayLike | None = None,
               sigmas_arcsec: ArrayLike | None = None, *, on_target: bool | None = None, scale_sigma: float = 0,
               functions: bool = True) -> Measurements:
        """Reduces measured separations to the orbit: measured / factor - geometric_arcsec.

            reduced = sky.reduce(Measurements("separations.csv", kind="separation", exposure_s=60))
            reduced = sky.reduce([[start, end], ...], measured_arcsec, sigma_arcsec)     # exposures of at most 600 s
            reduced = sky.reduce([[[start, end], ...], ...], measured_arcsec)            # on-target intervals

        measured: of kind "separation", or exposures as those of Measurements.of, with separations and sigmas.
        scale_sigma: standard deviation of the relative error of the plate scale, in [0, 1).
        functions: fit the errors of the orbit with the mean, unless the series has functions.
        Returns the reduced series, without the measurements that the observer file does not cover: info.left_out."""
        options = options_of(_raw.toliman_sky_reduce_options,
                             flags=0 if functions else _raw.TOLIMAN_SKY_NO_FUNCTIONS,
                             scale_sigma=real("scale_sigma", scale_sigma), log=log)
        given = _measured(measured, separations_arcsec, sigmas_arcsec, on_target)
        return Measurements._adopt(Measurements._create(library.toliman_sky_reduce, self._c, given._c,
                                                        ctypes.byref(options)))

    def refit(self, measured: Measurements | ArrayLike, separations_arcsec: ArrayLike | None = None,
              sigmas_arcsec: ArrayLike | None = None, *, scale_sigma: float = 0,
              on_target: bool | None = None) -> tuple[Sky, Refit]:
        """Fits the orbit again to measured separations, together with the errors of its elements.

            better, fit = sky.refit(Measurements("state", kind="separation"), scale_sigma=1e-3)
            better.save("refitted.json")

        measured, ...: as for reduce, with sigmas; measurements that the observer file does not cover are left out.
        scale_sigma: standard deviation of the relative error of the plate scale, in [0, 1); 0: no error.
        Returns the Sky with the new orbit, and its errors and residuals. If fit.unusable, chi-square is so poor that
        the orbit must not be used. planets() refuses measurements of these dates that are reduced to the new orbit."""
        given = _measured(measured, separations_arcsec, sigmas_arcsec, on_target)
        result = _raw.toliman_sky_refit_result()
        made = self._create(library.toliman_sky_refit, self._c, given._c, real("scale_sigma", scale_sigma),
                            ctypes.byref(result))
        return Sky._adopt(made), Refit._of(result)

    def diagnose(self, measured: Measurements | ArrayLike, separations_arcsec: ArrayLike | None = None,
                 sigmas_arcsec: ArrayLike | None = None, *, scale_sigma: float = 0,
                 on_target: bool | None = None) -> tuple[Diagnosis, dict[str, Hypothesis]]:
        """Finds the mistake that explains the residuals of measured separations about their predictions.

            found, hypotheses = sky.diagnose(Measurements("state", kind="separation"))
            if found.goodness == "poor" and found.cause != "none":
                print(hypotheses[found.cause].text)     # times are late by 37.0 +- 0.2 s: TAI taken for UTC?

        The arguments are those of refit. Measurements that the observer file does not cover are left out.
        Returns the cause with the goodness of fit, and all hypotheses by their causes. Of times, value is the given
        time minus the true time: above 0 for times that are late."""
        given = _measured(measured, separations_arcsec, sigmas_arcsec, on_target)
        result = _raw.toliman_sky_diagnosis()
        rows = (_raw.toliman_sky_hypothesis * _raw.TOLIMAN_SKY_HYPOTHESES)()
        rows[0].struct_size = ctypes.sizeof(_raw.toliman_sky_hypothesis)
        check(library.toliman_sky_diagnose(self._c, given._c, real("scale_sigma", scale_sigma), ctypes.byref(result),
                                           rows))
        hypotheses = [Hypothesis._of(row) for row in rows]
        return Diagnosis._of(result), {one.cause: one for one in hypotheses}

    def error_columns(self, unit_arcsec: float = 1.0, *,
                      scale_sigma: float = 0.0) -> tuple[list[int], numpy.ndarray, numpy.ndarray]:
        """The errors of the reference orbit as nuisance functions of a periodogram of reduced separations.

            elements, bounds, priors = sky.error_columns()
            p = toliman.Periodogram(f0, df, nf, columns=len(elements), column_bounds=bounds, priors=[math.inf, *priors])
            seen = sky.predict_exposures(exposures)
            p.push_many(t, measured_arcsec / seen["factor"] - seen["geometric_arcsec"], sigma_arcsec,
                        rows=seen["partials"][:, elements])

        unit_arcsec: arcsec per unit of the values: 1, or the plate scale for pixels.
        scale_sigma: standard deviation of the relative error of the plate scale, in [0, 1); 0: no error.
        Returns the elements with a standard deviation, except the node; the largest absolute values of their partial
        derivatives; and the standard deviations of their coefficients."""
        options = options_of(_raw.toliman_period_options)
        elements = (ctypes.c_int32 * 7)()
        check(library.toliman_sky_set_columns(self._c, real("unit_arcsec", unit_arcsec),
                                              real("scale_sigma", scale_sigma), ctypes.byref(options), elements))
        count = options.columns
        precisions = numpy.array(options.prior_precision[1:1 + count])
        return list(elements[:count]), numpy.array(options.column_bound[:count]), 1 / numpy.sqrt(precisions)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the system to a file (schema toliman-system/1)."""
        check(library.toliman_sky_save_file(self._c, file_name(path)))

    @property
    def elements(self) -> dict[str, tuple[float, float]]:
        """The elements of the orbit by name, each with its standard deviation, 0 if unknown."""
        found = {}
        value, sigma = ctypes.c_double(), ctypes.c_double()
        for element in range(_raw.TOLIMAN_SKY_ELEMENT_PERIOD, _raw.TOLIMAN_SKY_ELEMENT_EPOCH + 1):
            check(library.toliman_sky_get_element(self._c, element, ctypes.byref(value), ctypes.byref(sigma)))
            found[library.toliman_constant_name(element).decode()] = (value.value, sigma.value)
        return found

    def _columns(self) -> dict[str, Column]:
        """Returns the elements of the orbit, one per row."""
        elements = self.elements
        values, sigmas = zip(*elements.values())
        return {"name": Column(list(elements)), "unit": Column([unit_of_name(name) for name in elements]),
                "value": Column(numpy.array(values)),
                "sigma": Column(numpy.array(sigmas), "", "standard deviation; 0: not known")}

    def _facts(self) -> dict[str, typing.Any]:
        info = self.info
        return {"system": info.name, "observer": info.observer, "parallax": info.parallax_arcsec or None}

    def _summary(self) -> str:
        info = self.info
        return f"Sky of {info.name or 'a system'}, observer {info.observer}, parallax {info.parallax_arcsec:.6g} arcsec"

    @property
    def info(self) -> SkyInfo:
        """Observer, covered times and reference orbit."""
        return self._read(library.toliman_sky_get_info, _raw.toliman_sky_info, SkyInfo)
