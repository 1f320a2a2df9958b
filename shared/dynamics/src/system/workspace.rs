//! Scratch of one thread.

use super::System;
use crate::effect::Pick;
use crate::multibody::Data;

/// Everything that [`System`]'s functions need, so that none of them allocates.
#[derive(Clone, Debug)]
pub struct Workspace<T: Pick> {
    pub(super) data: Data<T>,
    /// The model's position, then modal coordinates.
    pub(super) position: Vec<T>,
    pub(super) position_rate: Vec<T>,
    pub(super) velocity: Vec<T>,
    pub(super) acceleration: Vec<T>,
    /// Generalised forces: passive ones, actuators, effects.
    pub(super) tau: Vec<T>,
    /// Share of `tau` that actuators apply.
    pub(super) effort: Vec<T>,
    pub(super) wrench: Vec<[T; 6]>,
    /// Per link: magnitudes of the forces that actuators apply, summed.
    pub(super) thrust: Vec<T>,
    /// Per link: mass that effects add.
    pub(super) added_mass: Vec<T>,
    /// Rates of the hidden states.
    pub(super) hidden_rate: Vec<T>,
    pub(super) base: BaseMotion<T>,
    /// Per sensor, at the beginning of an interval over which it averages.
    pub(super) begin: Vec<Begin<T>>,
    /// One state, input, derivative and output, for differentiation.
    pub(super) line: Line<T>,
}

/// Motion of the accelerated frame of a prescribed base.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct BaseMotion<T> {
    pub position: [T; 3],
    pub velocity: [T; 3],
    pub acceleration: [T; 3],
}

/// State at the beginning of the interval of a mean reading.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Begin<T> {
    pub rotation: [[T; 3]; 3],
    pub velocity: [T; 3],
    pub value: T,
}

#[derive(Clone, Debug, Default)]
pub(super) struct Line<T> {
    pub x: Vec<T>,
    pub u: Vec<T>,
    pub x_dot: Vec<T>,
    pub y: Vec<T>,
}

impl<T: Pick> Workspace<T> {
    /// Memory for one evaluation of `system` at a time; evaluations allocate nothing.
    pub fn new(system: &System) -> Self {
        let layout = &system.layout;
        let zeros = |n: usize| vec![T::zero(); n];
        let positions = layout.q_len + layout.modes;
        Self {
            data: Data::new(&system.model),
            position: zeros(positions),
            position_rate: zeros(positions),
            velocity: zeros(layout.v_len),
            acceleration: zeros(layout.v_len),
            tau: zeros(layout.v_len),
            effort: zeros(layout.v_len),
            wrench: vec![[T::zero(); 6]; system.model.links_len()],
            thrust: zeros(system.model.links_len()),
            added_mass: zeros(system.model.links_len()),
            hidden_rate: zeros(layout.hidden),
            base: BaseMotion::default(),
            begin: vec![Begin::default(); layout.outputs.len()],
            line: Line {
                x: zeros(layout.states_len()),
                u: zeros(layout.inputs.len()),
                x_dot: zeros(layout.states_len()),
                y: zeros(layout.outputs.len()),
            },
        }
    }
}
