//! Shapes of files whose names, blanks or counters stand where those of other tables do not.

use crate::file;
use recording::{Intake, SeriesSet};

const ROWS: usize = 200;

fn w(k: usize) -> f64 {
    ((0.3 * k as f64).sin() * 1e5).round() / 1e5
}

fn rows(row: impl Fn(usize) -> String) -> String {
    (0..ROWS).map(|k| row(k) + "\n").collect()
}

fn read(name: &str, text: &str) -> SeriesSet {
    let path = file(&format!("other_{name}.csv"), text);
    let set = recording::read_with(&path, &Intake::default()).and_then(recording::series);
    set.unwrap_or_else(|error| panic!("{name}: {}", error.explain()))
}

/// The channel in this unit, one of its numbers in the file being `factor`, at this rate.
fn holds(set: &SeriesSet, channel: &str, unit: &str, factor: f64, rate_hz: f64) {
    let names: Vec<&str> = set.recording.channels.iter().map(|of| of.name.as_str()).collect();
    let of = set.recording.channel_named(channel).unwrap_or_else(|| panic!("{channel}: {names:?} {:?}", set.notes));
    assert_eq!((of.unit.as_str(), of.value.len()), (unit, ROWS), "{channel}: {:?}", set.notes);
    let rate = of.rate_hz().unwrap();
    assert!((rate / rate_hz - 1.0).abs() < 1e-3, "{channel}: {rate} Hz {:?}", set.notes);
    for (k, found) in of.value.iter().enumerate() {
        assert!((found - factor * w(k)).abs() < 1e-12, "{channel}, row {k}: {found}");
    }
}

#[test]
fn cells_that_begin_with_their_name_are_a_table() {
    for (name, between, sign) in [("plotter", ",", ":"), ("pairs", " ", "="), ("tabs", "\t", ":")] {
        let text = rows(|k| format!("t{sign}{:.2}{between}w{sign}{}{between}mode{sign}1", 0.01 * k as f64, w(k)));
        holds(&read(name, &text), "w", "?", 1.0, 100.0);
        // a first line that was cut
        holds(&read("cut", &format!("0.5{between}mode{sign}1\n{text}")), "w", "?", 1.0, 100.0);
    }
    let path = file("other_unlike.csv", "t=0 w=1\nt=1 a=2\nt=2 w=3\nt=3 a=1\n");
    let error = recording::read_with(&path, &Intake::default()).unwrap_err().explain();
    assert!(error.contains("not the same in every line"), "{error}");
}

#[test]
fn blanks_within_a_date_divide_no_columns() {
    let header = "Sat.UTCGregorian           Sat.ElapsedSecs       Sat.X      \n";
    let row = |k: usize| {
        format!("05 Mar 2024 15:{:02}:{:02}.000   {:.6}            {:.8}     ", k / 60, k % 60, k as f64, w(k))
    };
    holds(&read("gmat", &(header.to_owned() + &rows(row))), "Sat.X", "?", 1.0, 1.0);
}

#[test]
fn names_above_each_other_are_those_of_motion_capture() {
    let optitrack = "Format Version,1.23,Take Name,Take 1,Capture Frame Rate,120.0,Rotation Type,Quaternion,Length Units,Millimeters\n\n\
                     ,Type,Rigid Body,Rigid Body,Rigid Body\n,Name,Bus,Bus,Bus\n,ID,\"A\",\"A\",\"A\"\n,,Rotation,Rotation,Position\n\
                     Frame,Time (Seconds),X,W,X\n";
    let text = optitrack.to_owned() + &rows(|k| format!("{k},{:.6},{},0.5,{}", k as f64 / 120.0, w(k), w(k)));
    let set = read("optitrack", &text);
    holds(&set, "Bus.Rotation.X", "-", 1.0, 120.0);
    holds(&set, "Bus.Position.X", "m", 1e-3, 120.0);
    assert_eq!(set.recording.channels.len(), 3);
    let vicon = "Trajectories\n100\n,,Bus:M1,,,Bus:M2,,\nFrame,Sub Frame,X,Y,Z,X,Y,Z\n,,mm,mm,mm,mm,mm,mm\n";
    let text = vicon.to_owned() + &rows(|k| format!("{},0,{},1,2,3,4,5", k + 1, w(k)));
    let set = read("vicon", &text);
    holds(&set, "Bus:M1.X", "m", 1e-3, 100.0);
    assert_eq!(set.recording.channels.len(), 6, "{:?}", set.notes);
}

#[test]
fn a_counter_counts_at_the_rate_that_the_file_states() {
    type Count = fn(usize) -> u64;
    let cases: [(&str, &str, Count); 3] = [
        ("// Update Rate: 100.0Hz\n", "PacketCounter,SampleTimeFine,w", |k| {
            (4_294_900_000 + 100 * k as u64) % (1 << 32)
        }),
        ("# sample_rate_hz: 100\n", "id,Time,w", |k| 37 + k as u64),
        ("Fs = 100 SPS\n", "id,timestamp,w", |k| 4000 * k as u64),
    ];
    for (above, header, count) in cases {
        let text = rows(|k| format!("{},{},{}", (65_500 + k) % 65_536, count(k), w(k)));
        holds(&read("counted", &format!("{above}{header}\n{text}")), "w", "?", 1.0, 100.0);
    }
    for above in ["# sample_rate_hz: 100\n", "Fs=100 SPS\n", "Rate: x\nSampling rate,100 samples/s\n"] {
        holds(&read("rate", &format!("{above}w,a\n{}", rows(|k| format!("{},1", w(k))))), "w", "?", 1.0, 100.0);
    }
}

#[test]
fn rows_that_are_missing_under_a_counter_are_gaps() {
    let lost = |k: usize| if k < 100 { k } else { k + 30 };
    let text = rows(|k| format!("{},{}", (65_500 + lost(k)) % 65_536, w(k)));
    let set = read("lost", &format!("// Update Rate: 100.0 Hz\nPacketCounter,w\n{text}"));
    let times = &set.recording.channels[0].time_s;
    assert_eq!(times.len(), ROWS);
    assert!((times[100] - times[99] - 0.31).abs() < 1e-6, "{} {:?}", times[100] - times[99], set.notes);
}

#[test]
fn units_of_a_preamble_are_of_the_columns_that_are_no_clocks() {
    let lvm = "LabVIEW Measurement\t\nX_Columns\tMulti\n***End_of_Header***\t\nChannels\t2\t\nSamples\t200\t200\n\
               Y_Unit_Label\tdeg/s\tmN\nX_Dimension\tTime\tTime\n***End_of_Header***\t\t\nX_Value\tw\tX_Value\tf\tComment\n";
    let set = read("lvm", &(lvm.to_owned() + &rows(|k| format!("{0:.2}\t{1}\t{0:.2}\t{1}", 0.01 * k as f64, w(k)))));
    holds(&set, "w", "rad/s", core::f64::consts::PI / 180.0, 100.0);
    holds(&set, "f", "N", 1e-3, 100.0);
}
