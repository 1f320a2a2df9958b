//! Reasons on their way into the interface control document.
use telemetry::Reason;
pub const OPERATIONAL_RECORD: Reason = Reason::NoHeldOutData;
pub const OUT_OF_REACH: Reason = Reason::NoNeedStated;
pub const INPUTS_LOST: Reason = Reason::NoEstimate;
pub const NOT_REACHED: Reason = Reason::NoEstimate;
