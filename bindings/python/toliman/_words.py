"""Maps the enumerations of C to words, the lower-case ends of the constants' names, and back."""
from __future__ import annotations

import functools

from . import _raw


@functools.lru_cache(maxsize=None)
def words(enumeration: str) -> dict[int, str]:
    """Words of an enumeration by value: TOLIMAN_SIM_UNIT gives {301: "photon", 302: "electron", 303: "dn"}."""
    prefix = enumeration + "_"
    found = {value: name[len(prefix):].lower() for name, value in vars(_raw).items() if name.startswith(prefix)}
    # The words of toliman_constant_name, as in files.
    return {value: name.replace("_", " ") for value, name in found.items()} if enumeration in ("TOLIMAN_GOODNESS", "TOLIMAN_PERIOD_INTERVAL") else found


def number(argument: str, word: str, enumeration: str) -> int:
    """Value of the constant that a word names; ValueError names the argument and lists the words."""
    for known, name in words(enumeration).items():
        if name == word:
            return known
    raise ValueError(f"{argument} = {word!r}: must be one of {', '.join(words(enumeration).values())}")
