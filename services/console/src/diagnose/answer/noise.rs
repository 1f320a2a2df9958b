//! Noise that is not as stated, in words: which channel, how many times the stated noise.

use super::in_titles;

/// How a noise differs from that of the plant file.
#[derive(Debug, PartialEq)]
pub enum Noise<'a> {
    /// A disturbance that the file does not state acts there.
    Disturbance(&'a str),
    /// Correlated from sample to sample, by this pole.
    Coloured(&'a str, &'a str),
    /// So many times the stated standard deviation.
    Scaled(&'a str, &'a str),
}

impl<'a> Noise<'a> {
    /// The difference that weighs most in a reason with entries such as `torque x0.04`; `None`
    /// where it has none.
    pub fn of(reason: &'a str) -> Option<Self> {
        let entries: Vec<&str> = reason.split("; ").flat_map(|clause| clause.split(", ")).collect();
        let bare = |entry: &'a str| entry.rsplit_once(": ").map_or(entry, |(_, entry)| entry);
        let disturbed = entries.iter().find_map(|entry| bare(entry).strip_prefix("disturbance of ")?.rsplit_once(' '));
        if let Some((name, _)) = disturbed {
            return Some(Noise::Disturbance(name));
        }
        let factor = |entry: &'a str| -> Option<(&'a str, &'a str)> {
            let (name, factor) = bare(entry).rsplit_once(" x")?;
            factor.parse::<f64>().ok().map(|_| (name, factor))
        };
        let coloured = entries.windows(2).find_map(|pair| Some((factor(pair[0])?.0, pair[1].strip_prefix("pole ")?)));
        if let Some((name, pole)) = coloured {
            return Some(Noise::Coloured(name, pole));
        }
        let distance = |factor: &str| factor.parse::<f64>().map_or(0.0, |factor| factor.ln().abs());
        let all = entries.iter().filter_map(|entry| factor(entry));
        let most = all.max_by(|a, b| distance(a.1).total_cmp(&distance(b.1)))?;
        Some(Noise::Scaled(most.0, most.1))
    }

    /// What it is, beside the file that states another.
    pub fn in_words(&self, plant_file: &str) -> String {
        match self {
            Noise::Disturbance(name) => {
                format!("a random disturbance of {} acts, which {plant_file} does not state", in_titles(name))
            }
            Noise::Coloured(name, pole) => {
                format!("the noise of {name} is coloured (pole {pole}), {plant_file} states white noise")
            }
            Noise::Scaled(name, factor) => {
                format!("the noise of {name} is {} times the noise that {plant_file} states", about(factor))
            }
        }
    }

    /// What to write into the file.
    pub fn cure(&self, plant_file: &str) -> String {
        let change = match self {
            Noise::Disturbance(name) => {
                format!("state a noise of the actuator at {} in {plant_file}, and diagnose again", in_titles(name))
            }
            Noise::Coloured(name, _) => {
                format!("look for a filter, a vibration or electrical pick-up in the measurement of {name}")
            }
            Noise::Scaled(name, factor) if factor.parse::<f64>().is_ok_and(|factor| factor > 1.0) => {
                return format!(
                    "look for what else moves {name} (a vibration, electrical pick-up, another channel or unit than its name says), else multiply its noise in {plant_file} by {factor}, and diagnose again"
                );
            }
            Noise::Scaled(name, factor) => {
                format!("multiply the noise of {name} in {plant_file} by {}, and diagnose again", about(factor))
            }
        };
        format!("{change}; the physics of {plant_file} needs no change")
    }
}

/// A factor that is printed as zero is below what is printed.
fn about(factor: &str) -> String {
    if factor.parse() == Ok(0.0) { "less than 0.005".into() } else { factor.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_channel_farthest_from_its_stated_noise_is_named_with_its_factor() {
        let reason =
            "the noise is not as stated; no physics is missing beside it: angle x0.99, rate x1.30, torque x0.04";
        assert_eq!(Noise::of(reason), Some(Noise::Scaled("torque", "0.04")));
        let said = Noise::of(reason).unwrap().in_words("wheel.toml");
        assert_eq!(said, "the noise of torque is 0.04 times the noise that wheel.toml states");
    }

    #[test]
    fn colour_and_disturbances_come_before_factors() {
        let coloured = "the noise is not as stated: angle x1.00, pole 0.90, rate x3.00; probability 0.90";
        assert_eq!(Noise::of(coloured), Some(Noise::Coloured("angle", "0.90")));
        let disturbed = "the noise is not as stated: rate x3.00, disturbance of joint:a 1.200e-3, which is not stated";
        assert_eq!(Noise::of(disturbed), Some(Noise::Disturbance("joint:a")));
        assert_eq!(Noise::of("nothing to see"), None);
    }

    #[test]
    fn a_factor_that_is_printed_as_zero_is_no_factor_to_multiply_by() {
        let said = Noise::Scaled("rate", "0.00").cure("a.toml");
        assert!(said.starts_with("multiply the noise of rate in a.toml by less than 0.005"), "{said}");
        // more noise than stated may be no noise
        let said = Noise::Scaled("rate", "573.84").cure("a.toml");
        assert!(said.starts_with("look for what else moves rate") && !said.contains("no change"), "{said}");
    }
}
