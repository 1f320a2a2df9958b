//! How rows are divided and what points and commas are in them.

use crate::file;
use recording::{Intake, SeriesSet};

const ROWS: usize = 60;

fn rows(row: impl Fn(usize) -> String) -> String {
    (0..ROWS).map(|k| row(k) + "\n").collect()
}

fn read(name: &str, text: &str) -> Result<SeriesSet, String> {
    let path = file(&format!("dialect_{}.txt", name.replace(' ', "_")), text);
    recording::read_with(&path, &Intake::default()).and_then(recording::series).map_err(|error| error.explain())
}

fn values(set: &SeriesSet, name: &str) -> Vec<f64> {
    let channel = set.recording.channel_named(name);
    channel.unwrap_or_else(|| panic!("{name}: {:?} {:?}", set.recording.channels, set.notes)).value.clone()
}

fn noted(set: &SeriesSet, part: &str) {
    assert!(set.notes.iter().any(|note| note.contains(part)), "`{part}` is missing in {:?}", set.notes);
}

/// In steps of a quarter, and no zero.
fn slow(k: usize) -> f64 {
    (k as f64 - 20.5) / 4.0
}

#[test]
fn a_decimal_comma_does_not_divide_two_columns() {
    for (name, separator) in [("tab", "\t"), ("semicolon", ";"), ("blanks", "  "), ("bar", "|")] {
        for digits in [2, 3, 5] {
            let rows =
                rows(|k| format!("{:.digits$}{separator}{:.digits$}", 0.01 * k as f64, slow(k)).replace('.', ","));
            let set = read(&format!("{name} {digits}"), &format!("t [s]{separator}a [V]\n{rows}")).unwrap();
            let found = values(&set, "a");
            assert_eq!(found.len(), ROWS, "{name} {digits}");
            let near = |(k, value): (usize, &f64)| (value - slow(k)).abs() < 0.006;
            assert!(found.iter().enumerate().all(near), "{name} {digits}: {found:?}");
        }
    }
}

#[test]
fn a_table_has_one_decimal_sign_and_the_other_divides_thousands() {
    let thousands = |k: usize, sign: char| {
        let whole = 15 + 40 * k;
        if whole < 1000 { format!("{whole}") } else { format!("{}{sign}{:03}", whole / 1000, whole % 1000) }
    };
    let files = [
        ("german", rows(|k| format!("{};{};0,00{k:03}", 10 * k, thousands(k, '.')))),
        ("american", rows(|k| format!("{};{};0.00{k:03}", 10 * k, thousands(k, ',')))),
        ("american whole", rows(|k| format!("{};{};{k}", 10 * k, thousands(k, ',')))),
        ("american in tabs", rows(|k| format!("{}\t{}\t{k}", 10 * k, thousands(k, ',')))),
        ("american in quotes", rows(|k| format!("\"{}\",\"{}\",\"{k}\"", 10 * k, thousands(k, ',')))),
        ("swiss", rows(|k| format!("{};{};{k}", 10 * k, thousands(k, '\'')))),
    ];
    for (name, rows) in files {
        let separator = if name.contains("quotes") {
            ","
        } else if name.contains("tabs") {
            "\t"
        } else {
            ";"
        };
        let header = ["t [ms]", "count", "b [V]"].join(separator);
        let set = read(name, &format!("{header}\n{rows}")).unwrap_or_else(|error| panic!("{name}: {error}"));
        let expected: Vec<f64> = (0..ROWS).map(|k| (15 + 40 * k) as f64).collect();
        assert_eq!(values(&set, "count"), expected, "{name}");
    }
    let millions = rows(|k| format!("{:.2};4,999,8{k:02}", 0.01 * k as f64));
    let set = read("millions", &format!("t [s];p [Pa]\n{millions}")).unwrap();
    assert_eq!(values(&set, "p")[1], 4_999_801.0);
}

#[test]
fn a_number_that_can_be_read_in_two_ways_is_noted() {
    let set = read("point", &format!("t [ms];speed [rpm]\n{}", rows(|k| format!("{};2.0{k:02}", 10 * k)))).unwrap();
    noted(&set, "the point in `2.000` is read as the decimal sign");
    let set = read("comma", &format!("t [ms];speed [rpm]\n{}", rows(|k| format!("{};2,0{k:02}", 10 * k)))).unwrap();
    noted(&set, "the comma in `2,000` is read as the decimal sign");
    let set = read("both", &format!("t [s];speed [V]\n{}", rows(|k| format!("0,{:02};2.0{k:02}", k)))).unwrap();
    noted(&set, "the comma is the decimal sign of this file: the point in `2.000` divides thousands");
    assert_eq!(values(&set, "speed")[3], 2003.0);
    // a point that leads a zero is decimal beside a decimal comma
    let set = read("mixed", &format!("t [s];a [V]\n{}", rows(|k| format!("0,{k:02};{:.3}", 0.5 + slow(k))))).unwrap();
    assert!((values(&set, "a")[59] - 0.5 - slow(59)).abs() < 1e-3);
}
