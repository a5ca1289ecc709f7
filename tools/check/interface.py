"""The binary interface as lines of text, and what two such texts mean for programs that were built with the older.

A line is a kind, a name and what belongs to it; members of structs are named struct.member.
"""
import os
import re
import sys

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "../gen"))
import layout
import model
import shapes

HEADING = "# The binary interface, in the headers' order: made by `make abi`, held by tools/check/abi, only ever added to.\n"
LINE = re.compile(r"\s*(\w+) (\w+(?:\.\w+)?)(.*)\n")
VERSIONS = re.compile(r"version abi (\d+) of (\d+)\.(\d+)")
STATUS = "TOLIMAN_E_"

# What becomes of programs that were built before.
GONE = {
    "function": "programs that call it do not start",
    "constant": "programs that name it do not compile, and the library no longer knows what built ones mean by it",
}
CHANGED = {
    "function": "programs built before call it the old way; Fortran and Python also name the arguments",
    "callback": "the functions of programs built before are called the new way",
    "constant": "programs built before mean something else by the number",
    "member": "programs built before have it elsewhere or of another kind",
    "struct": "programs built before give it less room or more",
    "type": "programs built before have the old type",
}


def declared(table, kind):
    """A type, with the number of an array's elements."""
    if kind.array:
        kind = model.Type(kind.base, kind.const, kind.pointers, str(table.length(kind.array)))
    return kind.declare("").strip()


def call(item):
    """(arguments) -> result of a function or callback."""
    arguments = ", ".join(argument.type.declare(argument.name) for argument in item.arguments)
    return f"({arguments or 'void'}) -> {item.returns.declare('').strip()}"


def oldest(top, item, measured):
    """The smallest size of a struct that the library takes: lib/api/oldest.hpp, or today's."""
    path = os.path.join(top, "lib/api/oldest.hpp")
    if not os.path.exists(path):
        return measured[item.name]
    with open(path, encoding="utf-8") as stream:
        text = re.sub(r"//.*", "", stream.read())
    match = re.search(rf"kOldest<{item.name}> =\s+(?:(\d+)|offsetof\({item.name}, (\w+)\));", text)
    return measured[item.name] if not match else match.group(1) or measured[f"{item.name}.{match.group(2)}"]


def item_lines(table, item, measured, top):
    """The lines of one declaration."""
    name = item.name
    if isinstance(item, model.Function):
        yield f"function {name}{call(item)}"
    elif isinstance(item, model.Callback):
        yield f"callback {name}{call(item)}"
    elif isinstance(item, model.Constant):
        yield f"constant {name} = {measured[name]}"
    elif isinstance(item, model.Alias):
        yield f"type {name} = {item.type.declare('').strip()}"
    elif isinstance(item, model.Handle):
        yield f"handle {name}"
    else:
        yield f"struct {name} of {measured[name]} bytes, taken from {oldest(top, item, measured)}"
        for field in item.fields:
            place = f"{name}.{field.name}"
            yield f"    member {place} at {measured[place]}: {declared(table, field.type)}"


def describe(top):
    """The text of a tree's headers."""
    table = model.read(top)
    measured = layout.measure(table, top)
    major, minor = measured["TOLIMAN_VERSION_MAJOR"], measured["TOLIMAN_VERSION_MINOR"]
    lines = [f"version abi {measured['TOLIMAN_ABI_VERSION']} of {major}.{minor}"]
    for item in table.items:
        if not item.name.startswith(("TOLIMAN_VERSION", "TOLIMAN_ABI_VERSION")):
            lines += item_lines(table, item, measured, top)
    return HEADING + "\n".join(lines) + "\n"


def entries(text):
    """(kind, name) -> (line number, what belongs to it)."""
    found = {}
    for number, line in enumerate(text.splitlines(keepends=True), 1):
        match = LINE.fullmatch(line)
        if match:
            found[match.group(1, 2)] = number, match.group(3).strip(" :")
    return found


def number(before, text):
    """The number behind a word: bytes of a struct, place of a member, value of a constant."""
    return int(re.search(before + r" (\d+)", text).group(1))


