//! What no scene should be, and is anyway.

use ultrasound::{
    Beams, Focus, Level, Met, Pose, Scanner, Scene, SceneError, Settings, Shape, Wall, Wire, truth, water,
};

use super::{image, linear, mean, straight};

const LEVEL: Level = Level {
    bone_hu: 300.0,
    speed_ratio: 1.0,
    gel_mm: 2.5,
};

#[test]
fn poses_that_are_none_are_refused_by_name() {
    let (x, y) = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    let said = |origin, u, v| Pose::new(origin, u, v).unwrap_err().to_string();
    assert!(said([0.0, f64::NAN, 0.0], x, y).contains("origin"));
    assert!(said([0.0, f64::INFINITY, 0.0], x, y).contains("origin"));
    assert!(said([0.0; 3], [f64::NAN, 0.0, 0.0], y).contains("axes"));
    assert!(said([0.0; 3], [0.001, 0.0, 0.0], y).contains("axes"), "metres");
    assert!(said([0.0; 3], x, [0.1, 1.0, 0.0]).contains("axes"));
    assert!(Pose::new([0.0; 3], x, y).is_ok());
}

#[test]
fn wires_and_walls_that_are_none_are_refused_by_number() {
    let mut scanner = Scanner::new(&linear(), &Settings::shallow()).unwrap();
    let good = Wire {
        ends: [[0.0; 3], [0.0, 0.0, 9.0]],
    };
    let bad = Wire {
        ends: [[f64::NAN; 3]; 2],
    };
    let scene = Scene {
        body: &water,
        wires: &[good, bad],
        walls: &[],
    };
    assert!(matches!(
        scanner.scan(&scene, &straight(), 1),
        Err(SceneError::Wire { number: 1, .. })
    ));
    assert!(truth(&scene, &straight(), &linear(), &LEVEL, 9).is_err());
    let walls = [Wall {
        point: [0.0; 3],
        normal: [0.0; 3],
    }];
    let scene = Scene {
        body: &water,
        wires: &[],
        walls: &walls,
    };
    assert!(matches!(
        scanner.scan(&scene, &straight(), 1),
        Err(SceneError::Wall { number: 0, .. })
    ));
    let scene = Scene {
        body: &water,
        wires: &vec![good; 1001],
        walls: &[],
    };
    assert!(matches!(
        scanner.scan(&scene, &straight(), 1),
        Err(SceneError::Count { found: 1001, .. })
    ));
}

#[test]
fn settings_that_cannot_be_are_refused_by_name() {
    let said = |settings: Settings| Scanner::new(&linear(), &settings).unwrap_err().to_string();
    let good = Settings::shallow();
    assert!(
        said(Settings {
            frequency_mhz: f64::NAN,
            ..good
        })
        .contains("frequency")
    );
    assert!(
        said(Settings {
            speed_ratio: 1540.0,
            ..good
        })
        .contains("speed of sound over 1540 m/s is 1540")
    );
    assert!(said(Settings { beams: 100_000, ..good }).contains("beams"));
    let lateral = Focus {
        width_mm: 0.0,
        ..good.lateral
    };
    assert!(said(Settings { lateral, ..good }).contains("lateral width"));
}

#[test]
fn in_the_air_nothing_is_seen() {
    let (shape, settings) = (linear(), Settings::shallow());
    for air in [-1000.0, f64::NAN, f64::NEG_INFINITY] {
        let grey = image(&shape, &settings, &|_: [f64; 3]| air, &straight());
        assert!(mean(&shape, &grey, 0..401, 60..501) < 4.0);
        let truth = truth(&Scene::of(&|_: [f64; 3]| air), &straight(), &shape, &LEVEL, 9).unwrap();
        assert!(truth.beams.iter().all(|met| *met == Met::Air));
    }
}

/// The right half of the face is off the skin, by more than gel fills.
#[test]
fn beams_off_the_skin_are_black() {
    let (shape, settings) = (linear(), Settings::shallow());
    let body = |[x, y, _]: [f64; 3]| if x > 20.0 && y < 5.0 { -1000.0 } else { 100.0 };
    let grey = image(&shape, &settings, &body, &straight());
    assert!(mean(&shape, &grey, 10..190, 60..500) > 30.0);
    assert!(mean(&shape, &grey, 215..401, 60..500) < 4.0);
    // A gap that gel fills shows what is below it.
    let body = |[_, y, _]: [f64; 3]| if y < 1.5 { -1000.0 } else { 100.0 };
    let grey = image(&shape, &settings, &body, &straight());
    assert!(mean(&shape, &grey, 10..390, 60..500) > 30.0);
}

