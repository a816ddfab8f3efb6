//! Echoes on the grid of beams and samples, before and after the blur of pulse and beam.

use crate::fan::Fan;

/// How far a Gaussian is followed, deviations.
const FOLLOWED: f64 = 2.6;

/// Row by row: one sample of all beams after another.
#[derive(Debug)]
pub(crate) struct Field {
    beams: usize,
    samples: usize,
    step_mm: f64,
    /// Two looks, each real and imaginary.
    pub(crate) speckle: Vec<[f32; 4]>,
    /// What mirrors: amplitudes without phase, for smooth layers of any tilt.
    pub(crate) lines: Vec<f32>,
    spare: Vec<[f32; 4]>,
    spare_lines: Vec<f32>,
}

/// Gaussians of pulse and beams.
#[derive(Debug, Clone)]
pub(crate) struct Kernels {
    /// By sample; the middle first; the sum of squares of a whole kernel is 1.
    lateral: Vec<Vec<f32>>,
    axial: Vec<f32>,
    /// By sample: makes a line of amplitude 1 across all beams 1 high.
    line: Vec<f32>,
}

impl Kernels {
    pub(crate) fn new(fan: &Fan) -> Self {
        let axial = kernel(fan.pulse);
        let lateral: Vec<_> = (0..fan.samples)
            .map(|sample| kernel(fan.lateral_beams(fan.shown_mm(sample))))
            .collect();
        let line = lateral
            .iter()
            .map(|kernel| 1.0 / (2.0 * kernel.iter().sum::<f32>() - kernel[0]) / axial[0])
            .collect();
        Self { lateral, axial, line }
    }

    /// What a node of speckle of amplitude 1 is worth after the blur.
    pub(crate) fn peak(&self) -> f32 {
        self.axial[0]
    }
}

fn kernel(deviation: f64) -> Vec<f32> {
    let half = (FOLLOWED * deviation).ceil() as usize;
    let values: Vec<f64> = (0..=half)
        .map(|i| (-0.5 * (i as f64 / deviation).powi(2)).exp())
        .collect();
    let squares: f64 = 2.0 * values.iter().map(|value| value * value).sum::<f64>() - 1.0;
    values.iter().map(|value| (value / squares.sqrt()) as f32).collect()
}

impl Field {
    pub(crate) fn new(fan: &Fan) -> Self {
        let nodes = fan.beams * fan.samples;
        Self {
            beams: fan.beams,
            samples: fan.samples,
            step_mm: fan.step_mm,
            speckle: vec![[0.0; 4]; nodes],
            lines: vec![0.0; nodes],
            spare: vec![[0.0; 4]; nodes],
            spare_lines: vec![0.0; nodes],
        }
    }

    pub(crate) fn clear(&mut self) {
        self.speckle.fill([0.0; 4]);
        self.lines.fill(0.0);
    }

    pub(crate) fn speckle_at(&mut self, beam: usize, sample: usize) -> &mut [f32; 4] {
        &mut self.speckle[sample * self.beams + beam]
    }

    /// Adds a mirroring place of a beam between its samples; outside it is nothing.
    pub(crate) fn line(&mut self, beam: usize, shown: f64, amplitude: f32) {
        let sample = shown / self.step_mm;
        if !(sample >= 0.0 && sample <= (self.samples - 1) as f64) {
            return;
        }
        let first = (sample as usize).min(self.samples - 2);
        let share = (sample - first as f64) as f32;
        self.lines[first * self.beams + beam] += amplitude * (1.0 - share);
        self.lines[(first + 1) * self.beams + beam] += amplitude * share;
    }

    /// Adds a rough place: its echo has a phase of its own, four normal numbers.
    pub(crate) fn rough(&mut self, beam: usize, shown: f64, echo: [f32; 4]) {
        let sample = shown / self.step_mm + 0.5;
        if sample >= 0.0 && sample < self.samples as f64 {
            let node = self.speckle_at(beam, sample as usize);
            for (into, part) in node.iter_mut().zip(echo) {
                *into += part;
            }
        }
    }

