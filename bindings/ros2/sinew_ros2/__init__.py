"""A ROS 2 node for a running driver of sinew: :mod:`sinew_ros2.node`; the motion between a trajectory's points: :mod:`sinew_ros2.trajectory`."""
