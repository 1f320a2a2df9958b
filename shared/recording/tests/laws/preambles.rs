//! Lines above the names: units of columns, the time between two rows.

use crate::file;
use recording::{Intake, SeriesSet};

const ROWS: usize = 60;

fn rows(separator: &str, columns: usize) -> String {
    let cells = |k: usize| (0..columns).map(|c| format!("{:.3}", 0.5 + (k * (c + 1)) as f64 / 8.0)).collect::<Vec<_>>();
    (0..ROWS).map(|k| cells(k).join(separator) + "\n").collect()
}

fn timed(separator: &str, columns: usize) -> String {
    rows(separator, columns)
        .lines()
        .enumerate()
        .map(|(k, row)| format!("{:.2}{separator}{row}\n", 0.01 * k as f64))
        .collect()
}

fn read(name: &str, text: &str) -> Result<SeriesSet, String> {
    let path = file(&format!("preamble_{}.txt", name.replace(' ', "_")), text);
    recording::read_with(&path, &Intake::default()).and_then(recording::series).map_err(|error| error.explain())
}

fn units(set: &SeriesSet) -> Vec<(&str, &str)> {
    set.recording.channels.iter().map(|channel| (channel.name.as_str(), channel.unit.as_str())).collect()
}

#[test]
fn a_line_of_units_of_a_preamble_is_laid_over_the_columns_that_it_matches_one_to_one() {
    let lvm = "LabVIEW Measurement\t\nSeparator\tTab\n***End_of_Header***\t\nChannels\t2\t\nY_Unit_Label\tdeg/s\tN*m\t\n\
               X_Dimension\tTime\tTime\t\n***End_of_Header***\t\t\t\nX_Value\tw\ttau\tComment\n";
    let scope =
        "Model,X1\nProbe Attenuation,1,1\nVertical Units,V,A\nVertical Offset,0,0\nVertical Scale,1,1\n,,\nLabel,,\n";
    let files = [
        ("labview", format!("{lvm}{}", timed("\t", 2)), [("w", "rad/s"), ("tau", "N*m")]),
        ("scope", format!("{scope}TIME,CH1,CH2\n{}", timed(",", 2)), [("CH1", "V"), ("CH2", "A")]),
        (
            "scope with a clock of its own",
            format!("{scope}TIME [s],CH1,CH2\n{}", timed(",", 2)),
            [("CH1", "V"), ("CH2", "A")],
        ),
        (
            "by name",
            format!("Vertical Units,CH2:A,CH1:V\nSource,CH1,CH2\nTIME,CH1,CH2\n{}", timed(",", 2)),
            [("CH1", "V"), ("CH2", "A")],
        ),
        (
            "of channels",
            format!("Horizontal Units,s\nVertical Units,CH1:V,CH2:A\nSecond,a,b\n{}", timed(",", 2)),
            [("a", "V"), ("b", "A")],
        ),
    ];
    for (name, text, expected) in files {
        let set = read(name, &text).unwrap_or_else(|error| panic!("{name}: {error}"));
        assert_eq!(units(&set), expected, "{name}: {:?}", set.notes);
    }
}

#[test]
fn units_of_a_preamble_that_match_no_columns_are_noted_and_not_used() {
    let files = [
        ("of quantities", "Length Unit,m\nAngle Unit,deg\nTime [s],a\n", 1),
        ("too few", "Y Units,V,A\nTime [s],a,b,c\n", 3),
        ("too many", "Y Units,V,A,m,N\nTime [s],a,b\n", 2),
        ("two lines", "Y Units,V,A\nVertical Units,m,N\nTime [s],a,b\n", 2),
    ];
    for (name, header, columns) in files {
        let set =
            read(name, &format!("{header}{}", timed(",", columns))).unwrap_or_else(|error| panic!("{name}: {error}"));
        let stated = units(&set);
        assert!(name == "two lines" || stated.iter().all(|(_, unit)| *unit == "?"), "{name}: {stated:?}");
        assert!(set.notes.iter().any(|note| note.contains("are of no certain columns")), "{name}: {:?}", set.notes);
    }
}

#[test]
fn numbers_are_no_units() {
    let set =
        read("numbers", &format!("Vertical Offset,a,b\nVertical Scale,1,1\nTIME,CH1,CH2\n{}", timed(",", 2))).unwrap();
    assert_eq!(units(&set), [("CH1", "?"), ("CH2", "?")]);
}

