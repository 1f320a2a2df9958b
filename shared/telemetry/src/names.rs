//! Names that travel as numbers: partitions, modes, experiments, parameters, reasons.

macro_rules! coded {
    ($(#[$doc:meta])* $name:ident { $($(#[$vdoc:meta])* $variant:ident = $code:literal $text:literal,)* }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize, serde::Deserialize)]
        #[serde(rename_all = "kebab-case")]
        #[repr(u16)]
        pub enum $name { $($(#[$vdoc])* $variant = $code,)* }
        impl $name {
            pub const ALL: &'static [$name] = &[$($name::$variant,)*];
            #[must_use]
            pub const fn code(self) -> u16 { self as u16 }
            /// `None` for a code that this build does not know.
            #[must_use]
            pub const fn from_code(code: u16) -> Option<Self> {
                match code { $($code => Some($name::$variant),)* _ => None }
            }
            /// Continues a hash over codes and texts, in order.
            const fn hash(mut hash: u32) -> u32 {
                $(hash = crate::layout_hash(hash, concat!($code, " ", $text, ";").as_bytes());)*
                hash
            }
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

coded! {
    /// Who produces a sample.
    PartitionId {
        SensorSim = 0 "sensor-sim",
        InertialId = 1 "inertial-id",
        SloshId = 2 "slosh-id",
        ModalId = 3 "modal-id",
        Supervisor = 4 "supervisor",
        Recorder = 5 "recorder",
    }
}

impl PartitionId {
    pub const COUNT: usize = Self::ALL.len();

    /// The partition called `name`.
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
    /// Why the supervisor accepts or refuses a model.
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
        InertiaAgrees = 14 "the inertia that the modes imply and the one that the momentum implies agree",
        InertiaModalDoubted = 15 "the inertias of modes and momentum disagree: doubt the modal model",
        InertiaInertialDoubted = 16 "the inertias of modes and momentum disagree: doubt the inertial model",
        InertiaUndecided = 17 "the inertias of modes and momentum disagree: nothing says which to doubt",
        SeparateBodies = 18 "inertias of modes and momentum are not comparable: separate bodies",
        InertiaNotFound = 19 "inertias of modes and momentum are not comparable: one of them was not found",
    }
}

coded! {
    /// What an event speaks of; its numbers stand in `Event::arguments`.
    EventCode {
        /// Restarts before, cause of the last one.
        Started = 1 "started",
        /// Samples dropped since the last such event, in all.
        BadSamples = 2 "bad samples dropped",
        /// Sequence numbers missed since the last such event, in all.
        SamplesLost = 3 "samples lost",
        /// Partition that was given up.
        GivenUp = 4 "partition given up",
        /// Frames done.
        Ended = 5 "ended",
    }
}

impl Reason {
    /// Whether it speaks of two estimates side by side, not of one.
    #[must_use]
    pub const fn compares(self) -> bool {
        self.code() >= Self::InertiaAgrees.code()
    }
}

/// Continues a hash over every list of codes and the names of all parameters.
pub(crate) const fn hash_of_codes(hash: u32) -> u32 {
    let hash = Phase::hash(Domain::hash(Experiment::hash(ModeState::hash(PartitionId::hash(hash)))));
    let mut hash = EventCode::hash(Reason::hash(hash));
    let lists: [&[Parameter]; 3] = [&INERTIAL, &SLOSH, &MODAL];
    let mut list = 0;
    while list < lists.len() {
        let mut i = 0;
        while i < lists[list].len() {
            hash = crate::layout_hash(hash, lists[list][i].name.as_bytes());
            hash = crate::layout_hash(hash, lists[list][i].unit.as_bytes());
            i += 1;
        }
        list += 1;
    }
    hash
}

/// `TargetEstimate::status`.
pub const TARGET_CRC_WRONG: u16 = 1;
pub const TARGET_REFUSED: u16 = 2;
pub const TARGET_NOT_SOLVED: u16 = 3;
pub const TARGET_CONTRADICTED: u16 = 4;

/// What is wrong with numbers of a target; empty when nothing is.
#[must_use]
pub const fn target_status_text(status: u16) -> &'static str {
    match status {
        0 => "",
        TARGET_CRC_WRONG => "crc wrong",
        TARGET_REFUSED => "what the target states contradicts what was identified",
        TARGET_NOT_SOLVED => {
            "no solution: both experiments and the arm's data sheet are needed; or a covariance was not positive, or the search did not converge"
        }
        TARGET_CONTRADICTED => "the estimates before and after capture and the arm's data sheet contradict each other",
        _ => "unknown status",
    }
}

/// Why an estimator has no estimate (`Estimate::status`); its numbers stand in `auxiliary` 10 and 11.
#[must_use]
pub const fn status_text(domain: Domain, status: u32) -> &'static str {
    match (domain, status) {
        (_, 0) => "valid",
        (Domain::Inertial, 1) => "momentum or prior are not known: state them in the scenario",
        (Domain::Inertial, 2) => "not excited enough: some direction carries more noise than signal",
        (Domain::Inertial, 4) => {
            "the motion's shape is not known yet, or no joint torques are: state joint_torque_sigma_nm"
        }
        (Domain::Inertial, 3) => "no sample had a rate and both joints at one time",
        (Domain::Slosh, 1) => "the hub's mass is not known: state it in the scenario",
        (Domain::Slosh, 2) => "the arc is too short for its unknowns",
        (Domain::Slosh, 3) => {
            "no slosh found: no frequency explains more than noise (is the force on the stated axis?)"
        }
        (Domain::Slosh, 4) => "the maximum of the likelihood was not reached",
        (Domain::Slosh, 5) => "too many gaps",
        (Domain::Slosh, 6) => "the slosh mode is too fast for the blocks of so long a record: shorten it",
        (Domain::Modal, 1) => "no accelerometer rows on the stated channels",
        (Domain::Modal, 2) => "the record is too short",
        (Domain::Modal, 3) => "no mode found",
        (Domain::Modal, 4) => "the channels are flat",
        (Domain::Modal, 5) => "a factorisation did not converge",
        (Domain::Modal, 6) => "excited throughout: no free or operational segment",
        _ => "unknown status",
    }
}

/// Name and unit of one element of an estimate's value vector.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Parameter {
    pub name: &'static str,
    pub unit: &'static str,
}

const fn p(name: &'static str, unit: &'static str) -> Parameter {
    Parameter { name, unit }
}

const INERTIAL: [Parameter; 9] = [
    p("a1", "kg m^2"),
    p("a2", "kg m^2"),
    p("a3", "kg m^2"),
    p("a4", "kg m^2"),
    p("a5", "kg m^2"),
    p("a6", "kg m^2"),
    p("a7", "kg m^2"),
    p("a8", "kg m^2"),
    p("a9", "kg m^2"),
];
const SLOSH: [Parameter; 3] = [p("m_s", "kg"), p("k_s", "N/m"), p("c_s", "N s/m")];
const MODAL: [Parameter; 12] = [
    p("f1", "Hz"),
    p("zeta1", "-"),
    p("f2", "Hz"),
    p("zeta2", "-"),
    p("f3", "Hz"),
    p("zeta3", "-"),
    p("f4", "Hz"),
    p("zeta4", "-"),
    p("f5", "Hz"),
    p("zeta5", "-"),
    p("f6", "Hz"),
    p("zeta6", "-"),
];

/// Names and units of an estimate's values, in order.
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
    use super::{Domain, Experiment, ModeState, PartitionId, Phase, Reason, parameters};
    use crate::PARAMETERS_MAX;

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
        check_codes!(PartitionId, ModeState, Experiment, Domain, Phase, Reason);
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
