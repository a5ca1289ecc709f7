"""Tests that constants, sizes and offsets in ctypes and Fortran equal the C compiler's, and so do the types in the
generator's table."""
import ctypes
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

from package import ROOT as TOP
from toliman import _raw

BUILD = pathlib.Path(os.environ["TOLIMAN"]).parents[1]
FORTRAN = BUILD / "fortran" / "toliman.f90"
sys.dont_write_bytecode = True
sys.path.insert(0, str(TOP / "tools" / "gen"))

import fortran  # noqa: E402
import layout  # noqa: E402
import model  # noqa: E402

TABLE = model.read(TOP)


def run(*command, folder):
    """Its output; a failure shows the compiler's messages."""
    done = subprocess.run([str(word) for word in command], cwd=folder, universal_newlines=True, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT)
    if done.returncode != 0:
        raise AssertionError(done.stdout[:2000])
    return done.stdout


def fortran_program():
    structs = TABLE.all(model.Struct)
    lines = ["program layout", "use, intrinsic :: iso_c_binding", "use toliman", "implicit none"]
    lines += [f"type({item.name}), target :: s{place}" for place, item in enumerate(structs)]
    for item in TABLE.all(model.Constant):
        kind = "2a" if isinstance(item.value, str) else "a, i0"
        lines.append(f"print '({kind})', '{item.name} ', {fortran.fortran_name(TABLE, item)}")
    for place, item in enumerate(structs):
        lines.append(f"print '(a, i0)', '{item.name} ', c_sizeof(s{place})")
        lines += [f"call offset('{item.name}.{field.name} ', c_loc(s{place}), c_loc(s{place}%{field.name}))"
                  for field in item.fields]
        if item.sized:
            lines.append(f"if (s{place}%struct_size /= c_sizeof(s{place})) error stop 'struct_size'")
    return "\n".join(lines) + """
contains
subroutine offset(name, whole, part)
    character(len=*), intent(in) :: name
    type(c_ptr), intent(in) :: whole, part
    print '(a, i0)', name, transfer(part, 0_c_intptr_t) - transfer(whole, 0_c_intptr_t)
end subroutine
end program layout
"""


def width(text):
    """The significant part of a type in a C declaration, regardless of its style."""
    if "*" in text:
        return "pointer"
    for words, found in ((("double",), "double"), (("int64_t", "size_t", "long"), "8 bytes"),
                         (("int", "status"), "4 bytes")):
        if any(word in text for word in words):
            return found
    return text.split()[0]


def width_of(kind):
    """The same for a type of the table."""
    return "pointer" if TABLE.kind(kind.base) is model.Callback else width(kind.declare(""))


class Layout(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        kept = tempfile.TemporaryDirectory()
        cls.addClassCleanup(kept.cleanup)
        cls.folder = pathlib.Path(kept.name)
        cls.c = layout.measure(TABLE, TOP)

    def test_python(self):
        found = {}
        for item in TABLE.all(model.Constant):
            found[item.name] = str(getattr(_raw, item.name))
        for item in TABLE.all(model.Struct):
            kind = getattr(_raw, item.name)
            found[item.name] = str(ctypes.sizeof(kind))
            found.update({f"{item.name}.{field.name}": str(getattr(kind, field.name).offset) for field in item.fields})
            if item.sized:
                self.assertEqual(kind().struct_size, ctypes.sizeof(kind))
        self.assertEqual(found, self.c)
        self.assertGreater(len(found), 300)

    def test_fortran(self):
        (self.folder / "layout.f90").write_text(fortran_program())
        run("gfortran", "-O0", "-std=f2018", FORTRAN, "layout.f90", "-o", "f",
            f"-L{BUILD / 'lib'}", "-ltoliman", f"-Wl,-rpath,{BUILD / 'lib'}", folder=self.folder)
        found = dict(line.split(" ") for line in run("./f", folder=self.folder).splitlines())
        self.assertEqual(found, self.c)

    def test_fortran_types(self):
        """The C declarations that gfortran derives from its structs and interfaces, compared with the header."""
        output = run("gfortran", "-fsyntax-only", "-fc-prototypes", FORTRAN, folder=self.folder)
        found = {}
        for name, fields in re.findall(r"^typedef struct (\w+) {\n(.*?)^}", output, re.M | re.S):
            found[name] = [width(field) for field in fields.splitlines()]
        for returned, stars, name, arguments in re.findall(r"^(\w+) (\**)(toliman_\w+) \((.*)\);$", output, re.M):
            found[name] = [width(returned + stars), *map(width, filter(None, arguments.split(", ")))]
        wanted = {item.name: [width_of(field.type) for field in item.fields] for item in TABLE.all(model.Struct)}
        for item in TABLE.all(model.Function) + TABLE.all(model.Callback):
            arguments = ["pointer" if argument.type.array else width_of(argument.type) for argument in item.arguments]
            wanted[item.name] = [width_of(item.returns), *arguments]
        self.assertEqual({name: found.get(name) for name in wanted}, wanted)


if __name__ == "__main__":
    unittest.main()
