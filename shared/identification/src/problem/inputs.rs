//! What drives a run: held commands, motions with their derivatives, signals of the plant.

use super::ProblemError;
use super::smooth::SmoothMotion;
use channels::Channel;
use dynamics::description::{Actuator, ActuatorKind, Plant, Prescribed};
use dynamics::signal::{SignalSum, SignalValue};

/// A motion as a smooth function of time.
#[derive(Clone, Debug)]
pub enum Course {
    /// As the plant states it.
    Stated(SignalSum),
    /// Behind the samples of a recording.
    Recorded(SmoothMotion),
}

impl Course {
    /// Value and derivatives at `t_s` \[s\].
    pub fn at(&self, t_s: f64) -> SignalValue {
        match self {
            Self::Stated(signal) => signal.at(t_s),
            Self::Recorded(motion) => motion.at(t_s),
        }
    }
}

/// What one actuator does in a run.
#[derive(Clone, Debug)]
pub enum Drive {
    /// Holds each value from its stamp on; before the first: zero.
    Held { time_s: Vec<f64>, value: Vec<f64> },
    /// A command that the plant states as a signal, held over steps of the sampling.
    Signal(SignalSum),
    /// A motion, its stated derivative as a smooth function of time; position and rate at the
    /// beginning of the run.
    Motion { course: Course, what: Prescribed, from: [f64; 2] },
}

pub(super) fn drive(
    plant: &Plant,
    actuator: &Actuator,
    channel: Option<&Channel>,
    recording: &str,
    (begin_s, end_s): (f64, f64),
) -> Result<Drive, ProblemError> {
    let what = match actuator.kind {
        ActuatorKind::PrescribedJoint { what, .. } | ActuatorKind::PrescribedBase { what, .. } => Some(what),
        _ => None,
    };
    let bad = |error: dynamics::signal::SignalError| ProblemError::Plant(error.to_string());
    let own = || SignalSum::new(&actuator.command, plant.simulation.duration_s, &actuator.name).map_err(bad);
    let Some(channel) = channel else {
        return Ok(match what {
            None => Drive::Signal(own()?),
            Some(what) => Drive::Motion { course: Course::Stated(own()?), what, from: [0.0; 2] },
        });
    };
    let (mut time_s, mut value) = (Vec::new(), Vec::new());
    for i in channel.finite() {
        let t = channel.time_s[i];
        if time_s.last().is_none_or(|last| t > *last) {
            time_s.push(t);
            value.push(channel.value[i]);
        }
    }
    if time_s.len() < 2 {
        let (recording, channel) = (recording.to_owned(), channel.name.clone());
        return Err(ProblemError::Empty { recording, channel, begin_s, end_s });
    }
    let Some(what) = what else { return Ok(Drive::Held { time_s, value }) };
    let course = Course::Recorded(SmoothMotion::new(&time_s, &value));
    Ok(Drive::Motion { course, what, from: [0.0; 2] })
}

impl Drive {
    /// A command that the plant states takes the numbers that `plant` has for it.
    pub(super) fn renew(&mut self, plant: &Plant, actuator: &Actuator) {
        if let Self::Signal(signal) = self
            && let Ok(fresh) = SignalSum::new(&actuator.command, plant.simulation.duration_s, &actuator.name)
        {
            *signal = fresh;
        }
    }

    /// Held command at `t_s`; of a motion nothing.
    pub fn held_at(&self, t_s: f64) -> f64 {
        match self {
            Self::Held { time_s, value } => {
                let after = time_s.partition_point(|stamp| *stamp <= t_s + 1e-9);
                if after == 0 { 0.0 } else { value[after - 1] }
            }
            Self::Signal(signal) => signal.at(t_s).value,
            Self::Motion { .. } => 0.0,
        }
    }
}
