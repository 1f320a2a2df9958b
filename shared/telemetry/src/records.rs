//! The samples. Units are SI; a vector's row says of what, relative to what, expressed in what.

use crate::header::Header;
use crate::layout::record;
use crate::{Domain, INERTIAL_PARAMETERS_MAX, MODES_MAX, PARAMETERS_MAX, TOPICS_MAX};
#[cfg(feature = "iceoryx2")]
use iceoryx2::prelude::ZeroCopySend;

/// Most accelerometer channels a batch can carry.
pub const ACCELEROMETERS_MAX: usize = 12;
/// Most samples per accelerometer batch (one batch a frame).
pub const BATCH_MAX: usize = 64;

record! {
    /// Inertial measurement unit. The rate is that of the instant `t_meas` (its noise that of an
    /// average over `interval_s`), as joint angles and rates are; the acceleration is the velocity
    /// increment over the interval.
    Imu {
        header: Header, "-", "-", "header";
        interval_s: f64, "s", "-", "integration interval that begins at t_meas";
        omega_bi_b_rad_s: [f64; 3], "rad/s", "body", "angular rate of the base relative to inertial space at t_meas";
        acceleration_b_m_s2: [f64; 3], "m/s^2", "body", "mean inertial acceleration of the sensor point over the interval";
        valid: u64, "-", "-", "bit 0..2: rate x, y, z; bit 3..5: acceleration x, y, z";
    }
}

record! {
    /// Manipulator joints, at t_meas.
    Joints {
        header: Header, "-", "-", "header";
        count: u64, "-", "-", "joints in use";
        angle_rad: [f64; 4], "rad", "joint", "joint angles";
        rate_rad_s: [f64; 4], "rad/s", "joint", "joint rates";
        torque_nm: [f64; 4], "N m", "joint", "joint torques held from t_meas for one frame";
        torque_valid: u64, "-", "-", "bit 0..3: the torque of joint 1..4 is measured";
    }
}

record! {
    /// Thrusters and reaction wheel: the wrench held over `interval_s`.
    Actuators {
        header: Header, "-", "-", "header";
        interval_s: f64, "s", "-", "holding interval that begins at t_meas";
        force_b_n: [f64; 3], "N", "body", "thruster force on the hub";
        torque_b_nm: [f64; 3], "N m", "body", "torque on the hub";
        wheel_momentum_nms: f64, "N m s", "body z", "momentum of the reaction wheel";
        excited: u64, "-", "-", "1 while an experiment's excitation is on";
    }
}

record! {
    /// Accelerometer array: one batch a frame, `count` rows of `channels` values.
    Accelerometers {
        header: Header, "-", "-", "header";
        count: u32, "-", "-", "rows in use, 1 to 64";
        channels: u32, "-", "-", "columns in use, 1 to 12";
        interval_ns: u64, "ns", "-", "nominal sample interval";
        offset_ns: [u32; BATCH_MAX], "ns", "-", "time of each row after t_meas";
        acceleration_m_s2: [[f64; ACCELEROMETERS_MAX]; BATCH_MAX], "m/s^2", "sensor axis", "rows of accelerations";
    }
}

record! {
    /// Closes a frame: everything the source sent for it carries a sequence number up to
    /// `last_seq`.
    Tick {
        header: Header, "-", "-", "header";
        frame: u64, "-", "-", "frame number";
        t_ns: u64, "ns", "-", "time at which the frame begins";
        flags: u64, "-", "-", "bit 0: the source has ended with this frame";
        last_seq: [u64; TOPICS_MAX], "-", "-", "per topic: newest sequence number a consumer must have seen";
    }
}

record! {
    /// A partition's execution counter and how far it is: the pacing of a simulated clock.
    Progress {
        header: Header, "-", "-", "header";
        partition: u32, "-", "-", "code of PartitionId";
        epoch: u32, "-", "-", "how often it was started before";
        cycles: u64, "-", "-", "execution counter, one per turn of its loop";
        frames_processed: u64, "-", "-", "frames done";
        frames_checkpointed: u64, "-", "-", "frames whose effect a restart would keep";
        working: u64, "-", "-", "1 while it does the work that its last frame left";
        out_seq: [u64; TOPICS_MAX], "-", "-", "per topic: last sequence number sent at that checkpoint";
    }
}

record! {
    /// The latest test of data against model, as every estimator publishes it.
    Innovation {
        t_ns: u64, "ns", "-", "time of the row";
        innovation: f64, "1 sigma units of the row", "-", "measurement minus prediction";
        variance: f64, "-", "-", "its predicted variance";
        test_ratio: f64, "-", "-", "innovation^2 / (gate^2 variance)";
        gate: f64, "sigma", "-", "gate";
        accepted: u32, "-", "-", "1 when the row was used";
        rows: u32, "-", "-", "rows offered so far in this experiment";
        generation: u64, "-", "-", "experiment counter: a new one starts with a fresh estimator";
    }
}