#[test]
fn rows_without_times_follow_each_other_in_the_interval_that_the_preamble_states() {
    let one = |row: &str| rows(",", 1).lines().map(|line| format!("{line}{row}\n")).collect::<String>();
    let counted: String = rows(",", 2).lines().enumerate().map(|(k, row)| format!("{k},{row},\n")).collect();
    let files = [
        ("rate in a remark", format!("# Sample rate: 100 Hz\na [V],b [V]\n{}", rows(",", 2))),
        ("rate with its unit in the key", format!("Device,X\nSample Rate (Hz),100\n\na [V],b [V]\n{}", rows(",", 2))),
        ("rate in kilohertz", format!("fs = 0.1 kHz\na [V],b [V]\n{}", rows(",", 2))),
        ("increment", format!("Type:,raw\nXInc:,1.0E-02\nXOrg:,-5.0\nData:,\n{}", one(""))),
        ("period", format!("Format,1.0B,\nSource,CH1,\nSampling Period,1.000000E-02,\nWaveform Data,\n{}", one(","))),
        ("beside the names", format!("X,CH1,CH2,Start,Increment,\nSequence,Volt,Volt,-5.0e+00,1.0e-02,\n{counted}")),
        (
            "within the names",
            format!("CH1V,CH2V,t0 = -5.0e+00, tInc = 1.0e-02,\n{}", rows(",", 2).replace('\n', ",,\n")),
        ),
        (
            "labview without times",
            format!(
                "X_Columns\tNo\n***End_of_Header***\t\nDelta_X\t0,01\t0,01\t\n***End_of_Header***\t\t\t\nX_Value\ta\tb\tComment\n{}",
                rows("\t", 2).lines().map(|row| format!("\t{}\n", row.replace('.', ","))).collect::<String>()
            ),
        ),
    ];
    for (name, text) in files {
        let set = read(name, &text).unwrap_or_else(|error| panic!("{name}: {error}"));
        for channel in &set.recording.channels {
            assert_eq!(channel.value.len(), ROWS, "{name}");
            assert!((channel.rate_hz().unwrap() - 100.0).abs() < 1e-6, "{name}: {:?}", channel.rate_hz());
        }
        let last = set.recording.channels.last().unwrap().value[1];
        assert!((last - 0.625).abs() < 1e-9 || (last - 0.75).abs() < 1e-9, "{name}: {last}");
        assert!(
            set.notes.iter().any(|note| note.contains("follow each other every 0.01 s (line ")),
            "{name}: {:?}",
            set.notes
        );
    }
    let two = format!("Sample rate: 100 Hz\nUpdate rate: 50 Hz\na [V],b [V]\n{}", rows(",", 2));
    assert!(read("two rates", &two).unwrap_err().contains("no column is known to hold the times"));
}

#[test]
fn a_preamble_beside_the_rows_and_a_name_of_the_index_below_the_names_shift_no_column() {
    let keys =
        ["Record Length,60", "Sample Interval,0.01", "Source,CH1", "Vertical Units,V", "Horizontal Units,s", ","];
    let row = |k: usize| format!("{},,{:.3},  {:.3},\n", keys.get(k).unwrap_or(&","), 0.01 * k as f64, k as f64 / 8.0);
    let set = read("beside", &(0..ROWS).map(row).collect::<String>()).unwrap();
    assert_eq!(units(&set), [("CH1", "V")], "{:?}", set.notes);
    assert_eq!((set.recording.channels[0].value.len(), set.recording.channels[0].value[3]), (ROWS, 0.375));
    let index = format!(",imu,motor\n,gyro_z,torque\nunit,deg/s,Nm\nt [s],,\n{}", timed(",", 2));
    let set = read("index", &index).unwrap();
    assert_eq!(units(&set), [("gyro_z", "rad/s"), ("torque", "N*m")], "{:?}", set.notes);
    let levels = "device,imu,imu,motor\naxis,x,y,x\nunit,deg/s,deg/s,Nm\nt [s],,,\n";
    let set = read("levels", &format!("{levels}{}", timed(",", 3))).unwrap();
    let joined = [("imu.x", "rad/s"), ("imu.y", "rad/s"), ("motor.x", "N*m")];
    assert_eq!(units(&set), joined, "{:?}", set.notes);
    let groups = format!("t [s],imu,imu,motor\n,x,y,x\n{}", timed(",", 3));
    let set = read("groups", &groups).unwrap();
    assert_eq!(units(&set), [("imu.x", "?"), ("imu.y", "?"), ("motor.x", "?")], "{:?}", set.notes);
    let text = format!("Type:,raw\nXInc:,1.0E-02\nTime:,14:59:58:00\nData:,\n{}", rows(",", 1));
    let set = read("time of day above", &text).unwrap();
    assert_eq!(set.recording.channels[0].value.len(), ROWS);
}
