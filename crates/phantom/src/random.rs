//! A tiny repeatable generator, so that a seed means the same patient on every machine and with every compiler.

/// SplitMix64: Steele, Lea and Flood, "Fast splittable pseudorandom number generators", OOPSLA 2014.
#[derive(Debug, Clone)]
pub(crate) struct SplitMix64(u64);

impl SplitMix64 {
    /// The generator whose first state is `seed`.
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// The next 64 bits.
    pub(crate) fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// A number drawn evenly from `middle - spread` to `middle + spread`.
    pub(crate) fn around(&mut self, middle: f64, spread: f64) -> f64 {
        // The upper 53 bits fill a double's mantissa: a fraction in 0..1 without rounding.
        let fraction = (self.bits() >> 11) as f64 / (1_u64 << 53) as f64;
        middle + spread * (2.0 * fraction - 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gives_the_published_sequence() {
        // From the reference implementation, seed 1234567.
        let mut random = SplitMix64::new(1_234_567);
        assert_eq!(random.bits(), 6_457_827_717_110_365_317);
        assert_eq!(random.bits(), 3_203_168_211_198_807_973);
    }

    #[test]
    fn stays_within_the_spread() {
        let mut random = SplitMix64::new(7);
        assert!((0..1000).all(|_| (9.0..=11.0).contains(&random.around(10.0, 1.0))));
    }
}
