"""Writes the model as Fortran: constants, bind(C) types, abstract interfaces of callbacks, interfaces of functions."""
import re
import textwrap

from model import Callback, Constant, Function, Handle, Struct

WIDTH = 118
KINDS = {"int32_t": "integer(c_int32_t)", "uint32_t": "integer(c_int32_t)", "int64_t": "integer(c_int64_t)",
         "uint64_t": "integer(c_int64_t)", "size_t": "integer(c_size_t)", "double": "real(c_double)",
         "char": "character(kind=c_char)", "void": "integer(c_int8_t)"}


def wrapped(line, indent):
    """Returns a statement, continued over several lines where it is too long."""
    pad, parts = " " * indent, []
    text = line
    while len(text) > WIDTH - indent - 2:
        at = text.rfind(", ", 0, WIDTH - indent - 4) + 1
        parts.append(text[:at] + " &")
        text = "    " + text[at + 1:]
    return "".join(f"{pad}{part}\n" for part in parts + [text])


def comment(text, indent):
    """Returns text as a comment with the same line breaks."""
    pad = " " * indent
    return "".join(f"{pad}! {line}".rstrip() + "\n" for line in text.split("\n")) if text else ""


def flowing(text, indent):
    """Returns text as a comment, refilled to one paragraph."""
    return comment("\n".join(textwrap.wrap(" ".join(text.split()), WIDTH - indent - 2)), indent)


def first_sentence(text):
    return re.split(r"(?<=\.)(?:\s+(?=[A-Z*])|\n(?=  ))", text.split("\n\n")[0], maxsplit=1)[0]


def fortran_name(model, item):
    """Returns a constant's name, changed where it differs from a function's only in case: Fortran ignores case."""
    if item.name.lower() in model.by_name:
        return item.name.replace("TOLIMAN_", "TOLIMAN_HEADER_", 1)
    return item.name


def constant(model, item):
    name = fortran_name(model, item)
    if isinstance(item.value, str):
        line = f"character(len=*), parameter, public :: {name} = '{item.value}'"
    else:
        line = f"integer(c_int32_t), parameter, public :: {name} = {item.value}"
    doc = " ".join(item.doc.split())
    if len(line) + len(doc) + 7 > WIDTH:
        return comment(item.heading, 4) + flowing(doc, 4) + wrapped(line, 4)
    return comment(item.heading, 4) + f"    {line}" + (f" ! {doc}" if doc else "") + "\n"


def field(model, struct, item):
    """Returns the declaration of a component with its default initialisation: struct_size the size, others zero."""
    kind, dimension = item.type, ""
    if kind.pointers:
        declared, value = "type(c_ptr)", "c_null_ptr"
    elif model.kind(kind.base) is Callback:
        declared, value = "type(c_funptr)", "c_null_funptr"
    elif model.kind(kind.base) is Struct:
        return f"type({kind.base}) :: {item.name}"
    else:
        declared = KINDS[model.plain(kind.base)]
        value = {"i": "0", "r": "0.0_c_double", "c": "c_null_char"}[declared[0]]
    if kind.array:
        dimension = f"({kind.array})"
    if struct.sized and item.name == "struct_size":
        value = str(model.struct_size(struct))
    return f"{declared} :: {item.name}{dimension} = {value}"


def struct(model, item):
    text, before = comment(item.doc, 4) + f"    type, bind(C), public :: {item.name}\n", None
    for member in item.fields:
        line = "        " + field(model, item, member)
        doc = " ".join(member.doc.split()) if member.doc != before else ""  # one comment may document several members
        short = len(line) + len(doc) + 3 <= WIDTH
        text += (line + (f" ! {doc}" if doc else "") if short else flowing(doc, 8) + line) + "\n"
        before = member.doc
    return text + "    end type\n"


