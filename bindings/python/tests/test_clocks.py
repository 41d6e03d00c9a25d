"""Stamps beside other clocks."""

import doctest
import time

import pytest

import sinew
import sinew._clocks


def test_what_the_docstrings_show_is_so():
    failed, tried = doctest.testmod(sinew._clocks)
    assert failed == 0 and tried >= 5


def test_a_device_that_is_asked_is_learnt_with_its_rate():
    daq = sinew.ClockMap()
    assert daq.driver_at(0) is None and daq.other_at(0) is None and daq.rate_ppm is None and len(daq) == 0
    shows = lambda ns: ns + 7_000 + ns * 30 // 1_000_000  # noqa: E731  30 ppm fast
    for i in range(1, 61):
        ns = i * 1_000_000_000
        assert daq.bracket(ns - 20_000 - 1_000 * (i % 7), shows(ns), ns + 15_000 + 1_000 * (i % 5)) is None
    ppm, error_ppm = daq.rate_ppm
    assert abs(ppm - 30.0) <= error_ppm < 5.0
    for ns in (20_500_000_000, 60_000_000_000, 90_000_000_000):
        there, back = daq.other_at(ns), daq.driver_at(shows(ns))
        assert abs(there.ns - shows(ns)) <= there.error_ns and abs(back.ns - ns) <= back.error_ns
        assert str(there) == f"{there.ns} ± {there.error_ns} ns"
    assert daq.other_at(40_500_000_000).error_ns < daq.other_at(300_000_000_000).error_ns
    said = daq.pair(61_000_000_000, 5_000_000, 100)
    assert "was reset" in said and len(daq) == 1
    assert daq.driver_at(0) is None, "before the reset"
    daq.clear()
    assert len(daq) == 0


def test_bad_use_is_an_error_and_no_crash():
    daq = sinew.ClockMap(max_rate_ppm=float("nan"), window_s=-1.0, pairs=0)
    for use in (lambda: daq.pair(-1, 0, 0), lambda: daq.late(0, 1 << 80), lambda: daq.driver_at("now")):
        with pytest.raises((OverflowError, TypeError)):
            use()
    assert daq.late((1 << 64) - 1, -(1 << 63)) is None


def test_a_rigs_stamps_are_mapped_to_the_time_of_day(rig):
    before = time.time_ns()
    cycle = rig.snapshot().cycle
    while (snapshot := rig.snapshot()).cycle < cycle + 2:
        rig.wait(1.0)
    after = time.time_ns()
    clocks = rig.clocks
    at = clocks.system(snapshot.monotonic_ns)
    period_ns = 1e9 / rig.rate_hz
    assert before - period_ns - at.error_ns <= at.ns <= after + at.error_ns
    assert abs(clocks.driver_at_system(at.ns).ns - snapshot.monotonic_ns) <= 1
    boot = time.clock_gettime_ns(time.CLOCK_BOOTTIME) - time.monotonic_ns()
    assert abs(clocks.boottime(snapshot.monotonic_ns).ns - snapshot.monotonic_ns - boot) < 10_000_000
    tai = clocks.tai(snapshot.monotonic_ns)
    assert tai is None or 10 <= (tai.ns - at.ns) / 1e9 <= 100
    change = clocks.refresh()
    assert change.step_ns is None and change.suspended_ns == 0 and "was not set" in str(change)
