//! Multiplicity correction: the effective number of hypotheses (Hunter–Worsley).
//!
//! Every law (an effect at a site) has the same share of the level, whatever the size of its grid.
//! Collinear laws count as one hypothesis: of the events that the score `|z_i|` of law `i` passes
//! its threshold `t`,
//!
//! ```text
//! P(∪ A_i) ≤ Σ P(A_i) − Σ over edges (i, j) of a tree of P(A_i ∩ A_j)
//! ```
//!
//! (Hunter, J. Appl. Prob. 13, 1976; Worsley, Biometrika 69, 1982). Each law is tied to the earlier
//! one that it is most collinear with, by the cosine between their columns once the plant's
//! parameters are projected off. Where all columns are orthogonal that is Bonferroni's bound; of
//! collinear laws one counts. For a set of laws the numbers are multiplied and divided by its
//! permutations, as the order of its members is no distinction.

use super::refit::free_parameters;
use crate::score::Column;
use identification::statistics::{chi_bar_squared_tail, normal_tail, normal_two_sided};

/// Level at which overlaps are taken. At a higher level they are larger, so that the bound holds
/// for all levels above it.
const OVERLAP_LEVEL: f64 = 1e-6;
/// Cosine below which the overlap of two laws is negligible at that level.
const OVERLAP_COSINE_MIN: f64 = 0.7;
/// Quadrature points of the overlap integral.
const OVERLAP_POINTS: usize = 64;

/// Effective number of hypotheses of each column.
#[derive(Clone, Debug, Default)]
pub struct Multiplicity {
    /// Effective number of laws.
    laws: f64,
    /// Grid points of each column's law.
    points: Vec<f64>,
    /// The amplitude has one sign only.
    one_sided: Vec<bool>,
}

impl Multiplicity {
    /// `cosine`: between two columns of one direction each once the unknowns are projected off,
    /// where it is known.
    ///
    /// Cost: O(laws²) cosines, one overlap integral for each law that has a collinear one.
    pub fn new(columns: &[Column], cosine: &dyn Fn(usize, usize) -> Option<f64>) -> Self {
        let law = |a: &Column, b: &Column| a.candidate.same_law(&b.candidate);
        let first = |c: &usize| !columns[..*c].iter().any(|other| law(other, &columns[*c]));
        let points = |own: &Column| columns.iter().filter(|c| law(c, own)).map(|c| c.candidate.tries as f64).sum();
        let firsts: Vec<usize> = (0..columns.len()).filter(first).collect();
        let mut multiplicity = Self {
            laws: firsts.len() as f64,
            points: columns.iter().map(points).collect(),
            one_sided: columns.iter().map(|own| own.candidate.one_sided).collect(),
        };
        let threshold = normal_two_sided(OVERLAP_LEVEL / multiplicity.laws.max(1.0));
        // a law with a grid or with shape parameters passes in more ways: the overlap of one of
        // them with another law is a small part of that
        let plain = |c: &usize| multiplicity.points[*c] == 1.0 && free_parameters(&columns[*c].candidate, 1) == 1;
        let plain: Vec<usize> = firsts.into_iter().filter(plain).collect();
        for (at, c) in plain.iter().enumerate() {
            let shared =
                plain[..at].iter().map(|other| multiplicity.shared(cosine(*c, *other), [*c, *other], threshold));
            multiplicity.laws -= shared.fold(0.0, f64::max);
        }
        multiplicity
    }

    /// Probability that one column passes where another has.
    fn shared(&self, cosine: Option<f64>, [a, b]: [usize; 2], threshold: f64) -> f64 {
        let Some(cosine) = cosine.filter(|cosine| cosine.abs() > OVERLAP_COSINE_MIN) else { return 0.0 };
        match [self.one_sided[a], self.one_sided[b]] {
            [true, true] => overlap(cosine.max(0.0), threshold),
            [false, false] => overlap(cosine.abs(), threshold),
            _ => 0.5 * overlap(cosine.abs(), threshold),
        }
    }

    /// Number of hypotheses that the p value of this column's law is multiplied by: effective
    /// number of laws × points of its grid.
    pub fn of(&self, column: usize) -> f64 {
        (self.laws * self.points[column]).max(1.0)
    }

    /// Factor on the p value of a set.
    pub fn price(&self, members: &[usize]) -> f64 {
        members.iter().enumerate().map(|(i, m)| self.of(*m) / (i + 1) as f64).product::<f64>().max(1.0)
    }

    /// p value of a set after the correction: χ² tail (χ̄² where an amplitude has one sign) of its
    /// likelihood `ratio` with `free` parameters, times the factor of `members`.
    pub fn p(&self, ratio: f64, free: usize, members: &[usize]) -> f64 {
        let one_sided = members.iter().any(|member| self.one_sided[*member]);
        (chi_bar_squared_tail(ratio, free, one_sided) * self.price(members)).min(1.0)
    }
}

