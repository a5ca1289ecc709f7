"""Base of the result classes: frozen dataclasses filled from C structs, printed and displayed as tables."""
from __future__ import annotations

import dataclasses
import html
import typing

from ._words import words as words_of


def member(doc: str, *, words: str = "", flag: int = 0) -> typing.Any:
    """Declares a documented member. words: prefix of the enumeration whose constants the member holds as words; flag:
    the bit of the struct's `flags` that a bool member reports."""
    if words:
        doc = doc.replace("...", ", ".join(words_of(words).values()))
    return dataclasses.field(metadata={"doc": doc, "words": words, "flag": flag})


def result(kind: type) -> type:
    """Makes a frozen dataclass of a class and lists its members in the docstring."""
    kind = dataclasses.dataclass(frozen=True, repr=False)(kind)
    lines = [f"    {field.name} ({field.type}): {field.metadata.get('doc', '')}".rstrip(": ")
             for field in dataclasses.fields(kind)]
    kind.__doc__ = f"{kind.__doc__}\n\n" + "\n".join(lines)
    return kind


def _text(value: typing.Any) -> str:
    return f"{value:.9g}" if isinstance(value, float) else str(value)


class Result:
    """Base class of results."""

    @classmethod
    def _of(cls, struct: typing.Any):
        """Converts a C struct with members of the same names."""
        return cls(*(cls._member(field, struct) for field in dataclasses.fields(cls)))

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
        members = (f"{field.name}={getattr(self, field.name)!r}" for field in dataclasses.fields(self))
        return f"{type(self).__name__}({', '.join(members)})"

    def __str__(self) -> str:
        fields = dataclasses.fields(self)
        width = max(len(field.name) for field in fields)
        return "\n".join(f"{field.name:<{width}}  {_text(getattr(self, field.name))}" for field in fields)

    def _repr_html_(self) -> str:
        left = "style='text-align:left'"
        rows = "".join(f"<tr><th {left}>{field.name}</th><td>{html.escape(_text(getattr(self, field.name)))}</td>"
                       f"<td {left}>{html.escape(field.metadata.get('doc', ''))}</td></tr>"
                       for field in dataclasses.fields(self))
        return f"<table><caption>{type(self).__name__}</caption>{rows}</table>"
