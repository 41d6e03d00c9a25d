"""The built-in hexapod under ros2_control, with a driver running: sinew run."""

from launch import LaunchDescription
from launch.substitutions import FileContent, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare


def generate_launch_description():
    share = FindPackageShare("sinew_ros2_control")
    controllers = PathJoinSubstitution([share, "config", "hexapod.yaml"])
    description = FileContent(PathJoinSubstitution([share, "urdf", "hexapod.urdf"]))
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
