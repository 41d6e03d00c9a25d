"""The node beside a running driver, as other nodes see it."""

import math
import signal
import time

import sinew
from builtin_interfaces.msg import Duration
from diagnostic_msgs.msg import DiagnosticStatus
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

SENSING_DUTY = 0.02


def command(listener, **values):
    """A joint_command, such as ``position={"left": 0.164}``."""
    (kind, given), = values.items()
    message = JointState(name=list(given))
    setattr(message, kind, [float(value) for value in given.values()])
    listener.command.publish(message)


def trajectory(*points, names=("left",)):
    """A JointTrajectory of points (time in s, one length in m a joint)."""
    message = JointTrajectory(joint_names=list(names))
    for time_s, positions in points:
        whole = int(time_s)
        due = Duration(sec=whole, nanosec=round(1e9 * (time_s - whole)))
        message.points.append(JointTrajectoryPoint(positions=list(positions), time_from_start=due))
    return message


def stroke_m(rig, channel, stroke):
    return rig[channel].cold_length_m + stroke * (rig[channel].hot_length_m - rig[channel].cold_length_m)


def test_states_are_those_of_the_driver_at_their_time(rig, listener):
    seen = len(listener.states)
    listener.wait_until(lambda: len(listener.states) > seen + 20 and listener.temperatures, "states")
    stamps = [s.header.stamp.sec + 1e-9 * s.header.stamp.nanosec for s in listener.states]
    assert stamps == sorted(stamps)
    latest = listener.states[-1]
    assert list(latest.name) == ["left", "right"]
    now_s = listener.node.get_clock().now().nanoseconds * 1e-9
    assert -0.01 < now_s - stamps[-1] < 10.0
    for name, length_m, speed_m_s in zip(latest.name, latest.position, latest.velocity):
        assert abs(length_m - rig[name].length_m) < 1e-3 and math.isfinite(speed_m_s)
    assert {t.header.frame_id for t in listener.temperatures} == {"left", "right"}
    assert all(0.0 < t.temperature < 60.0 for t in listener.temperatures), "cold wires"


def test_stamps_are_the_system_time_of_the_samples_and_their_error_is_diagnosed(rig, listener):
    seen = len(listener.states)
    with rig.recorder() as recorder:
        listener.wait_until(lambda: len(listener.states) > seen + 20, "states")
        time.sleep(0.1)
    clocks, cycles = rig.clocks, set(recorder.record.monotonic_ns.tolist())
    stamps = [10**9 * s.header.stamp.sec + s.header.stamp.nanosec for s in listener.states[seen + 5 : seen + 20]]
    error_ns = 2 * max(clocks.system(0).error_ns, 1_000)
    for stamp in stamps:
        at = clocks.driver_at_system(stamp).ns
        assert min(abs(at - cycle) for cycle in cycles) <= error_ns, "each is the time of a cycle, not of the look at it"
    listener.wait_until(lambda: listener.status("driver"), "a diagnosis")
    values = {pair.key: pair.value for pair in listener.status("driver").values}
    assert values["stamps"] == "system time" and 0.0 < float(values["stamp_error_s"]) < 1e-3
    assert values["utc_error_s"] == "not synchronised" or float(values["utc_error_s"]) >= 0.0


def test_a_command_holds_for_its_lease_and_no_longer(rig, listener):
    target_m = stroke_m(rig, "left", 0.3)
    for _ in range(20):
        command(listener, position={"left": target_m})
        listener.wait_until(lambda: rig["left"].mode == "length", "the command")
        assert abs(rig["left"].target_m - target_m) < 1e-9 and rig["right"].mode == "off"
        time.sleep(0.1)
    listener.wait_until(lambda: rig["left"].duty > 2 * SENSING_DUTY or rig["left"].stroke > 0.2, "the wire to be heated")
    listener.wait_until(lambda: rig["left"].mode == "lapsed", "the lease to run out")
    assert rig["left"].duty == SENSING_DUTY
    # That is no fault, and is said.
    listener.wait_until(lambda: (s := listener.status("left")) and s.message.startswith("lapsed: "), "the word")
    status = listener.status("left")
    assert status.level == DiagnosticStatus.OK and status.hardware_id == rig.name
    assert listener.status("right").level == DiagnosticStatus.OK and listener.status("driver").message == "running"
    command(listener, effort={"left": 1.8})
    listener.wait_until(lambda: rig["left"].mode == "force", "a tension")


