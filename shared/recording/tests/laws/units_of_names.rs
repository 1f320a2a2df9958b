//! Units of columns as names, brackets and endings state them, and words there that are no units.

use crate::file;
use recording::{Intake, SeriesSet};

fn read(name: &str, headers: &[&str]) -> Result<SeriesSet, String> {
    let row = |k: usize| {
        let cells: Vec<String> = (0..headers.len()).map(|c| format!("{}", k * (c + 1) + 1)).collect();
        format!("{:.2};{}\n", 0.01 * k as f64, cells.join(";"))
    };
    let rows: String = (0..60).map(row).collect();
    let path = file(&format!("names_{name}.csv"), &format!("t [s];{}\n{rows}", headers.join(";")));
    recording::read_with(&path, &Intake::default()).and_then(recording::series).map_err(|error| error.explain())
}

/// Name, SI unit and the first number, which is 1 in the file.
fn first(set: &SeriesSet) -> Vec<(&str, &str, f64)> {
    set.recording.channels.iter().map(|of| (of.name.as_str(), of.unit.as_str(), of.value[0])).collect()
}

#[test]
fn a_unit_that_may_be_two_things_is_the_one_that_the_name_says() {
    let cases: [(&str, &str, &str, f64); 14] = [
        ("mass [g]", "mass", "kg", 1e-3),
        ("acc [g]", "acc", "m/s^2", 9.80665),
        ("mag_x [G]", "mag_x", "T", 1e-4),
        ("mx [mG]", "mx", "T", 1e-7),
        ("accelerometerAccelerationX(G)", "accelerometerAccelerationX", "m/s^2", 9.80665),
        ("T [C]", "T", "K", 274.15),
        ("motorTemp [C]", "motorTemp", "K", 274.15),
        ("thrust [lb]", "thrust", "N", 4.448_221_615_260_5),
        ("mass [lb]", "mass", "kg", 0.453_592_37),
        ("wind [ms-1]", "wind", "m/s", 1.0),
        ("wind [ms^-1]", "wind", "m/s", 1.0),
        ("acc [ms-2]", "acc", "m/s^2", 1.0),
        ("servo [kgcm]", "servo", "N*m", 0.098_066_5),
        ("tq [NM]", "tq", "N*m", 1.0),
    ];
    for (k, (header, name, unit, value)) in cases.into_iter().enumerate() {
        let set = read(&format!("view_{k}"), &[header]).unwrap_or_else(|error| panic!("{header}: {error}"));
        let found = first(&set)[0];
        assert_eq!((found.0, found.1), (name, unit), "{header}");
        assert!((found.2 / value - 1.0).abs() < 1e-12, "{header}: {}", found.2);
    }
    for header in ["load [lb]", "x [G]", "x [NM]"] {
        let set = read("two", &[header, "b [V]"]).unwrap();
        assert_eq!(first(&set).len(), 1, "{header}: {:?}", first(&set));
        assert!(set.notes.iter().any(|note| note.contains("left out")), "{header}: {:?}", set.notes);
    }
    assert!(read("pounds", &["load [lb]"]).unwrap_err().contains("[lbm], a mass, or [lbf], a force"));
}

#[test]
fn a_word_in_brackets_that_tells_columns_apart_is_a_part_of_their_names() {
    let tables: [&[&str]; 8] = [
        &["Temp (in) ", "Temp (out)"],
        &["Rate (min)", "Rate (max)"],
        &["Angle (1)", "Angle (2)"],
        &["Sensor (A)", "Sensor (B)"],
        &["Panel (h)", "Panel (v)"],
        &["Temp [in]", "Temp [out]"],
        &["Temp (in)"],
        &["temp_A", "temp_B", "temp_C"],
    ];
    for (k, headers) in tables.iter().enumerate() {
        let set = read(&format!("labels_{k}"), headers).unwrap();
        let expected: Vec<(&str, &str)> = headers.iter().map(|header| (header.trim(), "?")).collect();
        let found: Vec<(&str, &str)> = first(&set).into_iter().map(|(name, unit, _)| (name, unit)).collect();
        assert_eq!(found, expected);
    }
    let units: [(&str, &str); 6] = [
        ("Temp (K)", "K"),
        ("length (in)", "m"),
        ("wind_angle (deg)", "rad"),
        ("thrust chamber (bar)", "Pa"),
        ("Temp (V)", "V"),
        ("duration (min)", "s"),
    ];
    for (k, (header, unit)) in units.into_iter().enumerate() {
        assert_eq!(first(&read(&format!("units_{k}"), &[header, "b [V]"]).unwrap())[0].1, unit, "{header}");
    }
    let set = read("both", &["v (m/s)", "v (km/h)"]).unwrap();
    assert_eq!(first(&set).iter().map(|of| of.1).collect::<Vec<_>>(), ["m/s", "m/s"]);
}

#[test]
fn units_in_capitals_and_at_the_end_of_a_name_are_known() {
    let cases: [(&str, &str, f64); 23] = [
        ("w [DEG/S]", "rad/s", 0.017_453_292_519_943_295),
        ("w [RAD/SEC]", "rad/s", 1.0),
        ("w [Rad/Sec]", "rad/s", 1.0),
        ("a [M/S^2]", "m/s^2", 1.0),
        ("p [MPA]", "Pa", 1e6),
        ("p [KPA]", "Pa", 1e3),
        ("p [psia]", "Pa", 6_894.757_293_168_361),
        ("f [MHZ]", "Hz", 1e6),
        ("v [fps]", "m/s", 0.3048),
        ("v [ips]", "m/s", 0.0254),
        ("q [l/min]", "m^3/s", 1e-3 / 60.0),
        ("acc (milli-g)", "m/s^2", 9.80665e-3),
        ("temp_C", "K", 274.15),
        ("acc_ms2", "m/s^2", 1.0),
        ("acc_x_g", "m/s^2", 9.80665),
        ("omega_rads", "rad/s", 1.0),
        ("speed_kmh", "m/s", 1.0 / 3.6),
        ("speed_ms", "m/s", 1.0),
        ("angle_rads", "rad", 1.0),
        ("Temp °C", "K", 274.15),
        ("speed m/s", "m/s", 1.0),
        ("w [N·m] (filtered)", "N*m", 1.0),
        ("bus_voltage_V", "V", 1.0),
    ];
    for (k, (header, unit, value)) in cases.into_iter().enumerate() {
        let set =
            read(&format!("capitals_{k}"), &[header, "b [V]"]).unwrap_or_else(|error| panic!("{header}: {error}"));
        let found = first(&set)[0];
        assert_eq!(found.1, unit, "{header}");
        assert!((found.2 / value - 1.0).abs() < 1e-12, "{header}: {}", found.2);
    }
    assert_eq!(first(&read("filtered", &["w [N·m] (filtered)"]).unwrap())[0].0, "w (filtered)");
}
