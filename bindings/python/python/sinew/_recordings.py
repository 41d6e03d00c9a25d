"""Recordings: of one channel as columns, and of a whole rig cycle by cycle."""

from __future__ import annotations

import html
import math
import os
from collections.abc import Mapping
from typing import Any, Iterator, Optional, Sequence, Tuple

import numpy as np

from . import _sinew, _state
from ._columns import arrays, pandas, recorded
from ._errors import BadInput, UnknownChannel


class Table(Mapping):
    """Columns over one time: a mapping of names (with the unit: ``position_m``) to float64 arrays of shape (samples,), in the
    order of the file. NaN is a missing sample. ``table.to_pandas()`` is a DataFrame."""

    def __init__(self, columns: Mapping) -> None:
        self._columns = dict(columns)

    def __getitem__(self, name: str) -> np.ndarray:
        try:
            return self._columns[name]
        except KeyError:
            raise BadInput(f"there is no column {name!r}", f"there are: {', '.join(self._columns)}") from None

    def __contains__(self, name: object) -> bool:
        return name in self._columns

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        return len(self._columns)

    @property
    def time_s(self) -> np.ndarray:
        """Times of the samples, s, increasing."""
        return self["time_s"]

    @property
    def samples(self) -> int:
        """Number of samples."""
        return len(self.time_s)

    def to_pandas(self):
        """A DataFrame with the columns as they are."""
        return pandas().DataFrame(self._columns)

    def save(self, path: os.PathLike | str) -> None:
        """Writes a CSV file that ``sinew`` reads, digit for digit."""
        with open(path, "w", encoding="utf-8", newline="") as file:
            file.write(",".join(self._columns) + "\n")
            for row in zip(*self._columns.values()):
                file.write(",".join("" if math.isnan(cell) else repr(float(cell)) for cell in row) + "\n")

    def __repr__(self) -> str:
        return f"<sinew.Table of {self.samples} samples: {', '.join(self._columns)}>"

    def _repr_html_(self) -> str:
        return _table_html(
            ["column", "first", "last", "least", "most"],
            [[name, *(_digits(v) for v in _ends(values))] for name, values in self._columns.items()],
            f"{self.samples} samples, {_digits(self.time_s[-1] - self.time_s[0])} s",
        )


class Record:
    """Every cycle of a rig over some time.

    ``cycle``, ``monotonic_ns`` and ``missed`` are uint64 arrays of shape (cycles,), ``time_s`` is float64 of the same shape and
    starts at 0. ``state`` is a structured array of shape (cycles, channels) with every published field:
    ``record.state["length_m"]`` are all lengths, ``record["left"]["length_m"]`` those of one channel. ``lost`` is the number
    of cycles that ran and are not in it, None where that is not known.
    """

    def __init__(
        self, heads: np.ndarray, state: np.ndarray, channels: Sequence[str], lost: Optional[int], about: Mapping
    ) -> None:
        self.cycle, self.monotonic_ns, self.missed = heads[:, 0].copy(), heads[:, 1].copy(), heads[:, 2].copy()
        self.state = state
        self.channels = tuple(channels)
        self.lost = lost
        self.about = dict(about)
        start = self.monotonic_ns[0] if len(heads) else np.uint64(0)
        self.time_s = (self.monotonic_ns - start).astype(np.float64) * 1e-9

    @property
    def fields(self) -> Tuple[str, ...]:
        """Names of the published fields."""
        return self.state.dtype.names or ()

    def __len__(self) -> int:
        return len(self.cycle)

    def __getitem__(self, channel: str) -> np.ndarray:
        return self.state[:, self._index(channel)]

    def _index(self, channel: str) -> int:
        if channel not in self.channels:
            raise UnknownChannel(f"there is no channel {channel!r}", f"there are: {', '.join(self.channels)}")
        return self.channels.index(channel)

    def to_pandas(self, channel: Optional[str] = None):
        """A DataFrame of one channel over ``time_s``, or of all of them with columns (channel, field)."""
        pd = pandas()
        index = pd.Index(self.time_s, name="time_s")
        if channel is None and len(self.channels) == 1:
            channel = self.channels[0]
        frames = {
            name: pd.DataFrame({field: self[name][field] for field in self.fields}, index=index)
            for name in (self.channels if channel is None else [channel])
        }
        return pd.concat(frames, axis=1) if channel is None else frames[channel]

    def __repr__(self) -> str:
        seconds = self.time_s[-1] if len(self) else 0.0
        return f"<sinew.Record of {len(self)} cycles, {seconds:.3f} s, {len(self.channels)} channels, lost {self.lost}>"

    def _repr_html_(self) -> str:
        rows = []
        for name in self.channels:
            length = self[name]["length_m"] if "length_m" in self.fields else np.zeros(0)
            least, most = _ends(length)[2:]
            rows.append([name, _digits(1e3 * least), _digits(1e3 * most)])
        return _table_html(["channel", "shortest, mm", "longest, mm"], rows, repr(self)[1:-1])


def read_recording(
    recording: Any, rig: Any = None, *, channel: Optional[str] = None, ignore_columns: bool = False
) -> Table:
    """The columns of a recording of one channel as the analysis understands them: time in s, everything in SI units.

    ``recording``: a ``.csv``, a ``.csv.gz`` or an ``.mcap``; or a DataFrame, Arrow table or dict of arrays. ``rig``: a rig file (path
    or text), whose ``[columns]`` translate foreign names and units, and whose wire the recording is checked against.
    Raises :class:`BadInput` with file, line, column and remedy.
    """
    columns = _sinew.read_recording(recorded(recording, "recording"), rig, channel, ignore_columns)
    return Table(arrays(columns))


def read_session(path: os.PathLike | str, *, from_s: float = -math.inf, to_s: float = math.inf) -> Record:
    """Every cycle of a session that ``sinew record`` wrote (``.mcap``), from ``from_s`` to ``to_s`` after its start."""
    session = _sinew.read_session(os.fspath(path), from_s, to_s)
    dtype = _state.dtype_of((name, kind) for name, _, kind in session.pop("fields"))
    heads = np.frombuffer(session.pop("heads"), dtype="<u8").reshape(-1, 3)
    channels = session.pop("channels")
    state = np.frombuffer(session.pop("cycles"), dtype=dtype).reshape(-1, len(channels)).copy()
    return Record(heads, state, channels, session.pop("lost"), session)


def _ends(values: np.ndarray):
    known = values[~np.isnan(values)] if len(values) else values
    if len(known) == 0:
        return [math.nan] * 4
    return [values[0], values[-1], known.min(), known.max()]


def _digits(value: float) -> str:
    return "–" if math.isnan(value) else f"{value:.5g}"


def _table_html(head: Sequence[str], rows: Sequence[Sequence[str]], caption: str) -> str:
    def line(cell: str, cells: Sequence[str]) -> str:
        return "<tr>" + "".join(f"<{cell}>{html.escape(str(c))}</{cell}>" for c in cells) + "</tr>"

    body = "".join(line("td", row) for row in rows)
    return f"<table><caption>{html.escape(caption)}</caption><thead>{line('th', head)}</thead><tbody>{body}</tbody></table>"
