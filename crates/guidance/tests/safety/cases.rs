//! The cases in which a structure could be missed.

use geometry::{Affine, VolumeGrid};
use guidance::safety::{Clearance, Distance, Nearest, Tube};

use crate::support::{Map, centre, point, signed, straight};

fn all(map: &Map, tube: &Tube) -> Vec<Clearance> {
    map.build().clearance(tube, 1e3).unwrap().structures
}

fn nearest(clearance: &Clearance) -> Nearest {
    match clearance.distance {
        Distance::Nearest(nearest) => nearest,
        Distance::Beyond { .. } => panic!("{clearance:?}"),
    }
}

fn tube(entry: [f64; 3], tip: [f64; 3], radius: f64) -> Tube {
    Tube::new(point(entry), point(tip), radius).unwrap()
}

/// An organ of 40 voxels each way has interior blocks without any boundary; a tube in its middle is 5 mm from its nearest boundary.
#[test]
fn a_tube_within_an_organ_cuts_it() {
    let grid = straight([48, 48, 48], [1.0; 3]);
    let map = Map::of(grid, |v| 8 * i16::from(v.iter().all(|i| (4..44).contains(i))));
    for radius in [1e-3, 0.3, 2.0, 9.0] {
        let found = all(&map, &tube([18.3, 22.4, 24.6], [30.1, 23.9, 25.3], radius));
        assert!(found[0].cuts && !found[0].is_clear(), "{radius} {found:?}");
        assert!(found[0].at_least_mm(Some(0.0)).unwrap() < 0.0);
    }
    // Between the centres, so thin that it holds none of them: the axis still runs through cells of the organ.
    let between = all(&map, &tube([20.5, 24.5, 10.0], [20.5, 24.5, 30.0], 0.1));
    assert!((between[0].distance_mm() - (0.5_f64.sqrt() - 0.1)).abs() < 1e-12 && between[0].cuts);
    let deep = all(&map, &tube([24.0, 24.0, 5.0], [24.0, 24.0, 42.0], 3.0));
    assert!(
        (nearest(&deep[0]).distance_mm + 3.0).abs() < 1e-12,
        "a centre on the axis is 3 mm deep: {deep:?}"
    );
}

/// As far from all centres as a place can be, half a diagonal: between the corners of eight blocks, and along an edge of four. The nearest
/// voxels are no boundary, and lie as far away as such voxels may.
#[test]
fn the_nearest_voxel_may_be_no_boundary() {
    let map = Map::of(straight([24, 24, 24], [1.0; 3]), |_| 5);
    let found = all(&map, &tube([7.5, 7.5, 7.495], [7.5, 7.5, 7.505], 0.005));
    // The corner of the tube that is nearest to the eight centres.
    let truth = (0.5_f64.sqrt() - 0.005).hypot(0.495);
    assert!(
        (found[0].distance_mm() - truth).abs() < 1e-12 && found[0].cuts,
        "{found:?} {truth}"
    );
    let sections = map
        .build()
        .profile(&tube([7.5, 7.5, 3.2], [7.5, 7.5, 20.2], 0.1), 17, 10.0)
        .unwrap();
    let distances: Vec<f64> = sections
        .iter()
        .map(|s| s.nearest.map_or(f64::NAN, |(_, n)| n.distance_mm))
        .collect();
    assert!(
        distances.iter().all(|mm| (mm - (0.5_f64.sqrt() - 0.1)).abs() < 1e-12),
        "{distances:?}"
    );
}

#[test]
fn a_tube_through_a_thin_plate_cuts_it() {
    let grid = straight([30, 30, 30], [0.8, 0.8, 2.0]);
    let map = Map::of(grid, |v| 2 * i16::from(v[2] == 15));
    // From between four centres to between four others, thinner than their distance, so that no centre lies within.
    let thin = all(&map, &tube([10.0, 10.0, 3.0], [10.0, 10.0, 55.0], 0.05));
    assert!(
        thin[0].cuts && !thin[0].is_clear() && thin[0].distance_mm() > 0.0,
        "{thin:?}"
    );
    let sections = map
        .build()
        .profile(&tube([10.0, 10.0, 3.0], [10.0, 10.0, 55.0], 0.6), 7, 10.0)
        .unwrap();
    let cut: Vec<bool> = sections
        .iter()
        .map(|s| s.nearest.is_some_and(|(_, n)| n.distance_mm <= 0.0))
        .collect();
    // The plate at 30 mm is at depth 27 of 52: in the fourth of seven sections.
    assert_eq!(cut, [false, false, false, true, false, false, false]);
}

