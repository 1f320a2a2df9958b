//! Loggers whose files were refused, or read with other names, when they were first tried. What
//! each means was written down before.

use crate::file;
use recording::{Intake, SeriesSet};

const ROWS: usize = 60;
/// 2024-03-05 [s since 1970].
const DAY_S: i64 = 1_709_596_800;

fn a(k: usize) -> f64 {
    (1e4 * ((0.3 * k as f64).sin() + 0.5)).round() / 1e4
}

fn rows(row: impl Fn(usize) -> String) -> String {
    (0..ROWS).map(|k| row(k) + "\n").collect()
}

fn read(name: &str, text: &str) -> Result<SeriesSet, String> {
    let path = file(&format!("further_{name}.csv"), text);
    recording::read_with(&path, &Intake::default()).and_then(recording::series).map_err(|error| error.explain())
}

/// 60 samples of `channel` at 100 Hz, which are `a` times `factor`.
fn holds(name: &str, text: &str, (channel, unit, factor): (&str, &str, f64)) -> SeriesSet {
    let set = read(name, text).unwrap_or_else(|error| panic!("{name}: {error}"));
    let found = set.recording.channel_named(channel);
    let found = found.unwrap_or_else(|| panic!("{name}: no {channel}: {:?} {:?}", set.recording.channels, set.notes));
    assert_eq!((found.unit.as_str(), found.value.len()), (unit, ROWS), "{name}: {:?}", set.notes);
    assert!((found.value[7] - factor * a(7)).abs() < 1e-9, "{name}: {}", found.value[7]);
    assert!((found.interval_s().unwrap() / 0.01 - 1.0).abs() < 1e-6, "{name}: {:?}", found.interval_s());
    set
}

#[test]
fn a_stamp_that_a_terminal_writes_before_a_line_is_its_time() {
    let stamp = |k: usize| format!("2024-03-05 14:59:{:06.3}", 50.0 + 0.01 * k as f64);
    holds("brackets", &rows(|k| format!("[{}] torque={}, spare=1", stamp(k), a(k))), ("torque", "?", 1.0));
    holds("plotter", &rows(|k| format!("{} -> torque:{},spare:1", &stamp(k)[11..], a(k))), ("torque", "?", 1.0));
    let named = format!("time,torque [Nm]\n{}", rows(|k| format!("[{}],{}", stamp(k), a(k))));
    holds("in a column", &named, ("torque", "N*m", 1.0));
}

#[test]
fn a_remark_between_the_rows_is_no_row() {
    for mark in ["#", "%", "//"] {
        let row = |k: usize| {
            let remark = if k % 20 == 7 { format!("{mark} event {k}\n") } else { String::new() };
            format!("{remark}{:.2},{}", 0.01 * k as f64, a(k))
        };
        holds("remarks", &format!("time [s],torque [Nm]\n{}", rows(row)), ("torque", "N*m", 1.0));
    }
}

#[test]
fn a_sampling_rate_is_read_under_every_name() {
    for key in [
        "Cadence: 100 Hz",
        "Frequency of acquisition: 100 Hz",
        "Fréquence d'acquisition : 100 Hz",
        "Fréquence d’échantillonnage = 100 Hz",
        "Frecuencia de muestreo: 100 Hz",
        "Frequenza di campionamento: 100 Hz",
        "采样频率: 100 Hz",
        "Waveform increment\t0.01",
        "OutputRate: 100 Hz",
    ] {
        let text = format!("{key}\ntorque [Nm]\tspare [V]\n{}", rows(|k| format!("{}\t1.5", a(k))));
        holds("rates", &text, ("torque", "N*m", 1.0));
    }
    // steps a minute
    let text = format!("Cadence: 100\ntorque [Nm]\tspare [V]\n{}", rows(|k| format!("{}\t1.5", a(k))));
    assert!(read("cadence", &text).unwrap_err().contains("--time-column"));
}

