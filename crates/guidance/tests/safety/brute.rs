//! Everything that is said of random tubes in random maps, by looking at every voxel.

use std::collections::BTreeMap;

use chance::SplitMix64;
use geometry::Point;
use guidance::safety::{Clearance, Distance, Section, Tube};
use proptest::prelude::*;

use crate::support::{Map, centre, outside, random_map, random_tube, rounding, signed};

/// The least signed distance of each label, by force.
fn forced(map: &Map, tube: &Tube) -> BTreeMap<i16, f64> {
    let mut least = BTreeMap::new();
    for (label, voxel) in map.labelled() {
        let mm = signed(tube, centre(&map.grid, voxel));
        let so_far = least.entry(label).or_insert(f64::INFINITY);
        *so_far = mm.min(*so_far);
    }
    least
}

/// Whether the axis meets a cell, to `doubt` of a voxel: the largest difference of indices is convex along the axis, and its least is
/// found by thirds.
fn pierced(map: &Map, tube: &Tube, voxel: [u32; 3]) -> Option<bool> {
    let far = |s: f64| {
        let index = (map.grid.voxel_from_ct() * tube.entry().lerp(tube.tip(), s)).mm();
        (0..3)
            .map(|k| (index[k] - f64::from(voxel[k])).abs())
            .fold(0.0, f64::max)
    };
    let (mut a, mut b) = (0.0, 1.0);
    for _ in 0..90 {
        let (c, d) = (a + (b - a) / 3.0, b - (b - a) / 3.0);
        if far(c) < far(d) { b = d } else { a = c }
    }
    let least = far(a).min(far(0.0)).min(far(1.0));
    let doubt = 1e-7;
    ((least - 0.5).abs() > doubt).then_some(least < 0.5)
}

fn forced_cut(map: &Map, tube: &Tube, label: i16) -> Option<bool> {
    // The centre of a cell that the axis meets is no farther from it than half of the three steps together.
    let near = map.grid.spacing_mm().iter().sum::<f64>() / 2.0;
    let of_label = || map.labelled().filter(|(l, _)| *l == label).map(|(_, voxel)| voxel);
    if of_label().any(|voxel| signed(tube, centre(&map.grid, voxel)) <= 0.0) {
        return Some(true);
    }
    let close = of_label().filter(|voxel| signed(tube, centre(&map.grid, *voxel)) <= near);
    let verdicts: Vec<_> = close.map(|voxel| pierced(map, tube, voxel)).collect();
    match () {
        () if verdicts.contains(&Some(true)) => Some(true),
        () if verdicts.contains(&None) => None,
        () => Some(false),
    }
}

/// A section's distance by force: that of the tube between its depths, and within it that of the whole.
fn forced_section(map: &Map, tube: &Tube, section: &Section) -> f64 {
    let of = |voxel| {
        let p = centre(&map.grid, voxel);
        let mm = outside(tube, [section.from_mm, section.to_mm], p);
        if mm > 0.0 { mm } else { signed(tube, p) }
    };
    map.labelled().map(|(_, voxel)| of(voxel)).fold(f64::INFINITY, f64::min)
}

fn check_clearance(map: &Map, tube: &Tube, within_mm: f64) {
    let structures = map.build();
    let (least, bound) = (forced(map, tube), rounding(tube, &map.grid));
    let found = structures.clearance(tube, within_mm).unwrap().structures;
    assert_eq!(found.len(), least.len());
    assert!(found.is_sorted_by_key(Clearance::distance_mm));
    for clearance in &found {
        let truth = least[&clearance.label];
        match clearance.distance {
            Distance::Nearest(nearest) => {
                assert!((nearest.distance_mm - truth).abs() <= bound, "{clearance:?} {truth}");
                let p = centre(&map.grid, nearest.voxel);
                assert_eq!(nearest.point, p);
                assert!((signed(tube, p) - truth).abs() <= bound);
                let depth = (p - tube.entry()).dot(tube.axis().vector());
                assert!((nearest.depth_mm - depth).abs() <= bound);
                let [x, y, _] = map.grid.dims();
                let at = nearest.voxel[0] + x * (nearest.voxel[1] + y * nearest.voxel[2]);
                assert_eq!(map.labels[at as usize], clearance.label);
            }
            Distance::Beyond { within_mm: searched } => {
                assert!(
                    searched >= within_mm && truth >= searched - bound,
                    "{clearance:?} {truth}"
                );
            }
        }
        if let Some(cuts) = forced_cut(map, tube, clearance.label) {
            // A centre on the surface may be on either side.
            assert!(clearance.cuts == cuts || truth.abs() <= bound, "{clearance:?} {truth}");
        }
    }
}

