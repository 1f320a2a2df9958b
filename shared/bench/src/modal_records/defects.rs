//! What happens to records between sensor and file.

use super::generator::Generator;
use super::structure::Structure;
use core::f64::consts::TAU;

/// A kind of defect.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Defect {
    Clean,
    /// 1–25 % of the rows, at random.
    MissingRows,
    /// 1–25 % of the rows in packets of 2–40.
    MissingPackets,
    /// 1–25 % of the values of every channel by itself.
    MissingCells,
    /// Every value stands 2–7 times.
    Held,
    /// One channel updated every 2nd–7th row.
    SlowChannel,
    /// Stamps to the millisecond.
    RoundedStamps,
    /// Stamps in batches: rows share the time of delivery.
    BunchedStamps,
    /// One channel late by up to a period of the fastest mode.
    LateChannel,
    /// The largest 2 % of every channel.
    Clipped,
    /// A line far from every mode.
    Tone,
    /// Two lines close to one another.
    TwoTones,
    /// A line whose frequency wanders by ±0.5–1.5 %.
    WanderingTone,
    /// A line 1–3 half-power widths beside a mode, of its height.
    ToneBeside,
    /// A line within the half-power width of a mode, of its height.
    ToneOn,
}

impl Defect {
    /// Every kind.
    pub const ALL: [Self; 15] = [
        Self::Clean,
        Self::MissingRows,
        Self::MissingPackets,
        Self::MissingCells,
        Self::Held,
        Self::SlowChannel,
        Self::RoundedStamps,
        Self::BunchedStamps,
        Self::LateChannel,
        Self::Clipped,
        Self::Tone,
        Self::TwoTones,
        Self::WanderingTone,
        Self::ToneBeside,
        Self::ToneOn,
    ];

    /// As the table of figures has it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Clean => "clean",
            Self::MissingRows => "missing rows",
            Self::MissingPackets => "missing packets",
            Self::MissingCells => "missing cells",
            Self::Held => "held",
            Self::SlowChannel => "slow channel",
            Self::RoundedStamps => "rounded stamps",
            Self::BunchedStamps => "bunched stamps",
            Self::LateChannel => "late channel",
            Self::Clipped => "clipped",
            Self::Tone => "tone",
            Self::TwoTones => "two tones",
            Self::WanderingTone => "wandering tone",
            Self::ToneBeside => "tone beside mode",
            Self::ToneOn => "tone on mode",
        }
    }
}

/// A file's content and what is true of it.
#[derive(Clone, Debug)]
pub struct DefectiveRecord {
    pub time_s: Vec<f64>,
    /// Per channel; NaN where the cell is empty.
    pub columns: Vec<Vec<f64>>,
    /// Frequencies of the lines in it \[Hz\].
    pub tones_hz: Vec<f64>,
    /// Rate at which it holds information \[Hz\].
    pub update_rate_hz: f64,
    /// Mode next to a line.
    pub beside_mode: Option<usize>,
}

/// Records a structure with a defect.
#[must_use]
pub fn record(structure: &Structure, defect: Defect, random: &mut Generator) -> DefectiveRecord {
    let rate_hz = structure.sample_rate_hz;
    let fastest_hz = structure.modes.last().map_or(1.0, |mode| mode.frequency_hz);
    let late =
        if defect == Defect::LateChannel { random.whole(1, (rate_hz / fastest_hz).max(1.0) as usize) } else { 0 };
    let mut motion = structure.motion(random, late);
    let mut record = DefectiveRecord {
        time_s: (0..structure.samples).map(|t| t as f64 / rate_hz).collect(),
        columns: Vec::new(),
        tones_hz: Vec::new(),
        update_rate_hz: rate_hz,
        beside_mode: None,
    };
    let late_channel = random.whole(0, structure.channels - 1);
    for (c, column) in motion.iter_mut().enumerate() {
        let lead = if c == late_channel { 0 } else { late };
        record.columns.push(column[lead..lead + structure.samples].to_vec());
    }
    tones(structure, defect, random, &mut record);
    for (c, column) in record.columns.iter_mut().enumerate() {
        let sigma = structure.sensor_noise * structure.channel_rms(c);
        column.iter_mut().for_each(|y| *y += sigma * random.normal());
    }
    damage(structure, defect, random, &mut record);
    record
}

