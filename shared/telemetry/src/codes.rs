//! All lists of codes, and what of them a layout hash covers.

use crate::names::{INERTIAL, MODAL, SLOSH};
use crate::{
    CodeList, DiagnosisVerdict, Domain, DoubtBasis, EventCode, Experiment, HealthAction, HealthError, HealthLevel,
    Identifiability, InertiaAgreement, InertialStatus, JointVerdict, ModalStatus, ModeState, Opcode, Parameter,
    ParameterBlock, PartitionId, Phase, Reason, Refusal, Severity, SloshStatus, TableId, layout_hash,
};

/// Every list of codes, as the interface control document shows them.
pub const CODE_LISTS: [CodeList; 23] = [
    PartitionId::LIST,
    ModeState::LIST,
    Experiment::LIST,
    Domain::LIST,
    Phase::LIST,
    Identifiability::LIST,
    InertialStatus::LIST,
    SloshStatus::LIST,
    ModalStatus::LIST,
    Reason::LIST,
    InertiaAgreement::LIST,
    DoubtBasis::LIST,
    EventCode::LIST,
    ParameterBlock::LIST,
    JointVerdict::LIST,
    DiagnosisVerdict::LIST,
    Severity::LIST,
    Opcode::LIST,
    Refusal::LIST,
    TableId::LIST,
    HealthLevel::LIST,
    HealthError::LIST,
    HealthAction::LIST,
];

/// Continues a hash over every list of codes and the names of all parameters.
pub(crate) const fn hash_of_codes(mut hash: u32) -> u32 {
    let mut list = 0;
    while list < CODE_LISTS.len() {
        hash = layout_hash(hash, CODE_LISTS[list].name.as_bytes());
        let mut at = 0;
        while at < CODE_LISTS[list].codes.len() {
            let (code, text) = CODE_LISTS[list].codes[at];
            hash = layout_hash(layout_hash(hash, &code.to_le_bytes()), text.as_bytes());
            at += 1;
        }
        list += 1;
    }
    let lists: [&[Parameter]; 3] = [&INERTIAL, &SLOSH, &MODAL];
    let mut list = 0;
    while list < lists.len() {
        let mut i = 0;
        while i < lists[list].len() {
            hash = layout_hash(hash, lists[list][i].name.as_bytes());
            hash = layout_hash(hash, lists[list][i].unit.as_bytes());
            i += 1;
        }
        list += 1;
    }
    hash_of_tables(hash)
}

/// Values of a table travel without their names.
const fn hash_of_tables(mut hash: u32) -> u32 {
    let mut table = 0;
    while table < TableId::ALL.len() {
        let fields = TableId::ALL[table].fields();
        let mut at = 0;
        while at < fields.len() {
            hash = layout_hash(hash, fields[at].name.as_bytes());
            at += 1;
        }
        table += 1;
    }
    hash
}