/// `P(z₂ > t | z₁ > t)` of two standard normal variables with correlation `cosine`; for `t` well
/// above zero, where the tail is nearly exponential.
fn overlap(cosine: f64, t: f64) -> f64 {
    let spread = (1.0 - cosine * cosine).max(0.0).sqrt();
    let (mut both, mut one) = (0.0, 0.0);
    for i in 0..OVERLAP_POINTS {
        // equal shares of the exponential
        let beyond = -libm::log1p(-(i as f64 + 0.5) / OVERLAP_POINTS as f64) / t;
        let weight = libm::exp(-0.5 * beyond * beyond);
        one += weight;
        let off = t - cosine * (t + beyond);
        both += weight * if spread > 1e-9 { normal_tail(off / spread) } else { f64::from(u8::from(off <= 0.0)) };
    }
    both / one
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compete::subsets::tests::column;

    #[test]
    fn every_law_has_the_same_share_of_the_level_whatever_its_grid() {
        let tone = |tries| column("sensor_tone", "sensor:angle", tries);
        let columns =
            [column("sensor_bias", "sensor:angle", 1), tone(1), tone(400), column("sensor_scale", "sensor:angle", 1)];
        let multiplicity = Multiplicity::new(&columns, &|_, _| Some(0.0));
        assert!((multiplicity.price(&[0]) - 3.0).abs() < 1e-3, "{multiplicity:?}");
        assert!((multiplicity.price(&[2]) / 401.0 - 3.0).abs() < 1e-3, "{multiplicity:?}");
        // an unordered pair
        assert!((multiplicity.price(&[0, 3]) - 4.5).abs() < 3e-3, "{multiplicity:?}");
        let spent: f64 = (0..4).map(|c| columns[c].candidate.tries as f64 / multiplicity.of(c)).sum();
        assert!((spent - 1.0).abs() < 1e-3, "{spent}");
    }

    fn alike(kinds: [&str; 3], one_sided: [bool; 3]) -> [Column; 3] {
        let mut columns = kinds.map(|kind| column(kind, "sensor:angle", 1));
        columns.iter_mut().zip(one_sided).for_each(|(column, one_sided)| column.candidate.one_sided = one_sided);
        columns
    }

    const KINDS: [&str; 3] = ["sensor_bias", "sensor_scale", "sensor_drift"];

    #[test]
    fn of_collinear_laws_one_counts_and_an_opposite_of_one_sign_is_absent() {
        let laws = |one_sided: [bool; 3], cosine: f64| {
            let twins = |a: usize, b: usize| Some(if a + b == 1 { cosine } else { 0.0 });
            Multiplicity::new(&alike(KINDS, one_sided), &twins).price(&[0])
        };
        for (one_sided, cosine, expected) in [
            ([false; 3], -1.0, 2.0),
            ([true; 3], 1.0, 2.0),
            ([true; 3], -1.0, 3.0),
            // half of the passes of a law of both signs have the other sign
            ([true, false, false], 1.0, 2.5),
        ] {
            let found = laws(one_sided, cosine);
            assert!((found - expected).abs() < 1e-3, "{one_sided:?} {cosine}: {found}");
        }
    }

    /// Against a simulation: pairs of variables with that correlation, drawn until the first
    /// passes.
    #[test]
    fn the_overlap_is_what_a_count_finds() {
        let mut noise = crate::noise::Noise::new(5);
        for (cosine, t) in [(0.5, 2.0), (0.9, 2.0), (0.99, 2.5), (0.9999, 2.5)] {
            let (mut one, mut both) = (0usize, 0usize);
            for _ in 0..500_000 {
                let (z1, other) = (noise.normal(), noise.normal());
                if z1 > t {
                    one += 1;
                    both += usize::from(cosine * z1 + libm::sqrt(1.0 - cosine * cosine) * other > t);
                }
            }
            let (share, expected) = (both as f64 / one as f64, overlap(cosine, t));
            let sigma = (share * (1.0 - share) / one as f64).sqrt();
            assert!((share - expected).abs() < 4.0 * sigma + 3e-3, "{cosine} {t}: {share} {expected} ± {sigma}");
        }
        // far out by an integral in fine steps
        assert!((overlap(0.9999, 4.4) - 0.974).abs() < 2e-3, "{}", overlap(0.9999, 4.4));
        assert!(overlap(0.0, 4.4) < 1e-5 && overlap(1.0, 4.4) > 0.999);
    }

    /// The law itself: of collinear scores one passes no more often than the level, and more often
    /// than half of what Bonferroni allows.
    #[test]
    fn any_of_many_alike_passes_at_most_as_often_as_the_level() {
        let cosine = 0.98;
        let columns = alike(KINDS, [false; 3]);
        let multiplicity = Multiplicity::new(&columns, &|_, _| Some(cosine));
        let mut noise = crate::noise::Noise::new(7);
        const DRAWS: usize = 400_000;
        let level = 0.01;
        let passes = (0..DRAWS).filter(|_| {
            let common = noise.normal();
            let own = |noise: &mut crate::noise::Noise| {
                libm::sqrt(cosine) * common + libm::sqrt(1.0 - cosine) * noise.normal()
            };
            (0..3).map(|c| (own(&mut noise).powi(2), c)).any(|(square, c)| multiplicity.p(square, 1, &[c]) < level)
        });
        let share = passes.count() as f64 / DRAWS as f64;
        assert!(share < level && share > 0.5 * level, "{share}");
        assert!(multiplicity.price(&[0]) < 2.3, "{}", multiplicity.price(&[0]));
    }
}
