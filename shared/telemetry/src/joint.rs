//! Samples of one craft that several partitions identify together: its rows, what each arc says of
//! it, and what all arcs say.

use crate::header::Header;
use crate::layout::record;
#[cfg(feature = "iceoryx2")]
use iceoryx2::prelude::ZeroCopySend;

/// Most parameters that are identified together.
pub const INFORMATION_MAX: usize = 48;
/// Lower triangle of a symmetric matrix of so many rows, row after row, its diagonal included.
pub const INFORMATION_PACKED: usize = INFORMATION_MAX * (INFORMATION_MAX + 1) / 2;
/// Most actuators of a craft.
pub const COMMANDS_MAX: usize = 16;
/// Most sensors of a craft.
pub const READINGS_MAX: usize = 32;
/// Most arcs of a scenario.
pub const ARCS_MAX: usize = 8;
/// Blocks of parameters, see [`ParameterBlock`](crate::ParameterBlock).
pub const BLOCKS: usize = 6;

record! {
    /// One control period of a craft: what was commanded and what every sensor read, actuators and
    /// sensors in the order of its plant file.
    CraftRow {
        header: Header, "-", "-", "header";
        interval_s: f64, "s", "-", "control period that begins at t_meas: commands are held over it";
        t_s: f64, "s", "-", "the same beginning, from that of the arc";
        commands: u32, "-", "-", "actuators in use";
        readings: u32, "-", "-", "sensors in use";
        valid: u64, "-", "-", "bit per sensor: it was read in this period";
        command: [f64; COMMANDS_MAX], "of the actuator", "of the actuator", "commands";
        reading: [f64; READINGS_MAX], "of the sensor", "of the sensor", "readings";
        stamp_s: [f64; READINGS_MAX], "s", "-", "per reading: its time by the sensor's own clock, from the beginning of the arc";
    }
}

record! {
    /// What one arc says of all parameters at a point of linearisation, its own parameters (biases,
    /// clocks) eliminated and the priors of the others not counted: `N = sum h h'`, `g = sum h r`
    /// of its whitened innovations r and their sensitivities h.
    Information {
        header: Header, "-", "-", "header";
        frame: u64, "-", "-", "frame it was made in";
        arc: u16, "-", "-", "number of the arc in the scenario, from 0";
        generation: u16, "-", "-", "of the point of linearisation; 0: where the arc itself ended";
        count: u16, "-", "-", "parameters in use; 0: the plant cannot predict the arc";
        held_out: u16, "-", "-", "1: predicted, not to be folded";
        parameter_hash: u32, "-", "-", "CRC-32 over names, units and priors of the parameters in their order";
        reserved: u32, "-", "-", "0";
        rows: u64, "-", "-", "readings";
        chi2: f64, "-", "-", "sum of the squared whitened innovations, the arc's own numbers eliminated";
        log_determinant: f64, "-", "-", "sum of ln of their variances, likewise";
        mask: u64, "-", "-", "bit per parameter: the arc depends on it";
        theta: [f64; INFORMATION_MAX], "of the parameter", "-", "point of linearisation";
        gradient: [f64; INFORMATION_MAX], "-", "-", "g, per standard deviation of the prior";
        information: [f64; INFORMATION_PACKED], "-", "-", "lower triangle of N, row after row, per standard deviations of the priors";
        crc32: u32, "-", "-", "CRC-32 (IEEE) over arc to information";
        reserved_too: u32, "-", "-", "0";
    }
}

record! {
    /// What all arcs say together, how they test the model, and what is asked for next.
    JointEstimate {
        header: Header, "-", "-", "header";
        frame: u64, "-", "-", "frame it was made in";
        generation: u16, "-", "-", "of the messages that were folded";
        count: u16, "-", "-", "parameters in use";
        messages: u16, "-", "-", "messages folded";
        asks: u16, "-", "-", "0 nothing; 1 messages of the next generation at theta; 2 the held-out arc, predicted at theta; 3 what the arc of the verdict misses";
        parameter_hash: u32, "-", "-", "as Information.parameter_hash";
        verdict: u16, "-", "-", "code of JointVerdict";
        verdict_arc: u16, "-", "-", "arc that the verdict speaks of; 65535 for none";
        step_sigma: f64, "sigma", "-", "from the point of linearisation to theta, rms over the parameters; NaN: no common point";
        theta: [f64; INFORMATION_MAX], "of the parameter", "-", "parameters";
        sigma: [f64; INFORMATION_MAX], "of the parameter", "-", "their standard deviations";
        identifiability: [u16; INFORMATION_MAX], "-", "-", "per parameter, code of Identifiability";
        chi2_per_row: [f64; ARCS_MAX], "-", "-", "per arc, mean squared whitened innovation; NaN: no message";
        p_between: [[f64; BLOCKS]; ARCS_MAX], "-", "-", "per arc and block of parameters (code of ParameterBlock): how often arcs of one craft differ as much from all others; NaN: not tested";
        held_out_chi2_per_row: f64, "-", "-", "of the arc that was predicted; NaN: none yet";
        held_out_p: f64, "-", "-", "how often a prediction by a true model is off as much, its uncertainty included; NaN: none yet";
    }
}

crate::seal::sealed!(Information, arc);

impl JointEstimate {
    /// `asks`: messages of the next generation at `theta`.
    pub const ASKS_NEXT_GENERATION: u16 = 1;
    /// `asks`: the held-out arc, predicted at `theta`.
    pub const ASKS_HELD_OUT: u16 = 2;
    /// `asks`: what the arc of the verdict misses.
    pub const ASKS_WHAT_IS_MISSING: u16 = 3;
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{ParameterBlock, Sample};

    #[test]
    fn a_message_with_one_wrong_bit_in_its_last_number_is_not_intact() {
        let mut sealed = Information { count: 2, chi2: 3.0, ..Information::zeroed_at(0) };
        sealed.information[INFORMATION_PACKED - 1] = 1.5;
        let sealed = sealed.sealed();
        assert!(sealed.is_intact());
        let mut moved = sealed;
        moved.information[INFORMATION_PACKED - 1] = f64::from_bits(1.5_f64.to_bits() ^ 1);
        assert!(!moved.is_intact());
        // in which frame it is sent is not part of what it says
        assert!(Information { frame: 7, ..sealed }.is_intact());
    }

    #[test]
    fn an_estimate_has_room_for_every_block_of_parameters() {
        assert_eq!(ParameterBlock::ALL.len(), BLOCKS);
    }
}
