//! The tube by search instead of by formula, and shapes to hold it against.

use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};

use crate::space::tube::Tube;

/// Numbers in `[-1, 1)`, the same on every run.
pub(super) struct Numbers(u64);

impl Numbers {
    pub(super) fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1)
    }

    #[expect(clippy::cast_precision_loss, reason = "53 bits are kept")]
    pub(super) fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    pub(super) fn vector(&mut self) -> Vector3<f64> {
        Vector3::from_fn(|_, _| self.next())
    }

    /// A direction, of length 1.
    pub(super) fn direction(&mut self) -> Vector3<f64> {
        loop {
            let v = self.vector();
            let length = v.norm();
            if length > 0.1 && length < 1.0 {
                return v / length;
            }
        }
    }

    pub(super) fn pose(&mut self, size: f64) -> Isometry3<f64> {
        let turn = UnitQuaternion::from_scaled_axis(self.vector() * 3.0);
        Isometry3::from_parts(Translation3::from(self.vector() * size), turn)
    }
}

/// A tube with its points in the world, for the search.
pub(super) struct Shape {
    pub(super) tube: Tube,
    centres: Vec<Vector3<f64>>,
    radii: Vec<f64>,
}

impl Shape {
    pub(super) fn new(pose: Isometry3<f64>, axis: &[Point3<f64>], radii: &[f64]) -> Self {
        Self {
            tube: Tube::new(pose, axis, radii).unwrap(),
            centres: axis.iter().map(|p| (pose * p).coords).collect(),
            radii: radii.to_vec(),
        }
    }

    /// A bent tube of five points about the size of `size`; radii differ where `cones`.
    pub(super) fn bent(numbers: &mut Numbers, size: f64, cones: bool) -> Self {
        let pose = numbers.pose(size);
        let axis: Vec<_> = (0..5).map(|_| Point3::from(numbers.vector() * size)).collect();
        let radius = |n: &mut Numbers| size * (0.2 + if cones { 0.15 * n.next() } else { 0.0 });
        let radii: Vec<_> = axis.iter().map(|_| radius(numbers)).collect();
        Self::new(pose, &axis, &radii)
    }

    /// A place about the tube: some way off its axis, up to two and a half radii of a bent one.
    pub(super) fn about(&self, numbers: &mut Numbers, size: f64) -> Vector3<f64> {
        let part = 0.5 + 0.5 * numbers.next();
        let segment = usize::from(numbers.next() > 0.0) * (self.segments() - 1);
        let last = (segment + 1).min(self.centres.len() - 1);
        self.centres[segment].lerp(&self.centres[last], part) + numbers.direction() * (0.5 * size * numbers.next())
    }

    pub(super) fn segments(&self) -> usize {
        (self.centres.len() - 1).max(1)
    }

    /// Distance to one segment: the least over its spheres, a convex function searched by thirds. Its error is that of the
    /// value at a minimum, a few units in the last place.
    pub(super) fn segment_value(&self, segment: usize, x: &Vector3<f64>) -> f64 {
        let last = (segment + 1).min(self.centres.len() - 1);
        let at = |t: f64| {
            let centre = self.centres[segment] * (1.0 - t) + self.centres[last] * t;
            (x - centre).norm() - (self.radii[segment] * (1.0 - t) + self.radii[last] * t)
        };
        least(0.0, 1.0, &at).1
    }

    pub(super) fn value(&self, x: &Vector3<f64>) -> f64 {
        (0..self.segments())
            .map(|s| self.segment_value(s, x))
            .fold(f64::INFINITY, f64::min)
    }

    /// First touch by halving, and the least distance on the way (which says how clear the case is).
    pub(super) fn first_touch(&self, x: &Vector3<f64>, d: &Vector3<f64>) -> (Option<f64>, f64) {
        let mut first: Option<f64> = None;
        let mut clear = f64::INFINITY;
        for segment in 0..self.segments() {
            // Convex along the way, as each segment is convex.
            let along = |t: f64| self.segment_value(segment, &(x + d * t));
            let (lowest, value) = least(0.0, 1.0, &along);
            clear = if value.abs() < clear.abs() { value } else { clear };
            if value > 0.0 {
                continue;
            }
            let (mut free, mut within) = (0.0, lowest);
            if along(0.0) <= 0.0 {
                within = 0.0;
            }
            for _ in 0..60 {
                let middle = 0.5 * (free + within);
                *(if along(middle) > 0.0 { &mut free } else { &mut within }) = middle;
            }
            first = Some(first.map_or(within, |f| f.min(within)));
        }
        (first, clear)
    }
}

/// Place and value of the minimum of a convex function.
fn least(mut low: f64, mut high: f64, f: &dyn Fn(f64) -> f64) -> (f64, f64) {
    for _ in 0..90 {
        let third = (high - low) / 3.0;
        if f(low + third) <= f(high - third) {
            high -= third;
        } else {
            low += third;
        }
    }
    let places = [low, high, 0.5 * (low + high)];
    let values = places.map(f);
    let best = (0..3).fold(0, |b, i| if values[i] < values[b] { i } else { b });
    (places[best], values[best])
}
