//! Lines below points.

/// A frame: the device's stamp and its arrival less its stamp, both from a base, nanoseconds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Point {
    pub(super) x: f64,
    pub(super) y: f64,
}

/// `y = offset + slope x`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Line {
    pub(super) slope: f64,
    pub(super) offset: f64,
}

impl Line {
    pub(super) fn at(self, x: f64) -> f64 {
        self.offset + self.slope * x
    }

    /// How far a point lies above it.
    pub(super) fn below(self, point: Point) -> f64 {
        point.y - self.at(point.x)
    }

    /// The highest line of this slope with no point below it.
    pub(super) fn supporting(slope: f64, points: impl Iterator<Item = Point>) -> Self {
        let offset = points.map(|p| p.y - slope * p.x).fold(f64::INFINITY, f64::min);
        Self { slope, offset }
    }
}

/// The slope of the lower convex hull's edge over the middle of `points`, which stand by rising `x`. `hull` is room for the work.
///
/// That edge belongs to the line with no point below it and the least sum of distances of points above it: the likeliest line where
/// delays beyond the least are exponential.
pub(super) fn slope_below(points: &[Point], hull: &mut Vec<Point>) -> Option<f64> {
    let (first, last) = (points.first()?, points.last()?);
    let middle = f64::midpoint(first.x, last.x);
    hull.clear();
    for &point in points {
        // A point that does not lie below the line from its neighbour to the new one is no corner.
        while let [.., a, b] = hull[..]
            && cross(a, b, point) <= 0.0
        {
            hull.pop();
        }
        hull.push(point);
    }
    let after = hull.iter().position(|p| p.x >= middle)?.max(1);
    let (a, b) = (hull.get(after - 1)?, hull.get(after)?);
    let run = b.x - a.x;
    (run > 0.0).then(|| (b.y - a.y) / run)
}

/// Positive where the way from `a` over `b` to `c` turns upward.
fn cross(a: Point, b: Point, c: Point) -> f64 {
    (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x)
}

/// The rank of [`eighth`].
pub(super) const RANK: usize = 8;

/// The eighth least distance of `points` above `line`; `None` of fewer.
///
/// Where delays near the least one are evenly likely, the distances of the lowest points from the least delay are sums of equal
/// exponential steps, and the lowest is farther from it than the eighth from the lowest in 1 case of 2^7.
pub(super) fn eighth(points: &[Point], line: Line) -> Option<f64> {
    let mut least = [f64::INFINITY; RANK];
    for &point in points {
        let mut next = line.below(point).max(0.0);
        for kept in &mut least {
            if next < *kept {
                std::mem::swap(kept, &mut next);
            }
        }
    }
    least.last().copied().filter(|distance| distance.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn points(delays: &[f64], slope: f64) -> Vec<Point> {
        let points = delays.iter().enumerate();
        points
            .map(|(k, d)| Point {
                x: k as f64,
                y: d + slope * k as f64,
            })
            .collect()
    }

    proptest! {
        #[test]
        fn no_line_below_all_points_is_higher_in_the_middle(delays in prop::collection::vec(0.0..100.0_f64, 2..80),
                                                            slope in -10.0..10.0_f64, other in -20.0..20.0_f64) {
            let points = points(&delays, slope);
            let middle = (points.len() - 1) as f64 / 2.0;
            let found = slope_below(&points, &mut Vec::new()).unwrap();
            let [best, worse] = [found, other].map(|slope| Line::supporting(slope, points.iter().copied()));
            prop_assert!(worse.at(middle) <= best.at(middle) + 1e-9);
            prop_assert!(points.iter().all(|&p| best.below(p) >= -1e-9));
        }

        #[test]
        fn the_eighth_is_that_of_a_sorted_list(delays in prop::collection::vec(0.0..100.0_f64, 0..80)) {
            let found = eighth(&points(&delays, 0.0), Line::default());
            let mut sorted = delays;
            sorted.sort_by(f64::total_cmp);
            prop_assert_eq!(found, sorted.get(RANK - 1).copied());
        }
    }

    #[test]
    fn one_point_has_no_slope() {
        assert_eq!(slope_below(&points(&[1.0], 0.0), &mut Vec::new()), None);
        assert_eq!(slope_below(&[], &mut Vec::new()), None);
    }
}
