"""Every cycle of a running driver, in order."""

from __future__ import annotations

import asyncio
import threading
import time
from dataclasses import dataclass
from typing import Any, AsyncIterator, Iterator, List, Mapping, Optional, Sequence, Tuple

import numpy as np

from . import _sinew, _state
from ._errors import DriverGone
from ._recordings import Record

_MOST = 4096
"""Cycles taken from the driver in one go."""

_LOOK_S = 0.1
"""So often a recording looks whether it is to end."""


@dataclass(frozen=True)
class Cycle:
    """One cycle. ``state`` is a structured array of shape (channels,) with every published field, a copy of one's own."""

    cycle: int
    """Its number, from 1; consecutive over the cycles that ran."""
    monotonic_ns: int
    """When its samples were taken: ``time.monotonic_ns()`` of this machine."""
    missed: int
    """Periods the driver has skipped since its start because it was late."""
    state: np.ndarray


class Stream:
    """All cycles from the moment it was opened: ``for cycle in rig.stream():`` or ``async for cycle in rig.stream():``.

    It buffers about two seconds. A reader that falls behind further loses the oldest cycles; ``lost`` counts them exactly.
    Iteration ends when the driver has stopped in order, and raises :class:`DriverGone` when it died.
    """

    def __init__(self, client: "_sinew.Client", channels: Sequence[str], about: Mapping) -> None:
        self._client = client
        self._stream = client.stream()
        self._channels = tuple(channels)
        self._about = dict(about)
        self._ready: Iterator[Cycle] = iter(())
        self.lost = 0

    def _take(self, timeout_s: float) -> "Tuple[np.ndarray, np.ndarray]":
        heads, states, self.lost = self._stream.take(timeout_s, _MOST)
        return np.frombuffer(heads, dtype="<u8").reshape(-1, 3), _state.of_bytes(states, len(self._channels))

    def _next(self, timeout_s: float) -> Optional[Cycle]:
        """The next cycle, or None where none came in time."""
        cycle = next(self._ready, None)
        if cycle is None:
            heads, states = self._take(timeout_s)
            self._ready = iter([Cycle(int(h[0]), int(h[1]), int(h[2]), s) for h, s in zip(heads, states)])
            cycle = next(self._ready, None)
        return cycle

    def _has_ended(self, gone: DriverGone) -> bool:
        """Whether the end of the driver was one in order; its death is an error."""
        if self._client.health() != "stopped":
            raise gone
        return True

    def __iter__(self) -> "Stream":
        return self

    def __next__(self) -> Cycle:
        while True:
            try:
                cycle = self._next(1.0)
            except DriverGone as gone:
                self._has_ended(gone)
                raise StopIteration from None
            if cycle is not None:
                return cycle

    async def __aiter__(self) -> AsyncIterator[Cycle]:
        loop = asyncio.get_running_loop()
        while True:
            try:
                # a short wait, so that a task that is cancelled leaves no thread behind for long
                cycle = next(self._ready, None) or await loop.run_in_executor(None, self._next, 0.1)
            except DriverGone as gone:
                self._has_ended(gone)
                return
            if cycle is not None:
                yield cycle

    def record(self, seconds: float) -> Record:
        """Every cycle of the next ``seconds``, as arrays; fewer where the driver stops before."""
        end = time.monotonic() + seconds
        return self._record(lambda: max(end - time.monotonic(), 0.0))

    def _record(self, left_s) -> Record:
        """Every cycle for as long as ``left_s()`` is not 0."""
        parts: List[Tuple[np.ndarray, np.ndarray]] = []
        lost = self.lost
        while left := left_s():
            try:
                parts.append(self._take(min(left, _LOOK_S)))
            except DriverGone as gone:
                self._has_ended(gone)
                break
        heads = np.concatenate([heads for heads, _ in parts]) if parts else np.zeros((0, 3), dtype="<u8")
        empty = np.zeros((0, len(self._channels)), dtype=_state.DTYPE)
        states = np.concatenate([states for _, states in parts]) if parts else empty
        return Record(heads, states, self._channels, self.lost - lost, self._about)


class Recorder:
    """Records every cycle beside the code of a block, see :meth:`Rig.recorder`. Its ``record`` is there when the block has ended."""

    def __init__(self, stream: Stream) -> None:
        self._stream = stream
        self._ended = threading.Event()
        self._failed: Optional[BaseException] = None
        self._thread = threading.Thread(target=self._work, name="sinew recorder", daemon=True)
        self.record: Optional[Record] = None

    def _work(self) -> None:
        try:
            self.record = self._stream._record(lambda: 0.0 if self._ended.is_set() else 1.0)
        except BaseException as failed:  # said where the block ends
            self._failed = failed

    def __enter__(self) -> "Recorder":
        self._thread.start()
        return self

    def __exit__(self, kind: Any, error: Any, trace: Any) -> None:
        self._ended.set()
        self._thread.join()
        if self._failed is not None and error is None:
            raise self._failed
