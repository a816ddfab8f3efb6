//! Where touching more would help: what is promised is what a fit with those points then predicts.

use std::f64::consts::TAU;

use chance::Chance;
use geometry::{Ct, Point, Rigid, Tracker, Vector};
use surface_registration::{Field, Options, Points, Spacing, Surface, SurfacePoint, Touches, next, refine};

use crate::shapes;

const SIGMA_MM: f64 = 0.3;
/// Half axes.
const HALF_MM: [f64; 3] = [40.0, 25.0, 16.0];

/// An ellipsoid of which the top was touched alone: a turn about its third axis is hardly held.
#[test]
fn what_is_promised_of_a_place_is_what_touching_it_gives() {
    let (corners, triangles) = shapes::ball(1.0, 60);
    let body = (
        corners
            .iter()
            .map(|p| [0, 1, 2].map(|k| HALF_MM[k] * p[k]))
            .collect::<Vec<_>>(),
        triangles,
    );
    let surface = Surface::<Ct>::new(&body.0, &body.1).unwrap();
    let field = Field::new(&surface, Spacing::default()).unwrap();
    let truth: Rigid<Ct, Tracker> =
        Rigid::from_rotation_vector(Vector::new(0.4, -0.8, 0.3), Vector::new(50.0, -20.0, 700.0)).unwrap();
    let touched = |[x, y, z]: [f64; 3]| SurfacePoint::touched(truth.inverse() * Point::new(x, y, z), SIGMA_MM);
    let mut points: Vec<SurfacePoint<Tracker>> = (0..90)
        .map(|i| {
            let c = Chance::new(5, i);
            // Within 60 degrees of the third axis.
            let (cosine, angle) = (1.0 - 0.5 * c.uniform(0), TAU * c.uniform(1));
            let sine = f64::sqrt(1.0 - cosine * cosine);
            let [x, y, z] = [
                HALF_MM[0] * sine * angle.cos(),
                HALF_MM[1] * sine * angle.sin(),
                HALF_MM[2] * cosine,
            ];
            let [ex, ey, ez] = [2, 3, 4].map(|k| SIGMA_MM * c.normal(k));
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
    assert!(places.is_sorted_by(|a, b| a.tre_mm <= b.tre_mm), "{places:?}");
    let (place, normal) = (places[0].place_mm, places[0].normal);
    // Square to the normal, so that steps along it stay on the surface: 0.5 mm of a radius of 10 mm leave it by 0.01 mm.
    let length = normal[0].hypot(normal[1]);
    let along = [-normal[1] / length, normal[0] / length, 0.0];
    for i in 0..10 {
        let step = 0.11 * (f64::from(i) - 4.5);
        points.push(touched([0, 1, 2].map(|k| place[k] + step * along[k])));
    }
    let after = tre(&fitted(&points));
    // To first order, of points that all have their full say; a twentieth is left for the factor by which residuals scatter.
    assert!((places[0].tre_mm / after - 1.0).abs() < 0.05, "{places:?}: {after}");
    assert!(after < 0.8 * tre(&before), "{after} of {}", tre(&before));
}
