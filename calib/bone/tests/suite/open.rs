//! Where the surface is open, and that what registers takes it.

use bone::{Lost, Options, Region, extract};
use geometry::{Affine, Ct, Point, Vector, VolumeGrid, Voxel};
use surface_registration::Surface;

use crate::common::{Body, Cortex, Scene, grid, scan};

fn surface(bone: &bone::Bone) -> Surface<Ct> {
    let corners: Vec<[f64; 3]> = bone.places.iter().map(|p| p.mm.into()).collect();
    Surface::new(&corners, &bone.triangles).unwrap()
}

/// A rod that the CT cuts through, marrow and all: open at that end, and closed where it is not cut.
#[test]
fn a_bone_that_the_ct_cuts_is_open_there_and_nowhere_else() {
    let mut scene = Scene::new(
        Body::Capsule {
            radius: 10.0,
            half: 20.0,
        },
        Cortex::Even(2.0),
        2.0,
        1.0,
    );
    scene.turn = [0.0; 3];
    let whole = grid(&scene);
    let mut dims = whole.dims().map(i64::from);
    dims[1] = dims[1] * 6 / 10;
    let cut = VolumeGrid::checked(dims, whole.ct_from_voxel()).unwrap();
    let last = (cut.ct_from_voxel() * Point::<Voxel>::new(0.0, (dims[1] - 1) as f64, 0.0)).mm()[1];
    let bone = extract(&scan(&scene, cut), &Options::of(Region::Number(1))).unwrap();
    assert!(bone.lost[&Lost::End] > 20, "{:?}", bone.lost);
    assert_eq!(bone.inner_triangles, 0);
    let surface = surface(&bone);
    let facts = surface.facts();
    assert_eq!((facts.parts, facts.open_ends.len()), (1, 1), "{facts:?}");
    assert!((facts.open_ends[0].centre_mm[1] - last).abs() < 4.0, "{facts:?}");
    // A deviation is right beside the end as well: of some thousand corners five deviations are the most that is to be expected.
    for place in &bone.places {
        let error = scene.body.distance(place.mm.into());
        assert!(error.abs() < 5.0 * place.total_mm() + 0.1, "{error}: {place:?}");
    }
}

/// A grid whose axes are left-handed, and one that is sheared by a gantry's tilt, give a surface whose outside is outside.
#[test]
fn whatever_the_axes_are_outside_is_outside() {
    let scene = Scene::new(Body::Ball { radius: 12.0 }, Cortex::Even(2.0), 2.0, 1.0);
    let straight = grid(&scene);
    let [x, y, z] = [0, 1, 2].map(|k| straight.ct_from_voxel().step(k).mm());
    let far = straight.ct_from_voxel() * Point::<Voxel>::new(0.0, 0.0, f64::from(straight.dims()[2] - 1));
    let first = straight.ct_from_voxel() * Point::<Voxel>::new(0.0, 0.0, 0.0);
    let vector = |v: [f64; 3]| Vector::<Ct>::new(v[0], v[1], v[2]);
    let back = vector(z.map(|c| -c));
    let tilted: [f64; 3] = [0, 1, 2].map(|k| z[k] + 0.25 * y[k]);
    let lower = (0..3).map(|k| first.mm()[k] - 0.125 * f64::from(straight.dims()[2]) * y[k]);
    let lower: Vec<f64> = lower.collect();
    for (origin, steps) in [
        (far, [vector(x), vector(y), back]),
        (
            Point::new(lower[0], lower[1], lower[2]),
            [vector(x), vector(y), vector(tilted)],
        ),
    ] {
        let grid = VolumeGrid::checked(straight.dims().map(i64::from), Affine::from_steps(origin, steps)).unwrap();
        let bone = extract(&scan(&scene, grid), &Options::of(Region::Number(1))).unwrap();
        let surface = surface(&bone);
        assert!(
            surface.facts().open_ends.is_empty(),
            "{:?} {:?}",
            bone.lost,
            surface.facts()
        );
        // Its own normals say the same as where the ball is.
        assert!(bone.places.iter().all(|p| p.normal.dot(&p.mm) > 0.0));
        assert!(surface.winding(Point::new(0.5, 0.3, 0.2)) > 0.99);
        let mean = bone
            .places
            .iter()
            .map(|p| scene.body.distance(p.mm.into()))
            .sum::<f64>()
            / bone.places.len() as f64;
        assert!(mean.abs() < 0.2, "{mean}");
    }
}

/// Of two balls 2 mm apart each is open where the other is too near to be told from it.
#[test]
fn another_bone_that_is_too_near_opens_the_surface() {
    let mut scene = Scene::new(Body::Ball { radius: 12.0 }, Cortex::Even(2.0), 1.5, 0.8);
    (scene.turn, scene.margin_mm) = ([0.0; 3], 22.0);
    scene.other = Some(([22.0, 0.0, 0.0], 8.0));
    let ct = scan(&scene, grid(&scene));
    let mut options = Options::of(Region::Seed { mm: [-11.0, 0.0, 0.0] });
    // At 200 HU they are one.
    options.level_hu = 700.0;
    let bone = extract(&ct, &options).unwrap();
    let near: Vec<f64> = bone
        .places
        .iter()
        .filter(|p| p.mm[0] > 11.0)
        .map(|p| (scene.body.distance(p.mm.into()) / p.total_mm()).abs())
        .collect();
    // What is kept there is right by its deviation, and something was not kept.
    assert!(bone.lost.contains_key(&Lost::Other), "{:?}", bone.lost);
    assert!(near.iter().all(|z| *z < 5.0), "{near:?}");
}
