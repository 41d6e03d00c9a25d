//! What is seen of a demonstrator from other threads, without holding it up: a few numbers in atomics.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use crate::picture::{Drawn, Picture};
use crate::pose::{NUMBERS, Pose};
pub use crate::sensor::SAID;

/// What the sensor has said last.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading {
    /// How often it has said something.
    pub count: u32,
    /// Of a camera over a beam: where the ball is, m; at an arm: where the target is seen to the side and ahead, m. Of a receiver: the
    /// pulse's width, s. Of a compass with a level: heading, to the left, and how far it leans, rad. Of a torso: the angles of its joints, rad, and where
    /// the ball is on its paddle, m, NaN where the camera sees none. What there is only one of stands first.
    pub values: [f32; SAID],
}

/// How the machine has done so far, by the truth.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Tally {
    /// Simulated time since the ball was first put down, or since the servo or the arm was first asked, s.
    pub seconds: f64,
    /// How often the ball has fallen off the beam or the paddle, or the hexapod.
    pub falls: u64,
    /// Largest distance of the ball from the middle, of the arm's tip from its target or of a hexapod from its line, m, or of a servo from its
    /// angle, rad: but for the time it has to get there.
    pub worst: f64,
    /// Its mean square.
    pub mean_square: f64,
    /// How far a hexapod has come straight ahead, m.
    pub walked_m: f64,
}

#[derive(Debug, Default)]
struct Cells {
    pose: [AtomicU64; NUMBERS],
    /// A count and an f32 in each, so that neither is seen without the other; those of the same count belong together.
    reading: [AtomicU64; SAID],
    tally: [AtomicU64; 5],
    draught: AtomicU64,
}

/// Sees what the demonstrator it is of does.
#[derive(Debug, Clone)]
pub struct Watch {
    cells: Arc<Cells>,
    of: Drawn,
    /// How it stood at first.
    first: Pose,
}

impl Watch {
    pub(crate) fn new(of: Drawn, first: Pose) -> Watch {
        let watch = Watch { cells: Arc::default(), of, first };
        watch.set_pose(&first, 0.0);
        watch
    }

    /// How it stands now.
    pub fn pose(&self) -> Pose {
        self.first.with_numbers(self.cells.pose.each_ref().map(get))
    }

    /// The share by which a draught takes more heat from the wire now.
    pub fn draught(&self) -> f64 {
        get(&self.cells.draught)
    }

    /// What its sensor has said last.
    pub fn reading(&self) -> Reading {
        loop {
            let words = self.cells.reading.each_ref().map(|cell| cell.load(Ordering::Acquire));
            let [first, others @ ..] = words;
            // between them it has said something else
            if others.iter().all(|word| word >> 32 == first >> 32) {
                let values = words.map(|word| f32::from_bits(word as u32));
                return Reading { count: (first >> 32) as u32, values };
            }
            std::hint::spin_loop();
        }
    }

    /// How it has done.
    pub fn tally(&self) -> Tally {
        let [seconds, falls, worst, mean_square, walked_m] = self.cells.tally.each_ref().map(get);
        Tally { seconds, falls: falls as u64, worst, mean_square, walked_m }
    }

    /// What it looks like now.
    pub fn picture(&self) -> Picture {
        self.of.draw(&self.pose(), self.draught())
    }

    pub(crate) fn set_pose(&self, pose: &Pose, draught: f64) {
        for (cell, number) in self.cells.pose.iter().zip(pose.to_numbers()) {
            set(cell, number);
        }
        set(&self.cells.draught, draught);
    }

    pub(crate) fn say(&self, values: [f64; SAID]) {
        let count = (self.cells.reading[0].load(Ordering::Relaxed) >> 32) as u32;
        for (cell, value) in self.cells.reading.iter().zip(values) {
            let word = u64::from(count.wrapping_add(1)) << 32 | u64::from((value as f32).to_bits());
            cell.store(word, Ordering::Release);
        }
    }

    pub(crate) fn set_tally(&self, tally: &Tally) {
        let numbers = [tally.seconds, tally.falls as f64, tally.worst, tally.mean_square, tally.walked_m];
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
