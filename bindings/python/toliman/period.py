"""Streaming periodogram; include/toliman/period.h is the manual."""
import ctypes
import math
import operator
import os
from ctypes import POINTER, byref, c_double, c_int32, c_char_p, c_int64, c_size_t, c_uint32, c_uint64, c_void_p

import numpy

from ._library import check, library


class _Options(ctypes.Structure):
    _fields_ = [("struct_size", c_uint32), ("flags", c_uint32)] + [
        (name, c_double) for name in ("time_offset", "value_offset", "value_bound", "sigma_floor", "sigma_ceiling")
    ] + [("time_offset_ns", c_int64), ("unit_ns", c_double), ("allocator", c_void_p)]


class Peak(ctypes.Structure):
    """A peak: frequency, period, power, widths, errors, amplitude, phase, offset and log10_fap as floats.

    period_error, frequency_error and amplitude_error are standard errors of least squares, scaled by the residuals; NaN
    of peak(), which sees no samples. half_width_error is the width of the peak instead, as the chapter prints it.
    y = offset + amplitude sin(2 pi frequency (t - time_offset) + phase). at_edge: the peak stands at the grid's first or
    last frequency, and the period may lie outside.
    """

    _fields_ = [("struct_size", c_uint32), ("flags", c_uint32)] + [
        (name, c_double)
        for name in (
            "frequency period power log10_residual fwhm fwhm_error half_width_error frequency_error "
            "amplitude amplitude_error phase offset log10_fap period_error"
        ).split()
    ]

    @property
    def at_edge(self):
        return bool(self.flags & _AT_EDGE)

    def __repr__(self):
        error = "" if math.isnan(self.period_error) else f" +- {self.period_error:.2g}"
        return f"Peak(period={self.period:.6g}{error}, power={self.power:.6g}, log10_fap={self.log10_fap:.4g})"


class _Info(ctypes.Structure):
    _fields_ = [("struct_size", c_uint32), ("flags", c_uint32), ("nf", c_int64)] + [
        (name, c_double) for name in ("f0", "df", "time_offset", "value_offset", "value_bound", "sigma_floor")
    ] + [("count", c_int64), ("digest", c_uint64), ("sigma_ceiling", c_double)] + [
        ("time_offset_ns", c_int64), ("unit_ns", c_double), ("weighted", c_int32), ("reserved", c_int32)
    ]


class Sampling(ctypes.Structure):
    """baseline, coarsest_df, ceiling and independent of the samples' times as floats; coarse, past_ceiling: the grid's df
    is above coarsest_df, its last frequency above the ceiling; narrow: at some frequency the sums
    give the power to less than 1e-9, for which they should be wide."""

    _fields_ = [("struct_size", c_uint32), ("flags", c_uint32)] + [
        (name, c_double) for name in ("baseline", "coarsest_df", "ceiling", "independent")
    ]

    @property
    def coarse(self):
        return bool(self.flags & _COARSE)

    @property
    def past_ceiling(self):
        return bool(self.flags & _PAST_CEILING)

    @property
    def narrow(self):
        return bool(self.flags & _NARROW)


class _Bootstrap(ctypes.Structure):
    _fields_ = [("struct_size", c_uint32), ("threads", c_uint32), ("seed", c_uint64), ("progress", c_void_p),
                ("progress_data", c_void_p)]


_FIXED_MEAN, _WIDE, _AT_EDGE, _COARSE, _PAST_CEILING, _NARROW = 1, 2, 1, 1, 2, 4
_NORMALISATIONS = {"standard": 0, "model": 1, "log": 2, "psd": 3}
_FAPS = {"baluev": 0, "naive": 1, "single": 2, "sequential": 3}
_doubles = POINTER(c_double)


def _declare(name, *argtypes, restype=c_int32):
    function = getattr(library, "toliman_period_" + name)
    function.argtypes, function.restype = argtypes, restype
    return function


