"""A simulated bench of two wires with its driver, the node in a process of its own, and a node of the tests that listens to it."""

import itertools
import os
import subprocess
import sys
import time

import pytest

rclpy = pytest.importorskip("rclpy")
sinew = pytest.importorskip("sinew")

from diagnostic_msgs.msg import DiagnosticArray  # noqa: E402
from rcl_interfaces.msg import Log  # noqa: E402
from sensor_msgs.msg import JointState, Temperature  # noqa: E402
from std_srvs.srv import Trigger  # noqa: E402
from trajectory_msgs.msg import JointTrajectory  # noqa: E402

COUNT = itertools.count()
PATIENCE_S = 60.0

WIRE = """
[[channel]]
name = "{name}"
wire = {{ diameter_mm = 0.125, length_mm = 160.0 }}
taps = {{ l0_mm = 0.0, ls_mm = 150.0 }}
drive = {{ supply_v = 6.5, shunt_ohm = 0.1, switch_ohm = 0.02 }}
load = {{ mass_kg = 0.08, damping_n_s_per_m = 30.0, spring_n_per_m = 150.0, preload_n = 2.4 }}
"""

# Nobody else's nodes, and nobody else's ears.
os.environ["ROS_DOMAIN_ID"] = str(1 + os.getpid() % 100)
os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"


class Listener:
    """What the node publishes, and how it is told."""

    def __init__(self, node) -> None:
        self.node = node
        self.states, self.temperatures, self.diagnostics, self.words = [], [], [], []
        node.create_subscription(JointState, "joint_states", self.states.append, 10)
        node.create_subscription(Temperature, "sinew/temperature", self.temperatures.append, 10)
        node.create_subscription(DiagnosticArray, "/diagnostics", self.diagnostics.append, 10)
        node.create_subscription(Log, "/rosout", lambda log: self.words.append(log.msg), 100)
        self.command = node.create_publisher(JointState, "sinew/joint_command", 10)
        self.trajectory = node.create_publisher(JointTrajectory, "sinew/joint_trajectory", 10)
        self.services = {name: node.create_client(Trigger, f"sinew/{name}") for name in ("off", "reset")}

    def wait_until(self, is_so, what: str) -> None:
        end = time.monotonic() + PATIENCE_S
        while not is_so():
            assert time.monotonic() < end, f"waited in vain for {what}; said: {self.words}"
            rclpy.spin_once(self.node, timeout_sec=0.02)

    def call(self, name: str):
        service = self.services[name]
        assert service.wait_for_service(PATIENCE_S)
        answer = service.call_async(Trigger.Request())
        self.wait_until(answer.done, name)
        return answer.result()

    def status(self, name: str):
        """The latest diagnosis of a channel, or of the driver."""
        found = [s for array in self.diagnostics[-1:] for s in array.status if s.name == f"sinew: {name}"]
        return found[0] if found else None


@pytest.fixture
def rig(tmp_path):
    path = tmp_path / "bench.toml"
    name = f"ros-{os.getpid()}-{next(COUNT)}"
    path.write_text(f'[rig]\nname = "{name}"\nrate_hz = 500.0\n' + "".join(WIRE.format(name=c) for c in ("left", "right")))
    with sinew.run(path) as rig:
        yield rig


@pytest.fixture
def process(rig):
    """The node as its users start it."""
    command = [sys.executable, "-m", "sinew_ros2", "--ros-args", "-p", f"rig:={rig.name}", "-p", "hold_after_s:=0.5"]
    process = subprocess.Popen(command)
    yield process
    process.kill()
    process.wait()


@pytest.fixture
def listener(process):
    rclpy.init()
    node = rclpy.create_node("listener")
    listener = Listener(node)
    listener.wait_until(lambda: listener.states and listener.command.get_subscription_count(), "the node")
    yield listener
    node.destroy_node()
    rclpy.shutdown()
