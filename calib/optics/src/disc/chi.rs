//! The criterion of the thesis for a disc at a pixel (5.3): contrast of inside and ring by their deviations.

use super::error::DetectRefused;
use super::region::Region;
use crate::image::Sums;

/// The deviation of rounding to whole steps: what keeps the criterion finite in uniform regions.
pub(super) const ROUNDING: f64 = 0.288_675_134_594_812_9;

/// The inside and the ring that a pixel is judged by.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Probe {
    inside: Region,
    hole: Region,
    whole: Region,
}

/// What a probe finds at a pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Chi {
    /// `(mean of the ring - mean inside) / (deviation inside + half the ring's + 1/sqrt(12))`: positive for dark discs.
    ///
    /// The last term, the deviation of rounding to whole grey levels, is not the thesis's: it gives uniform regions a
    /// value, where 5.3 divides by zero, and is nothing beside real noise.
    pub value: f64,
    /// The same difference beside its standard error (Welch): comparable between probes of different radius.
    pub significance: f64,
    /// Means inside and in the ring, grey levels.
    pub means: [f64; 2],
}

impl Probe {
    /// The thesis's regions (5.2): inside up to `rmin`, the ring from `rmax` to `rmax + e`, pixels.
    ///
    /// # Errors
    /// [`DetectRefused::BadRadii`] and [`DetectRefused::BadRing`].
    pub fn new(rmin: f64, rmax: f64, e: f64) -> Result<Self, DetectRefused> {
        if !(rmin >= 0.0 && rmin < rmax && rmax <= 400.0) {
            return Err(DetectRefused::BadRadii {
                least: rmin,
                greatest: rmax,
            });
        }
        if !(1.0..=100.0).contains(&e) {
            return Err(DetectRefused::BadRing { found: e });
        }
        Ok(Self {
            inside: Region::disc(rmin),
            // The ring begins at rmax itself.
            hole: Region::disc(rmax - 1e-9),
            whole: Region::disc(rmax + e),
        })
    }

    /// The probe for discs whose radius is about `radius` pixels: inside to 0.7, the ring from 1.25 radii and a pixel on.
    pub(crate) fn about(radius: f64) -> Result<Self, DetectRefused> {
        let rmax = 1.25 * radius + 1.0;
        Self::new(0.7 * radius, rmax, (0.35 * radius).max(1.5))
    }

    /// The criterion at a pixel; nothing where the ring lies outside the image.
    #[inline]
    pub fn at(&self, sums: &Sums, x: usize, y: usize) -> Option<Chi> {
        let [n, s, q] = self.inside.over(sums, x, y);
        let (hole, whole) = (self.hole.over(sums, x, y), self.whole.over(sums, x, y));
        let [m, t, u] = [0, 1, 2].map(|k| whole[k] - hole[k]);
        // Half of the ring is enough: at the border the other half is cut off (5.1 extended).
        if n == 0 || 2 * m < (self.whole.pixels() - self.hole.pixels()) as u64 {
            return None;
        }
        let ([inside, a], [ring, b]) = (moments(n, s, q), moments(m, t, u));
        let difference = ring - inside;
        let error = ((a + ROUNDING * ROUNDING) / n as f64 + (b + ROUNDING * ROUNDING) / m as f64).sqrt();
        Some(Chi {
            value: difference / (a.sqrt() + 0.5 * b.sqrt() + ROUNDING),
            significance: difference / error,
            means: [inside, ring],
        })
    }

    /// The radius of a disc here by the light it takes away: the sum of `(ring - sample) / (ring - inside)` up to the
    /// ring is its area.
    pub(crate) fn radius(&self, sums: &Sums, x: usize, y: usize, chi: &Chi) -> f64 {
        let [n, s, _] = self.hole.over(sums, x, y);
        let [inside, ring] = chi.means;
        let area = (n as f64 * ring - s as f64) / (ring - inside);
        (area.max(0.0) / std::f64::consts::PI).sqrt()
    }
}

/// Mean and variance from exact sums of at most 2^26 samples of 16 bits.
fn moments(n: u64, s: u64, q: u64) -> [f64; 2] {
    // n q - s^2 is exact in 128 bits, where one pass in floating point cancels.
    let spread = u128::from(n) * u128::from(q) - u128::from(s) * u128::from(s);
    let n = n as f64;
    [s as f64 / n, spread as f64 / (n * n)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Image;

    fn chi(samples: Vec<u16>, width: usize) -> Option<Chi> {
        let image = Image::new(width, samples.len() / width, samples).unwrap();
        let probe = Probe::new(1.0, 3.0, 2.0).unwrap();
        probe.at(&Sums::new(&image), width / 2, image.height() / 2)
    }

    #[test]
    fn uniform_regions_have_a_value() {
        assert_eq!(chi(vec![1234; 121], 11).unwrap().value, 0.0);
        let step = |i: usize| {
            if (i % 11).abs_diff(5) + (i / 11).abs_diff(5) <= 2 {
                40
            } else {
                50
            }
        };
        let found = chi((0..121).map(step).collect(), 11).unwrap();
        // Both deviations are 0: ten steps by the deviation of rounding.
        assert!((found.value - 10.0 / ROUNDING).abs() < 1e-12, "{found:?}");
        assert_eq!(found.means, [40.0, 50.0]);
    }

    #[test]
    fn chi_is_that_of_5_3_computed_in_two_passes() {
        let samples: Vec<u16> = (0..441_u32).map(|i| (3000 + i * 37 % 11) as u16).collect();
        let image = Image::new(21, 21, samples).unwrap();
        let found = Probe::new(3.0, 5.0, 3.0)
            .unwrap()
            .at(&Sums::new(&image), 10, 10)
            .unwrap();
        let collect = |low: f64, high: f64| {
            let places = (0..441_usize).filter(|i| {
                let r = (((i % 21) as f64 - 10.0).powi(2) + ((i / 21) as f64 - 10.0).powi(2)).sqrt();
                (low..=high).contains(&r)
            });
            places.map(|i| f64::from(image.samples()[i])).collect::<Vec<f64>>()
        };
        let both = |v: Vec<f64>| {
            let mean = v.iter().sum::<f64>() / v.len() as f64;
            [
                mean,
                (v.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / v.len() as f64).sqrt(),
            ]
        };
        // At these radii the regions are exact: radius 8 has six widths, of which the ring's outermost are joined.
        let [mi, si] = both(collect(0.0, 3.0));
        assert!((found.means[0] - mi).abs() < 1e-9);
        let [me, se] = both(collect(5.0, 8.0));
        assert!((found.means[1] - me).abs() < 0.3, "{} {me}", found.means[1]);
        let known = (me - mi) / (si + 0.5 * se + ROUNDING);
        assert!((found.value - known).abs() < 0.1, "{} {known}", found.value);
    }

    #[test]
    fn what_cannot_be_a_probe_is_refused() {
        assert!(
            Probe::new(3.0, 2.0, 1.0)
                .unwrap_err()
                .to_string()
                .contains("radii from 3 to 2")
        );
        assert!(Probe::new(1.0, 2.0, f64::NAN).unwrap_err().to_string().contains("NaN"));
        assert!(chi(vec![5; 4], 2).is_none() || chi(vec![5; 4], 2).unwrap().value == 0.0);
    }
}
