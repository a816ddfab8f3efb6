//! What cannot be calibrated is refused by name, with its numbers.

use geometry::{Rigid, Vector};
use nalgebra::{Matrix2, Vector2};
use optics::camera::{CameraRefused, ImageSize, LensModel, Options, View, calibrate};

use super::rig::{Rig, SIZE, noisy};
use super::{LENSES, camera};
use crate::common::Random;

fn rig() -> Rig {
    Rig::around(camera(1200.0, LENSES[3].1), 5, 0.5)
}

fn refused(views: &[View]) -> CameraRefused {
    calibrate(views, SIZE, &Options::default()).unwrap_err()
}

#[test]
fn views_that_are_all_parallel() {
    let mut rig = rig();
    let first = rig.poses[0];
    for (i, pose) in rig.poses.iter_mut().enumerate() {
        let i = i as f64;
        let by = Vector::new(6.0 * i, 9.0 - 4.0 * i, 25.0 * i);
        *pose = Rigid::from_rotation_vector(Vector::new(0.0, 0.0, 0.0), by).unwrap() * first;
    }
    let refused = refused(&noisy(&rig.views(None), &mut Random::new(3), 1.0));
    assert!(matches!(refused, CameraRefused::Parallel { views: 5, .. }), "{refused}");
    assert!(refused.to_string().contains("parallel in all 5 views"), "{refused}");
}

#[test]
fn too_few_views_and_discs_and_too_many_views() {
    let views = rig().views(None);
    let few = refused(&views[..2]);
    assert_eq!(few, CameraRefused::TooFewViews { found: 2, needed: 3 });
    assert_eq!(refused(&[]), CameraRefused::TooFewViews { found: 0, needed: 3 });
    let crowd: Vec<View> = (0..65).map(|k| views[k % 5].clone()).collect();
    let options = Options {
        field: true,
        ..Options::default()
    };
    let many = calibrate(&crowd, SIZE, &options).unwrap_err();
    assert_eq!(many, CameraRefused::TooManyForField { found: 65, most: 64 });
    let mut short = views;
    short[1].sightings.truncate(7);
    assert_eq!(
        refused(&short),
        CameraRefused::TooFewDiscs {
            view: 1,
            found: 7,
            needed: 8
        }
    );
}

#[test]
fn a_view_that_comes_twice() {
    let mut views = rig().views(None);
    views[4] = views[1].clone();
    let same = refused(&views);
    assert!(
        matches!(
            same,
            CameraRefused::Identical {
                first: 1,
                second: 4,
                ..
            }
        ),
        "{same}"
    );
    // Two pictures of the same place differ by their noise, and are two.
    let both = noisy(&views, &mut Random::new(4), 1.0);
    assert!(calibrate(&both, SIZE, &Options::default()).is_ok());
}

#[test]
fn discs_on_a_line_or_on_a_point() {
    let mut views = rig().views(None);
    views[2].sightings.truncate(9);
    let line = refused(&views);
    assert_eq!(line, CameraRefused::Singular { view: 2, discs: 9 });
    let mut views = rig().views(None);
    let pixel = views[3].sightings[0].pixel;
    views[3].sightings.iter_mut().for_each(|s| s.pixel = pixel);
    assert!(matches!(refused(&views), CameraRefused::Singular { view: 3, .. }));
}

#[test]
fn numbers_that_cannot_be() {
    let good = rig().views(None);
    let changed = |change: &dyn Fn(&mut View)| {
        let mut views = good.clone();
        change(&mut views[1]);
        refused(&views)
    };
    let not_finite = CameraRefused::NotFinite { view: 1, disc: 4 };
    assert_eq!(changed(&|v| v.sightings[4].pixel.x = f64::NAN), not_finite);
    assert_eq!(changed(&|v| v.sightings[4].at_mm.y = f64::INFINITY), not_finite);
    assert_eq!(changed(&|v| v.sightings[4].radius_mm = Some(-1.0)), not_finite);
    let far = changed(&|v| v.sightings[4].pixel = Vector2::new(1e9, 0.0));
    assert!(matches!(far, CameraRefused::OffImage { view: 1, disc: 4, .. }), "{far}");
    for bad in [
        Matrix2::zeros(),
        Matrix2::new(1.0, 2.0, 2.0, 1.0),
        Matrix2::new(1.0, 0.1, 0.2, 1.0),
    ] {
        let refused = changed(&|v| v.sightings[4].covariance = bad);
        assert_eq!(refused, CameraRefused::BadCovariance { view: 1, disc: 4 });
    }
    let empty = ImageSize { width: 0, height: 720 };
    let refused = calibrate(&good, empty, &Options::default()).unwrap_err();
    assert_eq!(refused, CameraRefused::BadSize { width: 0, height: 720 });
}

/// Discs near the middle only: nothing holds the sixth power of the radius, and it either folds or is found weak, or has
/// a deviation beyond every lens.
#[test]
fn a_lens_that_was_not_seen_is_not_claimed() {
    let mut rig = Rig::around(camera(1200.0, LENSES[3].1), 5, 0.3);
    for pose in &mut rig.poses {
        let back = Vector::new(0.0, 0.0, 4000.0);
        *pose = Rigid::from_rotation_vector(Vector::new(0.0, 0.0, 0.0), back).unwrap() * *pose;
    }
    let views = noisy(&rig.views(None), &mut Random::new(8), 1.0);
    match calibrate(
        &views,
        SIZE,
        &Options {
            lens: LensModel::Brown5,
            ..Options::default()
        },
    ) {
        Ok(found) => assert!(found.sigmas()[9] > 1.0, "{}", found.sigmas()[9]),
        Err(refused) => assert!(
            matches!(
                refused,
                CameraRefused::Weak { .. } | CameraRefused::Folded { .. } | CameraRefused::NoConvergence { .. }
            ),
            "{refused}"
        ),
    }
}
