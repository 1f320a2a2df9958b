use super::{EvenClock, Stamps};

/// SplitMix64, uniform in (0, 1).
fn uniform(state: &mut u64) -> f64 {
    *state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let mut z = *state;
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
}

fn rounded(time: f64, quantum: f64) -> f64 {
    (time / quantum).round() * quantum
}

#[test]
fn rows_that_tick_within_their_packet_are_no_fast_clock_with_rows_missing() {
    // packets of five rows a microsecond apart, every 50 ms
    let stamp = |k: usize| (k / 5 + 1) as f64 * 0.05 + (k % 5) as f64 * 1e-6;
    let clock = EvenClock::of(&(0..4000).map(stamp).collect::<Vec<_>>()).unwrap();
    assert!((clock.interval_s - 0.01).abs() < 1e-6 && clock.missing() == 0, "{}", clock.interval_s);
    assert!(matches!(clock.stamps, Stamps::Packed(_)));
    // two runs with an hour between them are one clock
    let stamp = |k: usize| k as f64 * 0.01 + if k < 2000 { 0.0 } else { 3600.0 };
    let clock = EvenClock::of(&(0..4000).map(stamp).collect::<Vec<_>>()).unwrap();
    assert!((clock.interval_s - 0.01).abs() < 1e-9 && clock.missing() == 360_000);
}

#[test]
fn stamps_rounded_to_any_quantum_show_their_even_clock() {
    for (rate, quantum, start) in [
        (300.0, 1e-3, 0.0),
        (300.0, 1e-3, 1.7e9),
        (100.0, 1.0 / 64.0, 3.3),
        (130.0, 0.01, 17.0),
        (200.0, 1.0 / 60.0, 0.0),
        (10.3, 1.0, 1.6e9),
    ] {
        let stamps: Vec<f64> = (0..4000).map(|k| rounded(start + f64::from(k) / rate, quantum)).collect();
        let clock = EvenClock::of(&stamps).unwrap_or_else(|| panic!("{rate} {quantum}"));
        assert!(matches!(clock.stamps, Stamps::Rounded(q) if (q / quantum - 1.0).abs() < 1e-3), "{clock:?}");
        // the line through 4000 rows is known to a quantum over its length
        assert!((clock.interval_s * rate - 1.0).abs() < quantum * rate / 4000.0, "{rate} {}", clock.interval_s);
        assert_eq!((clock.missing(), clock.rows.len()), (0, 4000));
    }
}

#[test]
fn rows_lost_at_random_or_every_tenth_leave_the_clock_even_with_rounded_stamps_too() {
    for (seed, (lost, quantum)) in [(0.03, 0.0), (0.4, 0.0), (0.05, 1e-3)].into_iter().enumerate() {
        let mut state = 77 + seed as u64;
        let kept: Vec<usize> = (0..3000).filter(|k| *k == 0 || uniform(&mut state) > lost).collect();
        let stamp = |k: &usize| {
            let time = *k as f64 / 300.0;
            if quantum > 0.0 { rounded(time, quantum) } else { time }
        };
        let clock = EvenClock::of(&kept.iter().map(stamp).collect::<Vec<_>>()).unwrap();
        assert_eq!(clock.rows, kept);
        assert!((clock.interval_s * 300.0 - 1.0).abs() < 1e-4);
    }
    let tenth: Vec<f64> = (0..1000).filter(|k| k % 10 != 9).map(|k| 0.02 * f64::from(k)).collect();
    let clock = EvenClock::of(&tenth).unwrap();
    assert_eq!((clock.stamps, clock.missing()), (Stamps::Right, 99));
}

#[test]
fn packets_show_the_even_clock_of_their_rows() {
    for (seed, (size, spread, late)) in [(5, 0.0, 0.0), (8, 1e-4, 2e-3), (2, 0.0, 1e-3)].into_iter().enumerate() {
        let mut state = 177 + seed as u64;
        let mut stamps = Vec::new();
        for packet in 0..400 {
            let at = f64::from(size * (packet + 1)) / 100.0 + late * uniform(&mut state);
            stamps.extend((0..size).map(|row| at + spread * f64::from(row)));
        }
        let clock = EvenClock::of(&stamps).unwrap_or_else(|| panic!("{size}"));
        assert!((clock.interval_s * 100.0 - 1.0).abs() < 1e-3, "{}", clock.interval_s);
        assert_eq!(clock.missing(), 0);
    }
}

