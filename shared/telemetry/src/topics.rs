//! The one list of topics: name, sample, depth, who produces, who consumes.
//!
//! Depth is buffer and history at once, so that a restarted consumer finds what it missed. Pacing
//! keeps `window x samples per frame <= depth / 2`, which the runtime checks at start (architecture
//! D5: `deploy/guide/architecture.md`).

use crate::commands::Telecommand;
use crate::diagnosis::Diagnosis;
use crate::events::Event;
use crate::joint::{CraftRow, Information, JointEstimate};
use crate::records::*;
use crate::{FieldInfo, Header, Layout, Record};
use core::marker::PhantomData;
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout};

/// Room for topics in per-topic tables of samples.
pub const TOPICS_MAX: usize = 24;
/// Most parameters an estimate carries.
pub const PARAMETERS_MAX: usize = 12;
/// Most parameters of the arm, those with a target.
pub const INERTIAL_PARAMETERS_MAX: usize = 9;
/// Most modes an estimate carries.
pub const MODES_MAX: usize = PARAMETERS_MAX / 2;

/// A record that begins with a [`Header`] and travels on a topic: plain bytes without padding or
/// pointers.
#[cfg(not(feature = "iceoryx2"))]
pub trait Sample: Record + FromBytes + IntoBytes + Immutable + KnownLayout + Copy + core::fmt::Debug + 'static {
    /// Its first field.
    fn header(&self) -> &Header;
    /// For the runtime, which stamps layout, source and sequence number.
    fn header_mut(&mut self) -> &mut Header;
    /// A sample of time `t_meas_ns` with every field 0.
    #[must_use]
    fn zeroed_at(t_meas_ns: u64) -> Self {
        let mut sample = Self::new_zeroed();
        *sample.header_mut() = Header::at(t_meas_ns);
        sample
    }
}
/// A record that begins with a [`Header`] and travels on a topic: plain bytes without padding or
/// pointers.
#[cfg(feature = "iceoryx2")]
pub trait Sample:
    Record
    + FromBytes
    + IntoBytes
    + Immutable
    + KnownLayout
    + Copy
    + core::fmt::Debug
    + iceoryx2::prelude::ZeroCopySend
    + 'static
{
    /// Its first field.
    fn header(&self) -> &Header;
    /// For the runtime, which stamps layout, source and sequence number.
    fn header_mut(&mut self) -> &mut Header;
    /// A sample of time `t_meas_ns` with every field 0.
    #[must_use]
    fn zeroed_at(t_meas_ns: u64) -> Self {
        let mut sample = Self::new_zeroed();
        *sample.header_mut() = Header::at(t_meas_ns);
        sample
    }
}

/// How a topic reaches a partition.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Delivery {
    /// From the source, with the frame whose tick covers its sequence number.
    Source,
    /// From a partition, one pacing window after the frame in which it was made.
    Feedback,
    /// As it comes: wall-clock matters, never part of an estimate.
    Status,
}

/// Number of a topic, its index in [`TOPICS`].
pub type TopicId = usize;

/// A topic whose sample type is known.
pub struct Topic<T> {
    /// Index in [`TOPICS`], and in per-topic arrays of samples.
    pub id: TopicId,
    sample: PhantomData<fn() -> T>,
}
impl<T> Clone for Topic<T> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<T> Copy for Topic<T> {}

/// A row of the topic table.
#[derive(Clone, Copy, Debug)]
pub struct TopicInfo {
    /// Also the name of the transport's service and of the recording's channel.
    pub name: &'static str,
    /// [`Record::NAME`] of its samples.
    pub record: &'static str,
    /// [`Record::FIELDS`] of its samples.
    pub fields: &'static [FieldInfo],
    /// [`Layout::HASH`] of its samples, equal in all processes that exchange them.
    pub layout: u32,
    /// Of one sample \[bytes\], a multiple of 8.
    pub size: usize,
    /// Buffer of a consumer and history for late joiners \[samples\].
    pub depth: usize,
    /// Most samples the producer sends in one frame.
    pub per_frame: usize,
    /// Which frame of a consumer takes a sample.
    pub delivery: Delivery,
    /// In words, for the interface control document.
    pub rate: &'static str,
    /// Names of partitions, separated by blanks, or `all`.
    pub producers: &'static str,
    /// As `producers`, for the document alone: a partition gets the topics that it names itself.
    pub consumers: &'static str,
}

