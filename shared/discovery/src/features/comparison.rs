//! One plant against one list of modes: residuals, and how well a set of changes explains them.

use super::changes::Change;
use super::frame::Frame;
use super::likelihood::{Each, Evidence, Factor, Group, Likelihood};
use super::peaks::MeasuredMode;
use dynamics::description::Plant;
use estimation::golden_section;
use identification::statistics::fisher_tail;
use nalgebra::DMatrix;

/// Number of matched modes below which changes of one parameter are not separable.
pub(super) const MODES_MIN: usize = 3;
/// A change that moves no feature by more than this is absent: rounding of the eigenvalues
/// [ln f, ln ζ].
const FEATURE_CHANGE_MIN: f64 = 1e-9;

/// A change in a set, with its amplitude.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Member {
    pub change: Change,
    pub amplitude: f64,
}

/// A change in its place in a set, with the amplitude that is best there.
#[derive(Clone)]
pub(super) struct Fitted {
    pub change: Change,
    pub amplitude: f64,
    pub sigma: f64,
    /// Of the whole set.
    pub likelihood: Likelihood,
    /// Features moved by it, beyond what the others of the set move.
    pub moved: Vec<f64>,
    pub p: f64,
    pub bic: f64,
}

/// Plant and measurement, and the likelihood between them.
pub(super) struct Comparison<'a> {
    pub plant: &'a Plant,
    pub name: &'a str,
    pub measured: &'a [MeasuredMode],
    pub frame: Frame,
    pub evidence: Evidence,
    /// Names, values and sigmas of the unknowns behind `evidence.prior`.
    pub unknowns: Vec<(String, f64, f64)>,
    pub residual: Vec<f64>,
    pub null: Likelihood,
}

impl<'a> Comparison<'a> {
    /// # Errors
    /// The plant or the modes cannot be compared, or too few of them belong together.
    pub fn new(plant: &'a Plant, name: &'a str, measured: &'a [MeasuredMode]) -> Result<Self, String> {
        let frame = Frame::new(plant, measured)?;
        if frame.pairs.len() < MODES_MIN {
            return Err(format!(
                "{} of {} measured modes belong to modes of the plant, {MODES_MIN} are needed to separate one change from another",
                frame.pairs.len(),
                measured.len()
            ));
        }
        let residual = frame.residual()?;
        let (prior, unknowns) = sensitivities(plant, &frame);
        let group = frame.rows.iter().map(|row| row.group).collect();
        let evidence = Evidence { sigma: frame.sigma.clone(), group, prior };
        let null = evidence.best(&residual);
        Ok(Self { plant, name, measured, frame, evidence, unknowns, residual, null })
    }

    /// The plant with a set of changes, one after another.
    pub fn changed(&self, members: &[Member]) -> Option<Plant> {
        let first = Some(self.plant.clone());
        members.iter().fold(first, |plant, member| member.change.applied(&plant?, member.amplitude))
    }

    /// Features moved by a set.
    pub fn moved(&self, members: &[Member]) -> Option<Vec<f64>> {
        if members.is_empty() {
            Some(vec![0.0; self.residual.len()])
        } else {
            self.frame.moved(&self.changed(members)?)
        }
    }

    /// Residual of some features behind a set.
    pub fn left(&self, members: &[Member], rows: &[usize]) -> Option<Vec<f64>> {
        let moved = self.moved(members)?;
        Some(rows.iter().map(|k| self.residual[*k] - moved[*k]).collect())
    }

