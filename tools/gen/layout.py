"""Asks the C compiler for the layout of the model: values of constants, sizes of structs, offsets of members."""
import os
import subprocess
import tempfile

from model import Callback, Constant, Function, Struct, version_header


def same_types(table):
    """Yields C code that compiles only if every declaration of the model matches the headers."""
    for item in table.all(Function):
        arguments = ", ".join(argument.type.declare(argument.name) for argument in item.arguments) or "void"
        yield f"{item.returns.declare(item.name)}({arguments});"
    for item in table.all(Callback):
        arguments = ", ".join(argument.type.declare(argument.name) for argument in item.arguments)
        yield f"typedef {item.returns.declare(f'(*same_{item.name})')}({arguments});"
        yield f"_Static_assert(__builtin_types_compatible_p({item.name}, same_{item.name}), \"{item.name}\");"
    for item in table.all(Struct):
        for field in item.fields:
            name = f"{item.name}_{field.name}"
            yield f"typedef {field.type.declare('same_' + name)};"
            yield (f"_Static_assert(__builtin_types_compatible_p(same_{name}, __typeof__((({item.name} *)0)->{field.name}))"
                   f", \"{name}\");")


def program(table):
    """Returns a C program that prints a line "name value" for every constant, struct and member."""
    lines = ["#include <stddef.h>", "#include <stdio.h>", "#include <toliman/toliman.h>", *same_types(table),
             "int main(void) {"]
    for item in table.all(Constant):
        form, cast = ("%s", "") if isinstance(item.value, str) else ("%lld", "(long long)")
        lines.append(f'printf("{item.name} {form}\\n", {cast}{item.name});')
    for item in table.all(Struct):
        lines.append(f'printf("{item.name} %zu\\n", sizeof({item.name}));')
        lines += [f'printf("{item.name}.{field.name} %zu\\n", offsetof({item.name}, {field.name}));' for field in item.fields]
    return "\n".join(lines + ["return 0;", "}"])


def measure(table, top):
    """Returns a dictionary from name to value (as text), measured by the C compiler with the headers of a tree."""
    with tempfile.TemporaryDirectory() as folder:
        os.mkdir(os.path.join(folder, "toliman"))
        for name, text in (("toliman/version.h", version_header(top)), ("layout.c", program(table))):
            with open(os.path.join(folder, name), "w", encoding="utf-8") as stream:
                stream.write(text)
        binary = os.path.join(folder, "layout")
        made = subprocess.run(["cc", "-std=c11", "-Wall", "-Wextra", "-Werror", f"-I{os.path.join(top, 'include')}",
                               f"-I{folder}", os.path.join(folder, "layout.c"), "-o", binary], stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, universal_newlines=True)
        if made.returncode != 0:
            raise SystemExit(f"the headers differ from the model of tools/gen/model.py:\n{made.stdout[:2000]}")
        printed = subprocess.run([binary], check=True, stdout=subprocess.PIPE, universal_newlines=True).stdout
    return dict(line.split(" ") for line in printed.splitlines())