record! {
    /// What every estimator says of its model: parameters, covariance, how the data tested them.
    Estimate {
        frame: u64, "-", "-", "frame after which the estimate was made";
        domain: u16, "-", "-", "code of Domain: it names the parameters and their units";
        phase: u16, "-", "-", "code of Phase";
        count: u16, "-", "-", "parameters in use";
        closing: u16, "-", "-", "1 for the last estimate of an experiment";
        status: u32, "-", "-", "0 estimate valid; else why there is none: code of InertialStatus, of SloshStatus or of ModalStatus";
        consistent: u32, "-", "-", "1 when the parameters are physically possible";
        values: [f64; PARAMETERS_MAX], "of the domain's parameters", "-", "parameters";
        covariance: [[f64; PARAMETERS_MAX]; PARAMETERS_MAX], "products of the units", "-", "covariance of the parameters";
        identifiability: [u16; PARAMETERS_MAX], "-", "-", "per parameter, code of Identifiability: 0 no prior, or no estimate; 1 identified, 2 prior kept, 3 not excited. Inertial parameters without a stated prior sigma: against a start of a thousand times their size";
        innovation: Innovation, "-", "-", "latest innovation record";
        nis_mean: f64, "-", "-", "mean normalised innovation squared per degree of freedom";
        nis_count: f64, "-", "-", "rows in that mean";
        block_length: [f64; 3], "rows", "-", "block lengths of the whiteness test";
        block_z: [f64; 3], "sigma", "-", "z-score of the mean squared block mean, per block length";
    }
}

record! {
    /// Parameters of the arm, from the momentum or from the joint torques.
    InertialEstimate {
        header: Header, "-", "-", "header";
        estimate: Estimate, "-", "-", "parameters a1 to a9 with their tests";
        consider_sigma_kg_m2: [f64; INERTIAL_PARAMETERS_MAX], "kg m^2", "-", "per parameter: standard deviation of what the sensor sheet's systematic errors may do to it, not part of the covariance; NaN: not known";
    }
}

record! {
    /// Slosh parameters, the slosh mass's state behind the arc, and the figures of a status.
    SloshEstimate {
        header: Header, "-", "-", "header";
        estimate: Estimate, "-", "-", "parameters m_s, k_s, c_s with their tests";
        arc_end_s: f64, "s", "-", "end of the arc, as t_meas counts";
        displacement_m: f64, "m", "slosh axis", "slosh mass relative to the hub at the end of the arc";
        rate_m_s: f64, "m/s", "slosh axis", "its rate";
        accelerometer_bias_m_s2: f64, "m/s^2", "slosh axis", "bias of the accelerometer, 0 where it is not estimated";
        arc_blocks: u64, "-", "-", "status 2 and 5: usable blocks of the arc, else 0";
        arc_blocks_needed: u64, "-", "-", "status 2 and 5: how many its unknowns need, else 0";
        slosh_gain: f64, "-", "-", "status 3: chi square that the best frequency explains beyond a rigid spacecraft, else 0";
        slosh_gain_needed: f64, "-", "-", "status 3: what noise alone may explain, else 0";
        iterations: u64, "-", "-", "status 4: steps taken, else 0";
        step_sigma: f64, "sigma", "-", "status 4: length of the last step, else 0";
        block_phase_rad: f64, "rad", "-", "status 6: natural frequency times the length of a block, else 0";
        block_phase_max_rad: f64, "rad", "-", "status 6: its limit, else 0";
    }
}

record! {
    /// What is said of one mode beside its frequency and damping.
    IdentifiedMode {
        identity: u32, "-", "-", "number of the mode over all answers and experiments, from 1; 0: no mode";
        dominant_channel: u16, "-", "-", "channel on which it shows most, numbered from 1";
        pulse_nulled: u16, "-", "-", "1: a pulse of this length leaves the mode at rest";
        record_short: u16, "-", "-", "1: the record is too short for its damping";
        close_modes: u16, "-", "-", "1: another mode lies within its bandwidth";
        input_leaks: u16, "-", "-", "1: the residual is not the sensor noise: an unknown input, or an unmodelled mode";
        reserved: u16, "-", "-", "0";
    }
}

