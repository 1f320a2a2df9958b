//! Every single effect, every pair and the promising triples, ranked under several noise
//! hypotheses.
//!
//! Which law is right depends on how much of the misfit is taken as noise: large disturbances hide
//! slow evidence, small ones overrate it. The whitened normal equations of all columns are
//! therefore taken under a few hypotheses between the adapted and the stated noise. The common
//! scale of the noise is maximised in closed form, and a subset is ranked by its best hypothesis:
//!
//! ```text
//! −2 ln p(S) = min over hypotheses of  n ln(χ²(S)/n) + ln|S_k|,    χ²(S) = χ² − gᵀ M⁻¹ g  (columns of S, nominal unknowns projected off)
//! BIC(S) = −2 ln p(S) + k ln n
//! ```
//!
//! Amplitudes keep their sign and nominal unknowns their range: a value that would leave it is held
//! at its bound. The hypotheses only rank and give starting values; the likelihoods that decide are
//! maximised over continuous noise.

use super::SET_MAX;
use super::multiplicity::Multiplicity;
use super::refit::free_parameters;
use crate::score::Column;
use identification::filter::NoiseModel;
use identification::fit::bounded::bounded;
use identification::fit::{EstimationSession, LinearisedProblem, Normal, parallel};
use nalgebra::{Cholesky, DMatrix, DVector};

/// A noise hypothesis with the normal equations of unknowns (in prior standard deviations) and
/// columns, (u + k) × (u + k).
pub(crate) struct NoiseHypothesis {
    pub noise: NoiseModel,
    log_determinant: f64,
    chi2: f64,
    /// All of them: unknowns first, then columns.
    matrix: DMatrix<f64>,
    right: DVector<f64>,
    /// Room of each unknown down and up [prior standard deviations].
    room: Vec<[f64; 2]>,
    /// Columns with the unknowns projected off.
    pub reduced: DMatrix<f64>,
    pub reduced_right: DVector<f64>,
    pub reduced_chi2: f64,
}

/// A set of effects and its result under the best hypothesis.
#[derive(Clone, Debug)]
pub struct Subset {
    /// Indices of columns.
    pub members: Vec<usize>,
    /// Number of free parameters.
    pub free: usize,
    /// BIC relative to no effect at its own best hypothesis.
    pub bic: f64,
    /// Noise of the hypothesis, at its maximised scale.
    pub noise: NoiseModel,
    /// Amplitudes of each member's directions.
    pub amplitudes: Vec<Vec<f64>>,
}

/// Subsets by size (one, two, three), each best first.
#[derive(Clone, Debug, Default)]
pub struct Ranking {
    pub sizes: Vec<Vec<Subset>>,
    pub multiplicity: Multiplicity,
}

/// Sets of each size whose likelihood is maximised. They trade work against the risk of missing the
/// right set; chosen, no derivation.
const SHORTLIST: [usize; SET_MAX] = [5, 4, 2];
/// Significance under a hypothesis, in multiples of the level, up to which a set is tested by its
/// likelihood. Ten leaves room for the gain by continuous noise; chosen, no derivation.
const SHORTLIST_LEVEL_FACTOR: f64 = 10.0;

impl Ranking {
    /// The best sets of distinct laws of each size that are significant under their hypothesis and
    /// that no smaller set beats: first the best of every size, then the second of every size.
    /// `samples`: logarithm of their number.
    pub fn shortlist(&self, columns: &[Column], samples: f64, alpha: f64) -> Vec<Subset> {
        let mut list: Vec<(usize, &Subset)> = Vec::new();
        let mut least = 0.0f64;
        for (ranked, most) in self.sizes.iter().zip(SHORTLIST) {
            let mut own: Vec<&Subset> = Vec::new();
            for subset in ranked {
                let ratio = subset.free as f64 * samples - subset.bic;
                let p = self.multiplicity.p(ratio, subset.free, &subset.members);
                let same = |other: &&&Subset| {
                    let law = |a: &usize, b: &usize| columns[*a].candidate.same_law(&columns[*b].candidate);
                    other.members.iter().zip(&subset.members).all(|(a, b)| law(a, b))
                };
                let known = own.iter().filter(same).count();
                if p < SHORTLIST_LEVEL_FACTOR * alpha && known == 0 && own.len() < most && subset.bic < least {
                    own.push(subset);
                }
            }
            // larger sets must beat the best smaller one
            least = own.first().map_or(least, |first| first.bic.min(least));
            list.extend(own.into_iter().enumerate());
        }
        list.sort_by_key(|(place, _)| *place);
        list.into_iter().map(|(_, subset)| subset.clone()).collect()
    }
}

