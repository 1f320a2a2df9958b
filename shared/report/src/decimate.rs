//! A long record as the points that can be seen: the extremes of every pixel column, in the order
//! of the record.
//!
//! A column keeps the first and the last sample in it and the least and the greatest between: a
//! line through these covers the same pixels as the line through all samples, and a spike of one
//! sample stays one.

/// A drawn point, in pixels.
pub type Point = (f64, f64);

/// Runs of points without a hole; a sample that is not finite ends a run. Consecutive samples of
/// one column of width 1 become four points at most.
///
/// Cost: O(n). Assumes nothing on the order of `x`: a path that turns back begins a new column.
#[must_use]
pub fn line(points: impl Iterator<Item = Point>) -> Vec<Vec<Point>> {
    let mut runs: Vec<Vec<Point>> = Vec::new();
    let mut column = Column::default();
    let mut open = false;
    for point in points {
        if !(point.0.is_finite() && point.1.is_finite()) {
            column.flush(&mut runs);
            open = false;
            continue;
        }
        if !open {
            runs.push(Vec::new());
            open = true;
        }
        column.add(point, &mut runs);
    }
    column.flush(&mut runs);
    runs
}

/// Samples of one pixel column, with their place in the record.
#[derive(Default)]
struct Column {
    count: usize,
    number: f64,
    first: Point,
    last: Point,
    low: (usize, Point),
    high: (usize, Point),
}

impl Column {
    fn add(&mut self, point: Point, runs: &mut [Vec<Point>]) {
        let number = libm::floor(point.0);
        if self.count > 0 && number != self.number {
            self.flush(runs);
        }
        if self.count == 0 {
            (self.number, self.first, self.low, self.high) = (number, point, (0, point), (0, point));
        }
        if point.1 < self.low.1.1 {
            self.low = (self.count, point);
        }
        if point.1 > self.high.1.1 {
            self.high = (self.count, point);
        }
        self.last = point;
        self.count += 1;
    }

    fn flush(&mut self, runs: &mut [Vec<Point>]) {
        let Some(run) = runs.last_mut().filter(|_| self.count > 0) else { return };
        let mut kept = [(0, self.first), self.low, self.high, (self.count - 1, self.last)];
        kept.sort_by_key(|(place, _)| *place);
        for (i, (place, point)) in kept.iter().enumerate() {
            if i == 0 || kept[i - 1].0 != *place {
                run.push(*point);
            }
        }
        self.count = 0;
    }
}

/// One point per occupied square of side `side`, in the order of the record: every place that a dot
/// would cover stays covered.
///
/// Cost: O(n log n).
#[must_use]
pub fn dots(points: impl Iterator<Item = Point>, side: f64) -> Vec<Point> {
    assert!(side > 0.0);
    let mut seen = std::collections::BTreeSet::new();
    points
        .filter(|p| p.0.is_finite() && p.1.is_finite())
        .filter(|p| seen.insert((libm::floor(p.0 / side) as i64, libm::floor(p.1 / side) as i64)))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A deterministic noise in [0, 1).
    fn noise(i: usize) -> f64 {
        let x = (i as u64).wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (x >> 40) as f64 / f64::from(1_u32 << 24)
    }

    #[test]
    fn every_column_keeps_its_extremes_and_its_ends() {
        let n = 25_000;
        let samples: Vec<Point> =
            (0..n).map(|i| (690.0 * i as f64 / n as f64, noise(i) + if i == 12_345 { 80.0 } else { 0.0 })).collect();
        let runs = line(samples.iter().copied());
        assert_eq!(runs.len(), 1);
        assert!(runs[0].len() <= 4 * 690, "{}", runs[0].len());
        for column in 0..690 {
            let of = |points: &[Point]| -> Vec<f64> {
                points.iter().filter(|p| libm::floor(p.0) as usize == column).map(|p| p.1).collect()
            };
            let (all, kept) = (of(&samples), of(&runs[0]));
            let least = |v: &[f64]| v.iter().copied().fold(f64::INFINITY, f64::min);
            let greatest = |v: &[f64]| v.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            assert_eq!((least(&all), greatest(&all)), (least(&kept), greatest(&kept)), "column {column}");
            assert_eq!((all[0], all[all.len() - 1]), (kept[0], kept[kept.len() - 1]), "column {column}");
        }
        assert!(runs[0].windows(2).all(|w| w[0].0 <= w[1].0), "the order of the record is kept");
    }

    #[test]
    fn a_hole_in_the_data_is_a_hole_in_the_line() {
        let y = [1.0, 2.0, f64::NAN, 3.0, f64::INFINITY, f64::NAN, 4.0];
        let runs = line(y.iter().enumerate().map(|(i, y)| (i as f64, *y)));
        assert_eq!(runs, [vec![(0.0, 1.0), (1.0, 2.0)], vec![(3.0, 3.0)], vec![(6.0, 4.0)]]);
        assert!(line(std::iter::empty()).is_empty());
    }

    #[test]
    fn dots_keep_every_occupied_place() {
        let samples: Vec<Point> = (0..50_000).map(|i| (100.0 * noise(i), 100.0 * noise(i + 70_000))).collect();
        let kept = dots(samples.iter().copied(), 2.0);
        assert!(kept.len() <= 2500);
        let square = |p: &Point| ((p.0 / 2.0) as i64, (p.1 / 2.0) as i64);
        let kept: std::collections::BTreeSet<_> = kept.iter().map(square).collect();
        assert!(samples.iter().all(|p| kept.contains(&square(p))));
    }
}
