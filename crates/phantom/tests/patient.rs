//! The generated patient against what a surgeon, a registration and a sampler expect of it.

use geometry::{Affine, Ct, Point, Vector, VolumeGrid};
use phantom::{AIR_HU, DEFAULT_SEED, Landmark, Phantom};

const SEEDS: std::ops::Range<u64> = 0..24;

fn default_patient() -> Phantom {
    Phantom::new(DEFAULT_SEED)
}

/// Twenty-six directions: the corners, edges and faces of a cube.
fn directions() -> Vec<Vector<Ct>> {
    let steps = [-1.0, 0.0, 1.0];
    let all = steps
        .iter()
        .flat_map(|&x| steps.iter().flat_map(move |&y| steps.map(|z| Vector::new(x, y, z))));
    all.filter_map(Vector::direction).map(|d| d * 1.0).collect()
}

fn assert_slices_equal_hu(patient: &Phantom, grid: &VolumeGrid, slices: &[u32]) {
    let [nx, ny, _] = grid.dims();
    let mut out = vec![0_i16; (nx * ny) as usize];
    for &k in slices {
        patient.fill_slice(grid, k, &mut out);
        for (at, &found) in (0_u32..).zip(&out) {
            let voxel = Point::new(f64::from(at % nx), f64::from(at / nx), f64::from(k));
            let want = patient.hu(grid.ct_from_voxel() * voxel).round() as i16;
            assert_eq!(found, want, "slice {k}, voxel {at}");
        }
    }
}

#[test]
fn slices_equal_the_field_bit_for_bit() {
    let patient = default_patient();
    let grid = patient.grid([3.0, 2.5, 7.0]).unwrap();
    let slices: Vec<u32> = (0..grid.dims()[2]).step_by(3).collect();
    assert_slices_equal_hu(&patient, &grid, &slices);
}

#[test]
fn tilted_and_mirrored_grids_equal_the_field_too() {
    let patient = default_patient();
    let rows = [
        [-2.1, 0.3, 0.4, 150.0],
        [0.2, 1.9, -1.1, -80.0],
        [-0.5, 0.8, 3.0, -20.0],
    ];
    let grid = VolumeGrid::checked([140, 90, 40], Affine::from_rows(rows)).unwrap();
    assert_slices_equal_hu(&patient, &grid, &[0, 7, 20, 39]);
}

#[test]
fn a_seed_is_one_patient_and_another_seed_another() {
    let probe = |seed| {
        let patient = Phantom::new(seed);
        let hu = |i: i32| patient.hu(Point::new(f64::from(i) * 0.7 - 140.0, 12.0, f64::from(i % 97) - 20.0));
        (0..400).map(hu).collect::<Vec<f64>>()
    };
    assert_eq!(probe(5), probe(5));
    assert_ne!(probe(5), probe(6));
}

#[test]
fn every_node_lies_in_fat() {
    for seed in SEEDS {
        let patient = Phantom::new(seed);
        assert_eq!(patient.targets().len(), 5);
        for node in patient.targets() {
            assert!(
                (patient.hu(node.centre) - 60.0).abs() < 1e-9,
                "seed {seed} {}",
                node.name
            );
            for d in directions() {
                // 3.2 mm is outside the node's ramp, which ends at 3 mm.
                let around = patient.hu(node.centre + d * 3.2);
                assert!(
                    (-120.0..-60.0).contains(&around),
                    "seed {seed} {}: {around} HU at {d:?}",
                    node.name
                );
            }
        }
    }
}

#[test]
fn every_bead_peaks_on_the_skin() {
    for seed in SEEDS {
        let patient = Phantom::new(seed);
        assert_eq!(patient.beads().len(), 8);
        for Landmark {
            name,
            centre,
            diameter_mm,
        } in patient.beads()
        {
            assert_eq!(*diameter_mm, 2.0);
            assert_eq!(patient.hu(*centre), 3000.0, "seed {seed} {name}");
            let around: Vec<f64> = directions().iter().map(|&d| patient.hu(*centre + d * 2.0)).collect();
            assert!(around.iter().all(|&hu| hu < 60.0), "seed {seed} {name}: {around:?}");
            assert!(around.contains(&AIR_HU), "seed {seed} {name} is buried: {around:?}");
            assert!(
                around.iter().any(|&hu| hu > -400.0),
                "seed {seed} {name} floats: {around:?}"
            );
        }
    }
}

#[test]
fn beads_are_told_apart_by_their_distances() {
    let patient = default_patient();
    let beads = patient.beads();
    for (i, a) in beads.iter().enumerate() {
        for b in &beads[i + 1..] {
            assert!(a.centre.distance(b.centre) > 20.0, "{} and {}", a.name, b.name);
        }
    }
}

