//! The closed-loop simulator of any plant: readings, controllers, held inputs, motion, one control
//! period at a time.
//!
//! In each period, beginning at `t_k`: controllers read their (noisy) sensors and command; commands
//! are held through the period, past range, delay and lag of their actuators; the state moves; and
//! every sensor whose instant falls into the period gives its sample. A sensor that feels an input
//! (a torque sensor, an accelerometer) is read just after the input has switched.
//!
//! Commands given as signals are held at their value in the *middle* of the period; references of
//! controllers are taken at its beginning; prescribed motions are continuous.
//!
//! Equal plant, seed and prefix give equal bits; noise belongs to (seed, stream name, sample
//! number), streams are named `PREFIX.SENSOR` and `PREFIX.ACTUATOR`. [`Simulator::state`] holds
//! everything that changes.

use crate::SimulationError;
use crate::control::Controllers;
use crate::excitation::ExcitedClock;
use crate::history::{History, PieceStart, Widths};
use crate::inputs::{Inputs, InputsState};
use crate::integrator::{self, Stepper};
use crate::motion::{Dynamics, Origin};
use crate::sensing::{Sample, Sensors, SensorsState};
use dynamics::description::{ActuatorKind, Initial, Integrator, Plant, SimulationSettings};
use dynamics::effect::apply_structures;
use dynamics::system::{System, SystemError, Totals, Workspace};
use serde::{Deserialize, Serialize};

/// What one control period brought.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Row {
    /// Beginning of the period, plant time \[s\].
    pub time_s: f64,
    /// Ordered by channel, then time. A sensor slower than the period is missing in some rows, a
    /// faster one is here several times; a mean is here once its interval is complete.
    pub samples: Vec<Sample>,
    /// Command of each actuator as a recording shows it: limited, before delay and lag; of a
    /// prescribed motion the stated derivative at `time_s`.
    pub commands: Vec<f64>,
    /// `u` at the beginning of the period, in the order of [`System::inputs`]: what acts.
    pub inputs: Vec<f64>,
}

impl Row {
    /// First sample of channel `channel` (index in `Plant::sensors`) in this row.
    pub fn sample(&self, channel: usize) -> Option<&Sample> {
        self.samples.iter().find(|sample| sample.channel == channel)
    }

    /// Its measured value; NaN where this row has none.
    pub fn value(&self, channel: usize) -> f64 {
        self.sample(channel).map_or(f64::NAN, |sample| sample.value)
    }
}

/// Everything that changes: with plant, seed and prefix it determines the future.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SimulatorState {
    present: Present,
    /// The recent past, where a sensor reaches back into it.
    history: Option<History>,
}

/// Of the present instant.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Present {
    /// Plant time at which sample 0 lies [s].
    start_s: f64,
    /// Number of periods since; and of those that were excited.
    sample: u64,
    excited_sample: u64,
    excited: bool,
    x: Vec<f64>,
    u: Vec<f64>,
    integrals: Vec<f64>,
    inputs: InputsState,
    sensors: SensorsState,
}

/// Noise-free values at the present instant, i.e. of the beginning of the next period, with the
/// inputs of the last one; momentum and energy: [`Simulator::totals`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Truth<'a> {
    pub time_s: f64,
    /// In the order of [`System::states`].
    pub state: &'a [f64],
    /// One per sensor, without noise, lag, delay, range, quantisation.
    pub readings: &'a [f64],
}

/// The simulator.
pub struct Simulator {
    plant: Plant,
    dynamics: Dynamics,
    controllers: Controllers,
    sensors: Sensors,
    history: History,
    period_s: f64,
    warning: Option<String>,
    state: Present,
    row: Row,
    /// Readings of the present instant, at the beginning and at the end of a piece; what the
    /// controllers read.
    y: [Vec<f64>; 2],
    feedback: Vec<f64>,
    /// Channels that some controller reads, each once.
    fed_back: Vec<usize>,
}

