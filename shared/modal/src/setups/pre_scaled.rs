//! One identification of several setups whose covariances are scaled by the references before.
//!
//! A track of poles within the bandwidth of a longer one and of its shape is the same mode: noise
//! in the references splits tracks.

use crate::gram::Gram;
use crate::mac::modal_assurance_criterion;
use crate::ssi_cov::{Pole, Realisation, SsiError};
use crate::stabilisation::{StabilityCriteria, Track, tracks};
use faer::linalg::solvers::Solve;
use faer::{Mat, MatRef, Side};

/// Orders in which a mode has to repeat, as for one record.
const ORDERS_NEEDED: usize = 6;

/// One setup as it enters: how its blocks of rows fall to references and moving sensors.
struct Part {
    /// Moving rows by reference pasts.
    moving: Mat<f64>,
    /// `Z = Uᵀ H_ref`, all orders.
    states: Mat<f64>,
    sensors: usize,
}

/// Modes of all setups together, a pole each over the references and then the moving sensors of
/// every setup; the first `references` channels of each Gram matrix are the same sensors.
///
/// Poles that repeat in six orders are modes, and the pole of each is the one of median damping. No
/// standard deviations are stated.
///
/// # Errors
/// [`SsiError`] when a setup is too short or its references are flat.
pub fn pre_scaled(
    grams: &[Gram],
    references: usize,
    order_max: usize,
    sample_rate_hz: f64,
    criteria: &StabilityCriteria,
) -> Result<Vec<Pole>, SsiError> {
    assert!(grams.windows(2).all(|two| two[0].block_rows == two[1].block_rows));
    let (basis, scaled) = reference_space(grams, references, order_max)?;
    let parts: Vec<Part> = grams
        .iter()
        .zip(&scaled)
        .map(|(gram, of_references)| {
            let sensors = gram.channels - references;
            Part {
                moving: rows(gram, references, references..gram.channels),
                states: basis.transpose() * of_references,
                sensors,
            }
        })
        .collect();
    let channels = references + parts.iter().map(|part| part.sensors).sum::<usize>();
    let mut all = Vec::new();
    for order in 1..=basis.ncols() {
        let Some(observability) = observability(&basis, &parts, references, order) else { continue };
        let realisation = Realisation::from_observability(observability, Mat::zeros(0, 0), vec![1.0; order], channels);
        let band = (0.0, 0.5 * sample_rate_hz);
        all.extend(
            realisation.poles(order, sample_rate_hz).into_iter().filter(|p| criteria.hard_rejection(p, band).is_none()),
        );
    }
    let needed = ORDERS_NEEDED.min(basis.ncols());
    let mut lasting: Vec<Track> =
        tracks(all, criteria).into_iter().filter(|track| track.poles.len() >= needed).collect();
    lasting.sort_by_key(|track| std::cmp::Reverse(track.poles.len()));
    let mut modes: Vec<Pole> = Vec::new();
    for mut track in lasting {
        track.poles.sort_by(|a, b| a.damping_ratio.total_cmp(&b.damping_ratio));
        let pole = track.poles.swap_remove(track.poles.len() / 2);
        if !modes.iter().any(|longer| is_same(longer, &pole, criteria)) {
            modes.push(pole);
        }
    }
    modes.sort_by(|a, b| a.frequency_hz.total_cmp(&b.frequency_hz));
    Ok(modes)
}

/// Block rows of the references, then the moving sensors of every setup, of an order; `None` where
/// a setup does not excite so many states.
fn observability(basis: &Mat<f64>, parts: &[Part], references: usize, order: usize) -> Option<Mat<f64>> {
    let block_rows = basis.nrows() / references;
    let channels = references + parts.iter().map(|part| part.sensors).sum::<usize>();
    let mut all = Mat::<f64>::zeros(block_rows * channels, order);
    let mut place = |first: usize, count: usize, from: MatRef<'_, f64>| {
        for row in 0..block_rows * count {
            for k in 0..order {
                all[(row / count * channels + first + row % count, k)] = from[(row, k)];
            }
        }
    };
    place(0, references, basis.as_ref());
    let mut first = references;
    for part in parts.iter().filter(|part| part.sensors > 0) {
        place(first, part.sensors, regressed(part, order)?.as_ref());
        first += part.sensors;
    }
    Some(all)
}

/// Within the half-power bandwidth, and of one shape: two tracks of one mode.
fn is_same(a: &Pole, b: &Pole, criteria: &StabilityCriteria) -> bool {
    let bandwidth_hz = 2.0 * a.damping_ratio.max(b.damping_ratio) * a.frequency_hz;
    (a.frequency_hz - b.frequency_hz).abs() <= bandwidth_hz
        && modal_assurance_criterion(&a.mode_shape, &b.mode_shape) >= criteria.mac_min
}

/// Future rows of the channels `of` by past columns of the references.
fn rows(gram: &Gram, references: usize, of: std::ops::Range<usize>) -> Mat<f64> {
    let (l, i, half) = (gram.channels, gram.block_rows, gram.half());
    let count = of.len();
    Mat::from_fn(i * count, i * references, |row, column| {
        let channel = of.start + row % count;
        gram.matrix[(half + row / count * l + channel, column / references * l + column % references)]
    })
}

/// Column space of all references together, and the reference blocks of the setups.
fn reference_space(grams: &[Gram], references: usize, order_max: usize) -> Result<(Mat<f64>, Vec<Mat<f64>>), SsiError> {
    let blocks: Vec<Mat<f64>> = grams.iter().map(|gram| rows(gram, references, 0..references)).collect();
    let size = blocks[0].nrows();
    let mut side_by_side = Mat::<f64>::zeros(size, size * blocks.len());
    for (j, (block, gram)) in blocks.iter().zip(grams).enumerate() {
        let need = 2 * order_max.min(size - references) as u64;
        if gram.columns < need {
            return Err(SsiError::RecordTooShort { columns: gram.columns, need });
        }
        let norm = block.norm_l2();
        if norm.is_nan() || norm <= f64::MIN_POSITIVE {
            return Err(SsiError::NoSignal { largest_singular_value: norm });
        }
        for column in 0..size {
            for row in 0..size {
                side_by_side[(row, j * size + column)] = block[(row, column)] / norm;
            }
        }
    }
    // Left singular vectors of the wide matrix: eigenvectors of its product with itself would
    // square the singular values.
    let svd = side_by_side.thin_svd().map_err(|_| SsiError::DecompositionFailed { rows: size })?;
    let available = order_max.min(size - references);
    Ok((svd.U().get(.., ..available).to_owned(), blocks))
}

/// `H_mov Z⁺` of an order.
fn regressed(part: &Part, order: usize) -> Option<Mat<f64>> {
    let z = part.states.get(..order, ..);
    let normal = z * z.transpose();
    let right = z * part.moving.transpose();
    let solved = normal.llt(Side::Lower).ok()?.solve(&right);
    Some(solved.transpose().to_owned())
}
