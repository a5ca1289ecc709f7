"""Units of members, columns and arguments, from their names and comments: "exposure_s" is in s.

Units are in the notation of astropy. Those of a series are not known here: "t" is the unit of its times, "y" that of
its values, and "date" is a time on its axis.
"""
from __future__ import annotations

import functools
import re

_SUFFIXES = {"px": "pix", "px2": "pix2", "deg": "deg", "arcsec": "arcsec", "mas": "mas", "uas": "uarcsec", "days": "d",
             "hours": "h", "minutes": "min", "years": "yr", "year": "yr", "s": "s", "ns": "ns", "nm": "nm", "m": "m",
             "m2": "m2", "km": "km", "m_s": "m / s", "photons": "photon"}
_SUFFIX = re.compile(rf"(?:^|.*?_)({'|'.join(sorted(_SUFFIXES, key=len, reverse=True))})$")
_RATE = re.compile(r"(.+)_per_([a-z]+)$")
_COMMENTS = {"solar masses": "solMass", "photons per pixel": "photon / pix"}
_NAMES = {"t": "date", "epoch": "date", "time_reference": "date", "time_offset": "date", "period": "t", "tau": "t",
          "step": "t", "baseline": "t", "interval": "t", "fwhm_period": "t", "half_width_period": "t",
          "frequency": "1/t", "f0": "1/t", "df": "1/t", "coarsest_df": "1/t", "fwhm": "1/t", "nyquist": "1/t",
          "y": "y", "sigma": "y", "value": "y", "amplitude": "y", "offset": "y", "jitter": "y", "rms": "y",
          "upper": "y", "detectable": "y", "phase": "rad"}


_LABELS = {"d": "days", "uarcsec": "µas", "uas": "µas", "pix": "px"}


def label_of(unit: str, otherwise: str) -> str:
    """Returns a unit as plots name it. otherwise: name of the unit "", which is not known."""
    return _LABELS.get(unit, unit.replace(" / ", "/")) or otherwise


@functools.lru_cache(maxsize=None)
def unit_of_name(name: str) -> str:
    """Returns the unit at the end of a name; "": there is none, or as of covariances several."""
    if name.startswith("cov_"):
        return ""
    if name.startswith("d_"):  # a derivative of the separation by an element
        below = unit_of_name(name[2:])
        return f"arcsec / {below}" if below not in ("", "arcsec") else ""
    rate = _RATE.fullmatch(name)
    if rate:
        above, below = unit_of_name(rate[1]), _SUFFIXES.get(rate[2], "")
        return f"{above or '1'} / {below}" if below else ""
    found = _SUFFIX.fullmatch(name)
    return _SUFFIXES[found[1]] if found else ""


def unit_of_member(name: str, doc: str) -> str:
    """Returns the unit of a member of a result, from its name or its comment; "": it has none, or none is known."""
    stated = next((unit for words, unit in _COMMENTS.items() if words in doc), "")
    return unit_of_name(name) or stated or _NAMES.get(re.sub("_(error|min|max)$", "", name), "")