impl Simulator {
    /// Simulator of `plant` in its initial state at t = 0. Noise streams are named
    /// `{stream_prefix}.{sensor or actuator}`.
    ///
    /// # Errors
    /// See [`SimulationError`].
    pub fn new(plant: &Plant, seed: u64, stream_prefix: &str) -> Result<Self, SimulationError> {
        let settings = &plant.simulation;
        check_positive("simulation.period", settings.period_s)?;
        check_positive("simulation.step", settings.step_s)?;
        let controllers = Controllers::new(plant)?;
        // clocks, ranges and resolutions are read from the description
        let described = plant;
        let mut built = plant.clone();
        apply_structures(&mut built).map_err(SystemError::from)?;
        let plant = &built;
        let mut system = System::new(plant)?;
        let chosen = integrator::choose(described, &system)?;
        if chosen.step_s != settings.step_s {
            // laws with states of their own receive the step
            let finer = SimulationSettings { step_s: chosen.step_s, ..settings.clone() };
            system = System::new(&Plant { simulation: finer, ..plant.clone() })?;
        }
        let sensors = Sensors::new(plant, &system, seed, stream_prefix)?;
        let exact = chosen.integrator == Integrator::ExactZeroOrderHold;
        // the exact hold needs no fine steps, and its bits should not depend on the sensors
        let fine = sensors.follows_lags() && !exact;
        let inputs = Inputs::new(plant, &system, (fine, chosen.step_s), seed, stream_prefix)?;
        let state = start(plant, &system, &controllers, &inputs, &sensors, (0.0, &plant.initial))?;
        if let (Some(actuator), true) = (inputs.prescribed_actuator(), exact) {
            return Err(SimulationError::NotHeld { actuator: plant.actuators[actuator].name.clone() });
        }
        let lengths_s: Vec<f64> = inputs.pieces().iter().map(|piece| piece.length_s).collect();
        let point = (0.0, &state.x[..], &state.u[..]);
        let stepper = Stepper::new(&system, chosen.integrator, chosen.step_s, point, &lengths_s)?;
        let history = new_history(&state, &sensors, &inputs, settings.period_s);
        let outputs = plant.sensors.len();
        let mut fed_back: Vec<usize> = controllers.sensors().collect();
        fed_back.sort_unstable();
        fed_back.dedup();
        let row = Row {
            time_s: 0.0,
            samples: Vec::with_capacity(sensors.samples_max(settings.period_s)),
            commands: vec![0.0; plant.actuators.len()],
            inputs: state.u.clone(),
        };
        Ok(Self {
            plant: plant.clone(),
            period_s: settings.period_s,
            warning: chosen.instead,
            dynamics: Dynamics { workspace: Workspace::new(&system), system, stepper, inputs },
            controllers,
            sensors,
            history,
            state,
            row,
            y: [vec![0.0; outputs], vec![0.0; outputs]],
            feedback: vec![0.0; outputs],
            fed_back,
        })
    }

    /// From now on noise comes from the streams that [`Simulator::new`] names for `seed` and
    /// `stream_prefix`: a simulator that has not moved is the one built with them. Takes no memory.
    pub fn draw_from(&mut self, seed: u64, stream_prefix: &str) {
        self.sensors.draw_from(&self.plant, seed, stream_prefix);
        self.dynamics.inputs.draw_from(&self.plant, seed, stream_prefix);
    }

    /// Simulates one control period and returns what it brought.
    ///
    /// Cost: an integration over the period, one reading of all sensors per instant at which some
    /// sample lies, and one inverse dynamics where a controller feeds forward; no allocation.
    pub fn step(&mut self) -> &Row {
        let (begin_s, end_s) = (self.time_at(self.state.sample), self.time_at(self.state.sample + 1));
        let clock = ExcitedClock {
            begin_s,
            excited_begin_s: self.state.start_s + self.state.excited_sample as f64 * self.period_s,
            running: self.state.excited,
        };
        self.row.time_s = begin_s;
        self.row.samples.clear();
        self.command(&clock);
        self.advance(&clock, end_s);
        let times = (self.state.start_s, end_s);
        let Self { dynamics, sensors, history, state, row, .. } = self;
        sensors.sample(dynamics, history, &mut state.sensors, times, &mut row.samples);
        self.state.sample += 1;
        self.state.excited_sample += u64::from(self.state.excited);
        &self.row
    }

    /// What the last period brought.
    pub fn row(&self) -> &Row {
        &self.row
    }

    /// Plant time at the beginning of the next period \[s\].
    pub fn time_s(&self) -> f64 {
        self.time_at(self.state.sample)
    }

    /// `false` freezes references and prescribed positions where they stand, asks for zero rates
    /// and commands nothing; the clock of signals stands still until it is excited again.
    pub fn set_excited(&mut self, excited: bool) {
        self.state.excited = excited;
    }