/// A generic function that [`for_each_topic`] calls for every topic with its sample type: the only
/// bridge from a [`TopicId`] to a type.
pub trait TopicVisitor {
    /// Called once per topic, in the order of [`TOPICS`].
    fn visit<T: Sample>(&mut self, topic: Topic<T>, info: &'static TopicInfo);
}

macro_rules! samples {
    ($($constant:ident $name:literal : $ty:ident x $depth:literal, $per_frame:literal a frame, $delivery:ident, $rate:literal, $from:literal => $to:literal;)*) => {
        samples!(@id 0usize; $($constant : $ty,)*);
        /// [`TOPICS`] for constants: how many there are, what they hash to.
        pub const TOPIC_TABLE: &[TopicInfo] = &[$(TopicInfo {
            name: $name,
            record: <$ty as Record>::NAME,
            fields: <$ty as Record>::FIELDS,
            layout: <$ty as Layout>::HASH,
            size: core::mem::size_of::<$ty>(),
            depth: $depth,
            per_frame: $per_frame,
            delivery: Delivery::$delivery,
            rate: $rate,
            producers: $from,
            consumers: $to,
        },)*];
        /// All topics, in the order of their numbers.
        pub static TOPICS: &[TopicInfo] = TOPIC_TABLE;
        /// Visits every topic in the order of its number.
        pub fn for_each_topic(visitor: &mut impl TopicVisitor) {
            $(visitor.visit($constant, &TOPICS[$constant.id]);)*
        }
    };
    (@id $id:expr; $constant:ident : $ty:ident, $($rest:tt)*) => {
        #[doc = concat!("Topic of [`", stringify!($ty), "`] samples.")]
        pub const $constant: Topic<$ty> = Topic { id: $id, sample: PhantomData };
        samples!(@id $id + 1; $($rest)*);
    };
    (@id $id:expr;) => {
        // The macro counts as 0 + 1 + 1 + ...
        #[allow(clippy::int_plus_one)]
        const _: () = assert!($id <= TOPICS_MAX);
    };
}

macro_rules! impl_sample {
    ($($ty:ident),*) => { $(impl Sample for $ty {
        fn header(&self) -> &Header { &self.header }
        fn header_mut(&mut self) -> &mut Header { &mut self.header }
    })* };
}
impl_sample!(
    Imu,
    Joints,
    Actuators,
    Accelerometers,
    Tick,
    Progress,
    InertialEstimate,
    SloshEstimate,
    ModalEstimate,
    TargetEstimate,
    Verdict,
    InertiaComparison,
    CraftRow,
    Information,
    JointEstimate,
    Diagnosis,
    Mode,
    Command,
    Housekeeping,
    Event,
    Telecommand
);

samples! {
    IMU "imu": Imu x 2048, 10 a frame, Source, "1 kHz or less", "sensor-sim" => "inertial-id slosh-id supervisor recorder";
    JOINTS "joints": Joints x 2048, 10 a frame, Source, "1 kHz or less", "sensor-sim" => "inertial-id supervisor recorder";
    ACTUATORS "actuators": Actuators x 2048, 10 a frame, Source, "1 kHz or less", "sensor-sim" => "slosh-id modal-id supervisor recorder";
    ACCELEROMETERS "accelerometers": Accelerometers x 256, 1 a frame, Source, "one batch a frame", "sensor-sim" => "modal-id supervisor recorder";
    TICK "tick": Tick x 256, 1 a frame, Source, "100 Hz", "sensor-sim" => "all";
    ESTIMATE_INERTIAL "estimate/inertial": InertialEstimate x 32, 0 a frame, Feedback, "1 Hz and at the end of an experiment", "inertial-id" => "supervisor recorder";
    ESTIMATE_SLOSH "estimate/slosh": SloshEstimate x 32, 0 a frame, Feedback, "0.1 Hz and at the end of an experiment", "slosh-id" => "supervisor recorder";
    ESTIMATE_MODAL "estimate/modal": ModalEstimate x 32, 0 a frame, Feedback, "1 Hz and at the end of an experiment", "modal-id" => "supervisor recorder";
    VERDICT "verdict": Verdict x 32, 0 a frame, Feedback, "at the end of an experiment", "supervisor" => "recorder";
    MODE "mode": Mode x 16, 0 a frame, Feedback, "on change", "supervisor" => "all";
    PROGRESS "progress": Progress x 16, 0 a frame, Status, "every checkpoint, 20 Hz when idle", "all" => "all";
    HOUSEKEEPING "housekeeping": Housekeeping x 16, 0 a frame, Status, "1 Hz of wall time", "all" => "recorder";
    COMMAND "command": Command x 16, 0 a frame, Status, "on demand", "supervisor" => "all";
    EVENT "event": Event x 64, 0 a frame, Status, "on demand", "all" => "recorder";
    ESTIMATE_INERTIAL_TORQUE "estimate/inertial-torque": InertialEstimate x 32, 0 a frame, Feedback, "1 Hz and at the end of an experiment", "inertial-id" => "recorder";
    ESTIMATE_TARGET "estimate/target": TargetEstimate x 16, 0 a frame, Feedback, "at the end of an experiment after capture", "inertial-id" => "recorder";
    COMPARISON_INERTIA "comparison/inertia": InertiaComparison x 16, 0 a frame, Feedback, "at the end of the second of two experiments", "supervisor" => "recorder";
    CRAFT "craft": CraftRow x 256, 1 a frame, Source, "one a control period", "sensor-sim" => "inertial-id slosh-id modal-id diagnosis recorder";
    INFORMATION_INERTIAL "information/inertial": Information x 16, 0 a frame, Feedback, "one an arc and generation", "inertial-id" => "slosh-id modal-id supervisor diagnosis recorder";
    INFORMATION_SLOSH "information/slosh": Information x 16, 0 a frame, Feedback, "one an arc and generation", "slosh-id" => "inertial-id modal-id supervisor diagnosis recorder";
    INFORMATION_MODAL "information/modal": Information x 16, 0 a frame, Feedback, "one an arc and generation", "modal-id" => "inertial-id slosh-id supervisor diagnosis recorder";
    ESTIMATE_JOINT "estimate/joint": JointEstimate x 16, 0 a frame, Feedback, "one a generation", "supervisor" => "inertial-id slosh-id modal-id diagnosis recorder";
    DIAGNOSIS "diagnosis": Diagnosis x 16, 0 a frame, Feedback, "when the supervisor asks", "diagnosis" => "inertial-id slosh-id modal-id supervisor recorder";
    TELECOMMAND "telecommand": Telecommand x 32, 0 a frame, Feedback, "on demand", "supervisor" => "all";
}

/// Topics of what arcs say of one craft, by the code of the [`Domain`](crate::Domain) that keeps
/// them.
pub const INFORMATION: [Topic<Information>; 3] = [INFORMATION_INERTIAL, INFORMATION_SLOSH, INFORMATION_MODAL];

/// Index of the topic whose [`TopicInfo::name`] is `name`; `None` for a topic of another build.
#[must_use]
pub fn topic_named(name: &str) -> Option<TopicId> {
    TOPICS.iter().position(|topic| topic.name == name)
}

/// Whether `topic` carries estimates, verdicts or modes: the samples that a run's digest covers
/// (architecture D7).
///
/// # Panics
/// When `topic` is not below the number of topics.
#[must_use]
pub fn is_result(topic: TopicId) -> bool {
    TOPICS[topic].delivery == Delivery::Feedback
}

/// Whether samples of `topic` go to another computer (`obsid bridge`): results and reports. Sensor
/// data stay where they are measured, and so does that by which the partitions of one run pace each
/// other.
///
/// # Panics
/// When `topic` is not below the number of topics.
#[must_use]
pub fn is_carried(topic: TopicId) -> bool {
    is_result(topic) || topic == EVENT.id || topic == HOUSEKEEPING.id
}

/// One hash for everything that two builds must agree on beyond a sample's own layout: the topic
/// table in its order (samples index topics by number), the stamps, and every list of codes.
#[must_use]
pub const fn generation() -> u32 {
    // Of the build: every checkpoint and every service that is opened asks for it.
    const OF_THIS_BUILD: u32 = hash_of_tables();
    OF_THIS_BUILD
}

const fn hash_of_tables() -> u32 {
    let mut hash = <crate::Stamps as Layout>::HASH;
    let mut topic = 0;
    while topic < TOPIC_TABLE.len() {
        let info = &TOPIC_TABLE[topic];
        hash = crate::layout_hash(hash, info.name.as_bytes());
        hash = crate::layout_hash(hash, &info.layout.to_le_bytes());
        hash = crate::layout_hash(hash, &(info.depth as u32).to_le_bytes());
        hash = crate::layout_hash(hash, &[info.per_frame as u8, info.delivery as u8]);
        topic += 1;
    }
    crate::codes::hash_of_codes(hash)
}

#[cfg(test)]
mod tests {
    use super::{
        Delivery, MODE, Sample, TICK, TOPICS, TargetEstimate, Topic, TopicInfo, TopicVisitor, for_each_topic,
        is_result, topic_named,
    };
    use crate::{Estimate, PartitionId, Record};