    /// The blur along rows: the beam.
    pub(crate) fn blur_beams(&mut self, kernels: &Kernels) {
        let rows = self
            .speckle
            .chunks_exact(self.beams)
            .zip(self.lines.chunks_exact(self.beams));
        let spare = self.spare.chunks_exact_mut(self.beams);
        let spare = spare.zip(self.spare_lines.chunks_exact_mut(self.beams));
        for (((from, lines), (into, into_lines)), kernel) in rows.zip(spare).zip(&kernels.lateral) {
            blur_row(from.as_flattened(), into.as_flattened_mut(), kernel, 4);
            // Most rows hold no line.
            match lines.iter().any(|&value| value != 0.0) {
                true => blur_row(lines, into_lines, kernel, 1),
                false => into_lines.fill(0.0),
            }
        }
        std::mem::swap(&mut self.speckle, &mut self.spare);
        std::mem::swap(&mut self.lines, &mut self.spare_lines);
    }

    /// The blur along beams, the pulse; then the square of the amplitude at each node.
    pub(crate) fn power(&mut self, kernels: &Kernels, looks: f32) -> &[f32] {
        let (beams, samples) = (self.beams, self.samples);
        let half = kernels.axial.len() - 1;
        let mut sum = vec![[0.0_f32; 4]; beams];
        let mut line = vec![0.0_f32; beams];
        for sample in 0..samples {
            sum.fill([0.0; 4]);
            line.fill(0.0);
            for other in sample.saturating_sub(half)..(sample + half + 1).min(samples) {
                let weight = kernels.axial[other.abs_diff(sample)];
                let from = &self.speckle[other * beams..][..beams];
                add(sum.as_flattened_mut(), from.as_flattened(), weight);
                add(&mut line, &self.lines[other * beams..][..beams], weight);
            }
            let height = kernels.line[sample];
            let out = &mut self.spare_lines[sample * beams..][..beams];
            for ((out, sum), line) in out.iter_mut().zip(&sum).zip(&line) {
                let speckle = sum[0] * sum[0] + sum[1] * sum[1] + (looks - 1.0) * (sum[2] * sum[2] + sum[3] * sum[3]);
                *out = speckle / looks + (line * height).powi(2);
            }
        }
        if looks > 1.0 {
            self.smooth(kernels);
        }
        &self.spare_lines
    }

    /// The mean power of neighbouring beams, about as wide as the beam: what scanners call speckle reduction.
    fn smooth(&mut self, kernels: &Kernels) {
        let rows = self.spare_lines.chunks_exact_mut(self.beams).zip(&kernels.lateral);
        for (row, kernel) in rows {
            // The kernel is 2.6 deviations long; a box of this half width is about as wide as the beam.
            let half = kernel.len() / 3;
            let mut sums = vec![0.0_f64; self.beams + 1];
            for (at, value) in row.iter().enumerate() {
                sums[at + 1] = sums[at] + f64::from(*value);
            }
            for (at, value) in row.iter_mut().enumerate() {
                let (from, to) = (at.saturating_sub(half), (at + half + 1).min(self.beams));
                *value = ((sums[to] - sums[from]) / (to - from) as f64) as f32;
            }
        }
    }
}

fn add(into: &mut [f32], from: &[f32], weight: f32) {
    for (into, from) in into.iter_mut().zip(from) {
        *into += weight * from;
    }
}

/// Beams beyond the outermost are silent: there, a scanner's aperture ends too.
fn blur_row(from: &[f32], into: &mut [f32], kernel: &[f32], channels: usize) {
    let long = from.len();
    for (into, from) in into.iter_mut().zip(from) {
        *into = kernel[0] * from;
    }
    for (off, &weight) in kernel.iter().enumerate().skip(1) {
        let off = off * channels;
        if off >= long {
            break;
        }
        add(&mut into[off..], &from[..long - off], weight);
        add(&mut into[..long - off], &from[off..], weight);
    }
}
