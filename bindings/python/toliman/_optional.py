"""Packages that the bindings need for some functions only."""
from __future__ import annotations

import importlib
import types


def optional(module: str, use: str) -> types.ModuleType:
    """Imports an optional package. use: completes "is needed for" in the ImportError without it."""
    name = module.partition(".")[0]
    try:
        return importlib.import_module(module)
    except ModuleNotFoundError as error:
        if (error.name or "").partition(".")[0] != name:  # it is there, but lacks another one
            raise
        raise ImportError(f"{name} is needed for {use}: install it (Debian: python3-{name.lower()}, pip: {name})",
                          name=name) from None
