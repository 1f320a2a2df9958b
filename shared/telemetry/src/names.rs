//! Names that samples carry as codes: partitions, modes, experiments, parameters, reasons.

/// A list of codes: the meaning of each value of a coded field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CodeList {
    /// Of the enumeration, as field descriptions cite it.
    pub name: &'static str,
    /// Code and meaning.
    pub codes: &'static [(u16, &'static str)],
}

macro_rules! coded {
    ($(#[$doc:meta])* $name:ident { $($(#[$vdoc:meta])* $variant:ident = $code:literal $text:literal,)* }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize, serde::Deserialize)]
        #[serde(rename_all = "kebab-case")]
        #[repr(u16)]
        pub enum $name { $($(#[$vdoc])* $variant = $code,)* }
        impl $name {
            /// Every variant, in the order of its code.
            pub const ALL: &'static [$name] = &[$($name::$variant,)*];
            /// As the interface control document shows it.
            pub const LIST: $crate::CodeList = $crate::CodeList { name: stringify!($name), codes: &[$(($code, $text),)*] };
            /// As samples carry it; part of the wire format, never reassigned.
            #[must_use]
            pub const fn code(self) -> u16 { self as u16 }
            /// `None` for a code that this build does not know.
            #[must_use]
            pub const fn from_code(code: u16) -> Option<Self> {
                match code { $($code => Some($name::$variant),)* _ => None }
            }
            /// As logs, screens and the interface control document show it.
            #[must_use]
            pub const fn text(self) -> &'static str {
                match self { $($name::$variant => $text,)* }
            }
        }
        impl core::fmt::Display for $name {
            fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result { f.pad(self.text()) }
        }
    };
}

pub(crate) use coded;

coded! {
    /// Who produces a sample.
    PartitionId {
        SensorSim = 0 "sensor-sim",
        InertialId = 1 "inertial-id",
        SloshId = 2 "slosh-id",
        ModalId = 3 "modal-id",
        Supervisor = 4 "supervisor",
        Recorder = 5 "recorder",
        /// Lowest priority: says which physics a refused model lacks.
        Diagnosis = 6 "diagnosis",
    }
}

impl PartitionId {
    /// Partitions of a complete system, the source included: the length of tables indexed by
    /// [`PartitionId::code`].
    pub const COUNT: usize = Self::ALL.len();

    /// The partition whose [`PartitionId::text`] is `name`; `None` if there is none.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|id| id.text() == name)
    }
}

coded! {
    /// State of the mode table.
    ModeState {
        Safe = 0 "SAFE",
        Standby = 1 "STANDBY",
        PreCaptureModal = 2 "PRE_CAPTURE.MODAL",
        PreCaptureSlosh = 3 "PRE_CAPTURE.SLOSH",
        PreCaptureInertial = 4 "PRE_CAPTURE.INERTIAL",
        ApproachHold = 5 "APPROACH_HOLD",
        Capture = 6 "CAPTURE",
        MatedSettle = 7 "MATED.SETTLE",
        MatedInertial = 8 "MATED.INERTIAL",
    }
}

coded! {
    /// What the vehicle is excited for.
    Experiment {
        None = 0 "none",
        Modal = 1 "modal",
        Slosh = 2 "slosh",
        Inertial = 3 "inertial",
        MatedInertial = 4 "mated inertial",
        /// A recording is played: every domain whose channels are present identifies.
        Replay = 5 "replay",
        /// Flown to be predicted, not to be fitted.
        HeldOut = 6 "held out",
    }
}

coded! {
    /// Which physics an estimate speaks of.
    Domain {
        Inertial = 0 "inertial",
        Slosh = 1 "slosh",
        Modal = 2 "modal",
    }
}

coded! {
    /// When in the mission an estimate was made.
    Phase {
        PreCapture = 0 "pre_capture",
        Mated = 1 "mated",
        Replay = 2 "replay",
    }
}

coded! {
    /// Why the supervisor accepts or rejects a model.
    Reason {
        Accepted = 0 "adequate, sigmas honest, physically consistent",
        NoEstimate = 1 "no estimate was made",
        InnovationsBiased = 2 "incomplete: innovations are not white on block means",
        NisOutOfBand = 3 "sigmas not honest: mean NIS outside its band",
        NotConsistent = 4 "physically inconsistent parameters",
        HeldOutTooLarge = 5 "inadequate: held-out simulation error above the need",
        SigmaTooLarge = 6 "inadequate: standard deviation above the need",
        NoNeedStated = 7 "no need is stated in the scenario: adequacy cannot be judged",
        NoHeldOutData = 8 "no data were held out (a free decay, or the rows behind 80 % of an experiment): adequacy cannot be judged",
        PartitionLost = 9 "the partition was given up",
        OperationalRecord = 10 "an operational record holds no free decay: adequacy cannot be judged",
        OutOfReach = 11 "skipped: its predicted sigma cannot meet the need",
        InputsLost = 12 "aborted: a sensor fell silent",
        NotReached = 13 "not flown",
    }
}

coded! {
    /// What the data of an experiment did to the prior of a parameter, in every domain.
    Identifiability {
        NoPrior = 0 "no prior",
        Identified = 1 "identified",
        PriorKept = 2 "prior kept",
        NotExcited = 3 "not excited",
    }
}

coded! {
    /// The inertia that the modes imply against the one that the momentum implies.
    InertiaAgreement {
        Agree = 0 "the inertia that the modes imply and the one that the momentum implies agree",
        ModalDoubted = 1 "the inertias of modes and momentum disagree: doubt the modal model",
        InertialDoubted = 2 "the inertias of modes and momentum disagree: doubt the inertial model",
        Undecided = 3 "the inertias of modes and momentum disagree: nothing says which to doubt",
        SeparateBodies = 4 "inertias of modes and momentum are not comparable: separate bodies",
        NotFound = 5 "inertias of modes and momentum are not comparable: one of them was not found",
    }
}

impl InertiaAgreement {
    /// Whether there were two inertias of one body.
    #[must_use]
    pub const fn is_comparison(self) -> bool {
        !matches!(self, Self::SeparateBodies | Self::NotFound)
    }
}

coded! {
    /// What decided which of two inertias that disagree to doubt.
    DoubtBasis {
        None = 0 "nothing",
        OwnTests = 1 "it fails its own tests while the other passes",
        StatedInertia = 2 "the stated inertia contradicts it while it confirms the other",
    }
}

coded! {
    /// Why there is no estimate of the arm's parameters.
    InertialStatus {
        Valid = 0 "valid",
        NotKnown = 1 "momentum or prior are not known: state them in the scenario",
        NotExcited = 2 "not excited enough: some direction carries more noise than signal",
        NoSamples = 3 "no sample had a rate and both joints at one time",
        NoTorques = 4 "the motion's shape is not known yet, or no joint torques are: state joint_torque_sigma_nm",
    }
}

coded! {
    /// Why there is no estimate of the slosh parameters.
    SloshStatus {
        Valid = 0 "valid",
        NotKnown = 1 "the hub's mass is not known: state it in the scenario",
        ArcTooShort = 2 "the arc is too short for its unknowns",
        NoSloshFound = 3 "no slosh found: no frequency explains more than noise (is the force on the stated axis?)",
        NotConverged = 4 "the maximum of the likelihood was not reached",
        Fragmented = 5 "too many gaps",
        ModeNotResolved = 6 "the slosh mode is too fast for the blocks of so long a record: shorten it",
    }
}

coded! {
    /// Why there is no estimate of modes.
    ModalStatus {
        Valid = 0 "valid",
        NothingToWorkOn = 1 "no accelerometer rows on the stated channels",
        RecordTooShort = 2 "the record is too short",
        NoMode = 3 "no mode found",
        FlatChannels = 4 "the channels are flat",
        DecompositionFailed = 5 "a factorisation did not converge",
        ExcitedThroughout = 6 "excited throughout: no free or operational segment",
    }
}

coded! {
    /// Part of a craft that a parameter belongs to.
    ParameterBlock {
        /// Masses, moments and joints.
        Inertial = 0 "inertial",
        Slosh = 1 "slosh",
        Modal = 2 "modal",
        /// Wheels and other actuators.
        Wheel = 3 "wheel",
        Sensor = 4 "sensor",
        /// All of them together.
        Whole = 5 "whole",
    }
}

coded! {
    /// Whether all arcs together give a model, or what speaks against it.
    JointVerdict {
        Undecided = 0 "not decided yet",
        Accepted = 1 "every arc is explained, all agree, the held-out arc is predicted",
        NoMessage = 2 "no arc gave a message",
        NotConverged = 3 "the iteration did not converge",
        ArcNotExplained = 4 "model refused: the residual of an arc is not its noise",
        ArcsContradict = 5 "model refused: an arc contradicts the others",
        HeldOutMissed = 6 "model refused: the held-out arc is not predicted",
        NoHeldOut = 7 "no arc was held out: adequacy cannot be judged",
    }
}

coded! {
    /// What an arc says of the physics that a refused model lacks.
    DiagnosisVerdict {
        CannotDecide = 0 "the arc does not decide what is missing",
        Nothing = 1 "the arc misses nothing",
        Named = 2 "effects are missing",
        NotSeparable = 3 "effects are missing that others could replace",
        NotInCatalogue = 4 "a law is missing that the catalogue does not hold",
        NoiseModel = 5 "the noise is not as stated",
        ParameterConflict = 6 "a parameter is beyond its prior",
        InputTiming = 7 "inputs act at other times than their stamps say",
        Sensor = 8 "sensors have errors that are not modelled",
        Unobservable = 9 "no effect of usual size would show",
    }
}

impl Reason {
    /// What `Verdict::measured` and `Verdict::limit` are under this reason; 0 where it says none.
    #[must_use]
    pub const fn figures(self) -> &'static str {
        match self {
            Self::Accepted | Self::HeldOutTooLarge => {
                "rms of the held-out simulation error and its need [as held_out_rms]"
            }
            Self::NoEstimate => "status of the estimate; no limit",
            Self::InnovationsBiased => "z-score of the block means and its limit [sigma]",
            Self::NisOutOfBand => {
                "mean NIS and the end of its band that it passes [-]; a limit of infinity: too few rows"
            }
            Self::NotConsistent => "Estimate.consistent and 1",
            Self::SigmaTooLarge => "standard deviation over the value and its need [%]",
            Self::NoHeldOutData => {
                "rms of the held-out signal and three times that of its noise [as held_out_rms]; both 0: no rows"
            }
            Self::OutOfReach => "largest predicted sigma over its need and the limit of that ratio [-]",
            Self::NoNeedStated
            | Self::PartitionLost
            | Self::OperationalRecord
            | Self::InputsLost
            | Self::NotReached => "none",
        }
    }
}

/// `TargetEstimate::status`: the target's statement arrived with a wrong CRC and was not used.
pub const TARGET_CRC_WRONG: u16 = 1;
/// `TargetEstimate::status`: the statement was rejected. It contradicts the identified parameters
/// at p < 0.001, or its covariance is not positive definite.
pub const TARGET_REJECTED: u16 = 2;
/// `TargetEstimate::status`: no target could be identified, because an estimate or the data sheet
/// is missing, a covariance is not positive definite, or the search did not converge.
pub const TARGET_NOT_SOLVED: u16 = 3;
/// `TargetEstimate::status`: the estimates before and after capture and the chaser's data sheet
/// contradict each other at p < 0.001.
pub const TARGET_CONTRADICTED: u16 = 4;

/// Meaning of a `TargetEstimate::status`; empty for 0, a valid estimate.
#[must_use]
pub const fn target_status_text(status: u16) -> &'static str {
    match status {
        0 => "",
        TARGET_CRC_WRONG => "crc wrong",
        TARGET_REJECTED => "what the target states contradicts what was identified",
        TARGET_NOT_SOLVED => {
            "no solution: both experiments and the arm's data sheet are needed; or a covariance was not positive, or the search did not converge"
        }
        TARGET_CONTRADICTED => "the estimates before and after capture and the arm's data sheet contradict each other",
        _ => "unknown status",
    }
}

