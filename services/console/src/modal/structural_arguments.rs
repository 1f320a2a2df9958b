//! Arguments of `obsid modal` that structural engineers expect.

use std::path::PathBuf;

/// What is done before, beside and after the identification
#[derive(clap::Args, Clone, Default)]
#[command(next_help_heading = "Structures")]
pub(crate) struct StructuralArguments {
    /// Compare with these modes: an answer of `obsid modal --json`, or a universal file with shapes
    /// (55)
    #[arg(long, value_name = "FILE")]
    pub reference: Option<PathBuf>,
    /// Nodes and lines for the shapes: a universal file (15, 2411, 82), or TOML: nodes.tip =
    /// [0, 0, 2.5]; lines = [["root", "tip"]]; sensors.acc_3 = { node = "tip", direction = "-x" }
    #[arg(long, value_name = "FILE", verbatim_doc_comment)]
    pub geometry: Option<PathBuf>,
    /// Write geometry and modes as a universal file (15, 82, 55)
    #[arg(long, value_name = "FILE")]
    pub uff: Option<PathBuf>,
    /// Write the singular values of the spectral matrix over frequency, as CSV
    #[arg(long, value_name = "FILE")]
    pub singular_values: Option<PathBuf>,
    /// Records of the other setups of one structure; --references names the sensors that stayed
    #[arg(long, value_delimiter = ',', value_name = "FILE", conflicts_with_all = ["input", "channels", "select"])]
    pub setup: Vec<PathBuf>,
    /// Channels that every setup has at one place; those of the same name when not given
    #[arg(long, value_delimiter = ',', value_name = "NAME", requires = "setup")]
    pub references: Vec<String>,
    /// How setups are merged: each identified by itself (poser), or all at once (preger)
    #[arg(long, value_enum, default_value_t = MergeBy::Poser, requires = "setup")]
    pub merge: MergeBy,
    /// Take these poles of the order sweep as the modes: order and frequency [Hz]
    #[arg(long, value_delimiter = ',', value_name = "ORDER:HZ", value_parser = pick, conflicts_with = "input")]
    pub select: Vec<(usize, f64)>,
    /// Every N-th sample, or this rate, behind an anti-alias filter (pass band 0.4 of the new rate)
    #[arg(long, value_name = "N|RATEHz", value_parser = decimation, conflicts_with = "input")]
    pub decimate: Option<Decimation>,
    /// Take the mean or a line out of every channel; a short decay keeps its mean
    #[arg(long, value_enum, default_value_t = Detrend::None)]
    pub detrend: Detrend,
}

/// When setups are brought together.
#[derive(clap::ValueEnum, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum MergeBy {
    #[default]
    Poser,
    Preger,
}

/// What is taken out of the channels.
#[derive(clap::ValueEnum, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Detrend {
    Mean,
    Linear,
    #[default]
    None,
}

/// A lower rate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Decimation {
    Factor(usize),
    RateHz(f64),
}

/// Factors beyond this leave no record.
const FACTOR_MAX: usize = 10_000;

fn decimation(text: &str) -> Result<Decimation, String> {
    let wrong = || format!("'{text}' is neither a factor nor a rate; write 5 or 20Hz");
    match text.strip_suffix("Hz").or_else(|| text.strip_suffix("hz")) {
        Some(rate) => {
            let rate: f64 = rate.trim().parse().map_err(|_| wrong())?;
            if rate > 0.0 && rate.is_finite() { Ok(Decimation::RateHz(rate)) } else { Err(wrong()) }
        }
        None => {
            let factor: usize = text.parse().map_err(|_| wrong())?;
            if (1..=FACTOR_MAX).contains(&factor) { Ok(Decimation::Factor(factor)) } else { Err(wrong()) }
        }
    }
}

fn pick(text: &str) -> Result<(usize, f64), String> {
    let wrong = || format!("'{text}' is no order and frequency; write 14:5.2");
    let (order, hz) = text.split_once(':').ok_or_else(wrong)?;
    let (order, hz): (usize, f64) = (order.parse().map_err(|_| wrong())?, hz.parse().map_err(|_| wrong())?);
    if order >= 1 && hz > 0.0 && hz.is_finite() { Ok((order, hz)) } else { Err(wrong()) }
}

impl StructuralArguments {
    /// The first option given that only a time record has a use for.
    pub(super) fn of_time_only(&self) -> Option<&'static str> {
        let given = [
            (!self.select.is_empty(), "--select"),
            (self.decimate.is_some(), "--decimate"),
            (self.detrend != Detrend::None, "--detrend"),
        ];
        given.into_iter().find_map(|(given, name)| given.then_some(name))
    }

    /// The words of a command line that say the same.
    pub(super) fn words(&self) -> Vec<String> {
        let mut words = Vec::new();
        let mut add = |flag: &str, value: String| words.extend([flag.to_owned(), value]);
        let files = [
            ("--reference", &self.reference),
            ("--geometry", &self.geometry),
            ("--uff", &self.uff),
            ("--singular-values", &self.singular_values),
        ];
        for (flag, file) in files {
            file.iter().for_each(|file| add(flag, file.display().to_string()));
        }
        if !self.setup.is_empty() {
            add("--setup", self.setup.iter().map(|file| file.display().to_string()).collect::<Vec<_>>().join(","));
            if !self.references.is_empty() {
                add("--references", self.references.join(","));
            }
            if self.merge == MergeBy::Preger {
                add("--merge", "preger".into());
            }
        }
        if !self.select.is_empty() {
            let picks = self.select.iter().map(|(order, hz)| format!("{order}:{hz}"));
            add("--select", picks.collect::<Vec<_>>().join(","));
        }
        match self.decimate {
            Some(Decimation::Factor(factor)) => add("--decimate", factor.to_string()),
            Some(Decimation::RateHz(rate)) => add("--decimate", format!("{rate}Hz")),
            None => {}
        }
        match self.detrend {
            Detrend::Mean => add("--detrend", "mean".into()),
            Detrend::Linear => add("--detrend", "linear".into()),
            Detrend::None => {}
        }
        words
    }
}
