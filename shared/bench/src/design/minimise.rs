//! Least value of a smooth function of many numbers: limited-memory BFGS with gradients by central
//! differences.

/// Pairs of steps and gradient changes that stand for the curvature.
const MEMORY: usize = 12;
/// Half width of the differences: truncation 1e-10, rounding 1e-11.
const STEP: f64 = 1e-5;
const BACKTRACKS_MAX: usize = 30;

/// Walks downhill from `start` for at most `iterations`, until a step gains less than `settled`;
/// the place and its value. `None` from `value` is a wall.
pub fn minimise(
    start: Vec<f64>,
    iterations: usize,
    settled: f64,
    value: &impl Fn(&[f64]) -> Option<f64>,
) -> Option<(Vec<f64>, f64)> {
    let (mut x, mut here) = (start.clone(), value(&start)?);
    let mut slope = gradient(&x, here, value);
    let mut pairs: Vec<(Vec<f64>, Vec<f64>)> = Vec::new();
    for _ in 0..iterations {
        let mut direction = downhill(&slope, &pairs);
        if dot(&direction, &slope) >= 0.0 {
            pairs.clear();
            direction = downhill(&slope, &pairs);
        }
        let Some((next, there)) = line_search(&x, here, &direction, &slope, value) else { break };
        let changed = gradient(&next, there, value);
        let step: Vec<f64> = next.iter().zip(&x).map(|(a, b)| a - b).collect();
        let bend: Vec<f64> = changed.iter().zip(&slope).map(|(a, b)| a - b).collect();
        let gained = here - there;
        if dot(&step, &bend) > 1e-10 * dot(&bend, &bend) {
            pairs.push((step, bend));
            if pairs.len() > MEMORY {
                pairs.remove(0);
            }
        }
        (x, here, slope) = (next, there, changed);
        if gained < settled {
            break;
        }
    }
    Some((x, here))
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// One-sided at a wall.
fn gradient(x: &[f64], here: f64, value: &impl Fn(&[f64]) -> Option<f64>) -> Vec<f64> {
    let mut moved = x.to_vec();
    let mut along = |i: usize| {
        let mut at = |offset: f64| {
            moved[i] = x[i] + offset;
            let found = value(&moved);
            moved[i] = x[i];
            found
        };
        match (at(STEP), at(-STEP)) {
            (Some(above), Some(below)) => (above - below) / (2.0 * STEP),
            (Some(above), None) => (above - here) / STEP,
            (None, Some(below)) => (here - below) / STEP,
            (None, None) => 0.0,
        }
    };
    (0..x.len()).map(&mut along).collect()
}

/// The two-loop recursion (Nocedal & Wright, algorithm 7.4).
fn downhill(slope: &[f64], pairs: &[(Vec<f64>, Vec<f64>)]) -> Vec<f64> {
    let mut direction: Vec<f64> = slope.iter().map(|value| -value).collect();
    let mut shares = Vec::with_capacity(pairs.len());
    for (step, bend) in pairs.iter().rev() {
        let share = dot(step, &direction) / dot(step, bend);
        direction.iter_mut().zip(bend).for_each(|(value, bend)| *value -= share * bend);
        shares.push(share);
    }
    let scale = match pairs.last() {
        Some((step, bend)) => dot(step, bend) / dot(bend, bend),
        None => 0.02 / dot(slope, slope).sqrt().max(f64::MIN_POSITIVE), // a first step of 0.02
    };
    direction.iter_mut().for_each(|value| *value *= scale);
    for ((step, bend), share) in pairs.iter().zip(shares.iter().rev()) {
        let back = share - dot(bend, &direction) / dot(step, bend);
        direction.iter_mut().zip(step).for_each(|(value, step)| *value += back * step);
    }
    direction
}

/// Halves the step until the value falls by a part of what the slope promises.
fn line_search(
    x: &[f64],
    here: f64,
    direction: &[f64],
    slope: &[f64],
    value: &impl Fn(&[f64]) -> Option<f64>,
) -> Option<(Vec<f64>, f64)> {
    const ARMIJO_SHARE: f64 = 1e-4;
    let promised = dot(direction, slope);
    let mut length = 1.0;
    for _ in 0..BACKTRACKS_MAX {
        let next: Vec<f64> = x.iter().zip(direction).map(|(x, d)| x + length * d).collect();
        if let Some(there) = value(&next).filter(|there| *there <= here + ARMIJO_SHARE * length * promised) {
            return Some((next, there));
        }
        length *= 0.5;
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_curved_valley_is_followed_to_its_end() {
        let rosenbrock = |x: &[f64]| -> Option<f64> {
            Some((0..9).map(|i| 100.0 * (x[i + 1] - x[i] * x[i]).powi(2) + (1.0 - x[i]).powi(2)).sum())
        };
        let start = (0..10).map(|i| if i % 2 == 0 { -1.2 } else { 1.0 }).collect();
        let (x, least) = minimise(start, 2000, 0.0, &rosenbrock).expect("no wall");
        // Nine links have a second, higher minimum near x0 = −1; differences of 1e-5 leave 1e-9 of
        // the gradient.
        assert!(least < 1e-8 || (least - 3.98).abs() < 0.02, "{least} {x:?}");
    }

    #[test]
    fn a_wall_is_not_passed() {
        let half = |x: &[f64]| (x[0] > 0.5).then(|| x[0] * x[0]);
        let (x, _) = minimise(vec![2.0], 200, 0.0, &half).expect("the start is inside");
        assert!(x[0] > 0.5 && x[0] < 0.51, "{x:?}");
        assert!(minimise(vec![0.2], 200, 0.0, &half).is_none());
    }
}
