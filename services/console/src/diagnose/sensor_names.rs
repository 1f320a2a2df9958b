//! Which channel of a shape is which sensor of the plant.
//!
//! The name itself; where files of responses were read together (`FILE:NAME`), one of its two
//! halves; and of a function between nodes as universal files have it (`accelerance_12z_3z`:
//! response at 12z by force at 3z) the only sensor whose name ends in the response
//! (`acceleration_12z`). A shape belongs to one reference: responses by force elsewhere are left
//! out of it.

use discovery::features::{MeasuredMode, ShapeComponent};
use dynamics::description::Plant;

/// Modes with the components that the plant has sensors for, under the names of these, and the
/// channels it has none for.
pub fn named_as_sensors(modes: &[MeasuredMode], plant: &Plant) -> (Vec<MeasuredMode>, Vec<String>) {
    let outputs = outputs(plant);
    let mut unknown: Vec<String> = Vec::new();
    let mut renamed = modes.to_vec();
    for mode in &mut renamed {
        let first = mode.shape.iter().find_map(|at| reference(&at.channel)).map(str::to_owned);
        let mut shape: Vec<ShapeComponent> = Vec::new();
        for at in &mode.shape {
            let here = reference(&at.channel).is_none() || reference(&at.channel) == first.as_deref();
            match sensor(&at.channel, &outputs) {
                Some(name) if here && shape.iter().all(|other| other.channel != name) => {
                    shape.push(ShapeComponent { channel: name, ..at.clone() });
                }
                None if !unknown.contains(&at.channel) => unknown.push(at.channel.clone()),
                _ => {}
            }
        }
        mode.shape = shape;
    }
    (renamed, unknown)
}

/// Channels of the plant, one per axis of a sensor.
fn outputs(plant: &Plant) -> Vec<String> {
    let system = dynamics::system::System::new(plant);
    system.map_or(Vec::new(), |system| system.outputs().iter().map(|output| output.name.clone()).collect())
}

fn sensor(channel: &str, outputs: &[String]) -> Option<String> {
    let (file, name) = channel.split_once(':').unwrap_or((channel, channel));
    let known = |wanted: &str| outputs.iter().find(|output| *output == wanted).cloned();
    known(channel).or_else(|| known(name)).or_else(|| known(file)).or_else(|| {
        let end = format!("_{}", nodes(name)?.0);
        let mut ending = outputs.iter().filter(|output| output.ends_with(&end));
        ending.next().filter(|_| ending.next().is_none()).cloned()
    })
}

/// Response and reference of a function between nodes.
fn nodes(name: &str) -> Option<(&str, &str)> {
    let node = |text: &&str| text.starts_with(|c: char| c.is_ascii_digit());
    let (rest, reference) = name.rsplit_once('_').filter(|(_, last)| node(last))?;
    let (_, response) = rest.rsplit_once('_').filter(|(_, last)| node(last))?;
    Some((response, reference))
}

fn reference(channel: &str) -> Option<&str> {
    nodes(channel.split_once(':').map_or(channel, |(_, name)| name)).map(|(_, reference)| reference)
}

#[cfg(test)]
mod tests {
    use super::sensor;

    #[test]
    fn a_channel_is_the_sensor_of_its_name_of_its_file_or_of_its_response_and_no_other() {
        let outputs: Vec<String> = ["tip", "acceleration_12z", "acceleration_2z"].map(String::from).into();
        let found = |channel: &str| sensor(channel, &outputs);
        assert_eq!(found("tip").as_deref(), Some("tip"));
        assert_eq!(found("blow_3:tip").as_deref(), Some("tip"));
        assert_eq!(found("tip:accelerance").as_deref(), Some("tip"));
        assert_eq!(found("beam:accelerance_2z_12z").as_deref(), Some("acceleration_2z"));
        assert_eq!(found("beam:accelerance_3z_2z"), None);
        assert_eq!(found("accelerance"), None);
    }
}
