//! The generated patient from the skin: what is shown is where the truth says.

use geometry::{Ct, Point};
use ultrasound::{Beams, Level, Met, Pose, Scanner, Scene, Settings, Shape, truth};

#[test]
fn the_patient_s_vertebrae_are_bright_where_they_truly_lie() {
    let patient = phantom::Phantom::new(phantom::DEFAULT_SEED);
    let body = |[x, y, z]: [f64; 3]| patient.hu(Point::<Ct>::new(x, y, z));
    let beams = Beams::Linear {
        from_mm: 0.0,
        to_mm: 40.0,
        face_mm: 0.0,
    };
    let shape = Shape::new([401, 601], [0.1; 2], beams, 60.0).unwrap();
    let settings = Settings::shallow();
    let mut scanner = Scanner::new(&shape, &settings).unwrap();
    let level = Level {
        bone_hu: settings.bone_hu,
        speed_ratio: settings.speed_ratio,
        gel_mm: settings.gel_mm,
    };
    let (mut seen, mut right) = (0, 0);
    // Along the back, 22 mm beside the spine: over the facets and laminae.
    for z in [20.0, 60.0, 100.0] {
        let skin = (0..2000).map(|i| 130.0 - 0.1 * f64::from(i));
        let skin = skin.into_iter().find(|&y| body([22.0, y, z + 20.0]) > -500.0).unwrap();
        let pose = Pose::new([22.0, skin + 0.5, z], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]).unwrap();
        let grey = scanner.scan(&Scene::of(&body), &pose, 1).unwrap();
        let truth = truth(&Scene::of(&body), &pose, &shape, &level, 81).unwrap();
        for met in &truth.beams[4..77] {
            let Met::Bone(crossing) = met else { continue };
            if crossing.incidence > 0.7 {
                continue;
            }
            seen += 1;
            let column = crossing.pixel[0].round() as usize;
            let (row, grey) = super::brightest(&shape, &grey, column, 150);
            // Below the fascia, which lies 12 mm deep and may be brighter. A pulse: here bone is curved to 5 mm, and wide beams reach beyond its rims.
            let near = (row as f64 - crossing.pixel[1]).abs() * 0.1 < 0.9;
            right += usize::from(near && grey > 120);
        }
    }
    assert!(seen > 60, "{seen}");
    assert!(right as f64 >= 0.9 * seen as f64, "{right} of {seen}");
}
