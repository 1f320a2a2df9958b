//! What a file is that is not read is said in one sentence, and what to give in its place.

use crate::{scratch, structured::read};

/// A zip archive of entries without content.
fn archive(names: &[&str]) -> Vec<u8> {
    let (mut bytes, mut directory) = (Vec::new(), Vec::new());
    for name in names {
        let at = u32::try_from(bytes.len()).unwrap();
        let length = u16::try_from(name.len()).unwrap().to_le_bytes();
        let (sizes, rest) = ([0; 16], [0; 12]);
        bytes.extend([&b"PK\x03\x04\x14\0\0\0\0\0"[..], &sizes, &length, &[0; 2], name.as_bytes()].concat());
        directory.extend([&b"PK\x01\x02\x14\0\x14\0\0\0\0\0"[..], &sizes, &length, &rest].concat());
        directory.extend([&at.to_le_bytes()[..], name.as_bytes()].concat());
    }
    let count = u16::try_from(names.len()).unwrap().to_le_bytes();
    let at = u32::try_from(bytes.len()).unwrap().to_le_bytes();
    let size = u32::try_from(directory.len()).unwrap().to_le_bytes();
    bytes.extend(directory);
    bytes.extend([&b"PK\x05\x06\0\0\0\0"[..], &count, &count, &size, &at, &[0; 2]].concat());
    bytes
}

#[test]
fn a_file_that_is_not_read_is_named_with_what_to_export() {
    let workbook = archive(&["[Content_Types].xml", "xl/workbook.xml", "xl/styles.xml"]);
    let document = archive(&["mimetype", "content.xml", "META-INF/manifest.xml"]);
    let tables = archive(&["imu.csv", "motor.csv"]);
    let files: &[(&str, &[u8], &str, &str)] = &[
        ("book.xlsx", &workbook, "workbook of a spreadsheet", "save the sheet as CSV"),
        ("book.ods", &document, "document of an office program", "save the sheet as CSV"),
        ("tables.zip", &tables, "zip archive without arrays of NumPy: `imu.csv`, `motor.csv`", "unpack it"),
        ("old.xls", b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1\0\0", "old office program", "save the sheet as CSV"),
        ("log.tdms", b"TDSm\x0e\0\0\0\x69\x12", "TDMS file of LabVIEW", "CSV or MAT"),
        ("log.mf4", b"MDF     4.10    TGT 15.0", "measurement in MDF", "asammdf"),
        ("log.blf", b"LOGG\x90\0\0\0", "log of bus frames", "DBC"),
        ("log.asc", b"date Tue Mar 5 15:00:00.000 2024\nbase hex  timestamps absolute\n", "log of bus frames", "DBC"),
        ("can.log", b"(1.000000) can0 123#AABB\n(1.010000) can0 123#AABC\n", "log of bus frames", "DBC"),
        ("log.bin", b"\xa3\x95\x80\x80\x59FMT", "DataFlash log of ArduPilot", "mavlogdump.py"),
        ("log.feather", b"ARROW1\0\0\xff\xff\xff\xff", "file of Arrow", "Parquet"),
        ("log.wav", b"RIFF\x24\0\0\0WAVEfmt ", "file of sound", "rate"),
        ("log.csv", b"<!DOCTYPE html>\n<html><body>sign in</body></html>\n", "page of the web", "download"),
    ];
    for (name, content, what, cure) in files {
        let path = scratch(name);
        std::fs::write(&path, content).unwrap();
        let error = read(&path).unwrap_err();
        let lines: Vec<&str> = error.lines().collect();
        assert!(lines[0].contains(what) && error.contains(cure), "{name}: {error}");
        assert!(recording::format_name(&path).is_err() || name.starts_with("book") || *name == "tables.zip", "{name}");
    }
}
