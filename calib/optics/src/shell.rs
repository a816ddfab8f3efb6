//! A spherical marker in one slice of a CT: the detector for balls with a bore, on a foot, that fill their surroundings.
//!
//! The thesis's criterion (5.3) asks for one value inside and one around (5.2). A marker of plastic as large as a finger's
//! end has holes for its screw inside, stands on skin, and its outline is all that is a circle. So I is the wall: the ring
//! just inside the outline, E the ring just outside of it:
//!
//! ```text
//! I = { 0.8 r <= |x| <= 0.95 r },    E = { 1.05 r + 0.5 <= |x| <= 1.15 r + 2 }
//! chi = (mean(I) - mean(E)) / (deviation(I) + deviation(E) / 2 + 1 / sqrt(12))
//! ```
//!
//! The more of a patch's outline is that circle, the smaller both deviations are. Sums are exact, over the rows of integral
//! images, and what lies outside of the image does not count: some 10 r additions a pixel and radius. The shares of r are
//! the best of three sets that were tried on the patches of `cargo bench -p optics --bench bead_roc`, where the area under the
//! curve is 0.98 in either half of them, beside 0.51 of the criterion for discs.

use crate::image::{Image, Sums};

/// Shares of the radius at which I begins and ends, and E begins.
const WALL_RADII: [f64; 2] = [0.8, 0.95];
const AROUND_RADII: [f64; 2] = [1.05, 1.15];
/// Pixels by which E lies farther out, and by which it is wider, at the least.
const GAP_PX: f64 = 0.5;
const WIDTH_PX: f64 = 1.5;
/// The least share of E that must lie in the image.
const LEAST_WITHIN: f64 = 0.5;
/// Deviation of rounding to whole steps.
const ROUNDING_DEVIATION: f64 = 0.288_675_134_594_812_9;

/// The regions for one radius: each the difference of two discs, by the half widths of their rows.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Shell {
    wall: [Vec<isize>; 2],
    around: [Vec<isize>; 2],
    pixels: u64,
}

/// A radius that no shell can have, pixels.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("a shell's radius of {0} pixels; expected 3 to 200")]
pub struct BadRadius(pub f64);

/// Where a shell fits best.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fit {
    /// Column and row.
    pub at: [usize; 2],
    /// Of those that were tried, pixels.
    pub radius: f64,
    /// Positive where the wall is brighter than what is around.
    pub chi: f64,
}

/// Count, sum and sum of squares.
type Totals = [u64; 3];

impl Shell {
    /// For balls whose outline has this radius, pixels.
    ///
    /// # Errors
    /// [`BadRadius`] outside of 3 to 200.
    pub fn new(radius: f64) -> Result<Self, BadRadius> {
        if !(3.0..=200.0).contains(&radius) {
            return Err(BadRadius(radius));
        }
        let near = AROUND_RADII[0] * radius + GAP_PX;
        let far = near + ((AROUND_RADII[1] - AROUND_RADII[0]) * radius).max(WIDTH_PX);
        // The lesser disc ends before its radius: that belongs to the ring.
        let shell = |from: f64, to: f64| [disc(from - 1e-9), disc(to)];
        let around = shell(near, far);
        let pixels = |d: &Vec<isize>| d.iter().map(|w| (2 * w + 1).max(0) as u64).sum::<u64>();
        Ok(Self {
            wall: shell(WALL_RADII[0] * radius, WALL_RADII[1] * radius),
            pixels: pixels(&around[1]) - pixels(&around[0]),
            around,
        })
    }

    /// The criterion about a pixel; nothing where less than half of the outer ring is in the image.
    pub fn at(&self, sums: &Sums, x: usize, y: usize) -> Option<f64> {
        let [wall, around] = [&self.wall, &self.around].map(|ring| {
            let [hole, whole] = ring.each_ref().map(|disc| over(sums, disc, x, y));
            [0, 1, 2].map(|k| whole[k] - hole[k])
        });
        if wall[0] == 0 || (around[0] as f64) < LEAST_WITHIN * self.pixels as f64 {
            return None;
        }
        let ([inside, a], [outside, b]) = (moments(wall), moments(around));
        Some((inside - outside) / (a + 0.5 * b + ROUNDING_DEVIATION))
    }
}

/// The best of all radii and of all pixels within `near` pixels of the image's middle: for patches cut about what may be
/// a marker. `None` where no shell has room.
///
/// # Errors
/// [`BadRadius`].
pub fn best(image: &Image, radii: &[f64], near: f64) -> Result<Option<Fit>, BadRadius> {
    let sums = Sums::new(image);
    let middle = [image.width(), image.height()].map(|n| (n as f64 - 1.0) / 2.0);
    let mut best: Option<Fit> = None;
    for radius in radii {
        let shell = Shell::new(*radius)?;
        for y in 0..image.height() {
            for x in 0..image.width() {
                if (x as f64 - middle[0]).hypot(y as f64 - middle[1]) > near {
                    continue;
                }
                let chi = shell.at(&sums, x, y);
                if let Some(chi) = chi.filter(|c| best.is_none_or(|b| *c > b.chi)) {
                    best = Some(Fit {
                        at: [x, y],
                        radius: *radius,
                        chi,
                    });
                }
            }
        }
    }
    Ok(best)
}

