//! The parameter table `guards`: limits and longest waits of the mode table.

use crate::mode::Plan;
use telemetry::{TableId, TableValues};

/// The table that says what `plan` says; `None` for a plan that is outside the table's ranges.
pub fn of(plan: &Plan) -> Option<TableValues> {
    let frames = [
        plan.settle_frames,
        plan.hold_timeout_frames,
        plan.capture_timeout_frames,
        plan.safe_dwell_frames,
        plan.accepted_age_limit_frames,
    ];
    let mut values = [plan.base_rate_limit_rad_s; 6];
    values[1..].iter_mut().zip(frames).for_each(|(value, frames)| *value = frames as f64);
    TableValues::checked(TableId::Guards, &values).ok()
}

/// Takes the values into `plan`.
pub fn put(plan: &mut Plan, values: &TableValues) {
    let &[rate, ref frames @ ..] = values.as_slice() else { return };
    plan.base_rate_limit_rad_s = rate;
    let own = [
        &mut plan.settle_frames,
        &mut plan.hold_timeout_frames,
        &mut plan.capture_timeout_frames,
        &mut plan.safe_dwell_frames,
        &mut plan.accepted_age_limit_frames,
    ];
    own.into_iter().zip(frames).for_each(|(own, value)| *own = *value as u64);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mode::{ModeMachine, Situation, Stimulus};
    use telemetry::ModeState;

    fn plan() -> Plan {
        Plan {
            modal: None,
            slosh: None,
            inertial: None,
            capture: true,
            mated: None,
            replay: None,
            settle_frames: 1,
            hold_timeout_frames: 2,
            capture_timeout_frames: 3,
            safe_dwell_frames: 4,
            accepted_age_limit_frames: 5,
            base_rate_limit_rad_s: 0.25,
            operator_override: false,
        }
    }

    #[test]
    fn a_table_put_into_a_plan_is_the_table_of_that_plan_field_by_field() {
        assert_eq!(of(&plan()).unwrap().as_slice(), [0.25, 1.0, 2.0, 3.0, 4.0, 5.0]);
        let other = TableValues::checked(TableId::Guards, &[0.5, 11.0, 12.0, 13.0, 14.0, 15.0]).unwrap();
        let mut changed = plan();
        put(&mut changed, &other);
        assert_eq!(of(&changed), Some(other));
    }

    #[test]
    fn a_dwell_that_was_set_in_flight_is_the_one_that_the_machine_waits() {
        let ends = |dwell_frames: Option<f64>| {
            let mut machine = ModeMachine::new(plan(), 100);
            let mut limits = plan();
            if let Some(frames) = dwell_frames {
                let mut values = of(&limits).unwrap().as_slice().to_vec();
                values[4] = frames;
                put(&mut limits, &TableValues::checked(TableId::Guards, &values).unwrap());
                machine.set_limits(&limits);
            }
            let first = machine.evaluate(0, &[Stimulus::SafeCommand], &Situation::default()).unwrap();
            assert_eq!(first.to, ModeState::Safe);
            (1..1000).find(|&frame| machine.evaluate(frame, &[], &Situation::default()).is_some())
        };
        // The mode is in force a window after the command, and the dwell begins there.
        assert_eq!(ends(None), Some(104));
        assert_eq!(ends(Some(50.0)), Some(150));
    }
}
