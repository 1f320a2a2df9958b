//! The line: a zenoh session between two ends that know each other's address.
//!
//! No discovery: nothing is sent to an address that was not given. zenoh connects again by itself;
//! what it drops meanwhile is sent again by `delivery`.

use crate::{BridgeError, End};
use std::sync::mpsc::{Receiver, TrySendError, sync_channel};
use zenoh::Wait;
use zenoh::pubsub::{Publisher, Subscriber};
use zenoh::qos::CongestionControl;

/// What each end publishes.
const OF_LISTENER: &str = "obsid/bridge/listener";
const OF_CONNECTOR: &str = "obsid/bridge/connector";
/// Messages that wait for the next look; more are dropped, and sent again.
const WAITING_MAX: usize = 4096;

/// One end.
pub struct Line {
    publisher: Publisher<'static>,
    received: Receiver<Vec<u8>>,
    // Held: they end with it.
    _subscriber: Subscriber<()>,
    _session: zenoh::Session,
}

impl Line {
    /// Listens, or connects as soon as the other end is there.
    ///
    /// # Errors
    /// When the endpoint cannot be used.
    pub fn open(end: &End) -> Result<Self, BridgeError> {
        let (endpoint, own, others) = match end {
            End::Listen(endpoint) => (endpoint, OF_LISTENER, OF_CONNECTOR),
            End::Connect(endpoint) => (endpoint, OF_CONNECTOR, OF_LISTENER),
        };
        let fail = |error: zenoh::Error| BridgeError::Line { endpoint: endpoint.clone(), reason: error.to_string() };
        let session = zenoh::open(config(end).map_err(fail)?).wait().map_err(fail)?;
        let (sender, received) = sync_channel(WAITING_MAX);
        let take = move |sample: zenoh::sample::Sample| match sender.try_send(sample.payload().to_bytes().into_owned())
        {
            Ok(()) | Err(TrySendError::Full(_) | TrySendError::Disconnected(_)) => {}
        };
        let subscriber = session.declare_subscriber(others).callback(take).wait().map_err(fail)?;
        // Never wait for the line.
        let publisher = session.declare_publisher(own).congestion_control(CongestionControl::Drop).express(true);
        let publisher = publisher.wait().map_err(fail)?;
        Ok(Line { publisher, received, _subscriber: subscriber, _session: session })
    }

    /// Sends, or drops where there is no way.
    pub fn send(&self, message: Vec<u8>) {
        // What is not acknowledged is sent again, whatever the reason.
        let _ = self.publisher.put(message).wait();
    }

    /// The oldest message that has come and was not taken.
    pub fn received(&self) -> Option<Vec<u8>> {
        self.received.try_recv().ok()
    }
}

fn config(end: &End) -> Result<zenoh::Config, zenoh::Error> {
    let (listen, connect) = match end {
        End::Listen(endpoint) => (vec![endpoint], vec![]),
        End::Connect(endpoint) => (vec![], vec![endpoint]),
    };
    let list = |endpoints: Vec<&String>| serde_json::json!(endpoints).to_string();
    let mut config = zenoh::Config::default();
    for (key, value) in [
        ("mode", "\"peer\"".into()),
        ("listen/endpoints", list(listen)),
        ("connect/endpoints", list(connect)),
        ("scouting/multicast/enabled", "false".into()),
        ("scouting/gossip/enabled", "false".into()),
    ] {
        config.insert_json5(key, &value)?;
    }
    Ok(config)
}
