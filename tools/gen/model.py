"""Parses the public headers into a model: constants, handles, structs, callbacks and functions, in the headers' order.

Method: a tokenizer and a recursive-descent parser for the one style in which the headers are written. Anything else is
an error with file and line, so that a declaration is never skipped silently. tests/bind verifies the model by compiling
it against the headers. tools/gen/README.md explains why libclang is not used.
"""
import dataclasses
import os
import re

SCALARS = {"char": 1, "int32_t": 4, "uint32_t": 4, "int64_t": 8, "uint64_t": 8, "size_t": 8, "double": 8}
POINTER_SIZE = 8


@dataclasses.dataclass
class Type:
    """A type `const base ** [array]`; const applies to the pointer's target. inputs: an array of pointers
    that are only read, `const base *const *`."""

    base: str
    const: bool = False
    pointers: int = 0
    array: str = ""
    inputs: bool = False

    def declare(self, name):
        """Returns the C declaration of a variable of this type."""
        stars = "*const *" if self.inputs else "*" * self.pointers
        return f"{'const ' if self.const else ''}{self.base} {stars}{name}{f'[{self.array}]' if self.array else ''}"


@dataclasses.dataclass
class Named:
    """A field of a struct or an argument of a function."""

    name: str
    type: Type
    doc: str = ""


@dataclasses.dataclass
class Constant:
    name: str
    value: object  # int or str
    doc: str  # the comment on its line
    heading: str  # the comment above the group whose first constant it is


@dataclasses.dataclass
class Alias:
    name: str
    type: Type
    doc: str


@dataclasses.dataclass
class Handle:
    name: str
    doc: str


@dataclasses.dataclass
class Struct:
    name: str
    fields: list
    doc: str

    @property
    def sized(self):
        return self.fields[0].name == "struct_size"


@dataclasses.dataclass
class Callback:
    name: str
    returns: Type
    arguments: list
    doc: str


@dataclasses.dataclass
class Function:
    name: str
    returns: Type
    arguments: list
    doc: str

    @property
    def status(self):
        return self.returns.base == "toliman_status"


class Model:
    """All declarations, in order, by name and by kind."""

    def __init__(self, items):
        self.items = items
        self.by_name = {item.name: item for item in items}

    def all(self, kind):
        return [item for item in self.items if isinstance(item, kind)]

    def kind(self, name):
        """Returns the class of a declared name; None for C's own types."""
        return type(self.by_name[name]) if name in self.by_name else None

    def plain(self, base):
        """Resolves aliases of a base type: toliman_status is int32_t."""
        item = self.by_name.get(base)
        return self.plain(item.type.base) if isinstance(item, Alias) else base

    def length(self, array):
        """Returns the number of elements of an array, given as a number or a constant's name."""
        return int(array) if array.isdigit() else self.by_name[array].value

    def layout(self, kind):
        """Returns size and alignment in bytes of a field's element."""
        if kind.pointers or self.kind(kind.base) is Callback:
            return POINTER_SIZE, POINTER_SIZE
        if self.kind(kind.base) is Struct:
            struct = self.by_name[kind.base]
            return self.struct_size(struct), max(self.layout(field.type)[1] for field in struct.fields)
        return (SCALARS[self.plain(kind.base)],) * 2

    def struct_size(self, struct):
        """Returns sizeof(struct) on 64-bit machines, with padding."""
        offset, most = 0, 1
        for field in struct.fields:
            size, alignment = self.layout(field.type)
            offset = (offset + alignment - 1) // alignment * alignment + size * self.length(field.type.array or "1")
            most = max(most, alignment)
        return (offset + most - 1) // most * most


TOKEN = re.compile(
    r"(?P<comment>/\*.*?\*/)|(?P<directive>\#(?:/\*.*?\*/|\\\n|[^\n])*)|(?P<word>\w+)|(?P<mark>[*()\[\]{},;])"
    r"|(?P<space>\s+)|(?P<other>.)", re.S)


@dataclasses.dataclass
class Token:
    kind: str
    text: str
    line: int
    end: int  # line


def plain_comment(text):
    """Returns a comment's text without its delimiters; lines that start with a star keep their indentation."""
    lines = text[2:-2].replace("\\\n", "\n").split("\n")
    lines = [re.sub(r"^\s*\* ?", "", line) if re.match(r"\s*\*", line) else line.strip() for line in lines]
    return "\n".join(line.rstrip() for line in lines).strip()


