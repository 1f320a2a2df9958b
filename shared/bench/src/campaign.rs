//! Records of a benchmark, drawn from one seed, worked on by all cores, folded in the order of
//! their numbers.
//!
//! Every random number is a function of (seed, record number, sensor, sample), so no thread can
//! disturb another.

use crate::report::{MethodReport, ParameterReport, Report};
use estimation::quantiles::{median, quantile};
use std::hint::black_box;
use std::num::NonZero;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

/// What is to be found, its true value, and the best standard deviation an unbiased estimator can
/// reach.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    pub name: &'static str,
    pub truth: f64,
    pub bound: f64,
}

/// A way to find it, and what the paper reports, one figure per parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Method {
    pub name: &'static str,
    /// Relative error [%] of the published method nearest to this one, one record.
    pub paper_percent: &'static [f64],
}

/// One parameter as a method found it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Found {
    pub value: f64,
    /// Standard deviation the method claims.
    pub sigma: Option<f64>,
}

/// What a method made of one record.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Answer {
    /// One per parameter; `None` where the method found nothing.
    pub found: Vec<Option<Found>>,
    /// Normalised estimation error squared, of all parameters together.
    pub nees: Option<f64>,
    /// Things found that are not there (modes).
    pub spurious: u32,
    /// Of each mode `1 − MAC` with the true shape; none where it was not found. Empty for what has
    /// no shapes.
    pub shape_errors: Vec<Option<f64>>,
}

impl Answer {
    /// The method gave no answer.
    pub fn none(parameters: usize) -> Self {
        Self { found: vec![None; parameters], ..Self::default() }
    }

    /// Values without any statement of their worth.
    pub fn bare(values: impl IntoIterator<Item = f64>) -> Self {
        Self { found: values.into_iter().map(|value| Some(Found { value, sigma: None })).collect(), ..Self::default() }
    }
}

/// Computation time of a method on one core.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cost {
    /// Taking one sample.
    pub us_per_sample: f64,
    /// Giving the answer once.
    pub ms_per_solve: f64,
}

/// Shortest of some runs on this thread: the others were disturbed.
pub(super) fn cost<T, R>(samples: usize, take: impl Fn() -> T, solve: impl Fn(&mut T) -> R) -> Cost {
    const RUNS: usize = 5;
    let (mut take_s, mut solve_s) = (f64::INFINITY, f64::INFINITY);
    for _ in 0..RUNS {
        let begin = Instant::now();
        let mut taken = black_box(take());
        let middle = Instant::now();
        black_box(solve(&mut taken));
        solve_s = solve_s.min(middle.elapsed().as_secs_f64());
        take_s = take_s.min((middle - begin).as_secs_f64());
    }
    Cost { us_per_sample: 1e6 * take_s / samples as f64, ms_per_solve: 1e3 * solve_s }
}

/// A problem with its truth.
pub trait Benchmark: Sync {
    fn name(&self) -> &'static str;
    /// `None` when the experiment leaves a parameter without trace.
    fn parameters(&self) -> Option<Vec<Parameter>>;
    fn methods(&self) -> &[Method];
    /// Bound of each method's own model, one list per method; `None` where all fit the model of
    /// [`Self::parameters`].
    fn method_bounds(&self) -> Option<Vec<Vec<f64>>> {
        None
    }
    /// One record, each method's answer.
    fn answers(&self, seed: u64, record: usize) -> Vec<Answer>;
    /// Each method on one record, this thread alone.
    fn costs(&self) -> Vec<Cost>;
    /// What is said under the table; may fly records of its own.
    fn remarks(&self, _campaign: &Campaign) -> Vec<String> {
        Vec::new()
    }
}

/// A number of records from one seed.
#[derive(Clone, Copy, Debug)]
pub struct Campaign {
    pub trials: usize,
    pub seed: u64,
    pub threads: usize,
}

