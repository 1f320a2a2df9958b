//! Channels with sample times of their own: what is written is read, bit for bit, and nothing else
//! is in the file.

use crate::{Numbers, file, scratch};
use channels::{Channel, Recording};
use recording::{Imported, ReplayFrames, SeriesSet, Table, read, series, write_series};

fn recording(channels: Vec<Channel>) -> Recording {
    Recording { name: "memory".into(), channels }
}

/// Channels of many rates with random values of all sizes, times as decimals of nanoseconds, and
/// the corners of f64.
fn random_recording() -> Recording {
    let mut numbers = Numbers(17);
    let units = ["rad/s", "N*m*s/rad", "V", "A", "T", "rad/s^2", "kg", "m", "Hz", "-"];
    let mut channels: Vec<Channel> = Vec::new();
    for (i, unit) in units.iter().enumerate() {
        let mut time_ns = numbers.below(1_000_000_000) as u64;
        let (mut time_s, mut values) = (Vec::new(), Vec::new());
        for _ in 0..numbers.below(500) + 2 {
            time_s.push(time_ns as f64 / 1e9);
            values.push(numbers.unit() * 10f64.powi(numbers.below(600) as i32 - 300));
            // Every second channel on the grid of the first, so that rows are shared.
            time_ns += if i % 2 == 0 { 1 + numbers.next() % 1_000_000_000 } else { 250_000 };
        }
        channels.push(Channel::new(&format!("hub/rate, {i} [raw]"), unit, time_s, values));
    }
    let corners = vec![-0.0, 5e-324, f64::MAX, f64::MIN_POSITIVE, -1e-5, 1e16, 123_456_789.0];
    channels.push(Channel::new("corners", "m", (0..corners.len()).map(|i| i as f64).collect(), corners));
    channels.push(Channel::new("silent", "rad", Vec::new(), Vec::new()));
    recording(channels)
}

fn same_bits(a: &SeriesSet, b: &Recording) {
    assert_eq!(a.recording.channels.len(), b.channels.len());
    for (read, b) in a.recording.channels.iter().zip(&b.channels) {
        let bits = |numbers: &[f64]| numbers.iter().map(|number| number.to_bits()).collect::<Vec<_>>();
        assert_eq!((&read.name, &read.unit, a.unit_in_file(read)), (&b.name, &b.unit, b.unit.as_str()));
        assert_eq!(bits(&read.time_s), bits(&b.time_s), "times of {}", b.name);
        assert_eq!(bits(&read.value), bits(&b.value), "values of {}", b.name);
    }
}

#[test]
fn channels_written_and_read_are_bit_for_bit_the_same_in_every_format() {
    let written = random_recording();
    for name in ["series.csv", "series.csv.gz", "series.mcap"] {
        let path = scratch(name);
        let notes = write_series(&written, &path).unwrap();
        assert!(notes.is_empty(), "{notes:?}");
        let Imported::Series(read) = read(&path).unwrap() else { panic!("channels") };
        same_bits(&read, &written);
        assert!(!scratch(&format!("{name}.writing")).exists());
    }
}

#[test]
fn the_formats_write_channels_and_the_same_channels_give_the_same_bytes() {
    let written = random_recording();
    for name in ["formats.mcap", "formats.csv"] {
        let format = recording::FORMATS.iter().find(|format| name.ends_with(format.name())).unwrap();
        let path = scratch(name);
        let mut set = SeriesSet::new("memory");
        set.recording.clone_from(&written);
        format.write(&Imported::Series(set), &path).unwrap();
        let first = std::fs::read(&path).unwrap();
        assert!(format.sniff(&first));
        write_series(&written, &path).unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), first, "{name}");
    }
}

#[test]
fn an_mcap_of_channels_holds_their_samples_in_order_of_time_and_nothing_else() {
    let written = recording(vec![
        Channel::new("slow", "rad", vec![0.0, 0.3], vec![1.0, 2.0]),
        Channel::new("fast", "N*m", vec![0.1, 0.2, 0.3], vec![3.0, 4.0, 5.0]),
    ]);
    let path = scratch("plain.mcap");
    write_series(&written, &path).unwrap();
    let bytes = std::fs::read(&path).unwrap();
    // Read by the crate's own reader, which knows nothing of this one.
    let messages: Vec<_> = mcap::MessageStream::new(&bytes).unwrap().map(Result::unwrap).collect();
    let listed: Vec<_> = messages
        .iter()
        .map(|m| (m.channel.topic.as_str(), m.sequence, m.log_time, f64::from_le_bytes(m.data[..].try_into().unwrap())))
        .collect();
    let expected = [
        ("/slow", 0, 0, 1.0),
        ("/fast", 0, 100_000_000, 3.0),
        ("/fast", 1, 200_000_000, 4.0),
        ("/slow", 1, 300_000_000, 2.0),
        ("/fast", 2, 300_000_000, 5.0),
    ];
    assert_eq!(listed, expected);
    for message in &messages {
        assert_eq!(message.publish_time, message.log_time);
        let schema = message.channel.schema.as_ref().unwrap();
        assert_eq!((schema.name.as_str(), schema.encoding.as_str()), ("obsid_msgs/Scalar", "ros1msg"));
        assert_eq!(schema.data.as_ref(), b"float64 value\n");
        assert_eq!(message.channel.message_encoding, "ros1");
        assert_eq!(message.channel.metadata.keys().collect::<Vec<_>>(), ["unit"]);
    }
    let summary = mcap::Summary::read(&bytes).unwrap().unwrap();
    let stats = summary.stats.unwrap();
    assert_eq!((stats.metadata_count, stats.attachment_count, stats.message_count), (0, 0, 5));
}

