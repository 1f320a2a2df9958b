use super::*;

fn array(group: &str, name: &str, shape: &[usize]) -> Array {
    let count = shape.iter().product::<usize>();
    let values = (0..count).map(|k| k as f64).collect();
    Array { group: group.into(), name: name.into(), shape: shape.to_vec(), values, ..Array::default() }
}

fn datasets(arrays: Vec<Array>) -> Vec<RawDataset> {
    Arrays { arrays, ..Arrays::default() }.into_datasets("file", &|_| true).unwrap()
}

fn names(dataset: &RawDataset) -> Vec<&str> {
    dataset.columns.iter().map(|column| column.name.as_str()).collect()
}

#[test]
fn arrays_of_one_length_are_one_dataset_and_others_are_named_by_their_length() {
    let found = datasets(vec![
        array("", "b", &[7]),
        array("", "t", &[5]),
        array("", "x", &[5, 1]),
        array("s", "u", &[3]),
        array("s", "v", &[4]),
        array("s", "w", &[4]),
    ]);
    let of: Vec<_> = found.iter().map(|dataset| (dataset.name.as_str(), names(dataset))).collect();
    assert_eq!(of, [("length_7", vec!["b"]), ("", vec!["t", "x"]), ("s.length_3", vec!["u"]), ("s", vec!["v", "w"])]);
}

#[test]
fn the_longer_dimension_of_a_matrix_is_the_rows_in_both_orders_of_storage() {
    let mut tall = array("", "m", &[3, 2]);
    let rows = datasets(vec![tall.clone()]);
    assert_eq!(rows[0].columns[0].values, [0.0, 2.0, 4.0]);
    tall.column_major = true;
    assert_eq!(datasets(vec![tall])[0].columns[1].values, [3.0, 4.0, 5.0]);
    let mut wide = array("", "m", &[1, 2, 3]);
    assert_eq!(datasets(vec![wide.clone()])[0].columns[1].values, [3.0, 4.0, 5.0]);
    wide.column_major = true;
    let found = datasets(vec![wide]);
    assert_eq!(found[0].columns[1].values, [1.0, 3.0, 5.0]);
    assert_eq!(names(&found[0]), ["m[0]", "m[1]"]);
    let mut square = array("", "m", &[2, 2]);
    assert_eq!(datasets(vec![square.clone()])[0].columns[0].values, [0.0, 2.0]);
    square.column_major = true;
    assert_eq!(datasets(vec![square])[0].columns[0].values, [0.0, 1.0]);
}

#[test]
fn a_scalar_rate_is_the_axis_only_where_no_array_of_times_is() {
    let mut rate = array("", "Fs", &[1, 1]);
    rate.values = vec![250.0];
    let with = |arrays: Vec<Array>| datasets([arrays, vec![rate.clone()]].concat());
    let found = with(vec![array("", "x", &[9])]);
    assert_eq!(found[0].axis, Axis::Uniform { start_s: 0.0, interval_s: 0.004 });
    assert!(found[0].notes[0].contains("`Fs`"), "{:?}", found[0].notes);
    let found = with(vec![array("", "x", &[9]), array("", "Time", &[9])]);
    assert_eq!(found[0].axis, Axis::Unknown);
    assert_eq!(found[0].notes, ["left out: `Fs` (one number)"]);
    let found = with(vec![array("", "H", &[9]), array("", "f", &[9])]);
    assert_eq!(found[0].axis, Axis::Unknown, "a spectrum has no interval of time");
    let found = with(vec![array("s.inner", "x", &[9])]);
    assert_eq!(found[0].axis, Axis::Uniform { start_s: 0.0, interval_s: 0.004 }, "from the top of the file");
}

#[test]
fn a_scalar_states_the_rate_or_the_interval_under_every_usual_name() {
    let stated = |name: &str, value: f64| {
        let scalar = Array { values: vec![value], ..array("", name, &[1]) };
        datasets(vec![array("", "x", &[4]), scalar]).remove(0).axis
    };
    for name in ["Fs", "fs", "sample_rate", "SampleRate", "sampling_rate", "samplingFrequency", "sample_rate_hz"] {
        assert_eq!(stated(name, 250.0), Axis::Uniform { start_s: 0.0, interval_s: 0.004 }, "{name}");
    }
    for name in ["dt", "Ts", "deltaT", "sample_time", "SamplePeriod", "sampling_interval"] {
        assert_eq!(stated(name, 0.004), Axis::Uniform { start_s: 0.0, interval_s: 0.004 }, "{name}");
    }
    for name in ["ts", "rate", "sample_rate_khz", "t", "samples"] {
        assert_eq!(stated(name, 250.0), Axis::Unknown, "{name}");
    }
}

#[test]
fn a_rate_that_is_no_rate_is_left_out() {
    for value in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let mut rate = array("", "fs", &[1]);
        rate.values = vec![value];
        let found = datasets(vec![array("", "x", &[4]), rate]);
        assert_eq!(found[0].axis, Axis::Unknown);
        assert_eq!(found[0].notes, ["left out: `fs` (one number)"]);
    }
}

#[test]
fn a_structure_without_times_takes_those_of_the_structure_around_it() {
    let found = datasets(vec![array("out", "time", &[6]), array("out.signals", "values", &[6, 2])]);
    assert_eq!(found[1].name, "out.signals");
    assert_eq!(names(&found[1]), ["time", "values[0]", "values[1]"]);
    assert_eq!(found[1].notes, ["the times are those of `out.time`"]);
}

#[test]
fn what_is_no_set_of_channels_is_left_out_and_named() {
    let found = datasets(vec![
        array("", "x", &[70]),
        array("", "wide", &[70, 65]),
        array("", "cube", &[2, 3, 4]),
        array("", "empty", &[0, 3]),
        array("", "mass", &[1]),
    ]);
    assert_eq!(found.len(), 1);
    assert_eq!(
        found[0].notes,
        ["left out: `wide` (a matrix of 70 x 65), `cube` (3 dimensions), `empty` (empty), `mass` (one number)"]
    );
}

#[test]
fn a_file_without_arrays_says_what_it_has() {
    let arrays = Arrays {
        arrays: vec![array("s", "mass", &[1])],
        left_out: vec![("note".into(), "text".into())],
        ..Arrays::default()
    };
    let error = arrays.into_datasets("file", &|_| true).unwrap_err().explain();
    assert!(error.contains("`note` (text), `s.mass` (one number)"), "{error}");
}

#[test]
fn only_the_wanted_datasets_are_given() {
    let arrays = vec![array("", "x", &[4]), array("s", "y", &[4])];
    let found = Arrays { arrays, ..Arrays::default() }.into_datasets("file", &|name| name == "s").unwrap();
    assert_eq!(found.iter().map(|dataset| dataset.name.as_str()).collect::<Vec<_>>(), ["s"]);
}
