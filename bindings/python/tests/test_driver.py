"""A running driver from Python: everything here watches a real one."""

import asyncio
import os
import signal
import subprocess
import sys
import textwrap
import threading
import time

import numpy as np
import pytest

import sinew
from conftest import bench, wait_until

SENSING_DUTY = 0.02


def test_a_wire_is_moved_and_goes_off_at_the_end_of_its_lease(rig):
    cold = rig["left"].length_m
    with rig.lease(1.0) as lease:
        rig["left"].stroke = 0.4
        wait_until(rig, lambda: lease.renew() and abs(rig["left"].stroke - 0.4) < 0.05)
        assert rig["left"].mode == "length" and rig["left"].target_m < cold
    wait_until(rig, lambda: rig["left"].mode == "off")
    assert rig["left"].duty <= SENSING_DUTY


def test_a_block_that_fails_leaves_its_channels_off_and_its_error_is_the_one_that_is_seen(rig):
    with pytest.raises(ZeroDivisionError):
        with rig.lease(30.0):
            rig["left"].duty = 0.1
            1 / 0
    wait_until(rig, lambda: rig["left"].mode == "off")


def test_many_channels_are_set_in_one_cycle_or_not_at_all(rig):
    taken = rig.set(stroke={"left": 0.3, "right": 0.2}, hold=5.0)
    wait_until(rig, lambda: rig.snapshot().cycle > taken.cycle)
    targets = [c.cold_length_m + s * (c.hot_length_m - c.cold_length_m) for c, s in zip(rig, (0.3, 0.2))]
    assert np.allclose(rig.state["asked"], targets) and taken.hold_s == 5.0
    with pytest.raises(sinew.Refused) as refused:
        rig.set(stroke=[0.5, 1.5], hold=5.0)
    (refusal,) = refused.value.refusals
    assert (refusal.channel, refusal.kind, refusal.high) == ("right", "stroke", 1.0)
    assert "outside" in refusal.message and refused.value.remedy
    rig.wait()
    assert np.allclose(rig.state["asked"], targets), "nothing of the refused request was carried out"
    rig.set(stroke=[0.4, np.nan], hold=5.0)
    wait_until(rig, lambda: not np.isclose(rig.state["asked"][0], targets[0]))
    assert np.isclose(rig.state["asked"][1], targets[1]), "NaN leaves a channel as it is"


def test_a_stream_of_setpoints_is_not_waited_for_and_goes_off_with_its_block(rig):
    with rig.setpoints(over=0.05, within=None) as setpoints:
        for stroke in np.linspace(0.1, 0.3, 100):
            setpoints.send(stroke=stroke)
            time.sleep(0.005)

        def settled():
            found = setpoints.progress
            return found.taken + found.overtaken + found.held_back == found.sent

        wait_until(rig, settled)
        assert setpoints.progress.sent == 100 and setpoints.progress.taken > 10
        wait_until(rig, lambda: rig["left"].mode == "length")
        setpoints.send(stroke={"left": 7.0})
        with pytest.raises(sinew.Refused) as refused:
            wait_until(rig, lambda: setpoints.progress is None)
        assert refused.value.refusals[0].channel == "left"
    wait_until(rig, lambda: all(channel.mode == "off" for channel in rig))
    with pytest.raises(sinew.BadInput):
        rig.setpoints(over=-1.0)
    with pytest.raises(sinew.BadInput):
        rig.setpoints().send()


def test_a_claimed_channel_is_its_owners_alone_and_off_is_everybodys(rig):
    other = sinew.connect(rig.name)
    with rig.claim(["left"], hold_s=30.0):
        rig["left"].set("stroke", 0.2, hold=30.0)
        wait_until(rig, lambda: rig["left"].owner == os.getpid())
        with pytest.raises(sinew.Refused, match=f"claimed by process {os.getpid()} with priority 5"):
            other["left"].stroke = 0.1
        with pytest.raises(sinew.Refused, match="claimed by process"):
            other.set(stroke=0.1)
        with pytest.raises(sinew.Refused, match="higher priority"):
            with other.claim():
                pass
        assert other["right"].mode == "off", "all or none"
        other["right"].stroke = 0.1
        other["left"].off()
        wait_until(rig, lambda: rig["left"].mode == "off")
        with other.claim(["left"], priority=7, hold_s=30.0):
            with pytest.raises(sinew.Refused, match="priority 7"):
                rig["left"].stroke = 0.2
    other["left"].stroke = 0.1
    wait_until(rig, lambda: rig["left"].owner is None)


