"""The binary interface as lines of text, and the effect of a change of this text on programs built with the older one.

A line has a kind, a name and a description; members of structs are named struct.member.
"""
import os
import re
import sys

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "../gen"))
import layout
import model
import shapes

HEADING = "# The binary interface in the order of the headers: written by `make abi`, verified by tools/check/abi, append-only.\n"
LINE = re.compile(r"\s*(\w+) (\w+(?:\.\w+)?)(.*)\n")
VERSIONS = re.compile(r"version abi (\d+) of (\d+)\.(\d+)")
STATUS = "TOLIMAN_E_"

# Effects on programs that were built before.
GONE = {
    "function": "programs that call it do not start",
    "constant": "programs that name it do not compile, and the library no longer knows the value that built programs pass",
}
CHANGED = {
    "function": "programs built before call it with the old arguments; Fortran and Python also use their names",
    "callback": "functions of programs built before are called with the new arguments",
    "constant": "programs built before give the value another meaning",
    "member": "programs built before use the old offset or type",
    "struct": "programs built before allocate another size",
    "type": "programs built before use the old type",
}


def declared(table, kind):
    """A type, including the length of an array."""
    if kind.array:
        kind = model.Type(kind.base, kind.const, kind.pointers, str(table.length(kind.array)))
    return kind.declare("").strip()


def call(item):
    """(arguments) -> result, for a function or callback."""
    arguments = ", ".join(argument.type.declare(argument.name) for argument in item.arguments)
    return f"({arguments or 'void'}) -> {item.returns.declare('').strip()}"


def oldest(top, item, measured):
    """The smallest size of a struct that the library accepts: that of lib/api/oldest.hpp, or the current one."""
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
    """(kind, name) -> (line number, description)."""
    found = {}
    for number, line in enumerate(text.splitlines(keepends=True), 1):
        match = LINE.fullmatch(line)
        if match:
            found[match.group(1, 2)] = number, match.group(3).strip(" :")
    return found


def number(before, text):
    """The number after a word: size of a struct, offset of a member, value of a constant."""
    return int(re.search(before + r" (\d+)", text).group(1))


def why_fixed(struct):
    """The reason why a struct may not grow, or None: the library must know the size that its caller allocated."""
    if not struct.sized:
        return "it has no struct_size from which the library learns the size in programs built before"
    return None


def wrong_addition(old, kind, name, text):
    """The reason why an item may not be added, or None."""
    struct = name.split(".")[0]
    if kind == "member" and ("struct", struct) in old:
        if any(name.startswith(struct + ".reserved") and place == text for (_, name), (_, place) in old.items()):
            return None  # the use for which the place was reserved
        size = number("of", old["struct", struct][1])
        if number("at", text) < size:
            return f"{text}, within the {size} bytes that programs built before use: append it"
    if name.startswith(STATUS):
        taken = max(number("=", text) for (_, name), (_, text) in old.items() if name.startswith(STATUS))
        if number("=", text) <= taken:
            return f"{text}, but codes are appended and those to {taken} are taken"
    return None


def lost_and_changed(old, new):
    """(line, what breaks) for every recorded item that is gone or has changed; of moved members the first of each struct."""
    moved, places = {}, {(name.split(".")[0], text) for (kind, name), (_, text) in new.items() if kind == "member"}
    for (kind, name), (line, text) in old.items():
        now = new.get((kind, name), (0, None))[1]
        struct = name.split(".")[0]
        if now is None and name.startswith(struct + ".reserved") and (struct, text) in places:
            continue  # a new member uses the reserved place
        if now is None:
            yield line, f"{kind} {name} is gone: {GONE.get(kind, 'programs that name it do not compile')}"
        elif now == text or kind == "version" or (kind == "struct" and number("of", now) >= number("of", text)):
            continue  # growth of a struct is reported by its members
        elif kind == "member":
            moved.setdefault(struct, []).append((line, f"{name} {text} -> {now}"))
        else:
            yield line, f"{kind} {name}: {text} -> {now}: {CHANGED[kind]}"
    for members in moved.values():
        line, first = members[0]
        more = f" (and {len(members) - 1} more)" if len(members) > 1 else ""
        yield line, f"member {first}{more}: {CHANGED['member']}"


def compare(before, after, top):
    """Breaks as (line of the older text, reason) and additions as lines. top: the tree of the newer text."""
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
        problem = why_fixed(table.by_name[name])
        if problem and not any(f" {name}." in why for _, why in breaks):
            breaks.append((line, f"struct {name} may not grow: {problem}"))
    return sorted(breaks), additions


def raised(before, after):
    """Whether the newer text has a higher TOLIMAN_ABI_VERSION and, before 1.0, a higher minor version (SONAME)."""
    old, new = (tuple(map(int, VERSIONS.search(text).groups())) for text in (before, after))
    return new[0] > old[0] and (new[1] > 0 or new[2] > old[2])
