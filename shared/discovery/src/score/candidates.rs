//! The catalogue laid out over a plant: every effect at every site, with grids for the shape
//! parameters of its law.

use super::specific_force::mean_axial;
use super::{Instants, Lines, Orders};
use dynamics::description::{EffectUse, Plant, Site, SiteKind, Space};
use dynamics::effect::{Amplitude, Effect, EffectParameter, Role, Scan, sites};
use identification::filter::Linear;
use identification::problem::{Problem, Timeline};

/// One effect at one site with its shape parameters.
#[derive(Clone)]
pub struct Candidate {
    pub effect: &'static Effect,
    pub site: Site,
    /// Every parameter but the amplitude and the angles.
    pub inner: Inner,
    /// Of a vector amplitude its components along each direction, else the angles of each; one
    /// empty list where there are none.
    pub directions: Vec<Direction>,
    /// The amplitude cannot be negative.
    pub one_sided: bool,
    pub high: f64,
    /// Amplitude at which the law is evaluated, where its shape depends on it (a compliance sets
    /// what resonates); fits start there.
    pub at: Option<f64>,
    /// Amplitude of the right size at a neighbouring grid point: passes start with it.
    pub felt: Option<f64>,
    /// Grid points that this one was picked from.
    pub tries: usize,
}

impl core::fmt::Debug for Candidate {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "{}@{} {:?}", self.effect.kind, self.site, self.inner)
    }
}

impl Candidate {
    /// Name of its amplitude parameter, the first of the effect.
    pub fn amplitude(&self) -> &'static str {
        self.effect.parameters[0].name
    }

    /// Range of the amplitude along a direction. Each of several components may have either sign:
    /// noise decides the sign of one that is absent, and the fit keeps to what is possible; an
    /// angle reverses a negative amplitude.
    pub fn range(&self, direction: usize) -> [f64; 2] {
        let first = &self.effect.parameters[0];
        if self.effect.amplitudes() > 1 {
            let component =
                |p: &&EffectParameter| self.directions[direction].iter().any(|(n, s)| *n == p.name && *s != 0.0);
            let own = self.effect.parameters.iter().find(component).unwrap_or(first);
            return if self.directions.len() > 1 { [-own.high, own.high] } else { [own.low, own.high] };
        }
        if self.one_sided || first.low < 0.0 { [first.low, first.high] } else { [-first.high, first.high] }
    }

    /// Range that the linear model may attribute to an amplitude along a direction. A share that is
    /// lost or kept as a whole (a command that sticks, a dead thruster) comes out above one as
    /// often as below, and by more where the plant's parameters had been biased by it.
    pub fn linear_range(&self, direction: usize) -> [f64; 2] {
        let first = &self.effect.parameters[0];
        let is_whole = |edge: f64| first.unit == "1" && (edge == -1.0 || edge == 1.0 && first.default == 1.0);
        self.range(direction).map(|edge| if is_whole(edge) { AMPLITUDE_SHARE_MAX * edge } else { edge })
    }

    /// Amplitudes along the directions are possible for the effect: within
    /// [`linear_range`](Self::linear_range), not all zero, and of effective masses the largest not
    /// negative.
    pub fn is_possible(&self, amplitudes: &[f64]) -> bool {
        let is_in_range = |(direction, a): (usize, &f64)| {
            let [low, high] = self.linear_range(direction);
            (low..=high).contains(a)
        };
        let largest = amplitudes.iter().copied().fold(0.0f64, |most, a| if a.abs() > most.abs() { a } else { most });
        let is_mass = self.effect.amplitude == Amplitude::ShareOfBody;
        amplitudes.iter().enumerate().all(is_in_range) && largest != 0.0 && !(is_mass && largest < 0.0)
    }

    /// All parameter values at one amplitude and direction.
    pub fn values(&self, amplitude: f64, direction: usize) -> Vec<(&'static str, f64)> {
        let components = self.effect.amplitudes();
        let direction = &self.directions[direction];
        let mut values = Vec::with_capacity(self.effect.parameters.len());
        if components > 1 {
            values.extend(direction.iter().map(|(name, share)| (*name, amplitude * share)));
        } else {
            values.push((self.amplitude(), amplitude));
            values.extend(direction.iter().copied());
        }
        values.extend(self.inner.iter().copied());
        values
    }

    /// Index among the shape parameters of the one with this role.
    pub fn inner_with(&self, role: Role) -> Option<usize> {
        let parameter = self.effect.with_role(role)?;
        self.inner.iter().position(|(name, _)| *name == parameter.name)
    }

    /// The angle between neighbouring directions over a right angle.
    pub fn pitch(&self) -> f64 {
        turn(self.effect).map_or(1.0, |(_, repeats)| 1.0 / repeats)
    }

    /// How many numbers a fit or a scan picks: amplitudes, shapes, onset and duration.
    pub fn numbers(&self) -> usize {
        let is_picked = |(name, value): &&(&str, f64)| {
            let own = self.effect.parameter(name).filter(|own| own.role != Role::Smoothing);
            own.is_some_and(|p| p.prior.sigma(*value).is_some() || matches!(p.role, Role::Onset | Role::Duration))
        };
        self.directions.len().max(1) + self.inner.iter().filter(is_picked).count()
    }

    /// `used` is this effect at this site.
    pub fn is(&self, used: &EffectUse) -> bool {
        used.kind == self.effect.kind && used.site == self.site
    }

    /// Both are the same effect at the same site: points of one law.
    pub fn same_law(&self, other: &Self) -> bool {
        self.effect.kind == other.effect.kind && self.site == other.site
    }
}