def why_fixed(table, struct):
    """Why a struct may not grow, None if it may: the library must learn how much room the caller has."""
    if not struct.sized:
        return "it has no struct_size that tells how much room programs built before give it"
    for function in table.all(model.Function):
        arguments = {argument.name: argument.type.base for argument in function.arguments}
        if struct.name in arguments.values() and function.name.endswith("_init") and "size" not in arguments:
            return f"{function.name} would write it whole over the shorter one of programs built before"
    return None


def wrong_addition(old, kind, name, text):
    """Why something new may not be added, None if it may."""
    struct = name.split(".")[0]
    if kind == "member" and ("struct", struct) in old:
        if any(name.startswith(struct + ".reserved") and place == text for (_, name), (_, place) in old.items()):
            return None  # what the place was kept for
        size = number("of", old["struct", struct][1])
        if number("at", text) < size:
            return f"{text}, within the {size} bytes that programs built before know: append it"
    if name.startswith(STATUS):
        taken = max(number("=", text) for (_, name), (_, text) in old.items() if name.startswith(STATUS))
        if number("=", text) <= taken:
            return f"{text}, but codes are appended and those to {taken} are taken"
    return None


def lost_and_changed(old, new):
    """(line, what breaks) of all that is recorded and no longer so; of a struct's members that moved the first."""
    moved, places = {}, {(name.split(".")[0], text) for (kind, name), (_, text) in new.items() if kind == "member"}
    for (kind, name), (line, text) in old.items():
        now = new.get((kind, name), (0, None))[1]
        struct = name.split(".")[0]
        if now is None and name.startswith(struct + ".reserved") and (struct, text) in places:
            continue  # the place is taken by what it was kept for
        if now is None:
            yield line, f"{kind} {name} is gone: {GONE.get(kind, 'programs that name it do not compile')}"
        elif now == text or kind == "version" or (kind == "struct" and number("of", now) >= number("of", text)):
            continue  # what makes a struct larger is told of its members
        elif kind == "member":
            moved.setdefault(struct, []).append((line, f"{name} {text} -> {now}"))
        else:
            yield line, f"{kind} {name}: {text} -> {now}: {CHANGED[kind]}"
    for members in moved.values():
        line, first = members[0]
        more = f" (and {len(members) - 1} more)" if len(members) > 1 else ""
        yield line, f"member {first}{more}: {CHANGED['member']}"


def compare(before, after, top):
    """What breaks, as (line of the older text, why), and what is new, as lines; top: the tree of the newer."""
    old, new = entries(before), entries(after)
    table = model.read(top)
    shapes.attach(table, top)
    breaks, additions, grown = list(lost_and_changed(old, new)), [], []
    for (kind, name), (_, text) in new.items():
        line, known = old.get((kind, name), (0, None))
        if known is None:
            problem = wrong_addition(old, kind, name, text)
            if problem:
                breaks.append((old.get(("struct", name.split(".")[0]), (0,))[0], f"new {kind} {name} {problem}"))
            else:
                additions.append(f"{kind} {name} {text}".strip())
        elif kind == "version" and text != known:
            additions.append(f"version {name} {known} -> {text}")
        elif kind == "struct" and text != known and number("of", text) >= number("of", known):
            least, before_it = number("from", text), number("from", known)
            if least > before_it:
                breaks.append((line, f"struct {name}: lib/api refuses the {before_it} bytes of programs built before: "
                                     f"give it kOldest<{name}> = {before_it} in oldest.hpp"))
            if number("of", text) > number("of", known):
                grown.append((line, name))
            additions.append(f"struct {name} {known} -> {text}")
    for line, name in grown:
        problem = why_fixed(table, table.by_name[name])
        if problem and not any(f" {name}." in why for _, why in breaks):
            breaks.append((line, f"struct {name} may not grow: {problem}"))
    return sorted(breaks), additions


def raised(before, after):
    """Whether the newer text has a higher TOLIMAN_ABI_VERSION and, before 1.0, a higher minor version, the SONAME's."""
    old, new = (tuple(map(int, VERSIONS.search(text).groups())) for text in (before, after))
    return new[0] > old[0] and (new[1] > 0 or new[2] > old[2])
