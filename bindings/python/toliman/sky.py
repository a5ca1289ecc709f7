"""Separation of a binary as an observer sees it. Reference: include/toliman/sky.h."""
from __future__ import annotations

import ctypes
import os
import typing

import numpy
from numpy.typing import ArrayLike, NDArray

from . import _raw
from ._arguments import INT64, file_name, options_of, pointer, real
from ._handle import Handle
from ._library import check, library
from ._log import log
from ._predictions import structured
from ._results import Diagnosis, Hypothesis, Refit, SkyInfo, SkyPrediction

_EFFECTS = ("earth_aberration", "spacecraft_aberration", "parallax", "roemer", "light_time", "radial_motion",
            "transverse_motion", "deflection")
_int64 = ctypes.POINTER(ctypes.c_int64)
_size = ctypes.POINTER(ctypes.c_size_t)


def _nanoseconds(name: str, values: ArrayLike) -> NDArray[numpy.int64]:
    """Returns times as int64. Dates and days are refused: numpy would truncate them."""
    array = numpy.asarray(values)
    if array.dtype.kind not in "iu" and array.size > 0:
        raise TypeError(f"{name} is an array of {array.dtype}: must be integers, nanoseconds of TAI (parse_time)")
    if array.dtype.kind == "u" and array.size > 0 and int(array.max()) >= INT64:
        raise ValueError(f"{name} = {int(array.max())}: must be below 2^63")
    return numpy.require(array, numpy.int64, "C")


class _Exposures:
    """Intervals of measurements: times [n], pairs of start and end [n][2], or a sequence of n arrays [intervals][2].

    on_target: whether they are on-target intervals. None: only if each measurement has an array [intervals][2]."""

    def __init__(self, tai_ns: typing.Any, on_target: bool | None):
        given = tai_ns if isinstance(tai_ns, (list, tuple)) else numpy.asarray(tai_ns)
        are_lists = {numpy.ndim(one) > 1 for one in given}
        if on_target is None and len(are_lists) > 1:
            raise ValueError("tai_ns: must be a time or a pair for each measurement, or an array [intervals][2] for each")
        pairs = [_nanoseconds("tai_ns", [one, one] if numpy.ndim(one) == 0 else one).reshape(-1, 2) for one in given]
        is_known = True in are_lists if on_target is None else on_target
        if not is_known and any(len(pair) != 1 for pair in pairs):
            raise ValueError("on_target=False: must have one interval for each measurement")
        self.count = len(pairs)
        lengths = (ctypes.c_size_t * len(pairs))(*(len(pair) for pair in pairs))
        self.counts = ctypes.cast(lengths, _size) if is_known else None
        self.intervals = numpy.ascontiguousarray(numpy.concatenate([*pairs, numpy.empty((0, 2), numpy.int64)]))

    def column(self, values: ArrayLike) -> NDArray[numpy.float64]:
        """One number for each measurement, or one for all."""
        return numpy.ascontiguousarray(numpy.broadcast_to(values, self.count), float)


