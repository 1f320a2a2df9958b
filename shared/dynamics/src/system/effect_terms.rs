//! Laws of the catalogue at the sites of one plant.

use super::System;
use super::geometry::{add, turn_back};
use super::sites::Coordinate;
use super::workspace::Workspace;
use crate::effect::{Action, BodyState, Both, HIDDEN_MAX, Local, PARAMETERS_MAX, Pick, Surroundings};
use core::ops::Range;

/// Most of its mass that a body can lose: an empty tank is still a body.
const LOST_SHARE_MAX: f64 = 0.99;

/// One law at one coordinate, body, actuator or sensor.
#[derive(Clone)]
pub(super) struct EffectTerm {
    pub law: Both,
    /// See [`Effect::is_smooth`](crate::effect::Effect::is_smooth).
    pub smooth: bool,
    /// In catalogue order, zero behind the last.
    pub values: [f64; PARAMETERS_MAX],
    /// Its own states among the hidden ones.
    pub hidden: Range<usize>,
    pub coordinate: Option<Coordinate>,
    /// Of a tank: all its coordinates and their axes.
    pub tank: Vec<(Coordinate, [f64; 3])>,
    /// The body the site belongs to.
    pub link: usize,
    /// The law receives the motion of that body.
    pub carried: bool,
    pub surroundings: Surroundings,
}

/// All laws, by the place of their action.
#[derive(Clone, Default)]
pub(super) struct EffectTerms {
    pub coordinates: Vec<EffectTerm>,
    pub bodies: Vec<EffectTerm>,
    /// Grouped by actuator, then by sensor, each group in the order of the catalogue.
    pub actuators: Vec<EffectTerm>,
    pub sensors: Vec<EffectTerm>,
    /// First hidden state in x.
    pub hidden_at: usize,
}

impl EffectTerms {
    fn all(&self) -> impl Iterator<Item = &EffectTerm> {
        [&self.coordinates, &self.bodies, &self.actuators, &self.sensors].into_iter().flatten()
    }

    /// All of them are forces without states of their own that change smoothly.
    pub fn are_smooth_forces(&self) -> bool {
        let forces = self.actuators.is_empty() && self.sensors.is_empty();
        forces && self.all().all(|term| term.smooth && term.hidden.is_empty())
    }

    /// As many laws act at each place.
    pub fn are_laws_of(&self, other: &Self) -> bool {
        let many = |terms: &Self| [&terms.coordinates, &terms.bodies, &terms.actuators, &terms.sensors].map(Vec::len);
        many(self) == many(other)
    }

    /// The same laws have the same numbers.
    pub fn act_as(&self, other: &Self) -> bool {
        self.all().zip(other.all()).all(|(a, b)| (a.values, a.surroundings) == (b.values, b.surroundings))
    }
}

impl EffectTerm {
    /// Takes the rates of its own states and clears them for the next law.
    #[inline]
    pub fn keep_hidden_rates<T: Pick>(&self, ws: &mut Workspace<T>, action: &mut Action<T>) {
        for (rate, found) in ws.hidden_rate[self.hidden.clone()].iter_mut().zip(action.hidden_rate) {
            *rate = found;
        }
        action.hidden_rate = [T::zero(); HIDDEN_MAX];
    }
}

