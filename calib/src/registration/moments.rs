//! The first and second moments of two paired clouds, in two passes.

use std::ops::Range;

use geometry::Point;
use nalgebra::{Matrix3, Vector3};

use super::pairs::coordinates;
use super::{Pairs, Refused};

/// Sums of squares outside this range are formed again from coordinates scaled by a power of two.
// `normalised` multiplies both energies: within this range the product is within 1e-200..1e200, a normal number.
const SAFE_SQUARES: std::ops::RangeInclusive<f64> = 1e-100..=1e100;
/// Pairs summed one after the other.
// A body of emitters (at most 32, `pose::MAX_EMITTERS`) is one block, and its sum needs no recursion.
const BLOCK_PAIRS: usize = 64;
/// A cloud whose radius is below this many units in the last place of its centre is one point.
const RESOLUTION: f64 = 8.0 * f64::EPSILON;

/// Centres, correlation matrix and mean squared radii of paired clouds (thesis, 4.4, 4.10).
///
/// The one-pass forms printed in 4.9 and 4.10 cancel: at an offset of 1e8 radii every digit is gone. Here the clouds
/// are centred first, and what the rounded centres leave over is taken off the second moments, so that the offset costs
/// nothing beyond the rounding of the coordinates themselves.
#[derive(Debug, Clone, Copy)]
pub struct Moments {
    /// Rounded centres in `To` and in `From`, mm.
    pub(crate) centre: [Vector3<f64>; 2],
    /// What the rounded centres lack, mm.
    pub(crate) rest: [Vector3<f64>; 2],
    /// Powers of two by which each cloud was multiplied before `psi` and `energy` were formed.
    pub(crate) scale: [f64; 2],
    /// Mean of `a'_i b'_i^T` (4.10), scaled.
    pub(crate) psi: Matrix3<f64>,
    /// Mean squared radii, traces of A and B of 4.9, scaled.
    pub(crate) energy: [f64; 2],
}

impl Moments {
    /// The moments of `pairs`. Two passes, no allocation.
    ///
    /// Domain: coordinates from 1e-300 to 1e300 in size; a cloud may be as small as 1e-15 of its distance to the
    /// origin.
    ///
    /// # Errors
    /// [`Refused::NotFinite`], [`Refused::BadWeight`], [`Refused::NoWeight`], [`Refused::TooFew`],
    /// [`Refused::Coincident`].
    #[inline]
    pub fn of<To, From>(pairs: Pairs<'_, To, From>) -> Result<Self, Refused> {
        let moments = match pairs.weights {
            None => sums(pairs, |v| v, |v| v, |_| 1.0),
            // A negative weight leaves no trace in the sums, so weights are checked before and not where a sum is
            // spoilt.
            Some(_) => {
                pairs.check()?;
                sums(pairs, |v| v, |v| v, |i| pairs.weight(i))
            }
        };
        // A NaN or an infinity fails this comparison too.
        let safe = pairs.len() >= 3 && moments.energy.iter().all(|e| SAFE_SQUARES.contains(e));
        let moments = if safe { moments } else { rescaled(pairs)? };
        moments.spread_out()?;
        Ok(moments)
    }

    #[inline]
    fn spread_out(&self) -> Result<(), Refused> {
        let floor = |i: usize| (self.centre[i] * self.scale[i]).norm_squared() * (RESOLUTION * RESOLUTION);
        // A NaN fails this comparison, and is refused.
        if self.energy[0] > floor(0) && self.energy[1] > floor(1) {
            return Ok(());
        }
        // What `finish` takes off may leave an energy below zero by rounding.
        let radius = |i: usize| self.energy[i].max(0.0).sqrt() / self.scale[i];
        Err(Refused::Coincident {
            radius_mm: radius(0).min(radius(1)),
        })
    }

    /// The refined centre of cloud 0 (`To`) or 1 (`From`), mm.
    pub(crate) fn mean(&self, cloud: usize) -> Vector3<f64> {
        self.centre[cloud] + self.rest[cloud]
    }

    /// A point of cloud 0 (`To`) or 1 (`From`) relative to its centre, mm; exact where the cloud is far from the
    /// origin.
    pub(crate) fn centred<F>(&self, cloud: usize, p: Point<F>) -> Vector3<f64> {
        // The large numbers first: their difference is exact where both are within a factor of two (Sterbenz).
        (coordinates(p) - self.centre[cloud]) - self.rest[cloud]
    }

    /// `psi` times a power of two that brings `root` near 1, and `root = sqrt(energy_0 energy_1)` likewise.
    ///
    /// By Cauchy and Schwarz `root` bounds the correlation coefficient (4.8), for clouds of different scale too.
    #[inline]
    pub(crate) fn normalised(&self) -> (Matrix3<f64>, f64) {
        let root = (self.energy[0] * self.energy[1]).sqrt();
        let s = reciprocal_power(root);
        (self.psi * s, root * s)
    }

    /// `psi / sqrt(energy_0 energy_1)`: dimensionless.
    pub(crate) fn correlation(&self) -> Matrix3<f64> {
        let (psi, root) = self.normalised();
        psi / root
    }
}

/// The power of two that brings the normal number `x` into 1..2; within 1e-300..1e300 the result is normal.
#[inline]
fn reciprocal_power(x: f64) -> f64 {
    // A biased exponent E stands for 2^(E - 1023); the reciprocal power 2^(1023 - E) has the biased exponent 2046 - E.
    let exponent = (x.to_bits() >> 52) & 0x7ff;
    f64::from_bits((0x7fe_u64.saturating_sub(exponent)) << 52)
}

