//! Axes of a gyro against another triad: permuted, turned or mirrored.
//!
//! A vector fixed in inertial space (magnetic field; gravity, while nothing else accelerates the
//! sensor) is seen from the body as `v̇ = -ω × v`; an attitude gives the rate itself. All 48 signed
//! permutations of the gyro axes (24 proper, 24 mirrored) are held against the other triad through
//! smooth windows, as in `kinship`; the recorded orientation is doubted only where another explains
//! the motion and it does not.

use nalgebra::{Matrix3, Vector3};

use super::kinship::{kernel, seen};
use super::{Check, FALSE_ALARM, Finding, Severity, probability, quantity, short, usable};
use channels::{Channel, Recording, common_grid};
use identification::statistics::{correlation_length, fisher_tail, mean};

/// Share of the motion the best orientation must explain, and by which it must beat the recorded
/// one.
const ROTATED_AXES_R2_MIN: f64 = 0.5;
const R2_GAIN_MIN: f64 = 0.2;
/// Orientations this near to the best are not told apart.
const R2_TIE: f64 = 0.02;

/// Sign and source axis of each axis: `ω'[a] = sign[a] ω[source[a]]`.
#[derive(Clone, Copy, PartialEq)]
struct Orientation {
    source: [usize; 3],
    sign: [f64; 3],
}

const RECORDED: Orientation = Orientation { source: [0, 1, 2], sign: [1.0, 1.0, 1.0] };

impl Orientation {
    fn all() -> Vec<Orientation> {
        let mut out = vec![RECORDED];
        for source in [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]] {
            for bits in 0..8 {
                let sign = core::array::from_fn(|a| if bits >> a & 1 == 1 { -1.0 } else { 1.0 });
                if (Orientation { source, sign }) != RECORDED {
                    out.push(Orientation { source, sign });
                }
            }
        }
        out
    }

    fn mirrored(&self) -> bool {
        let inversions = [(0, 1), (0, 2), (1, 2)].iter().filter(|(a, b)| self.source[*a] > self.source[*b]).count();
        let sign: f64 = self.sign.iter().product();
        (inversions % 2 == 1) != (sign < 0.0)
    }

    fn text(&self) -> String {
        let axis = |a: usize| {
            format!(
                "{} <- {}{}",
                ["x", "y", "z"][a],
                if self.sign[a] < 0.0 { "-" } else { "" },
                ["x", "y", "z"][self.source[a]]
            )
        };
        (0..3).map(axis).collect::<Vec<_>>().join(", ")
    }
}

/// What the other triad says.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    FixedVector,
    EulerAngles,
    Rate,
}

/// Gyro triads whose recorded axes do not explain the motion of another triad, each with the
/// orientation that does.
pub fn examine(recording: &Recording) -> Vec<Finding> {
    let channels = usable(recording, 64);
    let triads = triads(&channels);
    let quantity_of = |t: &[&Channel; 3]| quantity::of_channel(t[0]);
    let gyros: Vec<&[&Channel; 3]> = triads
        .iter()
        .filter(|t| quantity_of(t).is_some_and(|q| q.kind == quantity::Kind::Angle && q.order == 1))
        .collect();
    let mut findings = Vec::new();
    for (g, gyro) in gyros.iter().enumerate() {
        for other in &triads {
            let kind = match quantity_of(other) {
                Some(q) if q.kind == quantity::Kind::Angle && q.order == 0 => Kind::EulerAngles,
                Some(q) if q.kind == quantity::Kind::Angle && q.order == 1 => Kind::Rate,
                Some(q) if q.kind == quantity::Kind::Length && q.order == 2 => Kind::FixedVector,
                _ if ["T", "uT", "µT", "nT", "G"].contains(&other[0].unit.as_str()) => Kind::FixedVector,
                _ => continue,
            };
            let later = gyros.iter().position(|t| t[0].name == other[0].name).is_none_or(|k| k > g);
            if kind != Kind::Rate || later {
                findings.extend(compare(gyro, other, kind));
            }
        }
    }
    findings
}

