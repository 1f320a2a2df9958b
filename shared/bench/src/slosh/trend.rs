//! The published estimators over the length of the record: their damping gets worse with more data,
//! the bound better.

use super::{NAMES, PARAMETERS, Slosh, paper};
use crate::campaign::{Answer, Benchmark, Campaign, Cost, Method, Parameter, statistics};
use std::fmt::Write;

const LENGTHS_S: [f64; 5] = [100.0, 200.0, 300.0, 500.0, 1000.0];
/// Records for a median; the trend is a factor of ten.
const RECORDS_MAX: usize = 200;
const METHODS: &[Method] = &[super::method("tls-paper", &[]), super::method("iv-paper", &[])];

/// The first seconds of every record.
struct Shortened<'a>(&'a Slosh);

impl Benchmark for Shortened<'_> {
    fn name(&self) -> &'static str {
        self.0.name
    }

    fn parameters(&self) -> Option<Vec<Parameter>> {
        self.0.parameters()
    }

    fn methods(&self) -> &'static [Method] {
        METHODS
    }

    fn answers(&self, seed: u64, record: usize) -> Vec<Answer> {
        let (record, base_mass_kg) = (self.0.record(seed, record), self.0.settings.base_mass_kg);
        vec![
            paper::answer(paper::total_least_squares(&record, base_mass_kg)),
            paper::answer(paper::instrumental_variables(&record, base_mass_kg)),
        ]
    }

    fn costs(&self) -> Vec<Cost> {
        Vec::new()
    }
}

/// Median errors [%] of the published estimators beside the bound, one line per length of the
/// record.
pub(super) fn table(slosh: &Slosh, campaign: &Campaign) -> String {
    let mut text = format!(
        "Published estimators over the length of the record, median error % of {} (bound: one sigma):\n{:>7} {:>27} {:>27} {:>27}",
        NAMES.join(" / "),
        "s",
        "tls-paper",
        "iv-paper",
        "bound"
    );
    for duration_s in LENGTHS_S {
        let Some([tls, iv, bound]) = medians(slosh, campaign, duration_s) else { continue };
        let _ = write!(text, "\n{duration_s:>7.0} {:>27} {:>27} {:>27}", joined(&tls), joined(&iv), joined(&bound));
    }
    text
}

type Percent = [f64; PARAMETERS];

/// Of both methods, and the bound, at one length.
pub fn medians(slosh: &Slosh, campaign: &Campaign, duration_s: f64) -> Option<[Percent; 3]> {
    let mut short = slosh.clone();
    short.plant.simulation.duration_s = duration_s;
    let records = Campaign { trials: campaign.trials.min(RECORDS_MAX), ..*campaign };
    let (parameters, answers) = (short.parameters()?, records.run(&Shortened(&short), &|| ()));
    let reports = statistics(METHODS, &parameters, &answers);
    let median =
        |method: usize| std::array::from_fn(|i| reports[method].parameters[i].median_percent.unwrap_or(f64::NAN));
    let bound = std::array::from_fn(|i| 100.0 * parameters[i].bound / parameters[i].truth);
    Some([median(0), median(1), bound])
}

fn joined(percent: &Percent) -> String {
    let three = |value: &f64| match *value {
        value if value < 10.0 => format!("{value:.2}"),
        value => format!("{value:.0}"),
    };
    percent.iter().map(three).collect::<Vec<_>>().join(" / ")
}
