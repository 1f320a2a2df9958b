//! The plants that come with the program, as text: those of the benchmark problems, and rigs.

/// A plant of `deploy/plants` by its name.
macro_rules! built_in {
    ($($name:literal),* $(,)?) => {
        &[$(($name, include_str!(concat!("../../../deploy/plants/", $name, ".toml")))),*]
    };
}

/// Plants that need no file: name and text.
pub const BUILT_IN: &[(&str, &str)] = built_in![
    "damper_rig",
    "double_pendulum",
    "drive_rig",
    "free_floating_arm",
    "free_flying_arm",
    "hub_appendage",
    "hub_appendage_closed_loop",
    "mated",
    "oscillator",
    "pendulum",
    "rigid_body_imu",
    "study_case",
    "study_case_spatial",
    "tank_1d",
    "tank_pendulum",
    "tank_planar",
];

/// Text of the plant that comes with the program under `name`.
pub fn built_in(name: &str) -> Option<&'static str> {
    BUILT_IN.iter().find(|(known, _)| *known == name).map(|(_, text)| *text)
}

#[cfg(test)]
mod tests {
    use super::BUILT_IN;

    #[test]
    fn every_plant_of_the_deployment_needs_no_path() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../deploy/plants");
        let files = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
        let mut files: Vec<String> = files.filter_map(|name| name.strip_suffix(".toml").map(str::to_owned)).collect();
        files.sort();
        assert_eq!(BUILT_IN.iter().map(|(name, _)| *name).collect::<Vec<_>>(), files);
    }
}
