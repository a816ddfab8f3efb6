//! Which arcs are near one another: boxes sorted along one axis.
//!
//! The thesis keeps samples in a quadtree. Of it, a tree of bounds, a grid and this, all made anew in every state, this is the fastest
//! up to 10 000 samples, about four times as fast as the quadtree (`cargo bench -p simulation --bench detection`).

use nalgebra::Vector2;

use super::shape::{Shape, boxes_near};

/// An arc: its solid and its number.
pub(super) type Place = [u32; 2];

/// A box: its low and its high corner.
type Bounds = [Vector2<f64>; 2];

/// The axis along which boxes are spread farthest.
fn longer_axis(boxes: &[Bounds]) -> usize {
    let infinity = Vector2::repeat(f64::INFINITY);
    let [low, high] = boxes
        .iter()
        .fold([infinity, -infinity], |b, [low, high]| [b[0].inf(low), b[1].sup(high)]);
    let side = high - low;
    usize::from(side.y > side.x)
}

/// Every two boxes `[low corner, high corner]` that come as near as `within` along both axes, by their numbers, once each.
///
/// In the order of their low ends along the axis that they are spread over farthest. Boxes that are not finite end anywhere in it.
pub fn near_boxes(boxes: &[Bounds], within: f64) -> Vec<[u32; 2]> {
    let axis = longer_axis(boxes);
    let mut order: Vec<(f64, u32)> = boxes.iter().enumerate().map(|(k, b)| (b[0][axis], k as u32)).collect();
    // Equal ends in the order of their numbers: pairs come alike in every run, and sums of energies with them.
    order.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let mut found = Vec::new();
    for (k, (_, first)) in order.iter().enumerate() {
        let one = &boxes[*first as usize];
        let after = order[k + 1..]
            .iter()
            .take_while(|(low, _)| low - one[1][axis] <= within);
        let near = after.filter(|(_, second)| boxes_near(one, &boxes[*second as usize], within));
        found.extend(near.map(|(_, second)| [*first, *second]));
    }
    found
}

/// Every two arcs whose boxes come as near as `within`, once, of whatever solids.
pub(super) fn near_arcs(shapes: &[Shape], within: f64) -> Vec<[Place; 2]> {
    let boxes: Vec<Bounds> = shapes.iter().flat_map(|s| s.boxes.iter().copied()).collect();
    let place = |(body, shape): (usize, &Shape)| (0..shape.boxes.len()).map(move |arc| [body as u32, arc as u32]);
    let places: Vec<Place> = shapes.iter().enumerate().flat_map(place).collect();
    let pairs = near_boxes(&boxes, within).into_iter();
    pairs.map(|pair| pair.map(|number| places[number as usize])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pair_is_found_once() {
        let mut state = 11_u64;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        };
        // Sizes alike and very unlike, near the origin and far from it, distances from none to all.
        for (size, spread, away) in [(0.1, 1.0, 0.0), (1e-6, 1.0, 1e3), (5.0, 1.0, 0.0), (0.3, 1e-9, -7.0)] {
            let boxes: Vec<Bounds> = (0..150)
                .map(|k| {
                    let size = if k % 40 == 0 { 30.0 * size } else { size };
                    let mut point = || Vector2::new(next(), next()) * spread;
                    let (at, by) = (point() + Vector2::repeat(away), point() * size);
                    [at.inf(&(at + by)), at.sup(&(at + by))]
                })
                .collect();
            for within in [0.0, 0.05 * spread, 0.7 * spread, 1e3] {
                let mut found = near_boxes(&boxes, within);
                found.iter_mut().for_each(|pair| pair.sort_unstable());
                found.sort_unstable();
                let pairs = (0..150_u32).flat_map(|i| (i + 1..150).map(move |j| [i, j]));
                let near = |[i, j]: &[u32; 2]| boxes_near(&boxes[*i as usize], &boxes[*j as usize], within);
                let all: Vec<[u32; 2]> = pairs.filter(near).collect();
                assert!(!all.is_empty() || within == 0.0, "{size} {spread} {away}");
                assert_eq!(found, all, "{size} {spread} {away} {within}");
            }
        }
    }

    #[test]
    fn boxes_that_are_not_finite_end_all_the_same() {
        let good = [Vector2::zeros(), Vector2::new(1.0, 1.0)];
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX] {
            near_boxes(&[good, [Vector2::repeat(-1.0), Vector2::new(bad, 2.0)], good], 0.1);
        }
    }
}
