//! "Did you mean …?": the known word nearest to a given one.

/// Jaro–Winkler similarity below which a suggestion would mislead.
const SIMILARITY_MIN: f64 = 0.72;

/// The word of `known` nearest to `given`, if any is near.
pub fn nearest<'a>(given: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let given = given.to_lowercase();
    let similar = |word: &str| strsim::jaro_winkler(&given, &word.to_lowercase());
    let mut best: Option<(f64, &str)> = None;
    for word in known {
        let similarity = similar(word);
        // of equals the first
        if similarity >= SIMILARITY_MIN && best.is_none_or(|(most, _)| similarity > most) {
            best = Some((similarity, word));
        }
    }
    best.map(|(_, word)| word)
}

/// "did you mean 'x'?", or the whole list if no word is near and the list is short; `what` in the
/// plural.
pub fn suggestion<'a>(given: &str, what: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    let mut known: Vec<&str> = known.into_iter().collect();
    let mut seen = std::collections::BTreeSet::new();
    known.retain(|word| seen.insert(*word));
    if let Some(word) = nearest(given, known.iter().copied()) {
        return format!("did you mean '{word}'?");
    }
    match known.len() {
        0 => format!("there are no {what}"),
        1..=12 => format!("known {what}: {}", known.join(", ")),
        _ => String::new(),
    }
}
