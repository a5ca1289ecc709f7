"""Lists the generated files."""
import os

import fortran_layer
import model
import network
import python_raw
import python_results
import shapes
import struct_sizes


def products(top):
    """Returns a dictionary from path to text of every generated file."""
    table = model.read(top)
    shapes.attach(table, top)
    with open(os.path.join(top, "tools/gen/toliman.f90.in"), encoding="utf-8") as stream:
        template = stream.read()
    return {
        "bindings/python/toliman/_raw.py": python_raw.write(table),
        "bindings/python/toliman/_results.py": python_results.write(table),
        "bindings/python/toliman/report/_network.py": network.write(top),
        "lib/api/struct_sizes.hpp": struct_sizes.write(table),
        "bindings/fortran/toliman.f90": fortran_layer.write(table, template),
    }
