//! What the arcs of one craft say together, generation by generation, beside the truth.

use crate::identify::base::{self, BaseRow};
use crate::identify::conflicts::{self, Conflict};
use crate::identify::status;
use crate::outcome::missing::MissingOutcome;
use crate::scenario_run::ScenarioRun;
use craft::fold::fold;
use craft::message::{Received, received};
use craft::parameters::Parameters;
use dynamics::description::{BaseValue, Plant};
use nalgebra::{DMatrix, DVector, SymmetricEigen};
use plant_file::scenario::{ArcExperiment, ArcPlan, CraftPlan};
use recording::RecordedRun;
use serde_json::{Value, json};
use telemetry::{ESTIMATE_JOINT, INFORMATION, Information, JointEstimate, JointVerdict, ParameterBlock};

/// A parameter whose sigma is above this share of its value takes no part in the ratio of errors
/// and bounds: its estimate is its prior's.
const BOUND_SHARE_MAX: f64 = 0.2;

/// A parameter of the whole craft.
pub struct JointRow {
    pub name: String,
    /// Its block of parameters, or `base`: a base parameter, which motion alone can tell.
    pub block: &'static str,
    pub unit: String,
    pub truth: f64,
    pub prior: f64,
    pub prior_sigma: f64,
    pub value: f64,
    pub sigma: f64,
    pub status: &'static str,
}

impl JointRow {
    /// Error in standard deviations.
    #[must_use]
    pub fn z(&self) -> f64 {
        (self.value - self.truth) / self.sigma
    }

    /// Its bound says something of it: below a fifth of the truth.
    #[must_use]
    pub fn is_bounded(&self) -> bool {
        self.sigma < BOUND_SHARE_MAX * self.truth.abs()
    }
}

/// What one arc says of the model, and of the others.
pub struct ArcRow {
    pub arc: String,
    pub chi2_per_row: f64,
    /// By block: how often arcs of one craft differ as much.
    pub p_between: Vec<(ParameterBlock, f64)>,
}

/// The posterior of one generation of messages.
pub struct Generation {
    pub number: u16,
    pub rows: Vec<JointRow>,
    pub arcs: Vec<ArcRow>,
    pub step_sigma: Option<f64>,
    /// `e' P⁻¹ e / rank P` of the errors e of the base parameters and their covariance P: 1 on
    /// average.
    pub nees: Option<f64>,
}

/// What the supervisor says in the end.
pub struct JointOutcome {
    pub generations: Vec<Generation>,
    pub verdict: JointVerdict,
    /// The arc that the verdict speaks of.
    pub verdict_arc: Option<String>,
    /// The arc that was predicted, mean square of its innovations, and how often a true model's are
    /// as far off.
    pub predicted: Option<(String, f64, f64)>,
    /// What a refused model lacks, where the supervisor asked.
    pub missing: Option<MissingOutcome>,
}

impl JointOutcome {
    /// Of a run that flew one craft; `None` of any other.
    #[must_use]
    pub fn read(run: &ScenarioRun, recorded: &RecordedRun) -> Option<Self> {
        let plan = run.scenario.craft.as_ref()?;
        let parameters = Parameters::of(plan).ok()?;
        let flown = sensor_sim::craft::flown(plan, plan.arcs.first()?, run.config.seed).ok()?;
        let period_s = run.config.period_ns as f64 * 1e-9;
        let missing = MissingOutcome::read(plan, &parameters, period_s, recorded);
        let nominal = plan.known(plan.arcs.first()?).ok()?;
        let craft = |one: &JointEstimate| {
            let augmented = missing.as_ref().and_then(MissingOutcome::augmented);
            let augmented = augmented.filter(|(_, parameters)| parameters.hash == one.parameter_hash);
            let (known, parameters) =
                augmented.map_or((&nominal, &parameters), |(plant, parameters)| (plant, parameters));
            Craft { plan, parameters, known, flown: &flown, recorded }.generation(one)
        };
        // a point that is announced before any message of its model is no posterior
        let is_posterior = |one: &&JointEstimate| one.messages > 0 || one.verdict != JointVerdict::Undecided.code();
        let all: Vec<&JointEstimate> =
            recorded.of(ESTIMATE_JOINT).map(|(_, sample)| sample).filter(is_posterior).collect();
        let last = all.last()?;
        // the last word of a generation stands
        let is_last =
            |(k, one): &(usize, &&JointEstimate)| all.get(k + 1).is_none_or(|next| next.generation != one.generation);
        let generations = all.iter().enumerate().filter(is_last);
        let generations = generations.map(|(_, one)| craft(one)).collect();
        let held_out = plan.arcs.iter().find(|arc| arc.experiment == ArcExperiment::HeldOut);
        let predicted = held_out.filter(|_| last.held_out_chi2_per_row.is_finite());
        Some(Self {
            generations,
            verdict: JointVerdict::from_code(last.verdict).unwrap_or(JointVerdict::Undecided),
            verdict_arc: plan.arcs.get(usize::from(last.verdict_arc)).map(|arc| arc.name.clone()),
            predicted: predicted.map(|arc| (arc.name.clone(), last.held_out_chi2_per_row, last.held_out_p)),
            missing,
        })
    }

