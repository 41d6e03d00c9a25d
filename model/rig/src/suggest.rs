//! Finds the name that was probably meant.

use strsim::osa_distance;

/// The candidate nearest to `word`, if one is near enough to be a likely slip of the fingers.
pub fn nearest<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let word = word.to_lowercase();
    // A long pasted word cannot be a slip of a short key, and the distance is quadratic in its length.
    if word.chars().count() > 80 {
        return None;
    }
    candidates
        .into_iter()
        .map(|c| (osa_distance(&word, &c.to_lowercase()), c))
        .filter(|(d, c)| *d <= 1 + c.chars().count() / 4)
        .min_by_key(|(d, _)| *d)
        .map(|(_, c)| c)
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
        assert_eq!(nearest(&"x".repeat(100_000), keys), None);
    }
}