@pytest.mark.parametrize(
    "use, error, words",
    [
        (lambda rig: rig["lft"], sinew.UnknownChannel, "there are: left, right"),
        (lambda rig: rig.set(stroke={"up": 0.1}), sinew.UnknownChannel, "up"),
        (lambda rig: rig.set(stroke=[0.1]), sinew.BadInput, "2 channels"),
        (lambda rig: rig.set(), sinew.BadInput, "nothing is asked for"),
        (lambda rig: rig.set(duty=0.1, hold=-1.0), sinew.BadInput, "no time"),
        (lambda rig: rig.set(duty=0.1, hold=float("nan")), sinew.BadInput, "no time"),
        (lambda rig: rig["left"].set("speed", 1.0), sinew.BadInput, "length, stroke, duty, force"),
        (lambda rig: rig["left"].set("stroke", float("inf")), sinew.Refused, "finite"),
        (lambda rig: rig["left"].set("length", 5.0), sinew.Refused, "outside"),
        (lambda rig: rig["left"].set("duty", 0.1, hold=1e9), sinew.Refused, "hold is outside"),
        (lambda rig: rig.set(stroke={"left": 0.1}, off="left"), sinew.Refused, "twice"),
        (lambda rig: sinew.connect("nobody", patience_s=0.0), sinew.NotRunning, "nobody"),
        (lambda rig: sinew.connect("no body"), sinew.BadInput, "rig name"),
        (lambda rig: sinew.run("nowhere.toml"), sinew.BadInput, "nowhere.toml"),
    ],
)
def test_bad_use_is_an_error_with_its_remedy(rig, use, error, words):
    with pytest.raises(error) as raised:
        use(rig)
    assert words in str(raised.value) and raised.value.remedy, raised.value


def test_mistakes_of_a_rig_file_are_told_with_their_lines(tmp_path):
    path = tmp_path / "bad.toml"
    path.write_text(bench("left").replace("length_mm = 160.0", "length_mm = -1.0"))
    with pytest.raises(sinew.BadInput) as raised:
        sinew.run(path)
    assert "bad.toml:7" in raised.value.message and "docs/rig.md" in raised.value.remedy


def test_a_fault_is_an_exception_with_its_remedy_and_can_be_reset(tmp_path):
    path = tmp_path / "bench.toml"
    fault = '\n[[simulation.fault]]\nchannel = "left"\nkind = "open_wire"\nstart_s = 0.5\nend_s = 1.5\n'
    path.write_text(bench("left", "right", more=fault))
    with sinew.run(path) as rig:
        wait_until(rig, lambda: rig.faults)
        assert list(rig.faults) == ["left"] and rig["right"].fault is None
        with pytest.raises(sinew.Faulted) as raised:
            rig.check()
        assert "left is off" in str(raised.value) and raised.value.faults["left"].remedy in str(raised.value)
        with pytest.raises(sinew.Refused) as refused:
            rig["left"].stroke = 0.1
        assert refused.value.refusals[0].fault == rig.faults["left"].flag

        def is_reset():
            try:
                rig["left"].reset()
            except sinew.Refused:
                return False
            return True

        wait_until(rig, is_reset)
        wait_until(rig, lambda: not rig.faults)
        rig.check()


def test_every_cycle_comes_in_order_and_none_is_lost(rig):
    record = rig.record(0.5)
    assert len(record) > 20 and record.lost == 0
    assert np.all(np.diff(record.cycle.astype(np.int64)) == 1) and np.all(np.diff(record.time_s) > 0)
    assert record.state.shape == (len(record), 2)
    assert np.array_equal(record["right"]["length_m"], record.state["length_m"][:, 1], equal_nan=True)
    # its name of once is found as well
    assert np.array_equal(record.state["observed_length_m"], record.state["length_m"], equal_nan=True)
    frame = record.to_pandas("left")
    assert list(frame.columns) == list(record.state.dtype.names) and frame.index.name == "time_s"
    assert record.to_pandas()["right", "duty"].iloc[-1] == record["right"]["duty"][-1]


def test_streams_are_iterators_for_both_kinds_of_loops(rig):
    stream = rig.stream()
    cycles = [cycle.cycle for cycle, _ in zip(stream, range(20))]
    assert cycles == list(range(cycles[0], cycles[0] + 20))

    async def some():
        taken = []
        async for cycle in rig.stream():
            taken.append(cycle)
            if len(taken) == 20:
                return taken

    taken = asyncio.run(some())
    assert [c.cycle for c in taken] == list(range(taken[0].cycle, taken[0].cycle + 20))
    assert taken[0].state is not taken[1].state and taken[0].state["length_m"].shape == (2,)