#[test]
fn gas_hides_what_is_below() {
    let (shape, settings) = (linear(), Settings::shallow());
    let body = |[_, y, _]: [f64; 3]| if (20.0..24.0).contains(&y) { -900.0 } else { 100.0 };
    let grey = image(&shape, &settings, &body, &straight());
    assert!(mean(&shape, &grey, 10..390, 450..500) < 0.5 * mean(&shape, &grey, 10..390, 100..190));
    let truth = truth(&Scene::of(&body), &straight(), &shape, &LEVEL, 3).unwrap();
    assert!(
        matches!(truth.beams[1], Met::Gas(depth) if (depth - 20.0).abs() < 1e-5),
        "{truth:?}"
    );
}

#[test]
fn inside_bone_there_is_a_bright_face_and_shadow() {
    let (shape, settings) = (linear(), Settings::shallow());
    let body = |_: [f64; 3]| 1200.0;
    let grey = image(&shape, &settings, &body, &straight());
    assert!(mean(&shape, &grey, 10..390, 0..5) > 100.0);
    assert!(mean(&shape, &grey, 10..390, 300..500) < 15.0);
    let truth = truth(&Scene::of(&body), &straight(), &shape, &LEVEL, 3).unwrap();
    assert!(matches!(truth.beams[1], Met::Bone(crossing) if crossing.depth_mm == 0.0 && crossing.incidence.is_nan()));
}

#[test]
fn without_bone_tissue_goes_on_to_the_bottom() {
    let (shape, settings) = (linear(), Settings::shallow());
    let grey = image(&shape, &settings, &|_: [f64; 3]| 100.0, &straight());
    let (upper, lower) = (
        mean(&shape, &grey, 20..380, 100..200),
        mean(&shape, &grey, 20..380, 400..490),
    );
    assert!((upper - lower).abs() < 12.0 && upper > 30.0, "{upper} {lower}");
}

/// Every size and depth that a shape may have, with the finest pulse and the widest beams.
#[test]
fn every_shape_gives_an_image() {
    let linear = |depth: f64| Beams::Linear {
        from_mm: -depth,
        to_mm: depth,
        face_mm: 0.0,
    };
    let convex = Beams::Convex {
        centre_mm: [40.0, 0.0],
        radius_mm: 1.0,
        half_angle: 1.55,
    };
    let fine = Settings {
        pulse_mm: 0.05,
        beams: 16,
        ..Settings::shallow()
    };
    let wide = Settings {
        elevation: Focus {
            depth_mm: 0.0,
            width_mm: 10.0,
            spread: 0.5,
        },
        pulse_mm: 5.0,
        ..Settings::deep()
    };
    let body = |[x, y, z]: [f64; 3]| 400.0 * (x / 7.0).sin() + 300.0 * (y / 11.0 + z / 5.0).cos();
    let cases = [
        ([16, 16], [0.1, 0.1], linear(1.0), 1.0),
        ([16, 16], [2.0, 2.0], linear(400.0), 400.0),
        ([1024, 1024], [0.4, 0.4], linear(400.0), 400.0),
        ([256, 256], [0.4, 0.4], convex, 60.0),
    ];
    let (x, y) = ([0.48, 0.64, 0.6], [-0.8, 0.6, 0.0]);
    let pose = Pose::new([3.0, -5.0, 70.0], x, y).unwrap();
    for (size, pixel, beams, depth) in cases {
        let shape = Shape::new(size, pixel, beams, depth).unwrap();
        for settings in [fine, wide, Settings::shallow()] {
            let mut scanner = Scanner::new(&shape, &settings).unwrap();
            let grey = scanner.scan(&Scene::of(&body), &pose, u64::MAX).unwrap();
            assert_eq!(grey.len(), size[0] * size[1]);
            assert!(scanner.scatterers_per_cell() > 0.0);
        }
    }
}
