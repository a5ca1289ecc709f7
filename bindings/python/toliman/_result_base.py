"""Base of the result classes: frozen dataclasses filled from C structs, printed and displayed as tables."""
from __future__ import annotations

import dataclasses
import typing

from ._shown import brief_repr, html_table
from ._table import Column, Rows, Tabular, Units, text_of
from ._words import words as words_of


def member(doc: str, *, words: str = "", flag: int = 0) -> typing.Any:
    """Declares a documented member. words: prefix of the enumeration whose constants the member holds as words; flag:
    the bit of the struct's `flags` that a bool member reports."""
    if words:
        known = ", ".join(words_of(words).values())
        doc = doc.replace("...", known) if "..." in doc else f"{known}; {doc}" if doc else known
    return dataclasses.field(metadata={"doc": doc, "words": words, "flag": flag})


def result(kind: type) -> type:
    """Makes a frozen dataclass of a class and lists its members in the docstring."""
    kind = dataclasses.dataclass(frozen=True, repr=False)(kind)
    lines = [f"    {field.name} ({field.type}): {field.metadata.get('doc', '')}".rstrip(": ")
             for field in dataclasses.fields(kind)]
    kind.__doc__ = f"{kind.__doc__}\n\n" + "\n".join(lines)
    return kind


class Result(Tabular):
    """Base class of results. In a table, a result is one row."""

    _units: typing.ClassVar[Units] = {}  # of the series of the result, as of column_of()

    def _columns(self) -> dict[str, Column]:
        return Rows([self])._columns()

    @classmethod
    def _of(cls, struct: typing.Any, units: Units = {}):
        """Converts a C struct with members of the same names. units: of the series of the result."""
        made = cls(*(cls._member(field, struct) for field in dataclasses.fields(cls)))
        if any(units.values()):
            object.__setattr__(made, "_units", units)
        return made

    @staticmethod
    def _member(field: dataclasses.Field, struct: typing.Any) -> typing.Any:
        if field.metadata.get("flag"):
            return bool(struct.flags & field.metadata["flag"])
        value = getattr(struct, field.name)
        if field.metadata.get("words"):
            return words_of(field.metadata["words"]).get(value, str(value))  # a newer library's constant: its number
        if field.type == "bool":
            return bool(value)
        if field.type == "str":
            return value.decode() if value is not None else ""  # NULL: there is none
        return value if field.type in ("int", "float") else tuple(value)

    def __repr__(self) -> str:
        return brief_repr(self)

    def __str__(self) -> str:
        fields = dataclasses.fields(self)
        width = max(len(field.name) for field in fields)
        return "\n".join(f"{field.name:<{width}}  {text_of(getattr(self, field.name))}" for field in fields)

    def _repr_html_(self) -> str:
        return html_table(type(self).__name__, ((field.name, text_of(getattr(self, field.name)),
                                                 field.metadata.get("doc", "")) for field in dataclasses.fields(self)))
