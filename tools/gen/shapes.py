"""Adds the table `shapes` to the model: the extents of each argument, and whether it may be NULL."""
import os
import re

from model import Callback, Function


def words(top):
    """Yields (line number, function or callback name, list of argument entries) of the table."""
    with open(os.path.join(top, "tools/gen/shapes"), encoding="utf-8") as stream:
        for number, line in enumerate(stream, 1):
            line = line.split("#")[0].strip()
            if line:
                name, _, rest = line.partition(":")
                yield number, name, rest.split()


def attach(table, top):
    """Sets `extents` ([] for a scalar) and `nullable` of every argument; errors name the line of the table."""
    for item in table.all(Function) + table.all(Callback):
        for argument in item.arguments:
            argument.extents, argument.nullable = [argument.type.array] if argument.type.array else [], False
            argument.alone = False
    for number, name, rest in words(top):
        place = f"tools/gen/shapes:{number}"
        item = table.by_name.get(name)
        if not isinstance(item, (Function, Callback)):
            raise SystemExit(f"{place}: {name} is not a function of include/toliman")
        arguments = {argument.name: argument for argument in item.arguments}
        for word in rest:
            match = re.fullmatch(r"(\w+)((?:\[(?:\w+|\*)\])*)(\??)", word)
            argument = arguments.get(match.group(1)) if match else None
            if argument is not None and match.group(0) == argument.name and not argument.type.pointers:
                argument.alone = True
                continue
            if argument is None or not argument.type.pointers:
                raise SystemExit(f"{place}: {word}: expected a pointer argument of {name}")
            argument.extents = re.findall(r"\w+|\*", match.group(2)) or argument.extents
            argument.nullable = match.group(3) == "?"
    for item in table.all(Function):
        require_complete(item)


def require_complete(item):
    """Stops if the table lacks an entry for the function."""
    extents = {extent for argument in item.arguments for extent in argument.extents}
    for argument in item.arguments:
        kind = argument.type
        if kind.base == "size_t" and not kind.pointers and argument.name not in extents and not argument.alone:
            raise SystemExit(f"tools/gen/shapes: {item.name}: no argument has the extent {argument.name}")
        number = kind.pointers and not kind.base.startswith("toliman_") and kind.base != "char"
        if number and not argument.extents and (kind.const or kind.base == "void") and argument.name != "user_data":
            raise SystemExit(f"tools/gen/shapes: {item.name}: {argument.name} needs extents")
    if re.search(r"may\s+be\s+NULL", item.doc) and not any(argument.nullable for argument in item.arguments):
        raise SystemExit(f"tools/gen/shapes: {item.name}: the comment states that an argument may be NULL")