/// Half widths of a disc's rows from the top one on.
fn disc(radius: f64) -> Vec<isize> {
    let reach = radius.floor() as isize;
    let half = |y: isize| (radius * radius - (y * y) as f64).max(0.0).sqrt().floor() as isize;
    (-reach..=reach).map(half).collect()
}

fn over(sums: &Sums, disc: &[isize], x: usize, y: usize) -> Totals {
    let (x, top) = (x as isize, y as isize - disc.len() as isize / 2);
    let rows = (top..).zip(disc);
    rows.fold([0; 3], |total, (y, half)| {
        let row = sums.over([x - half, x + half + 1], [y, y + 1]);
        [0, 1, 2].map(|k| total[k] + row[k])
    })
}

/// Mean and deviation; `n q - s^2` is exact in 128 bits.
fn moments([n, s, q]: Totals) -> [f64; 2] {
    let spread = u128::from(n) * u128::from(q) - u128::from(s) * u128::from(s);
    [s as f64 / n as f64, (spread as f64).sqrt() / n as f64]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A disc of 200 with a square bore on a ground of 20, on a foot of 200 below row 30.
    fn marker(width: usize, centre: [f64; 2], radius: f64) -> Image {
        let value = |i: usize| {
            let [x, y] = [i % width, i / width].map(|v| v as f64);
            let [dx, dy] = [x - centre[0], y - centre[1]];
            let bore = dx.abs() < 3.0 && dy.abs() < 3.0;
            if (dx.hypot(dy) <= radius && !bore) || y > 30.0 {
                200
            } else {
                20
            }
        };
        Image::new(width, width, (0..width * width).map(value).collect()).unwrap()
    }

    #[test]
    fn a_ball_with_a_bore_on_a_foot_is_found_with_its_radius() {
        for radius in [6.0, 8.0, 10.0, 12.0] {
            let image = marker(41, [20.0, 19.0], radius);
            let radii: Vec<f64> = (5..15).map(f64::from).collect();
            let fit = best(&image, &radii, 4.0).unwrap().unwrap();
            assert_eq!(fit.at, [20, 19], "{fit:?}");
            assert!((fit.radius - radius).abs() <= 1.0, "{fit:?}");
        }
    }

    #[test]
    fn sums_are_those_of_the_pixels_and_the_border_is_cut_off() {
        let samples: Vec<u16> = (0..41_u32 * 41).map(|i| (i * 7919 % 251) as u16).collect();
        let image = Image::new(41, 41, samples.clone()).unwrap();
        let sums = Sums::new(&image);
        let shell = Shell::new(9.0).unwrap();
        for [x, y] in [[20_usize, 20_usize], [8, 20], [14, 9], [33, 30]] {
            let ring = |from: f64, to: f64| -> Vec<f64> {
                let distance = |i: usize| ((i % 41) as f64 - x as f64).hypot((i / 41) as f64 - y as f64);
                let within = |i: &usize| (from..=to).contains(&distance(*i));
                (0..41 * 41).filter(within).map(|i| f64::from(samples[i])).collect()
            };
            let moments = |v: &Vec<f64>| {
                let mean = v.iter().sum::<f64>() / v.len() as f64;
                (
                    mean,
                    (v.iter().map(|s| (s - mean).powi(2)).sum::<f64>() / v.len() as f64).sqrt(),
                )
            };
            let ((a, da), (b, db)) = (moments(&ring(7.2, 8.55)), moments(&ring(9.95, 11.45)));
            let expected = (a - b) / (da + 0.5 * db + ROUNDING_DEVIATION);
            let found = shell.at(&sums, x, y).unwrap();
            assert!((found - expected).abs() < 1e-12, "{found} {expected}");
        }
        assert_eq!(shell.at(&sums, 0, 0), None);
    }

    #[test]
    fn what_is_no_shell_is_refused_and_an_even_image_has_no_contrast() {
        for radius in [f64::NAN, 2.9, 201.0, -5.0] {
            let refused = Shell::new(radius).unwrap_err();
            assert!(refused.to_string().contains("expected 3 to 200"), "{refused}");
        }
        let even = Image::new(36, 36, vec![255; 36 * 36]).unwrap();
        assert_eq!(best(&even, &[8.0], 4.0).unwrap().unwrap().chi, 0.0);
        let dot = Image::new(1, 1, vec![7]).unwrap();
        assert_eq!(best(&dot, &[8.0], 4.0).unwrap(), None);
    }
}