def base_type(model, kind):
    """Returns the Fortran type of a value or of a pointer's target."""
    if model.kind(kind.base) is Struct:
        return f"type({kind.base})"
    return KINDS[model.plain(kind.base)]


def declared(model, argument, inside_out=False):
    """Returns the declaration of a dummy argument of a C function, or (inside_out) of a callback that C calls."""
    kind, name = argument.type, argument.name
    if model.kind(kind.base) is Callback:
        return f"type(c_funptr), value :: {name}"
    if model.kind(kind.base) is Handle and kind.inputs:
        return f"type(c_ptr), intent(in) :: {name}(*)"
    if model.kind(kind.base) is Handle and kind.pointers == 2:
        return f"type(c_ptr), intent(out) :: {name}"
    opaque = kind.base == "void" and not argument.extents
    text_of_c = kind.base == "char" and inside_out
    if kind.pointers and (model.kind(kind.base) is Handle or opaque or text_of_c):
        return f"type(c_ptr), value :: {name}"
    if not kind.pointers and not kind.array:
        return f"{base_type(model, kind)}, value :: {name}"
    changed = "inout" if model.kind(kind.base) is Struct else "out"
    text = f"{base_type(model, kind)}, intent({'in' if kind.const else changed})"
    text += ", optional" if argument.nullable else ""
    if inside_out and argument.extents:
        return f"{text} :: {name}({', '.join(reversed(argument.extents))})"
    return f"{text} :: {name}{'(*)' if argument.extents or kind.base == 'char' else ''}"


def result(model, kind):
    """Returns the type of a function's result; None for a subroutine."""
    if kind.pointers:
        return "type(c_ptr)"
    return None if kind.base == "void" else KINDS[model.plain(kind.base)]


def interface(model, item):
    """Returns the interface body of a function or callback."""
    names = ", ".join(argument.name for argument in item.arguments)
    returned = result(model, item.returns)
    word = "function" if returned else "subroutine"
    tail = " result(answer)" if returned else ""
    text = flowing(first_sentence(item.doc), 8) if isinstance(item, Function) else comment(item.doc, 8)
    text += wrapped(f"{word} {item.name}({names}) bind(C){tail}", 8) + "            import\n"
    text += listed([declared(model, argument, isinstance(item, Callback)) for argument in item.arguments], 12)
    if returned:
        text += f"            {returned} :: answer\n"
    return text + f"        end {word}\n"


def listed(declarations, indent):
    """Returns declarations grouped by type. Values come first, since they may be extents of the others."""
    kinds = {}
    for line in sorted(declarations, key=lambda line: ", value ::" not in line):
        kind, name = line.split(" :: ")
        kinds.setdefault(kind, []).append(name)
    return "".join(wrapped(f"{kind} :: {', '.join(names)}", indent) for kind, names in kinds.items())


def callback(model, item):
    """Returns the abstract interface of a callback. Strings arrive as type(c_ptr), for toliman_text; arrays have the
    extents passed along with them."""
    text = interface(model, item)
    return f"    abstract interface\n{text}    end interface\n    public :: {item.name}\n"


def declarations(model):
    """Returns the specification part of the module."""
    text, functions, before = "", [], None
    constants = {fortran_name(model, item).lower() for item in model.all(Constant)}
    for item in model.items:
        if not isinstance(item, Constant) and item.name.lower() in constants:
            raise SystemExit(f"{item.name}: differs from a constant only in case, which Fortran ignores")
        if isinstance(item, Function):
            functions.append(item)
        elif isinstance(item, (Constant, Struct, Callback)):
            write = {Constant: constant, Struct: struct, Callback: callback}[type(item)]
            part = write(model, item)
            apart = type(item) is not before or type(item) is not Constant or item.heading
            text += ("\n" if apart and text else "") + part
            before = type(item)
    text += "\n    interface\n" + "\n".join(interface(model, item) for item in functions) + "    end interface\n\n"
    return text + "".join(f"    public :: {item.name}\n" for item in functions)
