//! Files that are no single time record: a spectrum, and several recordings one after another.

use crate::{file, scratch};
use recording::{FORMATS, Imported, read, segments, series};

#[test]
fn a_spectrum_is_read_in_si_and_written_as_it_was_read() {
    let text = "frequency [kHz],accelerance_real [m/s^2/N],a [g]\n0,-1.5,1\n0.1,2,-0\n0.35,1e-30,0\n";
    let imported = read(&file("frf.csv", text)).unwrap();
    let Imported::Spectrum(spectrum) = &imported else { panic!("a spectrum") };
    assert_eq!(spectrum.frequency_hz, [0.0, 100.0, 350.0]);
    assert_eq!(spectrum.columns[spectrum.column_named("a").unwrap()].values, [9.806_65, 0.0, 0.0]);
    let path = scratch("frf-again.csv.gz");
    let csv = FORMATS.iter().find(|format| format.name() == "csv").unwrap();
    csv.write(&imported, &path).unwrap();
    let Imported::Spectrum(again) = read(&path).unwrap() else { panic!("a spectrum") };
    assert_eq!(again.frequency_hz, spectrum.frequency_hz);
    let values = |s: &recording::Spectrum| s.columns.iter().map(|c| c.values.clone()).collect::<Vec<_>>();
    assert_eq!(values(&again), values(spectrum));
    let error = series(imported).unwrap_err().explain();
    assert!(error.contains("frf.csv: line 1, column 1 `frequency [Hz]`") && error.contains("spectrum"), "{error}");
}

#[test]
fn time_that_starts_again_begins_another_recording_of_the_same_channels() {
    let text = "time [s],drop [-],height [m]\n1,1,10\n2,1,8\n3,1,4\n1,2,11\n2,2,\n0,3,7\n0.5,3,6\n";
    let path = file("drops.csv", text);
    let Imported::Segments(found) = read(&path).unwrap() else { panic!("segments") };
    assert_eq!(found.restarts.iter().map(|restart| restart.line).collect::<Vec<_>>(), [5, 7]);
    assert_eq!((found.restarts[1].before_s, found.restarts[1].after_s), (2.0, 0.0));
    let parts = segments(Imported::Segments(found)).unwrap();
    let heights: Vec<_> =
        parts.iter().map(|part| part.recording.channel_named("height").unwrap().value.clone()).collect();
    assert_eq!(heights, [vec![10.0, 8.0, 4.0], vec![11.0], vec![7.0, 6.0]]);
    assert_eq!(parts[1].recording.channels[0].time_s, [1.0, 2.0]);
    assert!(parts[1].recording.name.ends_with("drops.csv (lines 5 to 6)"), "{}", parts[1].recording.name);
    let error = series(read(&path).unwrap()).unwrap_err().explain();
    assert!(error.contains("drops.csv: line 5") && error.contains("split it before line 5"), "{error}");
    let one = segments(read(&file("one.csv", "time [s],x [m]\n0,1\n1,2\n")).unwrap()).unwrap();
    assert_eq!(one.len(), 1);
}