/// Why an estimator has no estimate (`Estimate::status`).
#[must_use]
pub const fn status_text(domain: Domain, status: u32) -> &'static str {
    let list = match domain {
        Domain::Inertial => InertialStatus::LIST,
        Domain::Slosh => SloshStatus::LIST,
        Domain::Modal => ModalStatus::LIST,
    };
    // The codes of a status are contiguous from 0: a test says so.
    if (status as usize) < list.codes.len() { list.codes[status as usize].1 } else { "unknown status" }
}

/// One element of an estimate's value vector.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Parameter {
    /// Symbol, unique inside a domain.
    pub name: &'static str,
    /// SI unit, `-` for a ratio.
    pub unit: &'static str,
    /// Quantity, with the point and the axis that it refers to.
    pub what: &'static str,
}

const fn p(name: &'static str, unit: &'static str, what: &'static str) -> Parameter {
    Parameter { name, unit, what }
}

pub(crate) const INERTIAL: [Parameter; 9] = [
    p("a1", "kg m^2", "augmented inertia of the base: factor of w0 in the angular momentum"),
    p("a2", "kg m^2", "augmented inertia of link 1: factor of w0 + d1"),
    p("a3", "kg m^2", "augmented inertia of link 2 and what it holds: factor of w0 + d1 + d2"),
    p("a4", "kg m^2", "coupling of base and link 1: factor of (2 w0 + d1) cos th1"),
    p("a5", "kg m^2", "coupling of base and link 1: factor of (2 w0 + d1) sin th1"),
    p("a6", "kg m^2", "coupling of base and link 2: factor of (2 w0 + d1 + d2) cos (th1 + th2)"),
    p("a7", "kg m^2", "coupling of base and link 2: factor of (2 w0 + d1 + d2) sin (th1 + th2)"),
    p("a8", "kg m^2", "coupling of links 1 and 2: factor of (2 w0 + 2 d1 + d2) cos th2"),
    p(
        "a9",
        "kg m^2",
        "coupling of links 1 and 2: factor of (2 w0 + 2 d1 + d2) sin th2; 0 while nothing is held off axis",
    ),
];
pub(crate) const SLOSH: [Parameter; 3] = [
    p("m_s", "kg", "slosh mass"),
    p("k_s", "N/m", "stiffness between slosh mass and hub"),
    p("c_s", "N s/m", "damping between slosh mass and hub"),
];
/// Natural frequency and damping ratio of one mode.
const fn mode(frequency: &'static str, damping: &'static str) -> [Parameter; 2] {
    [p(frequency, "Hz", "natural frequency"), p(damping, "-", "damping ratio")]
}
pub(crate) const MODAL: [Parameter; 12] = {
    let [[f1, zeta1], [f2, zeta2], [f3, zeta3]] = [mode("f1", "zeta1"), mode("f2", "zeta2"), mode("f3", "zeta3")];
    let [[f4, zeta4], [f5, zeta5], [f6, zeta6]] = [mode("f4", "zeta4"), mode("f5", "zeta5"), mode("f6", "zeta6")];
    [f1, zeta1, f2, zeta2, f3, zeta3, f4, zeta4, f5, zeta5, f6, zeta6]
};

