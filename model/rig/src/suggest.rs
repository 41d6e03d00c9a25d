//! Finds the name that was probably meant.

use strsim::osa_distance;

/// The candidate nearest to `word`, if one is near enough to be a likely slip of the fingers.
pub fn nearest<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let word = word.to_lowercase();
    // A long pasted word cannot be a slip of a short key, and the distance is quadratic in its length.
    if word.chars().count() > 80 {
        return None;
    }
    let candidates: Vec<&str> = candidates.into_iter().collect();
    let slip = candidates
        .iter()
        .map(|c| (osa_distance(&word, &c.to_lowercase()), *c))
        .filter(|(d, c)| *d <= 1 + c.chars().count() / 4)
        .min_by_key(|(d, _)| *d);
    slip.map(|(_, c)| c).or_else(|| in_another_unit(&word, &candidates))
}

/// The one candidate that is the same but for its unit, or the lack of one: `rate_hertz` for `rate_hz`, `mass` for `mass_kg`.
fn in_another_unit<'a>(word: &str, candidates: &[&'a str]) -> Option<&'a str> {
    let of = |stem: &str| {
        let mut same = candidates.iter().filter(|c| c.rsplit_once('_').is_some_and(|(its, _)| its == stem));
        same.next().filter(|_| same.next().is_none()).copied()
    };
    of(word).or_else(|| of(word.rsplit_once('_')?.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn suggests_only_what_is_near() {
        let keys = ["diameter_mm", "length_mm"];
        assert_eq!(nearest("diamter_mm", keys), Some("diameter_mm"));
        assert_eq!(nearest("length_m", keys), Some("length_mm"));
        assert_eq!(nearest("LENGTH_MM", keys), Some("length_mm"));
        assert_eq!(nearest("colour", keys), None);
        let keys = ["rate_hz", "mass_kg", "length_mm", "length_weight"];
        assert_eq!(nearest("rate_hertz", keys), Some("rate_hz"));
        assert_eq!(nearest("mass", keys), Some("mass_kg"));
        assert_eq!(nearest("mass_grams", keys), Some("mass_kg"));
        assert_eq!(nearest("length_inches", keys), None, "two are the same but for the last word");
        assert_eq!(nearest(&"x".repeat(100_000), keys), None);
    }
}
