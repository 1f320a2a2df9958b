//! Findings about a related pair: what is computed, turned, scaled, late, drifting or offset, each
//! beyond its own uncertainty.

use super::super::{Check, Finding, Severity, quantity, short};
use super::Relation;
use channels::Channel;
use identification::statistics::{deviation, student_two_sided};

/// Lag below this share of a step, scale error and offset below these shares are not reported: they
/// move no estimate by a sigma that matters.
const LAG_SHARE: f64 = 0.02;
const SCALE_SHARE: f64 = 0.005;
const OFFSET_SHARE: f64 = 0.01;
/// Ratios that wrong units give.
const FACTORS: &[(f64, &str)] = &[
    (57.295_779_513, "degrees against radians"),
    (9.806_65, "g against m/s^2"),
    (1000.0, "milli against one"),
    (100.0, "centi against one"),
    (1e6, "micro against one"),
    (9.549_296_586, "turns per minute against rad/s"),
    (core::f64::consts::TAU, "turns against radians"),
    (60.0, "minutes against seconds"),
];

/// A pair, what binds it, and the words that all its findings share.
pub(super) struct Judged<'a> {
    a: &'a Channel,
    b: &'a Channel,
    order: usize,
    r: &'a Relation,
    level: f64,
    /// Sigmas from which on a number counts.
    gate: f64,
    /// `the rate of change of `.
    what: &'static str,
    basis: String,
}

impl<'a> Judged<'a> {
    /// Channel `b` against the derivative of `order` of channel `a`; `level` is the false-alarm
    /// probability of one test.
    pub fn new(a: &'a Channel, b: &'a Channel, order: usize, r: &'a Relation, level: f64) -> Self {
        let what = ["", "the rate of change of ", "the second derivative of "][order.min(2)];
        let window = short(2.0 * r.half_s);
        let basis = format!("{what}{} against {} through windows of {window} s, R2 = {}", a.name, b.name, short(r.r2));
        Judged { a, b, order, r, level, gate: student_two_sided(level, r.freedom), what, basis }
    }

    fn finding(&self, check: Check, severity: Severity, value: f64, unit: &str) -> Finding {
        Finding::new(check, severity, &self.b.name, value, unit).with(&[&self.a.name])
    }

    /// A computed channel is nothing else; a measured one may have several faults.
    pub fn findings(&self) -> Vec<Finding> {
        if let Some(computed) = self.computed() {
            return vec![computed];
        }
        let mut out = Vec::new();
        out.extend(self.sign());
        out.extend(self.scale());
        out.extend(self.lag());
        out.extend(self.skew());
        out.extend(self.offset());
        out
    }

    /// Ratio in SI, and its sigma.
    fn ratio(&self) -> (f64, f64) {
        let factor = |c: &Channel| quantity::of_channel(c).map_or(1.0, |q| q.factor);
        let units = factor(self.a) / factor(self.b);
        (self.r.scale * units, self.r.scale_sigma * units)
    }

    fn computed(&self) -> Option<Finding> {
        let (residual, least, half_s) = self.r.computed?;
        let (a, b, (ratio, _)) = (&self.a.name, &self.b.name, self.ratio());
        let evidence = format!(
            "through windows of {} s {}{a} and {b} differ by {} {} rms; the noise of {a} alone, if {b} were measured apart from it, would make {}. Lag {} us, ratio {}",
            short(2.0 * half_s),
            self.what,
            short(residual),
            self.b.unit,
            short(least),
            short(1e6 * self.r.lag_s),
            short(ratio)
        );
        // the same quantity with the same noise: nothing was derived
        Some(if self.order == 0 {
            let cure = "use one of the two; counting both as measurements halves the noise that is not there";
            self.finding(Check::Copied, Severity::Warning, ratio, "-").because(evidence).cure(cure)
        } else {
            let cure = format!("no measurement: do not fit on it. Use {a} and let the estimator form the derivative");
            self.finding(Check::Derived, Severity::Fault, residual / least, "-").because(evidence).cure(cure)
        })
    }

    fn sign(&self) -> Option<Finding> {
        let (ratio, _) = self.ratio();
        (ratio < 0.0).then(|| {
            self.finding(Check::Sign, Severity::Fault, -1.0, "-")
                .because(format!("opposite signs: {}, ratio {}", self.basis, short(ratio)))
                .cure("turn the sign of one of the two, after looking which agrees with the drawing")
        })
    }

