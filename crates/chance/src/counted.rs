//! Chance without state: each draw is a function of the seed, the sample's number and the draw's number.

use crate::mix;

/// A source of draws for one sample.
#[derive(Debug, Clone, Copy)]
pub struct Chance(u64);

impl Chance {
    /// For one sample of a seed.
    pub fn new(seed: u64, sample: u64) -> Self {
        Self(mix(mix(seed ^ 0x7472_6f63_6172).wrapping_add(sample)))
    }

    /// Uniform in (0, 1), 53 bits.
    pub fn uniform(self, draw: u64) -> f64 {
        let bits = mix(self.0 ^ mix(draw.wrapping_add(1))) >> 11;
        (bits as f64 + 0.5) / (1_u64 << 53) as f64
    }

    /// Normal with mean 0 and deviation 1 (Box and Muller, 1958).
    pub fn normal(self, draw: u64) -> f64 {
        let radius = (-2.0 * self.uniform(2 * draw).ln()).sqrt();
        radius * (std::f64::consts::TAU * self.uniform(2 * draw + 1)).cos()
    }
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

    /// Recorded simulations are told by their seeds: computed apart, in Python.
    #[test]
    fn draws_are_what_they_were() {
        let bits = |seed, sample, draw| (Chance::new(seed, sample).uniform(draw) * (1_u64 << 53) as f64) as u64;
        assert_eq!(bits(1, 2, 3), 6_518_221_953_016_822);
        assert_eq!(bits(0, 0, 0), 2_097_406_289_499_963);
        assert_eq!(bits(7, 100000, 41), 1_347_160_784_309_845);
    }
}