/// Shares of the way from adapted to stated noise: of the inputs, of the colour and jitter of the
/// sensors, of their size. Chosen, no derivation; the last hypothesis is all noise as stated.
const HYPOTHESIS_SHARES: [[f64; 3]; 7] = [
    [0.0, 0.0, 0.0],
    [0.3, 0.0, 0.0],
    [0.6, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.5, 1.0, 0.0],
    [1.0, 1.0, 0.0],
    [1.0, 1.0, 1.0],
];
/// Largest work of one Gram matrix [multiplications].
const GRAM_WORK_MAX: f64 = 2e8;
/// Subsets of each size that are evaluated with their bounds, and pairs that are extended to
/// triples. They trade work against coverage; chosen, no derivation.
const CONSTRAINED_MAX: usize = 60;
const PAIRS_EXTENDED_MAX: usize = 25;

/// BIC within which two sets count as equal and keep the order of the catalogue: rounding and
/// convergence, not evidence.
pub const BIC_TIE: f64 = 0.5;

/// Ranks subsets of `columns` up to `size_max` under the hypotheses between `noise` and the stated
/// one, best first.
///
/// Cost: one Gram matrix of all columns for each hypothesis (O(samples × columns²), bounded by
/// `GRAM_WORK_MAX`), then small Cholesky factors for each subset.
pub fn rank(
    session: &EstimationSession<'_>,
    linearised: &LinearisedProblem,
    theta: &[f64],
    columns: &[Column],
    adapted: &NoiseModel,
    size_max: usize,
) -> Ranking {
    let noises = noise_hypotheses(session, adapted);
    let chosen = choose(session, linearised, theta, columns, &noises);
    let layout = Layout::new(session, columns, chosen);
    let raw: Vec<&Vec<f64>> = layout.groups.iter().flat_map(|g| &columns[g.column].raw).collect();
    let hypotheses: Vec<NoiseHypothesis> =
        parallel(noises.len(), session.threads, |i| NoiseHypothesis::new(session, linearised, theta, &raw, &noises[i]))
            .into_iter()
            .flatten()
            .collect();
    if hypotheses.is_empty() {
        return Ranking::default();
    }
    let samples = (session.samples + layout.unknowns) as f64;
    let null = hypotheses.iter().map(|hypothesis| hypothesis.objective(0.0, samples)).fold(f64::INFINITY, f64::min);
    let scorer = SubsetScorer { session, layout: &layout, hypotheses: &hypotheses, samples, null };
    let mut sizes: Vec<Vec<Subset>> = Vec::new();
    let groups = layout.groups.len();
    let mut last: Vec<Vec<usize>> = (0..groups).map(|g| vec![g]).collect();
    for size in 1..=size_max {
        let mut quick: Vec<(f64, Vec<usize>)> =
            last.iter().filter_map(|set| Some((scorer.quick(set)?, set.clone()))).collect();
        // sets of equal BIC keep the order of the catalogue
        quick.sort_by(|a, b| libm::round(a.0 / BIC_TIE).total_cmp(&libm::round(b.0 / BIC_TIE)).then(a.1.cmp(&b.1)));
        let mut looked: Vec<Subset> =
            quick.iter().take(CONSTRAINED_MAX).filter_map(|(_, set)| scorer.constrained(set)).collect();
        looked.sort_by(|a, b| {
            libm::round(a.bic / BIC_TIE).total_cmp(&libm::round(b.bic / BIC_TIE)).then(a.members.cmp(&b.members))
        });
        sizes.push(looked);
        if size == size_max {
            break;
        }
        let seeds: Vec<Vec<usize>> =
            if size == 1 { last } else { quick.into_iter().take(PAIRS_EXTENDED_MAX).map(|(_, set)| set).collect() };
        last = layout.extended(&seeds);
    }
    let cosine = |a: usize, b: usize| hypotheses[0].cosine(layout.place(a)?, layout.place(b)?);
    Ranking { sizes, multiplicity: Multiplicity::new(columns, &cosine) }
}