record! {
    /// Modes of the appendages, the hub inertia that they imply, and the figures of a status.
    ModalEstimate {
        header: Header, "-", "-", "header";
        estimate: Estimate, "-", "-", "frequency and damping ratio of each mode, with their tests";
        modes: [IdentifiedMode; MODES_MAX], "-", "-", "per mode";
        hub_inertia_kg_m2: f64, "kg m^2", "hub axis", "inertia about the hub's axis that the modes imply by the stated geometry; 0: none";
        hub_inertia_sigma_kg_m2: f64, "kg m^2", "hub axis", "its standard deviation; 0: none";
        record_samples: u64, "-", "-", "status 2: samples of the record, else 0";
        record_samples_needed: u64, "-", "-", "status 2: how many it needs, else 0";
    }
}

/// An estimate of any domain.
#[derive(Clone, Copy, Debug)]
pub enum AnyEstimate<'a> {
    /// From the momentum or from the joint torques.
    Inertial(&'a InertialEstimate),
    /// Of the slosh mass, its spring and damper.
    Slosh(&'a SloshEstimate),
    /// Of the appendages' modes.
    Modal(&'a ModalEstimate),
}

impl<'a> AnyEstimate<'a> {
    /// The part that estimates of every domain have in common: parameters, covariance, tests.
    #[must_use]
    pub const fn common(self) -> &'a Estimate {
        match self {
            Self::Inertial(sample) => &sample.estimate,
            Self::Slosh(sample) => &sample.estimate,
            Self::Modal(sample) => &sample.estimate,
        }
    }

    /// By the type of the sample; `Estimate::domain` carries the same as a code.
    #[must_use]
    pub const fn domain(self) -> Domain {
        match self {
            Self::Inertial(_) => Domain::Inertial,
            Self::Slosh(_) => Domain::Slosh,
            Self::Modal(_) => Domain::Modal,
        }
    }
}

record! {
    /// Mass, centre of mass and inertia of a target in the plane: as the target states them of
    /// itself, or as identified after its capture.
    TargetEstimate {
        header: Header, "-", "-", "header";
        frame: u64, "-", "-", "frame it was made in";
        epoch_ns: u64, "ns", "-", "time it speaks of";
        origin: u16, "-", "-", "0 stated by the target, 1 identified, 2 identified and fused with what was stated";
        status: u16, "-", "-", "0 valid; 1 crc wrong; 2 statement refused: it contradicts what was identified at p < 0.001, or its covariance is not positive; 3 no solution: an estimate or the data sheet is missing, a covariance is not positive, or the search did not converge; 4 what was identified before and after capture and the chaser's data sheet contradict each other at p < 0.001";
        fit_degrees: u32, "-", "-", "degrees of freedom of fit_chi_square; 0 where nothing was fitted";
        values: [f64; 4], "kg, m, m, kg m^2", "stated: target; else grasp", "mass, centre of mass x, y, inertia about it";
        covariance: [[f64; 4]; 4], "products of the units", "as values", "covariance";
        grasp_position_m: [f64; 2], "m", "target", "grasp point";
        grasp_angle_rad: f64, "rad", "target", "direction of the grasp frame's x axis";
        chi_square: f64, "-", "-", "of identified against stated, 4 degrees of freedom; 0 for none";
        fit_chi_square: f64, "-", "-", "of estimates and data sheet at the solution";
        crc32: u32, "-", "-", "CRC-32 (IEEE) over epoch_ns to fit_chi_square";
        reserved_too: u32, "-", "-", "0";
    }
}

crate::seal::sealed!(TargetEstimate, epoch_ns);

record! {
    /// What the supervisor says of an estimate, and which test failed.
    Verdict {
        header: Header, "-", "-", "header";
        frame: u64, "-", "-", "frame of the decision";
        estimate_frame: u64, "-", "-", "frame of the estimate";
        domain: u16, "-", "-", "code of Domain";
        phase: u16, "-", "-", "code of Phase";
        complete: u16, "-", "-", "1: innovations white on block means and NIS in its band";
        adequate: u16, "-", "-", "1: held-out simulation error below the need; 2: not decidable";
        accepted: u16, "-", "-", "1: adequate with honest sigmas and physically consistent";
        reason: u16, "-", "-", "code of Reason";
        parameter: u16, "-", "-", "parameter the reason speaks of, numbered from 0; 65535 for none";
        reserved: u16, "-", "-", "0";
        measured: f64, "of the reason", "-", "figure that decided: the list of reasons says which";
        limit: f64, "of the reason", "-", "its limit";
        nis_mean: f64, "-", "-", "mean normalised innovation squared per degree of freedom";
        block_z_worst: f64, "sigma", "-", "largest z-score of the block means";
        held_out_rms: f64, "inertial rad/s; slosh, modal m/s^2", "-", "rms error of a simulation over data not used for the fit; NaN: none";
        held_out_noise: f64, "as held_out_rms", "-", "rms that sensor noise alone would give; NaN: none";
        held_out_count: u64, "-", "-", "rows held out";
    }
}

record! {
    /// The inertia about the hub's axis, implied by the modes and by the momentum: do they agree?
    InertiaComparison {
        header: Header, "-", "-", "header";
        frame: u64, "-", "-", "frame of the comparison";
        modal_frame: u64, "-", "-", "frame of the modal estimate";
        inertial_frame: u64, "-", "-", "frame of the inertial estimate";
        phase: u16, "-", "-", "code of Phase";
        agreement: u16, "-", "-", "code of InertiaAgreement";
        doubt_basis: u16, "-", "-", "code of DoubtBasis: what decided which to doubt";
        reserved: u16, "-", "-", "0";
        modal_inertia_kg_m2: f64, "kg m^2", "hub axis", "inertia that the modes imply; NaN: not compared";
        inertial_inertia_kg_m2: f64, "kg m^2", "hub axis", "inertia that the momentum implies; NaN: not compared";
        difference_sigma_kg_m2: f64, "kg m^2", "hub axis", "standard deviation of their difference; NaN: not compared";
        z: f64, "sigma", "-", "modal minus inertial, in standard deviations of the difference; NaN: not compared";
        z_limit: f64, "sigma", "-", "beyond it the two disagree";
    }
}

record! {
    /// Mode decision, effective one pacing window after it was taken.
    Mode {
        header: Header, "-", "-", "header";
        frame: u64, "-", "-", "frame of the decision";
        effective_frame: u64, "-", "-", "first frame that belongs to the new mode";
        duration_frames: u64, "-", "-", "length of the experiment, 0 for none";
        state: u16, "-", "-", "code of ModeState";
        previous: u16, "-", "-", "code of ModeState: the state left";
        experiment: u16, "-", "-", "code of Experiment";
        event: u16, "-", "-", "code of ModeEvent: what caused it";
        generation: u32, "-", "-", "experiment counter";
        ended: u32, "-", "-", "1: nothing follows, the run may end";
        measured: f64, "of the event", "-", "quantity the guard looked at: the list of events says which";
        limit: f64, "of the event", "-", "its limit";
    }
}

record! {
    /// A command. Exempt from the pacing window only where its opcode says so.
    Command {
        header: Header, "-", "-", "header";
        id: u64, "-", "-", "idempotence key";
        opcode: u32, "-", "-", "1: partition given up (urgent)";
        argument: u32, "-", "-", "opcode 1: partition";
    }
}

record! {
    /// Housekeeping of a partition, about once a second of wall time.
    Housekeeping {
        header: Header, "-", "-", "header";
        partition: u32, "-", "-", "code of PartitionId";
        restarts: u32, "-", "-", "how often it was restarted";
        restart_cause: u32, "-", "-", "of the last restart: 0 none, 1 to 255 signal, 256 + exit code";
        allocations: u32, "-", "-", "allocations of its loop later than a second after this start";
        received: u64, "-", "-", "samples delivered to frames";
        lost: u64, "-", "-", "sequence numbers never seen";
        duplicates: u64, "-", "-", "samples dropped because they had been seen";
        bad: u64, "-", "-", "samples dropped: CRC, layout, value not finite";
        latency_us_p50: f64, "us", "-", "send to frame, median";
        latency_us_p99: f64, "us", "-", "send to frame, 99th percentile";
        frame_us_max: f64, "us", "-", "longest frame";
        cpu_percent: f64, "%", "-", "processor time over wall time since start";
        cpu_s: f64, "s", "-", "processor time since start";
        wall_s: f64, "s", "-", "wall time since start";
        events_sent: u64, "-", "-", "events sent since start or since they were cleared";
        events_squelched: u64, "-", "-", "events counted and not sent: too many of their code in a window";
        events_filtered: u64, "-", "-", "events not sent: below the least severity, or their code is switched off";
        deadline_misses: u64, "-", "-", "frames done later than the deadline, since start";
        cycle_slips: u64, "-", "-", "whole periods by which frames began late, since start";
        commands_executed: u32, "-", "-", "commands carried out since start or since they were cleared";
        commands_refused: u32, "-", "-", "commands refused, likewise";
    }
}

impl Default for Innovation {
    /// No test yet.
    fn default() -> Self {
        zerocopy::FromZeros::new_zeroed()
    }
}

impl Default for Estimate {
    /// Every field 0: of the first domain, without parameters.
    fn default() -> Self {
        zerocopy::FromZeros::new_zeroed()
    }
}
