//! Named noise streams with random access: the k-th number is a function of (seed, name, k) alone.
//!
//! Generator: Philox4x32-10 (Salmon, Moraes, Dror, Shaw, "Parallel random numbers: as easy as 1, 2,
//! 3", SC11), a counter-based generator that passes BigCrush. Key = seed; counter = (sample number,
//! 64-bit FNV-1a hash of the stream name). Two streams differ in the counter, so they share a
//! number only if two names collide in 64 bits. One block of 128 bits gives one normal deviate by
//! Box–Muller.
//!
//! Why not a stateful generator: a simulator restarted from a checkpoint, or a sensor added to the
//! set, must not move any other number. With a counter there is nothing to save and nothing to
//! advance.

/// One named stream of noise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stream {
    seed: u64,
    name_hash: u64,
}

impl Stream {
    /// Stream `name` of the campaign `seed`; every name is independent of every other.
    pub fn new(seed: u64, name: &str) -> Self {
        Self::of_parts(seed, &[name])
    }

    /// The stream whose name is `parts`, one after the other; takes no memory.
    pub fn of_parts(seed: u64, parts: &[&str]) -> Self {
        let bytes = parts.iter().flat_map(|part| part.bytes());
        Self { seed, name_hash: fnv1a(bytes) }
    }

    /// Two uniform deviates of this sample, the first in (0, 1], the second in [0, 1); 53 bits
    /// each.
    pub fn uniform_pair(&self, sample: u64) -> [f64; 2] {
        let counter = [low(sample), high(sample), low(self.name_hash), high(self.name_hash)];
        let bits = philox4x32_10(counter, [low(self.seed), high(self.seed)]);
        let first = (u64::from(bits[1]) << 32 | u64::from(bits[0])) >> 11;
        let second = (u64::from(bits[3]) << 32 | u64::from(bits[2])) >> 11;
        [(first + 1) as f64 * UNIT_53, second as f64 * UNIT_53]
    }

    /// Standard normal deviate of this sample: `√(−2 ln u₁) cos 2πu₂` (Box and Muller, 1958).
    ///
    /// Cost: about 40 ns, the same for every sample number. Largest possible value: √(2·53 ln 2) =
    /// 8.57.
    pub fn normal(&self, sample: u64) -> f64 {
        let [u_1, u_2] = self.uniform_pair(sample);
        (-2.0 * libm::log(u_1)).sqrt() * cosine_of_turns(u_2)
    }
}

/// `cos 2πu` for u in [0, 1), to one unit in the last place of one.
///
/// Why not `libm::cos`: the quadrant of a random angle cannot be predicted, and each of its
/// branches costs more than both polynomials. The reduction to an eighth of a turn is exact here;
/// the polynomials are those of fdlibm's `k_sin.c` and `k_cos.c`.
fn cosine_of_turns(turns: f64) -> f64 {
    let quarters = 4.0 * turns;
    let nearest = (quarters + 0.5) as usize;
    let x = (quarters - nearest as f64) * core::f64::consts::FRAC_PI_2;
    let z = x * x;
    let sine_tail = z
        * (8.333_333_333_322_49e-3
            + z * (-1.984_126_982_985_795e-4
                + z * (2.755_731_370_707_006_8e-6 + z * (-2.505_076_025_340_686_3e-8 + z * 1.589_690_995_211_55e-10))));
    let sin = x + x * z * (-1.666_666_666_666_663_2e-1 + sine_tail);
    let cosine_tail = 4.166_666_666_666_66e-2
        + z * (-1.388_888_888_887_411e-3
            + z * (2.480_158_728_947_673e-5
                + z * (-2.755_731_435_139_066_3e-7
                    + z * (2.087_572_321_298_175e-9 - z * 1.135_964_755_778_819_5e-11))));
    let half = 0.5 * z;
    let whole = 1.0 - half;
    let cos = whole + (((1.0 - whole) - half) + z * z * cosine_tail);
    [cos, -sin, -cos, sin][nearest & 3]
}

const UNIT_53: f64 = 1.0 / (1u64 << 53) as f64;

const fn low(word: u64) -> u32 {
    (word & 0xffff_ffff) as u32
}

const fn high(word: u64) -> u32 {
    (word >> 32) as u32
}

/// 64-bit FNV-1a (Fowler, Noll, Vo).
fn fnv1a(bytes: impl IntoIterator<Item = u8>) -> u64 {
    bytes.into_iter().fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}

