"""Tables of everything that has rows: to_table() of astropy, to_pandas(), and the table that a notebook shows."""
from __future__ import annotations

import dataclasses
import html
import typing

import numpy
from numpy.typing import NDArray

from ._optional import optional
from ._shown import public_name
from ._units import unit_of_member
from ._words import words as words_of

_ROWS_SHOWN = 20
_GPS_DAYS = 19 / 86400  # TAI - GPS
Units = typing.Mapping[str, str]


class Column(typing.NamedTuple):
    """A column: one value, or one array, for each row. unit: of astropy; doc: description; scale: of times that are
    Modified Julian Days, "": the values are no dates."""

    values: typing.Any
    unit: str = ""
    doc: str = ""
    scale: str = ""


class Tabular:
    """Base class of what can be converted to a table."""

    def _columns(self) -> dict[str, Column]:
        """Returns the columns by name."""
        raise NotImplementedError

    def _facts(self) -> dict[str, typing.Any]:
        """Returns properties of the whole table, by names of at most 8 characters, as FITS has."""
        return {}

    def _meta(self) -> dict[str, typing.Any]:
        from ._library import version
        facts = {"object": public_name(type(self)), "toliman": version(), **self._facts()}
        return {name: value for name, value in facts.items() if value is not None and value != "" and value == value}

    def to_table(self) -> typing.Any:
        """Returns an astropy Table, whose columns have units and descriptions; `meta` has the properties of the whole.
        Dates are columns of Time. table.write("name.ecsv") and table.write("name.fits") keep all digits; to read the
        dates of the latter, Table.read("name.fits", astropy_native=True)."""
        tables, times = (optional(f"astropy.{name}", "to_table()") for name in ("table", "time"))
        made = tables.Table(meta=self._meta())
        for name, column in self._columns().items():
            if column.scale:
                gps = column.scale == "gps"
                made[name] = times.Time(column.values, _GPS_DAYS if gps else None, format="mjd",
                                        scale="tai" if gps else column.scale)
                made[name].info.description = column.doc or None
            else:
                made[name] = tables.Column(column.values, unit=column.unit or None, description=column.doc or None)
        return made

    def to_pandas(self) -> typing.Any:
        """Returns a pandas DataFrame. Its attrs have units, descriptions, the properties of the whole, and as "scales"
        the time scales of columns of Modified Julian Days. Arrays in a column become columns NAME_0, NAME_1 ..."""
        pandas = optional("pandas", "to_pandas()")
        columns = self._columns()
        flat = {name: numpy.asarray(column.values) for name, column in columns.items()}
        for name in [name for name, values in flat.items() if values.ndim > 1]:
            flat = {other: one for key, values in flat.items() for other, one in
                    (_split(name, values) if key == name else ((key, values),))}
        made = pandas.DataFrame(flat)
        made.attrs = {**self._meta(), "units": {name: column.unit for name, column in columns.items() if column.unit},
                      "descriptions": {name: column.doc for name, column in columns.items() if column.doc},
                      "scales": {name: column.scale for name, column in columns.items() if column.scale}}
        return made

    def _repr_html_(self) -> str:
        columns = {name: (numpy.asarray(column.values), column) for name, column in self._columns().items()}
        count = len(next(iter(columns.values()))[0]) if columns else 0
        heads = "".join(f"<th title='{html.escape(column.doc, quote=True)}'>{html.escape(name)}"
                        f"{f'<br>{html.escape(column.unit)}' if column.unit else ''}</th>"
                        for name, (_, column) in columns.items())
        cells = ("".join(f"<td>{html.escape(text_of(values[row]))}</td>" for values, _ in columns.values())
                 for row in range(min(count, _ROWS_SHOWN)))
        rows = "".join(f"<tr>{row}</tr>" for row in cells)
        more = f"<tr><td colspan='{len(columns)}'>{count - _ROWS_SHOWN} more</td></tr>" if count > _ROWS_SHOWN else ""
        return f"<table><caption>{html.escape(repr(self))}</caption><tr>{heads}</tr>{rows}{more}</table>"


def _split(name: str, values: NDArray) -> typing.Iterator[tuple[str, NDArray]]:
    for place in numpy.ndindex(values.shape[1:]):
        yield f"{name}_{'_'.join(map(str, place))}", values[(..., *place)]  # type: ignore[arg-type]


def text_of(value: typing.Any) -> str:
    """Returns a value of a table as text with at most nine digits."""
    if isinstance(value, numpy.ndarray):
        return ", ".join(map(text_of, value.flat))
    return f"{value:.9g}" if isinstance(value, (float, numpy.floating)) else str(value)


def column_of(name: str, values: typing.Any, doc: str, units: Units) -> Column:
    """Returns a column of a member of results, whose unit its name and comment give. units: what "t", "y" and the scale
    of "date" are, where the object knows."""
    unit = unit_of_member(name, doc)
    if unit == "date" and units.get("date"):
        return Column(values, "", doc, units["date"])
    known = {"date": units.get("t", ""), "t": units.get("t", ""), "y": units.get("y", ""),
             "1/t": f"1 / {units['t']}" if units.get("t") else ""}
    return Column(values, known.get(unit, unit), doc)


def common(units: typing.Iterable[Units]) -> Units:
    """Returns the units that all have."""
    first, *others = [dict(one) for one in units] or [{}]
    return {name: unit for name, unit in first.items() if all(one.get(name) == unit for one in others)}


