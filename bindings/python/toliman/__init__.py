"""libtoliman for Python: scene -> frames -> latent -> period, over ctypes and numpy.

    from toliman import CAE, Periodogram, Simulator, suited_grid

    simulator = Simulator("chapter.json", progress=True)       # or a dict, or a file of your own
    network = CAE(simulator)
    network.train()
    times, _ = simulator.series()
    with Periodogram(*suited_grid(times)) as periodogram:
        for k, t in enumerate(times):
            periodogram.push(t, network.encode(simulator.frame(k)))
        print(periodogram.peak())

Images are numpy arrays [row][column] of float64; results are frozen dataclasses, which print and notebooks show as
tables. Frequencies are f0 + k df in cycles per unit of t; weights are 1/sigma**2; the power is astropy's "standard",
between 0 and 1, never NaN. A failed call raises toliman.Error with the library's message; InputError is also a
ValueError, NotFoundError a FileNotFoundError, and so on. Arguments that cannot reach the library, as wrong shapes, masked
values, units and words, raise ValueError or TypeError. Ctrl-C and what is given as `progress` stop long work, which stays usable.
Remarks of the library go to Python's logging under the name "toliman". Objects free themselves, or by `with`.

toliman._raw has every function and struct of C by its name. TOLIMAN_LIBRARY is the path of another libtoliman.so.
"""
from ._library import (Cancelled, CapacityError, Error, InputError, LostError, NoMemoryError, NotFoundError, StateError,
                       UnsupportedError, WriteError, abi_version, library_path, version)
from ._results import (ComponentsInfo, ComponentsTraining, Machine, Model, NetworkInfo, Outcome, PeriodogramInfo, Plan,
                       Sampling, SceneInfo, Stream, TrackInfo, Training)
from .cae import CAE, Reconstruction
from .linear import Components, Template
from .machine import blas_speed, machine
from .periodogram import AccuracyWarning, Grid, Peak, Periodogram, batch, period, suited_grid
from .sim import Simulator, Spectrum, plan, shipped_scenes
from .track import REASONS, VERDICTS, Estimate, Frame, Tracker

__version__ = version()
__all__ = [
    "AccuracyWarning", "CAE", "Cancelled", "CapacityError", "Components", "ComponentsInfo", "ComponentsTraining",
    "Error", "Estimate", "Frame", "Grid", "InputError", "LostError", "Machine", "Model", "NetworkInfo", "NoMemoryError",
    "NotFoundError", "Outcome", "Peak", "Periodogram", "PeriodogramInfo", "Plan", "REASONS", "Reconstruction", "Sampling",
    "SceneInfo", "Simulator", "Spectrum", "StateError", "Stream", "Template", "TrackInfo", "Tracker", "Training",
    "UnsupportedError", "VERDICTS", "WriteError", "abi_version", "batch", "blas_speed", "library_path", "machine",
    "period", "plan", "shipped_scenes", "suited_grid", "version",
]
