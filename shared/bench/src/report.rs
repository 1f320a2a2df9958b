//! Statistics of a campaign, as one JSON object and as a table beside the published figures.

use serde::Serialize;
use std::fmt::Write;

/// All methods on one problem.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    pub problem: &'static str,
    pub trials: usize,
    pub seed: u64,
    pub methods: Vec<MethodReport>,
    /// Said under the table.
    pub remarks: Vec<String>,
}

/// One method; what it cannot say (a covariance, an answer) is null.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MethodReport {
    pub name: &'static str,
    pub parameters: Vec<ParameterReport>,
    pub geomean_rmse_over_crlb: Option<f64>,
    /// Its relative standard deviation over campaigns of so many records.
    pub geomean_sd: Option<f64>,
    /// Mean over the records; equals `dof` when the covariance is honest.
    pub nees: Option<f64>,
    pub dof: usize,
    /// Records without any answer.
    pub failed: usize,
    /// Parameters not found, over all records.
    pub missed: usize,
    /// Things found that are not there, over all records.
    pub spurious: usize,
    /// Per mode the largest `1 − MAC` of any record.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub shape_error_max: Vec<f64>,
    pub us_per_sample: Option<f64>,
    pub ms_per_solve: Option<f64>,
}

/// One parameter over all records in which it was found.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ParameterReport {
    pub name: &'static str,
    pub truth: f64,
    pub median_percent: Option<f64>,
    pub p95_percent: Option<f64>,
    pub rmse_percent: Option<f64>,
    pub crlb_percent: f64,
    pub rmse_over_crlb: Option<f64>,
    /// Share of 95 % intervals that hold the truth.
    pub coverage95: Option<f64>,
    /// Published relative error, one record.
    pub paper_percent: Option<f64>,
}

impl Report {
    /// One line.
    pub fn json(&self) -> String {
        serde_json::to_string(self).expect("names and numbers always serialise") + "\n"
    }

    /// The report as text: one block per method, with the sources of bound and published errors
    /// below.
    pub fn table(&self) -> String {
        let mut text = format!("{}, {} records, seed {}\n", self.problem, self.trials, self.seed);
        for method in &self.methods {
            text.push('\n');
            method.append_to(&mut text);
        }
        text.push_str("\nErrors are relative; CRLB is the bound of this experiment, paper the published error (Table III TLS = IV, Table VI TLS and IV,\nTable IX SSI-COV) on one record of its own.\n");
        for remark in &self.remarks {
            let _ = writeln!(text, "\n{remark}");
        }
        text
    }
}

impl Report {
    /// A row for each method, as a table of Markdown.
    #[must_use]
    pub fn markdown(&self) -> String {
        let Report { problem, trials, seed, .. } = self;
        let mut text = format!(
            "| {problem}, {trials} records, seed {seed} | RMSE/CRLB | NEES (expected) | coverage of 95 % | RMSE [%] | failed, missed, spurious |\n|---|---|---|---|---|---|\n"
        );
        for method in &self.methods {
            let of = |f: &dyn Fn(&ParameterReport) -> Option<f64>, digits: usize| {
                method.parameters.iter().map(|own| number(f(own), digits)).collect::<Vec<_>>().join(" ")
            };
            let ratio = method.geomean_rmse_over_crlb;
            let _ = writeln!(
                text,
                "| {} | {} ± {} | {} ({}) | {} | {} | {}, {}, {} |",
                method.name,
                number(ratio, 3),
                number(ratio.zip(method.geomean_sd).map(|(mean, sd)| mean * sd), 3),
                number(method.nees, 2),
                method.dof,
                of(&|own| own.coverage95, 3),
                of(&|own| own.rmse_percent, 3),
                method.failed,
                method.missed,
                method.spurious
            );
        }
        text
    }
}

impl MethodReport {
    fn append_to(&self, text: &mut String) {
        let _ = writeln!(
            text,
            "{:<22} {:>12} {:>10} {:>10} {:>10} {:>10} {:>10} {:>9} {:>9}",
            self.name, "truth", "median %", "p95 %", "RMSE %", "CRLB %", "RMSE/CRLB", "cover 95", "paper %"
        );
        for row in &self.parameters {
            let _ = writeln!(
                text,
                "  {:<20} {:>12.6} {:>10} {:>10} {:>10} {:>10} {:>10} {:>9} {:>9}",
                row.name,
                row.truth,
                number(row.median_percent, 4),
                number(row.p95_percent, 4),
                number(row.rmse_percent, 4),
                number(Some(row.crlb_percent), 4),
                number(row.rmse_over_crlb, 3),
                number(row.coverage95, 3),
                number(row.paper_percent, 2)
            );
        }
        let _ = writeln!(
            text,
            "  geometric mean RMSE/CRLB {} +- {}   NEES {} for {}   failed {}   missed {}   spurious {}   {} us/sample   {} ms/solve",
            number(self.geomean_rmse_over_crlb, 3),
            number(self.geomean_rmse_over_crlb.zip(self.geomean_sd).map(|(mean, sd)| mean * sd), 3),
            number(self.nees, 2),
            self.dof,
            self.failed,
            self.missed,
            self.spurious,
            number(self.us_per_sample, 3),
            number(self.ms_per_solve, 3)
        );
        if !self.shape_error_max.is_empty() {
            let worst: Vec<String> = self.shape_error_max.iter().map(|error| format!("{error:.1e}")).collect();
            let _ = writeln!(text, "  largest 1 - MAC per mode {}", worst.join(" "));
        }
    }
}

/// Fixed point with `decimals` digits after it, three figures where those are all zero.
fn number(value: Option<f64>, decimals: usize) -> String {
    match value {
        None => "-".into(),
        Some(value) if value != 0.0 && value.abs() < 0.5 * 0.1_f64.powi(decimals as i32) => format!("{value:.2e}"),
        Some(value) => format!("{value:.decimals$}"),
    }
}
