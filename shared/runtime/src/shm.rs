//! The shared-memory link over iceoryx2: zero-copy between processes, one node, one listener per
//! process.
//!
//! Only the supervisor creates services, before any other partition starts: a process killed while
//! it creates a service bricks that name for ever. Everybody opens and holds all of them, so that
//! none vanishes while any partition lives. Overflow on, history = buffer: no `send` ever blocks, a
//! restarted consumer finds what it missed. The layout hash travels as a service attribute, because
//! iceoryx2 itself compares only name, size and alignment.

mod services;

use crate::link::{Link, LinkError};
use iceoryx2::config::Config;
use iceoryx2::node::{Node, NodeBuilder};
use iceoryx2::port::listener::{Listener, ListenerWaitError};
use iceoryx2::port::notifier::Notifier;
use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::port::update_connections::UpdateConnections;
use iceoryx2::prelude::{FileName, Path as IoxPath, SemanticString, SignalHandlingMode, ipc, set_log_level};
use iceoryx2::service::port_factory::event::PortFactory as EventFactory;
use iceoryx2::service::port_factory::publish_subscribe::PortFactory as SampleFactory;
use services::{sample_service, wake_service};
use std::fmt::Debug;
use std::path::Path;
use std::time::{Duration, Instant};
use telemetry::{PartitionId, Sample, Stamps, TOPICS, Topic, TopicId, TopicInfo, TopicVisitor, for_each_topic};

const CREATE_RETRY: Duration = Duration::from_secs(3);

type Service = ipc::Service;

/// A topic's ports, whatever its sample type.
trait Ports {
    fn publish(&self, stamps: &Stamps, payload: &[u8]) -> Result<(), String>;
    fn drain(&self, sink: &mut dyn FnMut(&Stamps, &[u8])) -> Result<(), String>;
    fn refresh(&self) -> Result<(), String>;
}

struct TypedPorts<T: Sample> {
    // Held so that the service lives as long as this process.
    _service: SampleFactory<Service, T, Stamps>,
    publisher: Option<Publisher<Service, T, Stamps>>,
    subscriber: Option<Subscriber<Service, T, Stamps>>,
}

impl<T: Sample> Ports for TypedPorts<T> {
    fn publish(&self, stamps: &Stamps, payload: &[u8]) -> Result<(), String> {
        let publisher = self.publisher.as_ref().ok_or("this partition does not produce it")?;
        let sample = T::read_from_bytes(payload).map_err(|_| "payload of another size")?;
        let mut loan = publisher.loan_uninit().map_err(text)?;
        *loan.user_header_mut() = *stamps;
        loan.write_payload(sample).send().map(drop).map_err(text)
    }

    fn drain(&self, sink: &mut dyn FnMut(&Stamps, &[u8])) -> Result<(), String> {
        let Some(subscriber) = &self.subscriber else { return Ok(()) };
        while let Some(sample) = subscriber.receive().map_err(text)? {
            sink(sample.user_header(), sample.payload().as_bytes());
        }
        Ok(())
    }

    fn refresh(&self) -> Result<(), String> {
        self.publisher.as_ref().map_or(Ok(()), |publisher| publisher.update_connections().map_err(text))
    }
}

fn text(error: impl Debug) -> String {
    format!("{error:?}")
}

/// Whether a process makes the services of a run or finds them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    Creates,
    Opens,
}

/// One process's end of shared memory.
pub struct ShmLink {
    ports: Vec<Box<dyn Ports>>,
    /// `None`: nobody wakes this process, it looks.
    listener: Option<Listener<Service>>,
    notifiers: Vec<Notifier<Service>>,
    wakes: Vec<EventFactory<Service>>,
    node: Node<Service>,
}

impl ShmLink {
    /// Joins the run whose iceoryx2 prefix is `prefix` and whose root is `root`.
    ///
    /// # Errors
    /// [`LinkError::Layout`] when the running system was built with another layout of a topic.
    pub fn join(prefix: &str, root: &Path, id: PartitionId, inputs: &[TopicId], role: Role) -> Result<Self, LinkError> {
        let produces = |info: &TopicInfo| info.producers == "all" || info.producers == id.text();
        let mut link = Self::open(prefix, root, role, inputs, &produces)?;
        let fail = |operation| move |reason| LinkError::Transport { topic: "wake", operation, reason };
        let own = &link.wakes[usize::from(id.code())];
        let listener = retry(&link.node, || own.listener_builder().create()).map_err(fail("listener"))?;
        let wakes = link.wakes.iter();
        link.notifiers = wakes
            .map(|wake| retry(&link.node, || wake.notifier_builder().create()))
            .collect::<Result<Vec<_>, _>>()
            .map_err(fail("notifier"))?;
        link.listener = Some(listener);
        Ok(link)
    }

    /// Reads `inputs` of a run that flies, without being one of its partitions.
    ///
    /// # Errors
    /// As [`ShmLink::join`].
    pub fn observe(prefix: &str, root: &Path, inputs: &[TopicId]) -> Result<Self, LinkError> {
        Self::open(prefix, root, Role::Opens, inputs, &|_| false)
    }

    /// Makes the services of a run whose samples come from elsewhere: whoever reads a run can read
    /// it, and the caller alone sends.
    ///
    /// # Errors
    /// As [`ShmLink::join`].
    pub fn mirror(prefix: &str, root: &Path) -> Result<Self, LinkError> {
        Self::open(prefix, root, Role::Creates, &[], &|_| true)
    }

