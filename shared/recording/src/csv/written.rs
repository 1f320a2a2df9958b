//! The one form in which text tables are written.

use crate::error::RecordingError;
use crate::file_name;
use crate::series::{check, for_each_time};
use crate::spectrum::Spectrum;
use crate::table::{Column, Table};
use crate::timing::check_extent;
use crate::whole_file::replace_stream;
use channels::Recording;
use flate2::write::GzEncoder;
use std::io::{BufWriter, Write};
use std::path::Path;

/// Writes a table in SI, gzipped when the name ends in `.gz`; every number reads back to the same
/// f64.
///
/// # Errors
/// The device's.
pub fn write_csv(table: &Table, path: &Path) -> Result<(), RecordingError> {
    let columns: Vec<_> = table.columns.iter().map(|column| (column.name.as_str(), column.unit)).collect();
    write_text(path, &mut |out| {
        write_header(out, "time [s]", &columns)?;
        write_columns(out, &table.time_s, &table.columns)
    })
}

/// Writes channels in SI, gzipped when the name ends in `.gz`: a row per time at which any channel
/// has a sample, an empty cell where a channel has none. Every number reads back to the same f64.
///
/// # Errors
/// [`RecordingError::BadChannel`] for what would not read back, times too few to read back, the
/// device's.
pub fn write_series_csv(recording: &Recording, path: &Path) -> Result<(), RecordingError> {
    check(recording)?;
    let mut times = Vec::new();
    let Ok(()) = for_each_time(recording, |time_s, _| {
        times.push(time_s);
        Ok::<(), core::convert::Infallible>(())
    });
    // The row of time i stands on line i + 2.
    check_extent(&file_name(path), &times, &(2..times.len() as u64 + 2).collect::<Vec<_>>())?;
    let columns: Vec<_> =
        recording.channels.iter().map(|channel| (channel.name.as_str(), channel.unit.as_str())).collect();
    write_text(path, &mut |out| {
        write_header(out, "time [s]", &columns)?;
        for_each_time(recording, |time_s, values| {
            write!(out, "{}", Shortest(time_s))?;
            for value in values {
                match value {
                    Some(value) => write!(out, ",{}", Shortest(*value))?,
                    None => write!(out, ",")?,
                }
            }
            writeln!(out)
        })
    })
}

/// Writes a spectrum in SI, gzipped when the name ends in `.gz`.
///
/// # Errors
/// The device's.
pub fn write_spectrum_csv(spectrum: &Spectrum, path: &Path) -> Result<(), RecordingError> {
    let columns: Vec<_> = spectrum.columns.iter().map(|column| (column.name.as_str(), column.unit)).collect();
    write_text(path, &mut |out| {
        write_header(out, "frequency [Hz]", &columns)?;
        write_columns(out, &spectrum.frequency_hz, &spectrum.columns)
    })
}

fn write_text(path: &Path, fill: &mut dyn FnMut(&mut dyn Write) -> std::io::Result<()>) -> Result<(), RecordingError> {
    let gzipped = path.extension().is_some_and(|extension| extension == "gz");
    replace_stream(path, |file| {
        if !gzipped {
            return fill(file);
        }
        // Cells one by one would cost a call of the compressor each.
        let mut text = BufWriter::with_capacity(1 << 16, GzEncoder::new(file, flate2::Compression::default()));
        fill(&mut text)?;
        text.into_inner().map_err(std::io::IntoInnerError::into_error)?.finish().map(|_| ())
    })
}

fn write_header(out: &mut dyn Write, first: &str, columns: &[(&str, &str)]) -> std::io::Result<()> {
    write!(out, "{first}")?;
    for (name, unit) in columns {
        // A name with a comma in it came out of quotes and goes back into them.
        let quote = if name.contains(',') { "\"" } else { "" };
        write!(out, ",{quote}{name} [{unit}]{quote}")?;
    }
    writeln!(out)
}

fn write_columns(out: &mut dyn Write, first: &[f64], columns: &[Column]) -> std::io::Result<()> {
    for (i, value) in first.iter().enumerate() {
        write!(out, "{}", Shortest(*value))?;
        for column in columns {
            write!(out, ",{}", Shortest(column.values[i]))?;
        }
        writeln!(out)?;
    }
    Ok(())
}

/// The fewest digits that read back to the same f64, with an exponent where zeros would be longer.
struct Shortest(f64);

impl core::fmt::Display for Shortest {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let value = self.0;
        if value == 0.0 || (1e-5..1e16).contains(&value.abs()) { write!(f, "{value}") } else { write!(f, "{value:e}") }
    }
}