/// Noise from adapted to stated, geometrically; a variance below the stated one stays, and
/// hypotheses are scaled as a whole.
pub(crate) fn noise_hypotheses(session: &EstimationSession<'_>, adapted: &NoiseModel) -> Vec<NoiseModel> {
    let jitters = adapted.jitter_s.iter().any(|jitter| *jitter > 0.0);
    let coloured = jitters || adapted.pole.iter().any(|pole| pole.abs() > 0.05);
    let mut noises: Vec<NoiseModel> = Vec::new();
    for [inputs, colour, sizes] in HYPOTHESIS_SHARES {
        if colour == 0.0 && inputs > 0.0 && !coloured {
            continue;
        }
        let mut noise = adapted.clone();
        let lower_variance = |found: &mut [f64], stated: &[f64], share: f64| {
            found.iter_mut().zip(stated).for_each(|(sigma, stated)| {
                *sigma = libm::exp((1.0 - share) * libm::log(*sigma) + share * libm::log(stated.min(*sigma)));
            });
        };
        lower_variance(&mut noise.input_sigma, &session.noise.input_sigma, inputs);
        lower_variance(&mut noise.sensor_sigma, &session.noise.sensor_sigma, sizes);
        noise.pole.iter_mut().chain(&mut noise.jitter_s).for_each(|number| *number *= 1.0 - colour);
        if !noises.contains(&noise) {
            noises.push(noise);
        }
    }
    noises
}

/// Places of columns in the normal equations.
struct Layout {
    unknowns: usize,
    groups: Vec<Group>,
    same_law: Vec<Vec<bool>>,
}

struct Group {
    column: usize,
    /// First place behind the unknowns, and number of places.
    first: usize,
    count: usize,
    free: usize,
    /// Range of each amplitude.
    room: Vec<[f64; 2]>,
}

impl Layout {
    fn new(session: &EstimationSession<'_>, columns: &[Column], chosen: Vec<usize>) -> Self {
        let mut groups = Vec::with_capacity(chosen.len());
        let mut width = 0;
        for column in chosen {
            let (candidate, count) = (&columns[column].candidate, columns[column].raw.len());
            let free = free_parameters(candidate, count);
            let room = (0..count).map(|direction| candidate.linear_range(direction)).collect();
            groups.push(Group { column, first: width, count, free, room });
            width += count;
        }
        let law = |a: &Group, b: &Group| columns[a.column].candidate.same_law(&columns[b.column].candidate);
        let same_law = groups.iter().map(|a| groups.iter().map(|b| law(a, b)).collect()).collect();
        Self { unknowns: session.problem.unknowns.len(), groups, same_law }
    }

    /// Each seed with one more group of another law, sorted, once.
    fn extended(&self, seeds: &[Vec<usize>]) -> Vec<Vec<usize>> {
        let mut sets = std::collections::BTreeSet::new();
        for seed in seeds {
            for g in (0..self.groups.len()).filter(|g| !seed.iter().any(|s| self.same_law[*s][*g])) {
                let mut set = seed.clone();
                set.push(g);
                set.sort_unstable();
                sets.insert(set);
            }
        }
        sets.into_iter().collect()
    }

    /// Place of a column of one direction.
    fn place(&self, column: usize) -> Option<usize> {
        self.groups.iter().find(|group| group.column == column && group.count == 1).map(|group| group.first)
    }

    fn places(&self, set: &[usize]) -> Vec<usize> {
        set.iter().flat_map(|g| self.groups[*g].first..self.groups[*g].first + self.groups[*g].count).collect()
    }
}