#[test]
fn the_date_above_rows_with_the_time_of_day_is_the_day_that_they_count_from() {
    let row = |k: usize| format!("14:59:{:06.3},{}", 50.0 + 0.01 * k as f64, a(k));
    let set = holds("dated", &format!("Date: 2024-03-05\ntime,torque [Nm]\n{}", rows(row)), ("torque", "N*m", 1.0));
    assert_eq!(set.origin_s, DAY_S, "{:?}", set.notes);
    let midnight = |k: usize| {
        let s = 86_399.7 + 0.01 * k as f64;
        let (day, s) = if s < 86_399.995 { (23, s - 82_800.0) } else { (0, s - 86_400.0) };
        format!("{day:02}:{:02}:{:06.3},{}", (s / 60.0) as u32, s % 60.0, a(k))
    };
    let text = format!("Date,05-Mar-2024\ntime,torque [Nm]\n{}", rows(midnight));
    let set = holds("midnight", &text, ("torque", "N*m", 1.0));
    assert_eq!(set.origin_s, DAY_S, "{:?}", set.notes);
    // day and month may be either
    let text = format!("Date: 03/05/2024\ntime,torque [Nm]\n{}", rows(row));
    assert_eq!(holds("either", &text, ("torque", "N*m", 1.0)).origin_s, 0);
}

#[test]
fn a_clock_of_numbers_that_contradicts_the_dates_beside_it_is_refused() {
    let stamp = |k: usize| format!("2024-03-05 14:59:{:02}", k % 60);
    let of = |unit_s: f64| {
        format!("date,Time_ms,torque [Nm]\n{}", rows(|k| format!("{},{:.3},{}", stamp(k), k as f64 / unit_s, a(k))))
    };
    let refused = read("contradicts", &of(0.0864)).unwrap_err();
    for words in
        ["last 0.6829 s by `Time_ms` and 59.0000 s by `date`", "--time-column 'date'", "--time-column 'Time_ms:UNIT'"]
    {
        assert!(refused.contains(words), "{refused}");
    }
    // dates of whole seconds, and a clock that is right
    assert!(read("agrees", &of(1e-3)).is_ok());
}

#[test]
fn names_and_units_are_read_behind_labels_of_every_kind() {
    let timed = |k: usize| format!("{:.2},{},1", 0.01 * k as f64, a(k));
    let each = "time,torque,spare\n,Type: double,Type: double\n,Unit: N*m,Unit: V\n,Interp: linear,Interp: linear\n";
    holds("each", &format!("{each}{}", rows(timed)), ("torque", "N*m", 1.0));
    holds(
        "one more",
        &format!(";SampleRate, 100,Hz\n;Headers, time,torque,spare\n{}", rows(timed)),
        ("torque", "?", 1.0),
    );
    let waveform = "Name,torque,spare\nUnit,mN*m,V\nWaveform start,05.03.2024 14:59:58,05.03.2024 14:59:58\n\
                    Waveform increment,0.01,0.01\nWaveform xname,Time,Time\n";
    holds("waveform", &format!("{waveform}{}", rows(|k| format!(",{},1", a(k)))), ("torque", "N*m", 1e-3));
    let traces = "\"TraceName\",,\"CH1\",\"CH2\"\n\"VUnit\",,\"V\",\"A\"\n\"HResolution\",,1.0E-02,1.0E-02\n\"SampleRate\",,100,100\n\
                  \"Date\",,\"2024/03/05\",\"2024/03/05\"\n\"Time\",,\"14:59:58.25\",\"14:59:58.25\"\n\n";
    holds("traces", &format!("{traces}{}", rows(|k| format!(",,{},1", a(k)))), ("CH1", "V", 1.0));
    let below = "channel names:\t\ntorque\tspare\t\nstart times:\t\n03/25/2024 14:59:58\t03/25/2024 14:59:58\ndt:\t\n0.01\t0.01\ndata:\t\n";
    holds("below keys", &format!("{below}{}", rows(|k| format!("{}\t1", a(k)))), ("torque", "?", 1.0));
    let clock = "Channel name;Zeit  1 - Standardmessrate;torque\nUnit;s;Nm\n";
    holds(
        "catman",
        &format!("{clock}{}", rows(|k| format!("{:.2};{}", 0.01 * k as f64, a(k)))),
        ("torque", "N*m", 1.0),
    );
}

#[test]
fn a_plant_file_that_is_given_as_a_recording_is_called_one() {
    let text = "format = 1\nname = \"wheel\"\n\n[[body]]\nname = \"disc\"\nmass = \"2 kg\"\ninertia = { value = \"0.02 kg*m^2\" }\n";
    let refused = read("plant", text).unwrap_err();
    assert!(refused.contains("TOML file") && refused.contains("--plant"), "{refused}");
}
