//! CSV: round trips, units, repairs.

use crate::{Numbers, file, scratch};
use recording::csv::{read_csv, write_csv};
use recording::units::{UNITS, unit_named};
use recording::{Column, Imported, Table};

fn random_table(rows: usize) -> Table {
    let mut numbers = Numbers(7);
    let time = (0..rows).map(|i| i as f64 * 0.01).collect();
    let column =
        |numbers: &mut Numbers| (0..rows).map(|_| numbers.unit() * 10f64.powi(numbers.below(40) as i32 - 20)).collect();
    let columns = vec![
        Column::si("rate", "rad/s", column(&mut numbers)),
        Column::si("force_x", "N", column(&mut numbers)),
        Column::si("a, quoted", "-", column(&mut numbers)),
    ];
    Table::from_columns("memory", time, columns).unwrap()
}

#[test]
fn a_table_written_and_read_is_bit_for_bit_the_same_plain_and_gzipped() {
    let table = random_table(2000);
    for name in ["round.csv", "round.csv.gz"] {
        let path = scratch(name);
        write_csv(&table, &path).unwrap();
        let Imported::Table(read) = recording::read(&path).unwrap() else { panic!("a table") };
        assert_eq!(read.time_s, table.time_s);
        assert_eq!(read.columns, table.columns);
        assert_eq!(read.timing, table.timing);
    }
}

#[test]
fn units_of_files_become_si() {
    let text = "time [ms],rate [deg/s],acceleration_x [g],wheel_rate [rpm],acceleration_y [mm/s^2],t [degC],torque [mN*m]\n\
                0,180,1,60,1000,0,5\n5,-90,0.5,30,1,20,-5\n10,0,0,0,0,0,0\n";
    let table = read_csv(&file("units.csv", text)).unwrap();
    assert_eq!(table.time_s, [0.0, 0.005, 0.01]);
    // Two roundings of a double: 2 eps of the value.
    let expected = [core::f64::consts::PI, 9.806_65, 2.0 * core::f64::consts::PI, 1.0, 273.15, 0.005];
    let si = ["rad/s", "m/s^2", "rad/s", "m/s^2", "K", "N*m"];
    for ((column, expected), si) in table.columns.iter().zip(expected).zip(si) {
        assert!((column.values[0] - expected).abs() <= 2.0 * f64::EPSILON * expected, "{column:?}");
        assert_eq!(column.unit, si);
    }
}

#[test]
fn every_unit_is_found_under_its_symbol_and_converts_to_one_that_stays() {
    for unit in UNITS.iter() {
        assert_eq!(unit_named(unit.symbol), Some(*unit));
        let si = unit_named(unit.si).unwrap();
        assert_eq!((si.si, si.to_si(1.25)), (unit.si, 1.25), "{}", unit.symbol);
    }
    for (spelling, symbol) in [
        ("°/s", "deg/s"),
        ("m/s²", "m/s^2"),
        ("N·m", "N*m"),
        ("Nm", "N*m"),
        ("µs", "us"),
        ("", "-"),
        ("Nms/rad", "N*m*s/rad"),
        ("Nm/A", "N*m/A"),
        ("Ω", "ohm"),
        ("kg/m³", "kg/m^3"),
    ] {
        assert_eq!(unit_named(spelling).unwrap().symbol, symbol);
    }
}

#[test]
fn byte_order_mark_crlf_blank_lines_and_quotes_do_not_matter() {
    let text = "\u{feff}\"time [s]\" , rate [rad/s]\r\n0,1\r\n\r\n0.1, 2\r\n0.2,3\r\n\r\n";
    let table = read_csv(&file("windows.csv", text)).unwrap();
    assert_eq!(table.time_s, [0.0, 0.1, 0.2]);
    assert_eq!(table.columns[0].values, [1.0, 2.0, 3.0]);
}

#[test]
fn a_gap_is_reported_with_its_place_and_not_filled() {
    let times = [0.0, 0.1, 0.2, 0.3, 0.9, 1.0, 1.1];
    let rows: String = times.iter().map(|t| format!("{t},1\n")).collect();
    let table = read_csv(&file("gap.csv", &format!("time [s],rate [rad/s]\n{rows}"))).unwrap();
    assert_eq!(table.time_s, times);
    let [gap] = table.timing.gaps[..] else { panic!("{:?}", table.timing) };
    assert_eq!((gap.after_row, gap.line, gap.start_s), (3, 6, 0.3));
    assert!((gap.length_s - 0.6).abs() < 1e-15);
    assert!(table.notes[0].contains("gap of") && table.notes[0].contains("line 6"), "{:?}", table.notes);
    // The interval does not take part in the gap: rounding of the decimal times only.
    assert!((table.timing.interval_s - 0.1).abs() < 1e-15);
}

#[test]
fn a_row_that_stands_twice_is_dropped_and_counted() {
    let text = "time [s],rate [rad/s]\n0,1\n0.1,2\n0.1,2\n0.1,2\n0.2,3\n";
    let table = read_csv(&file("twice.csv", text)).unwrap();
    assert_eq!(table.time_s, [0.0, 0.1, 0.2]);
    assert_eq!(table.timing.duplicates, 2);
    assert!(table.notes[0].contains("2 row(s) stood twice"));
}

#[test]
fn jitter_is_measured_and_accepted_up_to_a_fifth_of_the_interval() {
    let table_with_jitter = |jitter: f64| {
        let mut numbers = Numbers(3);
        let mut t = 0.0;
        let mut time = Vec::new();
        for _ in 0..2000 {
            time.push(t);
            t += 0.01 * (1.0 + jitter * numbers.unit());
        }
        let column = Column::si("rate", "rad/s", vec![0.0; time.len()]);
        Table::from_columns("memory", time, vec![column])
    };
    let table = table_with_jitter(0.15).unwrap();
    // Uniform in +-0.15: the 95th percentile is 0.1425, +-0.005 its 3 sigma from 2000 rows; the
    // median's own error adds.
    assert!((table.timing.jitter - 0.1425).abs() < 0.02, "{}", table.timing.jitter);
    assert!(table.timing.gaps.is_empty());
    let error = table_with_jitter(0.4).unwrap_err().explain();
    assert!(error.contains("line ") && error.contains("20 % are accepted") && error.contains("resample"), "{error}");
}

#[test]
fn a_last_line_without_line_feed_is_read_and_doubted() {
    let table = read_csv(&file("unended.csv", "time [s],rate [rad/s]\n0,1\n0.1,2\n0.2,3.25")).unwrap();
    assert_eq!(table.columns[0].values[2], 3.25);
    assert!(table.notes[0].contains("may be cut"));
}
