//! Notes that repeat, counted: twelve gaps are one line.
//!
//! Notes are alike where they differ in numbers and in quoted names only. One of a kind stays as it
//! is; of several the first is shown behind their count and the number of channels that they name.

use std::collections::BTreeSet;

/// The notes in the order in which each kind first occurs, one line per kind.
pub fn counted(notes: &[String]) -> Vec<String> {
    let mut kinds: Vec<(String, Vec<&String>)> = Vec::new();
    for note in notes {
        let (pattern, _) = pattern(note);
        match kinds.iter_mut().find(|(known, _)| *known == pattern) {
            Some((_, alike)) => alike.push(note),
            None => kinds.push((pattern, vec![note])),
        }
    }
    kinds.iter().map(|(_, alike)| line(alike)).collect()
}

fn line(alike: &[&String]) -> String {
    let [first, _, ..] = alike else { return alike[0].clone() };
    let names: BTreeSet<String> = alike.iter().flat_map(|note| pattern(note).1).collect();
    let channels = match names.len() {
        0 => String::new(),
        1 => " in 1 channel".to_owned(),
        n => format!(" in {n} channels"),
    };
    let what = if first.split(' ').any(|word| word == "gap") { "gaps" } else { "notes of one kind" };
    format!("{} {what}{channels}, the first: {first}", alike.len())
}

/// The note with `#` for numbers and quoted names, and these names.
fn pattern(note: &str) -> (String, Vec<String>) {
    let (mut pattern, mut names) = (String::new(), Vec::new());
    let mut rest = note;
    while let Some(letter) = rest.chars().next() {
        let behind = &rest[letter.len_utf8()..];
        let quoted = if matches!(letter, '`' | '\'') { behind.find(letter) } else { None };
        if let Some(end) = quoted {
            names.push(behind[..end].to_owned());
            pattern.push('#');
            rest = &behind[end + 1..];
        } else if letter.is_ascii_digit() {
            let in_number = |c: char| c.is_ascii_digit() || matches!(c, '.' | 'e' | '-');
            pattern.push('#');
            rest = rest.trim_start_matches(in_number);
        } else {
            pattern.push(letter);
            rest = behind;
        }
    }
    (pattern, names)
}

#[cfg(test)]
mod tests {
    use super::counted;

    fn notes(all: &[&str]) -> Vec<String> {
        all.iter().map(|note| (*note).to_owned()).collect()
    }

    #[test]
    fn a_note_without_a_like_stays_as_it_is_and_in_its_place() {
        let all = notes(&["left out: `label` (text)", "time counts from 2026-01-01", "the last line is cut"]);
        assert_eq!(counted(&all), all);
        assert!(counted(&[]).is_empty());
    }

    #[test]
    fn notes_that_differ_in_numbers_or_names_only_are_one_line_with_their_count() {
        let gap = |k: usize, name: &str| format!("gap of 0.{k} s from {k} s in `{name}`: reported, not filled");
        let mut all: Vec<String> = (1..=12).map(|k| gap(k, ["a", "b", "c"][k % 3])).collect();
        all.insert(5, "the bag is cut".to_owned());
        let lines = counted(&all);
        assert_eq!(lines, [format!("12 gaps in 3 channels, the first: {}", gap(1, "b")), "the bag is cut".to_owned()]);
    }

    #[test]
    fn every_note_is_counted_once() {
        let all = notes(&["3 rows dropped", "x is odd", "1e-3 rows dropped", "4 rows dropped", "y is odd"]);
        let lines = counted(&all);
        assert_eq!(lines, ["3 notes of one kind, the first: 3 rows dropped", "x is odd", "y is odd"]);
        let counts = lines.iter().map(|line| {
            let several = line.split_once(" notes of one kind");
            several.map_or(1, |(count, _)| count.parse::<usize>().unwrap())
        });
        assert_eq!(counts.sum::<usize>(), all.len());
    }
}