fn check_profile(map: &Map, tube: &Tube, sections: usize, within_mm: f64) {
    let structures = map.build();
    let bound = rounding(tube, &map.grid);
    let found = structures.profile(tube, sections, within_mm).unwrap();
    assert_eq!(found.len(), sections);
    let mut least = f64::INFINITY;
    for section in &found {
        let truth = forced_section(map, tube, section);
        // A centre on the face between two sections belongs to both, and by rounding to one.
        let distance = section.nearest.map_or(within_mm, |(_, nearest)| nearest.distance_mm);
        let is_right = (distance - truth.min(within_mm)).abs() <= bound;
        let on_a_face = distance <= bound && truth <= bound;
        assert!(is_right || on_a_face, "{section:?} {truth} {within_mm}");
        if let Some((label, nearest)) = section.nearest {
            assert_eq!(map.at(centre(&map.grid, nearest.voxel)), label);
            least = least.min(nearest.distance_mm);
        }
    }
    let whole = forced(map, tube).into_values().fold(f64::INFINITY, f64::min);
    assert!(
        (least.min(within_mm) - whole.min(within_mm)).abs() <= bound,
        "{least} {whole}"
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn clearance_is_that_of_every_voxel(seed: u64, within in prop_oneof![Just(0.0), 0.0..20.0, Just(1e4)]) {
        let mut random = SplitMix64::new(seed);
        let map = random_map(&mut random);
        check_clearance(&map, &random_tube(&map.grid, &mut random), within);
    }

    #[test]
    fn a_profile_is_that_of_every_voxel(seed: u64, sections in 1_usize..16, within in prop_oneof![Just(0.0), 0.0..20.0, Just(1e4)]) {
        let mut random = SplitMix64::new(seed);
        let map = random_map(&mut random);
        let tube = random_tube(&map.grid, &mut random);
        check_profile(&map, &tube, sections, within);
    }

    /// Whatever cell the tube touches, its structure is said not to be clear; and no point of a cell is nearer than is promised.
    #[test]
    fn what_is_clear_is_touched_by_no_cell(seed: u64) {
        let mut random = SplitMix64::new(seed);
        let map = random_map(&mut random);
        let tube = random_tube(&map.grid, &mut random);
        let found = map.build().clearance(&tube, 1e4).unwrap();
        let bound = rounding(&tube, &map.grid);
        let of: BTreeMap<i16, Clearance> = found.structures.iter().map(|c| (c.label, *c)).collect();
        for _ in 0..300 {
            let depth = random.around(tube.length_mm() / 2.0, tube.length_mm() / 2.0);
            let (turn, off) = (random.around(0.0, 3.2), tube.radius_mm() * random.around(0.5, 0.5));
            let p = tube.at(depth) + across(&tube, turn) * off;
            let label = map.at(p);
            if label != 0 {
                let clearance = of[&label];
                prop_assert!(!clearance.is_clear() || clearance.distance_mm() - clearance.voxel_half_diagonal_mm < bound);
            }
        }
        for (label, voxel) in map.labelled().step_by(7) {
            let index = [0, 1, 2].map(|k: usize| f64::from(voxel[k]) + random.around(0.0, 0.5));
            let p = map.grid.ct_from_voxel() * Point::new(index[0], index[1], index[2]);
            if let Some(least) = of[&label].at_least_mm(Some(0.0)) {
                prop_assert!(signed(&tube, p) >= least - bound);
            }
        }
    }

    /// Where a disc of the tube is outside, a polygon about it stands out of the field; where it is inside, its rim does not.
    #[test]
    fn coverage_is_that_of_points(seed: u64) {
        let mut random = SplitMix64::new(seed);
        let map = random_map(&mut random);
        let tube = random_tube(&map.grid, &mut random);
        let coverage = map.build().clearance(&tube, 0.0).unwrap().coverage;
        for _ in 0..60 {
            let depth = random.around(tube.length_mm() / 2.0, tube.length_mm() / 2.0);
            let is_out = |radius: f64| (0..1000).any(|k| {
                let turn = f64::from(k) * std::f64::consts::TAU / 1000.0;
                !map.grid.holds(tube.at(depth) + across(&tube, turn) * radius)
            });
            // A polygon of 1000 corners holds the circle that is smaller by 1 - cos(pi / 1000), which is 5e-6 of it.
            prop_assert!(coverage.holds(depth, depth) || is_out(tube.radius_mm() * 1.00001 + 1e-8), "{coverage:?} {depth}");
            prop_assert!(!coverage.holds(depth, depth) || !is_out(tube.radius_mm() - 1e-8), "{coverage:?} {depth}");
        }
    }

    /// No place outside the field is nearer than the margin, and every one of six planes is reached at it or beyond.
    #[test]
    fn the_margin_is_the_way_out(seed: u64) {
        let mut random = SplitMix64::new(seed);
        let map = random_map(&mut random);
        let tube = random_tube(&map.grid, &mut random);
        let coverage = map.build().clearance(&tube, 0.0).unwrap().coverage;
        prop_assert_eq!(coverage.is_whole(), coverage.outside_mm().is_empty());
        prop_assert_eq!(coverage.is_whole(), coverage.margin_mm >= 0.0);
        if coverage.is_whole() {
            let dims = map.grid.dims().map(f64::from);
            for k in 0..600 {
                let mut index = [0, 1, 2].map(|k: usize| random.around(dims[k] / 2.0 - 0.5, dims[k] / 2.0));
                index[k % 3] = if k % 2 == 0 { -0.5 } else { dims[k % 3] - 0.5 };
                let p = map.grid.ct_from_voxel() * Point::new(index[0], index[1], index[2]);
                prop_assert!(signed(&tube, p) >= coverage.margin_mm - rounding(&tube, &map.grid));
            }
        }
    }
}

/// A direction across the tube.
fn across(tube: &Tube, turn: f64) -> geometry::Vector<geometry::Ct> {
    let axis = tube.axis().vector();
    let helper = if axis.mm()[0].abs() < 0.8 {
        geometry::Vector::new(1.0, 0.0, 0.0)
    } else {
        geometry::Vector::new(0.0, 1.0, 0.0)
    };
    let u = helper.cross(axis).direction().unwrap();
    let v = axis.cross(u.vector());
    u * turn.cos() + v * turn.sin()
}
