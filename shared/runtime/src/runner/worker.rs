//! Work that takes longer than a frame, beside the loop: the partition itself goes to a thread and
//! comes back.
//!
//! Meanwhile the loop beats, listens and does no frame, so that results are those of one thread. The
//! thread takes its memory once; sending there and back takes none.

use crate::partition::{Outputs, Partition};
use crossbeam::channel::{Receiver, Sender, TryRecvError, bounded};

/// The partition, and what its work has published.
type Travels = (Box<dyn Partition>, Outputs);

/// The thread.
pub(super) struct Worker {
    there: Sender<Travels>,
    back: Receiver<Travels>,
}

/// The thread ended by a panic.
pub(super) struct WorkerEnded;

impl Worker {
    pub fn start() -> Self {
        let (there, arrivals) = bounded::<Travels>(1);
        let (departures, back) = bounded(1);
        std::thread::spawn(move || {
            for (mut partition, mut outputs) in arrivals {
                partition.work(&mut outputs);
                if departures.send((partition, outputs)).is_err() {
                    break;
                }
            }
        });
        Worker { there, back }
    }

    pub fn send(&self, partition: Box<dyn Partition>, outputs: Outputs) -> Result<(), WorkerEnded> {
        self.there.send((partition, outputs)).map_err(|_| WorkerEnded)
    }

    /// `None` while it works.
    pub fn try_receive(&self) -> Result<Option<Travels>, WorkerEnded> {
        match self.back.try_recv() {
            Ok(travels) => Ok(Some(travels)),
            Err(TryRecvError::Empty) => Ok(None),
            Err(TryRecvError::Disconnected) => Err(WorkerEnded),
        }
    }

    /// Waits for its end.
    pub fn receive(&self) -> Result<Travels, WorkerEnded> {
        self.back.recv().map_err(|_| WorkerEnded)
    }
}