#[test]
fn the_way_in_meets_neither_bone_nor_vessel_nor_gas() {
    for seed in SEEDS {
        let patient = Phantom::new(seed);
        let approach = patient.approach();
        let target = patient.targets().iter().find(|t| t.name == approach.target).unwrap();
        let length = approach.entry.distance(target.centre);
        let stop = (length - 5.0) / length;
        let lengthwise = target.centre - approach.entry;
        let lift = Vector::new(0.0, 0.0, 1.0);
        let level = lift.cross(lengthwise).direction().unwrap();
        // The tube's axis and eight lines on its wall, 5 mm from the axis; from 3 mm under the skin on.
        for line in 0..9 {
            let angle = f64::from(line) * std::f64::consts::FRAC_PI_4;
            let out = if line == 8 { 0.0 } else { 5.0 };
            let aside = level * (out * angle.cos()) + lift * (out * angle.sin());
            for i in 0..=1000 {
                let s = 4.0 / length + (stop - 4.0 / length) * f64::from(i) / 1000.0;
                let hu = patient.hu(approach.entry.lerp(target.centre, s) + aside);
                assert!(
                    (-200.0..200.0).contains(&hu),
                    "seed {seed} line {line}: {hu} HU at share {s}"
                );
            }
        }
    }
}

#[test]
fn the_entry_is_on_the_left_flank_skin() {
    for seed in SEEDS {
        let patient = Phantom::new(seed);
        let entry = patient.approach().entry;
        let [x, y, _] = entry.mm();
        assert!(x > 120.0 && y > 10.0, "seed {seed}: {entry:?}");
        let outwards = Vector::new(1.0, 0.2, 0.0);
        assert_eq!(patient.hu(entry + outwards * 2.0), AIR_HU);
        assert!(patient.hu(entry - outwards * 3.0) > -150.0);
    }
}

#[test]
fn sides_are_where_a_patient_has_them() {
    for seed in SEEDS {
        let patient = Phantom::new(seed);
        let hu = |x, y, z| patient.hu(Point::new(x, y, z));
        assert!(
            (100.0..120.0).contains(&hu(-110.0, -20.0, 175.0)),
            "liver at the right, seed {seed}"
        );
        assert!(
            hu(12.0, 3.0, 60.0) > 290.0,
            "aorta just left of the middle, seed {seed}"
        );
        assert!(
            (140.0..160.0).contains(&hu(-17.0, 3.0, 60.0)),
            "cava at the right, seed {seed}"
        );
        assert!(hu(0.0, 32.0, 74.0) > 190.0, "L3 in the middle at the back, seed {seed}");
        assert!(
            (115.0..130.0).contains(&hu(118.0, 34.0, 168.0)),
            "spleen at the left, seed {seed}"
        );
    }
}

#[test]
fn air_lies_all_around() {
    for seed in SEEDS {
        let patient = Phantom::new(seed);
        let grid = patient.grid([1.5; 3]).unwrap();
        let (low, high) = grid.bounds();
        let inside = |p: [f64; 3]| (0..3).all(|i| p[i] > low.mm()[i] + 3.0 && p[i] < high.mm()[i] - 3.0);
        for i in 0..200_u32 {
            for j in 0..200_u32 {
                let (u, v) = (f64::from(i) * 2.0 - 200.0, f64::from(j) * 2.0 - 180.0);
                for p in [
                    [u, -125.0, v],
                    [u, 125.0, v],
                    [-179.0, u, v],
                    [179.0, u, v],
                    [u, v, -131.5],
                    [u, v, 211.5],
                ] {
                    assert_eq!(patient.hu(Point::new(p[0], p[1], p[2])), AIR_HU, "seed {seed} {p:?}");
                }
            }
        }
        assert!(patient.beads().iter().all(|b| inside(b.centre.mm())));
    }
}

#[test]
fn the_field_is_smooth() {
    let patient = default_patient();
    // A quintic ramp's steepest slope is 1.875 / width; the steepest thing is a bead in air, 4000 HU over 1 mm. A field
    // with a step anywhere would give 1e4 times the step.
    let steepest = 1.875 * 4000.0;
    let step = 1e-4;
    for i in 0..200_000_u32 {
        let f = |m: u32, span: f64| f64::from(i.wrapping_mul(m) >> 8) / f64::from(1 << 24) * span;
        let p = Point::new(
            f(2_654_435_761, 350.0) - 175.0,
            f(40_503_001, 240.0) - 120.0,
            f(3_266_489_917, 340.0) - 130.0,
        );
        for d in [
            Vector::new(step, 0.0, 0.0),
            Vector::new(0.0, step, 0.0),
            Vector::new(0.0, 0.0, step),
        ] {
            let slope = (patient.hu(p + d) - patient.hu(p)).abs() / step;
            assert!(slope < steepest, "{slope} HU/mm at {p:?}");
        }
    }
}

#[test]
fn default_grid_has_the_documented_size() {
    let grid = default_patient().grid(phantom::DEFAULT_SPACING_MM).unwrap();
    assert_eq!(grid.dims(), [240, 168, 232]);
    assert_eq!(grid.centre().mm(), [0.0, 0.0, 40.0]);
}