    /// Root mean square of error over sigma, over the parameters (base parameters where there are
    /// any) of the last generation whose sigma
    /// is below a fifth of the truth.
    #[must_use]
    pub fn bound_ratio(&self) -> Option<f64> {
        let rows = &self.generations.last()?.rows;
        let has_base = rows.iter().any(|row| row.block == "base");
        let known = |row: &&JointRow| row.is_bounded() && (row.block == "base") == has_base;
        let squares: Vec<f64> = rows.iter().filter(known).map(|row| row.z().powi(2)).collect();
        (!squares.is_empty()).then(|| (squares.iter().sum::<f64>() / squares.len() as f64).sqrt())
    }

    /// Parameters of the last generation that contradict their priors.
    #[must_use]
    pub fn conflicts(&self) -> Vec<Conflict> {
        let rows = self.generations.last().map_or(&[][..], |last| &last.rows);
        let physical = rows.iter().filter(|row| row.block != "base");
        conflicts::conflicts(physical.map(|row| (&row.name[..], [row.value, row.sigma], [row.prior, row.prior_sigma])))
    }

    /// The supervisor's words; of an accepted model also what of it contradicts its priors.
    #[must_use]
    pub fn words(&self) -> String {
        let arc = self.verdict_arc.as_ref().map_or(String::new(), |arc| format!(" ({arc})"));
        let off = if self.verdict == JointVerdict::Accepted { self.conflicts() } else { Vec::new() };
        let off: Vec<String> =
            off.iter().map(|one| format!("{} by {:.1} sigma", one.name, one.distance_sigma.abs())).collect();
        let but = if off.is_empty() { String::new() } else { format!(", against the priors of {}", off.join(", ")) };
        format!("{}{arc}{but}", self.verdict.text())
    }

    /// What `--json` shows of it, by key.
    #[must_use]
    pub fn json(&self) -> [(&'static str, Value); 6] {
        let predicted = self.predicted.iter().map(|(arc, chi2, p)| json!({ "arc": arc, "chi2_per_row": chi2, "p": p }));
        [
            ("generations", self.generations.iter().map(Generation::json).collect()),
            ("joint_bound_ratio", json!(self.bound_ratio())),
            ("prior_conflicts", conflicts::object(&self.conflicts())),
            ("predicted", predicted.collect()),
            ("diagnosis", json!(self.missing.as_ref().map(MissingOutcome::json))),
            (
                "verdict",
                json!({ "accepted": self.verdict == JointVerdict::Accepted, "reason": self.words(), "arc": self.verdict_arc }),
            ),
        ]
    }
}

impl Generation {
    fn json(&self) -> Value {
        let parameters = self.rows.iter().map(|row| {
            json!({ "name": row.name, "block": row.block, "unit": row.unit, "truth": row.truth, "prior": row.prior,
                "prior_sigma": row.prior_sigma, "value": row.value, "sigma": row.sigma, "status": row.status, "z": row.z() })
        });
        let noise = self.arcs.iter().map(|row| json!({ "arc": row.arc, "value": row.chi2_per_row }));
        let between = self.arcs.iter().flat_map(|row| {
            row.p_between.iter().map(|(block, p)| json!({ "arc": row.arc, "block": block.text(), "p": p }))
        });
        json!({
            "generation": self.number, "step_sigma": self.step_sigma, "nees": self.nees, "parameters": parameters.collect::<Vec<_>>(),
            "chi2_per_row": noise.collect::<Vec<_>>(), "between_message": between.collect::<Vec<_>>(),
        })
    }
}

/// What a run flew, and what it recorded.
struct Craft<'a> {
    plan: &'a CraftPlan,
    parameters: &'a Parameters,
    /// What is known of the craft, with what was found to be missing.
    known: &'a Plant,
    flown: &'a Plant,
    recorded: &'a RecordedRun,
}

