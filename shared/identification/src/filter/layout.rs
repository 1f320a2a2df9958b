//! Places and names of the parts of z.

/// Places of the parts of z.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Layout {
    /// Numbers of a small change of state.
    pub tangent: usize,
    /// Noise inputs: index in `u` of each.
    pub noise_inputs: Vec<usize>,
    /// Per channel: place among lags, if it lags.
    pub lag_of: Vec<Option<usize>>,
    pub lags: usize,
    /// Numbers of the clone: `tangent` or none.
    pub clone: usize,
    /// Per channel: place among coloured noises.
    pub colour_of: Vec<Option<usize>>,
    pub colours: usize,
}

impl Layout {
    /// Place of the first noise input in z.
    pub fn noise_at(&self) -> usize {
        self.tangent
    }

    /// Place of the first lag in z.
    pub fn lags_at(&self) -> usize {
        self.tangent + self.noise_inputs.len()
    }

    /// Place of the clone of the state in z.
    pub fn clone_at(&self) -> usize {
        self.lags_at() + self.lags
    }

    /// Place of the first coloured noise in z.
    pub fn colours_at(&self) -> usize {
        self.clone_at() + self.clone
    }

    /// Length of z: tangent, noise inputs, lags, clone and coloured noises.
    pub fn len(&self) -> usize {
        self.colours_at() + self.colours
    }

    /// Whether z has no component.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Places in z of the numbers of a row of measurement.
    pub(super) fn places<'r>(&self, row: &'r [f64]) -> impl Iterator<Item = (usize, f64)> + use<'r> {
        let (before, clone_at) = (self.lags_at(), self.clone_at());
        row.iter().enumerate().map(move |(i, h)| (if i < before { i } else { clone_at + i - before }, *h))
    }
}

/// Name and unit of each number of a small change of state: those of the state; a quaternion's
/// three are turns.
pub fn tangent_names(system: &dynamics::system::System) -> Vec<(String, &'static str)> {
    let mut names = Vec::new();
    for state in system.states() {
        if state.name.ends_with(".qw") {
            continue;
        }
        match state.name.strip_suffix(".qx").or(state.name.strip_suffix(".qy")).or(state.name.strip_suffix(".qz")) {
            Some(body) => {
                let axis = state.name.chars().last().unwrap_or('x');
                names.push((format!("{body}.r{axis}"), "rad"));
            }
            None => names.push((state.name.clone(), state.unit)),
        }
    }
    names
}