/// Ten rounds of Philox4x32: `counter`, `key` → 128 random bits.
fn philox4x32_10(mut counter: [u32; 4], mut key: [u32; 2]) -> [u32; 4] {
    for _ in 0..10 {
        let product_0 = u64::from(counter[0]) * 0xd251_1f53;
        let product_1 = u64::from(counter[2]) * 0xcd9e_8d57;
        counter = [
            high(product_1) ^ counter[1] ^ key[0],
            low(product_1),
            high(product_0) ^ counter[3] ^ key[1],
            low(product_0),
        ];
        key = [key[0].wrapping_add(0x9e37_79b9), key[1].wrapping_add(0xbb67_ae85)];
    }
    counter
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The three known answers that the authors of Philox publish with their reference code
    /// (Random123).
    #[test]
    fn philox_reproduces_the_published_known_answers() {
        assert_eq!(philox4x32_10([0; 4], [0; 2]), [0x6627_e8d5, 0xe169_c58d, 0xbc57_ac4c, 0x9b00_dbd8]);
        assert_eq!(philox4x32_10([u32::MAX; 4], [u32::MAX; 2]), [0x408f_276d, 0x41c8_3b0e, 0xa20b_c7c6, 0x6d54_51fd]);
        assert_eq!(
            philox4x32_10([0x243f_6a88, 0x85a3_08d3, 0x1319_8a2e, 0x0370_7344], [0xa409_3822, 0x299f_31d0]),
            [0xd16c_fe09, 0x94fd_cceb, 0x5001_e420, 0x2412_6ea1]
        );
    }

    /// The four standard errors of a sample of N normals: mean 1/√N, variance √(2/N), skewness
    /// √(6/N), kurtosis √(24/N).
    #[test]
    fn the_first_four_moments_are_those_of_a_standard_normal() {
        let n = 1_000_000u64;
        for seed in 0..3 {
            let stream = Stream::new(seed, "imu.gyro.z");
            let mut sums = [0.0; 4];
            for sample in 0..n {
                let x = stream.normal(sample);
                let powers = [x, x * x, x * x * x, x * x * x * x];
                sums.iter_mut().zip(powers).for_each(|(sum, power)| *sum += power);
            }
            let count = n as f64;
            let z = [
                sums[0] / count.sqrt(),
                (sums[1] / count - 1.0) / (2.0 / count).sqrt(),
                sums[2] / count / (15.0 / count).sqrt(), // third raw moment: variance E x⁶ = 15
                (sums[3] / count - 3.0) / (96.0 / count).sqrt(), // fourth: E x⁸ − 9 = 96
            ];
            // 4.5 sigma: 12 statistics, false alarm 8e-5 once and for all (fixed seeds)
            assert!(z.iter().all(|z| z.abs() < 4.5), "seed {seed}: z = {z:?}");
        }
    }

    #[test]
    fn the_cosine_of_turns_is_the_cosine() {
        for k in 0..100_000u32 {
            let turns = f64::from(k) / 1e5;
            // half a unit in the last place of 2πu, which is up to 8, moves the reference
            assert!((cosine_of_turns(turns) - libm::cos(core::f64::consts::TAU * turns)).abs() < 1e-15, "{turns}");
        }
        assert_eq!([0.0, 0.25, 0.5, 0.75].map(cosine_of_turns), [1.0, 0.0, -1.0, 0.0]);
        assert!(cosine_of_turns(1.0 - f64::EPSILON / 2.0) == 1.0);
    }

    #[test]
    fn tails_and_centre_hold_the_right_share() {
        let stream = Stream::new(11, "tails");
        let n = 1_000_000u64;
        // P(|x| > 1, 2, 3, 4)
        for (limit, probability) in
            [(1.0, 0.317_310_508), (2.0, 0.045_500_264), (3.0, 2.699_796e-3), (4.0, 6.334_248e-5)]
        {
            let beyond = (0..n).filter(|k| stream.normal(*k).abs() > limit).count() as f64;
            let expected = n as f64 * probability;
            // binomial standard deviation, 4.5 of them
            assert!(
                (beyond - expected).abs() < 4.5 * (expected * (1.0 - probability)).sqrt(),
                "|x| > {limit}: {beyond}"
            );
        }
    }

    #[test]
    fn streams_seeds_and_neighbouring_samples_are_uncorrelated() {
        let n = 200_000u64;
        let correlation = |f: &dyn Fn(u64) -> f64| (0..n).map(f).sum::<f64>() / (n as f64).sqrt();
        let gyro = Stream::new(5, "imu.gyro.z");
        let near_name = Stream::new(5, "imu.gyro.y");
        let near_seed = Stream::new(6, "imu.gyro.z");
        let z = [
            correlation(&|k| gyro.normal(k) * near_name.normal(k)),
            correlation(&|k| gyro.normal(k) * near_seed.normal(k)),
            correlation(&|k| gyro.normal(k) * gyro.normal(k + 1)),
            correlation(&|k| gyro.normal(k) * gyro.normal(k + (1 << 32))),
            correlation(&|k| (gyro.normal(k).powi(2) - 1.0) * (near_name.normal(k).powi(2) - 1.0) / 2.0),
        ];
        // each is standard normal under independence
        assert!(z.iter().all(|z| z.abs() < 4.5), "z = {z:?}");
    }

    #[test]
    fn a_sample_read_alone_equals_the_sample_read_in_sequence() {
        let sequence: Vec<f64> = (0..1000).map(|k| Stream::new(3, "a").normal(k)).collect();
        for k in (0..1000u64).rev() {
            assert_eq!(Stream::new(3, "a").normal(k).to_bits(), sequence[k as usize].to_bits());
        }
    }

    /// A change of generator, hash or transform changes every recorded digest; it must not happen
    /// unnoticed.
    #[test]
    fn the_stream_is_pinned_by_an_independent_computation() {
        // FNV-1a test vector of its authors: "foobar"
        assert_eq!(fnv1a(*b"foobar"), 0x8594_4171_f739_67e8);
        // uniform of the all-zero block above, from its published words
        let zero = Stream { seed: 0, name_hash: 0 };
        let [u_1, u_2] = zero.uniform_pair(0);
        assert_eq!(u_1, ((0xe169_c58d_6627_e8d5u64 >> 11) + 1) as f64 / 9_007_199_254_740_992.0);
        assert_eq!(u_2, (0x9b00_dbd8_bc57_ac4cu64 >> 11) as f64 / 9_007_199_254_740_992.0);
    }
}
