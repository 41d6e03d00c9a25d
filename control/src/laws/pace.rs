//! How fast a reference moves: what laws that follow one ask of it.

/// Time over which the speed of a reference is averaged, s.
const TIME_S: f64 = 0.02;

/// The speed of a reference.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pace {
    reference: f64,
    /// m/s; 0 for a reference that steps.
    pub velocity: f64,
}

impl Pace {
    pub const NONE: Pace = Pace { reference: f64::NAN, velocity: 0.0 };

    /// Takes a cycle in; what moves by `jump` (m) or more in one has stepped.
    #[inline]
    pub fn follow(&mut self, reference: f64, dt: f64, jump: f64) {
        let moved = reference - self.reference;
        self.reference = reference;
        if moved.abs() < jump {
            // (moved/dt − v) dt/(dt + τ), which an instant of no length must not divide by
            self.velocity += (moved - self.velocity * dt) / (dt + TIME_S);
        } else {
            self.velocity = 0.0;
        }
    }
}