impl Campaign {
    /// `trials` records from one seed, on all cores; panics without records.
    pub fn new(trials: usize, seed: u64) -> Self {
        assert!(trials > 0);
        Self { trials, seed, threads: std::thread::available_parallelism().map_or(1, NonZero::get) }
    }

    /// Answers record by record; `after_each` is called from any thread.
    pub fn run(&self, benchmark: &impl Benchmark, after_each: &(dyn Fn() + Sync)) -> Vec<Vec<Answer>> {
        self.each(&|record| benchmark.answers(self.seed, record), after_each)
    }

    /// `make` of every record on all threads, in the order of the records.
    pub fn each<T: Send>(&self, make: &(dyn Fn(usize) -> T + Sync), after_each: &(dyn Fn() + Sync)) -> Vec<T> {
        let next = AtomicUsize::new(0);
        let work = || {
            let mut done = Vec::new();
            loop {
                let record = next.fetch_add(1, Ordering::Relaxed);
                if record >= self.trials {
                    return done;
                }
                done.push((record, make(record)));
                after_each();
            }
        };
        let mut all = std::thread::scope(|scope| {
            let workers: Vec<_> = (0..self.threads.clamp(1, self.trials)).map(|_| scope.spawn(work)).collect();
            let join =
                |worker: std::thread::ScopedJoinHandle<'_, Vec<_>>| worker.join().expect("a worker only computes");
            workers.into_iter().flat_map(join).collect::<Vec<_>>()
        });
        all.sort_by_key(|(record, _)| *record);
        all.into_iter().map(|(_, made)| made).collect()
    }

    /// Statistics of the answers, with the measured times.
    pub fn report(&self, benchmark: &impl Benchmark, parameters: &[Parameter], answers: &[Vec<Answer>]) -> Report {
        let mut report = Report {
            problem: benchmark.name(),
            trials: self.trials,
            seed: self.seed,
            methods: statistics_against(benchmark.methods(), parameters, benchmark.method_bounds().as_deref(), answers),
            remarks: benchmark.remarks(self),
        };
        for (method, cost) in report.methods.iter_mut().zip(benchmark.costs()) {
            method.us_per_sample = Some(cost.us_per_sample);
            method.ms_per_solve = Some(cost.ms_per_solve);
        }
        report
    }
}

/// Statistics of each method over the records, without times, all against the bounds of
/// `parameters`.
pub fn statistics(methods: &[Method], parameters: &[Parameter], answers: &[Vec<Answer>]) -> Vec<MethodReport> {
    statistics_against(methods, parameters, None, answers)
}

/// The same, each method against the bounds of its own model.
pub fn statistics_against(
    methods: &[Method],
    parameters: &[Parameter],
    bounds: Option<&[Vec<f64>]>,
    answers: &[Vec<Answer>],
) -> Vec<MethodReport> {
    let of_method = |(index, method): (usize, &Method)| {
        let mine: Vec<&Answer> = answers.iter().map(|record| &record[index]).collect();
        let mut parameters = parameters.to_vec();
        if let Some(bounds) = bounds {
            parameters.iter_mut().zip(&bounds[index]).for_each(|(parameter, bound)| parameter.bound = *bound);
        }
        method_statistics(method, &parameters, &mine)
    };
    methods.iter().enumerate().map(of_method).collect()
}

fn method_statistics(method: &Method, parameters: &[Parameter], answers: &[&Answer]) -> MethodReport {
    let of_parameter = |(index, parameter): (usize, &Parameter)| {
        let found: Vec<Found> = answers.iter().filter_map(|answer| answer.found[index]).collect();
        parameter_statistics(parameter, &found, method.paper_percent.get(index).copied())
    };
    let rows: Vec<ParameterReport> = parameters.iter().enumerate().map(of_parameter).collect();
    let logarithms: Option<f64> = rows.iter().map(|row| row.rmse_over_crlb.map(f64::ln)).sum();
    let nees: Vec<f64> = answers.iter().filter_map(|answer| answer.nees).collect();
    MethodReport {
        name: method.name,
        geomean_sd: geomean_sd(parameters, answers),
        geomean_rmse_over_crlb: logarithms.map(|sum| (sum / rows.len() as f64).exp()),
        nees: mean(&nees),
        dof: parameters.len(),
        failed: answers.iter().filter(|answer| answer.found.iter().all(Option::is_none)).count(),
        missed: answers.iter().flat_map(|answer| &answer.found).filter(|found| found.is_none()).count(),
        spurious: answers.iter().map(|answer| answer.spurious as usize).sum(),
        shape_error_max: shape_errors(answers),
        us_per_sample: None,
        ms_per_solve: None,
        parameters: rows,
    }
}

