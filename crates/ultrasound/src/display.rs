//! From power on the grid to grey on the screen.

use chance::mix;

use crate::fan::Fan;
use crate::settings::Settings;
use crate::tissue::amplitude;

/// Time-gain raises noise by at most this, dB.
const MOST_GAIN_DB: f64 = 30.0;

/// Where each pixel's value comes from.
#[derive(Debug, Clone)]
pub(crate) struct Display {
    pixels: Vec<Pixel>,
    /// Power of noise by sample.
    noise: Vec<f32>,
    range_db: f32,
    gain_db: f32,
    grey: Vec<f32>,
}

/// The node above and to the left, and the shares of the ways to the next ones; outside of the beams none.
#[derive(Debug, Clone, Copy)]
struct Pixel {
    node: u32,
    shares: [f32; 2],
}

const OUTSIDE: u32 = u32::MAX;

impl Display {
    /// `loss` is what soft tissue takes, dB a mm to and fro.
    pub(crate) fn new(fan: &Fan, settings: &Settings, loss: f64) -> Self {
        let shape = &fan.shape;
        let pixel = |index: usize| {
            let pixel = [index % shape.columns(), index / shape.columns()].map(|part| part as f64);
            let Some(beam) = shape.beam_at(shape.place_mm(pixel)) else {
                let shares = [0.0; 2];
                return Pixel { node: OUTSIDE, shares };
            };
            let (across, along) = (beam.share * (fan.beams - 1) as f64, beam.depth_mm / fan.step_mm);
            let (b, n) = (
                (across as usize).min(fan.beams - 2),
                (along as usize).min(fan.samples - 2),
            );
            Pixel {
                node: (n * fan.beams + b) as u32,
                shares: [(across - b as f64) as f32, (along - n as f64) as f32],
            }
        };
        let noise = (0..fan.samples).map(|sample| {
            let gained = (loss * fan.shown_mm(sample)).min(MOST_GAIN_DB);
            amplitude(settings.noise_db + gained).powi(2) as f32
        });
        Self {
            pixels: (0..shape.columns() * shape.rows()).map(pixel).collect(),
            noise: noise.collect(),
            range_db: settings.range_db as f32,
            gain_db: settings.gain_db as f32,
            grey: vec![0.0; fan.beams * fan.samples],
        }
    }

    /// Adds noise of image `number`, compresses, and fills the pixels.
    pub(crate) fn show(&mut self, power: &[f32], number: u64, beams: usize, out: &mut [u8]) {
        let seed = mix(number ^ 0x006e_6f69_7365);
        let rows = power.chunks_exact(beams).zip(self.grey.chunks_exact_mut(beams));
        let scale = 255.0 / self.range_db;
        // 10 log10 x = 3.0103 log2 x.
        let (steep, start) = (3.010_3 * scale, self.gain_db * scale);
        for (sample, ((power, grey), noise)) in rows.zip(&self.noise).enumerate() {
            let row = seed.wrapping_add((sample * beams) as u64);
            for (beam, (power, grey)) in power.iter().zip(grey).enumerate() {
                // Exponential, as the power of a complex normal number is, from 16 bits.
                let even = ((mix(row.wrapping_add(beam as u64)) >> 48) as f32 + 0.5) / 65536.0;
                let all = power - noise * std::f32::consts::LN_2 * log2(even);
                *grey = (steep * log2(all.max(1e-30)) + start).clamp(0.0, 255.0);
            }
        }
        for (out, pixel) in out.iter_mut().zip(&self.pixels) {
            *out = match pixel.node {
                OUTSIDE => 0,
                node => {
                    let [a, b] = [node as usize, node as usize + beams].map(|at| {
                        let pair = &self.grey[at..at + 2];
                        pair[0] + pixel.shares[0] * (pair[1] - pair[0])
                    });
                    (a + pixel.shares[1] * (b - a) + 0.5) as u8
                }
            };
        }
    }
}

/// The binary logarithm of a positive normal number, to 0.0002: a thousandth of a grey value is more than a screen shows.
///
/// Of its own, so that it is the same on every machine.
fn log2(x: f32) -> f32 {
    let bits = x.to_bits();
    let exponent = (bits >> 23) as i32 - 127;
    let mantissa = f32::from_bits((bits & 0x007f_ffff) | 0x3f80_0000);
    // With s = (m - r) / (m + r), r = sqrt 2: ln m = ln r + 2 (s + s^3 / 3 + s^5 / 5 + ...), and |s| <= 0.172.
    let s = (mantissa - std::f32::consts::SQRT_2) / (mantissa + std::f32::consts::SQRT_2);
    let square = s * s;
    let series = s * (1.0 + square * (1.0 / 3.0 + square * 0.2));
    exponent as f32 + 0.5 + 2.0 * std::f32::consts::LOG2_E * series
}

#[cfg(test)]
mod tests {
    #[test]
    fn logarithms_are_those_of_the_library() {
        for i in 1..200_000 {
            let x = i as f32 * 1e-3 + 1e-20;
            assert!((super::log2(x) - x.log2()).abs() < 2e-4, "{x}");
        }
    }
}
