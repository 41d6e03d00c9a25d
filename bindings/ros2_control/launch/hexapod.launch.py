"""The built-in hexapod under ros2_control, with a driver running: sinew run."""

from pathlib import Path

from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue


def generate_launch_description():
    share = Path(get_package_share_directory("sinew_ros2_control"))
    controllers = str(share / "config" / "hexapod.yaml")
    # as text: a URDF that is looked at as YAML may be taken for something else
    description = ParameterValue((share / "urdf" / "hexapod.urdf").read_text(), value_type=str)
    return LaunchDescription(
        [
            Node(
                package="robot_state_publisher",
                executable="robot_state_publisher",
                parameters=[{"robot_description": description}],
            ),
            # It has the description from robot_state_publisher.
            Node(package="controller_manager", executable="ros2_control_node", parameters=[controllers], output="both"),
            Node(
                package="controller_manager",
                executable="spawner",
                arguments=["joint_state_broadcaster", "joint_trajectory_controller", "--param-file", controllers],
            ),
        ]
    )
