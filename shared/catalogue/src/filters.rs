//! Filters that actuators and sensors share: the first parameter of the effect is the time.

use dynamics::lags::FilterKind;

/// Pure delay of `p[0]` seconds; zero is no filter.
pub fn delay(p: &[f64]) -> FilterKind {
    if p[0] == 0.0 { FilterKind::None } else { FilterKind::Delay { delay_s: p[0] } }
}

/// First-order lag with the time constant `p[0]` seconds; zero is no filter.
pub fn first_order(p: &[f64]) -> FilterKind {
    if p[0] == 0.0 { FilterKind::None } else { FilterKind::FirstOrder { time_constant_s: p[0] } }
}

#[cfg(test)]
mod tests {
    use super::{delay, first_order};
    use dynamics::lags::FilterKind;

    #[test]
    fn the_first_parameter_is_the_time_and_zero_is_no_filter() {
        assert_eq!(delay(&[0.02]), FilterKind::Delay { delay_s: 0.02 });
        assert_eq!(first_order(&[0.02]), FilterKind::FirstOrder { time_constant_s: 0.02 });
        assert_eq!([delay(&[0.0]), first_order(&[0.0])], [FilterKind::None; 2]);
    }
}
