//! A run beside the linear model of another plant: where it begins, and which of its numbers are
//! which.

use super::Propagator;
use crate::filter::{Linear, tangent_names};

impl Propagator<'_> {
    /// The run begins where the pass of `linear` began and, where the states are the same, is
    /// integrated in the same steps; `map` gives the place of its numbers in a change of state
    /// here.
    pub fn begin_as(&mut self, linear: &Linear, map: &[usize]) {
        if self.layout == linear.layout {
            // another division of a step is a jump that no derivative may see
            self.finer = linear.finer;
        }
        let mut change = vec![0.0; self.layout.tangent];
        linear.start.iter().zip(map).for_each(|(start, at)| change[*at] = *start);
        self.begin(&change);
    }

    /// Place of each entry of the frozen z of `linear` in this propagator's, by name; `None` where
    /// one is missing.
    pub fn map_names(&self, linear: &Linear) -> Option<Vec<usize>> {
        let ours = tangent_names(&self.system);
        let place = |name: &String| ours.iter().position(|(own, _)| own == name);
        let tangent: Vec<usize> = linear.names.iter().map(place).collect::<Option<_>>()?;
        let mut map = tangent.clone();
        for name in &linear.input_names {
            let found = self.layout.noise_inputs.iter().position(|i| self.system.inputs()[*i].name == *name)?;
            map.push(self.layout.noise_at() + found);
        }
        for (channel, lag) in linear.layout.lag_of.iter().enumerate() {
            if lag.is_some() {
                map.push(self.layout.lags_at() + self.layout.lag_of[channel]?);
            }
        }
        if linear.layout.clone > 0 {
            map.extend(tangent.iter().map(|at| self.layout.clone_at() + at));
        }
        Some(map)
    }
}
