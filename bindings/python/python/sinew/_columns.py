"""Columns of numbers, whatever they come in."""

from __future__ import annotations

import os
from typing import Any, List, Mapping, Tuple, Union

import numpy as np

from ._errors import BadInput

Recorded = Union[str, os.PathLike, Tuple[str, List[Tuple[str, bytes]]]]


def recorded(data: Any, name: str) -> Recorded:
    """A path as it is; a DataFrame, an Arrow table, a mapping of arrays or a structured array as named columns of bytes."""
    if isinstance(data, (str, os.PathLike)):
        return os.fspath(data)
    columns = [(column, _numbers(values, name, column)) for column, values in _columns(data, name)]
    if not columns:
        raise BadInput(f"{name} has no columns", "give a column time_s and those that were measured")
    return (name, columns)


def _columns(data: Any, name: str):
    if isinstance(data, np.ndarray) and data.dtype.names:
        return [(column, data[column]) for column in data.dtype.names]
    if isinstance(data, Mapping):
        return [(str(column), values) for column, values in data.items()]
    if hasattr(data, "column_names") and hasattr(data, "column"):  # Arrow
        return [(column, data.column(column).to_numpy()) for column in data.column_names]
    if hasattr(data, "columns"):  # pandas and its relatives
        return [(str(column), data[column]) for column in data.columns]
    raise BadInput(
        f"{name}: a {type(data).__name__} is no recording",
        "give a path, a DataFrame, an Arrow table or a dict of arrays, with a column time_s",
    )


def _numbers(values: Any, name: str, column: str) -> bytes:
    try:
        numbers = np.asarray(values, dtype="<f8")
    except (TypeError, ValueError) as error:
        raise BadInput(f"{name}: column {column!r} holds no numbers ({error})", "convert it, or leave it out") from None
    if numbers.ndim != 1:
        raise BadInput(
            f"{name}: column {column!r} has {numbers.ndim} dimensions", "give one number a sample: a column is a vector"
        )
    return numbers.tobytes()


def arrays(columns: List[Tuple[str, bytes]]) -> dict:
    """Columns of bytes as arrays of float64, each of one number a sample."""
    return {name: np.frombuffer(values, dtype="<f8").copy() for name, values in columns}


def pandas():
    """pandas, or what to do where it is not there."""
    try:
        import pandas
    except ImportError:
        raise BadInput("there is no pandas", "pip install pandas, or use the arrays as they are") from None
    return pandas
