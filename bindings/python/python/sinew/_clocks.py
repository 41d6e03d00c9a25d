"""Clocks beside the driver's, whose stamps are all ``time.monotonic_ns()``."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from typing import Optional, Tuple

from . import _sinew


@dataclass(frozen=True)
class Mapped:
    """A time on another clock."""

    ns: int
    """The time, ns."""
    error_ns: int
    """What it is off by at the most, ns."""

    def __str__(self) -> str:
        return f"{self.ns} ± {self.error_ns} ns"


def _mapped(found: Optional[Tuple[int, int]]) -> Optional[Mapped]:
    return None if found is None else Mapped(*found)


class ClockMap:
    """The clock of another device, a data acquisition's or a camera's, learnt from pairs of times.

    Feed it with what there is: :meth:`bracket` where the device can be asked for its time, :meth:`late` for stamps that come with its
    data some time later. What is assumed of it: its rate is within ``max_rate_ppm`` (200) of the driver's and changes by at most
    ``drift_ppm_per_s`` (0.02); its stamps are rounded to ``resolution_ns``; late ones are never delayed by less than
    ``least_delay_ns`` ± ``least_delay_error_ns`` (nothing one-way can tell: left at 0, answers are too late by just that).

    >>> import sinew
    >>> daq = sinew.ClockMap()
    >>> daq.bracket(5_000_000_000, 100_000, 5_000_040_000)
    >>> daq.bracket(15_000_000_000, 10_000_300_000, 15_000_040_000)
    >>> when = daq.driver_at(5_000_200_000)
    >>> abs(when.ns - 10_000_000_000) < 100_000 and when.error_ns < 300_000
    True
    """

    def __init__(
        self,
        *,
        max_rate_ppm: Optional[float] = None,
        drift_ppm_per_s: Optional[float] = None,
        resolution_ns: int = 0,
        least_delay_ns: int = 0,
        least_delay_error_ns: int = 0,
        settle_s: Optional[float] = None,
        window_s: Optional[float] = None,
        pairs: Optional[int] = None,
    ) -> None:
        self._map = _sinew.ClockMap(
            max_rate_ppm, drift_ppm_per_s, resolution_ns, least_delay_ns, least_delay_error_ns, settle_s, window_s, pairs
        )

    def bracket(self, before_ns: int, other_ns: int, after_ns: int) -> Optional[str]:
        """Adds a time the device showed between two times of ``time.monotonic_ns()``. Returns why it has begun anew, where it has."""
        return self._map.bracket(before_ns, other_ns, after_ns)

    def pair(self, driver_ns: int, other_ns: int, error_ns: int) -> Optional[str]:
        """Adds two times of one moment, the driver's off by ``error_ns`` at the most. Returns as :meth:`bracket`."""
        return self._map.pair(driver_ns, other_ns, error_ns)

    def late(self, received_ns: int, other_ns: int) -> Optional[str]:
        """Adds a stamp of the device and when it was received, in the order in which they were. Returns as :meth:`bracket`."""
        return self._map.late(received_ns, other_ns)

    def driver_at(self, other_ns: int) -> Optional[Mapped]:
        """The driver's time of a time of the device; None where it is not known."""
        return _mapped(self._map.driver_at(other_ns))

    def other_at(self, driver_ns: int) -> Optional[Mapped]:
        """The device's time of a driver's stamp; None where it is not known."""
        return _mapped(self._map.other_at(driver_ns))

    @property
    def rate_ppm(self) -> Optional[Tuple[float, float]]:
        """What the device's clock runs fast by, and what that is off by at the most, ppm."""
        return self._map.rate_ppm()

    def __len__(self) -> int:
        """How many pairs it holds."""
        return self._map.pairs()

    def clear(self) -> None:
        """Forgets all of it."""
        self._map.clear()


if sys.platform == "linux":

    @dataclass(frozen=True)
    class ClockChange:
        """What became of this machine's clocks between two comparisons."""

        step_ns: Optional[int]
        """What the system's clock was set forward by (negative: back), ns; None where it was not set."""
        slew_ppm: float
        """What it was corrected by beside the machine's counter, ppm."""
        slew_error_ppm: float
        """What that is off by at the most, ppm."""
        suspended_ns: int
        """How long the machine was suspended, ns."""
        text: str

        def __str__(self) -> str:
            return self.text

    class Clocks:
        """The clocks of this machine beside the driver's, compared when it is made and by :meth:`refresh`.

        >>> import sinew, time
        >>> at = sinew.Clocks().system(time.monotonic_ns())
        >>> abs(at.ns - time.time_ns()) < 1_000_000_000 and at.error_ns < 1_000_000
        True
        """

        def __init__(self) -> None:
            self._clocks = _sinew.Clocks()

        def system(self, monotonic_ns: int) -> Mapped:
            """System time of a driver's stamp, ns since 1970 (UTC), as the clock was set at the comparison."""
            return Mapped(*self._clocks.system(monotonic_ns))

        def tai(self, monotonic_ns: int) -> Optional[Mapped]:
            """TAI of a driver's stamp, ns since 1970; None where the system does not know it."""
            return _mapped(self._clocks.tai(monotonic_ns))

        def boottime(self, monotonic_ns: int) -> Mapped:
            """Boot time of a driver's stamp, ns."""
            return Mapped(*self._clocks.boottime(monotonic_ns))

        def driver_at_system(self, system_ns: int) -> Mapped:
            """The driver's time of a moment of system time."""
            return Mapped(*self._clocks.driver_at_system(system_ns))

        @property
        def utc_error_ns(self) -> Optional[int]:
            """What system time is off from UTC by at the most, as its synchronisation says, ns; None where it is not synchronised."""
            return self._clocks.utc_error_ns()

        def refresh(self) -> ClockChange:
            """Compares anew, and says what became of the clocks since the last time."""
            return ClockChange(*self._clocks.refresh())
