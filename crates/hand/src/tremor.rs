//! The tremor of a hand: sines of random phase, evenly spread over its band.

use std::f64::consts::TAU;

use chance::Chance;

/// Sines along each axis. So few repeat after a while, which is longer than a task.
const SINES: usize = 8;

/// A tremor along three axes.
#[derive(Debug, Clone, PartialEq)]
pub struct Tremor {
    /// Along each axis: frequencies in rad/s, and phases.
    sines: [[[f64; 2]; SINES]; 3],
    amplitude_mm: f64,
}

impl Tremor {
    /// Of this root mean square along each axis, mm, in a band, Hz.
    pub fn new(rms_mm: f64, [low, high]: [f64; 2], chance: Chance) -> Self {
        let sine = |axis: usize, k: usize| {
            let draw = 2 * (axis * SINES + k) as u64;
            // One in each part of the band: no two beat against each other for long.
            let hz = low + (high - low) * (k as f64 + chance.uniform(draw)) / SINES as f64;
            [TAU * hz, TAU * chance.uniform(draw + 1)]
        };
        Self {
            sines: std::array::from_fn(|axis| std::array::from_fn(|k| sine(axis, k))),
            // Each sine has half the square of its amplitude as its mean square.
            amplitude_mm: rms_mm * (2.0 / SINES as f64).sqrt(),
        }
    }

    /// What the hand is off by at a time, mm: twice across the tube, and along it.
    pub fn at(&self, t_s: f64) -> [f64; 3] {
        self.sines.map(|sines| {
            let sum: f64 = sines.iter().map(|[rate, phase]| (rate * t_s + phase).sin()).sum();
            self.amplitude_mm * sum
        })
    }
}
