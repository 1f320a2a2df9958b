//! Committed documents that are generated from the samples.

use crate::desk::{ask, workspace};

#[test]
fn the_committed_interface_control_document_is_the_one_of_this_build() {
    let generated = ask(&["icd", "--json"]).ends_with(0).stdout;
    let committed = std::fs::read_to_string(workspace().join("deploy/icd.json")).unwrap();
    assert!(committed == generated, "deploy/icd.json is old: write it with `obsid icd --json > deploy/icd.json`");
}

#[test]
fn the_readme_shows_the_topic_table_of_this_build() {
    let generated = ask(&["icd"]).ends_with(0).stdout;
    let readme = std::fs::read_to_string(workspace().join("README.md")).unwrap();
    let behind = readme.split_once("<!-- topics -->").expect("README.md has no <!-- topics -->").1;
    let table = behind.split_once("<!-- /topics -->").expect("README.md has no <!-- /topics -->").0;
    assert!(
        table.trim() == generated.trim(),
        "put the output of `obsid icd` between the markers of README.md:\n{generated}"
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