/// Adds the lines of a defect.
fn tones(structure: &Structure, defect: Defect, random: &mut Generator, record: &mut DefectiveRecord) {
    let far = |random: &mut Generator| loop {
        let f = structure.sample_rate_hz * 0.012 * libm::pow(0.4 / 0.012, random.uniform());
        if structure.modes.iter().all(|mode| (f / mode.frequency_hz - 1.0).abs() > 0.12) {
            break f;
        }
    };
    let strength = random.between(0.5, 3.0);
    match defect {
        Defect::Tone => add_tone(structure, far(random), 0.0, strength, random, record),
        Defect::TwoTones => {
            let f = far(random);
            let second = f * (1.0 + random.between(0.003, 0.03));
            add_tone(structure, f, 0.0, strength, random, record);
            add_tone(structure, second, 0.0, strength * random.between(0.5, 1.0), random, record);
        }
        Defect::WanderingTone => {
            let (f, wander) = (far(random), random.between(0.005, 0.015));
            add_tone(structure, f, wander, strength, random, record);
        }
        Defect::ToneBeside | Defect::ToneOn => {
            let chosen = random.whole(0, structure.modes.len() - 1);
            let mode = &structure.modes[chosen];
            let widths = if defect == Defect::ToneOn { random.between(0.0, 0.5) } else { random.between(1.0, 3.0) };
            let f = mode.frequency_hz * (1.0 + 2.0 * mode.damping_ratio * widths * random.sign());
            record.beside_mode = Some(chosen);
            add_tone(structure, f, 0.0, mode.rms, random, record);
        }
        _ => {}
    }
}

/// A line of so many rms of modal coordinates, on every channel with a factor of its own; its
/// frequency wanders by ±`wander` of itself within 20–90 s.
fn add_tone(
    structure: &Structure,
    frequency_hz: f64,
    wander: f64,
    rms: f64,
    random: &mut Generator,
    record: &mut DefectiveRecord,
) {
    let (period_s, start) = (random.between(20.0, 90.0), TAU * random.uniform());
    let phase = TAU * random.uniform();
    let gains: Vec<f64> = record.columns.iter().map(|_| random.between(0.3, 1.0) * random.sign()).collect();
    for t in 0..structure.samples {
        let t_s = t as f64 / structure.sample_rate_hz;
        let swing = wander * period_s / TAU * libm::sin(TAU * t_s / period_s + start);
        let y = core::f64::consts::SQRT_2 * rms * libm::sin(TAU * frequency_hz * (t_s + swing) + phase);
        record.columns.iter_mut().zip(&gains).for_each(|(column, gain)| column[t] += gain * y);
    }
    record.tones_hz.push(frequency_hz);
}

/// What the logger does.
fn damage(structure: &Structure, defect: Defect, random: &mut Generator, record: &mut DefectiveRecord) {
    let rows = record.time_s.len();
    match defect {
        Defect::MissingRows => {
            let share = random.between(0.01, 0.25);
            keep(record, &(0..rows).map(|_| random.uniform() >= share).collect::<Vec<_>>());
        }
        Defect::MissingPackets => {
            let share = random.between(0.01, 0.25);
            let mut kept = vec![true; rows];
            while (kept.iter().filter(|kept| !**kept).count() as f64) < share * rows as f64 {
                let (from, length) = (random.whole(1, rows - 2), random.whole(2, 40));
                kept[from..(from + length).min(rows - 1)].fill(false);
            }
            keep(record, &kept);
        }
        Defect::MissingCells => {
            let share = random.between(0.01, 0.25);
            for y in record.columns.iter_mut().flatten() {
                if random.uniform() < share {
                    *y = f64::NAN;
                }
            }
        }
        Defect::Held => {
            let times = random.whole(2, 7);
            record.columns.iter_mut().for_each(|column| hold(column, times));
            record.update_rate_hz = structure.sample_rate_hz / times as f64;
        }
        Defect::SlowChannel => {
            let (channel, times) = (random.whole(0, record.columns.len() - 1), random.whole(2, 7));
            hold(&mut record.columns[channel], times);
        }
        Defect::RoundedStamps => {
            // A clock that no millisecond fits.
            let rate_hz = random.between(150.0, 400.0);
            let stretch = structure.sample_rate_hz / rate_hz;
            record.time_s.iter_mut().for_each(|t| *t = (*t * stretch * 1000.0).round() / 1000.0);
            record.update_rate_hz = rate_hz;
        }
        Defect::BunchedStamps => {
            let batch = random.whole(2, 8);
            let rate_hz = structure.sample_rate_hz;
            for (row, t) in record.time_s.iter_mut().enumerate() {
                *t = ((row / batch + 1) * batch) as f64 / rate_hz;
            }
        }
        Defect::Clipped => record.columns.iter_mut().for_each(|column| clip(column, 0.02)),
        _ => {}
    }
}

fn keep(record: &mut DefectiveRecord, kept: &[bool]) {
    let of = |values: &[f64]| values.iter().zip(kept).filter(|(_, kept)| **kept).map(|(y, _)| *y).collect();
    record.time_s = of(&record.time_s);
    record.columns.iter_mut().for_each(|column| *column = of(column));
}

/// Every value stands so many times.
fn hold(column: &mut [f64], times: usize) {
    (0..column.len()).for_each(|t| column[t] = column[t - t % times]);
}

/// The largest `share` of the magnitudes.
fn clip(column: &mut [f64], share: f64) {
    let mut sizes: Vec<f64> = column.iter().map(|y| y.abs()).collect();
    sizes.sort_by(f64::total_cmp);
    let limit = sizes[((1.0 - share) * sizes.len() as f64) as usize];
    column.iter_mut().for_each(|y| *y = y.clamp(-limit, limit));
}
