//! Where a cube that the surface cuts holds some of the region: a grid of places finer than the points of elements.

use nalgebra::Vector3;

use super::field::Field;

/// Boxes along an axis.
const COUNT: usize = 8;

/// Of the 8 x 8 x 8 boxes of a cube those whose middle is inside the region, a bit each: along x the bits of a byte, along y the bytes of a number, along z
/// the numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::space) struct Eighths([u64; COUNT]);

impl Eighths {
    /// Of a cube from its lowest corner on.
    pub(super) fn of(field: &dyn Field, low: &Vector3<f64>, side: f64) -> Self {
        let mut found = [0; COUNT];
        for (k, place) in (0..COUNT.pow(3)).map(|k| (k, middle(k))) {
            // From -1 to 1 along each axis of the cube.
            let at = low + Vector3::from(place).add_scalar(1.0) * (0.5 * side);
            if field.value(&at) < 0.0 {
                found[k / 64] |= 1 << (k % 64);
            }
        }
        Self(found)
    }

    /// The middles that are inside, in the cube's own places from -1 to 1 along each axis.
    pub(in crate::space) fn middles(&self) -> impl Iterator<Item = [f64; 3]> {
        let inside = (0..COUNT.pow(3)).filter(|k| self.0[k / 64] >> (k % 64) & 1 == 1);
        inside.map(middle)
    }
}

/// Of box `k`, fastest along x.
fn middle(k: usize) -> [f64; 3] {
    [k % COUNT, k / COUNT % COUNT, k / COUNT / COUNT].map(|i| (2 * i + 1) as f64 / COUNT as f64 - 1.0)
}

#[cfg(test)]
mod tests {
    use super::super::Ball;
    use super::*;

    /// Counted by volume: the middles stand for their boxes.
    #[test]
    fn middles_inside_are_all_that_lie_in_the_region() {
        let ball = Ball {
            centre: Vector3::new(1.0, 2.0, 0.5),
            radius: 6.0,
        };
        let (low, side) = (Vector3::new(-6.0, -5.0, -6.5), 14.0);
        let found: Vec<[f64; 3]> = Eighths::of(&ball, &low, side).middles().collect();
        let at = |place: &[f64; 3]| Vector3::from_fn(|a, _| low[a] + 0.5 * side * (place[a] + 1.0));
        assert!(found.iter().all(|place| (at(place) - ball.centre).norm() < ball.radius));
        let volume = found.len() as f64 * (side / 8.0).powi(3);
        let expected = 4.0 / 3.0 * std::f64::consts::PI * ball.radius.powi(3);
        // A grid of a third of the radius: some percent.
        assert!((volume / expected - 1.0).abs() < 0.1, "{volume} {expected}");
    }
}