impl Craft<'_> {
    fn generation(&self, sample: &JointEstimate) -> Generation {
        let count = usize::from(sample.count).min(self.parameters.len());
        let truth = self.flown.parameters();
        let of = |name: &str| truth.iter().find(|p| p.name == name).map_or(f64::NAN, |p| p.value);
        let row = |i: usize| {
            let unknown = &self.parameters.unknowns[i];
            JointRow {
                name: unknown.name.clone(),
                block: self.parameters.blocks[i].text(),
                unit: unknown.unit.clone(),
                truth: of(&unknown.name),
                prior: unknown.prior,
                prior_sigma: unknown.sigma,
                value: sample.theta[i],
                sigma: sample.sigma[i],
                status: status(sample.sigma[i], unknown.sigma),
            }
        };
        let arc = |(k, arc): (usize, &ArcPlan)| {
            let p = |block: &ParameterBlock| (*block, sample.p_between[k][usize::from(block.code())]);
            ArcRow {
                arc: arc.name.clone(),
                chi2_per_row: sample.chi2_per_row[k],
                p_between: ParameterBlock::ALL.iter().map(p).filter(|(_, p)| p.is_finite()).collect(),
            }
        };
        let arcs = self.plan.arcs.iter().enumerate().map(arc).filter(|row| row.chi2_per_row.is_finite());
        let mut rows: Vec<JointRow> = (0..count).map(row).collect();
        let (base, nees) = self.base_rows(sample).unwrap_or_default();
        rows.extend(base);
        Generation {
            number: sample.generation,
            rows,
            arcs: arcs.collect(),
            step_sigma: Some(sample.step_sigma).filter(|step| step.is_finite()),
            nees,
        }
    }

    /// Base parameters of a planar craft, by the same fold of the same messages, and their
    /// [`Generation::nees`].
    fn base_rows(&self, sample: &JointEstimate) -> Option<(Vec<JointRow>, Option<f64>)> {
        let messages = INFORMATION.iter().flat_map(|topic| self.recorded.of(*topic)).map(|(_, message)| message);
        let of_generation = |one: &&Information| one.generation == sample.generation && one.held_out == 0;
        let heard: Vec<Received> =
            messages.filter(of_generation).filter_map(|one| received(one, self.parameters).ok()).collect();
        let knowledge = fold(self.parameters, &heard)?;
        let unknowns = &self.parameters.unknowns;
        let values = |theta: &[f64]| {
            let mut plant = self.known.clone();
            for (unknown, value) in unknowns.iter().zip(theta) {
                // names are the plant's own
                let _ = plant.set_parameter(&unknown.name, *value);
            }
            plant.planar_base_values()
        };
        let theta = self.parameters.values(&knowledge.mean);
        let (prior, sigma): (Vec<f64>, Vec<f64>) =
            unknowns.iter().map(|unknown| (unknown.prior, unknown.sigma)).unzip();
        let (rows, covariance) = base::propagated(&values, [&theta, &prior], &sigma, &knowledge.covariance()?);
        let row = |(row, truth): (BaseRow, BaseValue)| JointRow {
            status: status(row.sigma, row.prior_sigma),
            name: row.name,
            block: "base",
            unit: row.unit.into(),
            truth: truth.value,
            prior: row.prior,
            prior_sigma: row.prior_sigma,
            value: row.value,
            sigma: row.sigma,
        };
        let rows: Vec<JointRow> = rows.into_iter().zip(self.flown.planar_base_values()).map(row).collect();
        let nees = nees(&rows, &covariance);
        Some((rows, nees))
    }
}

/// Share of the largest eigenvalue of a correlation below which rounding of its differences
/// decides: where a plant file knows some parameters, base parameters of the others depend on each
/// other.
const EIGENVALUE_LEAST: f64 = 1e-8;

/// See [`Generation::nees`], over the directions in which the parameters vary; they are scaled to
/// unit variance first, having no common unit.
fn nees(rows: &[JointRow], covariance: &DMatrix<f64>) -> Option<f64> {
    let varied: Vec<usize> = (0..rows.len()).filter(|i| rows[*i].sigma > 0.0).collect();
    let (n, of) = (varied.len(), |i: usize| &rows[varied[i]]);
    let share = |i: usize, j: usize| covariance[(varied[i], varied[j])] / (of(i).sigma * of(j).sigma);
    let correlation = DMatrix::from_fn(n, n, share);
    let z = DVector::from_fn(n, |i, _| of(i).z());
    if n == 0 || correlation.iter().chain(z.iter()).any(|number| !number.is_finite()) {
        return None;
    }
    let SymmetricEigen { eigenvectors, eigenvalues } = SymmetricEigen::new(correlation);
    let least = EIGENVALUE_LEAST * eigenvalues.max();
    let turned = eigenvectors.tr_mul(&z);
    let kept = turned.iter().zip(&eigenvalues).filter(|(_, value)| **value > least);
    let (sum, rank) = kept.fold((0.0, 0), |(sum, rank), (z, value)| (sum + z * z / value, rank + 1));
    Some(sum / f64::from(rank))
}