/// Columns for the normal equations: the best of every law, then the best of all, as many as the
/// work allows.
fn choose(
    session: &EstimationSession<'_>,
    linearised: &LinearisedProblem,
    theta: &[f64],
    columns: &[Column],
    noises: &[NoiseModel],
) -> Vec<usize> {
    let most = (GRAM_WORK_MAX / session.samples.max(1) as f64).sqrt().max(24.0) as usize;
    if columns.len() <= most {
        return (0..columns.len()).collect();
    }
    let scores = |noise: &NoiseModel| crate::score::scores(session, linearised, theta, noise, columns);
    let mut best = vec![f64::NEG_INFINITY; columns.len()];
    for noise in [&noises[0], &noises[noises.len() - 1]] {
        let list = scores(noise);
        let largest = list.iter().flatten().map(|s| s.statistic).fold(1e-300, f64::max);
        for (best, score) in best.iter_mut().zip(list) {
            // shares of the best of a hypothesis: hypotheses differ in scale
            *best = best.max(score.map_or(f64::NEG_INFINITY, |s| s.statistic / largest));
        }
    }
    let mut order: Vec<usize> = (0..columns.len()).filter(|c| best[*c].is_finite()).collect();
    order.sort_by(|a, b| best[*b].total_cmp(&best[*a]).then(a.cmp(b)));
    let mut chosen: Vec<usize> = Vec::new();
    let fresh = |chosen: &[usize], c: usize| {
        !chosen.iter().any(|other| columns[*other].candidate.same_law(&columns[c].candidate))
    };
    for pass in 0..2 {
        for c in &order {
            if chosen.len() < most && !chosen.contains(c) && (pass == 1 || fresh(&chosen, *c)) {
                chosen.push(*c);
            }
        }
    }
    chosen.sort_unstable();
    chosen
}

impl NoiseHypothesis {
    /// Hypothesis of `noise` with the raw columns `extra`; `None` where a covariance is not
    /// positive.
    pub fn new(
        session: &EstimationSession<'_>,
        linearised: &LinearisedProblem,
        theta: &[f64],
        extra: &[&Vec<f64>],
        noise: &NoiseModel,
    ) -> Option<Self> {
        Self::of(session, theta, linearised.normal(session, theta, noise, extra)?, noise)
    }

    /// Hypothesis of `noise` from normal equations that hold the columns.
    pub fn of(session: &EstimationSession<'_>, theta: &[f64], normal: Normal, noise: &NoiseModel) -> Option<Self> {
        let (u, width) = (normal.unknowns, normal.right.len() - normal.unknowns);
        let chi2 = normal.chi2 + identification::fit::prior_chi2(session, theta);
        let log_determinant = normal.objective - chi2 + session.disturbance_price(noise);
        let (matrix, right, room) = (normal.matrix, normal.right, normal.room);
        let factor = Cholesky::new(matrix.view((0, 0), (u, u)).into_owned())?;
        let across = factor.l().solve_lower_triangular(&matrix.view((0, u), (u, width)).into_owned())?;
        let own = factor.l().solve_lower_triangular(&right.rows(0, u).into_owned())?;
        let reduced = matrix.view((u, u), (width, width)) - across.tr_mul(&across);
        let reduced_right = right.rows(u, width) - across.tr_mul(&own);
        let reduced_chi2 = chi2 - own.dot(&own);
        let noise = noise.clone();
        Some(Self { noise, log_determinant, chi2, matrix, right, room, reduced, reduced_right, reduced_chi2 })
    }

    /// `−2 ln p` with the scale of the noise maximised, for a decrease of χ².
    fn objective(&self, gain: f64, samples: f64) -> f64 {
        self.at(self.reduced_chi2 - gain, samples)
    }

    /// `−2 ln p` for the residual sum of squares `chi2` over `samples`: `n ln(χ²/n) + n + ln|S|`,
    /// scale of the noise maximised.
    pub fn at(&self, chi2: f64, samples: f64) -> f64 {
        samples * libm::log(chi2.max(f64::MIN_POSITIVE) / samples) + samples + self.log_determinant
    }

    /// Decrease of χ² by the columns at `places` and their amplitudes, unknowns free.
    fn gain(&self, places: &[usize]) -> Option<(f64, Vec<f64>)> {
        let k = places.len();
        if k == 1 {
            let (m, g) = (self.reduced[(places[0], places[0])], self.reduced_right[places[0]]);
            return self.seen(places[0]).then(|| (g * g / m, vec![g / m]));
        }
        if !places.iter().all(|p| self.seen(*p)) {
            return None;
        }
        let scale: Vec<f64> = places.iter().map(|p| 1.0 / self.reduced[(*p, *p)].sqrt()).collect();
        let matrix = DMatrix::from_fn(k, k, |i, j| {
            self.reduced[(places[i], places[j])] * scale[i] * scale[j] * if i == j { 1.0 + 1e-10 } else { 1.0 }
        });
        let right = DVector::from_fn(k, |i, _| self.reduced_right[places[i]] * scale[i]);
        let solved = Cholesky::new(matrix)?.solve(&right);
        Some((solved.dot(&right), solved.iter().zip(&scale).map(|(s, scale)| s * scale).collect()))
    }

