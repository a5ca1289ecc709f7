"""Networks that follow moving stars: one for each of several dates and sub-pixel places. Reference:
include/toliman/bank.h."""
from __future__ import annotations

import ctypes
import functools
import os
import typing

from numpy.typing import ArrayLike

from . import _raw
from ._arguments import array_of, file_name, load_options, of_kind, options_of, real, saved, whole
from ._goodness import warn_of
from ._handle import Handle
from ._library import check, library
from ._pixels import Frames, frame_of
from ._predictions import Predictions, joined, prediction_of, structured
from ._progress import Progress, Watch
from ._results import BankInfo, BankNetwork, BankPlan, BankResult, FitResult
from ._table import Records, Rows
from ._words import number
from .cae import layout_number
from .fit import Fit
from .sim import Scene, Simulator, simulator_of


class Bank(Handle):
    """A bank of networks. Each frame is fitted, and encoded by the network whose places of the stars are nearest.

        simulator = Simulator("sky.json")
        fit = Fit(simulator)
        print(Bank.plan(simulator))                                # number of networks, bytes, seconds
        bank = Bank(fit)                                           # random weights
        bank.train()
        results, fits = bank.encode(frames, times_days=times)      # structured arrays, results["displacement_px"]
        bank.save("bank.tlmb")
        bank = Bank.load("bank.tlmb", fit)

    fit: Fit of the scene. The bank uses it for every frame.
    layout: as of CAE; "paper" has an efficiency of 0.015.
    first_days, last_days: range of the frames' times in days of scene time, whose time 0 is binary.date of the scene;
        both 0: the times of the scene's frames.
    spacing_px: largest change of the place of B relative to A from one date to the next; 0 means 0.5.
    places: sub-pixel places along x and along y; 0 means 3.
    steps: steps of the training of each network; 0 means 600.
    seed: seed of the initial weights; 0 means 1.
    threads: number of worker threads of encode(); 0 means one per processor.

    The displacement is the separation minus its prediction. The prediction is made by time_days, shift, separation and
    position_angle, as in Fit. The efficiency is the Cramer-Rao bound divided by the standard deviation of the
    separation. An untrained network also encodes, as a control, with an efficiency of about 0.01.

    Raises InputError for options out of range, UnsupportedError for frames smaller than 256x256 or larger than
    4096x4096.
    """

    _kind, _destroy = _raw.toliman_bank, "toliman_bank_destroy"

    def __init__(self, fit: Fit, *, layout: str | None = None, first_days: float = 0, last_days: float = 0,
                 spacing_px: float = 0, places: int = 0, steps: int = 0, seed: int = 0, threads: int = 0):
        of_kind("fit", fit, Fit)
        options = _options(layout, first_days, last_days, spacing_px, places, steps, seed)
        options.threads = whole("threads", threads, 2**32)
        super().__init__(self._create(library.toliman_bank_create, fit._c, ctypes.byref(options)))
        self.fit = fit

    @staticmethod
    def plan(simulator: Simulator | Scene, *, layout: str | None = None, first_days: float = 0, last_days: float = 0,
             spacing_px: float = 0, places: int = 0, steps: int = 0) -> BankPlan:
        """Returns size and cost of the bank with these options, which are those of Bank()."""
        simulator = simulator_of("simulator", simulator)
        options, found = _options(layout, first_days, last_days, spacing_px, places, steps, 0), _raw.toliman_bank_plan_info()
        check(library.toliman_bank_plan(simulator._c, ctypes.byref(options), ctypes.byref(found)))
        return BankPlan._of(found)

    @property
    def info(self) -> BankInfo:
        """Properties of the bank."""
        return self._read(library.toliman_bank_get_info, _raw.toliman_bank_info, BankInfo)

    @property
    def networks(self) -> Rows[BankNetwork]:
        """The networks by date, then place along y, then place along x."""
        found: Rows[BankNetwork] = Rows()
        for index in range(self.info.networks):
            network = _raw.toliman_bank_network()
            check(library.toliman_bank_get_network(self._c, index, ctypes.byref(network)))
            found.append(BankNetwork._of(network))
        return found

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of the input frames."""
        info = self.info
        return info.rows, info.cols

    def train(self, *, threads: int = 0, progress: Progress | bool | None = None,
              journal: str | os.PathLike[str] | None = None) -> None:
        """Trains the networks that are not trained yet.

        journal: file to which each network is appended once it is trained. If it exists, its networks are not trained
        again: a killed program continues. Remove it once the bank is saved.

        Ctrl-C, and a progress function that raises or returns a true value, cancel the training. Networks that were
        trained before remain so; a later call continues. Raises Cancelled.
        """
        with self._exclusive(), Watch(progress) as watch:
            options = options_of(_raw.toliman_bank_train_options,
                                 threads=whole("threads", threads, 2**32), progress=watch.callback,
                                 journal=None if journal is None else file_name(journal))
            watch.check(library.toliman_bank_train(self._c, self.fit._c, ctypes.byref(options)))

    def encode_frame(self, frame: ArrayLike, *, time_days: typing.Any = None, shift: tuple[float, float] = (0, 0),
                     separation: float = 0, position_angle: float = 0,
                     window: ArrayLike | None = None) -> tuple[BankResult, FitResult]:
        """Encodes one frame [row][column]. Returns the result of the network and that of the fit. The prediction is as
        in Fit. Raises InputError if the bank was made for another fit."""
        image, _ = frame_of("frame", frame, self.shape, window)
        result, fitted = _raw.toliman_bank_result(), _raw.toliman_fit_result()
        prediction = prediction_of(self.fit._days("time_days", time_days, separation), shift, separation, position_angle)
        check(library.toliman_bank_encode(self._c, self.fit._c, ctypes.byref(image), 1, ctypes.byref(prediction),
                                          ctypes.byref(result), ctypes.byref(fitted)))
        warn_of(structured((_raw.toliman_bank_result * 1)(result)), stacklevel=3)
        return BankResult._of(result), FitResult._of(fitted)

    def encode(self, frames: ArrayLike, *, times_days: typing.Any = None, shifts: ArrayLike = (0, 0),
               separations: ArrayLike = 0, position_angles: ArrayLike = 0, windows: ArrayLike | None = None,
               progress: Progress | bool | None = None) -> tuple[Records, Records]:
        """Encodes frames [frame][row][column] of any pixel type, with windows as in CAE.encode. The predictions are one number (shifts: one pair) for
        all frames, or one per frame. Returns two structured arrays: a field for each member of toliman_bank_result, whose
        `flags` are the bits TOLIMAN_BANK_..., and the results of the fits, as Fit.frames()."""
        given = self.fit._days("times_days", times_days, separations), shifts, separations, position_angles
        source = Frames(frames, self.shape, *Predictions.lengths(*given), windows=windows)
        predictions = Predictions(source.count, *given)
        blocks: list[tuple[typing.Any, int]] = []
        of_fits: list[tuple[typing.Any, int]] = []
        with Watch(progress) as watch:
            for first, image, count in source.images(watch):
                results, fits = array_of(_raw.toliman_bank_result, count), array_of(_raw.toliman_fit_result, count)
                watch.check(library.toliman_bank_encode(self._c, self.fit._c, image, count, predictions.block(first, count),
                                                        results, fits))
                blocks.append((results, count))
                of_fits.append((fits, count))
                watch.step("encode", source.share(first + count))
        found, fitted = joined(blocks, _raw.toliman_bank_result), joined(of_fits, _raw.toliman_fit_result)
        warn_of(found, stacklevel=3)
        return found, fitted

    def predict(self, *, time_days: float = 0, shift: tuple[float, float] = (0, 0), separation: float = 0,
                position_angle: float = 0) -> BankResult:
        """Returns the result of a frame without noise whose stars are at the predicted places: network, efficiency and
        sigma_px. Its displacement_px is 0."""
        found = _raw.toliman_bank_result()
        prediction = prediction_of(time_days, shift, separation, position_angle)
        check(library.toliman_bank_predict(self._c, self.fit._c, ctypes.byref(prediction), ctypes.byref(found)))
        return BankResult._of(found)

    def renewal(self, least_efficiency: float = 0.95) -> float:
        """Returns until when the bank can be used, in days of scene time: the first of the times 1, 2, 3, ... days
        after its last date at which the efficiency is below least_efficiency or the stars leave the model images of
        the fit."""
        days = ctypes.c_double()
        check(library.toliman_bank_get_renewal(self._c, self.fit._c, real("least_efficiency", least_efficiency),
                                               ctypes.byref(days)))
        return days.value

    def save(self, path: str | os.PathLike[str], *, encoding: str = "float32") -> None:
        """Writes the bank to a file, atomically. encoding of the weights: "float32" (exact), "bf16" or "fp16"."""
        check(library.toliman_bank_save_file(self._c, _encoding(encoding), file_name(path)))

    def to_bytes(self, *, encoding: str = "float32") -> bytes:
        """Returns the contents of a file written by save() with the same encoding."""
        return saved(functools.partial(library.toliman_bank_save, self._c, _encoding(encoding)))

    @classmethod
    def load(cls, path: str | os.PathLike[str], fit: Fit, *, threads: int = 0) -> Bank:
        """Loads a bank from a file written by save(). fit: Fit of the same scene with the same options as that of the
        saved bank. With any other fit, the first use of the bank raises InputError."""
        return cls._with_fit(fit, threads, library.toliman_bank_load_file, file_name(path))

    @classmethod
    def from_bytes(cls, content: bytes, fit: Fit, *, threads: int = 0) -> Bank:
        """Loads a bank from the bytes returned by to_bytes(). fit: as for load()."""
        content = memoryview(content).tobytes()
        return cls._with_fit(fit, threads, library.toliman_bank_load, content, len(content))

    @classmethod
    def _with_fit(cls, fit: Fit, threads: int, load: typing.Any, *source: typing.Any) -> Bank:
        of_kind("fit", fit, Fit)
        bank = cls._adopt(cls._create(load, *source, load_options(threads)))
        bank.fit = fit
        return bank

    def _summary(self) -> str:
        info = self.info
        return (f"Bank of {info.networks} networks of layout {info.layout} for {info.rows}x{info.cols} frames, "
                f"{info.trained_networks} trained")


def _options(layout: str | None, first_days: float, last_days: float, spacing_px: float, places: int, steps: int,
             seed: int) -> typing.Any:
    return options_of(_raw.toliman_bank_options,
                      layout=layout_number(layout), first_days=real("first_days", first_days),
                      last_days=real("last_days", last_days), spacing_px=real("spacing_px", spacing_px),
                      places=whole("places", places, 2**32), steps=whole("steps", steps, 2**32),
                      seed=whole("seed", seed, 2**64))


def _encoding(word: str) -> int:
    return number("encoding", word, "TOLIMAN_CAE_ENCODING")
