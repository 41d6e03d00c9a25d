"""A running driver: what it knows, and how it is commanded."""

from __future__ import annotations

import difflib
import html
import math
import subprocess
import time
from dataclasses import dataclass
from typing import Any, Dict, Iterator, List, Mapping, Optional, Sequence, Set, Tuple, Union

import numpy as np

from . import _sinew, _state
from ._clocks import Clocks
from ._errors import BadInput, DriverGone, Faulted, NotRunning, SinewError, UnknownChannel
from ._recordings import Record
from ._stream import Recorder, Stream

Setpoints = Union[float, Mapping[str, float], Sequence[float], np.ndarray]
"""For every channel the same, by the names of channels, or one a channel in the rig's order (NaN: leave it as it is)."""


@dataclass(frozen=True)
class Fault:
    """Why a channel is off."""

    flag: str
    """Its short name, as in ``sinew status``."""
    cause: str
    remedy: str

    def __str__(self) -> str:
        return f"{self.flag}: {self.cause}; {self.remedy}"


@dataclass(frozen=True)
class Taken:
    """What became of a request."""

    cycle: int
    """The cycle from which on all of it is in force."""
    hold_s: float
    """The lease as granted, s; 0 where there is none."""


@dataclass(frozen=True)
class Snapshot:
    """The latest cycle. ``state`` is a structured array of shape (channels,) with every published field, a copy of one's own."""

    cycle: int
    """Its number, from 1; 0 before the first."""
    monotonic_ns: int
    """When its samples were taken: ``time.monotonic_ns()`` of this machine."""
    missed: int
    """Periods the driver has skipped since its start because it was late."""
    state: np.ndarray


def discover() -> List[str]:
    """Names of the rigs a driver is running for: one's own, and those whose driver lets other users look."""
    return _sinew.discover()


def connect(rig: Optional[str] = None, *, patience_s: float = 2.0, answer_s: float = 1.0) -> "Rig":
    """Connects to the driver of this rig; to the only one there is where none is named.

    ``patience_s``: how long to wait for a driver that is just starting. ``answer_s``: how long for answers to commands.
    Raises :class:`NotRunning` with the rigs that are.
    """
    if rig is None:
        running = discover()
        if not running:
            raise NotRunning("no driver is running", "start one with `sinew run RIG.toml` or sinew.run()")
        if len(running) > 1:
            raise BadInput(f"{len(running)} drivers are running", f"name one of them: {', '.join(running)}")
        rig = running[0]
    return Rig(_sinew.Client.connect(rig, patience_s, answer_s))


