//! Poles of the order sweep that a person points at.

use crate::gram::output_gram;
use crate::record::Record;
use crate::selection::{Mode, mode};
use crate::shape_uncertainty::{ShapeScale, shape_deviations};
use crate::ssi_cov::{Pole, SsiError, realise};
use crate::uncertainty::{Blocks, pole_deviations, residual};

/// The oscillation nearest to each (order, frequency \[Hz\]) in the sweep at the record's own rate,
/// with its deviations; `None` where the order carries no signal or no oscillation.
///
/// Nothing is judged: damping and shape come as found.
///
/// # Errors
/// [`SsiError`] of the factorisation.
pub fn by_hand(record: &Record, block_rows: usize, picks: &[(usize, f64)]) -> Result<Vec<Option<Mode>>, SsiError> {
    let gram = output_gram(record, block_rows);
    let order_max = picks.iter().map(|(order, _)| *order).max().unwrap_or(1);
    let realisation = realise(&gram, order_max)?;
    let rate_hz = record.sample_rate_hz;
    let nearest = |(order, hz): &(usize, f64)| -> Option<Pole> {
        let poles = (*order <= realisation.order_max()).then(|| realisation.poles(*order, rate_hz))?;
        // What grows is no mode of a record that does not.
        let is_decay = |pole: &Pole| pole.eigenvalue.im > 0.0 && pole.damping_ratio > 0.0;
        let oscillations = poles.into_iter().filter(is_decay);
        oscillations.min_by(|a, b| (a.frequency_hz - hz).abs().total_cmp(&(b.frequency_hz - hz).abs()))
    };
    let of = |pick: &(usize, f64)| {
        let pole = nearest(pick)?;
        let deviation = pole_deviations(&gram, Blocks::Windows(&[]), &realisation, &[&pole], rate_hz).swap_remove(0);
        let residual = residual(&gram, &realisation, pole.order);
        let shape = shape_deviations(&gram, &[], &realisation, &residual, &pole, ShapeScale::Largest);
        Some(Mode { shape_deviation: shape, ..mode(&pole, deviation, 1, 1) })
    };
    Ok(picks.iter().map(of).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_noise::Noise;

    #[test]
    fn the_pole_nearest_to_the_pick_comes_with_its_own_deviation_and_an_order_too_high_with_none() {
        let mut noise = Noise::new(11);
        let outputs = (0..1500).map(|t| {
            let t = f64::from(t) / 50.0;
            let decay = |hz: f64| libm::exp(-0.2 * t) * libm::cos(std::f64::consts::TAU * hz * t);
            decay(3.0) + decay(7.0) + 0.01 * noise.normal()
        });
        let record = Record::of_outputs(50.0, 1, outputs.collect());
        let found = by_hand(&record, 20, &[(6, 6.5), (900, 3.0)]).unwrap();
        let mode = found[0].as_ref().unwrap();
        // Ten deviations as the method states them.
        assert!((mode.frequency_hz - 7.0).abs() < 10.0 * mode.sigma_frequency_hz, "{mode:?}");
        assert!(mode.sigma_frequency_hz < 0.01 && mode.order == 6 && found[1].is_none());
    }
}
