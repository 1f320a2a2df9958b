//! Files that are known by their first bytes and not read: what they are, and what to give instead.

/// What a file is, in words, and what to export.
pub(crate) type Recognised = (&'static str, &'static str);

const SHEET: &str = "save the sheet as CSV";
const FRAMES: &str = "decode its frames with their data base (DBC) and export the signals as CSV or MAT";
const UNPACK: &str = "unpack it and give the recording inside";
const ARROW: &str = "write it as Parquet: in Python `pyarrow.parquet.write_table(pyarrow.feather.read_table(IN), OUT)`";

/// First bytes of formats that are not read.
const MAGIC: &[(&[u8], Recognised)] = &[
    (b"TDSm", ("a TDMS file of LabVIEW", "export it as CSV or MAT: in Python `nptdms.TdmsFile(IN).as_dataframe()`")),
    (b"MDF ", ("a measurement in MDF (.mf4, .mdf)", "export the signals as CSV, MAT or Parquet: `asammdf` does")),
    (
        b"UnFinMF",
        ("a measurement in MDF that was not finished", "export the signals as CSV, MAT or Parquet: `asammdf` does"),
    ),
    (b"LOGG", ("a log of bus frames (.blf)", FRAMES)),
    (b"ARROW1", ("a file of Arrow (.arrow, .feather)", ARROW)),
    (b"FEA1", ("a file of Arrow (.feather)", ARROW)),
    (
        b"\xa3\x95\x80",
        (
            "a DataFlash log of ArduPilot (.bin)",
            "convert it: `mavlogdump.py --format csv --types IMU FILE`, or export MAT in Mission Planner",
        ),
    ),
    (b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1", ("a workbook or document of an old office program (.xls)", SHEET)),
    (b"\x0e\x03\x13\x01", ("HDF of version 4", "convert it to version 5: `h4toh5 IN OUT`")),
    (b"Obj\x01", ("a file of Avro", "write it as Parquet or JSON lines")),
    (b"ORC", ("a file of ORC", "write it as Parquet")),
    (b"\x80\x04\x95", ("a pickle of Python", "write the data with numpy.savez, to_parquet or to_csv")),
    (b"\x80\x05\x95", ("a pickle of Python", "write the data with numpy.savez, to_parquet or to_csv")),
    (b"|CF,", ("a measurement of imc (.raw, .dat)", "export it as CSV or MAT")),
    (b"7z\xbc\xaf\x27\x1c", ("an archive (.7z)", UNPACK)),
    (b"Rar!", ("an archive (.rar)", UNPACK)),
    (b"BZh", ("a file that bzip2 packed", UNPACK)),
    (b"\xfd7zXZ", ("a file that xz packed", UNPACK)),
    (b"\x28\xb5\x2f\xfd", ("a file that zstd packed", UNPACK)),
    (b"\x04\x22\x4d\x18", ("a file that lz4 packed", UNPACK)),
    (b"%PDF-", ("a document (.pdf)", "give the recording that it shows, as CSV")),
    (b"\x89PNG", ("a picture", "give the recording that it shows, as CSV")),
];

/// What a file is that begins with `head` and is not read.
pub(crate) fn recognised(head: &[u8]) -> Option<Recognised> {
    let by_magic = MAGIC.iter().find(|(magic, _)| head.starts_with(magic)).map(|(_, of)| *of);
    by_magic.or_else(|| sound(head)).or_else(|| text(head))
}

fn sound(head: &[u8]) -> Option<Recognised> {
    let is_wave = head.starts_with(b"RIFF") && head.get(8..12) == Some(b"WAVE");
    is_wave.then_some(("a file of sound (.wav)", "write its samples as CSV or NPZ, with their rate and unit"))
}

/// Texts that are no tables.
fn text(head: &[u8]) -> Option<Recognised> {
    let text = String::from_utf8_lossy(head).to_lowercase();
    let text = text.trim_start_matches('\u{feff}').trim_start();
    if text.starts_with("<!doctype html") || text.starts_with("<html") {
        return Some(("a page of the web", "download the recording itself: a page of the server stands in its place"));
    }
    let mut lines = text.lines().filter(|line| !line.trim().is_empty());
    let (first, second) = (lines.next()?, lines.next().unwrap_or_default());
    let is_asc = first.starts_with("date ") && second.starts_with("base ");
    let is_frame = |line: &str| {
        let mut words = line.split_whitespace();
        let time = words.next().is_some_and(|word| word.starts_with('(') && word.ends_with(')'));
        time && words.next().is_some() && words.next().is_some_and(|word| word.contains('#'))
    };
    (is_asc || (is_frame(first) && is_frame(second))).then_some(("a log of bus frames as text (.asc, candump)", FRAMES))
}

/// What a zip archive without arrays of NumPy is, by the names of its entries.
pub(crate) fn archive(names: &[&str]) -> (String, String) {
    let has = |part: &str| names.iter().any(|name| name.contains(part));
    if has("xl/workbook") {
        return ("this is a workbook of a spreadsheet (.xlsx)".into(), SHEET.into());
    }
    if has("META-INF/manifest.xml") && has("content.xml") {
        return ("this is a document of an office program (.ods)".into(), SHEET.into());
    }
    const SHOWN_MAX: usize = 6;
    let shown: Vec<String> = names.iter().take(SHOWN_MAX).map(|name| format!("`{name}`")).collect();
    let dots = if names.len() > SHOWN_MAX { ", ..." } else { "" };
    (format!("this is a zip archive without arrays of NumPy: {}{dots}", shown.join(", ")), UNPACK.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_that_are_no_tables_are_recognised_and_tables_are_not() {
        for head in [
            "date Tue Mar 5 15:00:00.000 2024\nbase hex  timestamps absolute\n",
            "(1709650798.000000) can0 123#AABB\n(1709650798.010000) can0 123#AABC\n",
            "\u{feff}<!DOCTYPE html>",
        ] {
            assert!(recognised(head.as_bytes()).is_some(), "{head}");
        }
        for head in ["date time,x\n2024-03-05 15:00:00,1\n", "t,x\n0,1\n", "{\"a\":1}", "(s) (m)\n1 2", ""] {
            assert!(recognised(head.as_bytes()).is_none(), "{head}");
        }
    }
}
