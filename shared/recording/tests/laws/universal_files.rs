//! Universal files: what other tools write is read with its units, and what is wrong is named with
//! its line.

use crate::{Numbers, scratch};
use recording::{Imported, Spectrum, Table, read, read_group};
use std::fmt::Write;

/// A dataset as the fields of its header say it.
pub(crate) struct Dataset {
    pub kind: u32,
    pub nodes: [(i32, i32); 2],
    /// 2, 4, 5 or 6: real and complex, single and double.
    pub layout: u32,
    pub values: usize,
    /// First abscissa and step, where the spacing is even.
    pub even: Option<(f64, f64)>,
    pub abscissa: u32,
    pub ordinate: (u32, &'static str),
    pub denominator: (u32, &'static str),
}

pub(crate) const TIME: Dataset = Dataset {
    kind: 1,
    nodes: [(12, 3), (0, 0)],
    layout: 4,
    values: 5,
    even: Some((0.5, 0.01)),
    abscissa: 17,
    ordinate: (12, "m/s**2"),
    denominator: (0, "NONE"),
};
pub(crate) const RESPONSE: Dataset = Dataset {
    kind: 4,
    nodes: [(1, 3), (2, -1)],
    layout: 6,
    values: 5,
    even: Some((0.0, 2.5)),
    abscissa: 18,
    ordinate: (12, "m/s**2"),
    denominator: (13, "N"),
};

impl Dataset {
    fn header(&self) -> String {
        let mut text = String::from("a beam\nNONE\n22-Nov-26 10:00:00\nNONE\nNONE\n");
        let [(n, d), (m, e)] = self.nodes;
        let _ =
            writeln!(text, "{:5}{:10}{:5}{:10} {:10}{n:10}{d:4} {:10}{m:10}{e:4}", self.kind, 0, 0, 0, "NONE", "NONE");
        let (first, step) = self.even.unwrap_or_default();
        let spacing = u32::from(self.even.is_some());
        let _ =
            writeln!(text, "{:10}{:10}{spacing:10}{}{}{}", self.layout, self.values, e13(first), e13(step), e13(0.0));
        for (kind, unit) in [(self.abscissa, "s"), self.ordinate, self.denominator, (0, "NONE")] {
            let _ = writeln!(text, "{kind:10}{:5}{:5}{:5} {:20} {unit:20}", 0, 0, 0, "NONE");
        }
        text
    }

    /// Numbers in fixed columns.
    pub fn ascii(&self, values: &[f64]) -> String {
        let parts = values.len() / self.values;
        let mut text = format!("    -1\n    58\n{}", self.header());
        let per_line = match (self.layout, self.even.is_some()) {
            (4 | 6, true) => 4,
            (4 | 6, false) => parts,
            _ => 6,
        };
        for line in values.chunks(per_line) {
            for (k, value) in line.iter().enumerate() {
                let double = matches!(self.layout, 4 | 6) && (self.even.is_some() || k % parts > 0);
                text += &if double { e20(*value) } else { e13(*value) };
            }
            text.push('\n');
        }
        text + "    -1\n"
    }

    pub fn binary(&self, little_endian: bool, bytes: &[u8]) -> Vec<u8> {
        let order = if little_endian { 1 } else { 2 };
        let head =
            format!("    -1\n    58b{order:6}{:6}{:12}{:12}{:6}{:6}{:12}{:12}\n", 2, 11, bytes.len(), 0, 0, 0, 0);
        [head.as_bytes(), self.header().as_bytes(), bytes, b"    -1\n"].concat()
    }
}

/// Fortran's E13.5 and E20.12: a fraction below one is not asked for, two digits of exponent are.
fn e13(value: f64) -> String {
    fortran(value, 5, 13)
}

fn e20(value: f64) -> String {
    fortran(value, 12, 20)
}

fn fortran(value: f64, digits: usize, width: usize) -> String {
    let text = format!("{value:.digits$E}");
    let (mantissa, exponent) = text.split_once('E').unwrap();
    let exponent: i32 = exponent.parse().unwrap();
    format!("{:>width$}", format!("{mantissa}E{exponent:+03}"))
}

pub(crate) fn random(count: usize) -> Vec<f64> {
    let mut numbers = Numbers(7);
    (0..count).map(|_| numbers.unit() * 10f64.powi(numbers.below(9) as i32 - 4)).collect()
}

pub(crate) fn table(name: &str, bytes: &[u8]) -> Table {
    match imported(name, bytes) {
        Imported::Table(table) => table,
        other => panic!("{name}: {other:?}"),
    }
}

pub(crate) fn spectrum(name: &str, bytes: &[u8]) -> Spectrum {
    match imported(name, bytes) {
        Imported::Spectrum(spectrum) => spectrum,
        other => panic!("{name}: {other:?}"),
    }
}

pub(crate) fn imported(name: &str, bytes: &[u8]) -> Imported {
    let path = scratch(name);
    std::fs::write(&path, bytes).unwrap();
    read(&path).unwrap()
}

pub(crate) fn refusal(name: &str, bytes: &[u8]) -> String {
    let path = scratch(name);
    std::fs::write(&path, bytes).unwrap();
    read(&path).unwrap_err().explain()
}

fn close(found: &[f64], expected: &[f64], relative: f64) {
    assert_eq!(found.len(), expected.len());
    for (a, b) in found.iter().zip(expected) {
        assert!((a - b).abs() <= relative * b.abs(), "{a} {b}");
    }
}

#[test]
fn time_histories_in_text_come_with_names_times_and_si_units() {
    let values = random(5);
    let force = Dataset { nodes: [(3, -2), (0, 0)], layout: 2, ordinate: (13, "kN"), ..TIME };
    let text = TIME.ascii(&values) + &force.ascii(&values);
    let table = table("time.uff", text.as_bytes());
    assert_eq!(table.columns[0].header(), "acceleration_12z [m/s^2]");
    assert_eq!(
        (table.columns[0].unit, table.columns[1].name.as_str(), table.columns[1].unit),
        ("m/s^2", "force_3-y", "N")
    );
    close(&table.time_s, &[0.5, 0.51, 0.52, 0.53, 0.54], 1e-15);
    close(&table.columns[0].values, &values, 1e-12); // thirteen digits in the file
    close(&table.columns[1].values, &values.iter().map(|f| 1e3 * f).collect::<Vec<_>>(), 1e-5); // six
}

#[test]
fn the_same_numbers_come_from_every_layout_in_text_and_in_bytes_of_either_order() {
    let (re, im) = (random(5), random(10).split_off(5));
    let x = [0.0, 2.5, 5.0, 7.5, 10.0];
    for (layout, complex, double) in [(2, false, false), (4, false, true), (5, true, false), (6, true, true)] {
        for even in [true, false] {
            let dataset = Dataset { layout, even: RESPONSE.even.filter(|_| even), ..RESPONSE };
            let value = |k: usize| {
                let mut parts = if even { vec![] } else { vec![x[k]] };
                parts.push(re[k]);
                parts.extend(complex.then_some(im[k]));
                parts
            };
            let values: Vec<f64> = (0..5).flat_map(value).collect();
            let bytes = |little: bool, short_abscissa: bool| -> Vec<u8> {
                let parts = values.len() / 5;
                let one = |(k, value): (usize, &f64)| {
                    let single = !double || (short_abscissa && !even && k % parts == 0);
                    let (four, eight) = ((*value as f32).to_be_bytes().to_vec(), value.to_be_bytes().to_vec());
                    let mut bytes = if single { four } else { eight };
                    if little {
                        bytes.reverse();
                    }
                    bytes
                };
                values.iter().enumerate().flat_map(one).collect()
            };
            let name = format!("layout_{layout}_{even}.unv");
            let digits = if double { 1e-12 } else { 1e-5 };
            let mut files = vec![(dataset.ascii(&values).into_bytes(), digits)];
            for little in [true, false] {
                let exact = if double { 0.0 } else { 1e-7 };
                files.push((dataset.binary(little, &bytes(little, false)), exact));
                files.push((dataset.binary(little, &bytes(little, true)), exact));
                // A common writer announces half of what complex values take.
                let plain = dataset.binary(little, &bytes(little, false));
                let [whole, half] = [1, 2].map(|part| format!("{:12}{:12}", 11, bytes(little, false).len() / part));
                let at = plain.windows(24).position(|window| window == whole.as_bytes()).unwrap();
                files.push(([&plain[..at], half.as_bytes(), &plain[at + 24..]].concat(), exact));
            }
            for (file, relative) in files {
                let spectrum = spectrum(&name, &file);
                close(&spectrum.frequency_hz, &x, 1e-7);
                let stem = "accelerance_1z_2-x";
                let names: Vec<&str> = spectrum.columns.iter().map(|column| column.name.as_str()).collect();
                let expected = [format!("{stem}_real"), format!("{stem}_imag")];
                if complex {
                    assert_eq!(names, expected);
                    close(&spectrum.columns[1].values, &im, relative);
                } else {
                    assert_eq!(names, [stem]);
                }
                assert_eq!(spectrum.columns[0].unit, "m/s^2/N");
                close(&spectrum.columns[0].values, &re, relative);
            }
        }
    }
}

#[test]
fn what_is_no_function_is_left_out_and_said_and_units_of_the_file_are_si() {
    let nodes = "    -1\n    15\n         1         0         0        11  0.0  0.0  0.0\n    -1\n";
    // Millimetres: 1000 of them are the SI unit.
    let units = "    -1\n   164\n         5mm (milli-newton)            2\n  1.0000000000000000D+03   1.00000000000000000D+03  1.0D+00\n  2.7315D+02\n    -1\n";
    let unlabelled = Dataset { ordinate: (12, "NONE"), ..TIME };
    let odd = Dataset { nodes: [(4, 1), (0, 0)], ordinate: (0, "EU"), ..TIME };
    let values = random(5);
    let text = format!("{nodes}{units}\n{}{}", unlabelled.ascii(&values), odd.ascii(&values));
    let table = table("units.uff", text.as_bytes());
    close(&table.columns[0].values, &values.iter().map(|y| 1e-3 * y).collect::<Vec<_>>(), 1e-12);
    assert_eq!((table.columns[0].unit, table.columns[1].unit), ("m/s^2", "-"));
    assert!(table.notes.iter().any(|note| note.contains("15 (1)")), "{:?}", table.notes);
    assert!(table.notes.iter().any(|note| note.contains("response_4x [EU]")), "{:?}", table.notes);
}

#[test]
fn numbers_as_fortran_and_as_people_write_them_are_read() {
    // Three digits of exponent without the letter, D for E, and columns filled to the brim.
    let text = TIME.ascii(&[1.0, -2.0, 3.0, 4.0, 5.0]);
    let line = text.lines().find(|line| line.contains("1.000000000000E+00")).unwrap();
    let brim = "  1.000000000000D+00-2.0000000000000-100   3.000000000000E+0   4.00000000000e+00";
    let fortran = text.replace(line, brim);
    close(&table("fortran.uff", fortran.as_bytes()).columns[0].values, &[1.0, -2e-100, 3.0, 4.0, 5.0], 0.0);
    let people = text.replace(line, "1 -2.5 1234567890123456.789012345678 4e0");
    close(
        &table("people.uff", people.as_bytes()).columns[0].values,
        &[1.0, -2.5, 1_234_567_890_123_456.8, 4.0, 5.0],
        0.0,
    );
}

#[test]
fn what_is_wrong_is_named_with_its_line_and_a_cure() {
    let good = TIME.ascii(&random(5));
    let first = good.lines().nth(13).unwrap().to_string();
    let cases = [
        (good.replace(&first, "  1.0E+00  nonsense"), "line 14: `1.0E+00  nonsense` is no line of numbers"),
        (good.replace(&first, "  1.0E+00  NaN  1.0 1.0"), "line 14: NaN is not finite"),
        (good.replace("\n    -1\n", "\n"), "line 15: the file ends after line 15"),
        (good.replace("         5         1", "        50         1"), "line 16: 5 numbers of 50 are there"),
        (good.replace("         5         1", "         3         1"), "line 14: 4 numbers, 3 are announced"),
        (good.replace("         4         5", "         9         5"), "line 9: `         9         5"),
        (
            good.replace("        17    0", "        19    0"),
            "line 13: the abscissa is neither time (17) nor frequency (18)",
        ),
        (good.clone() + &RESPONSE.ascii(&random(10)), "line 18: the file holds several datasets: 'time', 'responses'"),
        ("    -1\n    15\n    -1\n".into(), "line 1: no dataset 58"),
        (good.clone() + "    58\n", "line 17: `58` stands where `-1` opens a dataset"),
    ];
    for (text, said) in cases {
        let error = refusal("bad.uff", text.as_bytes());
        assert!(error.contains("bad.uff: ") && error.contains(said) && error.contains("cure: "), "{said}: {error}");
    }
    let others = Dataset { even: Some((0.0, 2.0)), ..RESPONSE };
    let text = RESPONSE.ascii(&random(10)) + &others.ascii(&random(10));
    assert!(refusal("lines.uff", text.as_bytes()).contains("'responses 1', 'responses 2'"));
    let short = RESPONSE.binary(true, &[0; 79]);
    assert!(refusal("short.uff", &short).contains("79 bytes of numbers, 80 would hold the 5 values"));
    let whole = RESPONSE.binary(true, &[0; 80]);
    let cut = &whole[..whole.len() - 20];
    assert!(refusal("cut.uff", cut).contains("80 bytes of numbers are announced"));
    let vax = String::from_utf8(RESPONSE.binary(true, &[0; 80])).unwrap().replacen(
        "    58b     1     2",
        "    58b     1     1",
        1,
    );
    assert!(refusal("vax.uff", vax.as_bytes()).contains("floating point format 1"));
}

#[test]
fn functions_with_times_of_their_own_are_channels_where_all_are_chosen() {
    let slow = Dataset { nodes: [(1, 1), (0, 0)], even: Some((0.0, 0.1)), ..TIME };
    let text = TIME.ascii(&random(5)) + &slow.ascii(&random(5));
    assert!(refusal("two.uff", text.as_bytes()).contains("'time 1', 'time 2', 'time'"));
    let Imported::Series(set) = read_group(&scratch("two.uff"), "time").unwrap() else { panic!("channels") };
    assert_eq!(
        set.recording.channels.iter().map(|c| c.name.as_str()).collect::<Vec<_>>(),
        ["acceleration_12z", "acceleration_1x"]
    );
    assert_eq!(set.recording.channels[1].time_s[1], 0.1);
}
