//! The specific force that slosh hangs against, along the recordings.

use dynamics::description::{Noise, Orientation, Plant, Quantity, Reading, Sensor, SensorKind, Tank};
use dynamics::system::{System, Workspace};
use identification::filter::{Linear, equip};
use identification::problem::Timeline;

/// Instants of a run at which the specific force is evaluated. A budget.
const EVALUATED_INSTANTS: usize = 500;

/// Mean specific force over all runs along the axis of `tank` that no slosh axis has, at the rest
/// place of its mass, along the filtered trajectories [m/s^2]; `None` for a tank without such an
/// axis.
///
/// Cost: `EVALUATED_INSTANTS` evaluations of the equations for each run.
pub(super) fn mean_axial(plant: &Plant, linears: &[Linear], timelines: &[Timeline], tank: &Tank) -> Option<f64> {
    let axis = tank.axial(plant.space).ok()?;
    let mut equipped = equip(plant);
    equipped.sensors.push(accelerometer(plant, tank, axis));
    let system = System::new(&equipped).ok()?;
    let (output, width) = (plant.sensors.len(), system.states().len());
    let (mut ws, mut y) = (Workspace::new(&system), vec![0.0; equipped.sensors.len()]);
    let (mut sum, mut count) = (0.0, 0usize);
    for (linear, timeline) in linears.iter().zip(timelines).filter(|(linear, _)| linear.state_names.len() == width) {
        let every = timeline.events.len().div_ceil(EVALUATED_INSTANTS).max(1);
        let along = timeline.events.iter().zip(linear.updated.chunks_exact(width)).step_by(every);
        for (event, x) in along {
            let u = &timeline.rows[event.row * timeline.inputs..][..timeline.inputs];
            system.read_some(&mut ws, event.t_s, x, u, &[output], &mut y);
            sum += y[output];
            count += 1;
        }
    }
    (count > 0).then(|| sum / count as f64)
}

/// Without errors, at the rest place of the slosh mass.
fn accelerometer(plant: &Plant, tank: &Tank, axis: [f64; 3]) -> Sensor {
    let taken = |name: &str| plant.sensors.iter().any(|sensor| sensor.name == name);
    let name = (0..).map(|i| format!("{}_{i}", tank.name)).find(|name| !taken(name)).unwrap_or_default();
    Sensor {
        name,
        kind: SensorKind::Accelerometer { body: tank.body.clone(), position_m: tank.position_m, axis, point: None },
        noise: Noise::default(),
        bias: Quantity::known(0.0),
        scale: Quantity::known(0.0),
        misalignment: Orientation::default(),
        range: None,
        resolution: Quantity::known(0.0),
        low_pass_hz: None,
        delay_s: Quantity::known(0.0),
        period_s: None,
        reading: Reading::Instant,
        source: None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic::{problem, recording};
    use identification::fit::{EstimationSession, LinearisedProblem};

    /// A thrust of 180 N along x on 480 kg, 60 N more and less in turn. The tank's axis is y,
    /// and z × y is −x.
    #[test]
    fn slosh_hangs_against_the_mean_of_what_the_recording_was_pushed_by() {
        let text = "format = 1\nname = \"hub\"\nspace = \"planar\"\n[[body]]\nname = \"hub\"\nmass = \"440 kg\"\n\
                    inertia = \"300 kg*m^2\"\njoint = { kind = \"free\" }\n\
                    [[tank]]\nname = \"fuel\"\nbody = \"hub\"\nkind = \"spring\"\naxis = \"y\"\nposition = [\"-0.6 m\", 0]\n\
                    mass = \"40 kg\"\nstiffness = \"12 N/m\"\ndamping = \"0.6 N*s/m\"\n\
                    [[actuator]]\nname = \"main\"\nkind = \"body_force\"\nbody = \"hub\"\ndirection = \"x\"\n\
                    command = { kind = \"square\", amplitude = \"60 N\", frequency = \"0.1 Hz\" }\n\
                    [[actuator]]\nname = \"trim\"\nkind = \"body_force\"\nbody = \"hub\"\ndirection = \"x\"\n\
                    command = { kind = \"constant\", value = \"180 N\" }\n\
                    [[sensor]]\nname = \"acc\"\nkind = \"accelerometer\"\nbody = \"hub\"\naxis = \"x\"\nnoise = \"2e-3 m/s^2\"\n\
                    [simulation]\nduration = \"20 s\"\nperiod = \"0.1 s\"\nstep = \"0.05 s\"";
        let nominal = plant_file::parse("hub.toml", text).unwrap().plant;
        let problem = problem(&nominal, recording(&nominal, 4, 20.0));
        let session = EstimationSession::new(&problem, 1).unwrap();
        let linearised = LinearisedProblem::new(&session, &nominal, &session.prior(), &session.noise).unwrap();
        let tank = &nominal.tanks[0];
        let mean = mean_axial(&nominal, &linearised.linears, &session.timelines, tank).expect("it has an axis");
        assert!((mean + 180.0 / 480.0).abs() < 5e-3, "{mean}");
    }
}
