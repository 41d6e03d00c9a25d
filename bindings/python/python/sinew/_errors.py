"""What can go wrong, each with what to do about it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Optional, Sequence


class SinewError(Exception):
    """Every error of this package. ``message`` says what is wrong and where, ``remedy`` what to do about it."""

    def __init__(self, message: str, remedy: str = "") -> None:
        super().__init__(f"{message}; {remedy}" if remedy else message)
        self.message = message
        self.remedy = remedy


class BadInput(SinewError, ValueError):
    """Something that was given cannot be used: a file, a column, a value, a name."""


class UnknownChannel(BadInput, LookupError):
    """The rig has no channel of that name."""


class NotRunning(SinewError):
    """No driver of that rig is running, or it has not finished starting."""


class DriverGone(SinewError):
    """The driver this program was connected to has stopped or died. Connect again for the next one."""


class NoAnswer(SinewError):
    """The driver has not answered in time."""


class NotAdmitted(SinewError):
    """The driver is another user's, who lets only others look or command."""


@dataclass(frozen=True)
class Refusal:
    """Why one channel was refused what it was asked for."""

    channel: str
    kind: str
    """What was asked for: length, stroke, duty, force, off, reset or stop."""
    value: float
    """The value asked for, in SI units; 0 where the kind has none."""
    message: str
    remedy: str
    fault: Optional[str] = None
    """The flag of the fault that stands in the way, if one does."""
    low: Optional[float] = None
    """Smallest value that would have been taken, where that is the reason."""
    high: Optional[float] = None
    """Largest value that would have been taken, where that is the reason."""


class Refused(SinewError):
    """The driver refused a request; it has carried out none of it. ``refusals`` has each channel's own reason."""

    def __init__(self, message: str, remedy: str = "", refusals: Sequence[Refusal] = ()) -> None:
        super().__init__(message, remedy)
        self.refusals = tuple(refusals)


class Faulted(SinewError):
    """A channel is off by a latched fault. ``faults`` has them by the names of their channels."""

    def __init__(self, message: str, remedy: str = "", faults: Optional[dict] = None) -> None:
        super().__init__(message, remedy)
        self.faults = dict(faults or {})
