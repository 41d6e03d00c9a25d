//! Finds the name that was probably meant.

/// The candidate nearest to `word`, if one is near enough to be a likely slip of the fingers.
pub(crate) fn nearest<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let word = word.to_lowercase();
    // A long pasted word cannot be a slip of a short key, and the distance is quadratic in its length.
    if word.chars().count() > 80 {
        return None;
    }
    candidates
        .into_iter()
        .map(|c| (distance(&word, &c.to_lowercase()), c))
        .filter(|(d, c)| *d <= 1 + c.chars().count() / 4)
        .min_by_key(|(d, _)| *d)
        .map(|(_, c)| c)
}

/// How many letters must be inserted, dropped, exchanged or swapped with their neighbour (optimal string alignment).
fn distance(a: &str, b: &str) -> usize {
    let (a, b): (Vec<char>, Vec<char>) = (a.chars().collect(), b.chars().collect());
    let mut before = vec![0; b.len() + 1];
    let mut last: Vec<usize> = (0..=b.len()).collect();
    for i in 1..=a.len() {
        let mut row = vec![i; b.len() + 1];
        for j in 1..=b.len() {
            let cost = usize::from(a[i - 1] != b[j - 1]);
            row[j] = (last[j] + 1).min(row[j - 1] + 1).min(last[j - 1] + cost);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                row[j] = row[j].min(before[j - 2] + 1);
            }
        }
        before = std::mem::replace(&mut last, row);
    }
    last[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_single_slips_as_one() {
        assert_eq!(distance("lenght_mm", "length_mm"), 1);
        assert_eq!(distance("length", "length_mm"), 3);
        assert_eq!(distance("", "abc"), 3);
        assert_eq!(distance("abc", "abc"), 0);
    }

    #[test]
    fn suggests_only_what_is_near() {
        let keys = ["diameter_mm", "length_mm"];
        assert_eq!(nearest("diamter_mm", keys), Some("diameter_mm"));
        assert_eq!(nearest("length_m", keys), Some("length_mm"));
        assert_eq!(nearest("LENGTH_MM", keys), Some("length_mm"));
        assert_eq!(nearest("colour", keys), None);
    }
}
