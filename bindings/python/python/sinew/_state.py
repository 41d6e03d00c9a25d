"""What a channel publishes, as NumPy sees it."""

from __future__ import annotations

import numpy as np

from . import _sinew

FIELDS = _sinew.fields()
"""Name, dtype, unit and meaning of every field."""

ALIASES = {"length_m": "observed_length_m"}
"""Names of once that fields are found by as well: NumPy's titles."""


def dtype_of(fields) -> np.dtype:
    """Of (name, kind) pairs."""
    return np.dtype([((ALIASES[name], name) if name in ALIASES else name, kind) for name, kind in fields])


DTYPE = dtype_of((name, kind) for name, kind, _, _ in FIELDS)
"""One channel in one cycle, in SI units; NaN is not known."""

MODES = dict(_sinew.modes())
"""What a channel is doing, by the code in its state."""

FAULTS = {code: (flag, cause, remedy) for code, flag, cause, remedy in _sinew.fault_table()}
"""Flag, cause and remedy of every fault, by the code in its state."""


def of_bytes(cells: bytes, channels: int) -> np.ndarray:
    """States of shape (cycles, channels). A copy: it stays as it is."""
    return np.frombuffer(cells, dtype=DTYPE).reshape(-1, channels).copy()
