//! Integration over one stretch of held input: adaptive Dormand–Prince 5(4), sticking and slipping
//! located as events.
//!
//! State `[q | v | bristles | lags of inputs | lags of sensors]`. A coordinate with dry friction is
//! stuck, or slides one way. Sliding ends where its rate is zero, sticking where the force that
//! holds it exceeds what friction can hold; both instants are roots on the dense output. The stuck
//! coordinate is held by a constraint, not by a steep slope.

use crate::equations::{DOF_MAX, Equations, Vector};
use crate::hidden::Faults;
use differential_equations::prelude::{CrossingDirection, Event, EventConfig, ExplicitRungeKutta, IVP, ODE, Status};

/// Relative and absolute error of a step; the finest sensor resolves micrometres.
const TOLERANCE: (f64, f64) = (1e-9, 1e-12);
/// Rate past zero that ends sliding: below the resolution of the integration.
const STOP_RATE: f64 = 1e-11;
/// Most inputs, sensors and hidden states of a machine.
const INPUTS_MAX: usize = 3;
const SENSORS_MAX: usize = 3;
const HIDDEN_MAX: usize = 2;
/// Length of a state; components that a machine does not use stay zero.
const STATES_MAX: usize = 2 * DOF_MAX + HIDDEN_MAX + INPUTS_MAX + SENSORS_MAX;
/// Most changes of contact in one stretch; after more (chatter) the contacts stay as they are.
const CHANGES_MAX: usize = 60;

/// State of a coordinate with dry friction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Contact {
    Stuck,
    /// Towards plus or minus one.
    Sliding(f64),
}

/// A state vector, in the order of the module's page.
pub type State = [f64; STATES_MAX];

/// A machine with its hidden effects.
pub struct Rig {
    pub equations: Box<dyn Equations>,
    pub faults: Faults,
}

/// State and contacts.
#[derive(Clone, Debug)]
pub struct Motion {
    pub x: State,
    pub contacts: Vec<Contact>,
    /// Largest step that was taken in the last stretch [s]; zero: none yet.
    step_s: f64,
}

/// Offsets of the parts of a state vector.
#[derive(Clone, Copy)]
pub struct Places {
    pub n: usize,
    pub hidden: usize,
    pub inputs: usize,
    pub sensors: usize,
}

impl Rig {
    /// Offsets for the degrees of freedom and faults of this machine.
    pub fn places(&self) -> Places {
        let n = self.equations.dof();
        let hidden = 2 * n;
        let inputs = hidden + self.faults.hidden_states;
        Places { n, hidden, inputs, sensors: inputs + self.faults.inputs.len() }
    }

    /// Initial state at `q`, `v`; lags settled at zero input.
    pub fn begin(&self, q: &[f64], v: &[f64]) -> Motion {
        let places = self.places();
        let mut x = [0.0; STATES_MAX];
        assert!(places.sensors + self.faults.sensors.len() <= STATES_MAX, "the machine has room for its states");
        x[..q.len()].copy_from_slice(q);
        x[places.n..places.n + v.len()].copy_from_slice(v);
        let contact = |rate: f64| if rate == 0.0 { Contact::Stuck } else { Contact::Sliding(rate.signum()) };
        let contacts = self.faults.dry.iter().map(|dry| contact(x[places.n + dry.coordinate])).collect();
        Motion { x, contacts, step_s: 0.0 }
    }

    /// Positions and rates of a state.
    pub fn coordinates(&self, x: &[f64]) -> (Vector, Vector) {
        let n = self.equations.dof();
        let take = |from: usize| Vector::from_fn(|i, _| if i < n { x[from + i] } else { 0.0 });
        (take(0), take(n))
    }

    /// Acting inputs at `t_s` into a stretch. The lag of a held input is an exponential, so that it
    /// is not a stiff state; `x` holds the lags at the beginning of the stretch.
    fn acting(&self, t_s: f64, x: &[f64], u: &[f64]) -> [f64; INPUTS_MAX] {
        let from = self.places().inputs;
        let mut acting = [0.0; INPUTS_MAX];
        for (k, (acting, u)) in acting.iter_mut().zip(u).enumerate() {
            *acting = match self.faults.inputs[k].lag_s {
                lag_s if lag_s > 0.0 => u + (x[from + k] - u) * libm::exp(-t_s / lag_s),
                _ => *u,
            };
        }
        acting
    }

