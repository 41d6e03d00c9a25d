//! Twinned and detwinned martensite: ξ = ξ_S + ξ_T (chapter 3, first displayed equation; Brinson 1993), of which the detwinned part
//! ξ_S alone is longer than austenite.
//!
//! The one thing remembered is the share s = ξ_S/ξ. Stress detwins, s ≥ g(σ), and never twins again; martensite forms with the share
//! g(σ) of the stress it forms under; transformation to austenite takes of both in proportion. g is Brinson's cosine for all of the
//! martensite twinned, ξ_S = (1 − ξ_S0)/2 cos(π (σ − σ_f)/(σ_s − σ_f)) + (1 + ξ_S0)/2 at ξ_S0 = 0. What is loaded again goes elastically
//! up to the stress it has borne: her ξ_S0 > 0 would begin at σ_s anew, each time farther, at whatever stress the way was interrupted.
//! How much martensite there is stays the affair of the kinetics, so that ξ_S + ξ_T never exceeds 1: what Chung, Heo and Lee (2007)
//! correct in her sum below M_s, where stress and cold transform at once, cannot arise.

use crate::kinetics::Fraction;
use crate::params::Detwinning;

/// Less martensite than this remembers nothing.
const FORGOTTEN: f64 = 1e-12;

impl Detwinning {
    /// The share of martensite that a stress in Pa detwins if none is yet, and its slope in 1/Pa.
    fn detwinned(&self, stress: f64) -> (f64, f64) {
        let span = self.finish_pa - self.start_pa;
        let done = (stress - self.start_pa) / span;
        if done <= 0.0 {
            (0.0, 0.0)
        } else if done >= 1.0 {
            (1.0, 0.0)
        } else {
            let (sine, cosine) = (std::f64::consts::PI * done).sin_cos();
            (0.5 - 0.5 * cosine, 0.5 * std::f64::consts::PI / span * sine)
        }
    }
}

/// What the martensite of one wire remembers, at the start of the piece under way.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Twins {
    law: Detwinning,
    /// s, 0..1.
    share: f64,
    /// The phase that it is the share of.
    of: Fraction,
    /// g of the stress there.
    forming: f64,
}

/// The detwinned martensite at the end of a piece, as its tangent in stress.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Detwinned {
    /// ξ_S.
    pub(crate) fraction: f64,
    /// dξ_S/dσ, 1/Pa; never less than 0.
    pub(crate) slope: f64,
    /// dξ_S/dξ.
    pub(crate) per_fraction: f64,
    /// What ξ_S has gained since the start of the piece.
    pub(crate) gained: f64,
}

impl Twins {
    /// Martensite that has never borne any stress, however much of it there is.
    pub(crate) fn new(law: Detwinning) -> Twins {
        Twins { law, share: 0.0, of: Fraction::of_martensite(1.0), forming: 0.0 }
    }

    /// ξ_S where the piece ends with this phase under this stress, in Pa. Continuous, and grows with ξ and with σ.
    pub(crate) fn at(&self, fraction: &Fraction, stress: f64) -> Detwinned {
        let (share, steeper) = self.law.detwinned(stress);
        let (before, change) = (self.share * self.of.martensite, fraction.change_from(&self.of));
        let (now, slope, per_fraction) = if change > 0.0 {
            // formed under the mean of both ends
            let formed = 0.5 * (self.forming + share);
            (before + formed * change, 0.5 * steeper * change, formed)
        } else {
            (self.share * fraction.martensite, 0.0, self.share)
        };
        let led = share * fraction.martensite;
        if led > now {
            return Detwinned {
                fraction: led,
                slope: steeper * fraction.martensite,
                per_fraction: share,
                gained: led - before,
            };
        }
        Detwinned { fraction: now, slope, per_fraction, gained: now - before }
    }

    /// Closes the piece with this phase and this stress, in Pa.
    pub(crate) fn arrive(&mut self, fraction: &Fraction, stress: f64) {
        let (forming, _) = self.law.detwinned(stress);
        self.share = if fraction.martensite > FORGOTTEN {
            (self.at(fraction, stress).fraction / fraction.martensite).clamp(forming, 1.0)
        } else {
            forming
        };
        (self.of, self.forming) = (*fraction, forming);
    }