    #[test]
    fn every_sample_begins_with_a_header_and_has_no_gap_between_fields() {
        for info in TOPICS {
            assert_eq!(
                (info.fields[0].ros, info.fields[0].offset, info.fields[0].size),
                ("Header", 0, 24),
                "{}",
                info.name
            );
            let end = info.fields.iter().fold(0, |end, field| {
                assert_eq!(field.offset, end, "{}.{}", info.name, field.name);
                end + field.size
            });
            assert_eq!(end, info.size, "{}", info.name);
        }
    }

    #[test]
    fn every_result_says_after_its_header_in_which_frame_it_was_made() {
        // The runtime reads it there to know in which frame the result takes effect (architecture
        // D4).
        for info in TOPICS.iter().filter(|info| info.delivery == Delivery::Feedback) {
            let second = &info.fields[1];
            let first = if second.ros == Estimate::NAME { &Estimate::FIELDS[0] } else { second };
            assert_eq!((first.name, first.ros, second.offset), ("frame", "uint64", 24), "{}", info.name);
        }
    }

    #[test]
    fn names_are_unique_and_producers_and_consumers_exist() {
        for (id, info) in TOPICS.iter().enumerate() {
            assert_eq!(topic_named(info.name), Some(id));
            for partition in info.producers.split(' ').chain(info.consumers.split(' ')) {
                assert!(partition == "all" || PartitionId::named(partition).is_some(), "{}: {partition}", info.name);
            }
        }
        assert_eq!(topic_named("nothing"), None);
    }

