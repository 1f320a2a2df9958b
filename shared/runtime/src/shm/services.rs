//! The services of a run: made by the supervisor, opened by everybody else, of one build or not at
//! all.

use super::{Role, Service, text};
use crate::link::LinkError;
use iceoryx2::node::Node;
use iceoryx2::prelude::{AttributeSpecifier, AttributeVerifier, MessagingPattern, SemanticString, ServiceName};
use iceoryx2::service::Service as _;
use iceoryx2::service::attribute::{AttributeKey, AttributeValue};
use iceoryx2::service::builder::event::EventOpenError;
use iceoryx2::service::builder::publish_subscribe::PublishSubscribeOpenError;
use iceoryx2::service::port_factory::event::PortFactory as EventFactory;
use iceoryx2::service::port_factory::publish_subscribe::PortFactory as SampleFactory;
use telemetry::{PartitionId, Sample, Stamps, TopicInfo};

const LAYOUT_KEY: &str = "layout";
/// Over the whole topic table and every list of codes: samples index topics by number.
const GENERATION_KEY: &str = "generation";
/// Every process of a run, the console's tools and dead ones that are not buried yet.
const NODES_MAX: usize = 20;

/// What two builds must agree on: key of an attribute, and its value here.
type Hashes = [(&'static str, u32); 2];

pub(super) fn sample_service<T: Sample>(
    node: &Node<Service>,
    info: &'static TopicInfo,
    role: Role,
) -> Result<SampleFactory<Service, T, Stamps>, LinkError> {
    let fail = |operation, reason| LinkError::Transport { topic: info.name, operation, reason };
    let name: ServiceName =
        format!("obs/{}", info.name).as_str().try_into().map_err(|error| fail("name", text(error)))?;
    let hashes = [(LAYOUT_KEY, info.layout), (GENERATION_KEY, telemetry::generation())];
    let builder = node.service_builder(&name).publish_subscribe::<T>().user_header::<Stamps>();
    if role == Role::Creates {
        let mut attributes = AttributeSpecifier::new();
        for (key, hash) in hashes {
            let (key, value) = attribute(key, hash).map_err(|reason| fail("attribute", reason))?;
            attributes = attributes.define(&key, &value).map_err(|error| fail("attribute", text(error)))?;
        }
        return builder
            .enable_safe_overflow(true)
            .history_size(info.depth)
            .subscriber_max_buffer_size(info.depth)
            .subscriber_max_borrowed_samples(2)
            .max_subscribers(PartitionId::COUNT + 2)
            .max_publishers(if info.producers == "all" { PartitionId::COUNT + 1 } else { 1 })
            .max_nodes(NODES_MAX)
            .create_with_attributes(&attributes)
            .map_err(|error| fail("create", text(error)));
    }
    let mut verifier = AttributeVerifier::new();
    for (key, hash) in hashes {
        let (key, value) = attribute(key, hash).map_err(|reason| fail("attribute", reason))?;
        verifier = verifier.require(&key, &value).map_err(|error| fail("attribute", text(error)))?;
    }
    builder.open_with_attributes(&verifier).map_err(|error| match error {
        PublishSubscribeOpenError::DoesNotExist | PublishSubscribeOpenError::IsMarkedForDestruction => {
            LinkError::Vanished { topic: info.name }
        }
        error => other_build(node, &name, info, hashes).unwrap_or_else(|| fail("open", text(error))),
    })
}

fn attribute(key: &str, hash: u32) -> Result<(AttributeKey, AttributeValue), String> {
    let value = format!("{hash:08x}").as_str().try_into().map_err(text)?;
    Ok((key.try_into().map_err(text)?, value))
}

/// Of a service that cannot be opened: which hash of another build it has, for that is what the
/// operator needs. A sample of another size is of another build, too.
fn other_build(
    node: &Node<Service>,
    name: &ServiceName,
    info: &'static TopicInfo,
    hashes: Hashes,
) -> Option<LinkError> {
    let details = Service::details(name, node.config(), MessagingPattern::PublishSubscribe).ok()??;
    hashes.into_iter().find_map(|(key, ours)| {
        let value = details.static_details.attributes().key_value(&key.try_into().ok()?, 0);
        let theirs =
            value.map_or(format!("no {key}"), |value| format!("{key} {}", String::from_utf8_lossy(value.as_bytes())));
        let differs = theirs != format!("{key} {ours:08x}");
        differs.then_some(LinkError::Layout { topic: info.name, what: key, ours, theirs })
    })
}

pub(super) fn wake_service(
    node: &Node<Service>,
    of: PartitionId,
    role: Role,
) -> Result<EventFactory<Service>, LinkError> {
    let fail = |operation, reason| LinkError::Transport { topic: "wake", operation, reason };
    let name: ServiceName = format!("obs/wake/{of}").as_str().try_into().map_err(|error| fail("name", text(error)))?;
    let builder =
        node.service_builder(&name).event().max_listeners(4).max_notifiers(PartitionId::COUNT + 4).max_nodes(NODES_MAX);
    match role {
        Role::Creates => builder.create().map_err(|error| fail("create", text(error))),
        Role::Opens => node.service_builder(&name).event().open().map_err(|error| match error {
            EventOpenError::DoesNotExist | EventOpenError::IsMarkedForDestruction => {
                LinkError::Vanished { topic: "wake" }
            }
            error => fail("open", text(error)),
        }),
    }
}
