//! Geometry and mode shapes of universal files come with their labels and in SI, or with an error
//! that names the line.

use crate::{Numbers, file, scratch};
use recording::{Node, UffModel, read, read_model};
use std::path::{Path, PathBuf};

/// Made by another program: header, units in mm, four nodes, a trace line, a normal mode of 20 Hz
/// and 1 %, a complex one of 55 Hz and 2 %, a response at one frequency.
fn structure() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/uff/structure.unv")
}

/// Header of a dataset 55: analysis, data type, values at a node.
fn shape(analysis: u32, data: u32, values: u32, numbers: &str, nodes: &str) -> String {
    let kind = format!("{:10}{analysis:10}{:10}{:10}{data:10}{values:10}", 1, if values == 6 { 3 } else { 2 }, 8);
    let count = numbers.split_whitespace().count();
    format!("    -1\n    55\na\nb\nc\nd\ne\n{kind}\n{:10}{count:10}{:10}{:10}\n{numbers}\n{nodes}    -1\n", 2, 0, 1)
}

fn model(name: &str, text: &str) -> UffModel {
    read_model(&file(name, text)).unwrap()
}

fn refusal(name: &str, text: &str) -> String {
    read_model(&file(name, text)).unwrap_err().explain()
}

#[test]
fn a_structure_of_another_program_comes_with_header_geometry_and_both_kinds_of_modes() {
    let model = read_model(&structure()).unwrap();
    let header = model.header.unwrap();
    assert_eq!((header.model_name.as_str(), header.description.as_str()), ("frame", "two bays, free"));
    assert_eq!((header.program.as_str(), header.date.as_str()), ("modal test", "22-Nov-26 10:11:12"));
    assert_eq!(model.nodes.iter().map(|node| node.label).collect::<Vec<_>>(), [1, 2, 3, 14]);
    assert_eq!(model.nodes[1].xyz_m, [0.5, 0.0, -0.0205]);
    assert_eq!(model.nodes[3].xyz_m, [-0.125e-3, 1.0 / 3.0, 0.007]);
    assert_eq!((model.lines[0].number, model.lines[0].name.as_str()), (1, "outline"));
    assert_eq!(model.lines[0].strokes, [[1, 2], [3, 14]]);
    let [normal, complex] = &model.modes[..] else { panic!("{:?}", model.modes) };
    assert_eq!((normal.frequency_hz, normal.damping_ratio), (20.0, 0.01));
    assert_eq!(normal.shape[2].node, 3);
    assert_eq!(normal.shape[2].components, [[0.5, 0.0], [-1.0, 0.0], [3.0, 0.0]]);
    assert!((complex.frequency_hz - 55.0).abs() < 1e-3 && (complex.damping_ratio - 0.02).abs() < 1e-6);
    assert_eq!(complex.shape[2].components, [[0.5, 0.0], [0.0, -1.0], [3.0, -0.5]]);
    assert_eq!(complex.shape[1].components[0], [1.0, 1.0]);
    let left_out = "datasets 55 that are no modes are left out: response at one frequency (1)";
    assert_eq!(model.notes, [left_out]);
}

#[test]
fn the_functions_of_a_structure_are_asked_for_and_not_made_up() {
    let error = read(&structure()).unwrap_err().explain();
    assert!(error.contains("no dataset 58"), "{error}");
}

#[test]
fn geometry_in_either_form_and_without_columns_is_the_same() {
    let one =
        "    -1\n    15\n         7         0         0        11  5.00000D-01  0.00000E+00 -1.00000E+00\n    -1\n";
    let two = "    -1\n  2411\n         7         1         1        11\n   5.0000000000000000D-01   0.0000000000000000D+00  -1.0000000000000000D+00\n    -1\n";
    let words = "    -1\n    15\n7 0 0 11 0.5 0 -1\n\n    -1\n";
    let expected = [Node { label: 7, xyz_m: [0.5, 0.0, -1.0] }];
    for (name, text) in [("one.unv", one), ("two.unv", two), ("words.unv", words)] {
        let model = model(name, text);
        assert_eq!(model.nodes, expected, "{name}");
        assert_eq!(model.notes, ["no units (dataset 164): coordinates are taken as metres"]);
    }
    // Both forms of one geometry in a file are one geometry; units behind the nodes count, too.
    let inch = "    -1\n   164\n         7Inch (pound f)               1\n    3.937007874015748D+01   2.24808943099711D-01   1.0D+00\n    -1\n";
    let both = model("both.unv", &format!("{one}{two}{inch}"));
    assert_eq!(both.nodes.len(), 1);
    assert!((both.nodes[0].xyz_m[0] - 0.0127).abs() < 1e-15 && both.notes.is_empty(), "{both:?}");
}

#[test]
fn six_components_are_read_over_two_lines_and_hysteretic_damping_is_halved() {
    let nodes = "         4\n  1.00000E+00  2.00000E+00  3.00000E+00  4.00000E+00  5.00000E+00  6.00000E+00\n\
                 \x20 7.00000E+00  8.00000E+00  9.00000E+00  1.00000E+01  1.10000E+01  1.20000E+01\n";
    let eigenvalue = " -1.00000E+00  0.00000E+00  1.00000E+00  0.00000E+00";
    let six = model("six.unv", &shape(7, 5, 6, eigenvalue, nodes));
    let components = &six.modes[0].shape[0].components;
    assert_eq!((components.len(), components[5]), (6, [11.0, 12.0]));
    assert_eq!(six.modes[0].damping_ratio, 1.0);
    let hysteretic = "  2.00000E+01  1.00000E+00  0.00000E+00  4.00000E-02";
    let padded = "         4\n  1.00000E+00  2.00000E+00  3.00000E+00  0.00000E+00  0.00000E+00  0.00000E+00\n";
    let mode = &model("hysteretic.unv", &shape(2, 2, 3, hysteretic, padded)).modes[0];
    assert_eq!((mode.damping_ratio, mode.shape[0].components.len()), (0.02, 3));
}

