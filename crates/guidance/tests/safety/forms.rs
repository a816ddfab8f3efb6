//! Closed forms: the distance of a tube from a ball or a box, of which the map has the voxels whose centres lie in it.

use chance::SplitMix64;
use geometry::Point;
use guidance::safety::{Clearance, Tube};
use proptest::prelude::*;

use crate::support::{Map, centre, point, random_tube, signed, skewed, straight};

fn nearest(map: &Map, tube: &Tube) -> Clearance {
    map.build().clearance(tube, 1e4).unwrap().structures[0]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    /// The tube's distance from a ball is that of its middle less its radius. No centre of the map lies nearer; and as far as the tube
    /// is outside, a centre lies within half a diagonal of the ball's nearest point moved into the ball by half a diagonal.
    #[test]
    fn a_ball_keeps_its_distance(seed: u64) {
        let mut random = SplitMix64::new(seed);
        let grid = skewed([24, 24, 24], &mut random);
        let middle = centre(&grid, [12, 12, 12]);
        let radius = grid.spacing_mm().into_iter().fold(0.0, f64::max) * random.around(3.5, 1.5);
        let map = Map::of(grid, |v| i16::from(centre(&grid, v).distance(middle) <= radius));
        let tube = random_tube(&grid, &mut random);
        let half = map.build().voxel_half_diagonal_mm();
        let truth = signed(&tube, middle) - radius;
        prop_assume!(truth > 0.0 && radius > half && is_whole_ball(&map, radius));
        let found = nearest(&map, &tube).distance_mm();
        prop_assert!(found >= truth - 1e-10, "{found} {truth}");
        // The ball of half a diagonal that touches the near point from within holds a centre, of the ball's own voxels.
        prop_assert!(found <= truth + 2.0 * half + 1e-10, "{found} {truth} {half}");
    }

    /// As a structure is its cells, the ball of cells is the ball to half a diagonal: so is what may be said at least and at most.
    #[test]
    fn a_ball_of_cells_is_no_nearer_than_is_said(seed: u64) {
        let mut random = SplitMix64::new(seed);
        let grid = straight([30, 30, 30], [random.around(1.0, 0.5), random.around(1.0, 0.5), random.around(1.5, 1.0)]);
        let middle = centre(&grid, [15, 15, 15]);
        let map = Map::of(grid, |v| i16::from(centre(&grid, v).distance(middle) <= 6.0));
        let half = map.build().voxel_half_diagonal_mm();
        let tube = random_tube(&grid, &mut random);
        let truth = signed(&tube, middle) - 6.0;
        let found = nearest(&map, &tube);
        if let (Some(least), true) = (found.at_least_mm(Some(0.25)), truth > 0.0) {
            prop_assert!(least <= truth + half - 0.25 + 1e-10);
        }
    }

    /// A box along the grid's axes, and a tube beside it along one of them: the distance by centres is that of the box whose
    /// sides are its outermost centres, exactly.
    #[test]
    fn a_tube_beside_a_box_has_the_box_s_distance(seed: u64) {
        let mut random = SplitMix64::new(seed);
        let spacing = [0; 3].map(|_| random.around(1.2, 0.9));
        let grid = straight([20, 18, 22], spacing);
        let (low, high) = ([5_u32, 6, 7], [9_u32, 11, 14]);
        let map = Map::of(grid, |v| 4 * i16::from((0..3).all(|k| (low[k]..=high[k]).contains(&v[k]))));
        let [near, far] = [low, high].map(|v| centre(&grid, v).mm());
        let radius = random.around(1.0, 0.9);
        // Along z, over part of the box; x and y anywhere outside it.
        let [x, y] = [0, 1].map(|k: usize| random.around((near[k] + far[k]) / 2.0, 25.0));
        let past = |at: f64, k: usize| (near[k] - at).max(at - far[k]).max(0.0);
        let beside = past(x, 0).hypot(past(y, 1)) - radius;
        prop_assume!(beside > 0.0);
        let tube = Tube::new(point([x, y, near[2] - 3.0]), point([x, y, near[2] + 1e-3]), radius).unwrap();
        let found = nearest(&map, &tube);
        // The nearest point of the box may lie between two centres: then the centre is off by at most half a step.
        let most = (beside + radius).hypot(spacing[0] / 2.0).max((beside + radius).hypot(spacing[1] / 2.0)) - radius;
        prop_assert!(found.distance_mm() >= beside - 1e-12 && found.distance_mm() <= most + 1e-12, "{found:?} {beside} {most}");
    }
}