    /// ξ_S now.
    pub(crate) fn fraction(&self) -> f64 {
        self.share * self.of.martensite
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const BRINSON: Detwinning = Detwinning { start_pa: 100e6, finish_pa: 170e6 };

    /// Brinson's equation, ξ_S0 = 0.
    #[test]
    fn all_martensite_detwins_along_the_cosine() {
        let twins = Twins::new(BRINSON);
        for mpa in 0..300 {
            let sigma = f64::from(mpa) * 1e6;
            let stated = match mpa {
                ..=100 => 0.0,
                170.. => 1.0,
                _ => 0.5 * (std::f64::consts::PI / (100e6 - 170e6) * (sigma - 170e6)).cos() + 0.5,
            };
            let here = twins.at(&Fraction::of_martensite(1.0), sigma);
            assert!((here.fraction - stated).abs() < 1e-14, "{mpa}: {} {stated}", here.fraction);
            let beyond = twins.at(&Fraction::of_martensite(1.0), sigma + 10.0).fraction;
            assert!((here.slope - (beyond - here.fraction) / 10.0).abs() < 1e-14, "{mpa}: {}", here.slope);
        }
    }

    #[test]
    fn what_is_loaded_again_goes_on_where_it_was() {
        let all = Fraction::of_martensite(1.0);
        let mut twins = Twins::new(BRINSON);
        twins.arrive(&all, 135e6);
        assert!((twins.fraction() - 0.5).abs() < 1e-14);
        for mpa in [0.0, 50.0, 120.0, 134.9] {
            twins.arrive(&all, mpa * 1e6);
            assert!((twins.fraction() - 0.5).abs() < 1e-14, "{mpa}");
        }
        twins.arrive(&all, 152.5e6);
        assert!((twins.fraction() - (0.5 + 0.125f64.sqrt())).abs() < 1e-14, "{}", twins.fraction());
    }

    /// Half turned to austenite and back without stress: half of what was detwinned is twinned now.
    #[test]
    fn transformation_takes_of_both_and_gives_by_its_stress() {
        let mut twins = Twins::new(BRINSON);
        twins.arrive(&Fraction::of_martensite(1.0), 200e6);
        twins.arrive(&Fraction::of_martensite(1.0), 0.0);
        twins.arrive(&Fraction::of_martensite(0.5), 0.0);
        assert_eq!(twins.fraction(), 0.5);
        twins.arrive(&Fraction::of_martensite(1.0), 0.0);
        assert_eq!(twins.fraction(), 0.5);
        twins.arrive(&Fraction::of_martensite(0.0), 0.0);
        twins.arrive(&Fraction::of_martensite(1.0), 0.0);
        assert_eq!(twins.fraction(), 0.0);
    }

    proptest! {
        /// Along any way: a share is a share, strain is continuous in ξ and σ and falls with neither, and a piece of no length does nothing.
        #[test]
        fn a_share_stays_one_and_nothing_jumps(
            way in prop::collection::vec((0.0f64..=1.0, 0.0f64..300e6), 1..40),
        ) {
            let mut twins = Twins::new(BRINSON);
            twins.arrive(&Fraction::of_martensite(way[0].0), way[0].1);
            let mut stress = way[0].1;
            for &(martensite, next) in &way {
                prop_assert!((0.0..=1.0).contains(&twins.share), "{}", twins.share);
                let here = twins.at(&twins.of, stress);
                prop_assert!(here.gained.abs() < 1e-15, "{here:?}");
                let end = Fraction::of_martensite(martensite);
                for i in 0..20 {
                    let share = f64::from(i) / 20.0;
                    let sigma = share * 300e6;
                    let (a, b) = (twins.at(&end, sigma), twins.at(&end, sigma + 1e3));
                    prop_assert!(a.slope >= 0.0 && b.fraction >= a.fraction - 1e-15, "{a:?} {b:?}");
                    // π/2 of a share in 70 MPa
                    prop_assert!(b.fraction - a.fraction <= 1.001 * 1e3 * std::f64::consts::FRAC_PI_2 / 70e6);
                    prop_assert!((-1e-15..=martensite + 1e-15).contains(&a.fraction), "{a:?}");
                    let (c, d) = (Fraction::of_martensite(share), Fraction::of_martensite(share + 1e-6));
                    let more = twins.at(&d, sigma).fraction - twins.at(&c, sigma).fraction;
                    prop_assert!((-1e-15..=1e-6 + 1e-15).contains(&more), "{more}");
                }
                twins.arrive(&end, next);
                stress = next;
            }
        }
    }
}