class Channel:
    """One channel of a rig: ``rig["left"]``.

    What is read is measured or estimated, what is assigned is commanded: ``channel.stroke = 0.4`` asks for 40 % of the stroke,
    and ``channel.stroke`` is how far it has come. A setpoint holds for the channel's default lease (:attr:`lease_s`)
    unless it is given within :meth:`Rig.lease` or with ``hold=``, and has to be renewed before.
    """

    def __setattr__(self, name: str, value: Any) -> None:
        # A setpoint that is mistyped would be a new attribute, and the wire would stay where it is.
        if "lease_s" in self.__dict__ and not hasattr(type(self), name) and name not in self.__dict__:
            near = difflib.get_close_matches(name, ("stroke", "length_m", "duty"), 1, 0.5)
            hint = f"; did you mean {near[0]!r}?" if near else "; what is assigned is stroke, length_m or duty"
            raise AttributeError(f"a channel has no {name!r}{hint}")
        object.__setattr__(self, name, value)

    def __init__(self, rig: "Rig", index: int, info: Mapping) -> None:
        self._rig, self.index = rig, index
        self.name: str = info["name"]
        self.min_length_m: float = info["min_length_m"]
        self.max_length_m: float = info["max_length_m"]
        self.hot_length_m: float = info["hot_length_m"]
        self.cold_length_m: float = info["cold_length_m"]
        self.rest_length_m: float = info["rest_length_m"]
        self.max_duty: float = info["max_duty"]
        self.max_current_a: float = info["max_current_a"]
        self.max_power_w: float = info["max_power_w"]
        self.max_temperature_c: float = info["max_temperature_c"]
        self.lease_s: float = info["lease_s"]

    @property
    def state(self) -> np.void:
        """Every published field of the latest cycle, by name: ``channel.state["resistance_ohm"]``."""
        return self._rig.state[self.index]

    @property
    def length_m(self) -> float:
        """Wire length, m, without the noise of one sample; assigned: the length to hold."""
        return float(self.state["length_m"])

    @length_m.setter
    def length_m(self, value: float) -> None:
        self.set("length", value)

    @property
    def stroke(self) -> float:
        """Share of the stroke, 0 cold and long, 1 hot and short; assigned: the share to hold."""
        stroke_m = self.cold_length_m - self.hot_length_m
        return (self.cold_length_m - self.length_m) / stroke_m if stroke_m > 0 else math.nan

    @stroke.setter
    def stroke(self, value: float) -> None:
        self.set("stroke", value)

    @property
    def duty(self) -> float:
        """Duty given for the next period, 0..1; assigned: the duty to give, without control."""
        return float(self.state["duty"])

    @duty.setter
    def duty(self, value: float) -> None:
        self.set("duty", value)

    @property
    def target_m(self) -> float:
        """The length it is commanded to, m; NaN without one."""
        return float(self.state["target_m"])

    @property
    def temperature_c(self) -> float:
        """Estimated wire temperature, °C."""
        return float(self.state["temperature_c"])

    @property
    def resistance_ohm(self) -> float:
        """Measured resistance, Ω."""
        return float(self.state["resistance_ohm"])

    @property
    def mode(self) -> str:
        """What it is doing: waiting, off, length, duty, force, program or fault."""
        code = int(self.state["mode"])
        return _state.MODES.get(code, f"mode {code}")

    @property
    def owner(self) -> Optional[int]:
        """Process id of the client that has claimed it, if any."""
        return int(self.state["owner"]) or None

    @property
    def fault(self) -> Optional[Fault]:
        """The latched fault, if any."""
        return self._rig._fault(int(self.state["fault"]))

    def set(self, kind: str, value: float = 0.0, *, hold: Optional[float] = None) -> Taken:
        """Asks for a ``length`` (m), ``stroke`` (0..1), ``duty`` (0..1) or ``force`` (N), for ``hold`` seconds.

        Returns once the driver has taken it. Raises :class:`Refused` with the reason and what would be right.
        """
        return self._rig._ask([(self.index, kind, float(value))], hold)

    def off(self) -> Taken:
        """Only the sensing pulse from now on."""
        return self._rig._ask([(self.index, "off", 0.0)], 0.0)

    def reset(self) -> None:
        """Clears a latched fault whose cause has gone."""
        self._rig._client.command(self.index, "reset", 0.0, 0.0)

    def __repr__(self) -> str:
        fault = self.fault
        what = f"fault {fault.flag}" if fault else self.mode
        return f"<sinew.Channel {self.name}: {what}, {1e3 * self.length_m:.2f} mm, {self.temperature_c:.0f} °C>"


class Lease:
    """Setpoints that live as long as a block of code, see :meth:`Rig.lease`."""

    def __init__(self, rig: "Rig", hold_s: float) -> None:
        self._rig, self.hold_s = rig, float(hold_s)
        self._given: Dict[int, Tuple[str, float]] = {}
        self._outer: Optional[Lease] = None

    def renew(self) -> Optional[Taken]:
        """Gives every setpoint of this block again, all in one cycle. Raises :class:`Refused` where a channel cannot hold it
        any more, as by a fault."""
        return self._rig._ask([(index, *setpoint) for index, setpoint in self._given.items()], self.hold_s)

    def sleep(self, seconds: float) -> None:
        """Sleeps, and renews the setpoints three times in a lease meanwhile."""
        end = time.monotonic() + seconds
        while (left := end - time.monotonic()) > 0:
            if self._given:
                self.renew()
            time.sleep(max(0.0, min(left, self.hold_s / 3)))

    def __enter__(self) -> "Lease":
        self._outer, self._rig._lease = self._rig._lease, self
        return self

    def __exit__(self, kind: Any, error: Any, trace: Any) -> None:
        self._rig._lease = self._outer
        given, self._given = sorted(self._given), {}
        self._rig._leave(given, error)


