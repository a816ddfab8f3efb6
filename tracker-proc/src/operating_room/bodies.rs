//! Markers of a scene as rigid bodies of emitters.

use calib::marker::even_directions;
use calib::pose::{Body, BodyError, Emitter};
use geometry::{Direction, Frame, Point};
use scene::operating_room::{Emitters, Shape};

/// The body of a scene's marker, its emitters exactly where the scene says.
pub(crate) fn body<F: Frame>(shape: &Shape<F>) -> Result<Body<F>, BodyError> {
    let emitter = |place: Point<F>, normal: Option<Direction<F>>| Emitter {
        place,
        normal,
        // Zero.
        covariance_mm2: Default::default(),
    };
    let origin = Point::new(0.0, 0.0, 0.0);
    Body::new(match &shape.emitters {
        Emitters::Ball { count, radius_mm } => even_directions(*count)
            .into_iter()
            .map(|out| emitter(origin + out * *radius_mm, Some(out)))
            .collect(),
        Emitters::Listed(list) => list.iter().map(|e| emitter(e.place, e.normal)).collect(),
    })
}

/// How far the outermost emitter is from the marker's origin, mm.
pub(super) fn reach_mm<F: Frame>(body: &Body<F>) -> f64 {
    let origin = Point::new(0.0, 0.0, 0.0);
    let distances = body.emitters().iter().map(|e| e.place.distance(origin));
    distances.fold(0.0, f64::max)
}
