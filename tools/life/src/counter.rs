//! Cycles of the transformation, found sample by sample: rainflow counting in its three-point form (ASTM E1049), in constant memory.

use serde::{Deserialize, Serialize};

/// A movement smaller than this share of the transformation is none: ripple of a length that is held, and noise. By the law of life it would
/// use less than a hundredth of what a whole cycle does.
pub const LEAST_SHARE: f64 = 0.05;
/// Most turns that are kept open. Where there are more, the oldest is counted as it is, as half a cycle.
pub const MOST_OPEN: usize = 64;

/// What a wire goes through at a moment.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Moment {
    /// Share of the wire that is martensite, or a strain in terms of the whole transformation's.
    pub share: f64,
    /// Strain, as a share of the length.
    pub strain: f64,
    /// Stress, Pa; at a turn the largest on the way to it.
    pub stress_pa: f64,
    /// How far it is overheated, 0..1; at a turn the most on the way to it.
    pub overheated: f64,
}

impl Moment {
    /// Takes the peaks of another moment in.
    fn absorb(&mut self, other: &Moment) {
        self.stress_pa = self.stress_pa.max(other.stress_pa);
        self.overheated = self.overheated.max(other.overheated);
    }
}

/// A cycle that was found, or half of one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cycle {
    /// 1, or 0.5 of half a cycle.
    pub weight: f64,
    /// Share of the transformation between its ends.
    pub share: f64,
    /// Strain between its ends.
    pub strain: f64,
    /// Largest stress in it, Pa.
    pub stress_pa: f64,
    /// The most it was overheated in it.
    pub overheated: f64,
}

impl Cycle {
    fn between(a: &Moment, b: &Moment, weight: f64) -> Cycle {
        Cycle {
            weight,
            share: (a.share - b.share).abs(),
            strain: (a.strain - b.strain).abs(),
            // what is on the way to the later of both
            stress_pa: b.stress_pa,
            overheated: b.overheated,
        }
    }
}

/// The counter. It can be kept in a file and go on.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Counter {
    /// Turns that no cycle has been closed over yet, oldest first.
    turns: Vec<Moment>,
    /// The furthest of the present way, which becomes a turn when it is left.
    furthest: Option<Moment>,
    /// The peaks since then.
    since: Option<Moment>,
    /// Whether the share rises on the present way; `None` before there is one.
    rising: Option<bool>,
}

impl Counter {
    /// Takes a moment in; hands every cycle that closes with it to `found`.
    pub fn see(&mut self, now: &Moment, mut found: impl FnMut(&Cycle)) {
        let Some(furthest) = self.furthest else {
            self.turns.push(*now);
            (self.furthest, self.since) = (Some(*now), Some(*now));
            return;
        };
        let mut since = self.since.unwrap_or(*now);
        since.absorb(now);
        let way = now.share - furthest.share;
        let goes_on = match self.rising {
            None if way.abs() >= LEAST_SHARE => {
                self.rising = Some(way > 0.0);
                true
            }
            None => false,
            Some(rising) => (way > 0.0) == rising && way != 0.0,
        };
        if goes_on {
            let mut next = Moment { share: now.share, strain: now.strain, ..furthest };
            next.absorb(&since);
            (self.furthest, self.since) = (Some(next), Some(*now));
        } else if let Some(rising) = self.rising
            && way.abs() >= LEAST_SHARE
        {
            self.turn(furthest, &mut found);
            let next = Moment { share: now.share, strain: now.strain, ..since };
            (self.furthest, self.since, self.rising) = (Some(next), Some(*now), Some(!rising));
        } else {
            self.since = Some(since);
        }
    }

    /// A turn is certain: closes what it closes.
    fn turn(&mut self, turn: Moment, found: &mut impl FnMut(&Cycle)) {
        self.turns.push(turn);
        while let [.., a, b, c] = self.turns[..] {
            let (inner, outer) = ((a.share - b.share).abs(), (b.share - c.share).abs());
            if outer < inner {
                break;
            }
            let last = self.turns.len() - 1;
            if last == 2 {
                // over the beginning no cycle can close
                found(&Cycle::between(&a, &b, 0.5));
                self.turns.remove(0);
                break;
            }
            found(&Cycle::between(&a, &b, 1.0));
            // the way that is left leads through it
            let mut through = c;
            through.absorb(&b);
            through.absorb(&a);
            self.turns.truncate(last - 2);
            self.turns.push(through);
        }
        if self.turns.len() > MOST_OPEN {
            found(&Cycle::between(&self.turns[0], &self.turns[1], 0.5));
            self.turns.remove(0);
        }
    }