/// What a site's coordinate does in the recordings.
#[derive(Clone, Copy, Debug)]
pub struct Motion {
    pub low: f64,
    pub high: f64,
    pub rate_rms: f64,
    pub rate_max: f64,
}

/// Shape parameters of a law.
type Inner = Vec<(&'static str, f64)>;
/// Names and values that turn an amplitude's direction.
pub type Direction = Vec<(&'static str, f64)>;

/// What grids depend on.
struct Setting<'a> {
    duration_s: f64,
    begin_s: f64,
    period_s: f64,
    motion: &'a dyn Fn(&Site) -> Option<Motion>,
    /// See [`mean_axial`].
    specific_force: &'a dyn Fn(&Site) -> Option<f64>,
    /// Lines of the innovations that a site can cause [Hz].
    lines: &'a dyn Fn(&Site) -> Vec<f64>,
    /// Frequencies among which the lines were found.
    looked: usize,
    /// Instants of jumps in the innovations that a site can cause [s], and the number of samples
    /// among which they were found.
    instants: &'a dyn Fn(&Site) -> Vec<f64>,
    samples: usize,
    /// Orders of ripples that a site can cause.
    orders: &'a dyn Fn(&Site) -> Option<&'a Orders>,
    planar: bool,
}

/// Largest share that the linear model may attribute where one is the physical bound. Chosen, no
/// derivation.
const AMPLITUDE_SHARE_MAX: f64 = 1.5;
/// Points of a grid over frequency and over time.
const FREQUENCIES: usize = 9;
const TIMES: usize = 8;

/// Every candidate of `plant`; `without` names effects that are excluded from the catalogue.
pub fn candidates(
    problem: &Problem,
    plant: &Plant,
    (linears, timelines): (&[Linear], &[Timeline]),
    (found, ripples, jumps): (&Lines, &[Orders], &Instants),
    without: &[String],
) -> Vec<Candidate> {
    let motion = |site: &Site| motion(plant, linears, site);
    let specific_force = |site: &Site| {
        let tank = plant.tanks.iter().find(|tank| site.kind == SiteKind::Tank && tank.name == site.name);
        mean_axial(plant, linears, timelines, tank?)
    };
    // for a sensor its own, for all other sites those of any sensor
    let of = |site: &Site, channels: &[Vec<f64>], pooled: &[f64]| {
        let channel = plant.sensors.iter().position(|sensor| site.kind == SiteKind::Sensor && sensor.name == site.name);
        channel.and_then(|c| channels.get(c)).map_or_else(|| pooled.to_vec(), Clone::clone)
    };
    let lines = |site: &Site| of(site, &found.channels, &found.pooled);
    let instants = |site: &Site| of(site, &jumps.channels, &jumps.pooled);
    let orders = |site: &Site| {
        ripples.iter().find(|own| match own.channel {
            None => site.kind == SiteKind::Joint && own.joint == site.name,
            Some(channel) => site.kind == SiteKind::Sensor && plant.sensors[channel].name == site.name,
        })
    };
    let [begin_s, end_s] = problem.span_s();
    let setting = Setting {
        duration_s: end_s - begin_s,
        begin_s,
        period_s: timelines[0].period_s,
        motion: &motion,
        specific_force: &specific_force,
        lines: &lines,
        looked: found.looked,
        instants: &instants,
        samples: jumps.looked,
        orders: &orders,
        planar: plant.space == Space::Planar,
    };
    let mut list = Vec::new();
    for effect in plant.catalogue.entries().iter().filter(|effect| !without.iter().any(|kind| kind == effect.kind)) {
        for site in sites(effect, plant) {
            let present = plant.effects.iter().any(|used| used.kind == effect.kind && used.site == site);
            let recorded = site.kind != SiteKind::Sensor || {
                let channel = plant.sensors.iter().position(|sensor| sensor.name == site.name);
                channel.is_some_and(|c| problem.runs.iter().any(|run| !run.samples[c].value.is_empty()))
            };
            if !present && recorded {
                lay_out(effect, &site, &setting, &mut list);
            }
        }
    }
    list
}

fn lay_out(effect: &'static Effect, site: &Site, setting: &Setting<'_>, list: &mut Vec<Candidate>) {
    let motion = (setting.motion)(site);
    let mut grid: Vec<Inner> = vec![Vec::new()];
    let is_inner = |p: &&EffectParameter| !matches!(p.role, Role::Amplitude | Role::Direction { .. });
    for parameter in effect.parameters.iter().filter(is_inner) {
        let mut points = points(parameter, setting, (site, motion));
        match parameter.scan {
            Scan::Frequencies => {
                points.extend((setting.lines)(site).into_iter().map(|f| f.clamp(parameter.low, parameter.high)));
            }
            Scan::Orders => {
                points.extend((setting.orders)(site).into_iter().flat_map(|found| found.list.iter().copied()));
            }
            _ => {}
        }
        grid = grid
            .into_iter()
            .flat_map(|inner| points.iter().map(move |value| [inner.clone(), vec![(parameter.name, *value)]].concat()))
            .collect();
    }
    let mut points: Vec<(Inner, usize)> = Vec::with_capacity(grid.len());
    for inner in grid {
        let picked = |(name, value): &(&str, f64)| {
            match effect.parameter(name).map(|parameter| parameter.scan) {
                Some(Scan::Frequencies) => Some((setting.looked, (setting.lines)(site))),
                Some(Scan::Orders) => (setting.orders)(site).map(|found| (found.looked, found.list.clone())),
                _ => None,
            }
            .filter(|(_, list)| list.contains(value))
        };
        let tries = inner.iter().find_map(picked).map_or(1, |(looked, list)| looked.max(1) / list.len().max(1));
        points.push((inner, tries));
    }
    points.extend(points.first().map_or_else(Vec::new, |(inner, _)| jumping(effect, inner, site, setting)));
    let directions = directions(effect, setting.planar);
    let first = &effect.parameters[0];
    let one_sided = first.low >= 0.0 && directions.len() == 1 && effect.amplitudes() == 1;
    let amplitudes = amplitudes(effect);
    for ((inner, tries), at) in
        points.into_iter().flat_map(|point| amplitudes.iter().map(move |at| (point.clone(), *at)))
    {
        list.push(Candidate {
            effect,
            site: site.clone(),
            inner,
            directions: directions.clone(),
            one_sided,
            high: first.high,
            at,
            felt: None,
            tries: tries.max(1),
        });
    }
}

/// Grid points of laws that begin at a jump of the innovations, and last to the end or to the next
/// ones, with how many they were picked from.
fn jumping(effect: &Effect, inner: &Inner, site: &Site, setting: &Setting<'_>) -> Vec<(Inner, usize)> {
    let place = |role: Role| {
        let parameter = effect.with_role(role)?;
        inner.iter().position(|(own, _)| *own == parameter.name).map(|place| (place, parameter))
    };
    let Some((begin, onset)) = place(Role::Onset) else { return Vec::new() };
    let instants = (setting.instants)(site);
    let allows = |p: &EffectParameter, value: f64| (p.low..=p.high).contains(&value);
    let at = |values: &[(usize, f64)]| {
        let mut inner = inner.clone();
        values.iter().for_each(|(place, value)| inner[*place].1 = *value);
        inner
    };
    let mut points = Vec::new();
    for (i, from) in instants.iter().enumerate().filter(|(_, from)| allows(onset, **from)) {
        points.push((at(&[(begin, *from)]), setting.samples / instants.len()));
        let Some((lasts, duration)) = place(Role::Duration) else { continue };
        for until in instants[i + 1..].iter().filter(|until| allows(duration, *until - from)) {
            points.push((at(&[(begin, *from), (lasts, until - from)]), setting.samples));
        }
    }
    points
}

/// Amplitudes at which a law is evaluated: one that is felt a little, and given ones where its
/// shape depends on it.
fn amplitudes(effect: &Effect) -> Vec<Option<f64>> {
    let first = &effect.parameters[0];
    let Scan::TimesDefault(factors) = first.scan else { return vec![None] };
    let given = factors.iter().map(|factor| Some((factor * first.default).clamp(first.low, first.high)));
    core::iter::once(None).chain(given).collect()
}

/// The angle that turns the amplitude, and how often the law repeats while the angle turns once.
fn turn(effect: &'static Effect) -> Option<(&'static EffectParameter, f64)> {
    effect.parameters.iter().find_map(|parameter| match parameter.role {
        Role::Direction { repeats } => Some((parameter, repeats)),
        _ => None,
    })
}

/// Directions that span the amplitudes or their angle.
fn directions(effect: &'static Effect, planar: bool) -> Vec<Direction> {
    if effect.amplitudes() > 1 {
        let felt = |p: &&EffectParameter| !(planar && p.out_of_plane);
        let names = || effect.parameters.iter().take(effect.amplitudes()).filter(felt).map(|p| p.name);
        let along = |k: usize| names().enumerate().map(|(i, name)| (name, if i == k { 1.0 } else { 0.0 })).collect();
        return (0..names().count()).map(along).collect();
    }
    let Some((angle, repeats)) = turn(effect) else { return vec![Vec::new()] };
    let quarter = core::f64::consts::FRAC_PI_2 / repeats;
    vec![vec![(angle.name, 0.0)], vec![(angle.name, quarter)]]
}

/// Values of one shape parameter that the score tests; see [`Scan`].
fn points(parameter: &EffectParameter, setting: &Setting<'_>, (site, motion): (&Site, Option<Motion>)) -> Vec<f64> {
    let default = || vec![parameter.default];
    let times = |shares: &[f64], of: f64| clamped(parameter, shares.iter().map(|share| share * of));
    let range = motion.map_or(0.0, |m| m.high - m.low);
    let rate = motion.map_or(0.0, |m| m.rate_rms);
    let duration = setting.duration_s;
    match parameter.scan {
        Scan::At(value) => vec![value],
        Scan::Each(values) => values.to_vec(),
        Scan::TimesDefault(factors) => times(factors, parameter.default),
        Scan::OfRate(shares) if rate > 0.0 => times(shares, rate),
        Scan::OfSampling(shares) => times(shares, 1.0 / setting.period_s),
        Scan::OfRange(shares) if range > 0.0 => times(shares, range),
        Scan::OfRangeFollowed(shares) if range > 0.0 => {
            let finest = 2.0 * motion.map_or(0.0, |m| m.rate_max) * setting.period_s;
            clamped(parameter, shares.iter().map(|share| (share * range).max(finest)))
        }
        Scan::FromLow(shares) => {
            motion.map_or_else(default, |m| shares.iter().map(|share| m.low + share * range).collect())
        }
        Scan::FromHigh(shares) => {
            motion.map_or_else(default, |m| shares.iter().map(|share| m.high + share * range).collect())
        }
        Scan::Inside => {
            let inside = motion.is_none_or(|m| m.low <= 0.0 && m.high >= 0.0);
            vec![if inside { 0.0 } else { motion.map_or(0.0, |m| 0.5 * (m.low + m.high)) }]
        }
        Scan::SpecificForce => (setting.specific_force)(site).map_or_else(default, |own| clamped(parameter, [own])),
        Scan::DurationOver(parts) => clamped(parameter, [duration / parts]),
        Scan::Frequencies => frequencies(parameter, setting),
        Scan::Orders => orders(parameter, setting, range, rate),
        Scan::Onsets => (0..TIMES).map(|i| setting.begin_s + duration * (i as f64 + 0.5) / TIMES as f64).collect(),
        Scan::Durations => vec![parameter.default, duration / 4.0],
        Scan::Default | Scan::OfRate(_) | Scan::OfRange(_) | Scan::OfRangeFollowed(_) => default(),
    }
}

/// Within the plausible range, neighbours that are equal once.
fn clamped(parameter: &EffectParameter, values: impl IntoIterator<Item = f64>) -> Vec<f64> {
    let mut list: Vec<f64> = values.into_iter().map(|value| value.clamp(parameter.low, parameter.high)).collect();
    list.dedup();
    list
}

/// From three periods over the recording to a third of its rate, equally spaced in their logarithm.
fn frequencies(parameter: &EffectParameter, setting: &Setting<'_>) -> Vec<f64> {
    let low = (3.0 / setting.duration_s).max(parameter.low);
    let high = (0.35 / setting.period_s).min(parameter.high).max(low);
    let step = libm::pow(high / low, 1.0 / (FREQUENCIES - 1) as f64);
    (0..FREQUENCIES).map(|i| low * step.powi(i as i32)).collect()
}

/// Customary orders with at least a period over the range travelled (less is a scale or a spring,
/// not a ripple) and at most what the sampling rate resolves.
fn orders(parameter: &EffectParameter, setting: &Setting<'_>, range: f64, rate: f64) -> Vec<f64> {
    const CUSTOMARY: [f64; 14] = [1.0, 2.0, 3.0, 4.0, 6.0, 8.0, 12.0, 16.0, 24.0, 32.0, 48.0, 64.0, 100.0, 160.0];
    let turn = core::f64::consts::TAU;
    let fastest = 0.3 * turn / setting.period_s / rate.max(1e-12);
    let slowest = turn / range.max(1e-12);
    let resolved: Vec<f64> = CUSTOMARY.into_iter().filter(|n| *n >= slowest && *n <= fastest).collect();
    if resolved.is_empty() { clamped(parameter, [slowest.min(fastest)]) } else { resolved }
}

/// Range and rates of a site's coordinate along the filtered trajectories.
pub(crate) fn motion(plant: &Plant, linears: &[Linear], site: &Site) -> Option<Motion> {
    let name = match site.kind {
        SiteKind::Joint => format!("joint:{}", site.name),
        SiteKind::Tank => format!("tank:{}", site.name),
        SiteKind::Mode => format!("mode:{}", site.name),
        SiteKind::Actuator => match &plant.actuator(&site.name)?.kind {
            dynamics::description::ActuatorKind::Wheel { .. } => return wheel(linears, &site.name),
            dynamics::description::ActuatorKind::JointTorque { joint }
            | dynamics::description::ActuatorKind::Motor { joint, .. } => format!("joint:{joint}"),
            _ => return None,
        },
        SiteKind::Sensor => match &plant.sensor(&site.name)?.kind {
            dynamics::description::SensorKind::Encoder { joint } => format!("joint:{joint}"),
            _ => return None,
        },
        SiteKind::Body => return None,
    };
    let mut motion = Motion { low: f64::INFINITY, high: f64::NEG_INFINITY, rate_rms: 0.0, rate_max: 0.0 };
    let (mut square, mut count) = (0.0, 0usize);
    for linear in linears {
        let names = &linear.state_names;
        let q = names.iter().position(|state| *state == name)?;
        let v = names.iter().position(|state| *state == format!("{name}.rate"))?;
        for x in linear.states.chunks(names.len()).skip(3) {
            motion.low = motion.low.min(x[q]);
            motion.high = motion.high.max(x[q]);
            motion.rate_max = motion.rate_max.max(x[v].abs());
            square += x[v] * x[v];
            count += 1;
        }
    }
    motion.rate_rms = (square / count.max(1) as f64).sqrt();
    (count > 0).then_some(motion)
}

fn wheel(linears: &[Linear], name: &str) -> Option<Motion> {
    let mut motion = Motion { low: 0.0, high: 0.0, rate_rms: 0.0, rate_max: 0.0 };
    let (mut square, mut count) = (0.0, 0usize);
    for linear in linears {
        let v = linear.state_names.iter().position(|state| *state == format!("wheel:{name}"))?;
        for x in linear.states.chunks(linear.state_names.len()) {
            motion.rate_max = motion.rate_max.max(x[v].abs());
            square += x[v] * x[v];
            count += 1;
        }
    }
    motion.rate_rms = (square / count.max(1) as f64).sqrt();
    motion.high = motion.rate_rms * 10.0;
    Some(motion)
}
