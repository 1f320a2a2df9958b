//! What a kept arc says is missing in a model that was refused.

use crate::header::Header;
use crate::joint::INFORMATION_MAX;
use crate::layout::record;
#[cfg(feature = "iceoryx2")]
use iceoryx2::prelude::ZeroCopySend;

/// Most effects of an answer, those that could stand in for another among them.
pub const DIAGNOSED_MAX: usize = 8;
/// Most parameters of an effect.
pub const DIAGNOSED_PARAMETERS_MAX: usize = 8;

record! {
    /// The answer of one arc: which effects of the catalogue are missing, where, and how sure that
    /// is.
    Diagnosis {
        header: Header, "-", "-", "header";
        frame: u64, "-", "-", "frame it was made in";
        arc: u16, "-", "-", "number of the arc in the scenario, from 0";
        generation: u16, "-", "-", "of the messages whose model was refused";
        verdict: u16, "-", "-", "code of DiagnosisVerdict";
        count: u16, "-", "-", "effects in use";
        parameter_hash: u32, "-", "-", "of the model that was refused, as Information.parameter_hash";
        catalogue_hash: u32, "-", "-", "CRC-32 over the names of all effects in the order of the catalogue";
        effect: [u16; DIAGNOSED_MAX], "-", "-", "number of the effect in the catalogue, from 0";
        site: [u16; DIAGNOSED_MAX], "-", "-", "number of its site among those of the craft that it fits, from 0";
        stands_in_for: [u16; DIAGNOSED_MAX], "-", "-", "0: it is missing; else it could replace the effect of this number, from 1";
        probability: [f64; DIAGNOSED_MAX], "-", "-", "that it is the missing one of its set";
        significance: [f64; DIAGNOSED_MAX], "sigma", "-", "root of the gain in -2 ln p; 0 of one that stands in";
        value: [[f64; DIAGNOSED_PARAMETERS_MAX]; DIAGNOSED_MAX], "of the parameter", "-", "parameters in the order of the catalogue; NaN: the default";
        sigma: [[f64; DIAGNOSED_PARAMETERS_MAX]; DIAGNOSED_MAX], "of the parameter", "-", "their standard deviations; NaN: kept at its value";
        theta: [f64; INFORMATION_MAX], "of the parameter", "-", "parameters of the refused model, beside what is missing; 0 behind them";
        crc32: u32, "-", "-", "CRC-32 (IEEE) over arc to theta";
        reserved: u32, "-", "-", "0";
    }
}

crate::seal::sealed!(Diagnosis, arc);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Sample;

    #[test]
    fn an_answer_with_one_wrong_bit_in_its_last_number_is_not_intact() {
        let mut sealed = Diagnosis { count: 1, ..Diagnosis::zeroed_at(0) };
        sealed.theta[INFORMATION_MAX - 1] = 1.5;
        let sealed = sealed.sealed();
        assert!(sealed.is_intact());
        let mut moved = sealed;
        moved.theta[INFORMATION_MAX - 1] = f64::from_bits(1.5_f64.to_bits() ^ 1);
        assert!(!moved.is_intact());
        // in which frame it is sent is not part of what it says
        assert!(Diagnosis { frame: 7, ..sealed }.is_intact());
    }
}
