//! Work that takes longer than a frame, beside the loop: the partition itself goes to a thread and
//! comes back.
//!
//! Meanwhile the loop beats, listens and does no frame, so that results are those of one thread.
//! The thread takes its memory once; sending there and back takes none.

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

#[cfg(test)]
mod tests {
    use super::Worker;
    use crate::partition::{Frame, Outputs, Partition, StateError};
    use telemetry::{EVENT, Event, PartitionId, Sample, TopicId};

    /// Leaves work that publishes one event, or that panics.
    struct Toy {
        panics: bool,
        due: bool,
    }

    impl Partition for Toy {
        fn id(&self) -> PartitionId {
            PartitionId::ModalId
        }
        fn inputs(&self) -> &'static [TopicId] {
            &[]
        }
        fn frame(&mut self, _: &Frame<'_>, _: &mut Outputs) {}
        fn has_work(&self) -> bool {
            self.due
        }
        fn work(&mut self, out: &mut Outputs) {
            assert!(!self.panics, "on purpose");
            self.due = false;
            out.publish(EVENT, &Event::zeroed_at(5));
        }
        fn save(&mut self, _: &mut Vec<u8>) -> Result<(), StateError> {
            Ok(())
        }
        fn restore(&mut self, _: &[u8]) -> Result<(), StateError> {
            Ok(())
        }
    }

    #[test]
    fn a_partition_comes_back_with_its_work_done_and_published_every_time() {
        let worker = Worker::start();
        for _ in 0..3 {
            assert!(worker.send(Box::new(Toy { panics: false, due: true }), Outputs::default()).is_ok());
            let Ok((partition, mut outputs)) = worker.receive() else { panic!("the worker ended") };
            let mut topics = Vec::new();
            outputs.for_each(|topic, _| topics.push(topic));
            assert_eq!((partition.has_work(), topics), (false, vec![EVENT.id]));
        }
    }

    #[test]
    fn work_that_panics_ends_the_worker_and_whoever_waits_for_it_learns_so() {
        let worker = Worker::start();
        assert!(worker.send(Box::new(Toy { panics: true, due: true }), Outputs::default()).is_ok());
        assert!(worker.receive().is_err());
    }
}