#[test]
fn what_is_wrong_with_geometry_or_shapes_is_named_with_its_line_and_a_cure() {
    let node = "         4\n  1.00000E+00  2.00000E+00  3.00000E+00\n";
    let normal = "  2.00000E+01  1.00000E+00  1.00000E-02  0.00000E+00";
    let good = shape(2, 2, 3, normal, node);
    let cases = [
        (shape(2, 2, 6, normal, node), "line 13: 3 numbers of node 4 are there, 6 are announced"),
        (shape(2, 2, 6, normal, &format!("{node}         5\n")), "line 13: 3 numbers of node 4 are there, 6 are"),
        (shape(2, 2, 2, normal, node), "line 12: 3 numbers of node 4, 2 are announced"),
        (shape(2, 2, 99, normal, node), "line 8: 99 values at a node are announced"),
        (shape(2, 3, 3, normal, node), "line 8: data of type 3; read are real (2) and complex (5)"),
        (good.replace("3.00000E+00", "        NaN"), "line 12: `1.00000E+00  2.00000E+00          NaN` is no line of"),
        (good.replace("  2.00000E+01", " -2.00000E+01"), "line 10: the mode has a frequency of -20 Hz"),
        (
            good.replace("         2         4", "         2-999999999"),
            "line 9: 2 integers and -999999999 real numbers",
        ),
        (good.replace("         4\n", "      four\n"), "line 11: `four` is no label of a node"),
        (good.clone() + "    55\n", "line 14: `55` stands where `-1` opens a dataset"),
        (
            "    -1\n    15\n 7 0 0 0 1.0 2.0\n    -1\n".into(),
            "line 3: `7 0 0 0 1.0 2.0` does not hold three coordinates",
        ),
        ("    -1\n    15\n x 0 0 0 1.0 2.0 3.0\n    -1\n".into(), "does not begin with the label of a node"),
        (
            "    -1\n    15\n 7 0 0 0 1 2 3\n 7 0 0 0 1 2 4\n    -1\n".into(),
            "line 4: node 7 is at [1.0, 2.0, 4.0] and before",
        ),
        ("    -1\n  2411\n 7 0 0 0\n    -1\n".into(), "line 4: node 7 has no coordinates"),
        ("    -1\n    82\n 1 5 0\nname\n 1 2 3\n    -1\n".into(), "line 6: 3 entries of a trace line, 5 are announced"),
        (
            "    -1\n    82\n 1 9223372036854775807 0\nname\n 1 2\n    -1\n".into(),
            "2 entries of a trace line, 9223372036854775807 are announced",
        ),
        ("    -1\n    82\n 1\nname\n 1 2 3\n    -1\n".into(), "does not hold number and length of a trace line"),
        ("    -1\n    82\n 1 2 3\nname\n 1 b\n    -1\n".into(), "line 5: `1 b` is no line of node labels"),
        ("    -1\n    82\n 1 2 3\nname\n 1 2\n".into(), "line 5: the file ends after line 5"),
        ("time [s],a [m]\n0,1\n".into(), "line 1: no dataset opens with `-1`: this is no universal file"),
    ];
    for (text, said) in cases {
        let error = refusal("bad.unv", &text);
        assert!(error.contains("bad.unv: ") && error.contains(said) && error.contains("cure: "), "{said}: {error}");
    }
}

#[test]
fn functions_beside_a_structure_are_passed_over_and_other_datasets_are_counted() {
    let response = crate::universal_files::RESPONSE;
    // The bytes of a binary function may spell the end of a dataset.
    let bytes: Vec<u8> = b"\n    -1\n".repeat(10);
    let path = scratch("mixed.unv");
    let all =
        [std::fs::read(structure()).unwrap(), response.binary(true, &bytes), b"    -1\n  2412\n 1\n    -1\n".to_vec()];
    std::fs::write(&path, all.concat()).unwrap();
    let model = read_model(&path).unwrap();
    assert_eq!((model.nodes.len(), model.modes.len()), (4, 2));
    assert!(model.notes.iter().any(|note| note.ends_with("are left out: 2412 (1)")), "{:?}", model.notes);
}

#[test]
fn a_damaged_structure_is_a_structure_or_an_error_with_a_cure() {
    let bytes = std::fs::read(structure()).unwrap();
    let whole = read_model(&structure()).unwrap();
    let path = scratch("damaged.unv");
    let mut numbers = Numbers(55);
    let mut refused = 0;
    for k in 0..300 {
        let mut damaged = bytes.clone();
        match k % 3 {
            0 => damaged.truncate(numbers.below(bytes.len())),
            1 => damaged[numbers.below(bytes.len())] ^= 1 << numbers.below(8),
            _ => (0..4).for_each(|_| damaged[numbers.below(bytes.len())] = b"-1 559\nE."[numbers.below(9)]),
        }
        std::fs::write(&path, &damaged).unwrap();
        match read_model(&path) {
            Ok(model) => {
                assert!(model.nodes.len() <= whole.nodes.len() + 1 && model.modes.len() <= whole.modes.len() + 1);
                let finite = |x: &f64| x.is_finite();
                assert!(model.nodes.iter().all(|node| node.xyz_m.iter().all(finite)));
                assert!(model.modes.iter().all(|mode| mode.frequency_hz.is_finite() && mode.damping_ratio.is_finite()));
            }
            Err(error) => {
                refused += 1;
                assert!(error.explain().contains("cure: "), "{error}");
            }
        }
    }
    assert!(refused > 100, "{refused}");
}
