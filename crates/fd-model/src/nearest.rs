//! Names that a user may have meant.

/// At most three of `known` that differ from `name` by no more than a third of its letters, at
/// least one, the nearest first (Levenshtein 1966). Case counts for nothing.
///
/// ```
/// use fd_model::nearest;
///
/// assert_eq!(nearest("omga", ["theta", "omega", "tau"]), ["omega"]);
/// ```
pub fn nearest<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Vec<String> {
    let allowed = (name.chars().count() / 3).max(1);
    let name = name.to_lowercase();
    let mut found: Vec<(usize, &str)> = known
        .into_iter()
        .map(|candidate| (strsim::levenshtein(&name, &candidate.to_lowercase()), candidate))
        .filter(|(distance, _)| *distance <= allowed)
        .collect();
    found.sort_unstable();
    found.dedup();
    found.into_iter().take(3).map(|(_, candidate)| candidate.to_owned()).collect()
}
