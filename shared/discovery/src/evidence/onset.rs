//! Onset and end of effects that begin or end within a recording, with standard errors.
//!
//! An edge in time has no derivative where an integration step crosses it. Alone, its standard
//! error is half the width in which `−2 ln p` rises by less than one, all other parameters following
//! on the linear model; differences over that width give its correlation with the other edge and
//! with every other parameter.

use super::follow::Follow;
use crate::score::Candidate;
use dynamics::description::Plant;
use dynamics::effect::Role;
use identification::filter::NoiseModel;
use identification::fit::{EstimationSession, Fit};
use nalgebra::{Cholesky, DMatrix};

/// Relative tolerance of a width.
const EDGE_RESOLUTION: f64 = 0.125;

/// Duration from which an effect has no end in any recording \[s\].
const ENDLESS_S: f64 = 1e8;

/// A time inside an effect of a plant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Edge {
    /// The end stays where it is.
    Begin,
    End,
}

/// One edge of one effect: places of both.
#[derive(Clone, Copy, Debug)]
struct Place {
    effect: usize,
    edge: Edge,
}

/// A time that was searched, with its standard error [s].
#[derive(Clone, Debug, PartialEq)]
pub(super) struct TimeEstimate {
    pub name: &'static str,
    pub value: f64,
    pub sigma: f64,
}

/// Onset and duration \[s\] of the effect of `candidate` that the search has found, with standard
/// errors, and the standard errors of all unknowns with these times free. `None` where it has no
/// such time.
///
/// Cost: a bisection along the likelihood and two passes for each edge.
pub(super) fn onset_estimates(
    session: &EstimationSession<'_>,
    (fit, noise): (&Fit, &NoiseModel),
    candidate: &Candidate,
) -> Option<(Vec<TimeEstimate>, Vec<f64>)> {
    let plant = &fit.plant;
    let list = places(session, plant, candidate);
    (!list.is_empty()).then_some(())?;
    let mut follow = Follow::new(session, fit, noise);
    let alone: Vec<f64> = list.iter().map(|place| follow.sigma(plant, *place)).collect::<Option<_>>()?;
    let (sigma, between) = follow.joint(plant, &list, &alone)?;
    let value = |edge: Edge| time(plant, list[0].effect, edge);
    let name = |role: Role| candidate.effect.with_role(role).map(|parameter| parameter.name);
    let mut times = Vec::with_capacity(2);
    for (k, place) in list.iter().enumerate() {
        let found = match place.edge {
            Edge::Begin => {
                TimeEstimate { name: name(Role::Onset)?, value: value(Edge::Begin)?, sigma: between[(k, k)].sqrt() }
            }
            Edge::End => {
                let begun = list.iter().position(|other| other.edge == Edge::Begin);
                let own = begun.map_or(0.0, |b| between[(b, b)] - 2.0 * between[(b, k)]);
                let sigma = (between[(k, k)] + own).max(0.0).sqrt();
                TimeEstimate { name: name(Role::Duration)?, value: value(Edge::End)? - value(Edge::Begin)?, sigma }
            }
        };
        times.push(found);
    }
    Some((times, sigma))
}

/// From the first start of a run to the last end of one [s].
fn span_s(session: &EstimationSession<'_>) -> [f64; 2] {
    let runs = session.problem.runs.iter();
    runs.fold([f64::INFINITY, f64::NEG_INFINITY], |[b, e], run| [b.min(run.begin_s), e.max(run.end_s)])
}

/// Edges of the effect of `candidate` in `plant` that the score's refinement searches; edges
/// outside the recording are absent.
fn places(session: &EstimationSession<'_>, plant: &Plant, candidate: &Candidate) -> Vec<Place> {
    let Some(effect) = plant.effects.iter().position(|used| candidate.is(used)) else { return Vec::new() };
    let [begin_s, end_s] = span_s(session);
    let is_inside = |place: &Place| time(plant, effect, place.edge).is_some_and(|t| begin_s < t && t < end_s);
    [Edge::Begin, Edge::End].map(|edge| Place { effect, edge }).into_iter().filter(is_inside).collect()
}

/// Time of an edge of an effect; `None` where it has no such edge.
fn time(plant: &Plant, effect: usize, edge: Edge) -> Option<f64> {
    let known = |role: Role| plant.stated(&plant.effects[effect], role).filter(|q| q.sigma.is_none()).map(|q| q.value);
    let begin = known(Role::Onset)?;
    match edge {
        Edge::Begin => Some(begin),
        Edge::End => known(Role::Duration).filter(|lasts| *lasts < ENDLESS_S).map(|lasts| begin + lasts),
    }
}

