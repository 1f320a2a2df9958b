//! Maps: dotted, quoted and nested keys, errors with span and suggestion; groups that are
//! incomplete.

use crate::file;
use miette::Diagnostic;
use recording::csv::read_csv;
use recording::{CHANNELS, ChannelMap, Channels, Domains, Table};

fn table(header: &str) -> Table {
    let columns = header.split(',').count();
    let row = |t: &str| format!("{t}{}\n", ",1".repeat(columns - 1));
    read_csv(&file(&format!("map{}.csv", header.len()), &format!("{header}\n{}{}", row("0"), row("1")))).unwrap()
}

fn found(channels: &Channels) -> Vec<&'static str> {
    channels.found().map(|(channel, _)| channel.name).collect()
}

#[test]
fn every_channel_is_found_under_its_default_columns() {
    for channel in CHANNELS {
        for column in channel.columns {
            let table = table(&format!("time [s],{column} [{}]", channel.unit));
            let channels = Channels::find(&table, None).unwrap();
            assert_eq!(found(&channels), [channel.name]);
        }
    }
}

#[test]
fn dotted_quoted_and_nested_keys_mean_the_same() {
    let table = table("time [s],a [m/s^2],w [deg/s]");
    let maps = [
        "[channels]\nimu.accel_x = \"a [m/s^2]\"\nimu.rate_z = \"w\"\n",
        "[channels]\n\"imu.accel_x\" = \"a\"\n\"imu.rate_z\" = \"w [deg/s]\"\n",
        "channels.imu = { accel_x = \"a\", rate_z = \"w [°/s]\" }\n",
        "[channels.imu]\naccel_x = \"a\"\nrate_z = \"w\"\n",
    ];
    for text in maps {
        let map = ChannelMap::parse("map.toml", text).unwrap();
        let channels = Channels::find(&table, Some(&map)).unwrap();
        assert_eq!(found(&channels), ["imu.rate_z", "imu.accel_x"], "{text}");
    }
}

#[test]
fn with_a_map_only_its_channels_exist() {
    let table = table("time [s],rate [rad/s],force_x [N],acceleration_x [m/s^2]");
    let map = ChannelMap::parse("map.toml", "[channels]\nforce.x = \"force_x\"").unwrap();
    assert_eq!(found(&Channels::find(&table, Some(&map)).unwrap()), ["force.x"]);
}

#[test]
fn an_unknown_channel_is_shown_in_the_map_with_the_nearest_name() {
    let text = "[channels]\nforce.x = \"f\"\nimu.acel_x = \"a\"\n";
    let error = ChannelMap::parse("map.toml", text).unwrap_err();
    let explanation = error.explain();
    assert!(explanation.contains("map.toml: line 3, column 5: `imu.acel_x`"), "{explanation}");
    assert!(explanation.contains("did you mean `imu.accel_x`?"), "{explanation}");
    let label = error.labels().unwrap().next().unwrap();
    assert_eq!(&text[label.offset()..label.offset() + label.len()], "acel_x");
    assert!(error.source_code().is_some());
}

#[test]
fn a_missing_column_is_shown_in_the_map_with_the_nearest_column() {
    let table = table("time [s],acceleration_x [m/s^2]");
    let text = "[channels]\nimu.accel_x = \"accelaration_x [m/s^2]\"\n";
    let error = Channels::find(&table, Some(&ChannelMap::parse("map.toml", text).unwrap())).unwrap_err();
    let explanation = error.explain();
    assert!(explanation.contains("map.toml: line 2, column 15"), "{explanation}");
    assert!(explanation.contains("has no column `accelaration_x [m/s^2]`"), "{explanation}");
    assert!(explanation.contains("did you mean `acceleration_x [m/s^2]`?"), "{explanation}");
    let label = error.labels().unwrap().next().unwrap();
    assert_eq!(&text[label.offset()..label.offset() + label.len()], "\"accelaration_x [m/s^2]\"");
    // The name is there, the unit is another.
    let map = ChannelMap::parse("map.toml", "[channels]\nimu.accel_x = \"acceleration_x [g]\"").unwrap();
    let explanation = Channels::find(&table, Some(&map)).unwrap_err().explain();
    assert!(explanation.contains("did you mean `acceleration_x [m/s^2]`?"), "{explanation}");
}

#[test]
fn maps_that_are_no_maps_are_refused_with_their_place() {
    for (text, place, said) in [
        ("[channels]\nforce.x = 3\n", "line 2, column 11", "name of a column"),
        ("[channels]\nforce.x = \"f\n", "line 2", "cure: a map reads"),
        ("[chanels]\nforce.x = \"f\"\n", "line 1, column 2", "`chanels` is not known"),
        ("", "line 1", "names no channel"),
        ("[channels]\nforce.x = \"f\"\n\"force.x\" = \"g\"\n", "line 3", "mapped twice"),
    ] {
        let explanation = ChannelMap::parse("map.toml", text).unwrap_err().explain();
        assert!(explanation.contains(place) && explanation.contains(said), "{explanation}");
    }
}

#[test]
fn a_group_with_a_hole_is_refused_with_a_map_and_left_out_with_a_note_without() {
    let table =
        table("time [s],joint1_angle [rad],joint2_angle [rad],joint2_rate [rad/s],rate [rad/s],acceleration_2 [g]");
    let channels = Channels::find(&table, None).unwrap();
    assert_eq!((channels.joints(), channels.array().len()), (0, 0));
    assert!(channels.notes()[0].contains("`joint1.rate` is missing"), "{:?}", channels.notes());
    assert!(channels.notes()[1].contains("`accel.1` is missing"), "{:?}", channels.notes());
    let map = ChannelMap::parse("m", "[channels]\njoint1.angle = \"joint1_angle\"").unwrap();
    let explanation = Channels::find(&table, Some(&map)).unwrap_err().explain();
    assert!(explanation.contains("`joint1.rate` is missing") && explanation.contains("never taken as zero"));
}

#[test]
fn what_can_be_identified_follows_from_the_channels() {
    let domains = |header: &str| Channels::find(&table(header), None).unwrap().identifiable();
    let none = Domains::default();
    assert_eq!(domains("time [s],force_x [N],acceleration_x [m/s^2]"), Domains { slosh: true, ..none });
    assert_eq!(domains("time [s],force_x [N],acceleration_y [m/s^2]"), none);
    let joints = "joint1_angle [rad],joint1_rate [rad/s],joint2_angle [rad],joint2_rate [rad/s]";
    assert_eq!(domains(&format!("time [s],rate [rad/s],{joints}")), Domains { inertial: true, ..none });
    assert_eq!(domains(&format!("time [s],rate_x [rad/s],{joints}")), none);
    assert_eq!(domains("time [s],acceleration_x [g],acceleration_z [g]"), Domains { modal: true, ..none });
    assert_eq!(domains("time [s],acceleration_x [g],acceleration_z [g],rate_x [rad/s]"), none);
    assert_eq!(
        domains("time [s],acceleration_1 [g],acceleration_2 [g],rate_x [rad/s]"),
        Domains { modal: true, ..none }
    );
}
