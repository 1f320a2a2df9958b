//! The next experiment where an effect is not decided: the pair in question, the menu, and its
//! sentences.

use crate::next_experiment::{Experiment, Question, SEPARATES, menu};
use crate::score::Candidate;
use dynamics::description::Plant;
use identification::fit::EstimationSession;
use identification::problem::{Drive, Problem};

/// Menu entries in the report.
const MENU_REPORTED_MAX: usize = 5;

/// The scenario that separates the least decided effect from its strongest rival, or why there is
/// none.
pub(crate) enum Next {
    NothingOpen,
    /// A plant file whose commands are the experiment.
    Scenario(String),
    /// No entry of the menu separates the two.
    Never(String),
}

/// The scenario that separates `first` at `amplitude`, which `plant` has, from `second`.
pub(crate) fn separating(
    session: &EstimationSession<'_>,
    plant: &Plant,
    (first, amplitude): (&Candidate, &[f64]),
    second: &Candidate,
) -> Next {
    let problem = session.problem;
    let flown: Vec<f64> = (0..plant.actuators.len()).map(|index| largest(problem, index)).collect();
    let duration_s = problem.span_s()[1] - problem.span_s()[0];
    let question = Question { plant, first, amplitude, second, duration_s, flown: &flown };
    in_words(first, second, &menu(&question, session.threads, &session.work))
}

fn in_words(first: &Candidate, second: &Candidate, menu: &[Experiment]) -> Next {
    let pair = format!("{}@{} from {}@{}", first.effect.kind, first.site, second.effect.kind, second.site);
    let list: Vec<String> =
        menu.iter().take(MENU_REPORTED_MAX).map(|entry| format!("{} ({:.1})", entry.name, entry.d)).collect();
    let list = list.join(", ");
    match menu.first().filter(|best| best.d >= SEPARATES) {
        Some(best) => Next::Scenario(format!(
            "# Next experiment: {}, {} s. Expected to separate {pair} by {:.1} standard errors.\n\
             # Menu within the stated limits, standard errors in brackets: {list}.\n\
             # The file simulates; its commands are the profile.\n{}",
            best.name,
            best.duration_s,
            best.d,
            plant_file::write(&best.plant)
        )),
        None if menu.is_empty() => Next::Never(format!(
            "nothing can be flown that would separate {pair}: the plant states no free input with a range, no loop and no initial state"
        )),
        None => Next::Never(format!(
            "no experiment of the menu separates {pair}: standard errors expected {list}; another sensor or another place would"
        )),
    }
}

/// Largest command of an actuator in the recordings; NaN where it was not recorded.
fn largest(problem: &Problem, actuator: usize) -> f64 {
    let recorded = problem.runs.iter().filter_map(|run| match &run.drives[actuator] {
        Drive::Held { value, .. } => Some(value.iter().fold(0.0f64, |most, u| most.max(u.abs()))),
        _ => None,
    });
    recorded.fold(f64::NAN, f64::max)
}