def test_a_trajectory_is_followed_held_and_let_go(rig, listener):
    wanted = [(1.0, [stroke_m(rig, "left", 0.3), stroke_m(rig, "right", 0.1)]), (2.0, [stroke_m(rig, "left", 0.1), stroke_m(rig, "right", 0.4)])]
    recorder = rig.recorder()
    with recorder:
        listener.trajectory.publish(trajectory(*wanted, names=["left", "right"]))
        listener.wait_until(lambda: all(channel.mode == "length" for channel in rig), "the trajectory")
        listener.wait_until(lambda: all(channel.mode == "off" for channel in rig), "its end")
    targets = recorder.record.state["target_m"]
    held = ~_nan(targets).any(axis=1)
    seconds = held.sum() / rig.rate_hz
    assert 2.3 < seconds < 4.0, "two seconds and the half it is held after that"
    for column, channel in enumerate(("left", "right")):
        path = targets[held, column]
        for _, lengths in wanted:
            assert abs(path - lengths[column]).min() < 1e-4, "it comes by each point"
        assert abs(path[-1] - wanted[-1][1][column]) < 1e-9
        # never faster than its steepest piece, as far as steps of the command's rate allow
        assert abs(path[1:] - path[:-1]).max() < 1e-3, channel
    assert not rig.faults, "it has let go: no lease ran out"


def test_what_is_wrong_is_said_and_not_carried_out(rig, listener):
    good_m = stroke_m(rig, "left", 0.3)
    wrong = [
        (lambda: command(listener, position={"lefd": good_m}), "left"),
        (lambda: command(listener, position={"left": 0.5}), "outside"),
        (lambda: command(listener, position={"left": math.nan}), "finite"),
        (lambda: listener.command.publish(JointState(name=["left"])), "give a position"),
        (lambda: listener.command.publish(JointState(name=["left"], position=[good_m], effort=[1.0])), "give a position"),
        (lambda: listener.command.publish(JointState(name=["left", "left"], position=[good_m, good_m])), "stands twice"),
        (lambda: listener.trajectory.publish(trajectory((1.0, [good_m]), names=["lefd"])), "there are: left, right"),
        (lambda: listener.trajectory.publish(trajectory((1.0, [good_m, good_m]))), "2 positions for 1 joints"),
        (lambda: listener.trajectory.publish(trajectory((1.0, [0.5]))), "outside"),
    ]
    for ask, words in wrong:
        listener.words.clear()
        ask()
        listener.wait_until(lambda: any("joint_" in said and words in said for said in listener.words), words)
    # The last one was refused as it left the limits, and has let go of the wire.
    listener.wait_until(lambda: all(channel.mode == "off" for channel in rig), "the wires to be off")


def test_off_and_reset_are_services(rig, listener):
    command(listener, position={"left": stroke_m(rig, "left", 0.3)})
    listener.trajectory.publish(trajectory((30.0, [stroke_m(rig, "right", 0.3)]), names=["right"]))
    listener.wait_until(lambda: rig["right"].mode == "length", "the trajectory")
    assert listener.call("off").success
    assert all(channel.mode == "off" for channel in rig)
    time.sleep(0.2)
    assert rig["right"].mode == "off", "the trajectory is over, too"
    assert listener.call("reset").success


def test_a_node_that_is_killed_leaves_no_wire_heated(rig, listener, process):
    listener.trajectory.publish(trajectory((60.0, [stroke_m(rig, "left", 0.9)])))
    listener.wait_until(lambda: rig["left"].duty > 2 * SENSING_DUTY, "the wire to be heated")
    process.kill()
    listener.wait_until(lambda: rig["left"].mode == "lapsed", "the lease to run out")
    assert rig["left"].duty == SENSING_DUTY and rig["left"].fault is None


def test_a_node_that_is_ended_lets_go_at_once(rig, listener, process):
    command(listener, position={"left": stroke_m(rig, "left", 0.3)})
    listener.wait_until(lambda: rig["left"].mode == "length", "the command")
    process.send_signal(signal.SIGINT)
    assert process.wait(60) == 0
    assert rig["left"].mode == "off" and rig["left"].fault is None


def test_a_driver_that_ends_is_told_and_the_next_one_found(rig, listener, tmp_path):
    rig.stop()
    listener.wait_until(lambda: (s := listener.status("driver")) and s.level == DiagnosticStatus.ERROR, "the end")
    command(listener, position={"left": 0.164})
    listener.wait_until(lambda: any(said.startswith("joint_command: no driver") for said in listener.words), "its words")
    with sinew.run(tmp_path / "bench.toml") as following:
        listener.wait_until(lambda: (s := listener.status("driver")) and s.level == DiagnosticStatus.OK, "the next one")
        command(listener, position={"left": stroke_m(following, "left", 0.2)})
        listener.wait_until(lambda: following["left"].mode == "length", "a command to it")


def _nan(values):
    return values != values
