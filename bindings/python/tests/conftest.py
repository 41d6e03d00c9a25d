"""A simulated bench of two wires, and a driver for it."""

import itertools
import os

import pytest

import sinew

COUNT = itertools.count()

WIRE = """
[[channel]]
name = "{name}"
wire = {{ diameter_mm = 0.125, length_mm = 160.0 }}
taps = {{ l0_mm = 0.0, ls_mm = 150.0 }}
drive = {{ supply_v = 6.5, shunt_ohm = 0.1, switch_ohm = 0.02 }}
load = {{ mass_kg = 0.08, damping_n_s_per_m = 30.0, spring_n_per_m = 150.0, preload_n = 2.4 }}
"""


def bench(*channels: str, more: str = "") -> str:
    """A rig file with a name that nobody else has."""
    name = f"py-{os.getpid()}-{next(COUNT)}"
    return f'[rig]\nname = "{name}"\nrate_hz = 500.0\n' + "".join(WIRE.format(name=c) for c in channels) + more


@pytest.fixture
def rig_file(tmp_path):
    """Where the rig file of two wires lies."""
    path = tmp_path / "bench.toml"
    path.write_text(bench("left", "right"))
    return path


@pytest.fixture
def rig(rig_file):
    """A running driver with both wires known."""
    with sinew.run(rig_file) as rig:
        assert all(channel.mode == "off" for channel in rig)
        yield rig


def wait_until(rig, is_so, patience_s: float = 60.0):
    """Waits for the driver until it is so."""
    import time

    end = time.monotonic() + patience_s
    while not is_so():
        assert time.monotonic() < end, rig.state
        rig.wait(0.1)
