//! When what begins or ends within a recording does so.
//!
//! The score finds a time beside the nominal plant. A law that stands is physics, and the numbers beside it have moved: its edges are moved
//! along the likelihood, every other number following on the linear model. An edge in time has no derivative where integration steps over
//! it, so its standard error is half the width in which `−2 ln p` rises by less than one.

use super::refit::{FOR_EVER_S, Refit, settled};
use crate::filter::NoiseModel;
use crate::fit::{Board, Engine, Fit};
use crate::score::{Candidate, Column};
use plant::description::{EffectUse, Plant};

/// Gain in `−2 ln p` from which an edge lies elsewhere.
const BETTER: f64 = 0.5;
/// Turns between the edges and all other numbers.
const TURNS: usize = 3;
/// Largest move of an edge in one turn: this share of the recording.
const REACH: f64 = 0.125;
/// Least distance of two edges that are told apart [sampling intervals], and share of a width that it is known by.
const FINEST: f64 = 0.125;
/// What a bracket shrinks by.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

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

/// A time that was found, with its standard error.
#[derive(Clone, Debug, PartialEq)]
pub struct FoundTime {
    pub name: &'static str,
    pub value: f64,
    pub sigma: f64,
}

/// `refit` with the edges in time of its `members` where the likelihood is largest.
///
/// Cost: some forty passes and likelihoods an edge, and a fit where one moved.
pub fn timed(engine: &Engine<'_>, refit: Refit, members: &[&Column]) -> Refit {
    let mut best = refit;
    for _ in 0..TURNS {
        let Some(plant) = moved(engine, &best, members) else { break };
        let problem = engine.problem.with_plant(&plant);
        let found = settled(engine, Refit { plant, problem, objective: f64::INFINITY, ..best.clone() });
        if found.objective > best.objective - BETTER {
            break;
        }
        best = found;
    }
    best
}

/// The plant of `refit` with its edges moved; `None` where none gains.
fn moved(engine: &Engine<'_>, refit: &Refit, members: &[&Column]) -> Option<Plant> {
    let list: Vec<Place> = members.iter().flat_map(|column| places(&refit.plant, &column.candidate)).collect();
    (!list.is_empty()).then_some(())?;
    let own = Engine::like(engine, &refit.problem).ok()?;
    let mut follow = Follow::new(&own, &refit.fit, &refit.noise);
    let [begin_s, end_s] = own.problem.span_s();
    let finest = own.timelines.first()?.period_s;
    let mut plant = refit.plant.clone();
    let present = follow.least(&plant)?;
    let mut least = present;
    let mut dearest = 0.0f64;
    for place in list {
        if !engine.work.allows(dearest, "times of effects") {
            break;
        }
        let before = engine.work.spent();
        let at = time(&plant.effects[place.effect], place.edge)?;
        let mut value = |t_s: f64| {
            let inside = (begin_s..=end_s).contains(&t_s).then(|| with(&plant, place, t_s)).flatten();
            inside.and_then(|plant| follow.least(&plant)).unwrap_or(f64::INFINITY)
        };
        let (t_s, found) = lowest(&mut value, (at, least), [finest, REACH * (end_s - begin_s)]);
        if found < least {
            (plant, least) = (with(&plant, place, t_s)?, found);
        }
        dearest = dearest.max(engine.work.spent() - before);
    }
    (least < present - BETTER).then_some(plant)
}

/// Where `value` is least about `at` (where it is `present`): the best of steps that double to `reach` on both sides, its bracket by golden section.
fn lowest(value: &mut dyn FnMut(f64) -> f64, (at, present): (f64, f64), [finest, reach]: [f64; 2]) -> (f64, f64) {
    let mut seen = vec![(at, present)];
    let mut step = finest;
    while step <= reach {
        for t_s in [at - step, at + step] {
            seen.push((t_s, value(t_s)));
        }
        step *= 2.0;
    }
    seen.sort_by(|a, b| a.0.total_cmp(&b.0));
    let best = (0..seen.len()).min_by(|a, b| seen[*a].1.total_cmp(&seen[*b].1)).unwrap_or(0);
    let mut low = seen[best.saturating_sub(1)].0;
    let mut high = seen[(best + 1).min(seen.len() - 1)].0;
    let mut best = seen[best];
    while high - low > FINEST * finest {
        // into the wider side
        let is_up = high - best.0 > best.0 - low;
        let t_s = best.0 + (1.0 - GOLDEN) * if is_up { high - best.0 } else { low - best.0 };
        let found = value(t_s);
        if found < best.1 {
            (low, high) = if is_up { (best.0, high) } else { (low, best.0) };
            best = (t_s, found);
        } else {
            (low, high) = if is_up { (low, t_s) } else { (t_s, high) };
        }
    }
    best
}