#[test]
fn a_single_voxel_is_found_wherever_it_is() {
    let grid = straight([17, 9, 25], [1.1, 0.7, 2.3]);
    let way = tube([3.0, 2.0, 10.0], [14.0, 4.0, 40.0], 1.5);
    for voxel in [
        [0, 0, 0],
        [16, 8, 24],
        [8, 4, 12],
        [7, 8, 8],
        [8, 0, 7],
        [15, 7, 15],
        [16, 0, 23],
    ] {
        let map = Map::of(grid, |v| 9 * i16::from(v == voxel));
        let found = all(&map, &way);
        let truth = signed(&way, centre(&grid, voxel));
        assert!((nearest(&found[0]).distance_mm - truth).abs() < 1e-12 && nearest(&found[0]).voxel == voxel);
        assert_eq!((found.len(), found[0].label), (1, 9));
    }
}

#[test]
fn a_structure_behind_the_entry_or_beyond_the_tip_is_told_by_its_depth() {
    let grid = straight([60, 20, 20], [1.0; 3]);
    let map = Map::of(grid, |v| i16::from(v[0] < 4) + 2 * i16::from(v[0] > 50));
    let way = tube([10.0, 10.0, 10.0], [40.0, 10.0, 10.0], 4.0);
    let found = all(&map, &way);
    let depths: Vec<_> = found
        .iter()
        .map(|c| (c.label, nearest(c).depth_mm, c.distance_mm()))
        .collect();
    assert_eq!(depths, [(1, -7.0, 7.0), (2, 41.0, 11.0)]);
    assert!(found.iter().all(|c| !c.cuts && c.is_clear()));
    // In the chart each is nearest to its own end.
    let ends = map.build().profile(&way, 30, 100.0).unwrap();
    let [first, last] = [ends[0], ends[29]].map(|s| s.nearest.unwrap());
    assert_eq!(
        (first.0, first.1.distance_mm, last.0, last.1.distance_mm),
        (1, 7.0, 2, 11.0)
    );
}

/// Parallel to a plane of voxels and half-way between two: both planes are equally far.
#[test]
fn a_tube_parallel_to_planes_of_voxels() {
    let grid = straight([20, 20, 20], [1.0, 1.0, 3.0]);
    let map = Map::of(grid, |v| if v[2] == 5 { 1 } else { 2 * i16::from(v[2] == 6) });
    let found = all(&map, &tube([4.0, 10.0, 16.5], [15.0, 10.0, 16.5], 1.0));
    let distances: Vec<_> = found.iter().map(|c| (c.label, c.distance_mm())).collect();
    assert_eq!(distances, [(1, 0.5), (2, 0.5)]);
    // Between the plates' centres the axis runs on the common face of their cells.
    assert!(found.iter().all(|c| c.cuts && !c.is_clear()));
}

/// A tube that leaves the map: where, and nothing may be promised.
#[test]
fn what_leaves_the_map_is_not_checked() {
    let grid = straight([20, 20, 20], [1.0; 3]);
    let map = Map::of(grid, |v| i16::from(v == [10, 2, 10]));
    let structures = map.build();
    let way = tube([-20.5, 10.0, 10.0], [39.5, 10.0, 10.0], 2.0);
    let found = structures.clearance(&way, 100.0).unwrap();
    assert_eq!(found.coverage.inside_mm, Some([20.0, 40.0]));
    assert_eq!(found.coverage.outside_mm(), [[0.0, 20.0], [40.0, 60.0]]);
    assert!(!found.coverage.is_whole() && found.coverage.margin_mm == -20.0);
    assert_eq!(found.structures[0].at_least_mm(Some(0.0)), None);
    let sections = structures.profile(&way, 6, 100.0).unwrap();
    let inside: Vec<bool> = sections.iter().map(|s| s.is_inside_map).collect();
    assert_eq!(inside, [false, false, true, true, false, false]);
    // The part within is a tube of its own.
    let part = structures.clearance(&way.part(20.5, 39.5).unwrap(), 100.0).unwrap();
    assert!(part.coverage.is_whole() && part.structures[0].at_least_mm(Some(0.0)) == Some(0.5));
    // Beside the map, a finger's breadth away from its only structure: nothing of it was checked.
    let beside = structures
        .clearance(&tube([5.0, -1.0, 10.0], [15.0, -1.0, 10.0], 0.6), 100.0)
        .unwrap();
    assert_eq!(
        (beside.coverage.inside_mm, beside.structures[0].at_least_mm(Some(0.0))),
        (None, None)
    );
    assert_eq!(beside.coverage.outside_mm(), [[0.0, 10.0]]);
}

#[test]
fn an_unknown_error_gives_no_number() {
    let map = Map::of(straight([9, 9, 9], [1.0; 3]), |v| i16::from(v == [4, 4, 8]));
    let found = map
        .build()
        .clearance(&tube([4.0, 4.0, 2.0], [4.0, 4.0, 4.0], 0.5), 100.0)
        .unwrap()
        .structures[0];
    for unknown in [None, Some(f64::NAN), Some(f64::INFINITY), Some(-1e-9)] {
        assert_eq!(found.at_least_mm(unknown), None);
    }
    // 4 mm to the centre, less half a diagonal; the field ends 2.5 mm behind the entry, which is less.
    assert_eq!(
        found.at_least_mm(Some(1.0)),
        Some((4.0 - 0.75_f64.sqrt()).min(2.5) - 1.0)
    );
}

