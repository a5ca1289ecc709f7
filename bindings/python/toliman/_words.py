"""C's numbered choices by their words, as the headers name them."""
from __future__ import annotations

import functools

from . import _raw


@functools.lru_cache(maxsize=None)
def words(enumeration: str) -> dict[int, str]:
    """The words of its constants by their numbers: TOLIMAN_SIM_UNIT -> 301: photon, 302: electron, 303: dn."""
    prefix = enumeration + "_"
    return {value: name[len(prefix):].lower() for name, value in vars(_raw).items() if name.startswith(prefix)}


def number(argument: str, word: str, enumeration: str) -> int:
    """The number of a word that somebody gave for an argument."""
    for known, name in words(enumeration).items():
        if name == word:
            return known
    raise ValueError(f"{argument} = {word!r}: must be one of {', '.join(words(enumeration).values())}")
