//! Where the surface is open, and that what registers takes it.

use bone::{Lost, Options, Region, Voxels, extract};
use geometry::{Affine, Ct, Point, Vector, VolumeGrid, Voxel};
use surface_registration::Surface;

use crate::common::{Body, Cortex, Dense, Scene, grid, scan};

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

/// A CT with a value for what was not measured.
struct Padded(Dense, i16);

impl Voxels for Padded {
    fn grid(&self) -> &VolumeGrid {
        &self.0.grid
    }

    fn row(&self, y: u32, z: u32, out: &mut [i16]) {
        self.0.row(y, z, out);
    }

    fn padding_hu(&self) -> Option<i16> {
        Some(self.1)
    }
}

impl Padded {
    /// With this value wherever a place says.
    fn set(mut self, hu: i16, is_set: impl Fn([f64; 3]) -> bool) -> Self {
        let [nx, ny, _] = self.0.grid.dims().map(|d| d as usize);
        let affine = self.0.grid.ct_from_voxel();
        for (at, value) in self.0.hu.iter_mut().enumerate() {
            let index = [at % nx, at / nx % ny, at / (nx * ny)].map(|i| i as f64);
            if is_set((affine * Point::<Voxel>::new(index[0], index[1], index[2])).mm()) {
                *value = hu;
            }
        }
        self
    }
}

/// A hollow ball of 14 mm: its marrow is as dark as tissue.
fn hollow() -> (Scene, Dense) {
    let mut scene = Scene::new(Body::Ball { radius: 14.0 }, Cortex::Even(2.5), 1.5, 0.8);
    scene.hu[2] = 50.0;
    let ct = scan(&scene, grid(&scene));
    (scene, ct)
}

/// Places are the ball's by their deviations, none is of its inner wall, and some were lost where nothing was measured.
fn opens(scene: &Scene, ct: &Padded, name: &str) {
    let bone = extract(ct, &Options::of(Region::Number(1))).unwrap();
    for place in &bone.places {
        // As at the CT's end, and never half way to the inner wall.
        let error = scene.body.distance(place.mm.into()).abs();
        assert!(
            error < (5.0 * place.total_mm() + 0.1).min(1.25),
            "{name}: {error}: {place:?}"
        );
    }
    assert!(
        bone.lost.get(&Lost::End).is_some_and(|n| *n > 20),
        "{name}: {:?}",
        bone.lost
    );
    assert!(!surface(&bone).facts().open_ends.is_empty(), "{name}");
}

#[test]
fn padding_within_the_grid_opens_the_surface_and_the_inner_wall_is_not_taken() {
    let (scene, ct) = hollow();
    // A round field whose edge goes through the ball, a gap between slices, and a wedge: by values that no scanner measures, and by air's.
    let field = |[x, y, _]: [f64; 3]| (x + 8.0).hypot(y) > 18.0;
    let slab = |[x, _, z]: [f64; 3]| (0.3 * x + z - 3.0).abs() < 3.5;
    let of = |hu, padding_hu, is_set: &dyn Fn([f64; 3]) -> bool| {
        let ct = Dense {
            grid: ct.grid,
            hu: ct.hu.clone(),
        };
        opens(&scene, &Padded(ct, padding_hu).set(hu, is_set), &format!("{hu} HU"));
    };
    for (hu, padding_hu) in [(-3024, -1024), (-1024, -3024), (600, 600)] {
        of(hu, padding_hu, &field);
    }
    of(-2000, -2000, &slab);
}

/// What was not a number became the padding, alone in the cortex: the surface is open beside it, and right elsewhere.
#[test]
fn a_voxel_without_a_number_opens_the_surface_beside_it() {
    let (scene, ct) = hollow();
    let ct = Padded(ct, -1024).set(-1024, |p| (p[0] - 13.0).hypot(p[1]).hypot(p[2]) < 1.3);
    opens(&scene, &ct, "no number");
}

/// A bone in air, of which the scanner clips the half at -1024 HU: that was measured.
#[test]
fn air_that_a_scanner_clips_is_measured() {
    let mut scene = Scene::new(Body::Ball { radius: 12.0 }, Cortex::Even(2.0), 1.5, 0.8);
    scene.hu[0] = -1024.0;
    let mut ct = scan(&scene, grid(&scene));
    ct.hu.iter_mut().for_each(|hu| *hu = (*hu).max(-1024));
    let bone = extract(&Padded(ct, -1024), &Options::of(Region::Number(1))).unwrap();
    assert!(!bone.lost.contains_key(&Lost::End), "{:?}", bone.lost);
}

/// A hollow ball with a hole of 12 mm: what is outside reaches its inner wall, which is said and left out.
#[test]
fn the_inner_wall_behind_a_wide_hole_is_no_outer_surface() {
    let (scene, mut ct) = hollow();
    let affine = ct.grid.ct_from_voxel();
    let [nx, ny, _] = ct.grid.dims().map(|d| d as usize);
    for (at, value) in ct.hu.iter_mut().enumerate() {
        let index = [at % nx, at / nx % ny, at / (nx * ny)].map(|i| i as f64);
        let [x, y, z] = (affine * Point::<Voxel>::new(index[0], index[1], index[2])).mm();
        // Blurred as the rest is, nearly: a logistic for the normal distribution.
        let share = 1.0 / (1.0 + ((x.hypot(y) - 6.0) * 1.702 / 0.8).exp());
        if z > 0.0 {
            *value = (f64::from(*value) + (45.0 - f64::from(*value)) * share) as i16;
        }
    }
    let bone = extract(&ct, &Options::of(Region::Number(1))).unwrap();
    assert!(bone.lost.get(&Lost::Inner).is_some_and(|n| *n > 200), "{:?}", bone.lost);
    let inner = bone.places.iter().filter(|p| {
        let beside = p.mm[0].hypot(p.mm[1]);
        let d = scene.body.distance(p.mm.into());
        // The wall of the hole itself is a surface of this bone.
        (d + 2.5).abs() < 0.8 && (p.mm[2] < 0.0 || beside > 8.0)
    });
    assert_eq!(inner.count(), 0);
    assert!(bone.places.len() > 1000);
}