/// Stamps of 100 Hz in packets of ten but for the rows in `lost`.
fn in_packets(stamp: impl Fn(usize) -> f64, lost: &[core::ops::Range<usize>]) -> (EvenClock, Vec<usize>) {
    let kept: Vec<usize> = (0..1000).filter(|row| !lost.iter().any(|range| range.contains(row))).collect();
    let stamps: Vec<f64> = kept.iter().map(|row| stamp(*row)).collect();
    (EvenClock::of(&stamps).unwrap_or_else(|| panic!("{lost:?}")), kept)
}

#[test]
fn packets_that_were_lost_are_gaps_in_the_clock_of_the_others() {
    let ticks = |row: usize| 0.1 * (row / 10) as f64 + 1e-4 * (row % 10) as f64;
    let same = |row: usize| 0.05 * (row / 5) as f64 + 0.05;
    let alone = [500..510, 500..600, 500..700, 300..330, 10..40, 900..950];
    let three = [200..210, 500..510, 700..710];
    for lost in alone.iter().map(std::slice::from_ref).chain([&three[..]]) {
        for (clock, kept) in [in_packets(ticks, lost), in_packets(same, lost)] {
            assert!((clock.interval_s - 0.01).abs() < 1e-5, "{lost:?}: {}", clock.interval_s);
            let off = clock.rows.iter().zip(&kept).map(|(row, true_row)| row.abs_diff(*true_row)).max();
            assert!(off.unwrap() <= 1, "{lost:?}: {off:?}");
            let (Stamps::Packed(wait_s) | Stamps::Rounded(wait_s)) = clock.stamps else { panic!("{lost:?}") };
            assert!(wait_s < 0.11, "{lost:?}: {wait_s}");
        }
    }
}

#[test]
fn rows_lost_under_a_coarse_clock_are_gaps_of_the_even_one() {
    for (rate, quantum, lost) in [(300.0, 0.01, 500..506), (300.0, 0.01, 500..530), (100.0, 1.0, 430..560)] {
        let stamp = |row: usize| (row as f64 / rate / quantum + 1e-9).floor() * quantum;
        let (clock, kept) = in_packets(stamp, std::slice::from_ref(&lost));
        assert!((clock.interval_s * rate - 1.0).abs() < 3e-3, "{lost:?} {}", 1.0 / clock.interval_s);
        let off = clock.rows.iter().zip(&kept).map(|(row, true_row)| row.abs_diff(*true_row)).max().unwrap();
        // where within a second its rows were lost is not known
        let most = if quantum == 1.0 { 100 } else { 1 };
        assert!(off <= most, "{lost:?}: {off}");
    }
}

#[test]
fn a_packet_that_is_late_alone_is_no_loss() {
    let stamp = |row: usize| 0.1 * (row / 10) as f64 + if (500..530).contains(&row) { 0.25 } else { 0.0 };
    let stamps: Vec<f64> = (0..1000).map(|row| stamp(row).max(if row >= 530 { stamp(529) } else { 0.0 })).collect();
    let clock = EvenClock::of(&stamps).unwrap();
    assert_eq!(clock.missing(), 0);
}

#[test]
fn an_uneven_clock_is_none() {
    for seed in 0..200 {
        let mut state = 1000 + seed;
        let mut walk = |step: &mut dyn FnMut(f64) -> f64| {
            let mut time = 0.0;
            let stamps = (0..200).map(|_| {
                time += step(uniform(&mut state));
                time
            });
            EvenClock::of(&stamps.collect::<Vec<_>>())
        };
        assert_eq!(walk(&mut |u| 0.01 * (0.5 + u)), None, "even chance of half a step more or less");
        assert_eq!(walk(&mut |u| -0.01 * (1.0 - u).ln()), None, "at random");
        assert_eq!(walk(&mut |u| if u < 0.5 { 0.01 } else { 0.015 }), None, "two intervals");
        assert_eq!(walk(&mut |u| if u < 0.5 { 0.0 } else { 0.01 }), None, "two values a stamp at random");
        let sweep: Vec<f64> = (0..200).map(|k| 0.01 * f64::from(k) + 1e-4 * f64::from(k * k)).collect();
        assert_eq!(EvenClock::of(&sweep), None, "a rate that falls");
    }
}

#[test]
fn a_row_that_stands_twice_is_not_rounding() {
    let mut stamps: Vec<f64> = (0..500).map(|k| 0.01 * f64::from(k)).collect();
    stamps.insert(250, stamps[250]);
    assert_eq!(EvenClock::of(&stamps), None);
}