    #[test]
    fn buffers_hold_twice_what_the_default_pacing_window_of_100_frames_can_bring() {
        for info in TOPICS {
            assert!(100 * info.per_frame <= info.depth / 2, "{}", info.name);
        }
    }

    #[test]
    fn estimates_verdicts_and_modes_are_results_and_nothing_else_is() {
        let results = TOPICS.iter().enumerate().filter(|(id, _)| is_result(*id)).map(|(_, info)| info.record);
        let estimates = ["InertialEstimate", "SloshEstimate", "ModalEstimate"];
        let others = ["Verdict", "Mode", "InertialEstimate", "TargetEstimate", "InertiaComparison"];
        let joint = ["Information", "Information", "Information", "JointEstimate", "Diagnosis", "Telecommand"];
        assert!(results.eq(estimates.into_iter().chain(others).chain(joint)));
        assert!(is_result(MODE.id) && !is_result(TICK.id));
    }

    #[test]
    fn a_statement_with_one_wrong_bit_is_not_intact() {
        let sealed = TargetEstimate { values: [150.0, 0.6, 0.15, 40.0], ..TargetEstimate::zeroed_at(0) }.sealed();
        assert!(sealed.is_intact());
        let mut moved = sealed;
        moved.values[3] = f64::from_bits(moved.values[3].to_bits() ^ 1);
        assert!(!moved.is_intact());
        assert!(!TargetEstimate { epoch_ns: 1, ..sealed }.is_intact());
    }

    #[test]
    fn a_visitor_meets_every_topic_once_in_order_with_its_own_type() {
        struct Count(usize);
        impl TopicVisitor for Count {
            fn visit<T: Sample>(&mut self, topic: Topic<T>, info: &'static TopicInfo) {
                assert_eq!(topic.id, self.0);
                assert_eq!((size_of::<T>(), T::HASH, T::NAME), (info.size, info.layout, info.record));
                assert_eq!(T::zeroed_at(7).header().t_meas_ns, 7);
                self.0 += 1;
            }
        }
        let mut count = Count(0);
        for_each_topic(&mut count);
        assert_eq!(count.0, TOPICS.len());
    }
}
