//! Cells and lines that are no plain numbers: each is a missing sample, a number, or no row.

use crate::file;
use recording::{Intake, SeriesSet};

const ROWS: usize = 60;

fn rows(row: impl Fn(usize, String, String) -> String) -> String {
    (0..ROWS).map(|k| row(k, format!("{:.2}", 0.01 * k as f64), format!("{:.3}", slow(k))) + "\n").collect()
}

fn slow(k: usize) -> f64 {
    (k as f64 - 20.5) / 4.0
}

fn read(name: &str, text: &str) -> Result<SeriesSet, String> {
    let path = file(&format!("cells_{}.csv", name.replace(' ', "_")), text);
    recording::read_with(&path, &Intake::default()).and_then(recording::series).map_err(|error| error.explain())
}

fn counts(set: &SeriesSet) -> Vec<usize> {
    set.recording.channels.iter().map(|channel| channel.value.len()).collect()
}

fn noted(set: &SeriesSet, part: &str) {
    assert!(set.notes.iter().any(|note| note.contains(part)), "`{part}` is missing in {:?}", set.notes);
}

const HEADER: &str = "t [s],a [V],b [V]\n";

#[test]
fn a_cell_that_is_no_number_is_a_missing_sample() {
    for (k, cell) in
        ["1.#IND", "?", "*****", "Overflow", "undefined", "∞", "ERR", "<0.001", "OL", "12 apples"].iter().enumerate()
    {
        let text = rows(|k, t, a| format!("{t},{},{a}", if k % 20 == 7 { (*cell).to_owned() } else { a.clone() }));
        let set =
            read(&format!("missing {k}"), &format!("{HEADER}{text}")).unwrap_or_else(|error| panic!("{cell}: {error}"));
        assert_eq!(counts(&set), [57, 60], "{cell}");
        noted(&set, "3 cell(s) of `a`");
    }
    noted(
        &read("quoted", &format!("{HEADER}{}", rows(|k, t, a| format!("{t},{},{a}", if k == 9 { "ERR" } else { &a }))))
            .unwrap(),
        "line 11: `ERR`",
    );
}

#[test]
fn cells_without_a_number_in_the_first_rows_cost_no_row() {
    let text = rows(|k, t, a| format!("{t},{},{a}", if k < 5 { "Initializing" } else { &a }));
    let set = read("first rows", &format!("{HEADER}{text}")).unwrap();
    assert_eq!(counts(&set), [55, 60]);
    noted(&set, "5 cell(s) of `a` are no numbers: no sample (line 2: `Initializing`)");
}

#[test]
fn a_column_of_texts_is_left_out_and_the_file_is_read() {
    let text: String =
        (0..1000).map(|k| format!("{:.2},{},{k}\n", 0.01 * f64::from(k), if k < 450 { "1" } else { "off" })).collect();
    let set = read("late texts", &format!("{HEADER}{text}")).unwrap();
    assert_eq!(counts(&set), [1000]);
    noted(&set, "left out: `a` (most of its cells are no numbers)");
    let text: String =
        (0..1000).map(|k| format!("{:.2},{}\n", 0.01 * f64::from(k), if k < 450 { "1" } else { "off" })).collect();
    let error = read("nothing but texts", &format!("t [s],a [V]\n{text}")).unwrap_err();
    assert!(error.contains("line 452, column 2 `a [V]`") && error.contains("`off`"), "{error}");
}

#[test]
fn a_number_that_two_signs_make_is_never_taken_for_a_missing_sample() {
    let text: String =
        (0..1000).map(|k| format!("{:.2};{}\n", 0.01 * f64::from(k), if k == 900 { "1,271" } else { "7" })).collect();
    let set = read("late thousands", &format!("t [s];a [V]\n{text}"));
    assert!(
        set.as_ref().is_err_and(|error| error.contains("line 902"))
            || set.unwrap().recording.channels[0].value[900] == 1271.0
    );
    let text = rows(|k, t, a| format!("{t},{} {},{a}", a, if k == 40 { "A" } else { "V" }));
    assert!(read("another unit", &format!("t [s],a,b [V]\n{text}")).unwrap_err().contains("line 42"));
}

#[test]
fn numbers_of_other_hands_are_numbers() {
    type Form = fn(f64) -> String;
    let forms: [(&str, Form); 5] = [
        ("minus of typesetting", |a| format!("{a:.3}").replace('-', "\u{2212}")),
        ("bookkeeping", |a| if a < 0.0 { format!("({:.3})", -a) } else { format!("{a:.3}") }),
        ("fortran", |a| format!("{:.5}+001", a / 10.0)),
        ("mark", |a| format!("{a:.3}{}", if a == 0.125 { "*" } else { "" })),
        ("remark", |a| format!("{a:.3}{}", if a == 0.125 { " # event" } else { "" })),
    ];
    for (name, form) in forms {
        let text = rows(|k, t, a| format!("{t},{a},{}", form(slow(k))));
        let set = read(name, &format!("{HEADER}{text}")).unwrap_or_else(|error| panic!("{name}: {error}"));
        let found = &set.recording.channel_named("b").unwrap().value;
        assert_eq!(found.len(), ROWS, "{name}");
        assert!(found.iter().enumerate().all(|(k, value)| (value - slow(k)).abs() < 1e-9), "{name}: {found:?}");
    }
}

#[test]
fn lines_without_a_time_are_left_out_and_noted() {
    let lines = ["*** MARK 1 ***", ",0.01,0.02", "Average,0.01,0.02", "-- pause --"];
    for (at, line) in lines.iter().enumerate() {
        let text = rows(|k, t, a| format!("{t},{a},{a}{}", if k == 30 { format!("\n{line}") } else { String::new() }));
        let set = read(&format!("without time {at}"), &format!("{HEADER}{text}"))
            .unwrap_or_else(|error| panic!("{line}: {error}"));
        assert_eq!(counts(&set), [60, 60], "{line}");
        noted(&set, &format!("1 line(s) without a time are left out, the first is line 33: `{line}`"));
    }
    let names = rows(|k, t, a| format!("{t},{a},{a}{}", if k == 30 { "\nt [s],b [V],a [V]" } else { "" }));
    assert!(read("other names", &format!("{HEADER}{names}")).unwrap_err().contains("line 33"));
    let half = rows(|_, t, a| format!("{t},{a},{a}\nGPS {a}"));
    assert!(read("half", &format!("{HEADER}{half}")).is_err());
}

#[test]
fn a_header_may_have_breaks_of_lines_in_quotes() {
    let text = rows(|_, t, a| format!("{t},{a},{a}"));
    let set = read("breaks", &format!("\"t\n[s]\",\"a\n[V]\",\"b\n[V]\"\n{text}")).unwrap();
    assert_eq!(counts(&set), [60, 60]);
    assert_eq!(set.recording.channels[0].name, "a");
    // an inch is no quote
    let set = read("inches", &format!("t [s],a 3\",b [V]\n{text}")).unwrap();
    assert_eq!(counts(&set), [60, 60]);
}