    fn scale(&self) -> Option<Finding> {
        let (ratio, sigma) = self.ratio();
        let (check, severity, value, text, cure) =
            scale_finding(ratio.abs(), sigma, self.gate, self.r.r2, &self.basis)?;
        Some(self.finding(check, severity, value, "-").sigma(sigma).because(text).cure(cure))
    }

    fn lag(&self) -> Option<Finding> {
        let r = self.r;
        if r.lag_s.abs() <= self.gate * r.lag_sigma_s || r.lag_s.abs() <= LAG_SHARE * r.dt_s {
            return None;
        }
        let (a, b) = (&self.a.name, &self.b.name);
        let (late, early) = if r.lag_s > 0.0 { (b, a) } else { (a, b) };
        let text = format!(
            "{late} comes {} ± {} ms after {early} ({} samples): {}",
            short(1e3 * r.lag_s.abs()),
            short(1e3 * r.lag_sigma_s),
            short(r.lag_s.abs() / r.dt_s),
            self.basis
        );
        let found = self.finding(Check::Lag, Severity::Warning, r.lag_s, "s").sigma(r.lag_sigma_s).because(text);
        Some(found.cure("shift one source by this, or give the sensor a lag in the plant"))
    }

    fn skew(&self) -> Option<Finding> {
        let (skew, sigma, freedom) = self.r.skew?;
        let duration = self.b.time_s.last().unwrap_or(&0.0) - self.b.time_s.first().unwrap_or(&0.0);
        let significant = skew.abs() > student_two_sided(self.level, freedom) * sigma;
        (significant && (skew * duration).abs() > 0.05 * self.r.dt_s).then(|| {
            let (rate, spread) = (short(1e5 * skew), short(1e5 * sigma));
            self.finding(Check::ClockSkew, Severity::Warning, skew, "s/s")
                .sigma(sigma)
                .because(format!("the lag grows by {rate} ± {spread} ms per 100 s: {}", self.basis))
                .cure("different clocks: stretch the stamps of one by this rate; on one clock: a filter whose delay follows the motion, keep to the raw channel")
        })
    }

    fn offset(&self) -> Option<Finding> {
        let (bias, sigma) = (-self.r.offset / self.r.scale, (self.r.offset_sigma / self.r.scale).abs());
        let (a, b) = (self.a, self.b);
        (bias.abs() > self.gate * sigma && bias.abs() > OFFSET_SHARE * deviation(&b.value)).then(|| {
            let (size, spread, what) = (short(bias), short(sigma), self.what);
            self.finding(Check::Offset, Severity::Note, bias, &b.unit)
                .sigma(sigma)
                .because(format!(
                    "{} reads {size} ± {spread} {} when {what}{} is zero: {}",
                    b.name, b.unit, a.name, self.basis
                ))
                .cure("estimate a bias for this channel")
        })
    }
}

type Scale = (Check, Severity, f64, String, String);

fn scale_finding(ratio: f64, sigma: f64, gate: f64, r2: f64, basis: &str) -> Option<Scale> {
    let log = libm::log(ratio);
    if log.abs() > libm::log(1.5) {
        let tolerance = (3.0 * sigma / ratio + (1.0 - r2)).clamp(0.012, 0.1);
        let near = |f: &&(f64, &str)| (log.abs() - libm::log(f.0)).abs();
        let named = FACTORS.iter().min_by(|f, g| near(f).total_cmp(&near(g))).filter(|f| near(f) < tolerance);
        let text = format!("ratio {} ± {} where the units say 1: {basis}", short(ratio), short(sigma));
        return Some(match named {
            Some((factor, name)) => (
                Check::Units,
                Severity::Fault,
                ratio,
                format!("{text}; {} = {name}", short(*factor)),
                "correct the unit in the file's header or the channel map".into(),
            ),
            None => (
                Check::Scale,
                Severity::Fault,
                ratio,
                text,
                "not the same quantity, or a gear or unit between the two: find out before using both".into(),
            ),
        });
    }
    // Noise in b shrinks the ratio to R2 of its value at most; only what lies outside counts.
    let outside = if ratio > 1.0 { ratio - 1.0 } else { (1.0 - ratio / r2).max(0.0) };
    (outside > gate * sigma && outside > SCALE_SHARE).then(|| {
        (
            Check::Scale,
            Severity::Warning,
            ratio,
            format!("ratio {} ± {} where it should be 1: {basis}", short(ratio), short(sigma)),
            "estimate a scale factor for one of the two, or calibrate".into(),
        )
    })
}
