"""The node: ``sinew-ros2`` or ``python -m sinew_ros2``, beside a running driver.

The positions of ROS are wire lengths in m, read and commanded alike; names are those of the channels. Every command is a setpoint with a
lease: when this node hangs or dies the wires go off, and when nobody commands any more they do, too.
"""

from __future__ import annotations

import math
import time
from typing import Callable, Dict, Optional, Tuple

import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.time import Time
from sensor_msgs.msg import JointState, Temperature
from std_srvs.srv import Trigger
from trajectory_msgs.msg import JointTrajectory

import sinew

from .trajectory import Malformed, Trajectory

LAPSED = "lapsed"
LAPSED_MESSAGE = "lapsed: the setpoint's lease has ended; the next command is taken"


class SinewNode(Node):
    """Connects a rig to topics and services."""

    def __init__(self) -> None:
        super().__init__("sinew")
        parameter = lambda name, default: self.declare_parameter(name, default).value  # noqa: E731
        self._rig_name: str = parameter("rig", "")
        self._hold_s: float = parameter("hold_s", 0.5)
        self._hold_after_s: float = parameter("hold_after_s", 2.0)
        publish_hz, command_hz = parameter("publish_hz", 50.0), parameter("command_hz", 50.0)

        self._rig: Optional[sinew.Rig] = None
        self._clocks = sinew.Clocks()
        self._said = ""
        self._moving: Optional[Tuple[Trajectory, float]] = None
        """What is being carried out, and since when on ``time.monotonic()``."""
        self._commanded: set = set()

        self._states = self.create_publisher(JointState, "joint_states", 10)
        self._temperatures = self.create_publisher(Temperature, "~/temperature", 10)
        self._diagnostics = self.create_publisher(DiagnosticArray, "/diagnostics", 10)
        self.create_subscription(JointState, "~/joint_command", self._on_command, 10)
        self.create_subscription(JointTrajectory, "~/joint_trajectory", self._on_trajectory, 10)
        self.create_service(Trigger, "~/off", self._on_off)
        self.create_service(Trigger, "~/reset", self._on_reset)
        self.create_timer(1.0 / publish_hz, self._publish)
        self.create_timer(1.0 / command_hz, self._move)
        self.create_timer(1.0, self._diagnose)
        self._find()

    # The driver comes and goes

    def _find(self) -> Optional[sinew.Rig]:
        """The rig; looked for anew where its driver is gone."""
        if self._rig is not None and self._rig.health in ("stopped", "died"):
            self._lost(f"the driver of {self._rig.name} has {self._rig.health}")
        if self._rig is None:
            try:
                self._rig = sinew.connect(self._rig_name or None, patience_s=0.0)
            except sinew.SinewError as error:
                # Once, not at each look.
                if str(error) != self._said:
                    self.get_logger().warning(str(error))
                self._said = str(error)
            else:
                self._said = ""
                self.get_logger().info(f"connected to {self._rig.name}: {', '.join(self._rig.channels)}")
        return self._rig

    def _lost(self, why: str) -> None:
        self.get_logger().error(f"{why}; looking for the next one")
        self._rig, self._moving = None, None
        self._commanded.clear()

    def _nobody(self) -> str:
        """Why there is no rig."""
        return self._said or "no driver is connected; start one with `sinew run RIG.toml`"

    def _asked(self, ask: Callable[[sinew.Rig], object]) -> Optional[str]:
        """Asks the driver for something; what is wrong and what to do about it, where it was not done."""
        if self._rig is None:
            return self._nobody()
        try:
            ask(self._rig)
        except sinew.DriverGone as error:
            self._lost(str(error))
            return str(error)
        except sinew.SinewError as error:
            return str(error)
        return None

    # Commands

    def _set(self, lengths_m: Dict[str, float], forces_n: Dict[str, float]) -> Optional[str]:
        failed = self._asked(
            lambda rig: rig.set(length_m=lengths_m or None, force_n=forces_n or None, hold=self._hold_s)
        )
        if failed is None:
            self._commanded |= {*lengths_m, *forces_n}
        return failed

    def _on_command(self, message: JointState) -> None:
        """Lengths (position, m) or tensions (effort, N), held for the lease unless the next one comes."""
        names, given = list(message.name), [list(message.position), list(message.effort)]
        if not names or [len(values) for values in given if values] != [len(names)]:
            self.get_logger().error(
                f"joint_command: {len(names)} names, {len(given[0])} positions, {len(given[1])} efforts; "
                "give a position (wire length, m) or an effort (tension, N) for each name"
            )
            return
        if len(set(names)) < len(names):
            self.get_logger().error("joint_command: a joint stands twice; name each channel once")
            return
        lengths_m, forces_n = (dict(zip(names, values)) if values else {} for values in given)
        # What comes later is what counts.
        if self._moving and set(names) & set(self._moving[0].names):
            self._moving = None
        if failed := self._set(lengths_m, forces_n):
            self.get_logger().error(f"joint_command: {failed}")

    def _on_trajectory(self, message: JointTrajectory) -> None:
        """One trajectory at a time; one without points ends the one that runs, and its wires go off."""
        rig, before = self._rig, self._moving
        if rig is None:
            self.get_logger().error(f"joint_trajectory: {self._nobody()}")
            return
        if not message.points:
            self._moving = None
            if before and (failed := self._asked(lambda rig: rig.set(off=before[0].names))):
                self.get_logger().error(f"joint_trajectory: {failed}")
            return
        seconds = lambda stamp: stamp.sec + 1e-9 * stamp.nanosec  # noqa: E731
        now_m = {channel.name: _start_m(channel) for channel in rig}
        try:
            points = [(seconds(point.time_from_start), list(point.positions)) for point in message.points]
            trajectory = Trajectory.of(list(message.joint_names), points, now_m)
        except Malformed as error:
            self.get_logger().error(f"joint_trajectory: {error}")
            return
        stamp, now_s = seconds(message.header.stamp), 1e-9 * self.get_clock().now().nanoseconds
        # A stamp of zero is "now".
        wait_s = stamp - now_s if stamp else 0.0
        self._moving = (trajectory, time.monotonic() + wait_s)
        # What only the trajectory before moved is nobody's now: it is not left to run out.
        left = [name for name in before[0].names if name not in trajectory.names] if before else []
        if left and (failed := self._asked(lambda rig: rig.set(off=left))):
            self.get_logger().error(f"joint_trajectory: {failed}")

    def _move(self) -> None:
        if self._moving is None:
            return
        trajectory, since = self._moving
        passed_s = time.monotonic() - since
        if passed_s < 0.0:
            return
        if passed_s > trajectory.duration_s + self._hold_after_s:
            self._moving = None
            failed = self._asked(lambda rig: rig.set(off=trajectory.names))
        elif failed := self._set(trajectory.at(passed_s), {}):
            # Refused as a whole: what it has moved is not held where it happens to be.
            self._moving = None
            self._asked(lambda rig: rig.set(off=trajectory.names))
        if failed:
            self.get_logger().error(f"joint_trajectory: {failed}")

    def _on_off(self, _: Trigger.Request, answer: Trigger.Response) -> Trigger.Response:
        self._moving = None
        return self._answered(answer, self._asked(lambda rig: rig.off()))

    def _on_reset(self, _: Trigger.Request, answer: Trigger.Response) -> Trigger.Response:
        def reset(rig: sinew.Rig) -> None:
            for name in rig.faults:
                rig[name].reset()

        return self._answered(answer, self._asked(reset))

    @staticmethod
    def _answered(answer: Trigger.Response, failed: Optional[str]) -> Trigger.Response:
        answer.success, answer.message = failed is None, failed or ""
        return answer

    def let_go(self) -> None:
        """At the end: what this node has commanded goes off now and not with its leases."""
        if self._rig is not None and self._commanded:
            self._asked(lambda rig: rig.set(off=sorted(self._commanded)))

    # What is published

    def _ros_time(self, monotonic_ns: int) -> Tuple[Time, int]:
        """ROS time of a driver's stamp, and what that is off by at the most, ns."""
        if self.get_clock().ros_time_is_active:
            # Simulated time runs at a rate of its own, stands still or jumps: what passed since the stamp is not known in it.
            now, age_ns = self.get_clock().now(), max(time.monotonic_ns() - monotonic_ns, 0)
            return Time(nanoseconds=max(now.nanoseconds - age_ns, 0), clock_type=now.clock_type), age_ns
        change = self._clocks.refresh()
        if change.step_ns is not None:
            self.get_logger().warning(str(change))
        at = self._clocks.system(monotonic_ns)
        return Time(nanoseconds=at.ns, clock_type=self.get_clock().clock_type), at.error_ns

    def _publish(self) -> None:
        rig = self._rig
        if rig is None:
            return
        snapshot = rig.snapshot()
        stamp = self._ros_time(snapshot.monotonic_ns)[0].to_msg()
        message = JointState()
        message.header.stamp = stamp
        message.name = list(rig.channels)
        message.position = snapshot.state["length_m"].tolist()
        message.velocity = snapshot.state["velocity_m_s"].tolist()
        self._states.publish(message)
        for name, temperature_c in zip(rig.channels, snapshot.state["temperature_c"]):
            message = Temperature(temperature=float(temperature_c))
            message.header.stamp, message.header.frame_id = stamp, name
            self._temperatures.publish(message)

    def _diagnose(self) -> None:
        rig = self._find()
        array = DiagnosticArray()
        array.header.stamp = self.get_clock().now().to_msg()
        if rig is None:
            array.status = [_status(DiagnosticStatus.ERROR, "sinew: driver", self._rig_name, self._nobody(), {})]
        else:
            stats, health = rig.loop_stats, rig.health
            level = DiagnosticStatus.OK if health == "running" else DiagnosticStatus.WARN
            counts = {"cycles": stats["cycles"], "missed": stats["missed"], "rate_hz": rig.rate_hz, "pid": rig.pid}
            is_simulated = self.get_clock().ros_time_is_active
            _, error_ns = self._ros_time(rig.snapshot().monotonic_ns)
            utc_error_ns = self._clocks.utc_error_ns
            counts["stamps"] = "simulated time" if is_simulated else "system time"
            counts["stamp_error_s"] = 1e-9 * error_ns
            counts["utc_error_s"] = "not synchronised" if utc_error_ns is None else 1e-9 * utc_error_ns
            array.status = [_status(level, "sinew: driver", rig.name, health, counts)]
            array.status += [_channel_status(rig, channel) for channel in rig]
        self._diagnostics.publish(array)