class Reader:
    """Parses the declarations of one header."""

    def __init__(self, path, text, known):
        self.path, self.known, self.items, self.includes = path, known, [], []
        self.tokens, self.place = [], 0
        self.comment, self.reach = "", 0  # the last comment; the last line of it or of the declarations it documents
        self.fresh = False  # no declaration since the last comment
        line = 1
        for match in TOKEN.finditer(text):
            end = line + match.group().count("\n")
            if match.lastgroup != "space":
                self.tokens.append(Token(match.lastgroup, match.group(), line, end))
            line = end

    def fail(self, what):
        token = self.tokens[min(self.place, len(self.tokens) - 1)]
        raise SystemExit(f"{self.path}:{token.line}: {what}, not {token.text!r}")

    def peek(self):
        return self.tokens[self.place].text if self.place < len(self.tokens) else ""

    def take(self, *allowed):
        """Consumes and returns the next word or mark, which must be one of `allowed` if any are given."""
        text = self.peek()
        if (allowed and text not in allowed) or self.tokens[self.place].kind not in ("word", "mark"):
            self.fail("expected " + (" or ".join(allowed) or "a name"))
        self.place += 1
        return text

    def taken(self, text):
        """Consumes the next token if it is `text`; returns whether it was."""
        if self.peek() == text:
            self.place += 1
            return True
        return False

    def doc(self, line):
        """Returns the comment of a declaration that begins at `line`: directly above it, or above its group."""
        if self.reach + 1 != line:
            self.comment = ""
        return self.comment

    def read(self):
        while self.place < len(self.tokens):
            token = self.tokens[self.place]
            if token.kind == "comment":
                self.comment, self.reach, self.fresh = plain_comment(token.text), token.end, True
                self.place += 1
                continue
            if token.kind == "directive":
                self.directive(token)
                self.place += 1
            elif token.text in ("TOLIMAN_BEGIN_DECLS", "TOLIMAN_END_DECLS"):
                self.place += 1
            elif token.text == "typedef":
                self.typedef(self.doc(token.line))
            elif token.text == "TOLIMAN_API":
                self.function(self.doc(token.line))
            else:
                self.fail("expected a declaration")
            self.reach, self.fresh = self.tokens[self.place - 1].end, False

    def directive(self, token):
        text = token.text.replace("\\\n", " ")
        comment = re.search(r"/\*.*\*/", token.text, re.S)
        code = re.sub(r"/\*.*?\*/", "", text, flags=re.S).strip()
        include = re.fullmatch(r"#include <toliman/(\w+\.h)>", code)
        constant = re.fullmatch(r"#define (TOLIMAN_\w+)\s+(\S.*)", code)
        if include:
            self.includes.append(include.group(1))
        elif re.fullmatch(r"#define (TOLIMAN_\w*INIT\(type\) .*|TOLIMAN_(\w+)_INIT TOLIMAN_INIT\((\w+)\))", code):
            pass  # initialisers, for C only
        elif constant:
            self.items.append(Constant(constant.group(1), self.value(constant.group(2)),
                                       plain_comment(comment.group()) if comment else "",
                                       self.doc(token.line) if self.fresh else ""))
        elif not re.fullmatch(r"#(ifndef \w+|define \w+_H|endif|include <std\w+\.h>)", code):
            self.fail("expected a constant")

    def value(self, text):
        """Returns the value of a constant: a string, or an integer expression of numbers and other constants."""
        if re.fullmatch(r'"[^"]*"', text):
            return text[1:-1]
        expression = re.sub(r"\b(\d+)u\b", r"\1", text)
        for name in set(re.findall(r"\bTOLIMAN_\w+", expression)):
            found = [item.value for item in self.known + self.items if item.name == name]
            if not found:
                self.fail(f"{name} is unknown; expected a number")
            expression = re.sub(rf"\b{name}\b", str(found[0]), expression)
        if not re.fullmatch(r"[-+*() 0-9]+", expression):
            self.fail("expected an integer or a string")
        return eval(expression)  # only digits and operators, by the check above

    def base_type(self):
        const = self.taken("const")
        base = self.take()
        names = {item.name for item in self.known + self.items}
        if base not in SCALARS and base != "void" and base not in names:
            self.place -= 1
            self.fail("expected a type of <stdint.h>, size_t, double, char, void or a type declared above")
        return const, base

    def pointers(self):
        count = 0
        while self.taken("*"):
            count += 1
        return count

    def array(self):
        if not self.taken("["):
            return ""
        length = self.take()
        self.take("]")
        return length

    def arguments(self):
        """Parses (type name, ...) after the opening parenthesis."""
        found = []
        if self.taken("void"):
            if self.taken(")"):
                return found
            self.place -= 1
        while True:
            const, base = self.base_type()
            pointers = self.pointers()
            inputs = pointers == 1 and self.taken("const")
            pointers += self.pointers() if inputs else 0
            name = self.take()
            found.append(Named(name, Type(base, const, pointers, self.array(), inputs)))
            if self.take(",", ")") == ")":
                return found

    def function(self, doc):
        self.take("TOLIMAN_API")
        self.taken("TOLIMAN_MUST_CHECK")
        const, base = self.base_type()
        returns = Type(base, const, self.pointers())
        name = self.take()
        self.take("(")
        arguments = self.arguments()
        self.take("TOLIMAN_NOEXCEPT")
        self.take(";")
        if not doc:
            self.place -= 1
            self.fail(f"expected a comment above {name}")
        self.items.append(Function(name, returns, arguments, doc))

    def typedef(self, doc):
        self.take("typedef")
        if self.taken("struct"):
            name = self.take()
            if self.taken("{"):
                self.items.append(Struct(name, self.fields(), doc))
            else:
                self.items.append(Handle(name, doc))
            self.take(name)
        else:
            const, base = self.base_type()
            kind = Type(base, const, self.pointers())
            if self.taken("("):
                self.take("*")
                name = self.take()
                self.take(")")
                self.take("(")
                self.items.append(Callback(name, kind, self.arguments(), doc))
            else:
                self.items.append(Alias(self.take(), kind, doc))
        self.take(";")

    def fields(self):
        """Parses fields up to the closing brace, each with the comment on its line, otherwise that above it."""
        found, above = [], ""
        while not self.taken("}"):
            token = self.tokens[self.place]
            if token.kind == "comment":
                self.place += 1
                above = plain_comment(token.text)
                continue
            const, base = self.base_type()
            first = len(found)
            while True:
                pointers = self.pointers()
                name = self.take()
                found.append(Named(name, Type(base, const, pointers, self.array())))
                if self.take(",", ";") == ";":
                    break
            last = self.tokens[self.place - 1].line
            after = self.tokens[self.place]
            doc = above
            if after.kind == "comment" and after.line == last:
                self.place += 1
                doc = plain_comment(after.text)  # that above is of the group whose first member this is
            for field in found[first:]:
                field.doc = doc
            above = ""
        return found