    /// Cosine between two columns once the unknowns are projected off.
    fn cosine(&self, a: usize, b: usize) -> Option<f64> {
        let left = (self.reduced[(a, a)] * self.reduced[(b, b)]).sqrt();
        (self.seen(a) && self.seen(b)).then(|| self.reduced[(a, b)] / left)
    }

    /// The column is not collinear with the unknowns: more than 1e-7 of its square remains once
    /// they are projected off.
    pub fn seen(&self, place: usize) -> bool {
        let whole = self.matrix
            [(place + self.matrix.nrows() - self.reduced.nrows(), place + self.matrix.nrows() - self.reduced.nrows())];
        whole > 0.0 && self.reduced[(place, place)] > 1e-7 * whole
    }
}

struct SubsetScorer<'a> {
    session: &'a EstimationSession<'a>,
    layout: &'a Layout,
    hypotheses: &'a [NoiseHypothesis],
    samples: f64,
    null: f64,
}

impl SubsetScorer<'_> {
    fn free(&self, set: &[usize]) -> usize {
        set.iter().map(|g| self.layout.groups[*g].free).sum()
    }

    /// BIC at the best hypothesis under which no amplitude has the wrong sign; unknowns unbounded.
    fn quick(&self, set: &[usize]) -> Option<f64> {
        let places = self.layout.places(set);
        let best = self.hypotheses.iter().filter_map(|hypothesis| {
            let (gain, amplitudes) = hypothesis.gain(&places)?;
            self.possible(set, &amplitudes).then(|| hypothesis.objective(gain, self.samples))
        });
        let best = best.fold(f64::INFINITY, f64::min);
        best.is_finite().then(|| best - self.null + self.free(set) as f64 * libm::log(self.samples))
    }

    /// Every amplitude is possible for its effect.
    fn possible(&self, set: &[usize], amplitudes: &[f64]) -> bool {
        let mut at = 0;
        set.iter().all(|g| {
            let group = &self.layout.groups[*g];
            let own = &amplitudes[at..at + group.count];
            at += group.count;
            own.iter().zip(&group.room).all(|(a, [low, high])| (low..=high).contains(&a) && *a != 0.0)
        })
    }

    /// The same with the unknowns bounded to their ranges.
    fn constrained(&self, set: &[usize]) -> Option<Subset> {
        let mut best: Option<(f64, usize, f64, Vec<f64>)> = None;
        for (i, hypothesis) in self.hypotheses.iter().enumerate() {
            let Some((chi2, amplitudes)) = self.solve(hypothesis, set) else { continue };
            let objective = hypothesis.at(chi2, self.samples);
            if self.possible(set, &amplitudes) && best.as_ref().is_none_or(|best| objective < best.0) {
                best = Some((objective, i, chi2, amplitudes));
            }
        }
        let (objective, hypothesis, chi2, flat) = best?;
        let scale = (chi2 / self.samples).sqrt();
        let mut noise = self.hypotheses[hypothesis].noise.clone();
        noise
            .input_sigma
            .iter_mut()
            .zip(&self.session.noise.input_sigma)
            .for_each(|(s, floor)| *s = (*s * scale).max(*floor));
        noise.sensor_sigma.iter_mut().chain(&mut noise.jitter_s).for_each(|s| *s *= scale);
        let mut at = 0;
        let amplitudes = set.iter().map(|g| {
            let count = self.layout.groups[*g].count;
            at += count;
            flat[at - count..at].to_vec()
        });
        Some(Subset {
            members: set.iter().map(|g| self.layout.groups[*g].column).collect(),
            free: self.free(set),
            bic: objective - self.null + self.free(set) as f64 * libm::log(self.samples),
            noise,
            amplitudes: amplitudes.collect(),
        })
    }

    /// χ² and amplitudes; an unknown that would leave its range is held at its bound.
    fn solve(&self, hypothesis: &NoiseHypothesis, set: &[usize]) -> Option<(f64, Vec<f64>)> {
        let u = self.layout.unknowns;
        let places: Vec<usize> = (0..u).chain(self.layout.places(set).into_iter().map(|p| u + p)).collect();
        let (decrease, mut x) = bounded(&hypothesis.matrix, &hypothesis.right, &hypothesis.room, &places)?;
        Some((hypothesis.chi2 - decrease, x.split_off(u)))
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::score::Candidate;
    use catalogue::CATALOGUE;

    pub fn column(kind: &str, site: &str, tries: usize) -> Column {
        let effect = CATALOGUE.effect(kind).unwrap();
        let (site, directions) = (site.parse().unwrap(), vec![Vec::new()]);
        let candidate = Candidate {
            effect,
            site,
            inner: Vec::new(),
            directions,
            one_sided: false,
            high: 1.0,
            at: None,
            felt: None,
            tries,
        };
        Column { candidate, raw: Vec::new(), step: 1.0, push: None }
    }

    /// The normal equations of a hypothesis against the orthogonal projection that scores are made
    /// with.
    #[test]
    fn laws_are_as_alike_by_the_normal_equations_as_by_the_columns_that_the_scores_project() {
        let nominal = crate::synthetic::plant("drive_rig");
        let problem = crate::synthetic::problem(&nominal, crate::synthetic::recording(&nominal, 3, 1.0));
        let session = EstimationSession::new(&problem, 1).unwrap();
        let theta = session.prior();
        let linearised = LinearisedProblem::new(&session, &nominal, &theta, &session.noise).unwrap();
        let jumps = (&crate::score::Lines::default(), &[][..], &crate::score::Instants::default());
        let period_s = session.timelines[0].period_s;
        let list = crate::score::candidates(&problem, &nominal, &linearised.linears, period_s, jumps, &[]);
        let columns = crate::score::columns((&session, &linearised), &nominal, &theta, &list);
        let scores = crate::score::scores(&session, &linearised, &theta, &session.noise, &columns);
        let layout = Layout::new(&session, &columns, (0..columns.len()).collect());
        let raw: Vec<&Vec<f64>> = columns.iter().flat_map(|column| &column.raw).collect();
        let hypothesis = NoiseHypothesis::new(&session, &linearised, &theta, &raw, &session.noise).unwrap();
        let (mut compared, mut alike) = (0, 0);
        for a in 0..columns.len() {
            for b in 0..a {
                let (Some(first), Some(second)) = (&scores[a], &scores[b]) else { continue };
                let (Some(i), Some(j)) = (layout.place(a), layout.place(b)) else { continue };
                let Some(found) = hypothesis.cosine(i, j) else { continue };
                if first.kappa < 0.999 && second.kappa < 0.999 {
                    let sign = (first.amplitude[0] * second.amplitude[0]).signum();
                    let expected = sign * crate::score::cosine(first, second);
                    assert!((found - expected).abs() < 1e-3, "{a} {b}: {found} {expected}");
                    (compared, alike) = (compared + 1, alike + usize::from(found.abs() > 0.95));
                }
            }
        }
        assert!(compared > 100 && alike > 3, "{compared} {alike}");
    }

    #[test]
    fn the_best_of_every_size_is_met_before_the_second_of_any() {
        let kinds = ["joint_coulomb", "joint_stribeck", "joint_lugre", "joint_viscous"];
        let columns = kinds.map(|kind| column(kind, "joint:pivot", 1));
        let set = |members: &[usize], bic: f64| {
            let noise = NoiseModel { input_sigma: vec![], sensor_sigma: vec![], pole: vec![], jitter_s: vec![] };
            let (members, free) = (members.to_vec(), members.len());
            Subset { members, free, bic, noise, amplitudes: Vec::new() }
        };
        let singles = (0..4).map(|c| set(&[c], -500.0 + c as f64)).collect();
        let pairs = vec![set(&[0, 3], -700.0), set(&[1, 3], -600.0), set(&[2, 3], -400.0)];
        let ranking = Ranking { sizes: vec![singles, pairs], multiplicity: Multiplicity::new(&columns, &|_, _| None) };
        let order: Vec<Vec<usize>> = ranking.shortlist(&columns, 7.0, 0.01).into_iter().map(|s| s.members).collect();
        // a set that a smaller one beats is not tested
        let expected: [&[usize]; 6] = [&[0], &[0, 3], &[1], &[1, 3], &[2], &[3]];
        assert_eq!(order, expected);
    }
}
