//! Straight lines and discs, and what they are of.

/// What a thing is made of, to be drawn in a colour of its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ink {
    /// Frame, ground, marks.
    Frame,
    /// What the wire moves.
    Body,
    /// The wire.
    Wire,
    /// What is handled: a ball.
    Load,
    /// Where it is wanted.
    Goal,
}

impl Ink {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Ink::Frame => "frame",
            Ink::Body => "body",
            Ink::Wire => "wire",
            Ink::Load => "load",
            Ink::Goal => "goal",
        }
    }
}

/// A part of a picture; x to the right, y up, m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Shape {
    /// A straight line of this width.
    Line {
        /// One end.
        from: [f64; 2],
        /// The other.
        to: [f64; 2],
        /// How wide, m.
        width: f64,
        /// Drawn as.
        ink: Ink,
    },
    /// A disc.
    Disc {
        /// Its middle.
        at: [f64; 2],
        /// Radius, m.
        radius: f64,
        /// Drawn as.
        ink: Ink,
    },
}

/// What a machine looks like.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    /// What is in it, the hindmost first.
    pub shapes: Vec<Shape>,
    /// How far it reaches to either side, and up and down, m.
    pub half_size: [f64; 2],
    /// What there is to say beside it.
    pub says: String,
}
