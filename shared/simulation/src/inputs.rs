//! What acts on the plant: commands held over a control period, through range, delay, lag and
//! noise; and prescribed motions.
//!
//! A command is a signal at the *middle* instant of its period, so that a held sine follows the
//! sine without delay, plus what a controller commands. It is limited by the actuator's range,
//! passes the gates that effects put there, is delayed, lagged, and its noise added. Prescribed
//! motions are continuous: position, rate and acceleration belong together at every instant.

use super::SimulationError;
use super::excitation::ExcitedClock;
use dynamics::description::{Actuator, ActuatorKind, Initial, Plant, Prescribed};
use dynamics::lags::{FilterKind, Gate, HeldDelay, HeldDelayState, Lag, LagState};
use dynamics::noise::Stream;
use dynamics::signal::{SignalSum, SignalValue};
use dynamics::system::{FilterPlace, InputName, InputRole, System};
use serde::{Deserialize, Serialize};

/// A piece of a control period over which what is held acts unchanged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Piece {
    /// After the beginning of the period.
    pub offset_s: f64,
    pub length_s: f64,
}

/// A commanded actuator.
#[derive(Clone, Debug)]
struct Commanded {
    /// Index in `u`.
    input: usize,
    /// Index in `Plant::actuators`.
    actuator: usize,
    signal: SignalSum,
    limits: [f64; 2],
    gates: Vec<Gate>,
    delay: HeldDelay,
    lags: Vec<Lag>,
    sigma: f64,
    /// Makes no noise while its command is zero: a thruster that is shut.
    quiet_at_zero: bool,
    stream: Stream,
}

/// A motion imposed on a joint or on the base.
#[derive(Clone, Debug)]
struct PrescribedMotion {
    /// Indices of position, rate and acceleration in `u`.
    inputs: [usize; 3],
    actuator: usize,
    what: Prescribed,
    signal: SignalSum,
    /// Coordinate whose initial value starts what the signal does not state; `None`: of the base,
    /// from zero.
    coordinate: Option<String>,
}

/// What the inputs remember.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct InputsState {
    /// What the gates of all actuators remember, one after the other.
    gates: Vec<f64>,
    delays: Vec<HeldDelayState>,
    /// Of all actuators, one after the other.
    lags: Vec<LagState>,
    noise: Vec<f64>,
    /// Position and rate of each prescribed motion at the beginning of the present piece.
    pub motions: Vec<[f64; 2]>,
}

/// All inputs of a plant.
#[derive(Clone, Debug)]
pub(crate) struct Inputs {
    commanded: Vec<Commanded>,
    prescribed: Vec<PrescribedMotion>,
    pieces: Vec<Piece>,
}

/// The noise of an actuator.
fn noise_of(actuator: &Actuator, seed: u64, prefix: &str) -> Stream {
    Stream::of_parts(seed, &[prefix, ".", &actuator.name])
}

impl Inputs {
    /// Noise of other streams from now on: those that [`Inputs::new`] names for `seed` and
    /// `prefix`.
    pub fn draw_from(&mut self, plant: &Plant, seed: u64, prefix: &str) {
        for input in &mut self.commanded {
            input.stream = noise_of(&plant.actuators[input.actuator], seed, prefix);
        }
    }

    /// Inputs of `plant`; `fine` splits every period into integration steps of at most `step_s`,
    /// for sensors with lags.
    pub fn new(
        plant: &Plant,
        system: &System,
        (fine, step_s): (bool, f64),
        seed: u64,
        prefix: &str,
    ) -> Result<Self, SimulationError> {
        let duration_s = plant.simulation.duration_s;
        let (mut commanded, mut prescribed) = (Vec::new(), Vec::new());
        for (actuator, description) in plant.actuators.iter().enumerate() {
            let of = format!("actuator '{}'", description.name);
            let signal = SignalSum::new(&description.command, duration_s, &of)?;
            let inputs: Vec<usize> =
                system.inputs().iter().enumerate().filter(|(_, u)| u.actuator == actuator).map(|(i, _)| i).collect();
            if let Some(what) = prescribed_derivative(description) {
                let inputs = prescribed_inputs(system, &inputs);
                let coordinate = coordinate(description);
                prescribed.push(PrescribedMotion { inputs, actuator, what, signal, coordinate });
            } else if let [input] = inputs[..] {
                commanded.push(Commanded::new(plant, system, input, actuator, signal, (seed, prefix))?);
            }
        }
        let fine = fine || commanded.iter().any(|input: &Commanded| !input.lags.is_empty());
        let pieces = pieces(&commanded, plant.simulation.period_s, step_s, fine);
        Ok(Self { commanded, prescribed, pieces })
    }

