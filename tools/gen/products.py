"""Lists the generated files. tools/cmake/generated.cmake lists them too."""
import os

import fortran_layer
import model
import network
import options
import python_raw
import python_results
import shapes
import struct_sizes


def products(top):
    """Returns a dictionary from path below the build folder to text of every generated file."""
    table = model.read(top)
    shapes.attach(table, top)
    with open(os.path.join(top, "tools/gen/toliman.f90.in"), encoding="utf-8") as stream:
        template = stream.read()
    return {
        "python/toliman/_raw.py": python_raw.write(table),
        "python/toliman/_results.py": python_results.write(table),
        "python/toliman/report/_network.py": network.write(top),
        "generated/api/struct_sizes.hpp": struct_sizes.write(table),
        "generated/api/option_rules.hpp": options.write(table),
        "fortran/toliman.f90": fortran_layer.write(table, template),
    }
