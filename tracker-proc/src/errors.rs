//! Errors about a point, as scenes state them.

use geometry::rotation::Rotation;
use geometry::uncertain::CovarianceError;
use geometry::{Point, Rigid, Uncertain};
use scene::operating_room::Deviations;

/// The motion of which nothing is known but that it turns about `c` and shifts it with these deviations about and along each
/// axis: the identity with that covariance. Before a transform, it gives the transform these errors.
///
/// # Errors
/// Each variant of [`CovarianceError`] but the one for asymmetry.
pub(crate) fn errors_about<F>(c: Point<F>, errors: Deviations) -> Result<Uncertain<F, F>, CovarianceError> {
    let lever = c - Point::new(0.0, 0.0, 0.0);
    // There and back carries the covariance from c to the origin.
    let to_c: Rigid<F, F> = Rigid::from_parts(Rotation::IDENTITY, lever);
    let about_c = Uncertain::from_upper(Rigid::<F, F>::identity(), diagonal(errors))?;
    let carried = Uncertain::from(to_c) * about_c * Uncertain::from(to_c.inverse());
    Uncertain::from_upper(Rigid::identity(), carried.upper())
}

/// The upper triangle of the covariance of (turn, shift) with these deviations along and about each axis.
fn diagonal(errors: Deviations) -> [f64; 21] {
    let [turn, shift] = [errors.turn_rad, errors.shift_mm].map(|s| s * s);
    let mut upper = [0.0; 21];
    // Places of the diagonal in the upper triangle of a 6 x 6 matrix.
    for (place, variance) in [0, 6, 11, 15, 18, 20]
        .into_iter()
        .zip([turn, turn, turn, shift, shift, shift])
    {
        upper[place] = variance;
    }
    upper
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::Ct;

    #[test]
    fn the_point_moves_by_the_shift_and_others_by_the_turn_too() {
        let errors = Deviations {
            shift_mm: 0.2,
            turn_rad: 1e-3,
        };
        let c = Point::<Ct>::new(120.0, -30.0, 900.0);
        let motion = errors_about(c, errors).unwrap();
        let square = |p: Point<Ct>| (motion * p).covariance().trace();
        // Variances of a turn of 1e-3 at 1000 mm are 1 mm^2, of which 1e-10 is lost to cancellation, see geometry::uncertain.
        assert!((square(c) - 3.0 * 0.04).abs() < 1e-9, "{}", square(c));
        let aside = Point::new(120.0, -30.0, 1000.0);
        // Two of three turns move a point 100 mm away: by 0.1 mm each.
        assert!(
            (square(aside) - (3.0 * 0.04 + 2.0 * 0.01)).abs() < 1e-9,
            "{}",
            square(aside)
        );
    }
}