    /// Amplitude of least objective of the member at `place` over the features `rows`, whose
    /// evidence is `evidence`.
    pub fn fit(
        &self,
        members: &[Member],
        place: usize,
        evidence: &Evidence,
        rows: &[usize],
    ) -> Option<(f64, Likelihood)> {
        let with = |amplitude: f64| {
            let mut set = members.to_vec();
            set[place].amplitude = amplitude;
            self.left(&set, rows)
        };
        let objective = |amplitude: f64| with(amplitude).map_or(f64::INFINITY, |left| evidence.best(&left).objective);
        let grid = members[place].change.grid(self.plant);
        let values: Vec<f64> = grid.iter().map(|a| objective(*a)).collect();
        let least = (0..grid.len()).min_by(|a, b| values[*a].total_cmp(&values[*b]))?;
        let (low, high) = (grid[least.saturating_sub(1)], grid[(least + 1).min(grid.len() - 1)]);
        let amplitude = golden_section::minimise(low, high, 18, objective);
        let amplitude = if objective(amplitude) <= values[least] { amplitude } else { grid[least] };
        let likelihood = evidence.best(&with(amplitude)?);
        likelihood.objective.is_finite().then_some((amplitude, likelihood))
    }

    /// Amplitudes of the members at `places`, each in turn, twice.
    pub fn refit(&self, members: &mut [Member], places: &[usize], evidence: &Evidence, rows: &[usize]) {
        let sweeps = if places.len() > 1 { 2 } else { 1 };
        for place in (0..sweeps).flat_map(|_| places.iter().copied()) {
            if let Some((amplitude, _)) = self.fit(members, place, evidence, rows) {
                members[place].amplitude = amplitude;
            }
        }
    }

    /// Indices of all features.
    pub fn all_rows(&self) -> Vec<usize> {
        (0..self.residual.len()).collect()
    }

    /// `change` in its place in a set, at its best amplitude; `others` are the set without it.
    ///
    /// `tried`: number of changes tested, which share the probability of a false alarm.
    pub fn fitted(&self, others: &[Member], place: usize, change: Change, tried: usize) -> Option<Fitted> {
        let mut set = others.to_vec();
        set.insert(place, Member { change, amplitude: 0.0 });
        let rows = self.all_rows();
        let before = self.left(others, &rows)?;
        // cheap before expensive: a change without effect at its largest amplitude is not fitted
        set[place].amplitude = *set[place].change.grid(self.plant).last()?;
        if self
            .left(&set, &rows)
            .is_some_and(|left| left.iter().zip(&before).all(|(a, b)| (a - b).abs() < FEATURE_CHANGE_MIN))
        {
            return None;
        }
        let (amplitude, likelihood) = self.fit(&set, place, &self.evidence, &rows)?;
        let mut own = |amplitude: f64| -> Option<Vec<f64>> {
            set[place].amplitude = amplitude;
            Some(self.left(&set, &rows)?.iter().zip(&before).map(|(after, before)| before - after).collect())
        };
        let moved = own(amplitude)?;
        if moved.iter().all(|m| m.abs() < FEATURE_CHANGE_MIN) {
            return None;
        }
        // linear about the amplitude
        let step = 1e-3 * amplitude;
        let slope: Vec<f64> = own(amplitude + step)?.iter().zip(&moved).map(|(a, b)| (a - b) / step).collect();
        let factor = self.evidence.factor(&likelihood.tau);
        let information = factor.form(&slope, &slope);
        let sigma = if information > 0.0 { (1.0 / information).sqrt() } else { f64::INFINITY };
        let null = self.evidence.best(&before).objective;
        let bic = likelihood.objective - null + libm::log(rows.len() as f64);
        let p = (self.chance(&factor, &before, &moved, others.len()) * tried as f64).min(1.0);
        let change = set.swap_remove(place).change;
        Some(Fitted { change, amplitude, sigma, likelihood, moved, p, bic })
    }