@dataclass(frozen=True)
class SetpointProgress:
    """What became of the messages of a stream of setpoints so far. Those in none of the other counts are on their way."""

    sent: int
    """Messages given to :meth:`SetpointStream.send`."""
    taken: int
    """In force."""
    overtaken: int
    """Not carried out because a later one, or an ``off``, has overtaken them."""
    late: int
    """Not carried out because they came after their deadline."""
    refused: int
    """Refused for another reason."""
    held_back: int
    """Not sent because too many were without an answer."""
    cycle: int
    """The cycle in which the last one was taken; 0: none yet."""


class SetpointStream:
    """Setpoints that nobody waits for, see :meth:`Rig.setpoints`. For one thread at a time.

    At the end of a ``with`` block, however it ends, the channels it commanded go off.
    """

    def __init__(self, rig: "Rig", stream: "_sinew.Setpoints") -> None:
        self._rig, self._stream = rig, stream
        self._given: Set[int] = set()

    def send(
        self,
        *,
        stroke: Optional[Setpoints] = None,
        length_m: Optional[Setpoints] = None,
        duty: Optional[Setpoints] = None,
        force_n: Optional[Setpoints] = None,
        off: Union[str, Sequence[str]] = (),
    ) -> SetpointProgress:
        """Sends a message for any number of channels, all or none, as :meth:`Rig.set` takes them; does not wait.

        :class:`Refused` is about an earlier message: this one is on its way all the same. With every other error it was not sent.
        """
        wanted = self._rig._wanted(stroke, length_m, duty, force_n, off)
        self._given.update(index for index, kind, _ in wanted)
        return SetpointProgress(*self._stream.send(wanted))

    @property
    def progress(self) -> SetpointProgress:
        """What became of the messages. Looks for answers; raises :class:`Refused` once for each message that was."""
        return SetpointProgress(*self._stream.poll())

    def __enter__(self) -> "SetpointStream":
        return self

    def __exit__(self, kind: Any, error: Any, trace: Any) -> None:
        given, self._given = sorted(self._given), set()
        self._rig._leave(given, error)


class Claim:
    """Channels that nobody else commands while a block of code runs, see :meth:`Rig.claim`."""

    def __init__(self, rig: "Rig", channels: Sequence[int], priority: int, hold_s: float) -> None:
        self._rig, self._channels = rig, tuple(channels)
        self.priority, self.hold_s = priority, hold_s

    def renew(self) -> None:
        """Holds on to them; every setpoint for a channel does so for that channel."""
        self._rig._client.set_many([(index, "claim", float(self.priority)) for index in self._channels], self.hold_s)

    def __enter__(self) -> "Claim":
        self.renew()
        return self

    def __exit__(self, kind: Any, error: Any, trace: Any) -> None:
        try:
            self._rig._client.set_many([(index, "release", 0.0) for index in self._channels], 0.0)
        except SinewError:
            if error is None and self._rig.health == "running":
                raise


