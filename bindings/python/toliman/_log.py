"""Messages of the library go to Python's logging as "toliman"."""
from __future__ import annotations

import logging

from . import _raw

_log = logging.getLogger("toliman")


def _logged(level: int, text: bytes, _: object) -> None:
    if level == _raw.TOLIMAN_LOG_WARNING:
        _log.warning("%s", text.decode(errors="replace"))
    else:
        _log.info("%s", text.decode(errors="replace"))


# One for all calls, which therefore outlives each.
log = _raw.toliman_log_fn(_logged)
