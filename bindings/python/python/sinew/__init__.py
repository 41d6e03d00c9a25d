"""Shape-memory-alloy muscles from Python.

Two halves:

- a *running driver* (Linux) is watched and commanded: :func:`connect`, :func:`run`, :class:`Rig`, :class:`Channel`;
- *recordings* are simulated and explained, without a driver: :func:`simulate`, :func:`identify`, :func:`diagnose`,
  :func:`read_recording`, :func:`read_session`.

Everything is in SI units (metres, newtons, watts, seconds) but temperatures, which are in °C; names carry the unit. What is
not known is NaN. Every error is a :class:`SinewError` with a ``message`` and a ``remedy``.

>>> import sinew
>>> with sinew.run("bench.toml") as rig:        # doctest: +SKIP
...     with rig.lease(0.5) as lease:
...         rig["left"].stroke = 0.4
...         lease.sleep(2.0)
"""

import sys as _sys

from ._analysis import (
    Diagnosis,
    Effect,
    EffectSize,
    Identified,
    Misfit,
    Parameter,
    diagnose,
    identify,
    simulate,
)
from ._clocks import ClockMap, Mapped
from ._errors import (
    BadInput,
    DriverGone,
    Faulted,
    NoAnswer,
    NotAdmitted,
    NotRunning,
    Refusal,
    Refused,
    SinewError,
    UnknownChannel,
)
from ._recordings import Record, Table, read_recording, read_session
from ._sinew import __version__

__all__ = [
    "BadInput",
    "ClockMap",
    "Diagnosis",
    "DriverGone",
    "Effect",
    "EffectSize",
    "Faulted",
    "Identified",
    "Mapped",
    "Misfit",
    "NoAnswer",
    "NotAdmitted",
    "NotRunning",
    "Parameter",
    "Record",
    "Refusal",
    "Refused",
    "SinewError",
    "Table",
    "UnknownChannel",
    "__version__",
    "diagnose",
    "identify",
    "read_recording",
    "read_session",
    "simulate",
]

if _sys.platform == "linux":
    from ._clocks import ClockChange, Clocks
    from ._process import run
    from ._rig import (
        Channel,
        Claim,
        Fault,
        Lease,
        Rig,
        SetpointProgress,
        SetpointStream,
        Snapshot,
        Taken,
        connect,
        discover,
    )
    from ._stream import Cycle, Recorder, Stream

    __all__ += [
        "Channel",
        "Claim",
        "Cycle",
        "Fault",
        "Lease",
        "Recorder",
        "Rig",
        "SetpointProgress",
        "SetpointStream",
        "Snapshot",
        "Stream",
        "Taken",
        "connect",
        "discover",
        "run",
    ]
