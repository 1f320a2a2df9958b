//! `obsid design slosh`: bursts of thrust with the least bound of the slosh parameters, within
//! thrust, stroke, impulse and time.

use crate::{Failure, print};
use bench::design::slosh::{Task, ThrustLimits, plant_text, scenario_text, table};
use std::path::{Path, PathBuf};

/// Thrust that tells more of the slosh parameters, within limits
#[derive(clap::Args)]
pub struct Arguments {
    /// Greatest thrust [N]
    #[arg(long, default_value_t = 44.0)]
    thrust_max_n: f64,
    /// Greatest displacement of the slosh mass [m]
    #[arg(long, default_value_t = 0.5)]
    stroke_max_m: f64,
    /// Greatest integral of |thrust| [N s]
    #[arg(long, default_value_t = f64::INFINITY)]
    impulse_max_n_s: f64,
    /// Length of the record [s]
    #[arg(long, default_value_t = 7200.0)]
    duration_s: f64,
    /// Velocity random walk of the accelerometer [(m/s)/sqrt(h)]
    #[arg(long, default_value_t = 0.008)]
    vrw_m_s_sqrt_h: f64,
    /// Where the plant file with the new thrust goes
    #[arg(long)]
    out: Option<PathBuf>,
    /// Where a scenario that flies that plant goes
    #[arg(long, requires = "out")]
    scenario: Option<PathBuf>,
}

/// # Errors
/// [`Failure::Run`] for limits that allow nothing and a result that cannot be written.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    for (name, value) in [
        ("thrust-max-n", arguments.thrust_max_n),
        ("stroke-max-m", arguments.stroke_max_m),
        ("impulse-max-n-s", arguments.impulse_max_n_s),
        ("duration-s", arguments.duration_s),
        ("vrw-m-s-sqrt-h", arguments.vrw_m_s_sqrt_h),
    ] {
        if value.is_nan() || value <= 0.0 {
            return Err(Failure::Run(format!("--{name} must be positive")));
        }
    }
    let limits = ThrustLimits {
        thrust_max_n: arguments.thrust_max_n,
        stroke_max_m: arguments.stroke_max_m,
        impulse_max_n_s: arguments.impulse_max_n_s,
        duration_s: arguments.duration_s,
        vrw_m_s_sqrt_h: arguments.vrw_m_s_sqrt_h,
    };
    let task = Task::new(limits);
    let best = task.best().ok_or_else(|| {
        Failure::Run("no burst fits the record: allow a longer one than a period of the slosh".into())
    })?;
    print(&table(&task, &best));
    let Some(out) = &arguments.out else { return Ok(()) };
    let plant = plant_text(&best, &limits);
    let plant = plant.map_err(|errors| Failure::Run(format!("the designed plant cannot be read back: {errors:?}")))?;
    write(out, &plant)?;
    let Some(scenario) = &arguments.scenario else { return Ok(()) };
    write(scenario, &scenario_text(&task, &plant_from(scenario, out)?))
}

/// The plant file as a scenario names it: from its own folder, or whole.
fn plant_from(scenario: &Path, plant: &Path) -> Result<String, Failure> {
    let beside = scenario.parent() == plant.parent();
    let path = match plant.file_name().filter(|_| beside) {
        Some(name) => name.into(),
        None => std::path::absolute(plant).map_err(|error| Failure::Run(format!("{}: {error}", plant.display())))?,
    };
    Ok(toml::Value::String(path.display().to_string()).to_string())
}

fn write(path: &Path, text: &str) -> Result<(), Failure> {
    std::fs::write(path, text).map_err(|error| Failure::Run(format!("{}: {error}", path.display())))
}
