//! Node and direction in the name of a channel, as universal files give them: `acceleration_12z`,
//! `accelerance_12z_3z`, `accelerance_12-z_3z`.

/// A direction of a node; the sign is that of the sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Freedom {
    pub node: i64,
    pub axis: usize,
    pub negative: bool,
}

const AXES: [&str; 3] = ["x", "y", "z"];

impl Freedom {
    /// Without the sign: `12z`.
    pub(super) fn name(self) -> String {
        format!("{}{}", self.node, AXES[self.axis])
    }

    /// Unit vector of the sensor.
    pub(super) fn direction(self) -> [f64; 3] {
        let mut direction = [0.0; 3];
        direction[self.axis] = if self.negative { -1.0 } else { 1.0 };
        direction
    }
}

/// Of the response: the first part of the name that is a node with a direction.
pub(super) fn of_response(channel: &str) -> Option<Freedom> {
    parts(channel).next()
}

/// Of the reference: the second part.
pub(super) fn of_reference(channel: &str) -> Option<Freedom> {
    parts(channel).nth(1)
}

fn parts(channel: &str) -> impl Iterator<Item = Freedom> {
    // Before a colon is the name of the file.
    channel.rsplit(':').next().unwrap_or(channel).split('_').filter_map(parse)
}

fn parse(word: &str) -> Option<Freedom> {
    let digits = word.len() - word.trim_start_matches(|c: char| c.is_ascii_digit()).len();
    let (node, direction) = word.split_at(digits);
    let (negative, axis) = direction.strip_prefix('-').map_or((false, direction), |axis| (true, axis));
    let axis = AXES.iter().position(|known| *known == axis)?;
    Some(Freedom { node: node.parse().ok()?, axis, negative })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn node_and_direction_are_read_from_names_of_universal_files_and_from_nothing_else() {
        let z = Freedom { node: 12, axis: 2, negative: false };
        assert_eq!(of_response("beam:accelerance_12z_3-x"), Some(z));
        assert_eq!(of_reference("accelerance_12z_3-x"), Some(Freedom { node: 3, axis: 0, negative: true }));
        for other in ["acceleration_z", "acc_12", "12rz", "z12", ""] {
            assert_eq!(of_response(other), None, "{other}");
        }
    }
}
