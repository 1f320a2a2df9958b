//! `obsid plant describe`: a plant on one page.

mod inertial;
mod page;
mod poles;

use super::{impossible, words};
use crate::{Failure, plants, simulate};
use catalogue::EFFECTS;
use dynamics::description::{Noise, Plant, Quantity, SiteKind, Space};
use dynamics::effect::sites;
use dynamics::system::StateName;
use inertial::{Inertial, MomentumView};
use poles::Poles;
use serde_json::{Value, json};
use simulation::{SimulationError, Simulator};
use std::path::PathBuf;

/// Describe a plant on one page: bodies, totals, drives, sensors, poles, base parameters
#[derive(clap::Args)]
#[command(after_help = "Examples:
  obsid plant describe deploy/plants/study_case.toml
  obsid plant describe pendulum --set 'bar.mass = 2 kg'
  obsid plant describe free_floating_arm --json | jq .base_parameters")]
pub struct Arguments {
    /// A plant file, or the name of a built-in plant
    plant: PathBuf,
    /// Another value of a number, 'NAME = VALUE UNIT'; may be repeated
    #[arg(long, value_name = "NUMBER")]
    set: Vec<String>,
    /// One JSON object on standard output
    #[arg(long)]
    json: bool,
}

/// # Errors
/// [`Failure::Input`] for a plant that cannot be simulated.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let mut plant = plants::read(&arguments.plant)?;
    simulate::change(&mut plant, &arguments.set, &[])?;
    let facts = Facts::of(&plant).map_err(|error| impossible(&arguments.plant, &error))?;
    crate::print(&if arguments.json { format!("{}\n", as_json(&plant, &facts)) } else { page::text(&plant, &facts) });
    Ok(())
}

/// What has to be computed.
struct Facts {
    states: Vec<StateName>,
    inertial: Inertial,
    poles: Poles,
    /// Per site: how many effects can sit there.
    effects: Vec<(String, usize)>,
}

impl Facts {
    fn of(plant: &Plant) -> Result<Self, SimulationError> {
        let mut simulator = Simulator::new(plant, 1, &plant.name)?;
        Ok(Facts {
            states: simulator.system().states().to_vec(),
            inertial: Inertial::of(plant)?,
            poles: Poles::of(plant, &mut simulator)?,
            effects: effects_by_site(plant),
        })
    }
}

fn effects_by_site(plant: &Plant) -> Vec<(String, usize)> {
    let all = SiteKind::ALL.into_iter().flat_map(|kind| plant.sites(kind));
    let carried: Vec<_> = EFFECTS.iter().flat_map(|effect| sites(effect, plant)).collect();
    all.map(|site| (site.to_string(), carried.iter().filter(|other| **other == site).count())).collect()
}

fn as_json(plant: &Plant, facts: &Facts) -> Value {
    let three = |q: &[Quantity; 3]| q.map(|quantity| quantity.value);
    let bodies = plant.bodies.iter().map(|body| {
        json!({
            "name": body.name, "parent": body.parent, "mass_kg": body.mass_kg.value, "com_m": three(&body.com_m),
            "inertia_com_kg_m2": body.inertia_com_kg_m2.map(|q| q.value),
            "joint": { "name": body.joint.name, "kind": words::joint(&body.joint), "position_m": three(&body.joint.position_m) },
        })
    });
    let sensors = plant.sensors.iter().map(|sensor| {
        let unit = plant.sensor_unit(sensor);
        let density = matches!(sensor.noise, Noise::Density(_));
        let (Noise::PerSample(noise) | Noise::Density(noise)) = sensor.noise;
        json!({
            "name": sensor.name, "unit": unit, "noise": noise.value, "noise_is_density": density,
            "period_s": sensor.period_s.map_or(plant.simulation.period_s, |period| period.value),
        })
    });
    let tanks =
        plant.tanks.iter().map(|tank| json!({ "name": tank.name, "body": tank.body, "mass_kg": tank.mass_kg.value }));
    let appendages = plant.appendages.iter().map(|appendage| {
        let mode = |mode: &dynamics::description::Mode| json!({ "name": mode.name, "frequency_hub_locked_hz": mode.frequency_hz.value, "damping_ratio": mode.damping_ratio.value });
        json!({ "name": appendage.name, "body": appendage.body, "modes": appendage.modes.iter().map(mode).collect::<Vec<_>>() })
    });
    let actuators =
        plant.actuators.iter().map(|actuator| json!({ "name": actuator.name, "unit": plant.actuator_unit(actuator) }));
    json!({
        "name": plant.name, "about": plant.about,
        "space": if plant.space == Space::Planar { "planar" } else { "spatial" },
        "gravity_m_s2": plant.environment.gravity_m_s2.map(|g| g.value),
        "bodies": bodies.collect::<Vec<_>>(), "tanks": tanks.collect::<Vec<_>>(),
        "appendages": appendages.collect::<Vec<_>>(), "actuators": actuators.collect::<Vec<_>>(),
        "controllers": plant.controllers.iter().map(|c| json!({ "name": c.name, "actuator": c.actuator })).collect::<Vec<_>>(),
        "sensors": sensors.collect::<Vec<_>>(),
        "states": facts.states.iter().map(|s| json!({ "name": s.name, "unit": s.unit })).collect::<Vec<_>>(),
        "totals": facts.inertial.totals_json(), "poles": facts.poles.as_json(),
        "base_parameters": facts.inertial.base_json(),
        "momentum_span": facts.inertial.momentum.as_ref().map(MomentumView::as_json),
        "effects": facts.effects.iter().map(|(site, count)| json!({ "site": site, "kinds": count })).collect::<Vec<_>>(),
    })
}
