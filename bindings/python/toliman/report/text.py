"""Numbers as text: two digits of every error, powers of ten, the unknown as a dash."""
from __future__ import annotations

import math
import typing

UNKNOWN = "–"
MINUS = "−"
LOG_FAP = "log₁₀ FAP"
UNITS = {"photon": "photons", "electron": "electrons", "dn": "DN"}  # of frames
_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def raised(exponent: int) -> str:
    """Returns 10 with the exponent raised, such as 10⁻⁶."""
    return "10" + str(exponent).translate(_RAISED)


def exponential(value: float, digits: int = 3) -> str:
    """Returns 1.23 × 10⁻⁶."""
    if not math.isfinite(value) or value == 0:
        return UNKNOWN if value != 0 else "0"
    mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
    return mantissa.replace("-", MINUS) + " × " + raised(int(exponent))


def scientific(value: float, digits: int = 3) -> str:
    """Returns a power of ten only for numbers below 0.001 or with more than `digits` digits before the point."""
    exponent = int(f"{value:.{digits - 1}e}".split("e")[1]) if math.isfinite(value) else digits
    if value == 0 or -3 <= exponent < digits:
        return f"{value:.{digits}g}".replace("-", MINUS)
    return exponential(value, digits)


def fixed(value: float, decimals: int) -> str:
    """Returns a number with so many decimals."""
    if not math.isfinite(value):
        return UNKNOWN
    return f"{round(value, decimals) + 0.0:.{decimals}f}".replace("-", MINUS)


def decimals_of(error: float, unknown: int = 2) -> int:
    """Returns the decimals that show two digits of an error; `unknown` if there is none."""
    if not (math.isfinite(error) and error > 0):
        return unknown
    return max(0, min(15, 1 - int(f"{error:.1e}".split("e")[1])))


def with_error(value: float, error: float) -> str:
    """Returns 363.1 ± 3.1."""
    decimals = decimals_of(error)
    return fixed(value, decimals) + " ± " + fixed(error, decimals)


def scaled(value: float, error: float) -> str:
    """Returns (1.10 ± 0.05) × 10⁻⁶."""
    if not (math.isfinite(value) and value != 0):
        return UNKNOWN
    exponent = math.floor(math.log10(abs(value)))
    return f"({with_error(value / 10.0**exponent, error / 10.0**exponent)}) × {raised(exponent)}"


def short_unit(values: typing.Iterable[float], unit: str) -> tuple[float, str]:
    """Returns a factor that makes the largest of the values 1 to 999, and the unit with the power of ten."""
    most = max((abs(value) for value in values if math.isfinite(value)), default=0.0)
    exponent = 3 * math.floor(math.log10(most) / 3) if most > 0 else 0
    return 10.0**-exponent, f"{raised(exponent)} {unit}" if exponent else unit


def significant(log10_fap: float) -> bool:
    """Whether a peak counts as a period that was found, as `toliman run` decides it."""
    return log10_fap <= -2