_options_init = _declare("options_init", POINTER(_Options), c_size_t, restype=None)
_create = _declare("create", c_double, c_double, c_int64, POINTER(_Options), POINTER(c_void_p))
_destroy = _declare("destroy", c_void_p, restype=None)
_push = _declare("push", c_void_p, c_double, c_double, c_double)
_push_many = _declare("push_many", c_void_p, _doubles, _doubles, _doubles, c_size_t)
_count = _declare("count", c_void_p, restype=c_int64)
_query_power = _declare("query_power", c_void_p, c_uint32, c_int64, c_size_t, _doubles)
_query_peak = _declare("query_peak", c_void_p, POINTER(Peak))
_query_fit = _declare("query_fit", c_void_p, _doubles, _doubles, _doubles, c_size_t, POINTER(Peak))
_query_fap = _declare("query_fap", c_void_p, c_int32, c_double, _doubles)
_query_level = _declare("query_level", c_void_p, c_int32, c_double, _doubles)
_query_bootstrap = _declare("query_bootstrap", c_void_p, _doubles, _doubles, _doubles, c_size_t, POINTER(_Bootstrap),
                            c_size_t, _doubles)
_query_sampling = _declare("query_sampling", c_void_p, _doubles, c_size_t, POINTER(Sampling))
_get_info = _declare("get_info", c_void_p, POINTER(_Info))
_save_file = _declare("save_file", c_void_p, c_char_p)
_load_file = _declare("load_file", c_char_p, c_void_p, POINTER(c_void_p))


def _plain(name, values):
    """Float64 array; what would lose its mask or its unit on the way is refused."""
    if numpy.ma.is_masked(values):
        raise ValueError(f"{name} has masked values: leave them out, e.g. by {name}.compressed()")
    if getattr(values, "unit", None) is not None:
        raise TypeError(f"{name} is in {values.unit}: give plain numbers, e.g. {name}.to_value(...)")
    return numpy.ascontiguousarray(values, dtype=numpy.float64)


def _number_of(kind, names, name):
    """The number that the library has for a name."""
    if name not in names:
        raise ValueError(f"{kind} = {name!r}: must be one of {', '.join(names)}")
    return names[name]


def _series(t, y, sigma):
    """Equal-length float64 arrays and their pointers; the arrays must outlive the pointers."""
    if numpy.ndim(sigma) == 0 and sigma is not None:
        sigma = numpy.full(numpy.shape(t), float(sigma))
    arrays = [None if a is None else _plain(name, a) for name, a in (("t", t), ("y", y), ("sigma", sigma))]
    shapes = {a.shape for a in arrays if a is not None}
    if len(shapes) != 1 or arrays[0].ndim != 1:
        raise ValueError(f"t, y and sigma must be one-dimensional and of equal length, not {sorted(shapes)}")
    return arrays, [None if a is None else a.ctypes.data_as(_doubles) for a in arrays]