#[test]
fn unusable_spacings_are_refused() {
    let patient = default_patient();
    for bad in [0.0, -1.5, f64::NAN, f64::INFINITY, 1e-300, 1e300] {
        assert!(patient.grid([1.5, bad, 1.5]).is_err(), "{bad}");
    }
}

#[test]
fn nothing_is_anywhere_without_a_place() {
    let patient = default_patient();
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        assert_eq!(patient.hu(Point::new(bad, 0.0, 0.0)), AIR_HU);
    }
}

#[test]
fn short_and_long_buffers_are_no_accident() {
    let patient = default_patient();
    let grid = patient.grid([20.0; 3]).unwrap();
    let [nx, ny, _] = grid.dims();
    let mut long = vec![7_i16; (nx * ny + 5) as usize];
    patient.fill_slice(&grid, 9, &mut long);
    assert!(long[(nx * ny) as usize..].iter().all(|&v| v == 7));
    patient.fill_slice(&grid, 9, &mut []);
}

/// A structure is where its HU are, and a slice of structures is what each place says.
#[test]
fn structures_lie_where_their_tissue_does() {
    use phantom::structure::{
        AORTA, ILIAC_ARTERIES, ILIAC_VEINS, KIDNEY_LEFT, KIDNEY_RIGHT, MUSCLES_LEFT, MUSCLES_RIGHT, NODES, VENA_CAVA,
    };
    let patient = default_patient();
    let grid = patient.grid([4.0; 3]).unwrap();
    let [nx, ny, nz] = grid.dims();
    let mut counts = std::collections::BTreeMap::<u16, usize>::new();
    let mut slice = vec![0_i16; (nx * ny) as usize];
    for k in 0..nz {
        patient.fill_structures(&grid, k, &mut slice);
        for (at, label) in slice.iter().enumerate() {
            let voxel = [at as u32 % nx, at as u32 / nx, k].map(f64::from);
            let place: Point<geometry::Ct> = grid.ct_from_voxel() * Point::new(voxel[0], voxel[1], voxel[2]);
            let label = *label as u16;
            assert_eq!(label, patient.structure(place));
            *counts.entry(label).or_default() += 1;
            let hu = patient.hu(place);
            match label {
                // Sinus and pelvis are a kidney's, and at its rim fat is half of it.
                KIDNEY_LEFT | KIDNEY_RIGHT => {
                    assert_eq!(label == KIDNEY_LEFT, place.mm()[0] > 0.0);
                    assert!((-100.0..300.0).contains(&hu), "{hu} at {place:?}");
                }
                label if MUSCLES_LEFT.contains(&label) || MUSCLES_RIGHT.contains(&label) => {
                    // At its rim half of it is fat, or a part of it each of several bones; at the scan's ends half of that is air.
                    let is_whole = (-128.0..208.0).contains(&place.mm()[2]);
                    assert!(!is_whole || (-30.0..720.0).contains(&hu), "{hu} at {place:?}");
                }
                // Contrast, half of it fat at the rim; half of it air at the scan's ends. Iliac vessels lie in one another's rims, and at bone.
                AORTA | VENA_CAVA => {
                    assert_eq!(label == AORTA, place.mm()[0] > -3.0, "{place:?}");
                    let is_whole = place.mm()[2] < 208.0;
                    assert!(!is_whole || (20.0..310.0).contains(&hu), "{hu} at {place:?}");
                }
                label if ILIAC_ARTERIES.contains(&label) || ILIAC_VEINS.contains(&label) => {
                    let is_left = [ILIAC_ARTERIES[0], ILIAC_VEINS[0]].contains(&label);
                    assert!(
                        if is_left {
                            place.mm()[0] > -28.0
                        } else {
                            place.mm()[0] < 13.0
                        },
                        "{place:?}"
                    );
                }
                label if NODES.contains(&label) => {
                    let number = NODES.iter().position(|node| *node == label).unwrap();
                    assert!(patient.targets()[number].centre.distance(place) < 2.6, "{place:?}");
                }
                _ => assert_eq!(label, 0),
            }
        }
    }
    // An ellipsoid of 28, 24 and 54 mm has 152 ml, that is 2375 voxels of 4 mm; this seed's are up to 8 % larger or smaller a side.
    for kidney in [KIDNEY_LEFT, KIDNEY_RIGHT] {
        assert!((1800..3000).contains(&counts[&kidney]), "{counts:?}");
    }
    // A cylinder of 9.5 mm and 184 of length is 815 voxels; a ball of 5 mm, one.
    assert!((700..900).contains(&counts[&AORTA]), "{counts:?}");
    assert!(
        [VENA_CAVA, 65, 66, 67, 68].iter().all(|label| counts[label] > 80),
        "{counts:?}"
    );
    for (label, node) in NODES.iter().zip(patient.targets()) {
        assert_eq!(patient.structure(node.centre), *label);
    }
    assert!(
        MUSCLES_LEFT
            .iter()
            .chain(&MUSCLES_RIGHT)
            .all(|label| counts[label] > 300)
    );
}
