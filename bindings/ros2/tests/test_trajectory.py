"""The motion between points, without ROS and without a driver."""

import math

import pytest

from sinew_ros2.trajectory import Malformed, Trajectory

NOW_M = {"left": 0.166, "right": 0.165}


def test_it_begins_where_the_wires_are_and_goes_straight_from_point_to_point():
    trajectory = Trajectory.of(["right", "left"], [(1.0, [0.164, 0.166]), (3.0, [0.160, 0.162])], NOW_M)
    assert trajectory.duration_s == 3.0
    for time_s, right, left in [(0.0, 0.165, 0.166), (0.5, 0.1645, 0.166), (1.0, 0.164, 0.166), (2.0, 0.162, 0.164), (9.0, 0.160, 0.162)]:
        assert trajectory.at(time_s) == pytest.approx({"right": right, "left": left})


def test_a_first_point_at_once_takes_the_place_of_where_they_are():
    trajectory = Trajectory.of(["left"], [(0.0, [0.163]), (2.0, [0.161])], NOW_M)
    assert trajectory.at(0.0) == {"left": 0.163} and trajectory.at(1.0)["left"] == pytest.approx(0.162)


@pytest.mark.parametrize(
    "names, points, words",
    [
        ([], [(1.0, [])], "without joints"),
        (["lefd"], [(1.0, [0.16])], "there are: left, right"),
        (["left", "left"], [(1.0, [0.16, 0.16])], "stands twice"),
        (["left"], [(1.0, [0.16, 0.16])], "2 positions for 1 joints"),
        (["left"], [(1.0, [])], "0 positions for 1 joints"),
        (["left"], [(1.0, [math.nan])], "not a finite number"),
        (["left"], [(2.0, [0.16]), (1.0, [0.16])], "point 2 is not after"),
        (["left"], [(1.0, [0.16]), (1.0, [0.16])], "point 2 is not after"),
        (["left"], [(-1.0, [0.16])], "point 1 is not after"),
    ],
)
def test_what_cannot_be_carried_out_is_told(names, points, words):
    with pytest.raises(Malformed, match=words):
        Trajectory.of(names, points, NOW_M)


def test_a_wire_that_is_not_measured_is_not_moved_from_nowhere():
    with pytest.raises(Malformed, match="not measured"):
        Trajectory.of(["left"], [(1.0, [0.16])], {"left": math.nan})
