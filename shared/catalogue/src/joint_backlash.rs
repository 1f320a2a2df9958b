//! Play between motor and link.

use super::parts;
use dynamics::description::{EffectUse, Plant, Quantity, Site, SiteKind};
use dynamics::effect::{Effect, EffectParameter, Family, Law, Prior, Scan, Spread};

/// Rate of a contact that is looked for [1 / time between samples]: it lasts π/2 samples, and a
/// stiffer one, of less than a sample, is the same on the record.
const CONTACT: f64 = 2.0;

/// Backlash between motor and link: a contact `−k (x − b sgn x) − c x'` beyond a half gap b.
pub static EFFECT: Effect = Effect {
    kind: "joint_backlash",
    title: "Backlash between motor and link",
    sites: &[SiteKind::Joint],
    parameters: &[
        EffectParameter::new("half_gap", "*", [0.0, 1.0], 0.01, "half b of the play").amplitude(),
        EffectParameter::new(
            "contact_rate",
            "rad/s",
            [1e-3, 1e6],
            100.0,
            "natural frequency w of motor against link in contact: stiffness k = J w^2, J the reduced inertia",
        )
        .scanned(Scan::OfSampling(&[CONTACT])),
        EffectParameter::new(
            "contact_damping",
            "1",
            [0.0, 2.0],
            0.2,
            "damping ratio z while in contact: damper c = 2 z J w",
        ),
        EffectParameter::new(
            "inertia_share",
            "1",
            [1e-3, 0.9],
            0.1,
            "share of the link that moves with the motor, where the joint states no rotor inertia",
        )
        .with_prior(Prior::Free(Spread::Relative(1.0))),
    ],
    law: Law::Structure(build),
    family: Family::Clearance,
    what: "The joint is split as by joint_flexibility; between motor and link nothing acts while |x| <= b, else -k (x - b sgn x) - c x', held \
           so that contact only pushes: dead-zone model of play (Nordin and Gutman 2002). The stiffness grows as the gap shrinks, so that \
           none is the rigid joint.",
    signature: "After each reversal the motor moves alone for 2b, then the link with a jerk; a limit cycle in a loop on the link.",
    confounders: "joint_flexibility on small motion; joint_looseness; joint_coulomb in the encoder of a motor that hardly moves.",
    experiment: "Press the joint to one side by a constant torque: play disappears, a spring stays. A gyro on the link.",
    ..Effect::PLAIN
};

fn build(plant: &mut Plant, site: &Site, p: &[f64]) -> Result<(), String> {
    let (half_gap, rate, damping, share) = (p[0], p[1], p[2], p[3]);
    if half_gap == 0.0 {
        return Ok(());
    }
    let split = parts::split_joint(plant, site, share)?;
    let reduced = split.motor_inertia * split.link_inertia / (split.motor_inertia + split.link_inertia);
    let stiffness = reduced * rate * rate;
    let contact_time = 2.0 * damping / rate;
    let values = [("stiffness", stiffness), ("half_gap", half_gap), ("centre", 0.0), ("contact_time", contact_time)];
    plant.effects.push(EffectUse {
        kind: super::joint_looseness::EFFECT.kind.to_owned(),
        site: Site { kind: SiteKind::Joint, name: split.gear },
        values: values.map(|(name, value)| (name.to_owned(), Quantity::known(value))).to_vec(),
    });
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::build;
    use crate::trial::plant;
    use dynamics::system::{System, Workspace};

    #[test]
    fn in_the_gap_the_motor_moves_alone_wherever_the_joint_is_and_beyond_it_takes_the_link_along() {
        let mut built = plant();
        build(&mut built, &"joint:elbow".parse().unwrap(), &[0.01, 30.0, 0.0, 0.1]).unwrap();
        let system = System::new(&built).unwrap();
        let at = |name: &str| system.states().iter().position(|state| state.name == name).unwrap();
        let drive = system.inputs().iter().position(|input| input.name == "drive").unwrap();
        let rates = |angle: f64, play: f64, torque: f64| {
            let (mut x, mut u) = (vec![0.0; system.states().len()], vec![0.0; system.inputs().len()]);
            (x[at("joint:elbow")], x[at("joint:elbow_gear")], u[drive]) = (angle, play, torque);
            let mut x_dot = x.clone();
            system.derivative(&mut Workspace::new(&system), 0.0, &x, &u, &mut x_dot);
            let [motor, gear] = [x_dot[at("joint:elbow.rate")], x_dot[at("joint:elbow_gear.rate")]];
            (motor, motor + gear)
        };
        for angle in [0.0, 1.0, -2.0] {
            for play in [-0.009, 0.0, 0.009] {
                let (motor, link) = rates(angle, play, 2.0);
                // nothing but the hub's reaction moves the link: it turns the other way, little
                assert!(motor > 0.0 && link.abs() < 0.05 * motor, "{motor} {link}");
            }
            // the link lags behind the motor by more than the play
            let (_, link) = rates(angle, -0.02, 0.0);
            assert!(link > 0.1, "{link}");
        }
    }
}
