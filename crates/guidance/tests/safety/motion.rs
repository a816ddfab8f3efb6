//! What a distance must not depend on, and what it must.

use chance::SplitMix64;
use geometry::{Affine, Ct, Point, Rigid, Vector, VolumeGrid, Voxel};
use guidance::safety::{Clearances, Tube};
use proptest::prelude::*;

use crate::support::{Map, random_map, random_tube, rounding};

/// The map's grid, its steps and its first voxel moved.
fn moved(grid: &VolumeGrid, motion: Rigid<Ct, Ct>) -> VolumeGrid {
    let map = grid.ct_from_voxel();
    let origin = motion * (map * Point::<Voxel>::new(0.0, 0.0, 0.0));
    let steps = [0, 1, 2].map(|k| motion * map.step(k));
    VolumeGrid::checked(grid.dims().map(i64::from), Affine::from_steps(origin, steps)).unwrap()
}

fn distances(found: &Clearances) -> Vec<(i16, f64)> {
    let mut list: Vec<_> = found.structures.iter().map(|c| (c.label, c.distance_mm())).collect();
    list.sort_by_key(|(label, _)| *label);
    list
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn a_rigid_motion_of_everything_changes_nothing(seed: u64) {
        let mut random = SplitMix64::new(seed);
        let map = random_map(&mut random);
        let tube = random_tube(&map.grid, &mut random);
        let mut vector = |size: f64| Vector::new(random.around(0.0, size), random.around(0.0, size), random.around(0.0, size));
        let motion = Rigid::<Ct, Ct>::from_rotation_vector(vector(2.0), vector(400.0)).unwrap();
        let there = Map { grid: moved(&map.grid, motion), labels: map.labels.clone() };
        let tube_there = Tube::new(motion * tube.entry(), motion * tube.tip(), tube.radius_mm()).unwrap();
        let [here, there_found] = [(&map, &tube), (&there, &tube_there)].map(|(map, tube)| {
            map.build().clearance(tube, 1e4).unwrap()
        });
        // The motion itself rounds the grid and the tube: by 8 eps of the coordinates, and an axis that is turned by
        // rounding moves the far end of the map by as much over the tube's length.
        let lever = 1.0 + far(&there, &tube_there) / tube.length_mm();
        let bound = (rounding(&tube, &map.grid) + rounding(&tube_there, &there.grid)) * lever;
        for (a, b) in distances(&here).iter().zip(distances(&there_found)) {
            prop_assert!(a.0 == b.0 && (a.1 - b.1).abs() <= bound, "{a:?} {b:?} {bound}");
        }
        prop_assert!((here.coverage.margin_mm - there_found.coverage.margin_mm).abs() <= bound);
    }

    /// A longer or thicker tube holds the shorter and thinner one: no structure is farther from it.
    #[test]
    fn a_larger_tube_is_never_farther(seed: u64) {
        let mut random = SplitMix64::new(seed);
        let map = random_map(&mut random);
        let tube = random_tube(&map.grid, &mut random);
        let structures = map.build();
        let more = random.around(1.0, 1.0);
        let thicker = Tube::new(tube.entry(), tube.tip(), tube.radius_mm() + more).unwrap();
        let longer = Tube::new(tube.entry(), tube.at(tube.length_mm() + more), tube.radius_mm()).unwrap();
        let smaller = structures.clearance(&tube, 1e4).unwrap();
        for larger in [thicker, longer] {
            let found = structures.clearance(&larger, 1e4).unwrap();
            let bound = rounding(&larger, &map.grid) * (1.0 + far(&map, &tube) / tube.length_mm());
            for (a, b) in distances(&smaller).iter().zip(distances(&found)) {
                prop_assert!(b.1 <= a.1 + bound, "{a:?} {b:?}");
            }
            prop_assert!(found.coverage.margin_mm <= smaller.coverage.margin_mm + bound);
        }
    }

    /// A tube pushed from the tip to the entry is the same solid.
    #[test]
    fn either_end_may_be_the_entry(seed: u64) {
        let mut random = SplitMix64::new(seed);
        let map = random_map(&mut random);
        let tube = random_tube(&map.grid, &mut random);
        let back = Tube::new(tube.tip(), tube.entry(), tube.radius_mm()).unwrap();
        let [a, b] = [tube, back].map(|tube| distances(&map.build().clearance(&tube, 1e4).unwrap()));
        for (a, b) in a.iter().zip(b) {
            prop_assert!(a.0 == b.0 && (a.1 - b.1).abs() <= rounding(&tube, &map.grid));
        }
    }
}

/// From the entry to the farthest corner of the map, mm.
fn far(map: &Map, tube: &Tube) -> f64 {
    let (low, high) = map.grid.bounds();
    tube.entry().distance(low) + low.distance(high)
}
