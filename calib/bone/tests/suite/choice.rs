//! Which bone is taken, and what is refused.

use bone::{Cut, Options, Refused, Region, extract};
use geometry::{Affine, VolumeGrid};

use crate::common::{Body, Cortex, Dense, Scene, grid, scan};

/// A ball of 12 mm at the origin and one of 8 mm, 26 mm beside it.
fn two() -> (Scene, Dense) {
    let mut scene = Scene::new(Body::Ball { radius: 12.0 }, Cortex::Even(2.0), 3.0, 1.3);
    (scene.turn, scene.margin_mm) = ([0.0; 3], 30.0);
    scene.other = Some(([26.0, 0.0, 0.0], 8.0));
    let ct = scan(&scene, grid(&scene));
    (scene, ct)
}

fn centre(bone: &bone::Bone) -> [f64; 3] {
    let n = bone.places.len() as f64;
    bone.places
        .iter()
        .fold([0.0; 3], |sum, p| [0, 1, 2].map(|k| sum[k] + p.mm[k] / n))
}

#[test]
fn of_several_bodies_none_is_chosen_and_each_way_of_saying_which_is_heard() {
    let (_, ct) = two();
    let refused = extract(&ct, &Options::of(Region::Only)).unwrap_err();
    let Refused::Which { count: 2, largest } = &refused else {
        unreachable!("{refused}")
    };
    assert!(largest[0].volume_ml > largest[1].volume_ml && (largest[1].centre_mm[0] - 26.0).abs() < 1.0);
    assert!(refused.to_string().contains("heart"), "{refused}");
    // What is in the little ball is not marrow: its label is a box.
    let is_in = |voxel: [u32; 3]| {
        let at = ct.grid.ct_from_voxel()
            * geometry::Point::new(f64::from(voxel[0]), f64::from(voxel[1]), f64::from(voxel[2]));
        (at.mm()[0] - 26.0).abs() < 7.0 && at.mm()[1].abs() < 7.0 && at.mm()[2].abs() < 7.0
    };
    let little = [
        Region::Seed { mm: [33.0, 0.0, 0.0] },
        Region::Number(2),
        Region::Box {
            corners_mm: [[40.0, 15.0, -15.0], [15.0, -15.0, 15.0]],
        },
        Region::Labelled {
            is_in: &is_in,
            grow_mm: 6.0,
        },
    ];
    for region in little {
        let bone = extract(&ct, &Options::of(region)).unwrap();
        // The mean of the corners goes by where the grid has them.
        assert!((centre(&bone)[0] - 26.0).abs() < 1.0, "{:?}", centre(&bone));
    }
}

#[test]
fn what_is_no_place_of_a_bone_is_refused_with_numbers() {
    let (_, ct) = two();
    let refused = |region| extract(&ct, &Options::of(region)).unwrap_err();
    assert!(matches!(refused(Region::Seed { mm: [0.0, -25.0, 0.0] }), Refused::Seed { level, .. } if level == 200.0));
    for region in [
        Region::Seed { mm: [900.0, 0.0, 0.0] },
        Region::Seed {
            mm: [f64::NAN, 0.0, 0.0],
        },
        Region::Box {
            corners_mm: [[500.0; 3], [600.0; 3]],
        },
        Region::Labelled {
            is_in: &|_| false,
            grow_mm: 3.0,
        },
    ] {
        assert!(matches!(refused(region), Refused::Outside { .. }));
    }
    assert!(matches!(
        refused(Region::Number(3)),
        Refused::NoComponent { asked: 3, count: 2 }
    ));
    let mut options = Options::of(Region::Number(1));
    options.level_hu = 5000.0;
    assert!(matches!(extract(&ct, &options), Err(Refused::Option { .. })));
}

/// Attenuation in 1/cm instead of HU has nothing above 200; a heart with contrast has no cortex; slices of 6 mm show none.
#[test]
fn what_is_no_ct_of_bone_is_refused() {
    let (scene, ct) = two();
    let mut other = Dense {
        grid: ct.grid,
        hu: ct.hu.iter().map(|hu| hu / 100).collect(),
    };
    assert!(matches!(
        extract(&other, &Options::of(Region::Number(1))),
        Err(Refused::NoBone { brightest, .. }) if brightest < 20
    ));
    let mut heart = scene.clone();
    heart.hu = [40.0, 350.0, 350.0];
    other = scan(&heart, grid(&heart));
    let refused = extract(&other, &Options::of(Region::Number(1))).unwrap_err();
    assert!(
        matches!(refused, Refused::NoCortex { share, .. } if share > 60.0),
        "{refused}"
    );
    let rows = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 6.0, 0.0]];
    let thick = Dense {
        grid: VolumeGrid::checked([4; 3], Affine::from_rows(rows)).unwrap(),
        hu: vec![0; 64],
    };
    assert!(matches!(
        extract(&thick, &Options::of(Region::Only)),
        Err(Refused::Coarse { axis: 2, .. })
    ));
}