/// What is not nearer than was searched is said to be beyond, and never to be free.
#[test]
fn beyond_is_a_bound_and_no_distance() {
    let map = Map::of(straight([40, 9, 9], [1.0; 3]), |v| {
        i16::from(v[0] == 2) + 2 * i16::from(v[0] == 36)
    });
    let way = tube([6.0, 4.0, 4.0], [12.0, 4.0, 4.0], 1.0);
    let found = map.build().clearance(&way, 10.0).unwrap().structures;
    assert_eq!(nearest(&found[0]).distance_mm, 4.0);
    assert_eq!(
        (found[1].label, found[1].distance),
        (2, Distance::Beyond { within_mm: 10.0 })
    );
    assert!(found[1].is_clear() && found[1].at_least_mm(Some(0.0)).unwrap() <= 10.0);
}

/// The sections of a tube within the field are within it, and are the tube to the last bit, however many they are.
#[test]
fn sections_leave_nothing_out() {
    let structures = Map::of(straight([30, 30, 30], [0.9; 3]), |v| i16::from(v[0] > 20)).build();
    let way = tube([4.1, 7.3, 5.9], [16.7, 19.3, 17.1], 1.1);
    for sections in (1..400).chain([9_999, 10_000]) {
        let found = structures.profile(&way, sections, 40.0).unwrap();
        assert!(found.iter().all(|s| s.is_inside_map), "{sections}");
        assert_eq!((found[0].from_mm, found[sections - 1].to_mm), (0.0, way.length_mm()));
        assert!(found.windows(2).all(|pair| pair[0].to_mm == pair[1].from_mm));
    }
}

/// Ten thousand structures, each of some voxels, in one map; all are told, in order.
#[test]
fn ten_thousand_labels() {
    let grid = straight([80, 40, 50], [1.0; 3]);
    let map = Map::of(grid, |v| 1 + ((v[0] / 4) + 20 * (v[1] / 2) + 400 * (v[2] / 2)) as i16);
    let structures = map.build();
    assert_eq!(structures.list().len(), 10_000);
    assert!(structures.list().iter().all(|s| s.voxels() == 16));
    let way = tube([5.2, 6.1, 7.3], [70.0, 30.0, 40.0], 2.5);
    let found = structures.clearance(&way, 5.0).unwrap().structures;
    assert_eq!(found.len(), 10_000);
    assert!(found.is_sorted_by_key(Clearance::distance_mm));
    let cut = found.iter().filter(|c| c.distance_mm() <= 0.0).count();
    let mut by_force: Vec<i16> = map
        .labelled()
        .filter(|(_, v)| signed(&way, centre(&grid, *v)) <= 0.0)
        .map(|(l, _)| l)
        .collect();
    by_force.sort_unstable();
    by_force.dedup();
    assert!(cut == by_force.len() && cut > 100, "{cut} {}", by_force.len());
}

/// The statistics of a structure.
#[test]
fn a_structure_knows_its_voxels() {
    let map = Map::of(straight([30, 20, 20], [1.0; 3]), |v| {
        6 * i16::from((3..21).contains(&v[0]) && v[1] > 9 && v[2] < 9)
    });
    let structures = map.build();
    let structure = &structures.list()[0];
    assert_eq!((structure.label(), structure.voxels()), (6, 18 * 10 * 9));
    assert_eq!(structure.extent(), ([3, 10, 0], [20, 19, 8]));
    assert_eq!(structure.boundary_voxels(), 18 * 10 * 9 - 16 * 8 * 7);
}

/// A grid as sheared as is accepted: half the diagonal and the reach are far from those of a box, and interior voxels count.
#[test]
fn an_organ_of_skewed_cells_is_not_missed() {
    let rows = [[1.0, 0.9, 0.0, 0.0], [0.0, 0.44, 0.7, 0.0], [0.0, 0.0, 0.6, 0.0]];
    let grid = VolumeGrid::checked([40, 40, 40], Affine::from_rows(rows)).unwrap();
    let map = Map::of(grid, |_| 1);
    for k in 0..40 {
        let from = geometry::Point::new(14.0 + 0.11 * f64::from(k), 14.0 + 0.07 * f64::from(k), 15.0);
        let to = geometry::Point::new(25.0, 26.0 - 0.13 * f64::from(k), 25.5);
        let way = Tube::new(grid.ct_from_voxel() * from, grid.ct_from_voxel() * to, 0.02).unwrap();
        let found = all(&map, &way);
        let truth = map
            .labelled()
            .map(|(_, v)| signed(&way, centre(&grid, v)))
            .fold(f64::INFINITY, f64::min);
        assert!(
            (found[0].distance_mm() - truth).abs() < 1e-12 && found[0].cuts,
            "{found:?} {truth}"
        );
    }
}