    /// q'' and, per contact, the force that friction exerts (sliding) or must exert (stuck).
    pub fn acceleration(&self, t_s: f64, x: &[f64], u: &[f64], contacts: &[Contact]) -> (Vector, Vec<f64>) {
        let places = self.places();
        let (q, v) = self.coordinates(x);
        let mut force = self.equations.force(&q, &v, &self.acting(t_s, x, u)[..u.len()]);
        for (i, law) in &self.faults.forces {
            force[*i] += law.at(q[*i], v[*i], &x[places.hidden..places.inputs]);
        }
        let mass = self.equations.mass(&q);
        let (mut held, mut free) = (mass, force);
        for (dry, contact) in self.faults.dry.iter().zip(contacts) {
            let i = dry.coordinate;
            match contact {
                Contact::Sliding(sign) => {
                    free[i] -= sign * dry.magnitude(v[i]);
                    force[i] = free[i];
                }
                Contact::Stuck => {
                    held.fill_row(i, 0.0);
                    held.fill_column(i, 0.0);
                    (held[(i, i)], free[i]) = (1.0, 0.0);
                }
            }
        }
        let a = held.cholesky().map_or_else(|| Vector::repeat(f64::NAN), |factor| factor.solve(&free));
        let reaction = |(dry, contact): (&crate::hidden::Dry, &Contact)| match contact {
            Contact::Sliding(sign) => -sign * dry.magnitude(v[dry.coordinate]),
            Contact::Stuck => (mass.row(dry.coordinate) * a)[0] - force[dry.coordinate],
        };
        let reactions = self.faults.dry.iter().zip(contacts).map(reaction).collect();
        (a, reactions)
    }

    /// Readings of an instant, before faults of sensors.
    pub fn read(&self, motion: &Motion, u: &[f64]) -> Vec<f64> {
        // an input that begins now may move what the one before did not
        let mut now = motion.clone();
        self.settle(0.0, &mut now, u);
        self.read_at(0.0, &now.x, u, &now.contacts)
    }

    fn read_at(&self, t_s: f64, x: &[f64], u: &[f64], contacts: &[Contact]) -> Vec<f64> {
        let (q, v) = self.coordinates(x);
        let (a, _) = self.acceleration(t_s, x, u, contacts);
        let mut y = vec![0.0; self.faults.sensors.len()];
        self.equations.read(&q, &v, &a, &mut y);
        y
    }

    /// Moves over `dt_s` under held `u`. A motion that cannot be integrated ends in NaN.
    pub fn advance(&self, motion: &mut Motion, u: &[f64], dt_s: f64) {
        if motion.x.iter().any(|x| !x.is_finite()) {
            return; // it ran away in an earlier stretch
        }
        let mut done = 0.0;
        let own = self.places().sensors + self.faults.sensors.len();
        self.settle(0.0, motion, u);
        for _ in 0..CHANGES_MAX {
            if dt_s - done <= 1e-12 * dt_s {
                break;
            }
            let field = Field { rig: self, u, contacts: motion.contacts.clone() };
            let begin_s = motion.step_s.min(dt_s - done);
            // the error of a step is a mean over all numbers of the state: those beyond the
            // machine's own have none
            let share = (own as f64 / STATES_MAX as f64).sqrt();
            let method = ExplicitRungeKutta::dopri5().rtol(share * TOLERANCE.0).atol(share * TOLERANCE.1);
            let method = method.max_steps(100_000);
            let problem = IVP::ode(&field, done, dt_s, motion.x).method(method.h0(begin_s));
            let solved = if motion.contacts.is_empty() { problem.solve() } else { problem.event(&field).solve() };
            let (Ok(solution), true) = (solved, motion.x.iter().all(|x| x.is_finite())) else {
                return motion.x.fill(f64::NAN);
            };
            let (Some(t), Some(x)) = (solution.t.last(), solution.y.last()) else {
                return motion.x.fill(f64::NAN);
            };
            (done, motion.x) = (*t, *x);
            motion.step_s = solution.t.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
            if !matches!(solution.status, Status::Interrupted) {
                break;
            }
            self.stop(motion);
            self.settle(done, motion, u);
        }
        let acting = self.acting(dt_s, &motion.x, u);
        let from = self.places().inputs;
        motion.x[from..from + u.len()].copy_from_slice(&acting[..u.len()]);
    }