    fn open(
        prefix: &str,
        root: &Path,
        role: Role,
        inputs: &[TopicId],
        produces: &dyn Fn(&TopicInfo) -> bool,
    ) -> Result<Self, LinkError> {
        set_log_level(iceoryx2::prelude::LogLevel::Fatal);
        let node = NodeBuilder::new()
            .config(&config(prefix, root)?)
            .signal_handling_mode(SignalHandlingMode::Disabled)
            .create::<Service>()
            .map_err(|error| LinkError::Node(text(error)))?;
        if role == Role::Opens {
            // Who died before us is buried before we take its place.
            node.blocking_cleanup_dead_nodes(Duration::from_secs(1));
        }
        let mut builder = PortsBuilder { node: &node, produces, inputs, role, ports: Vec::new(), error: None };
        for_each_topic(&mut builder);
        if let Some(error) = builder.error {
            return Err(error);
        }
        let ports = builder.ports;
        let wakes = PartitionId::ALL.iter().map(|&of| wake_service(&node, of, role)).collect::<Result<Vec<_>, _>>()?;
        Ok(ShmLink { ports, listener: None, notifiers: Vec::new(), wakes, node })
    }

    /// Sleeps until somebody wakes this partition or `timeout` has passed.
    ///
    /// # Errors
    /// When the listener fails.
    pub fn wait(&self, timeout: Duration) -> Result<(), LinkError> {
        let fail = |reason: String| LinkError::Transport { topic: "wake", operation: "wait", reason };
        let Some(listener) = &self.listener else {
            std::thread::sleep(timeout);
            return Ok(());
        };
        // A WaitSet of this one attachment would take memory at every wait.
        match listener.timed_wait(|_| {}, timeout) {
            // A stopped process that goes on is woken by the signal.
            Ok(_) | Err(ListenerWaitError::InterruptSignal) => Ok(()),
            Err(error) => Err(fail(text(error))),
        }
    }

    /// Frees what dead processes of this run left.
    pub fn bury_the_dead(&self) {
        self.node.try_cleanup_dead_nodes();
    }
}

impl Link for ShmLink {
    fn publish(&mut self, topic: TopicId, stamps: &Stamps, payload: &[u8]) -> Result<(), LinkError> {
        self.ports[topic].publish(stamps, payload).map_err(|reason| transport(topic, "send", reason))
    }

    fn drain(&mut self, topic: TopicId, sink: &mut dyn FnMut(&Stamps, &[u8])) -> Result<(), LinkError> {
        self.ports[topic].drain(sink).map_err(|reason| transport(topic, "receive", reason))
    }

    fn refresh(&mut self) -> Result<(), LinkError> {
        self.ports
            .iter()
            .enumerate()
            .try_for_each(|(topic, ports)| ports.refresh().map_err(|reason| transport(topic, "update", reason)))
    }

    fn wake(&mut self, partition: PartitionId) {
        // A partition that is down has no listener: nobody to wake, nothing to report.
        if let Some(notifier) = self.notifiers.get(usize::from(partition.code())) {
            let _ = notifier.notify();
        }
    }

    fn now_ns(&self) -> u64 {
        crate::sys::monotonic_ns()
    }
}

fn transport(topic: TopicId, operation: &'static str, reason: String) -> LinkError {
    LinkError::Transport { topic: TOPICS[topic].name, operation, reason }
}

/// A private prefix and root: never the machine-wide defaults.
fn config(prefix: &str, root: &Path) -> Result<Config, LinkError> {
    let mut config = Config::default();
    config.global.prefix = FileName::new(prefix.as_bytes()).map_err(|error| LinkError::Node(text(error)))?;
    let root = IoxPath::new(root.as_os_str().as_encoded_bytes()).map_err(|error| LinkError::Node(text(error)))?;
    config.global.set_root_path(&root);
    Ok(config)
}

struct PortsBuilder<'a> {
    node: &'a Node<Service>,
    produces: &'a dyn Fn(&TopicInfo) -> bool,
    inputs: &'a [TopicId],
    role: Role,
    ports: Vec<Box<dyn Ports>>,
    error: Option<LinkError>,
}

impl TopicVisitor for PortsBuilder<'_> {
    fn visit<T: Sample>(&mut self, topic: Topic<T>, info: &'static TopicInfo) {
        if self.error.is_some() {
            return;
        }
        match self.ports::<T>(topic, info) {
            Ok(ports) => self.ports.push(Box::new(ports)),
            Err(error) => self.error = Some(error),
        }
    }
}

impl PortsBuilder<'_> {
    fn ports<T: Sample>(&self, topic: Topic<T>, info: &'static TopicInfo) -> Result<TypedPorts<T>, LinkError> {
        let service = sample_service::<T>(self.node, info, self.role)?;
        let fail = |operation| move |reason| LinkError::Transport { topic: info.name, operation, reason };
        let publisher = (self.produces)(info)
            .then(|| retry(self.node, || service.publisher_builder().max_loaned_samples(2).create()))
            .transpose()
            .map_err(fail("publisher"))?;
        let subscriber = self
            .inputs
            .contains(&topic.id)
            .then(|| retry(self.node, || service.subscriber_builder().buffer_size(info.depth).create()))
            .transpose()
            .map_err(fail("subscriber"))?;
        Ok(TypedPorts { _service: service, publisher, subscriber })
    }
}

/// A port of a predecessor that is dead but not buried yet stands in the way for a moment.
fn retry<T, E: Debug>(node: &Node<Service>, mut create: impl FnMut() -> Result<T, E>) -> Result<T, String> {
    let since = Instant::now();
    loop {
        match create() {
            Ok(port) => return Ok(port),
            Err(error) if since.elapsed() > CREATE_RETRY => return Err(text(error)),
            Err(_) => {
                node.blocking_cleanup_dead_nodes(Duration::from_millis(50));
            }
        }
    }
}