fn triads<'a>(channels: &[&'a Channel]) -> Vec<[&'a Channel; 3]> {
    let mut out: Vec<[&'a Channel; 3]> = Vec::new();
    for first in channels {
        let Some((stem, 0)) = quantity::axis(&first.name) else { continue };
        let find = |k: usize| {
            channels
                .iter()
                .find(|c| quantity::axis(&c.name).is_some_and(|(s, a)| s == stem && a == k) && c.unit == first.unit)
        };
        if let (Some(y), Some(z)) = (find(1), find(2)) {
            out.push([first, y, z]);
        }
    }
    out
}

fn compare(gyro: &[&Channel; 3], other: &[&Channel; 3], kind: Kind) -> Option<Finding> {
    let mut omega: Vec<Vec<f64>> = Vec::new();
    let mut vector: Vec<Vec<f64>> = Vec::new();
    let mut dt = 0.0;
    for a in 0..3 {
        let (x, y) = common_grid(gyro[a], other[a], 64)?;
        let factor = |c: &Channel| quantity::of_channel(c).map_or(1.0, |q| q.factor);
        omega.push(x.value.iter().map(|v| v * factor(gyro[a])).collect());
        vector
            .push(y.value.iter().map(|v| v * if kind == Kind::FixedVector { 1.0 } else { factor(other[a]) }).collect());
        dt = x.dt_s;
    }
    let n = omega.iter().chain(&vector).map(Vec::len).min()?;
    let orientations = Orientation::all();
    let mut best: Option<(Vec<f64>, f64, usize)> = None;
    let mut half = 3;
    while half <= (n / 12).min(256) {
        if let Some((explained, independent)) = explained(&omega, &vector, kind, n, half, dt, &orientations) {
            let top = explained.iter().fold(f64::NEG_INFINITY, |m, r| m.max(*r));
            if best.as_ref().is_none_or(|(e, ..)| top > e.iter().fold(f64::NEG_INFINITY, |m, r| m.max(*r))) {
                best = Some((explained, independent, half));
            }
        }
        half *= 2;
    }
    let (explained, independent, half) = best?;
    let top = (0..48).max_by(|&i, &j| explained[i].total_cmp(&explained[j]).then(j.cmp(&i)))?;
    let p = 48.0 * fisher_tail((1.0 - explained[0]) / (1.0 - explained[top]).max(1e-12), independent, independent);
    if explained[top] < ROTATED_AXES_R2_MIN || explained[top] - explained[0] < R2_GAIN_MIN || p > FALSE_ALARM {
        return None;
    }
    let ties = explained.iter().filter(|r| **r > explained[top] - R2_TIE).count();
    let names: Vec<&str> = gyro[1..].iter().chain(other.iter()).map(|c| c.name.as_str()).collect();
    let nature = if orientations[top].mirrored() { "mirrored" } else { "turned" };
    Some(
        Finding::new(Check::Axes, Severity::Fault, &gyro[0].name, explained[0], "-")
            .with(&names)
            .because(format!(
                "as recorded the gyro explains {} of the turning of {}; with its axes {nature} ({}) {}; {} of 48 orientations fit as well (windows of {} s, {})",
                short(explained[0]), quantity::axis(&other[0].name).map_or_else(String::new, |(s, _)| s), orientations[top].text(), short(explained[top]), ties - 1, short(2.0 * half as f64 * dt), probability(p)
            ))
            .cure(if ties == 1 { "map the axes of one of the two triads so; then look at the mounting" } else { "one of the triads is mounted otherwise than recorded; turn about a second axis to see which way" }),
    )
}

/// Share of the other triad's turning that each orientation explains, and the number of independent
/// windows.
fn explained(
    omega: &[Vec<f64>],
    vector: &[Vec<f64>],
    kind: Kind,
    n: usize,
    half: usize,
    dt: f64,
    orientations: &[Orientation],
) -> Option<(Vec<f64>, f64)> {
    let (k0, k1) = (kernel(half, 0, 0.0), kernel(half, 1, 0.0));
    let positions: Vec<usize> = (half + 1..n.saturating_sub(half + 1)).step_by((half / 2).max(1)).collect();
    if positions.len() < 24 {
        return None;
    }
    let through = |x: &[f64], k: &[f64]| positions.iter().map(|&p| seen(x, k, p)).collect::<Vec<f64>>();
    let rate = |a: usize| through(&vector[a], &k1).iter().map(|v| v / dt).collect::<Vec<f64>>();
    // target[a] = Σ over gyro axes s of weight[a][b][s], with ω' [b] = sign ω[s].
    let target: Vec<Vec<f64>> = match kind {
        Kind::FixedVector => (0..3).map(rate).collect(),
        Kind::Rate => (0..3).map(|a| through(&vector[a], &k0)).collect(),
        Kind::EulerAngles => {
            let (dr, dp, dy) = (rate(0), rate(1), rate(2));
            let (roll, pitch) = (through(&vector[0], &k0), through(&vector[1], &k0));
            let body = |i: usize| {
                let (sr, cr, sp, cp) =
                    (libm::sin(roll[i]), libm::cos(roll[i]), libm::sin(pitch[i]), libm::cos(pitch[i]));
                [dr[i] - dy[i] * sp, dp[i] * cr + dy[i] * cp * sr, -dp[i] * sr + dy[i] * cp * cr]
            };
            (0..3).map(|a| (0..positions.len()).map(|i| body(i)[a]).collect()).collect()
        }
    };
    let smooth: Vec<Vec<f64>> = omega.iter().map(|w| through(w, &k0)).collect();
    let products: Vec<Vec<Vec<f64>>> = if kind == Kind::FixedVector {
        let product = |s: usize, v: usize| (0..n).map(|i| omega[s][i] * vector[v][i]).collect::<Vec<f64>>();
        (0..3).map(|s| (0..3).map(|v| through(&product(s, v), &k0)).collect()).collect()
    } else {
        Vec::new()
    };
    let total: f64 = target.iter().flatten().map(|v| v * v).sum();
    let share = |o: &Orientation| {
        let mut left = 0.0;
        // A constant the sensor adds to a fixed vector (hard iron, bias) enters as ω' × b: three
        // unknowns, by normal equations.
        let (mut normal, mut right) = (Matrix3::<f64>::zeros(), Vector3::<f64>::zeros());
        for a in 0..3 {
            let (b, c) = ((a + 1) % 3, (a + 2) % 3);
            for i in 0..positions.len() {
                let model = if kind == Kind::FixedVector {
                    o.sign[c] * products[o.source[c]][b][i] - o.sign[b] * products[o.source[b]][c][i]
                } else {
                    o.sign[a] * smooth[o.source[a]][i]
                };
                let error = target[a][i] - model;
                left += error * error;
                if kind == Kind::FixedVector {
                    let turned = |k: usize| o.sign[k] * smooth[o.source[k]][i];
                    let mut row = Vector3::zeros();
                    (row[b], row[c]) = (-turned(c), turned(b));
                    normal += row * row.transpose();
                    right += row * error;
                }
            }
        }
        if kind == Kind::FixedVector
            && let Some(inverse) = normal.pseudo_inverse(1e-9 * normal.norm()).ok()
        {
            left -= right.dot(&(inverse * right));
        }
        if total > 0.0 { 1.0 - left / total } else { 0.0 }
    };
    let memory = mean(&target.iter().map(|t| correlation_length(t)).collect::<Vec<_>>()).max(4.0);
    Some((orientations.iter().map(share).collect(), positions.len() as f64 / memory))
}
