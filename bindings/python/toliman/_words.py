"""C's numbered choices by their words, as the headers name them."""
from __future__ import annotations

import functools

from . import _raw


@functools.lru_cache(maxsize=None)
def words(first: str) -> tuple[str, ...]:
    """The words of the constants from `first` on, numbered 0, 1, ...: TOLIMAN_UNIT_PHOTON -> photon, electron, dn."""
    prefix, names = first[: first.rindex("_") + 1], list(vars(_raw))
    found: list[str] = []
    for name in names[names.index(first):]:
        if not name.startswith(prefix) or getattr(_raw, name) != len(found):
            break
        found.append(name[len(prefix):].lower())
    return tuple(found)


def number(argument: str, word: str, first: str) -> int:
    """The number of a word that somebody gave for an argument."""
    if word not in words(first):
        raise ValueError(f"{argument} = {word!r}: must be one of {', '.join(words(first))}")
    return words(first).index(word)
