//! How the process of a partition is started.

use crate::life::Life;
use std::os::unix::process::CommandExt;
use std::path::PathBuf;
use std::process::{Command, Stdio};
use telemetry::PartitionId;

/// How partitions are started.
#[derive(Clone, Debug)]
pub struct Launcher {
    /// `program partition NAME --run FOLDER --epoch N --cause C` ...
    pub program: PathBuf,
    /// ... or, as in an on-board computer's image,
    /// `images/obsid-NAME --run FOLDER --epoch N --cause C`.
    pub images: Option<PathBuf>,
    /// The source's image is that of the gateway.
    pub is_fed: bool,
}

impl Launcher {
    pub(super) fn command(&self, id: PartitionId, folder: &std::path::Path, life: Life) -> Command {
        let mut command = match &self.images {
            Some(images) if self.is_fed && id == PartitionId::SensorSim => Command::new(images.join("obsid-gateway")),
            Some(images) => Command::new(images.join(format!("obsid-{id}"))),
            None => Command::new(&self.program),
        };
        if self.images.is_none() {
            command.args(["partition", id.text()]);
        }
        let (epoch, cause, parent) = (life.epoch.to_string(), life.cause.to_string(), std::process::id().to_string());
        command.arg("--run").arg(folder).args(["--epoch", &epoch, "--cause", &cause, "--parent", &parent]);
        // A service manager watches the warden, which watches the partitions.
        command.process_group(0).env_remove("NOTIFY_SOCKET");
        match id {
            PartitionId::Supervisor => command.stdin(Stdio::piped()).stdout(Stdio::piped()),
            _ => command.stdin(Stdio::null()).stdout(Stdio::null()),
        };
        command
    }
}