    /// Pieces of every control period: split where a delayed command changes, and into integration
    /// steps where a lag moves.
    pub fn pieces(&self) -> &[Piece] {
        &self.pieces
    }

    /// The first actuator that prescribes a motion; `None` where all are forces.
    pub fn prescribed_actuator(&self) -> Option<usize> {
        self.prescribed.first().map(|motion| motion.actuator)
    }

    /// Nothing commanded yet, prescribed motions at their beginning; also the initial values that
    /// are not of such motions.
    pub fn start(&self, initial: &Initial) -> (InputsState, Initial) {
        let motions = self.prescribed.iter().map(|motion| motion.initial(initial)).collect();
        let mut rest = initial.clone();
        rest.values.retain(|value| !self.prescribed.iter().any(|motion| motion.integrates(&value.coordinate)));
        (InputsState { motions, ..self.empty() }, rest)
    }

    /// What effects remember of the commands before a new segment.
    pub fn keep_effects(&self, before: &InputsState, after: &mut InputsState) {
        after.gates.clone_from(&before.gates);
    }

    fn empty(&self) -> InputsState {
        InputsState {
            gates: vec![0.0; self.commanded.iter().map(|input| input.gates.len()).sum()],
            delays: self.commanded.iter().map(|input| input.delay.start()).collect(),
            lags: vec![LagState::default(); self.commanded.iter().map(|input| input.lags.len()).sum()],
            noise: vec![0.0; self.commanded.len()],
            motions: vec![[0.0; 2]; self.prescribed.len()],
        }
    }

    /// Limits what the controllers command plus the signals, and takes it for the period number
    /// `sample`.
    ///
    /// `commands`, one per actuator, holds the controllers' share on entry and, on return, what a
    /// recording shows: the command, or of a prescribed motion the stated derivative at the
    /// beginning of the period.
    pub fn begin_period(
        &self,
        state: &mut InputsState,
        clock: &ExcitedClock,
        period_s: f64,
        sample: u64,
        commands: &mut [f64],
    ) {
        let middle_s = clock.at(clock.begin_s + 0.5 * period_s);
        let mut held = state.gates.iter_mut();
        for (i, input) in self.commanded.iter().enumerate() {
            let signal = if clock.running { input.signal.at(middle_s).value } else { 0.0 };
            let command = (commands[input.actuator] + signal).clamp(input.limits[0], input.limits[1]);
            commands[input.actuator] = command;
            let mut passed = command;
            for gate in &input.gates {
                passed = gate.pass(held.next().expect("a number for every gate"), clock.begin_s, passed);
            }
            input.delay.push(&mut state.delays[i], passed);
            let acts = input.sigma > 0.0 && !(input.quiet_at_zero && passed == 0.0);
            state.noise[i] = if acts { input.sigma * input.stream.normal(sample) } else { 0.0 };
        }
        for motion in &self.prescribed {
            let at = motion.signal.at(clock.excited_begin_s).value;
            commands[motion.actuator] = if clock.running || motion.what == Prescribed::Position { at } else { 0.0 };
        }
    }

    /// What is held over `piece`, into the commanded entries of `u`; lags move on by its length.
    pub fn hold(&self, state: &mut InputsState, piece: Piece, u: &mut [f64]) {
        let mut lag_index = 0;
        for (i, input) in self.commanded.iter().enumerate() {
            let mut value = input.delay.at(&state.delays[i], piece.offset_s);
            for lag in &input.lags {
                value = lag.hold(&mut state.lags[lag_index], value, piece.length_s);
                lag_index += 1;
            }
            u[input.input] = value + state.noise[i];
        }
    }