class Periodogram:
    """Lomb-Scargle periodogram on the grid f0 + k df, k < nf, that takes one sample at a time.

    time_offset and value_offset are subtracted exactly; |y - value_offset| must stay within value_bound, and sigma
    between sigma_floor and sigma_ceiling (by default 32 times, at most 1e8 times sigma_floor). The sums are exact: any
    order of pushes gives the same bits. With small sigmas give sigma_floor=min(sigma), sigma_ceiling=max(sigma).
    wide=True keeps all digits where sampling().narrow says that they are lost, as over small parts of a cycle.
    A grid that suits data of time span T and median step dt: f0 = 1.5/T, df = 0.1/T, nf = (0.5/dt - f0)/df.
    """

    def __init__(self, f0, df, nf, *, fit_mean=True, time_offset=0.0, value_offset=0.0, value_bound=2.0**20,
                 sigma_floor=1.0, sigma_ceiling=0.0, wide=False):
        self._handle = c_void_p()
        self.nf = operator.index(int(nf) if float(nf).is_integer() else nf)
        options = _Options()
        _options_init(byref(options), ctypes.sizeof(options))
        options.flags = (0 if fit_mean else _FIXED_MEAN) | (_WIDE if wide else 0)
        options.time_offset, options.value_offset = time_offset, value_offset
        options.value_bound = value_bound
        options.sigma_floor, options.sigma_ceiling = sigma_floor, sigma_ceiling
        self._sigma = sigma_floor
        check(_create(f0, df, self.nf, byref(options), byref(self._handle)))

    def push(self, t, y, sigma=None):
        """Adds one sample; without sigma it is unweighted."""
        check(_push(self._handle, t, y, self._sigma if sigma is None else sigma))

    def push_many(self, t, y, sigma=None):
        """Adds arrays of samples, all or none; sigma may be one number. Without it they are unweighted."""
        arrays, pointers = _series(t, y, sigma)
        check(_push_many(self._handle, *pointers, len(arrays[0])))

    def power(self, normalisation="standard"):
        """Power at every frequency, float64 array of length nf; normalised as standard, model, log or psd."""
        power = numpy.empty(self.nf)
        check(_query_power(self._handle, _number_of("normalisation", _NORMALISATIONS, normalisation), 0, self.nf,
                           power.ctypes.data_as(_doubles)))
        return power

    def peak(self):
        """Highest peak: frequency refined by a parabola, power and FAP of the highest grid point."""
        peak = Peak(struct_size=ctypes.sizeof(Peak))
        check(_query_peak(self._handle, byref(peak)))
        return peak

    def fit(self, t, y, sigma=None):
        """Highest peak refined by least squares on the samples that were pushed."""
        peak = Peak(struct_size=ctypes.sizeof(Peak))
        arrays, pointers = _series(t, y, sigma)
        check(_query_fit(self._handle, *pointers, len(arrays[0]), byref(peak)))
        return peak

    def log10_fap(self, log10_residual, method="baluev"):
        """log10 of the false alarm probability of a power P, given as log10(1 - P), on this grid.

        method: baluev, naive, single, or sequential for looking again and again while samples come in.
        """
        result = c_double()
        check(_query_fap(self._handle, _number_of("method", _FAPS, method), log10_residual, byref(result)))
        return result.value

    def level(self, log10_fap, method="baluev"):
        """log10(1 - P) of the power P that has this log10 of the false alarm probability."""
        result = c_double()
        check(_query_level(self._handle, _number_of("method", _FAPS, method), log10_fap, byref(result)))
        return result.value

    def bootstrap(self, t, y, sigma=None, *, count=1000, seed=0, threads=0):
        """log10(1 - P) of the highest peaks of `count` resamplings of the samples that were pushed, strongest first."""
        peaks = numpy.empty(count)
        options = _Bootstrap(struct_size=ctypes.sizeof(_Bootstrap), threads=threads, seed=seed)
        arrays, pointers = _series(t, y, sigma)
        check(_query_bootstrap(self._handle, *pointers, len(arrays[0]), byref(options), count,
                               peaks.ctypes.data_as(_doubles)))
        return peaks

    def sampling(self, t=None):
        """What the samples' times are worth, and whether the grid suits them; by the times pushed, if they are given."""
        result = Sampling(struct_size=ctypes.sizeof(Sampling))
        times = None if t is None else _plain("t", t)
        pointer = None if times is None else times.ctypes.data_as(_doubles)
        check(_query_sampling(self._handle, pointer, 0 if times is None else times.size, byref(result)))
        return result

    def save(self, path):
        """Writes all sums to a file, as a whole or not at all."""
        check(_save_file(self._handle, os.fsencode(path)))

    @classmethod
    def load(cls, path):
        """A periodogram from such a file; it goes on where the other stood."""
        self = cls.__new__(cls)
        self._handle = c_void_p()
        check(_load_file(os.fsencode(path), None, byref(self._handle)))
        info = _Info(struct_size=ctypes.sizeof(_Info))
        check(_get_info(self._handle, byref(info)))
        self.nf, self._sigma = info.nf, info.sigma_floor
        return self

    def __len__(self):
        return _count(self._handle)

    def close(self):
        """Frees the memory; the object is of no use afterwards."""
        _destroy(self._handle)
        self._handle = c_void_p()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def __del__(self):
        if getattr(self, "_handle", None):
            self.close()
