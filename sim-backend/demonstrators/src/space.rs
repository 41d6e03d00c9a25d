//! Places and turns in space.

/// A place or a direction: ahead, to the left, up.
pub(crate) type Vector = [f64; 3];

pub(crate) fn sum(a: Vector, b: Vector) -> Vector {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

pub(crate) fn difference(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub(crate) fn times(share: f64, a: Vector) -> Vector {
    a.map(|x| share * x)
}

pub(crate) fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// How a body is turned: a unit quaternion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Turn {
    real: f64,
    axis: Vector,
}

impl Turn {
    /// By an angle around the upright axis, to the left.
    pub fn heading(angle_rad: f64) -> Turn {
        let (sin, cos) = (0.5 * angle_rad).sin_cos();
        Turn { real: cos, axis: [0.0, 0.0, sin] }
    }

    /// From heading, pitch (nose down) and roll (to the right), as [`Turn::angles`] has them.
    pub fn of([heading, pitch, roll]: [f64; 3]) -> Turn {
        let about =
            |angle: f64, axis: Vector| Turn { real: (0.5 * angle).cos(), axis: times((0.5 * angle).sin(), axis) };
        Turn::heading(heading).after(about(pitch, [0.0, 1.0, 0.0])).after(about(roll, [1.0, 0.0, 0.0]))
    }

    /// First `first`, then this.
    fn after(self, first: Turn) -> Turn {
        let real = self.real * first.real - dot(self.axis, first.axis);
        let axis = sum(sum(times(self.real, first.axis), times(first.real, self.axis)), cross(self.axis, first.axis));
        Turn { real, axis }
    }

    /// After a time with this spin, rad/s, in the body's own directions.
    pub fn spun(self, spin: Vector, dt_s: f64) -> Turn {
        let Turn { real, axis } = self.after(Turn { real: 1.0, axis: times(0.5 * dt_s, spin) });
        let length = (real * real + dot(axis, axis)).sqrt();
        Turn { real: real / length, axis: times(1.0 / length, axis) }
    }

    /// From the body's own directions to the world's.
    pub fn out(self, a: Vector) -> Vector {
        let twice = times(2.0, cross(self.axis, a));
        sum(sum(a, times(self.real, twice)), cross(self.axis, twice))
    }

    /// From the world's directions to the body's own.
    pub fn back(self, a: Vector) -> Vector {
        Turn { real: self.real, axis: times(-1.0, self.axis) }.out(a)
    }

    /// Heading to the left, pitch with the nose down, roll to the right, rad.
    pub fn angles(self) -> [f64; 3] {
        let (ahead, up) = (self.out([1.0, 0.0, 0.0]), [self.back([0.0, 0.0, 1.0])[1], self.back([0.0, 0.0, 1.0])[2]]);
        [ahead[1].atan2(ahead[0]), (-ahead[2]).clamp(-1.0, 1.0).asin(), up[0].atan2(up[1])]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turned_about_and_back_a_place_is_where_it_was() {
        let turn = Turn::of([0.7, -0.2, 0.4]);
        let place = [0.3, -0.1, 0.2];
        let again = turn.back(turn.out(place));
        assert!((0..3).all(|axis| (again[axis] - place[axis]).abs() < 1e-12), "{again:?}");
        let angles = turn.angles();
        assert!([0.7, -0.2, 0.4].iter().zip(angles).all(|(a, b)| (a - b).abs() < 1e-12), "{angles:?}");
    }

    #[test]
    fn spun_a_quarter_ahead_is_left() {
        let turn =
            (0..1000).fold(Turn::heading(0.0), |turn, _| turn.spun([0.0, 0.0, std::f64::consts::FRAC_PI_2], 1e-3));
        let ahead = turn.out([1.0, 0.0, 0.0]);
        assert!((ahead[0]).abs() < 1e-6 && (ahead[1] - 1.0).abs() < 1e-6, "{ahead:?}");
        assert!((turn.angles()[0] - std::f64::consts::FRAC_PI_2).abs() < 1e-6);
    }
}