def test_a_stream_ends_with_its_driver(rig_file):
    rig = sinew.run(rig_file)
    stream = rig.stream()
    threading.Timer(0.3, rig.stop).start()
    assert len(list(stream)) > 0, "a driver that stops in order ends the loop"
    rig.close()
    with pytest.raises(sinew.DriverGone):
        rig["left"].stroke = 0.1
    with pytest.raises(sinew.DriverGone):
        rig.check()
    assert rig.health == "stopped" and len(rig.state) == 2, "the last state stays"


def test_a_driver_that_dies_is_an_error_of_its_stream(rig_file):
    rig = sinew.run(rig_file)
    stream = rig.stream()
    os.kill(rig.pid, signal.SIGKILL)
    with pytest.raises(sinew.DriverGone, match="died"):
        list(stream)
    with pytest.raises(sinew.SinewError, match="-9"):
        rig.close()


def test_a_state_is_a_copy_that_stays_as_it_is(rig):
    before = rig.snapshot()
    kept = before.state.copy()
    wait_until(rig, lambda: rig.snapshot().cycle > before.cycle + 10)
    assert np.array_equal(before.state.view("u1"), kept.view("u1"))


def test_threads_use_one_rig_side_by_side(rig):
    errors = []

    def work(name, value):
        try:
            for _ in range(20):
                rig[name].set("duty", value, hold=5.0)
                rig.state
        except Exception as error:
            errors.append(error)

    threads = [threading.Thread(target=work, args=(name, value)) for name in ("left", "right") for value in (0.03, 0.04)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not errors


def script(rig_file, body: str) -> subprocess.Popen:
    text = f"import sinew, time\nrig = sinew.connect({str(rig_file)!r})\n" + textwrap.dedent(body)
    return subprocess.Popen([sys.executable, "-u", "-c", text], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def test_a_program_killed_in_mid_command_leaves_no_wire_on(rig):
    program = script(
        rig.name,
        """
        while True:
            rig["left"].set("duty", 0.2, hold=1.0)
            print("given", flush=True)
        """,
    )
    assert program.stdout.readline() == "given\n"
    wait_until(rig, lambda: rig["left"].duty > 0.1)
    program.send_signal(signal.SIGKILL)
    program.communicate()
    wait_until(rig, lambda: rig["left"].duty <= SENSING_DUTY)
    wait_until(rig, lambda: rig["left"].temperature_c < 60.0)
    rig["left"].stroke = 0.2


def test_a_driver_ends_with_the_program_that_started_it(rig_file):
    text = f"import sinew\nrig = sinew.run({str(rig_file)!r})\nprint(rig.pid, flush=True)\nrig = None\n"
    said = subprocess.run([sys.executable, "-c", text], capture_output=True, text=True, timeout=300)
    assert said.returncode == 0, said.stderr
    with pytest.raises(ProcessLookupError):
        os.kill(int(said.stdout), 0)


def test_an_interrupt_ends_a_wait_and_the_block_leaves_its_channels_off(rig):
    program = script(
        rig.name,
        """
        with rig.lease(30.0) as lease:
            rig["left"].duty = 0.1
            print("given", flush=True)
            for cycle in rig.stream():
                pass
        """,
    )
    assert program.stdout.readline() == "given\n"
    program.send_signal(signal.SIGINT)
    _, said = program.communicate(timeout=60)
    assert "KeyboardInterrupt" in said
    wait_until(rig, lambda: rig["left"].mode == "off")


def test_a_setpoint_that_is_mistyped_is_no_new_attribute(rig):
    left = rig["left"]
    with pytest.raises(AttributeError, match="strok.*did you mean 'stroke'"):
        left.strok = 0.4
    with pytest.raises(AttributeError, match="did you mean 'length_m'"):
        left.length_mm = 164.0
    with pytest.raises(AttributeError, match="stroke, length_m or duty"):
        left.colour = "red"
    assert left.mode == "off"


def test_the_state_of_a_rig_shows_in_a_notebook(rig):
    page = rig._repr_html_()
    assert page.count("<tr>") == 3 and "left" in page and rig.name in page
    assert "running" in repr(rig) and "left" in repr(rig["left"])
    wait_until(rig, lambda: rig.loop_stats["cycles"] > 100)
    stats = rig.loop_stats
    assert stats["allocations"] == 0 and stats["period_p50_s"] > 0
    assert "[[channel]]" in rig.rig_text
    assert time.monotonic_ns() - rig.snapshot().monotonic_ns < 60e9, "the clock is Python's own monotonic one"
