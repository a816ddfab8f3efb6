//! How far apart two colours are for people with and without colour blindness: colour differences by CIEDE2000 (Sharma, Wu and Dalal
//! 2005) of colours as Machado, Oliveira and Fernandes (2009) say that a dichromat sees them.
//!
//! For palettes: nothing that is drawn asks it.

use crate::Rgb;

/// Linear RGB as a protanope, a deuteranope and a tritanope see it (Machado et al. 2009, table 1, severity 1).
const BLIND: [[[f64; 3]; 3]; 3] = [
    [
        [0.152_286, 1.052_583, -0.204_868],
        [0.114_503, 0.786_281, 0.099_216],
        [-0.003_882, -0.048_116, 1.051_998],
    ],
    [
        [0.367_322, 0.860_646, -0.227_968],
        [0.280_085, 0.672_501, 0.047_413],
        [-0.011_820, 0.042_940, 0.968_881],
    ],
    [
        [1.255_528, -0.076_749, -0.178_779],
        [-0.078_411, 0.930_809, 0.147_602],
        [0.004_733, 0.691_367, 0.303_900],
    ],
];
const NORMAL: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
/// sRGB to XYZ over the white of D65.
const XYZ: [[f64; 3]; 3] = [
    [0.412_456_4 / 0.950_47, 0.357_576_1 / 0.950_47, 0.180_437_5 / 0.950_47],
    [0.212_672_9, 0.715_152_2, 0.072_175],
    [0.019_333_9 / 1.088_83, 0.119_192 / 1.088_83, 0.950_304_1 / 1.088_83],
];

/// How far apart two colours are for whom they are least so: people who see all colours, protanopes, deuteranopes and tritanopes.
/// CIEDE2000 with all weights 1; 2.3 is just noticed side by side.
pub fn least_difference(a: Rgb, b: Rgb) -> f64 {
    let seen = BLIND.iter().chain([&NORMAL]);
    seen.map(|vision| difference(lab(a, vision), lab(b, vision)))
        .fold(f64::INFINITY, f64::min)
}

fn times(m: &[[f64; 3]; 3], v: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| (0..3).map(|j| m[i][j] * v[j]).sum())
}

/// L*, a*, b* of a colour seen through `vision`.
fn lab(Rgb(r, g, b): Rgb, vision: &[[f64; 3]; 3]) -> [f64; 3] {
    let linear = [r, g, b].map(|c| match f64::from(c) / 255.0 {
        c if c <= 0.04045 => c / 12.92,
        c => ((c + 0.055) / 1.055).powf(2.4),
    });
    let seen = times(vision, linear).map(|c| c.clamp(0.0, 1.0));
    let [x, y, z] = times(&XYZ, seen).map(|t| match t {
        t if t > (6.0_f64 / 29.0).powi(3) => t.cbrt(),
        t => t / (3.0 * (6.0_f64 / 29.0).powi(2)) + 4.0 / 29.0,
    });
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// CIEDE2000 with all weights 1.
fn difference([l1, a1, b1]: [f64; 3], [l2, a2, b2]: [f64; 3]) -> f64 {
    let seventh = |c: f64| (c.powi(7) / (c.powi(7) + 25_f64.powi(7))).sqrt();
    let g = 0.5 * (1.0 - seventh((a1.hypot(b1) + a2.hypot(b2)) / 2.0));
    let [(c1, h1), (c2, h2)] = [(a1, b1), (a2, b2)].map(|(a, b)| {
        let a = (1.0 + g) * a;
        (a.hypot(b), b.atan2(a).to_degrees().rem_euclid(360.0))
    });
    let turn = match h2 - h1 {
        _ if c1 * c2 == 0.0 => 0.0,
        d if d > 180.0 => d - 360.0,
        d if d < -180.0 => d + 360.0,
        d => d,
    };
    let mean_h = match h1 + h2 {
        s if c1 * c2 == 0.0 => s,
        s if (h1 - h2).abs() <= 180.0 => s / 2.0,
        s if s < 360.0 => (s + 360.0) / 2.0,
        s => (s - 360.0) / 2.0,
    };
    let (mean_l, mean_c) = ((l1 + l2) / 2.0, (c1 + c2) / 2.0);
    let cosine = |degrees: f64| degrees.to_radians().cos();
    let t = 1.0 - 0.17 * cosine(mean_h - 30.0) + 0.24 * cosine(2.0 * mean_h) + 0.32 * cosine(3.0 * mean_h + 6.0)
        - 0.20 * cosine(4.0 * mean_h - 63.0);
    let from_middle = (mean_l - 50.0).powi(2);
    let l = (l2 - l1) / (1.0 + 0.015 * from_middle / (20.0 + from_middle).sqrt());
    let c = (c2 - c1) / (1.0 + 0.045 * mean_c);
    let h = 2.0 * (c1 * c2).sqrt() * (turn / 2.0).to_radians().sin() / (1.0 + 0.015 * mean_c * t);
    let theta = 60.0 * (-((mean_h - 275.0) / 25.0).powi(2)).exp();
    let rotation = -seventh(mean_c) * theta.to_radians().sin();
    (l * l + c * c + h * h + 2.0 * rotation * c * h).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pairs 1, 7 and 17 of Sharma's test data.
    #[test]
    fn differences_are_those_of_the_published_test_data() {
        for (a, b, expected) in [
            ([50.0, 2.6772, -79.7751], [50.0, 0.0, -82.7485], 2.0425),
            ([50.0, 0.0, 0.0], [50.0, -1.0, 2.0], 2.3669),
            ([50.0, 2.5, 0.0], [73.0, 25.0, -18.0], 27.1492),
        ] {
            assert!((difference(a, b) - expected).abs() < 1e-4, "{}", difference(a, b));
        }
    }
}