    /// Prescribed entries of `u` at `t_s`; `motions` is where they were at `begin_s`.
    pub fn prescribe(&self, motions: &[[f64; 2]], clock: &ExcitedClock, begin_s: f64, t_s: f64, u: &mut [f64]) {
        for (motion, from) in self.prescribed.iter().zip(motions) {
            let at = motion.at(*from, clock, begin_s, t_s);
            u[motion.inputs[0]] = at.value;
            u[motion.inputs[1]] = at.rate;
            u[motion.inputs[2]] = at.acceleration;
        }
    }

    /// Moves the prescribed motions from `begin_s` to `end_s`.
    pub fn advance_motions(&self, state: &mut InputsState, clock: &ExcitedClock, begin_s: f64, end_s: f64) {
        for (motion, from) in self.prescribed.iter().zip(&mut state.motions) {
            if clock.running {
                let at = motion.at(*from, clock, begin_s, end_s);
                *from = [at.value, at.rate];
            }
        }
    }

    /// Position and rate, at `start_s`, of the joint prescribed by actuator `actuator`.
    pub fn initial_motion(&self, state: &InputsState, actuator: usize, start_s: f64) -> Option<(f64, f64)> {
        let (motion, from) =
            self.prescribed.iter().zip(&state.motions).find(|(motion, _)| motion.actuator == actuator)?;
        let clock = ExcitedClock { begin_s: start_s, excited_begin_s: start_s, running: true };
        let at = motion.at(*from, &clock, start_s, start_s);
        Some((at.value, at.rate))
    }

    /// Numbers in the memory of [`InputsState`], to recognise a foreign one.
    pub fn matches(&self, state: &InputsState) -> bool {
        let own = self.empty();
        own.gates.len() == state.gates.len()
            && own.delays.len() == state.delays.len()
            && own.lags.len() == state.lags.len()
            && own.noise.len() == state.noise.len()
            && own.motions.len() == state.motions.len()
    }
}

impl Commanded {
    fn new(
        plant: &Plant,
        system: &System,
        input: usize,
        actuator: usize,
        signal: SignalSum,
        (seed, prefix): (u64, &str),
    ) -> Result<Self, SimulationError> {
        let description = &plant.actuators[actuator];
        let range = description.range.map_or(f64::INFINITY, |range| range.value);
        if range.is_nan() || range < 0.0 {
            let what = format!("range of actuator '{}'", description.name);
            return Err(SimulationError::Setting { what, value: range, why: "must not be negative" });
        }
        let lowest = if matches!(description.kind, ActuatorKind::Thruster { .. }) { 0.0 } else { -range };
        let own = |filter: &&dynamics::system::Filter| filter.place == FilterPlace::Input(input);
        let kinds: Vec<FilterKind> = system.filters().iter().filter(own).map(|filter| filter.kind).collect();
        // delays and lags do not change with time, so they may change places
        let delay_s = kinds.iter().map(FilterKind::delay_s).sum();
        Ok(Self {
            input,
            actuator,
            signal,
            limits: [lowest, range],
            gates: kinds.iter().copied().filter_map(Gate::new).collect(),
            delay: HeldDelay::new(delay_s, plant.simulation.period_s),
            lags: kinds.into_iter().filter_map(Lag::new).collect(),
            sigma: description.noise.value,
            quiet_at_zero: matches!(description.kind, ActuatorKind::Thruster { .. }),
            stream: noise_of(description, seed, prefix),
        })
    }
}

impl PrescribedMotion {
    /// The signal states a derivative of this coordinate, which therefore needs an initial value.
    fn integrates(&self, coordinate: &str) -> bool {
        self.what != Prescribed::Position && self.coordinate.as_deref() == Some(coordinate)
    }

    /// Position and rate before the first instant.
    fn initial(&self, initial: &Initial) -> [f64; 2] {
        let stated = initial.values.iter().find(|value| self.integrates(&value.coordinate));
        stated.map_or([0.0; 2], |value| [value.position.value, value.rate.value])
    }