def _start_m(channel: sinew.Channel) -> float:
    """Where a trajectory begins: where the wire is commanded to, or else where it is, which a cold wire may be a little outside of
    what may be commanded. NaN while that is not measured."""
    state = channel.state
    target_m, length_m = float(state["target_m"]), float(state["length_m"])
    if not math.isnan(target_m):
        return target_m
    return math.nan if math.isnan(length_m) else min(max(length_m, channel.min_length_m), channel.max_length_m)


def _channel_status(rig: sinew.Rig, channel: sinew.Channel) -> DiagnosticStatus:
    fault, state = channel.fault, channel.state
    values = {name: state[name] for name in ("length_m", "target_m", "temperature_c", "duty", "resistance_ohm", "lease_s")}
    name = f"sinew: {channel.name}"
    if fault is None and channel.mode == LAPSED:
        return _status(DiagnosticStatus.OK, name, rig.name, LAPSED_MESSAGE, values)
    if fault is None:
        return _status(DiagnosticStatus.OK, name, rig.name, channel.mode, values)
    return _status(DiagnosticStatus.ERROR, name, rig.name, f"{fault.flag}: {fault.cause}", {"remedy": fault.remedy, **values})


def _status(level: bytes, name: str, rig: str, message: str, values: Dict[str, object]) -> DiagnosticStatus:
    pairs = [KeyValue(key=key, value=str(value)) for key, value in values.items()]
    return DiagnosticStatus(level=level, name=name, hardware_id=rig, message=message, values=pairs)


def main() -> None:
    """Runs the node until it is interrupted."""
    rclpy.init()
    node = SinewNode()
    try:
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        node.let_go()
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
