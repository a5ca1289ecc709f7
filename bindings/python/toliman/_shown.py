"""How objects that are not results appear: repr() in one line, and a table of their members in a notebook."""
from __future__ import annotations

import dataclasses
import html
import typing

import numpy

LONGEST = 120  # characters of a line


def public_name(kind: type) -> str:
    """Returns the name of a class, of a private one that of its public base."""
    return next(one.__name__ for one in kind.__mro__ if not one.__name__.startswith("_"))


def brief(value: typing.Any) -> str:
    """Returns a value in a few characters: of an array, its shape and type."""
    if isinstance(value, numpy.ndarray):
        return f"<{'x'.join(map(str, value.shape))} {'fields' if value.dtype.names else value.dtype}>"
    if isinstance(value, (list, tuple, dict)) and len(value) > 4:
        return f"<{len(value)} values>"
    if isinstance(value, (list, tuple)):
        return f"({', '.join(map(brief, value))})"
    if isinstance(value, (float, numpy.floating)):
        return f"{value:.6g}"
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:56]}...{text[-1]}"


def members_of(thing: typing.Any) -> dict[str, typing.Any]:
    """Returns the members of a dataclass or a NamedTuple."""
    names = [field.name for field in dataclasses.fields(thing)] if dataclasses.is_dataclass(thing) else thing._fields
    return {name: getattr(thing, name) for name in names}


def brief_repr(thing: typing.Any) -> str:
    """Returns the first members of an object, as many as fit in a line."""
    text = f"{type(thing).__name__}("
    for place, (name, value) in enumerate(members_of(thing).items()):
        member = f"{', ' if place else ''}{name}={brief(value)}"
        if place and len(text + member) > LONGEST - len(", ...)"):
            return text + ", ...)"
        text += member
    return text + ")"


def html_table(caption: str, rows: typing.Iterable[tuple[str, ...]]) -> str:
    """Returns a table with the first column as its heads."""
    left = "style='text-align:left'"
    cells = ("".join([f"<th {left}>{html.escape(head)}</th>", *(f"<td>{html.escape(text)}</td>" if not place else
                      f"<td {left}>{html.escape(text)}</td>" for place, text in enumerate(texts))])
             for head, *texts in rows)
    return f"<table><caption>{html.escape(caption)}</caption>{''.join(f'<tr>{row}</tr>' for row in cells)}</table>"


def members_html(thing: typing.Any) -> str:
    """Returns the members of an object as a table."""
    return html_table(type(thing).__name__, ((name, brief(value)) for name, value in members_of(thing).items()))


Kind = typing.TypeVar("Kind", bound=type)


def documented(**docs: str) -> typing.Callable[[Kind], Kind]:
    """Sets the comments of the members of a NamedTuple, which help() shows."""
    def set_docs(kind: Kind) -> Kind:
        for name, doc in docs.items():
            getattr(kind, name).__doc__ = doc
        return kind
    return set_docs


class Shown:
    """Base class of dataclasses with repr=False."""

    def __repr__(self) -> str:
        return brief_repr(self)

    def _repr_html_(self) -> str:
        return members_html(self)