    /// Contacts whose rate is zero become stuck.
    fn stop(&self, motion: &mut Motion) {
        let n = self.equations.dof();
        for (dry, contact) in self.faults.dry.iter().zip(&mut motion.contacts) {
            let rate = &mut motion.x[n + dry.coordinate];
            if let Contact::Sliding(sign) = *contact
                && *rate * sign <= 0.0
            {
                (*rate, *contact) = (0.0, Contact::Stuck);
            }
        }
    }

    /// Contacts whose holding force exceeds the friction begin to slide in its direction.
    fn settle(&self, t_s: f64, motion: &mut Motion, u: &[f64]) {
        for _ in 0..self.faults.dry.len() {
            let (_, reactions) = self.acceleration(t_s, &motion.x, u, &motion.contacts);
            let list = self.faults.dry.iter().zip(&motion.contacts).zip(&reactions);
            let excess = |((dry, contact), reaction): ((&crate::hidden::Dry, &Contact), &f64)| match contact {
                Contact::Stuck => reaction.abs() - dry.magnitude(0.0) * (1.0 - 1e-12),
                Contact::Sliding(_) => f64::NEG_INFINITY,
            };
            let over: Vec<f64> = list.map(excess).collect();
            let Some(worst) = (0..over.len()).max_by(|a, b| over[*a].total_cmp(&over[*b])) else { return };
            if over[worst] <= 0.0 {
                return;
            }
            motion.contacts[worst] = Contact::Sliding(-reactions[worst].signum());
        }
    }
}

/// The equations under one input and one state of the contacts.
struct Field<'a> {
    rig: &'a Rig,
    u: &'a [f64],
    contacts: Vec<Contact>,
}

impl ODE<f64, State> for Field<'_> {
    fn diff(&self, t_s: f64, x: &State, x_dot: &mut State) {
        let (rig, places) = (self.rig, self.rig.places());
        let (a, _) = rig.acceleration(t_s, x, self.u, &self.contacts);
        x_dot.fill(0.0);
        x_dot[..places.n].copy_from_slice(&x[places.n..2 * places.n]);
        x_dot[places.n..2 * places.n].copy_from_slice(&a.as_slice()[..places.n]);
        for (i, law) in &rig.faults.forces {
            if let Some((state, rate)) = law.rate(x[places.n + i], &x[places.hidden..places.inputs]) {
                x_dot[places.hidden + state] = rate;
            }
        }
        if rig.faults.sensors.iter().any(|fault| fault.lag_s > 0.0) {
            let y = rig.read_at(t_s, x, self.u, &self.contacts);
            for (k, fault) in rig.faults.sensors.iter().enumerate().filter(|(_, fault)| fault.lag_s > 0.0) {
                x_dot[places.sensors + k] = (y[k] - x[places.sensors + k]) / fault.lag_s;
            }
        }
    }
}

impl Event<f64, State> for Field<'_> {
    fn config(&self) -> EventConfig {
        EventConfig::new(CrossingDirection::Negative, Some(1))
    }

    /// The least distance of any contact from a change; only its sign and its zero matter.
    fn event(&self, t_s: f64, x: &State) -> f64 {
        let n = self.rig.equations.dof();
        let (_, reactions) = self.rig.acceleration(t_s, x, self.u, &self.contacts);
        let list = self.rig.faults.dry.iter().zip(&self.contacts).zip(&reactions);
        let distance = |((dry, contact), reaction): ((&crate::hidden::Dry, &Contact), &f64)| match contact {
            Contact::Sliding(sign) => sign * x[n + dry.coordinate] + STOP_RATE,
            Contact::Stuck => dry.magnitude(0.0) - reaction.abs(),
        };
        list.map(distance).fold(f64::INFINITY, f64::min)
    }
}

#[cfg(test)]
mod tests;
