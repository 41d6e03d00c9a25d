//! What is seen of a demonstrator from other threads, without holding it up: a few numbers in atomics.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use crate::picture::{Drawn, Picture};
use crate::pose::Pose;

/// What the sensor has said last.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading {
    /// How often it has said something.
    pub count: u32,
    /// Of a camera: where the ball is, m. Of a receiver: the pulse's width, s.
    pub value: f32,
}

/// How the machine has done so far, by the truth.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Tally {
    /// Simulated time since the ball was first put down, or since the servo was first asked, s.
    pub seconds: f64,
    /// How often the ball has fallen off the beam.
    pub falls: u64,
    /// Largest distance of the ball from the middle, m, and of a servo from its angle, rad: but for the time it has to get there.
    pub worst: f64,
    /// Its mean square.
    pub mean_square: f64,
}

#[derive(Debug, Default)]
struct Cells {
    angle: AtomicU64,
    other: AtomicU64,
    /// A count and an f32: one word, so that neither is seen without the other.
    reading: AtomicU64,
    tally: [AtomicU64; 4],
    draught: AtomicU64,
}

/// Sees what the demonstrator it is of does.
#[derive(Debug, Clone)]
pub struct Watch {
    cells: Arc<Cells>,
    of: Drawn,
}

impl Watch {
    pub(crate) fn new(of: Drawn) -> Watch {
        let watch = Watch { cells: Arc::default(), of };
        watch.set_pose(Pose { angle_rad: 0.0, other: f64::NAN }, 0.0);
        watch
    }

    /// How it stands now.
    pub fn pose(&self) -> Pose {
        Pose { angle_rad: get(&self.cells.angle), other: get(&self.cells.other) }
    }

    /// The share by which a draught takes more heat from the wire now.
    pub fn draught(&self) -> f64 {
        get(&self.cells.draught)
    }

    /// What its sensor has said last.
    pub fn reading(&self) -> Reading {
        let word = self.cells.reading.load(Ordering::Acquire);
        Reading { count: (word >> 32) as u32, value: f32::from_bits(word as u32) }
    }

    /// How it has done.
    pub fn tally(&self) -> Tally {
        let [seconds, falls, worst, mean_square] = self.cells.tally.each_ref().map(get);
        Tally { seconds, falls: falls as u64, worst, mean_square }
    }

    /// What it looks like now.
    pub fn picture(&self) -> Picture {
        self.of.draw(&self.pose(), self.draught())
    }

    pub(crate) fn set_pose(&self, pose: Pose, draught: f64) {
        set(&self.cells.angle, pose.angle_rad);
        set(&self.cells.other, pose.other);
        set(&self.cells.draught, draught);
    }

    pub(crate) fn say(&self, value: f64) {
        let count = self.reading().count.wrapping_add(1);
        let word = u64::from(count) << 32 | u64::from((value as f32).to_bits());
        self.cells.reading.store(word, Ordering::Release);
    }

    pub(crate) fn set_tally(&self, tally: &Tally) {
        let numbers = [tally.seconds, tally.falls as f64, tally.worst, tally.mean_square];
        for (cell, number) in self.cells.tally.iter().zip(numbers) {
            set(cell, number);
        }
    }
}

fn get(cell: &AtomicU64) -> f64 {
    f64::from_bits(cell.load(Ordering::Relaxed))
}

fn set(cell: &AtomicU64, value: f64) {
    cell.store(value.to_bits(), Ordering::Relaxed);
}
