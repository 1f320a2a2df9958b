//! From text to scenario: faults at their places, numbers to the last bit.

use super::{WHOLE, whole};
use crate::scenario::{Opened, Refusal, Scenario, open};
use std::collections::BTreeMap;

const TANK: &str = include_str!("../../../../../deploy/plants/tank_1d.toml");
const SLOSH: &str = "format = 1\nname = \"x\"\n[slosh]\nduration_s = 6\nknown.m_0_kg = 300\n";

fn opened(text: &str) -> Result<Opened, Refusal> {
    open("test.toml", text, |name| match name {
        "tank_1d" => Ok(TANK.into()),
        _ => Err((format!("{name}: there is no such file"), "take another".into())),
    })
}

/// Everything that is said of `text`, one fault a line.
fn faults(text: &str) -> Vec<String> {
    opened(text).unwrap_err().errors.iter().map(ToString::to_string).collect()
}

fn carried(text: &str, is_replay: bool) -> Scenario {
    let Opened { text, files, .. } = opened(text).unwrap();
    Scenario::read(&text, &files, is_replay).unwrap()
}

#[test]
fn an_unknown_key_is_named_with_its_line_and_column_and_the_known_keys() {
    let faults = faults("format = 1\nname = \"x\"\nwindow_framse = 3\n");
    assert_eq!(faults.len(), 1);
    assert!(faults[0].starts_with("test.toml:3:1: "), "{faults:?}");
    assert!(faults[0].contains("window_framse") && faults[0].contains("window_frames"), "{faults:?}");
}

#[test]
fn every_number_that_cannot_be_is_named_at_its_own_place_once() {
    let text = "format = 1\nname = \"x\"\n[slosh]\nduration_s = -5.0\n[slosh.known]\nm_0_kg = nan\n";
    let faults = faults(text);
    assert_eq!(faults.len(), 2, "{faults:?}");
    assert!(faults[0].starts_with("test.toml:4:14: slosh.duration_s = -5: must be"), "{faults:?}");
    assert!(faults[1].starts_with("test.toml:6:10: slosh.known.m_0_kg = NaN: must be"), "{faults:?}");
}

#[test]
fn a_number_of_another_type_is_named_with_its_place() {
    let faults = faults("format = 1\nname = \"x\"\nseed = \"one\"\n");
    assert!(faults[0].starts_with("test.toml:3:8: "), "{faults:?}");
}

#[test]
fn a_fault_of_a_plant_stands_where_the_scenario_asks_for_it_or_in_the_plants_own_file() {
    let with = |plant: &str| faults(&format!("{SLOSH}[slosh.plant]\n{plant}"));
    assert!(with("file = \"tank\"\n")[0].starts_with("test.toml:7:8: tank: there is no such file (take another)"));
    let set = with("file = \"tank_1d\"\nset.\"fuel.mas\" = \"3 kg\"\n");
    assert!(set[0].starts_with("test.toml:8:") && set[0].contains("fuel.mass"), "{set:?}");
    let hide = with("file = \"tank_1d\"\nhide = [\n\"slosh_cubik@tank:fuel\"]\n");
    assert!(hide[0].starts_with("test.toml:9:1: ") && hide[0].contains("slosh_cubic"), "{hide:?}");
    let text = format!("{SLOSH}plant.file = \"empty\"\n");
    let refusal = open("test.toml", &text, |_| Ok("format = 1\n".into())).unwrap_err();
    assert!((refusal.file.as_str(), refusal.text.as_str()) == ("empty", "format = 1\n"), "{refusal}");
}

#[test]
fn what_a_run_carries_is_read_as_it_was_opened_and_nothing_is_read_without_its_plants() {
    let text = format!("{SLOSH}plant.file = \"tank_1d\"\n");
    let Opened { scenario, files, .. } = opened(&text).unwrap();
    let read = Scenario::read(&text, &files, false).unwrap();
    assert_eq!(read.slosh.as_ref().unwrap().plant.as_ref().unwrap().text, TANK);
    assert_eq!(Scenario { slosh: None, ..read }, Scenario { slosh: None, ..scenario });
    let refusal = Scenario::read(&text, &BTreeMap::new(), false).unwrap_err().to_string();
    assert!(refusal.contains(":6:14: ") && refusal.contains("does not carry 'tank_1d'"), "{refusal}");
}

#[test]
fn a_tank_starts_at_rest_in_a_simulation_and_where_one_was_recorded_unless_the_scenario_says() {
    let rest = |scenario: Scenario| scenario.slosh.unwrap().known.starts_at_rest;
    let simulated = format!("{SLOSH}plant.file = \"tank_1d\"\n");
    assert_eq!([false, true].map(|is_replay| rest(carried(SLOSH, is_replay))), [Some(true), Some(false)]);
    assert_eq!([false, true].map(|is_replay| rest(carried(&simulated, is_replay))), [Some(true); 2]);
    let stated = format!("{SLOSH}known.starts_at_rest = false\n");
    assert_eq!([false, true].map(|is_replay| rest(carried(&stated, is_replay))), [Some(false); 2]);
}

#[test]
fn the_shortest_decimal_of_a_number_is_read_to_its_last_bit() {
    let mut state = 1_u64;
    for _ in 0..5_000 {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        // Exponents of what is measured in SI: 2^-40 to 2^23.
        let number = f64::from_bits((state >> 12) | ((1023 - 40 + (state & 63)) << 52));
        let text = format!("format = 1\nname = \"x\"\n[modal]\nduration_s = 1\ntorque_nm = {number:?}\n");
        let read = Scenario::read(&text, &BTreeMap::new(), false).unwrap().modal.unwrap().torque_nm;
        assert_eq!(read.to_bits(), number.to_bits(), "{number:e}");
    }
}

#[test]
fn a_whole_scenario_is_readable() {
    let with_plants = open("test.toml", WHOLE, |name| match name {
        "mated" => Ok(include_str!("../../../../../deploy/plants/mated.toml").into()),
        _ => Ok(TANK.into()),
    });
    let opened = with_plants.unwrap();
    assert_eq!(opened.files.keys().collect::<Vec<_>>(), ["mated", "tank_1d"]);
    assert_eq!(opened.scenario.modal, whole().modal);
}
