"""Python bindings of libtoliman: simulate TOLIMAN frames, estimate the separation, search for the planet's period.

Data flow: scene -> frames -> separations -> period -> planets. One call for each step, with the defaults of the program:

    import toliman

    times, _, frames = toliman.simulate("sky.json", count=100)     # a shipped scene, a path or a dict
    toliman.calibrate("sky.json", frames[:20], times_days=times[:20]).save("fitted.json")
    tracker = toliman.track("fitted.json", frames, times, folder="mission")
    found = toliman.planets("mission")

Stars at rest are measured by a network; any series has a period:

    simulator = toliman.Simulator("chapter.json", progress=True)
    network = toliman.CAE(simulator)
    network.train()
    times, _ = simulator.series()                                  # days
    latents = network.encode(simulator.frame(k) for k in range(len(times)))
    toliman.period(times, latents).plot()

Conventions
    Images are numpy arrays [row][column] of float64; row 0 and column 0 are the most negative coordinates. Separations
    are in detector pixels; a positive displacement increases the separation.
    Times are in any unit, or dates (see below); no barycentric correction is applied. Frequencies are f0 + k df in cycles per unit of t.
    Weights are 1/sigma**2. The power is astropy's "standard" normalisation, in [0, 1] and never NaN.
    threads=0 uses one thread per processor. The number of threads never changes a result.
    Results are frozen dataclasses; print() and notebooks show them as tables.

Dates and units
    Times may be datetime, datetime64 of numpy, both in UTC, or Time of astropy, in any scale: they become Modified Julian
    Days (MJD) of TAI, in days, which resolve 0.6 us. A datetime without time zone is taken as UTC. A Quantity of astropy
    becomes days. astropy.time.Time(mjd, format="mjd", scale="tai") converts back. datetime and datetime64 have no leap
    seconds: the second 23:59:60 equals the second after it.
    Numbers whose name ends in a unit (exposure_s), periods of a series in days and angles may be a Quantity, which is
    converted; all others refuse one.
    Values may be a Quantity, then their sigma too. period() and batch() compute in the unit of the values, a Periodogram in
    that of its first sample, in which results are. Frequencies are cycles per day then.

Plots
    plot() of a Peak, a Periodogram, Measurements and others draws with matplotlib: in a new figure of pyplot, or with
    plot(ax=axes) on axes of yours, in your style. They return the Axes; those that make several, the Figure.

Tables
    to_table() gives an astropy Table with units and descriptions, to_pandas() a DataFrame, of series, periodograms,
    calibrations, planets, trackers, results, and of the arrays and lists of results that methods return. table.write()
    then writes ECSV or FITS. Rows(results) makes such a list of your own. Measurements.of_table() reads tables.

Errors
    A failed library call raises a subclass of toliman.Error with the library's message. Each is also a Python
    exception: InputError a ValueError, NotFoundError a FileNotFoundError, WriteError and LostError an OSError,
    NoMemoryError a MemoryError, StateError a RuntimeError, UnsupportedError a NotImplementedError. Arguments that
    cannot be converted for C (wrong shape, masked values, units, unknown words) raise ValueError or TypeError.

Long calls
    progress=True shows a progress bar; a function of (stage, fraction) is called instead and cancels the call by
    returning a true value. Ctrl-C cancels too. The object stays usable.

Diagnostic messages of the library go to Python's logging, logger "toliman". Objects are destroyed by close(), by a with
statement or by the garbage collector. toliman._raw has every C function, struct and constant by its name. The
environment variable TOLIMAN_LIBRARY selects another libtoliman.so.
"""
import importlib
import typing

if typing.TYPE_CHECKING:
    from ._public import *
    from ._public import __all__, __version__


def __getattr__(name: str) -> typing.Any:
    """Loads libtoliman and all public names at the first use of one of them; toliman.report needs them for
    folders of run and pupil only."""
    if name != "report" and (not name.startswith("_") or name in ("__all__", "__version__")):
        public = importlib.import_module("._public", __name__)
        globals().update({known: getattr(public, known) for known in ("__all__", "__version__", *public.__all__)})
        if name in globals():
            return globals()[name]
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return list(__getattr__("__all__"))