/// Names, units and meanings of an estimate's values, in order.
#[must_use]
pub const fn parameters(domain: Domain) -> &'static [Parameter] {
    match domain {
        Domain::Inertial => &INERTIAL,
        Domain::Slosh => &SLOSH,
        Domain::Modal => &MODAL,
    }
}

#[cfg(test)]
mod tests {
    use super::{
        DiagnosisVerdict, Domain, DoubtBasis, Experiment, Identifiability, InertiaAgreement, InertialStatus,
        JointVerdict, ModalStatus, ModeState, ParameterBlock, PartitionId, Phase, Reason, SloshStatus, parameters,
        status_text,
    };
    use crate::{HealthAction, HealthError, HealthLevel, PARAMETERS_MAX};

    macro_rules! check_codes {
        ($($name:ident),*) => { $(
            for (at, name) in $name::ALL.iter().enumerate() {
                // Codes index tables of the runtime: contiguous from 0.
                assert_eq!(usize::from(name.code()), at);
                assert_eq!($name::from_code(name.code()), Some(*name));
                assert_eq!($name::ALL.iter().filter(|other| other.text() == name.text()).count(), 1);
            }
            assert_eq!($name::from_code($name::ALL.len() as u16), None);
            assert_eq!($name::from_code(u16::MAX), None);
        )* };
    }

