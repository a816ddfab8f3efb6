//! Where the surface lies, against bodies in closed form.

use bone::{Bone, Options, Region, extract};

use crate::common::{Body, Cortex, Scene, grid, scan};

fn taken(scene: &Scene) -> Bone {
    let ct = scan(scene, grid(scene));
    extract(&ct, &Options::of(Region::Number(1))).unwrap()
}

/// Mean error, root mean square of the errors over their deviations, share within 1.96 of them.
fn errors(scene: &Scene, bone: &Bone) -> [f64; 3] {
    let n = bone.places.len() as f64;
    let errors = bone
        .places
        .iter()
        .map(|p| (scene.body.distance(p.mm.into()), p.total_mm()));
    let (mut mean, mut squares, mut within) = (0.0, 0.0, 0.0);
    for (error, deviation) in errors {
        mean += error / n;
        squares += (error / deviation).powi(2) / n;
        within += f64::from(u8::from(error.abs() < 1.96 * deviation)) / n;
    }
    [mean, squares.sqrt(), within]
}

/// What the issue that asked for it holds a mean error to, at 0.7, 1.5 and 3 mm voxels: a threshold's is 0.5, 0.9 and 1.3 mm.
fn most(step_mm: f64) -> f64 {
    match step_mm {
        s if s < 1.0 => 0.05,
        s if s < 2.0 => 0.15,
        _ => 0.4,
    }
}

/// The errors of one body go together by blur and cortex, and those of neighbours by the voxels that they share: of a body the ratio may be
/// anything between a third and one and a half of what is stated, and never more.
fn holds(scene: &Scene) {
    let bone = taken(scene);
    let [mean, ratio, within] = errors(scene, &bone);
    assert!(mean.abs() < most(scene.step_mm[0]), "{scene:?}: mean error {mean}");
    assert!((0.3..1.5).contains(&ratio), "{scene:?}: errors over deviations {ratio}");
    assert!(within > 0.85, "{scene:?}: within 95 %: {within}");
    let lost: usize = bone.lost.values().sum();
    assert!(lost * 50 < bone.threshold_corners, "{:?}", bone.lost);
}

#[test]
fn thick_voxels_and_cortex_of_half_to_three_mm() {
    holds(&Scene::new(
        Body::Torus { ring: 20.0, tube: 8.0 },
        Cortex::Waves(0.5, 3.0),
        3.0,
        1.3,
    ));
}

#[test]
fn middle_voxels_and_cortex_of_another_density() {
    let mut scene = Scene::new(Body::Ball { radius: 14.0 }, Cortex::Waves(1.0, 3.0), 1.5, 0.8);
    scene.hu[1] = 1700.0;
    holds(&scene);
}

#[test]
fn thin_voxels() {
    holds(&Scene::new(
        Body::Ball { radius: 7.0 },
        Cortex::Waves(1.0, 2.0),
        0.7,
        0.45,
    ));
}

/// Slices thicker than the voxels of their plane, and blurred more across it.
#[test]
fn thick_slices() {
    let mut scene = Scene::new(
        Body::Capsule {
            radius: 9.0,
            half: 10.0,
        },
        Cortex::Waves(1.0, 3.0),
        1.0,
        0.6,
    );
    (scene.step_mm[2], scene.blur_mm[1]) = (2.5, 1.1);
    // Held to what 3 mm voxels are: the worst direction's.
    let bone = taken(&scene);
    let [mean, ratio, within] = errors(&scene, &bone);
    assert!(
        mean.abs() < 0.2 && (0.3..1.5).contains(&ratio) && within > 0.85,
        "{mean} {ratio} {within}"
    );
    let [plane, across] = bone.scanner.blur_mm;
    assert!(
        (plane / 0.6).ln().abs() < 0.2 && (across / 1.1).ln().abs() < 0.2,
        "{plane} {across}"
    );
}

/// Cortex thinner than a third of the blur everywhere: its HU and thickness are one number, and the deviation says so.
#[test]
fn cortex_that_is_not_told_from_its_density_has_a_larger_shared_deviation() {
    let thin = Scene::new(Body::Ball { radius: 16.0 }, Cortex::Even(1.0), 3.0, 1.3);
    holds(&thin);
    let thick = Scene::new(Body::Ball { radius: 16.0 }, Cortex::Even(3.0), 1.5, 0.8);
    let [of_thin, of_thick] = [&thin, &thick].map(|scene| taken(scene).shared_rms_mm());
    assert!(of_thin > 3.0 * of_thick, "{of_thin} {of_thick}");
}

#[test]
fn the_number_of_threads_changes_no_bit() {
    let scene = Scene::new(Body::Ball { radius: 12.0 }, Cortex::Even(2.0), 3.0, 1.3);
    let ct = scan(&scene, grid(&scene));
    let by = |threads: usize| {
        let mut options = Options::of(Region::Number(1));
        options.threads = threads;
        extract(&ct, &options).unwrap()
    };
    assert_eq!(by(1), by(3));
}

/// Where cortex is thin and the same everywhere, its HU, its thickness and the blur are nearly one number: whatever its HU are, the mean error
/// is within two of the shared deviations that are stated.
#[test]
fn the_mean_error_of_uniform_cortex_of_any_density_is_within_what_is_shared() {
    for (hu, inside) in [(600.0, 150.0), (1300.0, 200.0), (1900.0, 200.0)] {
        let mut scene = Scene::new(Body::Ball { radius: 12.0 }, Cortex::Even(1.5), 1.0, 0.67);
        (scene.hu[1], scene.hu[2]) = (hu, inside);
        let bone = taken(&scene);
        let ([mean, _, _], shared) = (errors(&scene, &bone), bone.shared_rms_mm());
        assert!(mean.abs() < 2.0 * shared, "{hu} HU: mean error {mean}, {shared} shared");
        // A third of what a threshold is off at 1 mm voxels, 0.7 mm: more would say nothing.
        assert!(shared < 0.23, "{hu} HU: {shared}");
    }
}
