"""A driver started from Python."""

from __future__ import annotations

import atexit
import os
import shutil
import subprocess
import tempfile
import time
from typing import List, Optional, Set, Union

from . import _rig, _sinew
from ._errors import BadInput, NotRunning, SinewError

_LOOK_S = 0.02

_running: List[subprocess.Popen] = []


def run(
    rig_file: Optional[Union[str, os.PathLike]] = None,
    *,
    program: Optional[Union[str, os.PathLike]] = None,
    patience_s: float = 30.0,
    answer_s: float = 1.0,
) -> "_rig.Rig":
    """Starts a driver for a rig file (its path or its text; the built-in simulated hexapod without one) and connects to it.

    It returns when the loop runs and each channel's sensors have reported, or have been found wanting (:attr:`Rig.faults`).

    The driver is a process of its own, ``sinew run``, found as ``program``, in ``SINEW_BINARY`` or on the path. It is stopped
    by :meth:`Rig.close`, at the end of ``with sinew.run(...) as rig:``, and when Python ends in order. When Python is killed it
    goes on, with every wire off as soon as its lease has run out.

    Raises :class:`BadInput` with the rig file's mistakes, each with its line; :class:`SinewError` where it does not come up.
    """
    text = rig_file if isinstance(rig_file, str) and "\n" in rig_file else None
    with tempfile.TemporaryDirectory(prefix="sinew-") as folder:
        if text is not None:
            # the driver has read it when it runs
            rig_file = os.path.join(folder, "rig.toml")
            with open(rig_file, "w", encoding="utf-8") as file:
                file.write(text)
        return _started([_program(program), "run", "--no-monitor"], rig_file, patience_s, answer_s)


def _started(
    command: List[str], rig_file: Optional[Union[str, os.PathLike]], patience_s: float, answer_s: float
) -> "_rig.Rig":
    others = set(_sinew.discover())
    command = command + ([os.fspath(rig_file)] if rig_file is not None else [])
    process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    try:
        rig = _connected(process, others, patience_s, answer_s)
    except BaseException:
        if process.poll() is None:
            process.terminate()
            process.wait()
        raise
    rig._process = process
    _running.append(process)
    return rig


def _program(given: Optional[Union[str, os.PathLike]]) -> str:
    for candidate in (given, os.environ.get("SINEW_BINARY")):
        if candidate is not None:
            return os.fspath(candidate)
    found = shutil.which("sinew")
    if found is None:
        raise BadInput(
            "there is no program `sinew` on the path",
            "install it (`cargo install --path tools/cli` in a clone), or name it with program= or SINEW_BINARY",
        )
    return found


def _connected(process: subprocess.Popen, others: Set[str], patience_s: float, answer_s: float) -> "_rig.Rig":
    """Waits for the driver of this process, which is none of those that ran before, and for its wires."""
    end = time.monotonic() + patience_s
    while True:
        if process.poll() is not None:
            said = process.communicate()[1].strip()
            if process.returncode == 2:
                raise BadInput(_after(said, "error: "), _after(said, "hint: "))
            raise SinewError(f"the driver ended with {process.returncode}: {said}", "look at its words")
        for name in set(_sinew.discover()) - others:
            try:
                client = _sinew.Client.connect(name, 0.0, answer_s)
            except SinewError:
                continue
            rig = _rig.Rig(client)
            # a wire is waited for until its sensors have reported, or it has a fault
            if rig.pid == process.pid and rig.health == "running" and not any(c.mode == "waiting" for c in rig):
                return rig
        if time.monotonic() > end:
            raise NotRunning(f"the driver (process {process.pid}) did not come up in {patience_s:g} s", "run `sinew doctor`")
        time.sleep(_LOOK_S)


def _after(said: str, mark: str) -> str:
    """What the program said after this mark, up to the other one."""
    lines: List[str] = []
    inside = False
    for line in said.splitlines():
        if line.startswith(("error: ", "hint: ")):
            inside = line.startswith(mark)
            line = line[len(mark) :] if inside else line
        if inside:
            lines.append(line.strip())
    return "\n".join(lines) or said


@atexit.register
def _end() -> None:
    """Ends every driver that was started here and still runs, whatever has become of its :class:`Rig`."""
    for process in _running:
        if process.poll() is None:
            process.terminate()
            process.wait()
