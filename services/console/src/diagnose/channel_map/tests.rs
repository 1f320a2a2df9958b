//! Laws of the map: names, units and signs are exchanged; what cannot be is refused at its place.

use super::*;

fn plant() -> Plant {
    crate::plants::parse("drive_rig", crate::plants::built_in("drive_rig").unwrap()).unwrap().plant
}

fn set() -> SeriesSet {
    let time: Vec<f64> = (0..3).map(f64::from).collect();
    let mut set = SeriesSet::new("log.csv");
    for (name, unit, value) in [("omega", "-", [0.0, 90.0, -180.0]), ("other", "V", [1.0, 2.0, 3.0])] {
        set.push(Channel::new(name, unit, time.clone(), value.to_vec()), unit);
    }
    set
}

fn map(text: &str) -> Result<ChannelMap, String> {
    ChannelMap::parse("map.toml".into(), text.into(), &plant()).map_err(words)
}

fn words(failure: Failure) -> String {
    match failure {
        Failure::Input(report) => format!("{report:?}"),
        Failure::Run(reason) => panic!("{reason}"),
    }
}

/// A sensor of the plant whose unit is rad/s.
fn rate() -> String {
    let plant = plant();
    plant.sensors.iter().find(|s| plant.sensor_unit(s) == "rad/s").unwrap().name.clone()
}

#[test]
fn a_name_a_unit_and_a_sign_are_exchanged() {
    let mut set = set();
    let text = format!("[channels]\n{} = {{ name = \"omega\", scale = -1, unit = \"deg/s\" }}\n", rate());
    map(&text).unwrap().apply(&mut set).unwrap();
    let channel = set.recording.channel_named(&rate()).unwrap();
    assert_eq!(channel.unit, "rad/s");
    let expected = [0.0, -core::f64::consts::FRAC_PI_2, core::f64::consts::PI];
    // one multiplication and one division
    channel.value.iter().zip(expected).for_each(|(a, b)| assert!((a - b).abs() <= 1e-15 * (1.0 + b.abs())));
    assert!(set.recording.channel_named("omega").is_none() && set.recording.channel_named("other").is_some());
}

#[test]
fn a_header_with_its_unit_names_the_same_channel() {
    let mut set = set();
    map(&format!("[channels]\n{} = \"omega [-]\"\n", rate())).unwrap().apply(&mut set).unwrap();
    assert_eq!(set.recording.channel_named(&rate()).unwrap().value, [0.0, 90.0, -180.0]);
}

#[test]
fn what_cannot_be_is_refused_with_line_and_suggestion() {
    let refused = |text: &str, says: &[&str]| {
        let error = map(text).err().unwrap_or_else(|| panic!("accepted: {text}"));
        says.iter().for_each(|words| assert!(error.contains(words), "`{words}` is not in {error}"));
    };
    let rate = rate();
    refused(&format!("[channels]\n{rate}x = \"omega\"\n"), &["map.toml:2:1", &format!("did you mean '{rate}'?")]);
    refused("[chanels]\nx = \"y\"\n", &["map.toml:1:2", "[channels]"]);
    refused("", &["names no channel"]);
    refused("[channels\n", &["map.toml:1:"]);
    refused(&format!("[channels]\n{rate} = 3\n"), &["map.toml:2:", "in quotes"]);
    refused(&format!("[channels]\n{rate} = {{ name = \"a\", sale = -1 }}\n"), &["map.toml:2:", "sale"]);
    refused(&format!("[channels]\n{rate} = {{ name = \"a\", scale = 0 }}\n"), &["map.toml:2:", "not zero"]);
    refused(
        &format!("[channels]\n{rate} = {{ name = \"a\", unit = \"rad/sec\" }}\n"),
        &["map.toml:2:", "did you mean 'rad/s'"],
    );
    let absent =
        map(&format!("[channels]\n{rate} = \"omeg\"\n")).unwrap().apply(&mut set()).map_err(words).unwrap_err();
    assert!(absent.contains("map.toml:2:") && absent.contains("did you mean 'omega'?") && absent.contains("log.csv"));
}
