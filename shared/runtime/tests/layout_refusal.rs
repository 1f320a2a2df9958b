//! Two processes of different builds never exchange a sample: the layout hash is compared before a
//! service is opened.
//!
//! Layouts are compiled in, so the other build is played by services made by hand with iceoryx2
//! alone.

#![forbid(unsafe_code)]

mod toy_run;

use iceoryx2::config::Config;
use iceoryx2::node::{Node, NodeBuilder};
use iceoryx2::prelude::{
    AttributeSpecifier, FileName, Path as IoxPath, SemanticString, ServiceName, ZeroCopySend, ipc,
};
use iceoryx2::service::port_factory::publish_subscribe::PortFactory;
use runtime::link::LinkError;
use runtime::rundir::OwnedRunDir;
use runtime::shm::{Role, ShmLink};
use std::path::Path;
use telemetry::PartitionId::{SensorSim, SloshId};
use telemetry::{Header, IMU, Imu, Sample, Stamps, TOPICS, Topic, TopicInfo, TopicVisitor, for_each_topic};
use toy_run::toy_run;

/// `telemetry::Imu` as a build would have it in which rate and acceleration have changed places.
#[derive(Clone, Copy, Debug, ZeroCopySend)]
#[type_name("telemetry::records::Imu")]
#[repr(C)]
struct SwappedImu {
    header: Header,
    interval_s: f64,
    acceleration_b_m_s2: [f64; 3],
    omega_bi_b_rad_s: [f64; 3],
    valid: u64,
}

/// `telemetry::Imu` as a build would have it that knows no acceleration.
#[derive(Clone, Copy, Debug, ZeroCopySend)]
#[type_name("telemetry::records::Imu")]
#[repr(C)]
struct ShortImu {
    header: Header,
    interval_s: f64,
    omega_bi_b_rad_s: [f64; 3],
    valid: u64,
}

/// The other build: a node in the run's private prefix.
struct OtherBuild {
    node: Node<ipc::Service>,
    folder: OwnedRunDir,
}

impl OtherBuild {
    fn new() -> Self {
        let folder = OwnedRunDir::create(Path::new("/dev/shm"), &toy_run(&[SensorSim])).unwrap();
        let mut config = Config::default();
        config.global.prefix = FileName::new(folder.dir().prefix().as_bytes()).unwrap();
        config.global.set_root_path(&IoxPath::new(folder.dir().iceoryx_root().as_os_str().as_encoded_bytes()).unwrap());
        OtherBuild { node: NodeBuilder::new().config(&config).create().unwrap(), folder }
    }

    fn create<T: ZeroCopySend + core::fmt::Debug>(
        &self,
        topic: &str,
        layout: Option<&str>,
    ) -> PortFactory<ipc::Service, T, Stamps> {
        self.create_of_generation(topic, layout, telemetry::generation())
    }

    fn create_of_generation<T: ZeroCopySend + core::fmt::Debug>(
        &self,
        topic: &str,
        layout: Option<&str>,
        generation: u32,
    ) -> PortFactory<ipc::Service, T, Stamps> {
        let generation = hex(generation);
        let generation = generation.as_str().try_into().unwrap();
        let attributes = AttributeSpecifier::new().define(&"generation".try_into().unwrap(), &generation);
        let mut attributes = attributes.unwrap();
        if let Some(layout) = layout {
            attributes = attributes.define(&"layout".try_into().unwrap(), &layout.try_into().unwrap()).unwrap();
        }
        let depth = TOPICS[telemetry::topic_named(topic).unwrap()].depth;
        let builder = self.node.service_builder(&name(topic)).publish_subscribe::<T>().user_header::<Stamps>();
        let builder = builder.history_size(depth).subscriber_max_buffer_size(depth);
        builder.create_with_attributes(&attributes).unwrap()
    }

    /// What obsid says when it joins this other build.
    fn refusal(&self) -> LinkError {
        let dir = self.folder.dir();
        match ShmLink::join(&dir.prefix(), &dir.iceoryx_root(), SloshId, &[IMU.id], Role::Opens) {
            Ok(_) => panic!("another layout was accepted"),
            Err(error) => error,
        }
    }
}

fn name(topic: &str) -> ServiceName {
    format!("obs/{topic}").as_str().try_into().unwrap()
}