    /// Position, rate and acceleration at `t_s`, from where the motion was at `begin_s`.
    ///
    /// What the signal does not state follows by Gauss–Legendre quadrature with three points, exact
    /// for polynomials of degree five.
    fn at(&self, from: [f64; 2], clock: &ExcitedClock, begin_s: f64, t_s: f64) -> SignalValue {
        const NODES: [(f64, f64); 3] = [
            (0.112_701_665_379_258_31, 0.277_777_777_777_777_8),
            (0.5, 0.444_444_444_444_444_4),
            (0.887_298_334_620_741_7, 0.277_777_777_777_777_8),
        ];
        let signal = self.signal.at(clock.at(t_s));
        if !clock.running {
            let value = if self.what == Prescribed::Position { signal.value } else { from[0] };
            return SignalValue { value, rate: 0.0, acceleration: 0.0 };
        }
        let h = t_s - begin_s;
        let stated = |node: f64| self.signal.at(clock.at(begin_s + node * h)).value;
        match self.what {
            Prescribed::Position => signal,
            Prescribed::Rate => SignalValue {
                value: from[0] + h * NODES.iter().map(|(node, weight)| weight * stated(*node)).sum::<f64>(),
                rate: signal.value,
                acceleration: signal.rate,
            },
            Prescribed::Acceleration => {
                let (mut gained, mut moved) = (0.0, 0.0);
                for (node, weight) in NODES {
                    let share = weight * stated(node);
                    gained += share;
                    moved += share * (1.0 - node);
                }
                SignalValue {
                    value: from[0] + h * (from[1] + h * moved),
                    rate: from[1] + h * gained,
                    acceleration: signal.value,
                }
            }
        }
    }
}

fn prescribed_derivative(actuator: &Actuator) -> Option<Prescribed> {
    match actuator.kind {
        ActuatorKind::PrescribedJoint { what, .. } | ActuatorKind::PrescribedBase { what, .. } => Some(what),
        _ => None,
    }
}

/// The input whose unit a recording of actuator `actuator` has.
pub(crate) fn stated_input<'a>(plant: &Plant, inputs: &'a [InputName], actuator: usize) -> Option<&'a InputName> {
    let role = match prescribed_derivative(&plant.actuators[actuator]) {
        None => InputRole::Command,
        Some(Prescribed::Position) => InputRole::Position,
        Some(Prescribed::Rate) => InputRole::Rate,
        Some(Prescribed::Acceleration) => InputRole::Acceleration,
    };
    inputs.iter().find(|input| input.actuator == actuator && input.role == role)
}

fn prescribed_inputs(system: &System, inputs: &[usize]) -> [usize; 3] {
    let find = |role: InputRole| {
        let found = inputs.iter().copied().find(|index| system.inputs()[*index].role == role);
        found.expect("a prescribed motion has position, rate and acceleration among the inputs")
    };
    [find(InputRole::Position), find(InputRole::Rate), find(InputRole::Acceleration)]
}

fn coordinate(actuator: &Actuator) -> Option<String> {
    let ActuatorKind::PrescribedJoint { joint, .. } = &actuator.kind else { return None };
    Some(format!("joint:{joint}"))
}

/// Splits a period at the switches of delays and, where it must be fine, into integration steps.
fn pieces(commanded: &[Commanded], period_s: f64, step_s: f64, fine: bool) -> Vec<Piece> {
    let mut edges: Vec<f64> = commanded.iter().filter_map(|input| input.delay.switch_s()).collect();
    edges.push(0.0);
    edges.push(period_s);
    edges.sort_by(f64::total_cmp);
    edges.dedup_by(|a, b| *a - *b < dynamics::signal::EDGE_S);
    let mut pieces = Vec::new();
    for pair in edges.windows(2) {
        let length_s = pair[1] - pair[0];
        let parts = if fine { super::integrator::substeps(length_s, step_s) } else { 1 };
        for part in 0..parts {
            let length_s = length_s / f64::from(parts);
            pieces.push(Piece { offset_s: pair[0] + f64::from(part) * length_s, length_s });
        }
    }
    pieces
}