/// Whether no part of the ball is cut off at the border of the map.
fn is_whole_ball(map: &Map, radius: f64) -> bool {
    let middle = centre(&map.grid, [12, 12, 12]);
    let mut random = SplitMix64::new(1);
    (0..500).all(|_| {
        let v = geometry::Vector::new(
            random.around(0.0, 1.0),
            random.around(0.0, 1.0),
            random.around(0.0, 1.0),
        );
        v.direction()
            .is_none_or(|d| map.grid.holds(middle + d * (radius * 1.02)))
    })
}

/// Entirely by hand: 1 mm voxels, a plane of voxels at x = 10, a tube along x with its tip 2.5 mm before it.
#[test]
fn a_tube_before_a_wall() {
    let grid = straight([20, 20, 20], [1.0; 3]);
    let map = Map::of(grid, |v| if v[0] >= 10 { 3 } else { 0 });
    let tube = Tube::new(point([1.0, 9.0, 9.0]), point([7.5, 9.0, 9.0]), 2.0).unwrap();
    let found = map.build().clearance(&tube, 50.0).unwrap();
    assert!(found.coverage.is_whole());
    // From x = 1 to the face of the field at -0.5.
    assert_eq!(found.coverage.margin_mm, 1.5);
    let clearance = found.structures[0];
    assert_eq!(
        (clearance.label, clearance.distance_mm(), clearance.cuts),
        (3, 2.5, false)
    );
    assert_eq!(clearance.voxel_half_diagonal_mm, 0.75_f64.sqrt());
    // The field ends 1.5 mm away: what lies beyond is not known, and nothing more may be promised.
    assert_eq!(clearance.at_least_mm(Some(0.5)), Some(1.5 - 0.5));
    let structures = map.build();
    let profile = structures.profile(&tube, 13, 50.0).unwrap();
    for (k, section) in profile.iter().enumerate() {
        let (label, nearest) = section.nearest.unwrap();
        let truth = 10.0 - (1.0 + 0.5 * (k + 1) as f64);
        assert!(label == 3 && (nearest.distance_mm - truth).abs() < 1e-12, "{section:?}");
    }
}

/// The tube's own depth stands where the structure is nearest.
#[test]
fn the_depth_is_where_the_ball_is() {
    let grid = straight([60, 40, 40], [1.0; 3]);
    let map = Map::of(grid, |v| {
        i16::from(centre(&grid, v).distance(Point::new(40.0, 30.0, 20.0)) <= 4.0)
    });
    let tube = Tube::new(point([5.0, 15.0, 20.0]), point([55.0, 15.0, 20.0]), 3.0).unwrap();
    let found = map.build().clearance(&tube, 50.0).unwrap().structures[0];
    let guidance::safety::Distance::Nearest(nearest) = found.distance else {
        panic!()
    };
    assert_eq!(
        (nearest.depth_mm, nearest.distance_mm, nearest.voxel),
        (35.0, 8.0, [40, 26, 20])
    );
    let sections = map.build().profile(&tube, 50, 50.0).unwrap();
    let least = sections
        .iter()
        .map(|s| s.nearest.unwrap().1.distance_mm)
        .fold(f64::INFINITY, f64::min);
    let at: Vec<f64> = sections
        .iter()
        .filter(|s| s.nearest.unwrap().1.distance_mm == least)
        .map(|s| s.from_mm)
        .collect();
    assert!(least == 8.0 && at == [34.0, 35.0], "{least} {at:?}");
}
