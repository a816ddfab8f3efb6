//! Where touching more would help: what is promised is what a fit with those points then predicts.

use chance::Chance;
use geometry::{Ct, Point, Rigid, Tracker, Vector};
use surface_registration::{Field, Options, Points, Spacing, Surface, SurfacePoint, Touches, next, refine};

use crate::shapes;

const SIGMA_MM: f64 = 0.3;

/// A box of which one face and half of another were touched: its long way is held by nothing but noise.
#[test]
fn what_is_promised_of_a_place_is_what_touching_it_gives() {
    let body = shapes::cuboid([30.0, 20.0, 10.0], 12);
    let surface = Surface::<Ct>::new(&body.0, &body.1).unwrap();
    let field = Field::new(&surface, Spacing::default()).unwrap();
    let truth: Rigid<Ct, Tracker> =
        Rigid::from_rotation_vector(Vector::new(0.4, -0.8, 0.3), Vector::new(50.0, -20.0, 700.0)).unwrap();
    let touched = |[x, y, z]: [f64; 3]| SurfacePoint::touched(truth.inverse() * Point::new(x, y, z), SIGMA_MM);
    let mut points: Vec<SurfacePoint<Tracker>> = (0..90)
        .map(|i| {
            let c = Chance::new(5, i);
            let (u, v) = (2.0 * c.uniform(0) - 1.0, 2.0 * c.uniform(1) - 1.0);
            let [ex, ey, ez] = [2, 3, 4].map(|k| SIGMA_MM * c.normal(k));
            // The face above, and a side along y: nothing looks along x.
            let [x, y, z] = if i < 60 {
                [28.0 * u, 18.0 * v, 10.0]
            } else {
                [28.0 * u, 20.0, 8.0 * v]
            };
            touched([x + ex, y + ey, z + ez])
        })
        .collect();
    let targets = [Point::new(0.0, 0.0, -40.0), Point::new(20.0, -10.0, -30.0)];
    let fitted = |points: &[SurfacePoint<Tracker>]| {
        let points = Points::new(points, None, 0.0).unwrap();
        refine(&surface, &field, &points, &truth, &Options::default()).unwrap()
    };
    let before = fitted(&points);
    let tre = |found: &surface_registration::SurfaceRegistration<Ct, Tracker>| {
        (targets.iter().map(|t| found.predicted_tre_mm(*t).powi(2)).sum::<f64>() / 2.0).sqrt()
    };
    let options = Options::default();
    let touches = Touches {
        points: 10.0,
        sigma_mm: SIGMA_MM.hypot(options.priors.bone_mm),
        apart_mm: 25.0,
        places: 3,
    };
    let places = next(&surface, &before, &targets, &touches);
    assert_eq!(places.len(), 3);
    // The ends of the box hold what slides.
    assert!(places[0].normal[0].abs() > 0.99, "{places:?}");
    assert!(places.is_sorted_by(|a, b| a.tre_mm <= b.tre_mm), "{places:?}");
    let [x, y, z] = places[0].place_mm;
    for i in 0..10 {
        // Some tenths of a millimetre apart in the face, or they were one place and no ten points.
        let f = f64::from(i) * 0.1;
        points.push(touched([x, y + f.sin(), z + f.cos() - 1.0]));
    }
    let after = tre(&fitted(&points));
    // To first order, of points that all have their full say; a twentieth is left for the factor by which residuals scatter.
    assert!((places[0].tre_mm / after - 1.0).abs() < 0.05, "{places:?}: {after}");
    assert!(after < 0.2 * tre(&before), "{after} of {}", tre(&before));
}
