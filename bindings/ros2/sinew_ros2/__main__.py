"""``python -m sinew_ros2 --ros-args -p rig:=bench``."""

from .node import main

main()