fn hex(layout: u32) -> String {
    format!("{layout:08x}")
}

fn assert_names_both(error: &LinkError, topic: &str, ours: u32, theirs: &str) {
    let text = error.to_string();
    assert!(matches!(error, LinkError::Layout { .. }), "{text}");
    for word in [topic, &hex(ours), theirs, "one revision"] {
        assert!(text.contains(word), "\"{word}\" is not in: {text}");
    }
}

#[test]
fn iceoryx2_alone_attaches_swapped_fields_and_reads_accelerations_as_rates() {
    // Why the hash exists. When this fails, iceoryx2 has learnt to compare layouts itself.
    let other = OtherBuild::new();
    let theirs = other.create::<SwappedImu>("imu", None);
    let ours =
        other.node.service_builder(&name("imu")).publish_subscribe::<Imu>().user_header::<Stamps>().open().unwrap();
    let (writer, reader) = (theirs.publisher_builder().create().unwrap(), ours.subscriber_builder().create().unwrap());
    let sample = SwappedImu {
        header: Header::at(0),
        interval_s: 0.01,
        acceleration_b_m_s2: [4.0, 5.0, 6.0],
        omega_bi_b_rad_s: [0.1, 0.2, 0.3],
        valid: 0,
    };
    writer.loan_uninit().unwrap().write_payload(sample).send().unwrap();
    let read = reader.receive().unwrap().expect("one sample was sent");
    assert_eq!(read.payload().omega_bi_b_rad_s, [4.0, 5.0, 6.0]);
}

#[test]
fn two_swapped_fields_of_equal_size_are_refused_and_both_hashes_are_named() {
    let other = OtherBuild::new();
    let _service = other.create::<SwappedImu>("imu", Some("0badcafe"));
    assert_names_both(&other.refusal(), "imu", TOPICS[IMU.id].layout, "0badcafe");
}

#[test]
fn a_sample_of_another_size_is_refused_and_both_hashes_are_named() {
    let other = OtherBuild::new();
    let _service = other.create::<ShortImu>("imu", Some("0badcafe"));
    assert_names_both(&other.refusal(), "imu", TOPICS[IMU.id].layout, "0badcafe");
}

#[test]
fn a_service_without_a_layout_is_refused() {
    let other = OtherBuild::new();
    let _service = other.create::<Imu>("imu", None);
    assert_names_both(&other.refusal(), "imu", TOPICS[IMU.id].layout, "no layout");
}

#[test]
fn another_topic_table_or_list_of_codes_is_refused_although_the_sample_is_the_same() {
    let (other, ours) = (OtherBuild::new(), telemetry::generation());
    let _service = other.create_of_generation::<Imu>("imu", Some(&hex(TOPICS[IMU.id].layout)), ours ^ 1);
    assert_names_both(&other.refusal(), "imu", ours, &hex(ours ^ 1));
}

#[test]
fn a_service_of_another_type_with_our_hash_is_refused_by_iceoryx2() {
    let other = OtherBuild::new();
    let _service = other.create::<ShortImu>("imu", Some(&hex(TOPICS[IMU.id].layout)));
    let text = other.refusal().to_string();
    assert!(text.contains("imu") && text.contains("IncompatibleTypes"), "{text}");
}

/// Makes every service up to `tampered` by hand; that one with another layout.
struct Services<'a> {
    other: &'a OtherBuild,
    tampered: usize,
    held: Vec<Box<dyn core::any::Any>>,
}

impl TopicVisitor for Services<'_> {
    fn visit<T: Sample>(&mut self, topic: Topic<T>, info: &'static TopicInfo) {
        if topic.id <= self.tampered {
            let layout = hex(info.layout ^ u32::from(topic.id == self.tampered));
            self.held.push(Box::new(self.other.create::<T>(info.name, Some(&layout))));
        }
    }
}

#[test]
fn one_changed_bit_in_the_hash_of_any_topic_is_refused_with_that_topic() {
    for (tampered, info) in TOPICS.iter().enumerate() {
        let other = OtherBuild::new();
        let mut services = Services { other: &other, tampered, held: Vec::new() };
        for_each_topic(&mut services);
        // The ports of the topics before it can be had, or the test would not get here.
        assert_names_both(&other.refusal(), info.name, info.layout, &hex(info.layout ^ 1));
    }
}
