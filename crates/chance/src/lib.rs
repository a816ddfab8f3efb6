//! Repeatable random numbers: a seed means the same patient, noise and order on every machine and with every compiler.
//!
//! All come from SplitMix64 (Steele, Lea and Flood, "Fast splittable pseudorandom number generators", OOPSLA 2014): as a
//! sequence, [`SplitMix64`], or without state, [`Chance`]. What these give for a seed never changes: generated patients and
//! recorded simulations are told by their seeds.

mod counted;

pub use counted::Chance;

/// A sequence of numbers.
#[derive(Debug, Clone)]
pub struct SplitMix64(u64);

impl SplitMix64 {
    /// The generator whose first state is `seed`.
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// The next 64 bits.
    pub fn bits(&mut self) -> u64 {
        let bits = mix(self.0);
        self.0 = self.0.wrapping_add(STEP);
        bits
    }

    /// A number drawn evenly from `middle - spread` to `middle + spread`.
    pub fn around(&mut self, middle: f64, spread: f64) -> f64 {
        // The upper 53 bits fill a double's mantissa: a fraction in 0..1 without rounding.
        let fraction = (self.bits() >> 11) as f64 / (1_u64 << 53) as f64;
        middle + spread * (2.0 * fraction - 1.0)
    }
}

/// From one state to the next.
const STEP: u64 = 0x9e37_79b9_7f4a_7c15;

/// A number in which every digit depends on every digit of `z`: the first that [`SplitMix64`] gives for it.
pub fn mix(z: u64) -> u64 {
    let z = z.wrapping_add(STEP);
    let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
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
        assert_eq!(mix(1_234_567), 6_457_827_717_110_365_317);
    }

    #[test]
    fn stays_within_the_spread() {
        let mut random = SplitMix64::new(7);
        assert!((0..1000).all(|_| (9.0..=11.0).contains(&random.around(10.0, 1.0))));
    }
}
