//! Chance without state: each draw is a function of the seed, the sample's number and the draw's number.

/// A source of draws for one sample.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Chance(u64);

impl Chance {
    pub(crate) fn new(seed: u64, sample: u64) -> Self {
        Self(mix(mix(seed ^ 0x7472_6f63_6172).wrapping_add(sample)))
    }

    /// Uniform in (0, 1), 53 bits.
    pub(crate) fn uniform(self, draw: u64) -> f64 {
        let bits = mix(self.0 ^ mix(draw.wrapping_add(1))) >> 11;
        (bits as f64 + 0.5) / (1_u64 << 53) as f64
    }

    /// Normal with mean 0 and deviation 1 (Box and Muller, 1958).
    pub(crate) fn normal(self, draw: u64) -> f64 {
        let radius = (-2.0 * self.uniform(2 * draw).ln()).sqrt();
        radius * (std::f64::consts::TAU * self.uniform(2 * draw + 1)).cos()
    }
}

/// The finaliser of splitmix64 (Steele, Lea and Flood, 2014).
fn mix(mut z: u64) -> u64 {
    z = z.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_are_those_of_the_distributions() {
        let n = 100_000;
        let draws: Vec<f64> = (0..n).map(|i| Chance::new(1, i).normal(3)).collect();
        let mean = draws.iter().sum::<f64>() / n as f64;
        let variance = draws.iter().map(|x| x * x).sum::<f64>() / n as f64;
        // Five standard errors: 1/sqrt(n) and sqrt(2/n).
        assert!(mean.abs() < 5.0 / (n as f64).sqrt(), "{mean}");
        assert!((variance - 1.0).abs() < 5.0 * (2.0 / n as f64).sqrt(), "{variance}");
    }

    #[test]
    fn draws_repeat_and_differ() {
        assert_eq!(Chance::new(1, 2).uniform(3), Chance::new(1, 2).uniform(3));
        assert_ne!(Chance::new(1, 2).uniform(3), Chance::new(2, 2).uniform(3));
        assert_ne!(Chance::new(1, 2).uniform(3), Chance::new(1, 3).uniform(3));
        assert_ne!(Chance::new(1, 2).uniform(3), Chance::new(1, 2).uniform(4));
    }
}