    /// Noise-free values at the present instant.
    pub fn truth(&mut self) -> Truth<'_> {
        let time_s = self.time_s();
        self.dynamics.read(time_s, &self.state.x, &self.state.u, &mut self.y[0]);
        Truth { time_s, state: &self.state.x, readings: &self.y[0] }
    }

    /// Momentum and energy at the present instant, with the inputs of the last period.
    pub fn totals(&mut self) -> Totals<f64> {
        let Dynamics { system, workspace, .. } = &mut self.dynamics;
        system.totals(workspace, &self.state.x, &self.state.u)
    }

    /// Whether there is more to simulate.
    ///
    /// # Errors
    /// [`SimulationError::NotFinite`].
    pub fn check_finite(&self) -> Result<(), SimulationError> {
        let Some(at) = self.state.x.iter().position(|x| !x.is_finite()) else { return Ok(()) };
        let state = self.dynamics.system.states()[at].name.clone();
        Err(SimulationError::NotFinite { time_s: self.time_s(), state })
    }

    /// What is simulated otherwise than the plant states, and why.
    pub fn warning(&self) -> Option<&str> {
        self.warning.as_deref()
    }

    /// The equations that are simulated.
    pub fn system(&self) -> &System {
        &self.dynamics.system
    }

    /// The changing part, for a checkpoint: the bytes of a [`SimulatorState`], without a copy.
    pub fn state(&self) -> impl Serialize + '_ {
        let reaches_back = self.sensors.span_s() > 0.0;
        (&self.state, reaches_back.then_some(&self.history))
    }

    /// Continues from a checkpoint of a simulator built with the same plant, seed and prefix, with
    /// equal bits.
    ///
    /// # Errors
    /// [`SimulationError::ForeignState`]: the checkpoint is of another plant.
    pub fn restore(&mut self, state: &SimulatorState) -> Result<(), SimulationError> {
        let SimulatorState { present: state, history } = state;
        let own = &self.state;
        for (what, got, expected) in [
            ("state", state.x.len(), own.x.len()),
            ("input", state.u.len(), own.u.len()),
            ("controllers", state.integrals.len(), own.integrals.len()),
            ("sensors", state.sensors.channels.len(), own.sensors.channels.len()),
            ("sensor lags", state.sensors.lags.len(), own.sensors.lags.len()),
            ("actuators", usize::from(self.dynamics.inputs.matches(&state.inputs)), 1),
        ] {
            if got != expected {
                return Err(SimulationError::ForeignState { what, got, expected });
            }
        }
        self.history.clear();
        if let Some(history) = history {
            if !history.same_shape(&self.history) {
                return Err(SimulationError::ForeignState { what: "history", got: 0, expected: 1 });
            }
            self.history.clone_from(history);
        }
        self.state.clone_from(state);
        Ok(())
    }

    /// Begins a new segment at `start_s` with its own initial state; nothing is commanded yet,
    /// filters and integrals are empty. What effects remember stays as it is: propellant that is
    /// gone is gone.
    ///
    /// # Errors
    /// A coordinate that does not exist.
    pub fn restart(&mut self, start_s: f64, initial: &Initial) -> Result<(), SimulationError> {
        let Dynamics { system, inputs, .. } = &self.dynamics;
        let mut state = start(&self.plant, system, &self.controllers, inputs, &self.sensors, (start_s, initial))?;
        let hidden = system.hidden_states();
        state.x[hidden.clone()].copy_from_slice(&self.state.x[hidden]);
        inputs.keep_effects(&self.state.inputs, &mut state.inputs);
        self.state = state;
        self.history.clear();
        Ok(())
    }

    fn time_at(&self, sample: u64) -> f64 {
        self.state.start_s + sample as f64 * self.period_s
    }

    /// Feedback, controllers, signals: what is commanded in this period.
    fn command(&mut self, clock: &ExcitedClock) {
        self.row.commands.fill(0.0);
        let begin_s = clock.begin_s;
        if !self.fed_back.is_empty() {
            let state = &mut self.state;
            let origin = Origin { begin_s, clock, motions: &state.inputs.motions };
            self.dynamics.prescribe(&origin, begin_s, &mut state.u);
            self.dynamics.read_some(begin_s, &state.x, &state.u, &self.fed_back, &mut self.y[0]);
            for index in &self.fed_back {
                let times = (state.start_s, begin_s);
                let (dynamics, history) = (&mut self.dynamics, &self.history);
                self.feedback[*index] =
                    self.sensors.feedback(dynamics, history, &mut state.sensors, *index, times, &self.y[0]);
            }
        }
        let Self { controllers, dynamics, feedback, state, row, period_s, .. } = self;
        controllers.command(clock, *period_s, feedback, &mut state.integrals, &mut row.commands);
        dynamics.inputs.begin_period(&mut state.inputs, clock, *period_s, state.sample, &mut row.commands);
    }

    /// Moves the state through the pieces of the period.
    fn advance(&mut self, clock: &ExcitedClock, end_s: f64) {
        let follows_lags = self.sensors.follows_lags();
        let pieces = self.dynamics.inputs.pieces().len();
        // an instantaneous sensor is read where the period begins: the first slope is computed
        // there anyway
        let reads_beginning = pieces == 1 && !follows_lags && self.sensors.read_beginnings();
        self.sensors.forget();
        for index in 0..pieces {
            let piece = self.dynamics.inputs.pieces()[index];
            let begin_s = clock.begin_s + piece.offset_s;
            let state = &mut self.state;
            self.dynamics.inputs.hold(&mut state.inputs, piece, &mut state.u);
            let origin = Origin { begin_s, clock, motions: &state.inputs.motions };
            self.dynamics.prescribe(&origin, begin_s, &mut state.u);
            if index == 0 {
                self.row.inputs.copy_from_slice(&state.u);
            }
            let [y_begin, y_end] = &mut self.y;
            if follows_lags || (!state.sensors.settled && self.sensors.lag_count() > 0) {
                self.dynamics.read(begin_s, &state.x, &state.u, y_begin);
            }
            if !state.sensors.settled {
                self.sensors.settle(&mut state.sensors, y_begin);
            }
            self.history.push(&PieceStart {
                begin_s,
                clock: *clock,
                x: &state.x,
                u: &state.u,
                motions: &state.inputs.motions,
                lags: &state.sensors.lags,
                y: y_begin,
            });
            let reading = reads_beginning.then_some(&mut y_end[..]);
            let span = (begin_s, piece.length_s);
            if self.dynamics.advance_and_read(&origin, span, &mut state.x, &mut state.u, reading) {
                self.sensors.know(begin_s, self.history.newest(), y_end);
            }
            let piece_end_s = begin_s + piece.length_s;
            if follows_lags {
                self.dynamics.read(piece_end_s, &state.x, &state.u, y_end);
                self.sensors.follow(&mut state.sensors, y_begin, y_end, piece.length_s);
            }
            self.dynamics.inputs.advance_motions(&mut state.inputs, clock, begin_s, piece_end_s);
        }
        self.history.close(end_s, &self.state.x);
    }
}

