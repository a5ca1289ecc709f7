"""Forwards the library's diagnostic messages to Python's logging, logger "toliman"."""
from __future__ import annotations

import logging

from . import _raw

_log = logging.getLogger("toliman")


def _logged(level: int, text: bytes, _: object) -> None:
    if level == _raw.TOLIMAN_LOG_WARNING:
        _log.warning("%s", text.decode(errors="replace"))
    else:
        _log.info("%s", text.decode(errors="replace"))


# One callback for all calls: C may keep the pointer, so it must never be collected.
log = _raw.toliman_log_fn(_logged)
