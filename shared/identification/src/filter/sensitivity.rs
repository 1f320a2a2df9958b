//! Sensitivities of a pass with frozen gains to parameters of the plant, all of them in one pass
//! along the trajectory.
//!
//! With S = ∂ẑ/∂θ, and what θ does there at a fixed state, b to the rates and D to the readings:
//!
//! ```text
//! ∂ŷ = H S + D,   S ← S − K ∂ŷ,   S ← F S + ∫ e^{A s} b   (Friedland's separated bias)
//! b = −M⁻¹ ∂r/∂θ at the found acceleration,   D = ∂y/∂θ|ₐ + ∂y/∂a b
//! ```
//!
//! F, H and K are those of the linear model; b is taken at the beginning, the middle and the end of
//! every step of integration, A between its values at both events.

mod apart;
mod interval;
mod local;
mod recursion;

use super::Linear;
use super::jacobian::{Jacobian, Slopes};
use super::propagator::{Point, Propagator};
use apart::Apart;
use dynamics::system::Differs;
use interval::{Interval, Stretch};
use local::Local;
use recursion::Recursion;

/// A plant beside the nominal one: one number moved.
pub struct Moved<'a> {
    propagator: Propagator<'a>,
    /// Change of the number, in the unit that sensitivities are per.
    step: f64,
    differs: Differs,
    /// Its sensors are stamped or delayed otherwise.
    retimed: bool,
}

impl<'a> Moved<'a> {
    /// `None` where a difference at points does not show what the number does: other parts, other
    /// lags, commands that pass filters.
    pub fn new(nominal: &Propagator<'_>, propagator: Propagator<'a>, step: f64) -> Option<Self> {
        let differs = nominal.system.differs(&propagator.system)?;
        let alike = nominal.layout == propagator.layout && nominal.same_lags(&propagator);
        let retimed = !nominal.is_timed_as(&propagator);
        (alike && propagator.is_driven_plainly()).then_some(Self { propagator, step, differs, retimed })
    }

    /// Work of its evaluations so far.
    pub fn work(&self) -> f64 {
        self.propagator.work()
    }

    fn moves(&self) -> bool {
        self.differs != Differs::InReadings
    }
}

/// Rows of columns are whole fours of numbers, as vectors are.
const FOUR: usize = 4;

/// `∂ŷ/∂θ` of every sample of the run of `linear`, one column for each of `moved`; `None` where the
/// plant has no residual.
///
/// `divisions`: parts that each step of the timeline was divided into; b is smooth over a whole
/// one.
///
/// Cost: a residual for each moving plant at every point, and per sample columns × size of z
/// products.
pub fn sensitivities(
    nominal: &mut Propagator<'_>,
    linear: &Linear,
    moved: &mut [Moved<'_>],
    divisions: usize,
) -> Option<Vec<Vec<f64>>> {
    let point = Point::of(nominal).filter(|_| nominal.is_driven_plainly())?;
    let mut jacobians = [Jacobian::new(nominal, &point), Jacobian::new(nominal, &point)];
    let (mut slopes, mut mass) = (Slopes::new(&jacobians[0]), Slopes::new(&jacobians[0]));
    let mut rates = Slopes::new(&jacobians[0]);
    let mut local = Local::new(moved, point);
    let mut interval = Interval::new(&local);
    let mut recursion = Recursion::new(nominal, linear, moved, &local);
    let (n, m) = (nominal.x0.len(), linear.layout.noise_inputs.len());
    for k in 0..nominal.timeline.events.len() {
        let event = nominal.timeline.events[k];
        let (held, x) = (&linear.held[k * m..(k + 1) * m], &linear.states[k * n..(k + 1) * n]);
        local.place(nominal, (event.t_s, event.row, held), x);
        local.take(nominal, moved, Some(&mut recursion.d));
        jacobians.swap(0, 1);
        jacobians[1].take(nominal, &local.point);
        let here = &jacobians[1];
        if !mass.take_mass([here, here], 0.0) {
            return None;
        }
        local.finish(&mass, Some(&mut recursion.d));
        if Apart::needs_rates(nominal, k) && !rates.take([here, here], 0.0) {
            return None;
        }
        recursion.apart.b.copy_from_slice(&local.b);
        if k > 0 {
            let begin = &linear.updated[(k - 1) * n..k * n];
            let [before, here] = &mut jacobians;
            if !before.serves(nominal, begin) {
                let (event, held) = (nominal.timeline.events[k - 1], &linear.held_updated[(k - 1) * m..k * m]);
                local.place(nominal, (event.t_s, event.row, held), begin);
                before.take(nominal, &local.point);
            }
            let stretch = Stretch::new(nominal, linear, k - 1, [before, here]);
            let whole = (stretch.event.steps / divisions).max(1);
            let lags = recursion.lags_behind(nominal, k);
            let steps = if lags { whole.next_multiple_of(2) } else { whole };
            let solved = slopes.take([before, here], 0.5)
                && interval.take((nominal, moved), (&mut local, &slopes, &mut mass), (&stretch, begin, (steps, lags)));
            if !solved {
                return None;
            }
            recursion.move_on(nominal, k, (&interval, &slopes));
        }
        recursion.take_up((nominal, moved), k, (&rates, &interval));
    }
    Some(recursion.columns)
}
