//! `obsid identify`: numbers of one vehicle from all its recordings, and what it refuses.

use crate::desk::{Folder, number};
use serde_json::Value;

/// Two recordings of a pendulum whose bob is heavier than its plant file says, each with a plant
/// file of its own rate, and a third that nothing is fitted to.
fn swings(name: &str) -> Folder {
    let folder = Folder::new(name);
    let plant = include_str!("../../deploy/plants/pendulum.toml");
    folder.file("slow.toml", plant);
    folder.file("fast.toml", plant.replace("period = \"10 ms\"", "period = \"5 ms\""));
    folder.file("other.toml", plant.replace("sigma = \"2e-3 kg\"", "sigma = \"1e-3 kg\""));
    for (plant, seed, out) in
        [("slow.toml", "11", "slow.csv"), ("fast.toml", "12", "fast.csv"), ("slow.toml", "13", "third.csv")]
    {
        let words =
            ["simulate", plant, "--duration", "6", "--seed", seed, "--set", "bar.com.x = 0.416 m", "--out", out];
        folder.ask(&words).ends_with(0);
    }
    folder
}

fn found<'a>(object: &'a Value, name: &str) -> &'a Value {
    object["parameters"].as_array().unwrap().iter().find(|one| one["name"] == name).unwrap()
}

#[test]
fn recordings_with_plants_of_their_own_give_one_number_that_predicts_a_third() {
    let folder = swings("identify");
    let line = ["identify", "slow.csv=slow.toml", "fast.csv=fast.toml", "--predict", "third.csv=slow.toml", "--json"];
    let object = folder.ask(&line).ends_with(0).object();
    assert_eq!(object["converged"], true);
    let com = found(&object, "bar.com.x");
    assert!((number(com, "value") - 0.416).abs() < 4.0 * number(com, "sigma"), "{com}");
    // each recording has a bias of its own
    assert!(
        found(&object, "angle.bias@slow")["value"].is_number()
            && found(&object, "angle.bias@fast")["value"].is_number()
    );
    for arc in object["arcs"].as_array().unwrap() {
        assert!(number(arc, "p_between") > 1e-3 && (number(arc, "chi2_per_row") - 1.0).abs() < 0.3, "{arc}");
    }
    assert!((number(&object["predicted"][0], "chi2_per_row") - 1.0).abs() < 0.3, "{}", object["predicted"]);
    let table = folder.ask(&line[..5]).ends_with(0).stdout;
    for text in ["identified from 2 recordings", "predicted, not fitted", "agrees"] {
        assert!(table.contains(text), "{table}");
    }
}

#[test]
fn what_is_not_said_or_said_twice_is_refused_with_a_cure() {
    let folder = swings("identify_refused");
    let two = ["identify", "slow.csv=slow.toml", "fast.csv=other.toml"];
    folder.ask(&two).refuses(&["bar.mass", "0.002", "0.001", "one prior"]);
    folder.ask(&["identify", "slow.csv"]).refuses(&["slow.csv=PLANT.toml", "--plant"]);
    let same = ["identify", "slow.csv", "--predict", "slow.csv", "--plant", "pendulum"];
    folder.ask(&same).refuses(&["give another recording"]);
}