    /// Probability that a change gains as much where nothing is missing: Fisher's F.
    ///
    /// Both quadratic forms are taken under the covariance with the change, which the plant without
    /// it must meet as well. The scale of a group is estimated from its own features: the gain of
    /// the change in each group is divided by the remainder of that group, and the degrees of
    /// freedom are those of the shares (Satterthwaite 1946). The remainder of a group never counts
    /// as less than its covariance: a small remainder by chance is no precision.
    fn chance(&self, factor: &Factor, before: &[f64], moved: &[f64], others: usize) -> f64 {
        let after: Vec<f64> = before.iter().zip(moved).map(|(r, m)| r - m).collect();
        let of_groups = |r: &[f64]| -> Each {
            let solved = factor.solve(&nalgebra::DVector::from_row_slice(r));
            Group::ALL.map(|group| {
                (0..r.len()).filter(|k| self.evidence.group[*k] == group).map(|k| r[k] * solved[k]).sum::<f64>()
            })
        };
        let (left, own) = (of_groups(&after), of_groups(moved));
        let gained = (factor.form(before, before) - left.iter().sum::<f64>()).max(0.0);
        let total: f64 = own.iter().map(|own| own.max(0.0)).sum::<f64>().max(1e-300);
        let (mut scale, mut spread) = (0.0, 0.0);
        for group in Group::ALL.into_iter().filter(|group| self.evidence.has(*group)) {
            let freedom = self.evidence.count(group).saturating_sub(1 + others).max(1) as f64;
            let share = own[group as usize].max(0.0) / total;
            scale += share * (left[group as usize] / freedom).max(1.0);
            spread += share * share / freedom;
        }
        fisher_tail(gained / scale.max(1e-300), 1.0, 1.0 / spread.max(1e-300))
    }

    /// Standard deviations of all amplitudes of a set that were fitted together to the features
    /// `rows`, and the change of every feature along the uncertain directions, one standard
    /// deviation each (features × members).
    pub fn spread(&self, members: &[Member], rows: &[usize], tau: &Each) -> Option<(Vec<f64>, DMatrix<f64>)> {
        let moved = self.moved(members)?;
        let mut slopes = DMatrix::zeros(self.residual.len(), members.len());
        for place in 0..members.len() {
            let mut set = members.to_vec();
            let step = 1e-3 * set[place].amplitude;
            set[place].amplitude += step;
            let next = self.moved(&set)?;
            slopes
                .column_mut(place)
                .iter_mut()
                .zip(next.iter().zip(&moved))
                .for_each(|(s, (a, b))| *s = (a - b) / step);
        }
        let factor = self.evidence.part(rows).factor(tau);
        let own = slopes.select_rows(rows);
        let weighted: Vec<_> = (0..members.len()).map(|k| factor.solve(&own.column(k).into_owned())).collect();
        let information = own.transpose() * DMatrix::from_columns(&weighted);
        let covariance = nalgebra::Cholesky::new(information)?.inverse();
        let sigma = covariance.diagonal().iter().map(|v| v.max(0.0).sqrt()).collect();
        let root = nalgebra::Cholesky::new(covariance)?.l();
        Some((sigma, slopes * root))
    }
}

/// Derivatives of the features by every parameter with a prior, times its sigma.
fn sensitivities(plant: &Plant, frame: &Frame) -> (DMatrix<f64>, Vec<(String, f64, f64)>) {
    let mut columns: Vec<Vec<f64>> = Vec::new();
    let mut unknowns = Vec::new();
    for parameter in plant.parameters() {
        let Some(sigma) = parameter.sigma else { continue };
        if parameter.name.starts_with("initial") || parameter.name.starts_with("segment.") {
            continue;
        }
        let step = 1e-3 * sigma;
        let at = |value: f64| {
            let mut moved = plant.clone();
            moved.set_parameter(&parameter.name, value).ok()?;
            frame.moved(&moved)
        };
        let (Some(up), Some(down)) = (at(parameter.value + step), at(parameter.value - step)) else { continue };
        let column: Vec<f64> = up.iter().zip(&down).map(|(up, down)| (up - down) / (2.0 * step) * sigma).collect();
        if column.iter().any(|c| c.abs() > FEATURE_CHANGE_MIN) {
            columns.push(column);
            unknowns.push((parameter.name, parameter.value, sigma));
        }
    }
    (DMatrix::from_fn(frame.rows.len(), columns.len(), |i, j| columns[j][i]), unknowns)
}