impl System {
    /// Adds the forces of laws on coordinates and bodies. Actuators come before, because their
    /// efforts are arguments of the laws.
    #[inline]
    pub(super) fn apply_effects<T: Pick>(&self, ws: &mut Workspace<T>, t_s: f64, x: &[T]) {
        for term in &self.effects.coordinates {
            let Some(coordinate) = term.coordinate else { continue };
            let mut action = Action::default();
            let body = if term.carried { body_state(ws, term.link) } else { BodyState::default() };
            let local = Local { command: ws.effort[coordinate.v], ..self.local(ws, t_s, x, term, &body) };
            (T::pick(&term.law))(&local, &term.values, &mut action);
            term.keep_hidden_rates(ws, &mut action);
            ws.tau[coordinate.v] += action.force;
        }
        if self.effects.bodies.is_empty() {
            return;
        }
        ws.added_mass.fill(T::zero());
        for term in &self.effects.bodies {
            let mut action = Action::default();
            let body = body_state(ws, term.link);
            let local = Local { command: ws.thrust[term.link], ..self.local(ws, t_s, x, term, &body) };
            (T::pick(&term.law))(&local, &term.values, &mut action);
            term.keep_hidden_rates(ws, &mut action);
            for (sum, part) in ws.wrench[term.link].iter_mut().zip(action.wrench) {
                *sum += part;
            }
            ws.added_mass[term.link] += action.added_mass_kg;
            let least = T::constant(-LOST_SHARE_MAX * self.model.links[term.link].mass);
            let added = ws.added_mass[term.link].max(least);
            let com = self.model.links[term.link].com.array().map(T::constant);
            ws.data.set_added_mass(term.link, added, com);
        }
    }

    /// The nominal masses again.
    pub(super) fn lose_added_mass<T: Pick>(&self, ws: &mut Workspace<T>) {
        for term in &self.effects.bodies {
            ws.data.set_added_mass(term.link, T::zero(), [T::zero(); 3]);
        }
    }

    /// Arguments of the law of `term`, without accelerations.
    #[inline]
    pub(super) fn local<'a, T: Pick>(
        &self,
        ws: &Workspace<T>,
        t_s: f64,
        x: &'a [T],
        term: &'a EffectTerm,
        body: &'a BodyState<T>,
    ) -> Local<'a, T> {
        let at = self.effects.hidden_at;
        let position = term.coordinate.and_then(|coordinate| coordinate.position);
        let (displacement, displacement_rate) = tank_motion(ws, &term.tank);
        Local {
            t_s,
            displacement,
            displacement_rate,
            coordinate: position.map_or(T::zero(), |q| ws.position[q]),
            rate: term.coordinate.map_or(T::zero(), |coordinate| ws.velocity[coordinate.v]),
            command: T::zero(),
            reading: T::zero(),
            body,
            hidden: &x[at + term.hidden.start..at + term.hidden.end],
            surroundings: &term.surroundings,
        }
    }
}

/// Displacement of a tank's mass and its rate along all axes together.
#[inline]
fn tank_motion<T: Pick>(ws: &Workspace<T>, tank: &[(Coordinate, [f64; 3])]) -> ([T; 3], [T; 3]) {
    let (mut displacement, mut rate) = ([T::zero(); 3], [T::zero(); 3]);
    for (coordinate, axis) in tank {
        if let Some(q) = coordinate.position {
            displacement = add(displacement, axis.map(|a| ws.position[q].scale(a)));
        }
        rate = add(rate, axis.map(|a| ws.velocity[coordinate.v].scale(a)));
    }
    (displacement, rate)
}

/// Motion of a body against inertial space, accelerations zero.
pub(super) fn body_state<T: Pick>(ws: &Workspace<T>, link: usize) -> BodyState<T> {
    let (origin, rotation) = ws.data.link_pose(link);
    let [wx, wy, wz, vx, vy, vz] = ws.data.link_velocity(link);
    BodyState {
        rotation,
        position_m: add(origin, ws.base.position),
        omega_rad_s: [wx, wy, wz],
        velocity_m_s: add([vx, vy, vz], turn_back(&rotation, ws.base.velocity)),
        ..BodyState::default()
    }
}

/// The motion of a body with its accelerations, as the law of a sensor receives it.
pub(super) fn accelerated<T: Pick>(ws: &Workspace<T>, link: usize, body: BodyState<T>) -> BodyState<T> {
    let [ax, ay, az, ..] = ws.data.link_acceleration(link);
    let specific_force_m_s2 = ws.data.specific_force(link, [T::zero(); 3]);
    BodyState { alpha_rad_s2: [ax, ay, az], specific_force_m_s2, ..body }
}
