"""What a ``trajectory_msgs/JointTrajectory`` asks for at a time. Knows neither ROS nor a driver."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Dict, Sequence, Tuple

import numpy as np


class Malformed(ValueError):
    """A trajectory that cannot be carried out, in words with what to do."""


@dataclass(frozen=True)
class Trajectory:
    """Lengths of some channels over time, straight between the points."""

    names: Tuple[str, ...]
    times_s: np.ndarray
    """Of shape (points,), from 0: the first one is where the wires are when it begins."""
    lengths_m: np.ndarray
    """Of shape (points, channels)."""

    @staticmethod
    def of(
        names: Sequence[str],
        points: Sequence[Tuple[float, Sequence[float]]],
        now_m: Dict[str, float],
    ) -> "Trajectory":
        """From its joints, its points (time from the start in s, one length in m a joint), and where every channel of the rig is now.

        Raises :class:`Malformed`.
        """
        if not names:
            raise Malformed("a trajectory without joints; name the channels it is for")
        for name in names:
            if name not in now_m:
                raise Malformed(f"there is no channel {name!r}; there are: {', '.join(now_m)}")
        if len(set(names)) < len(names):
            raise Malformed("a joint stands twice in the trajectory; name each channel once")
        times, lengths = [0.0], [[now_m[name] for name in names]]
        for number, (time_s, positions) in enumerate(points, start=1):
            if len(positions) != len(names):
                raise Malformed(f"point {number} has {len(positions)} positions for {len(names)} joints; give one each, in m")
            if not np.all(np.isfinite(positions)):
                raise Malformed(f"a position of point {number} is not a finite number; give wire lengths in m")
            # The first point may be due at once: then it takes the place of where the wires are.
            if time_s == 0.0 and number == 1:
                lengths[0] = list(positions)
                continue
            if not time_s > times[-1]:
                raise Malformed(f"point {number} is not after the one before; let time_from_start grow from point to point")
            times.append(float(time_s))
            lengths.append(list(positions))
        if not np.all(np.isfinite(lengths[0])):
            raise Malformed("a wire's length is not measured yet; wait until its sensors have proved themselves")
        return Trajectory(tuple(names), np.array(times), np.array(lengths, dtype=float))

    @property
    def duration_s(self) -> float:
        """Time of its last point, s."""
        return float(self.times_s[-1])

    def at(self, time_s: float) -> Dict[str, float]:
        """Lengths by channel, m, so long after its start; after its end those of the last point."""
        return {name: float(np.interp(time_s, self.times_s, row)) for name, row in zip(self.names, self.lengths_m.T)}
