//! The nearest of many points.

use nalgebra::Vector3;

/// Points in a balanced tree: the middle one of each part divides the others across the part's axis.
#[derive(Debug, Clone, Default)]
pub(super) struct Tree {
    points: Vec<Vector3<f64>>,
    /// Which of the points given each is.
    numbers: Vec<u32>,
}

impl Tree {
    pub(super) fn new(points: Vec<Vector3<f64>>) -> Self {
        let mut order: Vec<u32> = (0..points.len() as u32).collect();
        divide(&points, &mut order, 0);
        Self {
            points: order.iter().map(|k| points[*k as usize]).collect(),
            numbers: order,
        }
    }

    /// All points, in the tree's order.
    pub(super) fn points(&self) -> &[Vector3<f64>] {
        &self.points
    }

    /// The nearest point and its distance; of a tree without points the origin, infinitely far.
    pub(super) fn nearest(&self, x: &Vector3<f64>) -> (Vector3<f64>, f64) {
        self.nearest_number(x)
            .map_or((Vector3::zeros(), f64::INFINITY), |(k, apart)| (self.points[k], apart))
    }

    /// The distance of the nearest point, or `most` where none is nearer than that: far from all points it costs next to nothing.
    pub(super) fn apart_within(&self, x: &Vector3<f64>, most: f64) -> f64 {
        let mut best = (self.points.len(), most * most);
        self.visit(x, 0, self.points.len(), 0, &mut best);
        best.1.sqrt().min(most)
    }

    /// Number of the nearest of the points given, and its distance.
    pub(super) fn nearest_given(&self, x: &Vector3<f64>) -> Option<(usize, f64)> {
        self.nearest_number(x)
            .map(|(k, apart)| (self.numbers[k] as usize, apart))
    }

    fn nearest_number(&self, x: &Vector3<f64>) -> Option<(usize, f64)> {
        let mut best = (self.points.len(), f64::INFINITY);
        self.visit(x, 0, self.points.len(), 0, &mut best);
        (best.0 < self.points.len()).then(|| (best.0, best.1.sqrt()))
    }

    fn visit(&self, x: &Vector3<f64>, first: usize, end: usize, axis: usize, best: &mut (usize, f64)) {
        if first >= end {
            return;
        }
        let middle = first + (end - first) / 2;
        let square = (self.points[middle] - x).norm_squared();
        if square < best.1 {
            *best = (middle, square);
        }
        let (across, next) = (x[axis] - self.points[middle][axis], (axis + 1) % 3);
        let parts = [(first, middle), (middle + 1, end)];
        let near = usize::from(across > 0.0);
        self.visit(x, parts[near].0, parts[near].1, next, best);
        if across * across < best.1 {
            self.visit(x, parts[1 - near].0, parts[1 - near].1, next, best);
        }
    }
}

fn divide(points: &[Vector3<f64>], order: &mut [u32], axis: usize) {
    if order.len() < 2 {
        return;
    }
    let middle = order.len() / 2;
    // Equal coordinates by number: one order whatever the way to it.
    let key = |k: &u32| points[*k as usize][axis];
    order.select_nth_unstable_by(middle, |p, q| key(p).total_cmp(&key(q)).then(p.cmp(q)));
    let (low, high) = order.split_at_mut(middle);
    divide(points, low, (axis + 1) % 3);
    divide(points, &mut high[1..], (axis + 1) % 3);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_is_that_of_a_plain_search() {
        let mut state = 7_u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 40) as f64 / (1_u64 << 24) as f64
        };
        for count in [1, 2, 3, 10, 500] {
            // On a plane too, where many coordinates are equal.
            for flat in [false, true] {
                let mut point = || Vector3::new(random(), if flat { 0.5 } else { random() }, (random() * 4.0).floor());
                let points: Vec<_> = (0..count).map(|_| point()).collect();
                let tree = Tree::new(points.clone());
                for _ in 0..50 {
                    let x = point() * 1.5;
                    let least = points.iter().map(|p| (p - x).norm()).fold(f64::INFINITY, f64::min);
                    let (number, apart) = tree.nearest_given(&x).unwrap();
                    assert!((apart - least).abs() < 1e-15 && ((points[number] - x).norm() - least).abs() < 1e-15);
                    assert_eq!(tree.nearest(&x).1, apart);
                    assert_eq!(tree.apart_within(&x, 1.5 * apart), apart);
                    assert_eq!(tree.apart_within(&x, 0.9 * apart), 0.9 * apart);
                }
            }
        }
        assert_eq!(Tree::new(Vec::new()).nearest_given(&Vector3::zeros()), None);
    }
}