/// The same moments from coordinates and weights brought near 1 first, or what is wrong with them.
#[cold]
#[inline(never)]
fn rescaled<To, From>(pairs: Pairs<'_, To, From>) -> Result<Moments, Refused> {
    pairs.check()?;
    let sa = scale_of(pairs.to);
    let sb = scale_of(pairs.from);
    // Powers of two scale the coordinates without rounding. Weights of any size would overflow the sums; only their
    // ratios matter, and `check` has found three above zero.
    let largest = (0..pairs.len()).map(|i| pairs.weight(i)).fold(0.0, f64::max);
    let sums = sums(pairs, |v| v * sa, |v| v * sb, |i| pairs.weight(i) / largest);
    let [a, b] = sums.centre;
    let [ra, rb] = sums.rest;
    Ok(Moments {
        centre: [a / sa, b / sb],
        rest: [ra / sa, rb / sb],
        scale: [sa, sb],
        ..sums
    })
}

/// A power of two that brings the largest coordinate into 1..2, within 2^-900 and 2^900.
fn scale_of<F>(points: &[Point<F>]) -> f64 {
    let largest = points.iter().flat_map(|p| p.mm()).fold(0.0_f64, |m, x| m.max(x.abs()));
    // The clamp keeps the reciprocal a normal number for a cloud at the origin, too, whose largest coordinate is 0.
    reciprocal_power(largest.clamp(2.0_f64.powi(-900), 2.0_f64.powi(900)))
}

#[inline(always)]
fn sums<To, From>(
    pairs: Pairs<'_, To, From>,
    to: impl Fn(Vector3<f64>) -> Vector3<f64>,
    from: impl Fn(Vector3<f64>) -> Vector3<f64>,
    weight: impl Fn(usize) -> f64,
) -> Moments {
    // Scaling and weights are closures, so that the usual case, which has neither, compiles to sums without them.
    let (mut ca, mut cb, mut total) = (Vector3::zeros(), Vector3::zeros(), 0.0);
    for (i, (a, b)) in pairs.to.iter().zip(pairs.from).enumerate() {
        let w = weight(i);
        total += w;
        ca += to(coordinates(*a)) * w;
        cb += from(coordinates(*b)) * w;
    }
    // Without pairs this is infinite and the sums are NaN; `rescaled` then names the reason.
    let share = 1.0 / total;
    let (ca, cb) = (ca * share, cb * share);
    let block = |range: Range<usize>| {
        let mut second = Second::default();
        let points = pairs.to[range.clone()].iter().zip(&pairs.from[range.clone()]);
        for (i, (a, b)) in range.zip(points) {
            second.add(weight(i), to(coordinates(*a)) - ca, from(coordinates(*b)) - cb);
        }
        second
    };
    tree(0..pairs.len(), &block).finish(share, [ca, cb])
}

/// Sums blocks two by two, so that the rounding grows with the logarithm of their number.
#[inline(always)]
fn tree(range: Range<usize>, block: &impl Fn(Range<usize>) -> Second) -> Second {
    if range.len() <= BLOCK_PAIRS {
        return block(range);
    }
    // The recursion is out of line, so that a single block is all that is compiled into the caller.
    halves(range, block)
}

#[inline(never)]
fn halves(range: Range<usize>, block: &impl Fn(Range<usize>) -> Second) -> Second {
    if range.len() <= BLOCK_PAIRS {
        return block(range);
    }
    let middle = range.start + range.len() / 2;
    let (first, rest) = (halves(range.start..middle, block), halves(middle..range.end, block));
    first.plus(&rest)
}

/// Running sums about the rounded centres.
#[derive(Default)]
struct Second {
    rest: [Vector3<f64>; 2],
    psi: Matrix3<f64>,
    energy: [Vector3<f64>; 2],
}

impl Second {
    #[inline(always)]
    fn add(&mut self, weight: f64, a: Vector3<f64>, b: Vector3<f64>) {
        let wa = a * weight;
        let wb = b * weight;
        self.rest[0] += wa;
        self.rest[1] += wb;
        self.energy[0] += wa.component_mul(&a);
        self.energy[1] += wb.component_mul(&b);
        self.psi += wa * b.transpose();
    }

    fn plus(&self, other: &Self) -> Self {
        let both = |i: usize| (self.rest[i] + other.rest[i], self.energy[i] + other.energy[i]);
        let ((ra, ea), (rb, eb)) = (both(0), both(1));
        Self {
            rest: [ra, rb],
            psi: self.psi + other.psi,
            energy: [ea, eb],
        }
    }

    fn finish(&self, share: f64, centre: [Vector3<f64>; 2]) -> Moments {
        let rest = [self.rest[0] * share, self.rest[1] * share];
        // Steiner's theorem: mean |x - m|^2 = mean |x|^2 - |m|^2. About the rounded centres m is of the size of
        // rounding, so that nothing cancels here.
        let energy = |i: usize| self.energy[i].sum() * share - rest[i].norm_squared();
        Moments {
            centre,
            rest,
            scale: [1.0; 2],
            psi: self.psi * share - rest[0] * rest[1].transpose(),
            energy: [energy(0), energy(1)],
        }
    }
}