    /// What is open, as the half cycles that it would be if it ended now.
    pub fn open(&self) -> impl Iterator<Item = Cycle> + '_ {
        let last = self.turns.last().zip(self.furthest.as_ref()).filter(|_| self.rising.is_some());
        let pairs = self.turns.windows(2).map(|pair| Cycle::between(&pair[0], &pair[1], 0.5));
        pairs.chain(last.map(|(turn, furthest)| Cycle::between(turn, furthest, 0.5)))
    }

    /// Whether every number in it is one, and there are no more of them than there can be.
    pub(crate) fn is_sound(&self) -> bool {
        let moments = self.turns.iter().chain(&self.furthest).chain(&self.since);
        let is_sound = |m: &Moment| [m.share, m.strain, m.stress_pa, m.overheated].iter().all(|x| x.is_finite());
        self.turns.len() <= MOST_OPEN + 1
            && moments.into_iter().all(is_sound)
            && (self.furthest.is_none() == self.turns.is_empty())
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn at(share: f64) -> Moment {
        Moment { share, strain: 0.04 * share, stress_pa: 100e6, overheated: 0.0 }
    }

    fn count(path: impl IntoIterator<Item = Moment>) -> (Vec<Cycle>, Counter) {
        let (mut counter, mut cycles) = (Counter::default(), Vec::new());
        for moment in path {
            counter.see(&moment, |cycle| cycles.push(*cycle));
        }
        (cycles, counter)
    }

    /// The example of ASTM E1049: −2 1 −3 5 −1 3 −4 4 −2 gives half cycles of 3, 4, 8, 9, 8, 6 and a whole one of 4.
    #[test]
    fn the_standards_example_comes_out() {
        let (cycles, counter) = count([-2.0, 1.0, -3.0, 5.0, -1.0, 3.0, -4.0, 4.0, -2.0].map(at));
        let mut found: Vec<(f64, f64)> =
            cycles.iter().copied().chain(counter.open()).map(|c| (c.share, c.weight)).collect();
        found.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
        assert_eq!(found, [(3.0, 0.5), (4.0, 0.5), (4.0, 1.0), (6.0, 0.5), (8.0, 0.5), (8.0, 0.5), (9.0, 0.5)]);
    }

    #[test]
    fn an_inner_loop_is_a_cycle_of_its_own_and_has_its_own_peaks() {
        let mut path = [1.0, 0.0, 0.6, 0.3, 1.0, 0.0].map(at);
        path[3].stress_pa = 300e6;
        let (cycles, counter) = count(path);
        assert_eq!(cycles.len(), 2, "{cycles:?}");
        let inner = cycles[0];
        assert!((inner.share - 0.3).abs() < 1e-12 && inner.weight == 1.0 && (inner.strain - 0.012).abs() < 1e-12);
        assert_eq!(inner.stress_pa, 300e6);
        assert_eq!((cycles[1].share, cycles[1].weight, cycles[1].stress_pa), (1.0, 0.5, 100e6), "that was before");
        let open: Vec<Cycle> = counter.open().collect();
        assert_eq!(
            open.iter().map(|c| c.stress_pa).collect::<Vec<_>>(),
            [300e6, 100e6],
            "the outer way led through it"
        );
    }

    #[test]
    fn a_peak_between_samples_of_a_way_belongs_to_it() {
        let mut path: Vec<Moment> =
            (0..=20).chain((0..20).rev()).chain(1..=20).map(|i| at(f64::from(i) * 0.05)).collect();
        path[25].overheated = 0.5;
        let (cycles, counter) = count(path);
        let heat: Vec<f64> = cycles.iter().copied().chain(counter.open()).map(|c| c.overheated).collect();
        assert_eq!(heat, [0.0, 0.5, 0.0]);
    }

    proptest! {
        /// A signal's transformation is that of its cycles, whatever was counted of it and when, and noise adds none.
        #[test]
        fn the_way_is_the_sum_of_the_cycles(turns in prop::collection::vec(0.0f64..1.0, 2..200), noise in 0.0f64..0.02) {
            let mut way = 0.0;
            let mut path = vec![turns[0]];
            for pair in turns.windows(2) {
                // a way that is none would be left out
                if (pair[1] - path[path.len() - 1]).abs() > 0.1 {
                    way += (pair[1] - path[path.len() - 1]).abs();
                    path.push(pair[1]);
                }
            }
            let mut moments = Vec::new();
            for pair in path.windows(2) {
                for k in 0..50 {
                    let ripple = if k % 2 == 0 || k == 0 { 0.0 } else { noise * (0.5 - f64::from(k % 4) / 4.0) };
                    moments.push(at(pair[0] + (pair[1] - pair[0]) * f64::from(k) / 50.0 + ripple));
                }
            }
            moments.push(at(path[path.len() - 1]));
            let (cycles, counter) = count(moments);
            let found: f64 = cycles.iter().copied().chain(counter.open()).map(|c| 2.0 * c.weight * c.share).sum();
            let slack = 0.06 * path.len() as f64 * f64::from(u8::from(noise > 0.0)) + 1e-9;
            prop_assert!((found - way).abs() <= slack, "{found} {way}");
        }

        #[test]
        fn it_needs_no_more_memory_the_longer_it_runs_and_goes_on_from_a_file(shares in prop::collection::vec(0.0f64..1.0, 0..2000), cut in 0usize..2000) {
            let (all, whole) = count(shares.iter().map(|s| at(*s)));
            let cut = cut.min(shares.len());
            let (mut cycles, first) = count(shares[..cut].iter().map(|s| at(*s)));
            let text = serde_json::to_string(&first).unwrap();
            prop_assert!(text.len() < 20_000);
            let mut again: Counter = serde_json::from_str(&text).unwrap();
            prop_assert!(again.is_sound());
            for share in &shares[cut..] {
                again.see(&at(*share), |cycle| cycles.push(*cycle));
            }
            // JSON keeps all but the last digit
            let close = |a: f64, b: f64| (a - b).abs() <= 1e-12 * a.abs().max(b.abs()).max(1.0);
            prop_assert_eq!(cycles.len(), all.len());
            for (a, b) in cycles.iter().zip(&all) {
                prop_assert!(a.weight == b.weight && close(a.share, b.share) && close(a.strain, b.strain), "{:?} {:?}", a, b);
            }
            prop_assert_eq!(again.open().count(), whole.open().count());
        }
    }

    #[test]
    fn what_never_closes_is_bounded() {
        // ever smaller loops: nothing closes
        let (cycles, counter) =
            count((0..4000).map(|k| at(1000.0 * 0.999f64.powi(k) * if k % 2 == 0 { 1.0 } else { -1.0 })));
        assert!(counter.turns.len() <= MOST_OPEN && cycles.len() > 3000, "{}", cycles.len());
        assert!(counter.is_sound());
    }
}