def version_header(top):
    """Returns version.h as the build configures it."""
    def text(name):
        with open(os.path.join(top, name), encoding="utf-8") as stream:
            return stream.read()
    build = text("CMakeLists.txt")
    version = re.search(r"project\(toliman VERSION ((\d+)\.(\d+)\.(\d+))", build)
    values = dict(zip(("PROJECT_VERSION", "PROJECT_VERSION_MAJOR", "PROJECT_VERSION_MINOR", "PROJECT_VERSION_PATCH"),
                      version.groups()))
    values["TOLIMAN_ABI_VERSION"] = re.search(r"set\(TOLIMAN_ABI_VERSION (\d+)\)", build).group(1)
    return re.sub(r"@(\w+)@", lambda match: values[match.group(1)], text("include/toliman/version.h.in"))


def read(top):
    """Returns the model of the headers in a source tree; a header comes after those that it includes."""
    items, done = [], {"export.h"}

    def visit(header):
        if header in done:
            return
        done.add(header)
        path = f"include/toliman/{header}"
        if header == "version.h":
            path, text = path + ".in", version_header(top)
        else:
            with open(os.path.join(top, path), encoding="utf-8") as stream:
                text = stream.read()
        for included in re.findall(r"#include <toliman/(\w+\.h)>", text):
            visit(included)
        reader = Reader(path, text, items)
        reader.read()
        items.extend(reader.items)

    visit("toliman.h")
    return Model(items)
