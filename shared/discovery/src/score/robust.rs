//! Significance that does not believe the noise model: Bartlett window over the products of column and residual.

/// Robust form of one score.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Robust {
    pub z: f64,
    /// Lag of the window, in instants.
    pub lag: usize,
    /// Instants that carry the effect: `(Σ c²)² / Σ c⁴`.
    pub instants: f64,
    /// Largest z that any amplitude can reach.
    pub ceiling: f64,
}

/// `z = Σ s / √(Σ s² + 2 Σ w_l Σ s_t s_{t−l})`, `s` the products summed per instant; not centred: the mean is zero under the null.
pub fn robust(c: &[f64], r: &[f64], events: &[usize]) -> Robust {
    let instants = events.last().map_or(0, |last| last + 1);
    let mut s = vec![0.0; instants];
    let mut power = vec![0.0; instants];
    for ((c, r), event) in c.iter().zip(r).zip(events) {
        s[*event] += c * r;
        power[*event] += c * c;
    }
    let total: f64 = power.iter().sum();
    let fourth: f64 = power.iter().map(|p| p * p).sum();
    if total <= 0.0 || instants < 10 {
        return Robust::default();
    }
    let carrying = total * total / fourth;
    let lag = lag(&s);
    // below that where products alternate: such a window tells little
    let variance = long_run(&s, lag).max(0.25 * s.iter().map(|s| s * s).sum::<f64>());
    let sum: f64 = s.iter().sum();
    let z = if variance > 0.0 { sum / variance.sqrt() } else { 0.0 };
    Robust { z, lag, instants: carrying, ceiling: (carrying / (lag + 1) as f64).sqrt() }
}

/// `Σ s² + 2 Σ w_l Σ s_t s_{t−l}` with `w_l = 1 − l / (lag + 1)`: the mean square of all sums of `lag + 1` neighbours, zero beyond the ends.
fn long_run(s: &[f64], lag: usize) -> f64 {
    let width = lag + 1;
    let (mut total, mut sum) = (0.0, 0.0);
    for t in 0..s.len() + lag {
        sum += s.get(t).unwrap_or(&0.0);
        sum -= t.checked_sub(width).map_or(0.0, |left| s[left]);
        total += sum * sum;
    }
    total / width as f64
}

/// Newey and West's rule, longer where the products themselves go on.
fn lag(s: &[f64]) -> usize {
    let n = s.len();
    let rule = 4.0 * libm::pow(n as f64 / 100.0, 2.0 / 9.0);
    let mean = s.iter().sum::<f64>() / n as f64;
    let off: Vec<f64> = s.iter().map(|x| x - mean).collect();
    let own: f64 = off.iter().map(|x| x * x).sum();
    let rho = |l: usize| -> f64 {
        let cross: f64 = off[l..].iter().zip(&off).map(|(a, b)| a * b).sum();
        if own > 0.0 { cross / own } else { 0.0 }
    };
    let significant = 2.0 / (n as f64).sqrt();
    let mut reach = 0;
    while reach < n / 20 && rho(reach + 1) > significant {
        reach += 1;
    }
    (rule as usize).max(3 * reach).min(n / 10).max(1)
}
