//! A plant of `deploy/plants` as equations, with its states and inputs by name.

pub use bench::inertial::planar_arm as arm_of;
use dynamics::description::{Plant, SiteKind};
use dynamics::noise::Stream;
use dynamics::system::{System, Totals, Workspace};
use std::path::{Path, PathBuf};

/// States compared per claim.
pub const STATES: u64 = 1000;
/// Of the sum of absolute terms: two formulations add up to some fifty terms each, a mass matrix of
/// condition 10² between them.
pub const ROUNDING: f64 = 1e-11;

pub fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("deploy/plants")
}

/// A plant with some numbers replaced.
pub fn plant(name: &str, changes: &[(&str, f64)]) -> Plant {
    let path = folder().join(format!("{name}.toml"));
    let text = std::fs::read_to_string(&path).unwrap();
    let mut plant = plant_file::parse(name, &text).unwrap().plant;
    for (parameter, value) in changes {
        plant.set_parameter(parameter, *value).unwrap();
    }
    plant
}

/// A number of the plant by its name.
pub fn value(plant: &Plant, name: &str) -> f64 {
    plant.parameters().into_iter().find(|parameter| parameter.name == name).unwrap().value
}

/// Unequal components of r0, a base whose centre of mass is not its origin: a swap of two of them
/// shows.
pub const SKEWED: [(&str, f64); 4] =
    [("shoulder.position.x", 0.99), ("shoulder.position.y", 0.40), ("hub.com.x", -0.07), ("hub.com.y", 0.12)];

pub struct Subject {
    pub plant: Plant,
    pub system: System,
    workspace: Workspace<f64>,
    pub x: Vec<f64>,
    pub u: Vec<f64>,
    x_dot: Vec<f64>,
}

impl Subject {
    pub fn new(plant: Plant) -> Self {
        let system = System::new(&plant).unwrap();
        let (n, m) = (system.states().len(), system.inputs().len());
        let workspace = Workspace::new(&system);
        Self { plant, workspace, x: vec![0.0; n], u: vec![0.0; m], x_dot: vec![0.0; n], system }
    }

    /// State number `k`: angles of some turns, everything else of order one; no inputs.
    pub fn draw(&mut self, k: u64) {
        let stream = Stream::new(k, "state");
        for (i, x) in self.x.iter_mut().enumerate() {
            let rate = self.system.states()[i].name.ends_with(".rate");
            *x = stream.normal(i as u64) * if rate { 1.0 } else { 2.0 };
        }
        self.u.fill(0.0);
    }

    /// Inputs of order `size`, of the same draw.
    pub fn push(&mut self, k: u64, size: f64) {
        let stream = Stream::new(k, "input");
        self.u.iter_mut().enumerate().for_each(|(i, u)| *u = size * stream.normal(i as u64));
    }

    fn state(&self, name: &str) -> usize {
        self.system.states().iter().position(|state| state.name == name).unwrap_or_else(|| panic!("no state {name}"))
    }

    pub fn at(&self, name: &str) -> f64 {
        self.x[self.state(name)]
    }

    pub fn set(&mut self, name: &str, value: f64) {
        let index = self.state(name);
        self.x[index] = value;
    }

    pub fn input(&self, name: &str) -> f64 {
        self.u[self.system.inputs().iter().position(|input| input.name == name).unwrap()]
    }

    /// Derivatives of the named states.
    pub fn rates<const N: usize>(&mut self, names: [&str; N]) -> [f64; N] {
        self.system.derivative(&mut self.workspace, 0.0, &self.x, &self.u, &mut self.x_dot);
        names.map(|name| self.x_dot[self.state(name)])
    }

    pub fn totals(&mut self) -> Totals<f64> {
        self.system.totals(&mut self.workspace, &self.x, &self.u)
    }

    /// (angles, rates (w0, d1, d2)) of the arm.
    pub fn arm_state(&self) -> ([f64; 2], [f64; 3]) {
        (
            ["joint:shoulder", "joint:elbow"].map(|name| self.at(name)),
            ["body:hub.rz.rate", "joint:shoulder.rate", "joint:elbow.rate"].map(|name| self.at(name)),
        )
    }

    /// (position, velocity) of the model: the halves of the state where nothing is prescribed and
    /// no mode bends.
    pub fn model_state(&self) -> (Vec<f64>, Vec<f64>) {
        assert!(self.plant.sites(SiteKind::Mode).is_empty());
        let (q, v) = self.x.split_at(self.system.model().q_len());
        (q.to_vec(), v.to_vec())
    }
}

/// Largest `|error| / size` so far.
#[derive(Default)]
pub struct Worst(pub f64);

impl Worst {
    pub fn see(&mut self, error: f64, size: f64) {
        assert!(size > 0.0 && error.is_finite(), "{error} of {size}");
        self.0 = self.0.max(error.abs() / size);
    }

    pub fn demand(&self, what: &str, tolerance: f64) {
        println!("{what}: {:.1e}", self.0);
        assert!(self.0 <= tolerance, "{what}: {:.3e} > {tolerance:.0e}", self.0);
    }
}
