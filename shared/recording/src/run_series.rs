//! Channels of a recorded run: what its source measured, named and given units by the telemetry's
//! own fields.
//!
//! A channel is called topic, field without its unit, element: `imu.omega_bi_b.z [rad/s]`,
//! `joints.angle.1 [rad]`, `actuators.wheel_momentum [N*m*s]`,
//! `accelerometers.acceleration.3 [m/s^2]`; elements are x, y, z of a vector in body axes, else
//! numbered from 1. Every float64 field of `imu`, `joints`, `actuators` and the array of
//! `accelerometers` is taken where the sample says that it is valid. Estimates, verdicts and
//! housekeeping are no measurements of the plant.

use crate::run::{RecordedRun, RecordedSample};
use crate::units::unit_named;
use channels::Channel;
use std::collections::BTreeMap;
use telemetry::{ACCELEROMETERS, ACCELEROMETERS_MAX, ACTUATORS, BATCH_MAX, FieldInfo, IMU, JOINTS, TOPICS, TopicId};

/// The channels that have a sample at all, in the order of topics and fields.
pub(crate) fn channels(run: &RecordedRun) -> Vec<Channel> {
    let mut channels: Vec<Channel> =
        [IMU.id, JOINTS.id, ACTUATORS.id].iter().flat_map(|id| of_topic(run, *id)).collect();
    channels.extend(accelerometers(run));
    channels.retain(|channel| !channel.value.is_empty());
    channels
}

/// Samples of a topic in the order of their numbers, each once: a restarted source sends some
/// again.
fn once(run: &RecordedRun, topic: TopicId) -> impl Iterator<Item = (u64, RecordedSample<'_>)> {
    let mut samples = BTreeMap::new();
    for sample in run.samples().filter(|sample| sample.topic == topic) {
        let (seq, t_ns) = (word(sample.payload, SEQ), word(sample.payload, T_MEAS));
        samples.entry(seq).or_insert((t_ns, sample));
    }
    samples.into_values()
}

/// Places in the header: every sample begins with layout, source and flags, then these.
const SEQ: usize = 8;
const T_MEAS: usize = 16;

fn word(payload: &[u8], offset: usize) -> u64 {
    let mut bytes = [0; 8];
    bytes.copy_from_slice(&payload[offset..offset + 8]);
    u64::from_le_bytes(bytes)
}

fn number(payload: &[u8], offset: usize) -> f64 {
    f64::from_bits(word(payload, offset))
}

fn seconds(t_ns: u64) -> f64 {
    t_ns as f64 / 1e9
}

/// An empty channel for one element of a field.
fn channel(topic: TopicId, field: &FieldInfo, element: usize) -> Channel {
    // `acceleration_b_m_s2` [m/s^2] is called `acceleration_b`: the unit stands beside the name.
    let suffix = format!("_{}", field.unit.to_lowercase().replace('/', "_").replace(['^', ' '], ""));
    let stem = field.name.strip_suffix(&suffix).unwrap_or(field.name);
    let element = match (field.length, field.frame) {
        (0, _) => String::new(),
        (3, "body") => format!(".{}", ["x", "y", "z"][element]),
        _ => format!(".{}", element + 1),
    };
    let unit = unit_named(field.unit).expect("measured fields have units of the table: a test visits all");
    Channel::new(&format!("{}.{stem}{element}", TOPICS[topic].name), unit.si, Vec::new(), Vec::new())
}

/// One channel per element of every float64 field.
fn of_topic(run: &RecordedRun, topic: TopicId) -> Vec<Channel> {
    let fields = TOPICS[topic].fields.iter().filter(|field| field.ros == "float64");
    let elements = fields.flat_map(|field| (0..field.size / 8).map(move |element| (field, element)));
    let mut channels: Vec<_> = elements.map(|(f, element)| (f, element, channel(topic, f, element))).collect();
    for (t_ns, sample) in once(run, topic) {
        for (field, element, channel) in &mut channels {
            if is_valid(&sample, field, *element) {
                channel.time_s.push(seconds(t_ns));
                channel.value.push(number(sample.payload, field.offset + 8 * *element));
            }
        }
    }
    channels.into_iter().map(|(.., channel)| channel).collect()
}

fn is_valid(sample: &RecordedSample<'_>, field: &FieldInfo, element: usize) -> bool {
    let bit = match field.name {
        "omega_bi_b_rad_s" => element,
        _ => 3 + element,
    };
    match (sample.get(IMU), sample.get(JOINTS)) {
        (Some(imu), _) => field.length == 0 || imu.valid >> bit & 1 == 1,
        (_, Some(joints)) => (element as u64) < joints.count,
        _ => true,
    }
}

/// The array's columns, batches unrolled.
fn accelerometers(run: &RecordedRun) -> Vec<Channel> {
    let topic = ACCELEROMETERS.id;
    let Some(field) = TOPICS[topic].fields.iter().find(|field| field.ros == "float64") else { return Vec::new() };
    let mut channels: Vec<Channel> = (0..ACCELEROMETERS_MAX).map(|element| channel(topic, field, element)).collect();
    for (t_ns, sample) in once(run, topic) {
        let Some(batch) = sample.get(ACCELEROMETERS) else { continue };
        let rows = (batch.count as usize).min(BATCH_MAX);
        for (offset_ns, row) in batch.offset_ns[..rows].iter().zip(&batch.acceleration_m_s2) {
            let columns = channels.iter_mut().zip(row).take(batch.channels as usize);
            for (channel, value) in columns {
                channel.time_s.push(seconds(t_ns.saturating_add(u64::from(*offset_ns))));
                channel.value.push(*value);
            }
        }
    }
    channels
}