class Sky(Handle):
    """Predicts the separation of a binary as an observer sees it.

        sky = Sky("alpha-cen", "spacecraft.oem")
        seen = sky.predict(tai_ns)                    # structured array: seen["separation_arcsec"], seen["factor"]
        reduced, seen = sky.reduce(intervals, measured_arcsec)

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
        options = options_of(_raw.toliman_sky_options, library.toliman_sky_options_init,
                             observer=None if observer is None else file_name(observer),
                             altitude_km=real("altitude_km", altitude_km), node_hours=real("node_hours", node_hours),
                             without=sum(1 << _EFFECTS.index(name) for name in set(left_out)), log=log)
        super().__init__(self._create(library.toliman_sky_create, file_name(system), ctypes.byref(options)))

    def predict(self, tai_ns: ArrayLike) -> NDArray:
        """Returns what the observer sees at each time: a structured array of the times' shape, with the members of
        SkyPrediction."""
        times = _nanoseconds("tai_ns", tai_ns)
        made = (_raw.toliman_sky_prediction * max(times.size, 1))()
        made[0].struct_size = ctypes.sizeof(_raw.toliman_sky_prediction)
        check(library.toliman_sky_predict(self._c, times.ctypes.data_as(_int64), times.size, made))
        return structured(made)[:times.size].reshape(times.shape)

    def predict_mean(self, intervals: ArrayLike) -> SkyPrediction:
        """Returns the mean over on-target intervals, [start, end] or [n][2], weighted with their lengths."""
        given = _nanoseconds("intervals", intervals)
        if given.ndim == 0 or given.ndim > 2 or (given.size > 0 and given.shape[-1] != 2):
            raise ValueError(f"intervals has shape {given.shape}: must be (2,) or (n, 2)")
        given = given.reshape(-1, 2)
        made = _raw.toliman_sky_prediction()
        check(library.toliman_sky_predict_mean(self._c, given.ctypes.data_as(_int64), len(given), ctypes.byref(made)))
        return SkyPrediction._of(made)

    def reduce(self, tai_ns: ArrayLike, separations_arcsec: ArrayLike, *,
               on_target: bool | None = None) -> tuple[NDArray[numpy.float64], NDArray]:
        """Reduces measured separations to the orbit: measured / factor - geometric_arcsec.

            reduced, seen = sky.reduce([[start, end], ...], measured_arcsec)             # exposures of at most 600 s
            reduced, seen = sky.reduce([[[start, end], ...], ...], measured_arcsec)      # on-target intervals

        tai_ns: start and end of each exposure, [n][2], or its on-target intervals, a sequence of n arrays
            [intervals][2]; times [n] for the Earth's centre only.
        on_target: whether the telescope pointed at the stars in all of tai_ns. None: True for arrays [intervals][2],
            False for pairs and times. With False and an observer in orbit, exposures above 600 s are refused.
        Returns the reduced separations and the predictions, a structured array as that of predict. They are NaN where
        the observer file has no state, and where a measured separation is NaN."""
        exposures = _Exposures(tai_ns, on_target)
        separations, reduced = exposures.column(separations_arcsec), numpy.empty(exposures.count)
        made = (_raw.toliman_sky_prediction * max(exposures.count, 1))()
        made[0].struct_size = ctypes.sizeof(_raw.toliman_sky_prediction)
        unreduced = ctypes.c_size_t()
        check(library.toliman_sky_reduce(self._c, exposures.intervals.ctypes.data_as(_int64), exposures.counts,
                                         pointer(separations), exposures.count, pointer(reduced), made,
                                         ctypes.byref(unreduced)))
        return reduced, structured(made)[:exposures.count]

    def refit(self, tai_ns: ArrayLike, separations_arcsec: ArrayLike, sigmas_arcsec: ArrayLike, *,
              scale_sigma: float = 0, on_target: bool | None = None) -> tuple[Sky, Refit]:
        """Fits the orbit again to measured separations, together with the errors of its elements.

            better, fit = sky.refit([[start, end], ...], measured_arcsec, sigma_arcsec, scale_sigma=1e-3)
            better.save("refitted.json")

        tai_ns, on_target: exposures or on-target intervals, as in reduce.
        scale_sigma: standard deviation of the relative error of the plate scale, in [0, 1); 0: no error.
        Returns the Sky with the new orbit, and its errors and residuals. If fit.unusable, chi-square is so poor that
        the orbit must not be used."""
        exposures = _Exposures(tai_ns, on_target)
        separations, sigmas = exposures.column(separations_arcsec), exposures.column(sigmas_arcsec)
        result = _raw.toliman_sky_refit_result()
        made = self._create(library.toliman_sky_refit, self._c, exposures.intervals.ctypes.data_as(_int64),
                            exposures.counts, pointer(separations), pointer(sigmas), exposures.count,
                            real("scale_sigma", scale_sigma), ctypes.byref(result))
        return Sky._adopt(made), Refit._of(result)

    def diagnose(self, tai_ns: ArrayLike, separations_arcsec: ArrayLike, sigmas_arcsec: ArrayLike, *,
                 scale_sigma: float = 0, on_target: bool | None = None) -> tuple[Diagnosis, dict[str, Hypothesis]]:
        """Finds the mistake that explains the residuals of measured separations about their predictions.

            found, hypotheses = sky.diagnose([[start, end], ...], measured_arcsec, sigma_arcsec)
            if found.goodness == "poor" and found.cause != "none":
                print(hypotheses[found.cause].text)     # times are late by 37.0 +- 0.2 s: TAI taken for UTC?

        The arguments are those of refit. Measurements that the observer file does not cover are left out.
        Returns the cause with the goodness of fit, and all hypotheses by their causes. Of times, value is the given
        time minus the true time: above 0 for times that are late."""
        exposures = _Exposures(tai_ns, on_target)
        separations, sigmas = exposures.column(separations_arcsec), exposures.column(sigmas_arcsec)
        result = _raw.toliman_sky_diagnosis()
        rows = (_raw.toliman_sky_hypothesis * _raw.TOLIMAN_SKY_HYPOTHESES)()
        rows[0].struct_size = ctypes.sizeof(_raw.toliman_sky_hypothesis)
        check(library.toliman_sky_diagnose(self._c, exposures.intervals.ctypes.data_as(_int64), exposures.counts,
                                           pointer(separations), pointer(sigmas), exposures.count,
                                           real("scale_sigma", scale_sigma), ctypes.byref(result), rows))
        hypotheses = [Hypothesis._of(row) for row in rows]
        return Diagnosis._of(result), {one.cause: one for one in hypotheses}

    def error_columns(self, unit_arcsec: float = 1.0, *,
                      scale_sigma: float = 0.0) -> tuple[list[int], numpy.ndarray, numpy.ndarray]:
        """The errors of the reference orbit as nuisance functions of a periodogram of reduced separations.

            elements, bounds, priors = sky.error_columns()
            p = toliman.Periodogram(f0, df, nf, columns=len(elements), column_bounds=bounds, priors=[math.inf, *priors])
            reduced, seen = sky.reduce(exposures, measured_arcsec)
            p.push_many(t, reduced, sigma_arcsec, rows=seen["partials"][:, elements])

        unit_arcsec: arcsec per unit of the values: 1, or the plate scale for pixels.
        scale_sigma: standard deviation of the relative error of the plate scale, in [0, 1); 0: no error.
        Returns the elements with a standard deviation, except the node; the largest absolute values of their partial
        derivatives; and the standard deviations of their coefficients."""
        options = options_of(_raw.toliman_period_options, library.toliman_period_options_init)
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
        for i in range(7):
            check(library.toliman_sky_get_element(self._c, i, ctypes.byref(value), ctypes.byref(sigma)))
            found[library.toliman_sky_element_name(i).decode()] = (value.value, sigma.value)
        return found

    @property
    def info(self) -> SkyInfo:
        """Observer, covered times and reference orbit."""
        return self._read(library.toliman_sky_get_info, _raw.toliman_sky_info, SkyInfo)
