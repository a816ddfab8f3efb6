//! Ways of the tube: in, held, aside, back and out, at a speed.

use nalgebra::Vector3;

/// Poses a second.
pub(crate) const RATE: f64 = 60.0;

/// Where the foremost point is: so far from the entry, and moved across the way, mm.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Place {
    pub(crate) phase: &'static str,
    pub(crate) gone: f64,
    pub(crate) aside: [f64; 2],
}

/// Numbers in -1..1 that look random: the same each run.
pub(crate) struct Noise(pub(crate) u64);

impl Noise {
    pub(crate) fn next(&mut self) -> f64 {
        // A linear congruential generator with Knuth's constants; its upper bits.
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    /// Three of them, times this.
    pub(crate) fn vector(&mut self, size: f64) -> Vector3<f64> {
        Vector3::new(self.next(), self.next(), self.next()) * size
    }
}

/// From one place to another in equal parts, without the first.
fn line(phase: &'static str, from: (f64, [f64; 2]), to: (f64, [f64; 2]), step: f64) -> Vec<Place> {
    let d = [to.0 - from.0, to.1[0] - from.1[0], to.1[1] - from.1[1]];
    let count = (d.iter().map(|x| x * x).sum::<f64>().sqrt() / step).ceil().max(1.0);
    (1..=count as usize)
        .map(|k| {
            let t = k as f64 / count;
            Place {
                phase,
                gone: from.0 + t * d[0],
                aside: [from.1[0] + t * d[1], from.1[1] + t * d[2]],
            }
        })
        .collect()
}

/// In by `depth` from `touch`, held for half a second, aside by `across` both ways, forth and back a little, and out.
pub(crate) fn stroke(touch: f64, depth: f64, across: f64, angle: f64, speed: f64) -> Vec<Place> {
    let step = speed / RATE;
    let (free, deep) = ((touch - 3.0, [0.0; 2]), (touch + depth, [0.0; 2]));
    let side = |sign: f64| (deep.0, [sign * across * angle.cos(), sign * across * angle.sin()]);
    let half = (touch + 0.5 * depth, [0.0; 2]);
    let mut places = line("press", free, deep, step);
    places.extend((0..30).map(|_| Place {
        phase: "hold",
        gone: deep.0,
        aside: deep.1,
    }));
    places.extend(line("slide", deep, side(1.0), step));
    places.extend(line("slide", side(1.0), side(-1.0), step));
    places.extend(line("slide", side(-1.0), deep, step));
    places.extend(line("along", deep, half, step));
    places.extend(line("along", half, deep, step));
    places.extend(line("out", deep, free, step));
    places
}