/// Relative standard deviation of the geometric mean of the ratios, the correlation of the
/// parameters included: a record's share of it is half the mean of its squared errors over their
/// mean squares. `None` below two complete records.
fn geomean_sd(parameters: &[Parameter], answers: &[&Answer]) -> Option<f64> {
    let errors = |answer: &&Answer| -> Option<Vec<f64>> {
        answer
            .found
            .iter()
            .zip(parameters)
            .map(|(found, of)| Some((found.as_ref()?.value - of.truth).powi(2)))
            .collect()
    };
    let squares: Vec<Vec<f64>> = answers.iter().filter_map(errors).collect();
    let n = squares.len() as f64;
    let means: Vec<f64> = (0..parameters.len()).map(|i| squares.iter().map(|row| row[i]).sum::<f64>() / n).collect();
    let share = |row: &Vec<f64>| {
        0.5 * row.iter().zip(&means).map(|(square, mean)| square / mean - 1.0).sum::<f64>() / means.len() as f64
    };
    let variance = squares.iter().map(|row| share(row).powi(2)).sum::<f64>() / (n - 1.0);
    (squares.len() > 1).then(|| (variance / n).sqrt())
}

/// Worst of each mode over the records.
fn shape_errors(answers: &[&Answer]) -> Vec<f64> {
    let modes = answers.iter().map(|answer| answer.shape_errors.len()).max().unwrap_or(0);
    let of = |mode: usize| answers.iter().filter_map(move |answer| *answer.shape_errors.get(mode)?);
    (0..modes).map(|mode| of(mode).fold(0.0, f64::max)).collect()
}

fn parameter_statistics(parameter: &Parameter, found: &[Found], paper_percent: Option<f64>) -> ParameterReport {
    const QUANTILE_975: f64 = 1.959_963_984_540_054; // of the unit normal
    let error = |found: &Found| found.value - parameter.truth;
    let mut percent: Vec<f64> = found.iter().map(|found| 100.0 * (error(found) / parameter.truth).abs()).collect();
    let squares: Vec<f64> = found.iter().map(|found| error(found) * error(found)).collect();
    let is_found = !found.is_empty();
    let rmse = mean(&squares).map(f64::sqrt);
    let held: Vec<f64> = found
        .iter()
        .filter_map(|found| found.sigma.map(|sigma| f64::from(u8::from(error(found).abs() <= QUANTILE_975 * sigma))))
        .collect();
    ParameterReport {
        name: parameter.name,
        truth: parameter.truth,
        median_percent: is_found.then(|| median(&mut percent)),
        p95_percent: is_found.then(|| quantile(&mut percent, 0.95)),
        rmse_percent: rmse.map(|rmse| 100.0 * rmse / parameter.truth.abs()),
        crlb_percent: 100.0 * parameter.bound / parameter.truth.abs(),
        rmse_over_crlb: rmse.map(|rmse| rmse / parameter.bound),
        coverage95: mean(&held),
        paper_percent,
    }
}

fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Answers that name their record; slow for some, so that threads overtake each other.
    struct Named;

    impl Benchmark for Named {
        fn name(&self) -> &'static str {
            "named"
        }
        fn parameters(&self) -> Option<Vec<Parameter>> {
            None
        }
        fn methods(&self) -> &[Method] {
            &[]
        }
        fn answers(&self, seed: u64, record: usize) -> Vec<Answer> {
            let rounds = if record.is_multiple_of(7) { 200_000 } else { 10 };
            let value = (0..rounds).fold(record as f64, |value, _| std::hint::black_box(value));
            vec![Answer::bare([seed as f64, value])]
        }
        fn costs(&self) -> Vec<Cost> {
            Vec::new()
        }
    }

    #[test]
    fn answers_come_in_the_order_of_records_whatever_the_number_of_threads() {
        let alone = Campaign { trials: 100, seed: 3, threads: 1 }.run(&Named, &|| ());
        assert!(alone.iter().enumerate().all(|(k, answers)| answers[0] == Answer::bare([3.0, k as f64])));
        for threads in [2, 5, 200] {
            assert_eq!(Campaign { trials: 100, seed: 3, threads }.run(&Named, &|| ()), alone);
        }
    }

    #[test]
    fn statistics_of_known_errors_are_the_textbook_ones() {
        let parameter = Parameter { name: "a", truth: -2.0, bound: 0.1 };
        let method = Method { name: "m", paper_percent: &[7.0] };
        // Errors −0.1, 0.1, 0.3: 5, 5, 15 % of 2; intervals of 0.1 hold two of three.
        let found = |value| Answer {
            found: vec![Some(Found { value, sigma: Some(0.1) })],
            nees: Some(1.0),
            spurious: 1,
            ..Answer::default()
        };
        let answers: Vec<Vec<Answer>> = [-2.1, -1.9, -1.7].map(|value| vec![found(value)]).into();
        let report = &statistics(&[method], &[parameter], &answers)[0];
        let row = &report.parameters[0];
        let rmse = (0.11_f64 / 3.0).sqrt();
        for (value, expected) in [
            (row.median_percent, 5.0),
            (row.p95_percent, 14.0),
            (row.rmse_over_crlb, rmse / 0.1),
            (row.coverage95, 2.0 / 3.0),
            (report.geomean_rmse_over_crlb, rmse / 0.1),
            (report.nees, 1.0),
            (row.paper_percent, 7.0),
        ] {
            assert!((value.expect("three records") - expected).abs() < 1e-12, "{value:?} {expected}"); // rounding
        }
        assert_eq!((report.failed, report.missed, report.spurious, report.dof), (0, 0, 3, 1));
    }

    #[test]
    fn the_spread_of_the_mean_ratio_is_that_of_one_ratio_when_errors_are_common_and_smaller_when_they_are_not() {
        let stream = dynamics::noise::Stream::new(1, "spread");
        let parameters: Vec<Parameter> =
            ["a", "b", "c", "d"].map(|name| Parameter { name, truth: 0.0, bound: 1.0 }).into();
        let spread = |common: bool| {
            let value = |k: u64, i: u64| stream.normal(if common { k } else { 4 * k + i });
            let answers: Vec<Answer> = (0..2000).map(|k| Answer::bare((0..4).map(|i| value(k, i)))).collect();
            geomean_sd(&parameters, &answers.iter().collect::<Vec<_>>()).expect("2000 records")
        };
        let one = (1.0 / 4000.0_f64).sqrt(); // an RMSE of n records spreads by 1/√(2n)
        assert!((spread(true) / one - 1.0).abs() < 0.15); // a fourth moment of 2000 numbers
        assert!((spread(false) / (0.5 * one) - 1.0).abs() < 0.15);
    }

    #[test]
    fn a_method_without_answers_has_no_statistics_and_says_how_often_it_failed() {
        let parameter = Parameter { name: "a", truth: 1.0, bound: 0.1 };
        let answers = vec![vec![Answer::none(1)], vec![Answer::none(1)]];
        let report = &statistics(&[Method { name: "m", paper_percent: &[] }], &[parameter], &answers)[0];
        assert_eq!((report.failed, report.missed), (2, 2));
        assert_eq!(
            (report.nees, report.geomean_rmse_over_crlb, report.parameters[0].median_percent),
            (None, None, None)
        );
    }
}