    #[test]
    fn every_code_stands_for_one_name_and_an_unknown_code_for_none() {
        check_codes!(PartitionId, ModeState, Experiment, Domain, Phase, Reason, Identifiability, InertiaAgreement);
        check_codes!(
            DoubtBasis,
            InertialStatus,
            SloshStatus,
            ModalStatus,
            ParameterBlock,
            JointVerdict,
            DiagnosisVerdict,
            HealthLevel,
            HealthError,
            HealthAction
        );
    }

    #[test]
    fn a_status_is_told_in_the_words_of_its_own_domain() {
        for &domain in Domain::ALL {
            assert_eq!(status_text(domain, 0), "valid");
            assert_eq!(status_text(domain, u32::MAX), "unknown status");
        }
        for status in ModalStatus::ALL {
            assert_eq!(status_text(Domain::Modal, status.code().into()), status.text());
        }
        assert_eq!(status_text(Domain::Inertial, InertialStatus::ALL.len() as u32), "unknown status");
    }

    #[test]
    fn a_partition_is_found_by_its_name_and_by_no_other() {
        for &id in PartitionId::ALL {
            assert_eq!(PartitionId::named(id.text()), Some(id));
        }
        assert_eq!(PartitionId::named("Recorder"), None);
    }

    #[test]
    fn an_estimate_has_room_for_the_parameters_of_every_domain_and_their_names_are_unique() {
        for &domain in Domain::ALL {
            let list = parameters(domain);
            assert!(list.len() <= PARAMETERS_MAX, "{domain}");
            for parameter in list {
                assert_eq!(list.iter().filter(|other| other.name == parameter.name).count(), 1, "{}", parameter.name);
            }
        }
    }
}