/// Balls of 12 and 8 mm that touch are one body; a plane cuts them, and what is left is open there.
#[test]
fn a_joint_is_cut_by_a_plane() {
    let (mut scene, _) = two();
    scene.other = Some(([19.0, 0.0, 0.0], 8.0));
    let ct = scan(&scene, grid(&scene));
    let cuts = [Cut {
        place_mm: [11.5, 0.0, 0.0],
        normal: [1.0, 0.0, 0.0],
    }];
    let mut options = Options::of(Region::Only);
    options.cuts = &cuts;
    // The other half is kept out as well, and is no body of its own.
    let bone = extract(&ct, &options).unwrap();
    assert!(bone.lost.contains_key(&bone::Lost::Cut), "{:?}", bone.lost);
    let farthest = bone.places.iter().map(|p| p.mm[0]).fold(f64::NEG_INFINITY, f64::max);
    assert!(farthest < 12.5, "{farthest}");
    let error = bone
        .places
        .iter()
        .map(|p| scene.body.distance(p.mm.into()).abs())
        .fold(0.0, f64::max);
    assert!(error < 1.5, "{error}");
}

/// The neighbour's blurred edge reaches over the cut: no place of its surface is taken, also where the plane goes through voxels' centres.
#[test]
fn a_cut_leaves_nothing_of_the_neighbours_surface() {
    let mut scene = Scene::new(Body::Ball { radius: 12.0 }, Cortex::Even(2.0), 1.0, 0.7);
    (scene.turn, scene.margin_mm) = ([0.0; 3], 10.0);
    let grid = grid(&scene);
    let first = (grid.ct_from_voxel() * geometry::Point::new(0.0, 0.0, 0.0)).mm()[0];
    // Nearly flat, as the other side of a joint, half a voxel beyond a row of voxels: those are as bright as bone by its blur.
    let on_voxels = first + (12.2 - first).round();
    scene.other = Some(([on_voxels + 900.5, 0.0, 0.0], 900.0));
    let ct = scan(&scene, grid);
    for at in [on_voxels, on_voxels + 0.3, on_voxels - 0.3] {
        let cuts = [Cut {
            place_mm: [at, 0.0, 0.0],
            normal: [2.0, 0.0, 0.0],
        }];
        let mut options = Options::of(Region::Seed { mm: [-11.0, 0.0, 0.0] });
        options.cuts = &cuts;
        let bone = extract(&ct, &options).unwrap();
        let off = bone.places.iter().map(|p| p.mm.norm() - 12.0).fold(0.0, f64::max);
        assert!(off < 0.6, "cut at {at}: {off}, {:?}", bone.lost);
        assert!(bone.lost.contains_key(&bone::Lost::Cut));
    }
}

/// A CT whose zero is air's has no tissue below the threshold: that is said, and not that it ends.
#[test]
fn a_ct_that_is_bone_throughout_is_refused_by_that_name() {
    let (_, ct) = two();
    let shifted = Dense {
        grid: ct.grid,
        hu: ct.hu.iter().map(|hu| hu + 1000).collect(),
    };
    let refused = extract(&shifted, &Options::of(Region::Only)).unwrap_err();
    assert!(
        matches!(refused, Refused::AllBone { share, darkest, .. } if share > 95.0 && darkest > 900),
        "{refused}"
    );
}

/// What is said of a region is of the region: the little ball, without contrast and bone, beside the other's cortex of 1300 HU.
#[test]
fn the_brightest_voxel_that_is_named_is_of_the_region() {
    let (_, ct) = two();
    let box_of = |corners_mm| extract(&ct, &Options::of(Region::Box { corners_mm })).unwrap_err();
    // In the other's marrow, 200 HU: with a threshold above it.
    let mut options = Options::of(Region::Box {
        corners_mm: [[-3.0; 3], [3.0; 3]],
    });
    options.level_hu = 600.0;
    let refused = extract(&ct, &options).unwrap_err();
    assert!(
        matches!(refused, Refused::NoBone { brightest, .. } if (100..400).contains(&brightest)),
        "{refused}"
    );
    // All bone is cut away.
    let cuts = [Cut {
        place_mm: [-25.0, 0.0, 0.0],
        normal: [1.0, 0.0, 0.0],
    }];
    let mut cut = Options::of(Region::Only);
    cut.cuts = &cuts;
    let refused = extract(&ct, &cut).unwrap_err();
    assert!(
        matches!(refused, Refused::NoBone { brightest, .. } if brightest < 200),
        "{refused}"
    );
    // Between the voxels' centres.
    assert_eq!(box_of([[0.1; 3], [0.2; 3]]), Refused::Empty);
    // Brighter than metal counts as none.
    options.metal_hu = 1100;
    let refused = extract(&ct, &options).unwrap_err();
    assert!(refused.to_string().contains("metal of 1100 HU"), "{refused}");
}