class Rig:
    """A running driver, from :func:`connect` or :func:`run`. It may be used from several threads.

    ``rig["left"]`` is a :class:`Channel`, ``for channel in rig`` are all of them. ``rig.state`` is a structured array of shape
    (channels,) with every published field of the latest cycle: ``rig.state["length_m"]``.
    """

    def __init__(self, client: "_sinew.Client", process: Optional[subprocess.Popen] = None) -> None:
        info = client.info()
        self._client, self._process = client, process
        self._lease: Optional[Lease] = None
        self._channels = [Channel(self, index, row) for index, row in enumerate(info["channels"])]
        self._by_name = {channel.name: channel for channel in self._channels}
        self.name: str = info["rig"]
        self.pid: int = info["pid"]
        self.rate_hz: float = info["rate_hz"]
        self.is_simulated: bool = info["simulated"]

    @property
    def channels(self) -> Tuple[str, ...]:
        """Names of the channels, in the rig's order."""
        return tuple(self._by_name)

    def __getitem__(self, channel: Union[str, int]) -> Channel:
        if isinstance(channel, str):
            if channel not in self._by_name:
                raise UnknownChannel(f"there is no channel {channel!r}", f"there are: {', '.join(self.channels)}")
            return self._by_name[channel]
        return self._channels[channel]

    def __iter__(self) -> Iterator[Channel]:
        return iter(self._channels)

    def __len__(self) -> int:
        return len(self._channels)

    def __contains__(self, channel: object) -> bool:
        return channel in self._by_name

    @property
    def state(self) -> np.ndarray:
        """Every channel in the latest cycle: a structured array of shape (channels,), a copy of one's own."""
        return self.snapshot().state

    def snapshot(self) -> Snapshot:
        """The latest cycle: one whole one, never parts of two. Does not wait."""
        cycle, monotonic_ns, missed, cells = self._client.latest()
        return Snapshot(cycle, monotonic_ns, missed, _state.of_bytes(cells, len(self))[0])

    @property
    def clocks(self) -> Clocks:
        """The clocks of this machine beside the driver's, compared now: system time, TAI and boot time of its stamps, with the error.

        >>> rig.clocks.system(rig.snapshot().monotonic_ns)        # doctest: +SKIP
        Mapped(ns=1785598212345678901, error_ns=41)
        """
        return Clocks()

    def wait(self, timeout: float = 1.0) -> bool:
        """Sleeps until the driver has something new, up to ``timeout`` seconds; False when nothing came."""
        return self._client.wait(timeout)

    def set(
        self,
        *,
        stroke: Optional[Setpoints] = None,
        length_m: Optional[Setpoints] = None,
        duty: Optional[Setpoints] = None,
        force_n: Optional[Setpoints] = None,
        off: Union[str, Sequence[str]] = (),
        hold: Optional[float] = None,
    ) -> Taken:
        """Commands many channels at once: all of it is in force from one cycle on, or none of it.

        >>> rig.set(stroke={"left": 0.4, "right": 0.2}, hold=0.5)        # doctest: +SKIP
        >>> rig.set(stroke=np.linspace(0, 0.5, 18))                      # doctest: +SKIP

        Raises :class:`Refused`, whose ``refusals`` have each channel's own reason.
        """
        return self._ask(self._wanted(stroke, length_m, duty, force_n, off), hold)

    def _wanted(
        self,
        stroke: Optional[Setpoints],
        length_m: Optional[Setpoints],
        duty: Optional[Setpoints],
        force_n: Optional[Setpoints],
        off: Union[str, Sequence[str]],
    ) -> List[Tuple[int, str, float]]:
        wanted: List[Tuple[int, str, float]] = []
        for kind, given in (("stroke", stroke), ("length", length_m), ("duty", duty), ("force", force_n)):
            wanted += [(index, kind, value) for index, value in self._spread(given, kind)]
        wanted += [(self[name].index, "off", 0.0) for name in ([off] if isinstance(off, str) else off)]
        if not wanted:
            raise BadInput("nothing is asked for", "give stroke=, length_m=, duty=, force_n= or off=")
        return wanted

    def _spread(self, given: Optional[Setpoints], kind: str) -> List[Tuple[int, float]]:
        if given is None:
            return []
        if isinstance(given, Mapping):
            return [(self[name].index, float(value)) for name, value in given.items()]
        values = np.asarray(given, dtype=float)
        if values.ndim == 0:
            return [(channel.index, float(values)) for channel in self]
        if values.shape != (len(self),):
            raise BadInput(
                f"{kind}: {values.shape} values for {len(self)} channels",
                "give one for each channel in the rig's order (NaN: leave it as it is), or a dict by name",
            )
        return [(index, float(value)) for index, value in enumerate(values) if not math.isnan(value)]

    def _ask(self, wanted: List[Tuple[int, str, float]], hold: Optional[float]) -> Taken:
        lease = self._lease
        if hold is None:
            hold = lease.hold_s if lease else 0.0
        taken = Taken(*self._client.set_many(wanted, hold))
        if lease:
            for index, kind, value in wanted:
                if kind == "off":
                    lease._given.pop(index, None)
                else:
                    lease._given[index] = (kind, value)
        return taken

    def _leave(self, given: List[int], error: Any) -> None:
        """Switches off what a block of code has commanded, which ended with this error, or none."""
        try:
            if given:
                self._ask([(index, "off", 0.0) for index in given], 0.0)
        except SinewError as failed:
            # A driver that is gone has switched its outputs off. What ended the block is said, not what followed from it.
            if error is None and not isinstance(failed, DriverGone):
                raise

    def lease(self, hold_s: float) -> Lease:
        """Setpoints that live as long as a block of code: within it they hold for ``hold_s`` seconds, at its end, however it ends,
        the channels it commanded go off. ``lease.renew()`` gives them again, ``lease.sleep(s)`` renews while it sleeps.

        A program that hangs or is killed inside renews nothing, and its wires go off.

        >>> with rig.lease(0.5) as lease:        # doctest: +SKIP
        ...     rig["left"].stroke = 0.4
        ...     lease.sleep(2.0)
        """
        return Lease(self, hold_s)

    def setpoints(
        self, *, hold: float = 0.5, over: float = 0.0, within: Optional[float] = 0.1
    ) -> SetpointStream:
        """Setpoints for a planner that does not wait for the driver: each message replaces the one before it, see
        :class:`SetpointStream`.

        Each holds for ``hold`` seconds unless the next one comes, is approached in a straight line within ``over`` seconds (the
        planner's own period, say; 0: it holds at once), and is not carried out where the driver gets to it later than ``within``
        seconds (None: whenever it comes).

        >>> with rig.setpoints(over=0.01) as setpoints:        # doctest: +SKIP
        ...     for stroke in 0.2 - 0.2 * np.cos(np.arange(0, 20, 0.02)):
        ...         setpoints.send(stroke=stroke)
        ...         time.sleep(0.01)
        """
        return SetpointStream(self, self._client.setpoints(hold, over, within))

    def claim(self, channels: Optional[Sequence[str]] = None, *, priority: int = 5, hold_s: float = 2.0) -> Claim:
        """Has these channels (all without any) to itself while a block of code runs: others' setpoints and resets are refused, with
        the name of this process. Switching off stays open to everybody.

        A claim is lost when nothing has been asked of its channel for ``hold_s``, and to a higher ``priority`` (0..9): then the next
        setpoint is :class:`Refused`. Where somebody else has a channel with this priority or a higher, so is the claim.

        >>> with rig.claim(["left"]), rig.lease(0.5) as lease:        # doctest: +SKIP
        ...     rig["left"].stroke = 0.4
        ...     lease.sleep(2.0)
        """
        names = self.channels if channels is None else channels
        return Claim(self, [self[name].index for name in names], priority, hold_s)

    def off(self) -> None:
        """Only the sensing pulse on every channel from now on."""
        self._client.command(None, "off", 0.0, 0.0)

    def stop(self) -> None:
        """Stops the driver: outputs to zero, then it ends."""
        self._client.command(None, "stop", 0.0, 0.0)

    def stream(self) -> Stream:
        """Every cycle from now on."""
        return Stream(self._client, self.channels, self._about())

    def record(self, seconds: float) -> Record:
        """Every cycle of the next ``seconds``, as arrays."""
        return self.stream().record(seconds)

    def recorder(self) -> Recorder:
        """Every cycle while a block of code runs.

        >>> with rig.recorder() as recorder:        # doctest: +SKIP
        ...     move(rig)
        >>> recorder.record.to_pandas("left")       # doctest: +SKIP
        """
        return Recorder(self.stream())

    def _about(self) -> Dict[str, Any]:
        return {"rig": self.name, "rate_hz": self.rate_hz, "simulated": self.is_simulated}

    def _fault(self, code: int) -> Optional[Fault]:
        if code == 0:
            return None
        unknown = (f"fault {code}", "a fault this version does not know", "use driver and program of the same version")
        return Fault(*_state.FAULTS.get(code, unknown))

    @property
    def faults(self) -> Dict[str, Fault]:
        """The latched faults, by the names of their channels."""
        codes = self.state["fault"]
        return {c.name: fault for c, code in zip(self, codes) if (fault := self._fault(int(code))) is not None}

    def check(self) -> None:
        """Raises :class:`Faulted` where a channel is off by a fault, and :class:`DriverGone` where the driver is gone."""
        if self.health in ("stopped", "died"):
            raise DriverGone(f"the driver of {self.name} has {self.health}", "start it again with `sinew run` or sinew.run()")
        faults = self.faults
        if faults:
            said = "; ".join(f"{name} is off ({fault.flag}): {fault.cause}" for name, fault in faults.items())
            raise Faulted(said, next(iter(faults.values())).remedy, faults)

    @property
    def health(self) -> str:
        """How the driver is: starting, running, stalled, stopped or died."""
        return self._client.health()

    @property
    def age_s(self) -> float:
        """Age of the latest state, s."""
        return self._client.age_s()

    @property
    def loop_stats(self) -> Dict[str, Any]:
        """How the loop does: cycles, missed periods, lateness and cycle times in s, means of real time that were granted."""
        return self._client.loop_stats()

    @property
    def rig_text(self) -> Optional[str]:
        """The text of the rig file as the driver read it: what :func:`sinew.simulate` and the others take."""
        return self._client.rig_text()

    def close(self) -> None:
        """Lets go of the driver. One that :func:`run` started is stopped, its outputs at zero, and its end waited for; raises
        :class:`SinewError` where it did not end in order."""
        process, self._process = self._process, None
        if process is None:
            return
        process.terminate()
        _, said = process.communicate()
        if process.returncode != 0:
            raise SinewError(f"the driver ended with {process.returncode}: {said.strip()[-2000:]}", "look at its words")

    def __enter__(self) -> "Rig":
        return self

    def __exit__(self, kind: Any, error: Any, trace: Any) -> None:
        try:
            self.close()
        except SinewError:
            if error is None:
                raise

    def __repr__(self) -> str:
        wires = "simulated" if self.is_simulated else "real"
        return f"<sinew.Rig {self.name}: {len(self)} {wires} wires at {self.rate_hz:g} Hz, {self.health}>"

    def _repr_html_(self) -> str:
        head = "".join(f"<th>{name}</th>" for name in ("channel", "mode", "length, mm", "stroke, %", "°C", "duty, %", "fault"))
        rows = ""
        for channel in self:
            fault = channel.fault
            cells = [
                html.escape(channel.name),
                html.escape(channel.mode),
                f"{1e3 * channel.length_m:.2f}",
                f"{100 * channel.stroke:.0f}",
                f"{channel.temperature_c:.0f}",
                f"{100 * channel.duty:.1f}",
                html.escape(str(fault)) if fault else "",
            ]
            rows += "<tr>" + "".join(f"<td>{cell}</td>" for cell in cells) + "</tr>"
        caption = html.escape(repr(self)[1:-1])
        return f"<table><caption>{caption}</caption><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table>"
