//! Committed documents that are generated from the samples, or repeat what the code says.

use crate::desk::{ask, workspace};

#[test]
fn the_committed_interface_control_document_is_the_one_of_this_build() {
    let generated = ask(&["icd", "--json"]).ends_with(0).stdout;
    let committed = std::fs::read_to_string(workspace().join("deploy/icd.json")).unwrap();
    assert!(committed == generated, "deploy/icd.json is old: write it with `obsid icd --json > deploy/icd.json`");
}

#[test]
fn the_guide_shows_the_topic_table_of_this_build() {
    let generated = ask(&["icd"]).ends_with(0).stdout;
    let page = std::fs::read_to_string(workspace().join("deploy/guide/architecture.md")).unwrap();
    let behind = page.split_once("<!-- topics -->").expect("the page has no <!-- topics -->").1;
    let table = behind.split_once("<!-- /topics -->").expect("the page has no <!-- /topics -->").0;
    assert!(
        table.trim() == generated.trim(),
        "put the output of `obsid icd` between the markers of deploy/guide/architecture.md:\n{generated}"
    );
}

#[test]
fn the_document_names_every_topic_with_fields_that_fill_its_sample() {
    let document = ask(&["icd", "--json"]).result();
    let topics = document["topics"].as_array().unwrap();
    assert_eq!(topics.len(), telemetry::TOPICS.len());
    for topic in topics {
        let fields = topic["fields"].as_array().unwrap();
        let bytes: u64 = fields.iter().map(|field| field["bytes"].as_u64().unwrap()).sum();
        assert_eq!(Some(bytes), topic["bytes"].as_u64(), "{}", topic["topic"]);
    }
    let markdown = ask(&["icd", "--md"]).ends_with(0).stdout;
    assert!(telemetry::TOPICS.iter().all(|topic| markdown.contains(&format!("## `{}`", topic.name))));
}

/// Names of the fields that a source gives to its effect.
fn fields_of_effect(source: &str) -> Vec<&str> {
    let body = source.split_once("Effect = Effect {\n").expect("a source with an effect").1;
    let body = body.split_once("\n};").expect("an effect ends").0;
    let names = body.lines().filter_map(|line| line.strip_prefix("    ")?.split_once(": "));
    names.map(|(name, _)| name).filter(|name| name.chars().all(|c| c.is_ascii_lowercase() || c == '_')).collect()
}

#[test]
fn the_example_for_newcomers_gives_every_field_of_an_effect() {
    let read = |path: &str| std::fs::read_to_string(workspace().join(path)).unwrap();
    let (page, pattern) = (read(".github/CONTRIBUTING.md"), read("shared/catalogue/src/joint_stribeck.rs"));
    let example = page.split_once("```rust\n").expect("an example").1.split_once("```").expect("its end").0;
    assert!(fields_of_effect(&pattern).len() > 8, "{:?}", fields_of_effect(&pattern));
    assert_eq!(
        fields_of_effect(example),
        fields_of_effect(&pattern),
        "bring the example of CONTRIBUTING.md up to date"
    );
}

#[test]
fn the_document_shows_every_record_and_every_list_of_codes_that_a_field_speaks_of() {
    let document = ask(&["icd", "--json"]).result();
    let names = |key: &str| -> Vec<String> {
        let rows = document[key].as_array().unwrap().iter();
        rows.map(|row| row["name"].as_str().unwrap().to_string()).collect()
    };
    let (records, lists) = (names("records"), names("codes"));
    let shown = ["records", "topics"].into_iter().flat_map(|key| document[key].as_array().unwrap());
    let fields: Vec<_> = shown.flat_map(|row| row["fields"].as_array().unwrap()).collect();
    let mut spoken_of = 0;
    for field in fields {
        let ty = field["type"].as_str().unwrap().split('[').next().unwrap().to_string();
        assert!(["uint16", "uint32", "uint64", "float64"].contains(&&*ty) || records.contains(&ty), "{field}");
        for word in field["what"].as_str().unwrap().split("ode of ").skip(1) {
            let list = word.split(|c: char| !c.is_alphanumeric()).next().unwrap().to_string();
            assert!(lists.contains(&list), "{field}");
            spoken_of += 1;
        }
    }
    assert!(spoken_of >= 15, "{spoken_of}");
}

#[test]
fn the_document_names_every_parameter_with_its_unit_and_says_what_a_verdict_measured() {
    let document = ask(&["icd", "--json"]).result();
    let domains = document["parameters"].as_array().unwrap();
    let count = |domain: &telemetry::Domain| telemetry::parameters(*domain).len();
    let counts: Vec<usize> = domains.iter().map(|row| row["parameters"].as_array().unwrap().len()).collect();
    assert_eq!(counts, telemetry::Domain::ALL.iter().map(count).collect::<Vec<_>>());
    let rows = domains.iter().flat_map(|row| row["parameters"].as_array().unwrap());
    for row in rows {
        assert!(["name", "unit", "what"].iter().all(|key| !row[*key].as_str().unwrap().is_empty()), "{row}");
    }
    for list in document["codes"].as_array().unwrap() {
        let measures = ["Reason", "ModeEvent"].contains(&list["name"].as_str().unwrap());
        let rows = list["codes"].as_array().unwrap();
        assert!(rows.iter().all(|row| row["measured_and_limit"].is_string() == measures), "{list}");
    }
}