fn check_positive(what: &str, value: f64) -> Result<(), SimulationError> {
    if value > 0.0 && value.is_finite() {
        return Ok(());
    }
    Err(SimulationError::Setting { what: what.to_owned(), value, why: "must be positive" })
}

/// State at `start_s`: nothing commanded yet.
fn start(
    plant: &Plant,
    system: &System,
    controllers: &Controllers,
    inputs: &Inputs,
    sensors: &Sensors,
    (start_s, initial): (f64, &Initial),
) -> Result<Present, SimulationError> {
    let (inputs_state, rest) = inputs.start(initial);
    let references = |name: &str| {
        let prescribes =
            |kind: &ActuatorKind| matches!(kind, ActuatorKind::PrescribedJoint { joint, .. } if joint == name);
        let prescribed = plant.actuators.iter().position(|actuator| prescribes(&actuator.kind));
        match prescribed {
            Some(actuator) => inputs.initial_motion(&inputs_state, actuator, start_s),
            None if initial.on_reference => controllers.joint_reference(name, start_s),
            None => None,
        }
    };
    let x = system.initial_state(&rest, &references)?;
    let mut u = vec![0.0; system.inputs().len()];
    let clock = ExcitedClock { begin_s: start_s, excited_begin_s: start_s, running: true };
    inputs.prescribe(&inputs_state.motions, &clock, start_s, start_s, &mut u);
    Ok(Present {
        start_s,
        sample: 0,
        excited_sample: 0,
        excited: true,
        x,
        u,
        integrals: vec![0.0; controllers.len()],
        inputs: inputs_state,
        sensors: sensors.start(),
    })
}

/// Room for one period and for what the sensors reach back to.
fn new_history(state: &Present, sensors: &Sensors, inputs: &Inputs, period_s: f64) -> History {
    let widths = Widths {
        x: state.x.len(),
        u: state.u.len(),
        motions: state.inputs.motions.len(),
        lags: sensors.lag_count(),
        y: if sensors.follows_lags() { sensors.channels.len() } else { 0 },
    };
    let periods = libm::ceil(sensors.span_s() / period_s) as usize + 2;
    History::new(widths, periods * inputs.pieces().len())
}
