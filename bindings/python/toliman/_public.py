"""The public names of the package; importing this module loads libtoliman."""
from ._library import (Cancelled, CapacityError, Error, InputError, LostError, NoMemoryError, NotFoundError, StateError,
                       UnsupportedError, WriteError, abi_version, library_path, netcdf_version, version)
from ._results import (Alias, BankInfo, BankNetwork, BankPlan, BankResult, Bounds, BudgetRow, BudgetStep, BudgetSummary,
                       CalibrationInfo, CalibrationStep, CalibrationValue, CalibrationWindow, CoaddInfo, CoaddOutcome, CoaddSum,
                       ComponentsInfo,
                       ComponentsTraining, Diagnosis, FitInfo, FitResult, FolderGoodness, FrameGoodness, HeaderTime, Hypothesis,
                       Machine, MaskInfo, MeasureFunction, MeasureInfo, Model, NetworkInfo, Outcome, PairInfo, Parameter, PeriodogramInfo, Plan, PlanetInfo,
                       PlanetLimit, Record, Refit, Sampling,
                       SceneInfo, SkyInfo, SkyPrediction, Stream, TrackInfo, Training)
from .bank import Bank
from .budget import Budget
from .cae import CAE, Reconstruction
from .calibration import Calibration, calibrate
from ._goodness import FitWarning
from ._spread import Spread
from ._table import Records, Rows
from .coadd import Coadd
from .fit import Fit
from .ingest import Pair, PairEvent
from .linear import Components, Template
from .machine import machine
from .mask import DesignedMask, design_mask
from .measure import Measurements
from .noise import NoiseSearch, bootstrap_correlated, search_correlated
from .periodogram import AccuracyWarning, Grid, Peak, Periodogram, batch, period, suited_grid
from .planet import Planet, Planets, planets
from .sim import Series, Simulated, Simulator, Spectrum, parameters, plan, shipped_scenes, simulate
from .sky import Sky
from .times import parse_time, read_clock, read_header, read_on_target
from .tracker import REASONS, VERDICTS, Estimate, Frame, Tracker
from ._track import FrameWarning, track


__version__ = version()
__all__ = [
    "AccuracyWarning", "Alias", "Bank", "BankInfo", "BankNetwork", "BankPlan", "BankResult", "Bounds", "Budget", "BudgetRow",
    "BudgetStep", "BudgetSummary", "CAE", "Calibration", "CalibrationInfo", "CalibrationStep", "CalibrationValue",
    "CalibrationWindow", "Cancelled", "CapacityError",
    "Coadd", "CoaddInfo", "CoaddOutcome", "CoaddSum", "Components", "ComponentsInfo", "ComponentsTraining", "DesignedMask", "Diagnosis", "Error", "Estimate", "Fit", "FitInfo", "FitResult",
    "FitWarning", "FolderGoodness", "Frame", "FrameGoodness", "FrameWarning", "Grid", "HeaderTime", "Hypothesis",
    "InputError", "LostError", "Machine", "MaskInfo", "MeasureFunction", "MeasureInfo", "Measurements", "Model", "NetworkInfo", "NoiseSearch", "NoMemoryError", "NotFoundError", "Outcome",
    "Pair", "PairEvent", "PairInfo", "Parameter", "Peak", "Periodogram", "PeriodogramInfo", "Plan", "Planet", "PlanetInfo", "PlanetLimit",
    "Planets", "REASONS", "Reconstruction", "Record", "Records", "Refit", "Rows",
    "Sampling", "SceneInfo", "Series", "Simulated", "Simulator", "Sky", "SkyInfo", "SkyPrediction", "Spectrum", "Spread", "StateError", "Stream", "Template", "TrackInfo", "Tracker",
    "Training", "UnsupportedError", "VERDICTS", "WriteError", "abi_version", "batch", "bootstrap_correlated", "calibrate", "design_mask", "library_path", "netcdf_version",
    "machine", "parameters", "parse_time", "period", "plan", "planets", "read_clock", "read_header", "read_on_target", "search_correlated", "shipped_scenes", "simulate", "suited_grid", "track",
    "version",
]