def _members_of(kind: type | None) -> dict[str, dataclasses.Field]:
    fields = () if kind is None else dataclasses.fields(kind)  # type: ignore[arg-type]
    return {field.name: field for field in fields}


class Records(numpy.ndarray, Tabular):
    """A structured array of results: array["name"] is a plain array. In tables, constants are words, and each of the
    `flags` that the class of the results has is a column."""

    _kind: type | None
    _units: Units

    def __array_finalize__(self, source: typing.Any) -> None:
        self._kind, self._units = getattr(source, "_kind", None), getattr(source, "_units", {})

    def __getitem__(self, key: typing.Any) -> typing.Any:
        found = super().__getitem__(key)
        return found.view(numpy.ndarray) if isinstance(found, Records) and found.dtype.names is None else found

    def __array_function__(self, function: typing.Any, types: typing.Any, arguments: typing.Any,
                           options: typing.Any) -> typing.Any:
        made = super().__array_function__(function, types, arguments, options)
        if function is not numpy.concatenate or made is NotImplemented or made.dtype.names is None:
            return made
        parts = [one for one in arguments[0] if isinstance(one, Records)]
        kinds = {one._kind for one in parts}
        return records_of(made, self._kind if len(kinds) == 1 else None, common(one._units for one in parts))

    def __eq__(self, other: typing.Any) -> typing.Any:
        return self.view(numpy.ndarray) == other

    def __ne__(self, other: typing.Any) -> typing.Any:
        return self.view(numpy.ndarray) != other

    def __reduce__(self) -> typing.Any:
        rebuild, arguments, state = super().__reduce__()  # type: ignore[misc]
        return rebuild, arguments, (*state, self._kind, self._units)

    def __setstate__(self, state: typing.Any) -> None:
        *state, self._kind, self._units = state
        super().__setstate__(tuple(state))  # type: ignore[arg-type]

    def _columns(self) -> dict[str, Column]:
        rows, members, found = self.ravel(), _members_of(self._kind), {}
        flags = {name: field.metadata for name, field in members.items() if field.metadata.get("flag")}
        for name in self.dtype.names or ():
            metadata = members[name].metadata if name in members else {}
            if name == "flags" and flags:
                continue
            values = rows[name]
            if metadata.get("words"):
                known = words_of(metadata["words"])
                values = numpy.array([known.get(value, str(value)) for value in values.tolist()], str)
            elif name in members and members[name].type == "bool":
                values = values.astype(bool)
            found[name] = column_of(name, values, metadata.get("doc", ""), self._units)
        for name, metadata in flags.items() if "flags" in (self.dtype.names or ()) else ():
            found[name] = Column(rows["flags"] & metadata["flag"] != 0, "", metadata["doc"])
        return found

    def _facts(self) -> dict[str, typing.Any]:
        return {"object": "" if self._kind is None else self._kind.__name__}

    def __repr__(self) -> str:
        kind = "" if self._kind is None else f" of {self._kind.__name__}"
        return f"<{self.size} records{kind}>"

    def __str__(self) -> str:
        return str(self.view(numpy.ndarray))


def records_of(array: NDArray, kind: type | None, units: Units = {}) -> Records:
    """Returns a structured array as records with the comments and units of a class of results; None: no class."""
    made = array.view(Records)
    made._kind, made._units = kind, units
    return made


def _array_of(name: str, values: list[typing.Any]) -> NDArray:
    lengths = sorted({len(value) for value in values if isinstance(value, tuple)})
    if len(lengths) > 1:
        raise ValueError(f"{name} has {', '.join(map(str, lengths))} values: must have one number of them in all rows")
    return numpy.array(values)


T = typing.TypeVar("T")


class Rows(typing.List[T], Tabular):
    """A list of results of one class, also of your own: Rows(outcomes).to_table()."""

    @typing.overload
    def __getitem__(self, key: typing.SupportsIndex) -> T: ...

    @typing.overload
    def __getitem__(self, key: slice) -> Rows[T]: ...

    def __getitem__(self, key: typing.Any) -> typing.Any:
        found = super().__getitem__(key)
        return Rows(found) if isinstance(key, slice) else found

    def __add__(self, others: typing.Any) -> typing.Any:
        return Rows(super().__add__(others))

    def copy(self) -> Rows[T]:
        """Returns a list of the same results."""
        return Rows(self)

    def _columns(self) -> dict[str, Column]:
        kinds = {type(one) for one in self}
        if len(kinds) > 1 or not all(dataclasses.is_dataclass(kind) for kind in kinds):
            names = ", ".join(sorted(kind.__name__ for kind in kinds))
            raise TypeError(f"the rows are {names}: must be results of one class")
        found, units = {}, common(getattr(one, "_units", {}) for one in self)
        for name, field in _members_of(next(iter(kinds), None)).items():
            values = [getattr(one, name) for one in self]
            if field.type == "tuple[str, ...]":
                values = [", ".join(value) for value in values]
            found[name] = column_of(name, _array_of(name, values), field.metadata.get("doc", ""), units)
        return found

    def _facts(self) -> dict[str, typing.Any]:
        return {"object": type(self[0]).__name__ if self else ""}

    def __repr__(self) -> str:
        return f"<{len(self)} rows{f' of {type(self[0]).__name__}' if self else ''}>"

    def __str__(self) -> str:
        return "\n".join(map(repr, self)) or repr(self)