/// `plant` with one edge at `t_s`, the other where it was.
fn with(plant: &Plant, place: Place, t_s: f64) -> Option<Plant> {
    let (begin, end) = (time(plant, place.effect, Edge::Begin)?, time(plant, place.effect, Edge::End));
    let effect = plant.catalogue.effect(&plant.effects[place.effect].kind)?;
    let mut plant = plant.clone();
    let used = &mut plant.effects[place.effect];
    let mut set = |role: Role, value: f64| {
        let is_it = |name: &str| effect.with_role(role).is_some_and(|parameter| parameter.name == name);
        used.values.iter_mut().filter(|(own, _)| is_it(own)).for_each(|(_, quantity)| quantity.value = value);
    };
    let lasts = match place.edge {
        Edge::Begin => {
            set(Role::Onset, t_s);
            end.map(|end| end - t_s)
        }
        Edge::End => Some(t_s - begin),
    };
    if let Some(lasts) = lasts {
        (lasts > 0.0).then_some(())?;
        set(Role::Duration, lasts);
    }
    Some(plant)
}

impl Follow<'_, '_> {
    /// Half the width in which the objective rises by less than one, at least the resolution of the
    /// integration; all other edges fixed.
    fn sigma(&mut self, plant: &Plant, place: Place) -> Option<f64> {
        let at = time(plant, place.effect, place.edge)?;
        let finest = self.session.timelines.first()?.period_s;
        let [begin_s, end_s] = span_s(self.session);
        let least = self.least(plant)?;
        let mut rises = |t_s: f64| {
            let inside = (begin_s..=end_s).contains(&t_s);
            let moved = inside.then(|| with(plant, place, t_s)).flatten().and_then(|moved| self.least(&moved));
            moved.is_none_or(|found| found - least >= 1.0)
        };
        let [down, up] = [-1.0, 1.0].map(|sign| {
            let (mut near, mut far) = (0.0, 0.5 * finest);
            while far < end_s - begin_s && !rises(at + sign * far) {
                (near, far) = (far, 2.0 * far);
            }
            while far - near > EDGE_RESOLUTION * far.max(finest) {
                let middle = 0.5 * (near + far);
                (near, far) = if rises(at + sign * middle) { (near, middle) } else { (middle, far) };
            }
            0.5 * (near + far)
        });
        Some((0.5 * (down + up)).max(finest / 12f64.sqrt()))
    }

    /// Standard errors of the unknowns and covariance of the edges, all free, from differences over
    /// the width `alone` of each edge.
    fn joint(&mut self, plant: &Plant, list: &[Place], alone: &[f64]) -> Option<(Vec<f64>, DMatrix<f64>)> {
        let mut columns = Vec::with_capacity(list.len());
        for (place, width) in list.iter().zip(alone) {
            let at = time(plant, place.effect, place.edge)?;
            let nu = |t_s: f64| {
                let moved = with(plant, *place, t_s)?;
                self.session.innovations(&moved, self.theta, &self.linearised.linears, &|_| true)
            };
            let (down, up) = (nu(at - width)?, nu(at + width)?);
            columns.push(down.iter().zip(&up).map(|(d, u)| 0.5 * (d - u) / width).collect::<Vec<f64>>());
        }
        self.least(plant)?;
        let extra: Vec<&Vec<f64>> = columns.iter().collect();
        let mut normal = self.linearised.normal(self.session, self.theta, self.noise, &extra)?;
        let n = normal.unknowns;
        // a difference over a jump of the likelihood gives a direction only: its length is the
        // edge's own width
        let factor = normal.factor()?;
        for (k, width) in alone.iter().enumerate() {
            let across = normal.matrix.view((0, n + k), (n, 1)).into_owned();
            let own = normal.matrix[(n + k, n + k)] - across.dot(&factor.solve(&across));
            let scale = if own > 0.0 { 1.0 / (width * own.sqrt()) } else { 0.0 };
            normal.matrix.row_mut(n + k).scale_mut(scale);
            normal.matrix.column_mut(n + k).scale_mut(scale);
            if scale == 0.0 {
                // between two samples: no later sample depends on it
                normal.matrix[(n + k, n + k)] = 1.0 / (width * width);
            }
        }
        let inverse = Cholesky::new(normal.matrix)?.inverse();
        let unknowns = &self.session.problem.unknowns;
        let sigma = (0..n).map(|i| inverse[(i, i)].max(0.0).sqrt() * unknowns[i].sigma).collect();
        Some((sigma, inverse.view((n, n), (list.len(), list.len())).into_owned()))
    }
}