#[test]
fn mcap_rounds_times_to_the_nearest_nanosecond_and_says_by_how_much() {
    let time_s: Vec<f64> = (0..1000).map(|i| f64::from(i) / 3.0).collect();
    let values = vec![1.0; time_s.len()];
    let path = scratch("thirds.mcap");
    let notes = write_series(&recording(vec![Channel::new("x", "m", time_s.clone(), values)]), &path).unwrap();
    // Two of three times are no whole nanoseconds: 999 - 333 of them, each a third of one off.
    assert!(notes[0].starts_with("666 time(s) were rounded to whole nanoseconds, by 3.3e-10 s"), "{notes:?}");
    let read = series(read(&path).unwrap()).unwrap();
    for (read, written) in read.recording.channels[0].time_s.iter().zip(&time_s) {
        assert!((read - written).abs() <= 0.5e-9, "{read} {written}");
    }
}

#[test]
fn an_empty_cell_is_no_sample_of_that_channel_at_that_time() {
    let text = "time [ms],a [deg],b [N]\n0,180,1\n\n5,,2\n7,90,\n7,,3\n9,,\n";
    let path = file("sparse.csv", text);
    let imported = read(&path).unwrap();
    let error = ReplayFrames::new(&imported, None, 10_000_000).unwrap_err().explain();
    for part in ["sparse.csv: replay needs one rate: line 4, column 2 `a [deg]` is empty", "`obsid diagnose`"] {
        assert!(error.contains(part), "{error}");
    }
    let set = series(imported).unwrap();
    assert_eq!(set.recording.channel_named("a").unwrap().time_s, [0.0, 0.007]);
    assert_eq!(set.recording.channel_named("a").unwrap().value, [core::f64::consts::PI, core::f64::consts::FRAC_PI_2]);
    assert_eq!(set.recording.channel_named("b").unwrap().time_s, [0.0, 0.005, 0.007]);
    assert_eq!(set.recording.channel_named("b").unwrap().value, [1.0, 2.0, 3.0]);
    assert_eq!(set.unit_in_file(set.recording.channel_named("a").unwrap()), "deg");

    let conflict = read(&file("sparse-conflict.csv", "time [s],a [m],b [N]\n0,1,1\n1,,2\n1,1,3\n")).unwrap_err();
    let conflict = conflict.explain();
    assert!(conflict.contains("line 4, column 3 `b [N]`") && conflict.contains("2 and 3"), "{conflict}");
}

#[test]
fn uneven_sampling_is_read_as_channels_and_noted() {
    let mut numbers = Numbers(5);
    let mut time_s = 0.0;
    let mut rows = String::new();
    for i in 0..200 {
        rows.push_str(&format!("{time_s},{i}\n"));
        time_s += 0.01 + 0.1 * (numbers.unit() + 1.0);
    }
    let imported = read(&file("uneven.csv", &format!("time [s],x [m]\n{rows}"))).unwrap();
    let Imported::Series(set) = &imported else { panic!("channels") };
    assert_eq!((set.recording.channels.len(), set.recording.channels[0].value.len()), (1, 200));
    assert!(set.notes[0].starts_with("not one rate: line "), "{:?}", set.notes);
    let error = ReplayFrames::new(&imported, None, 10_000_000).unwrap_err().explain();
    assert!(error.contains("uneven.csv: replay needs one rate: line ") && error.contains("resample"), "{error}");
}

#[test]
fn channels_of_one_rate_are_a_table_whatever_file_they_were_in() {
    let time_s: Vec<f64> = (0..500).map(|i| f64::from(i) / 100.0).collect();
    let channel = |name: &str, unit, scale: f64| {
        Channel::new(name, unit, time_s.clone(), time_s.iter().map(|t| scale * t * t).collect())
    };
    let written = recording(vec![channel("force_x", "N", 2.0), channel("acceleration_x", "m/s^2", 0.1)]);
    let frames = ["rate.csv", "rate.mcap"].map(|name| {
        let path = scratch(name);
        write_series(&written, &path).unwrap();
        let imported = read(&path).unwrap();
        assert_eq!(matches!(imported, Imported::Table(_)), name == "rate.csv");
        let frames = ReplayFrames::new(&imported, None, 10_000_000).unwrap();
        same_bits(&series(imported).unwrap(), &written);
        frames
    });
    assert_eq!(frames[0].frame_count(), 500);
    for k in 0..500 {
        let samples = frames.each_ref().map(|frames| {
            let mut samples = Vec::new();
            frames.frame(k, &mut |sample| samples.push(sample));
            samples
        });
        assert_eq!(samples[0], samples[1]);
    }
    let mut set = SeriesSet::new("memory");
    set.recording.clone_from(&written);
    let table: Table = set.table().unwrap();
    assert_eq!(table.columns[1].values, written.channels[1].value);
}