/// Times of the effect of `candidate` that the search has found, as `fit` of its plant knows them; none where it has none.
pub fn found_times(engine: &Engine<'_>, (fit, noise): (&Fit, &NoiseModel), candidate: &Candidate) -> Vec<FoundTime> {
    let plant = &fit.plant;
    let list = places(plant, candidate);
    let mut follow = Follow::new(engine, fit, noise);
    let mut times: Vec<FoundTime> = Vec::new();
    for place in list {
        let Some(sigma) = follow.sigma(plant, place) else { continue };
        let found = match (place.edge, times.last()) {
            (Edge::Begin, _) => time(&plant.effects[place.effect], Edge::Begin).map(|value| ("begin", value, sigma)),
            (Edge::End, begun) => {
                let lasts = time(&plant.effects[place.effect], Edge::End).zip(begun).map(|(end, b)| (end - b.value, b));
                lasts.map(|(lasts, begun)| ("duration", lasts, libm::hypot(sigma, begun.sigma)))
            }
        };
        times.extend(found.map(|(name, value, sigma)| FoundTime { name, value, sigma }));
    }
    times
}

/// Edges of the effect of `candidate` in `plant` that the refinement of the score searches.
fn places(plant: &Plant, candidate: &Candidate) -> Vec<Place> {
    let is_own = |used: &EffectUse| used.kind == candidate.effect.kind && used.site == candidate.site;
    let Some(effect) = plant.effects.iter().position(is_own) else { return Vec::new() };
    let is_there = |place: &Place| time(&plant.effects[effect], place.edge).is_some();
    [Edge::Begin, Edge::End].map(|edge| Place { effect, edge }).into_iter().filter(is_there).collect()
}

/// When an effect begins or ends; `None` where it has no such edge.
fn time(used: &EffectUse, edge: Edge) -> Option<f64> {
    let value = |name: &str| used.values.iter().find(|(own, q)| own == name && q.sigma.is_none()).map(|(_, q)| q.value);
    let begin = value("begin")?;
    match edge {
        Edge::Begin => Some(begin),
        Edge::End => value("duration").filter(|lasts| *lasts < FOR_EVER_S).map(|lasts| begin + lasts),
    }
}

/// `plant` with one edge at `t_s`, the other where it was.
fn with(plant: &Plant, place: Place, t_s: f64) -> Option<Plant> {
    let mut plant = plant.clone();
    let used = &mut plant.effects[place.effect];
    let (begin, end) = (time(used, Edge::Begin)?, time(used, Edge::End));
    let mut set = |name: &str, value: f64| {
        used.values.iter_mut().filter(|(own, _)| own == name).for_each(|(_, quantity)| quantity.value = value);
    };
    let lasts = match place.edge {
        Edge::Begin => {
            set("begin", t_s);
            end.map(|end| end - t_s)
        }
        Edge::End => Some(t_s - begin),
    };
    if let Some(lasts) = lasts {
        (lasts > 0.0).then_some(())?;
        set("duration", lasts);
    }
    Some(plant)
}

/// Least objective of a plant beside a fit, all numbers following on the fit's linear model.
struct Follow<'a, 'p> {
    engine: &'a Engine<'p>,
    board: Board,
    theta: &'a [f64],
    noise: &'a NoiseModel,
}

impl<'a, 'p> Follow<'a, 'p> {
    fn new(engine: &'a Engine<'p>, fit: &'a Fit, noise: &'a NoiseModel) -> Self {
        Self { engine, board: fit.board.clone(), theta: &fit.theta, noise }
    }

    fn least(&mut self, plant: &Plant) -> Option<f64> {
        self.board.nu = self.engine.innovations(plant, self.theta, &self.board.linears, &|_| true)?;
        self.board.normal(self.engine, self.theta, self.noise, &[])?.minimum_without()
    }

    /// Half the width in which the objective rises by less than one, at least what integration resolves.
    fn sigma(&mut self, plant: &Plant, place: Place) -> Option<f64> {
        let at = time(&plant.effects[place.effect], place.edge)?;
        let finest = self.engine.timelines.first()?.period_s;
        let [begin_s, end_s] = self.engine.problem.span_s();
        let least = self.least(plant)?;
        let mut rises = |t_s: f64| {
            let moved = with(plant, place, t_s).and_then(|moved| self.least(&moved));
            !(begin_s..=end_s).contains(&t_s) || moved.is_none_or(|found| found - least >= 1.0)
        };
        let [down, up] = [-1.0, 1.0].map(|sign| {
            let (mut near, mut far) = (0.0, 0.5 * finest);
            while !rises(at + sign * far) {
                (near, far) = (far, 2.0 * far);
            }
            while far - near > FINEST * far {
                let middle = 0.5 * (near + far);
                (near, far) = if rises(at + sign * middle) { (near, middle) } else { (middle, far) };
            }
            0.5 * (near + far)
        });
        Some((0.5 * (down + up)).max(finest / 12f64.sqrt()))
    }
}
