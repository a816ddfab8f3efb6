//! Points of which the surface says nothing, as it ends before them.

/// Whether a point may have a say.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Say {
    /// It has one, as far as the kernel leaves it.
    Has,
    /// Its beam comes from inside the bone.
    FacesAway,
    /// The bone nearest to it is an open border, beyond which nothing is known.
    Beyond,
}

/// No verdict accepts a larger share of the points beyond open borders.
pub(crate) const MOST_BEYOND: f64 = 0.3;

/// As large a share lies beyond open borders at the price of the others. It is more than a verdict accepts: were it as much, a pose with some
/// more would pay for each of them, and a bone whose levels are alike was taken for one level off, where fewer are beyond.
pub(crate) const NEUTRAL_BEYOND: f64 = 0.5;

/// What points of `beyond` votes beyond an open border cost, where `known` votes elsewhere cost `cost`.
///
/// Nothing is known of the bone there, so they cost what the others do on average. Were it as much as what is infinitely far away, each
/// point that comes back under the border would pay for a worse fit of all: a sweep near the end of a CT was drawn along the bone by
/// 3 to 5 mm by points that lay on the true bone to 0.03 mm. Were it less, a border would draw points across it. Beyond
/// [`NEUTRAL_BEYOND`] of all each costs as much as it can: otherwise nothing would fit as well as a pose with all points beyond the border.
pub(crate) fn beyond_cost(cost: f64, known: f64, beyond: f64, most: f64) -> f64 {
    let neutral = beyond.min(NEUTRAL_BEYOND * (known + beyond));
    let mean = if known > 0.0 { cost / known } else { most };
    neutral * mean + (beyond - neutral) * most
}

#[cfg(test)]
mod tests {
    use geometry::{Point, Tracker};
    use nalgebra::{Matrix3, Vector3};

    use super::*;
    use crate::points::{Points, SurfacePoint};
    use crate::solve::{Distances, Priors, Problem, State};
    use crate::{Kernel, LEAST_POINTS};

    const MOST: f64 = 6.75;

    fn total(cost: f64, known: f64, beyond: f64) -> f64 {
        cost + beyond_cost(cost, known, beyond, MOST)
    }

    #[test]
    fn a_point_that_fits_as_the_others_do_costs_the_same_on_both_sides_of_a_border() {
        for mean in [0.0, 0.9, 3.0] {
            let (before, after) = (total(80.0 * mean, 80.0, 20.0), total(81.0 * mean, 81.0, 19.0));
            // Rounding of sums of some hundreds.
            assert!(
                (before - after).abs() < 1e-12 * (1.0 + before),
                "{mean}: {before} {after}"
            );
            assert!((before - 100.0 * mean).abs() < 1e-12 * (1.0 + before));
        }
    }

    #[test]
    fn more_than_the_share_beyond_a_border_costs_as_much_as_it_can() {
        // 70 of 100: 50 at 0.5 each, 20 at the most.
        assert!((total(15.0, 30.0, 70.0) - (15.0 + 25.0 + 20.0 * MOST)).abs() < 1e-12);
        assert!((total(0.0, 0.0, 100.0) - 100.0 * MOST).abs() < 1e-12);
        assert_eq!(total(7.0, 50.0, 0.0), 7.0);
    }

    /// The plane z = 0, of which nothing is known where x is above 0.
    struct Sheet;

    impl Distances for Sheet {
        fn look(&self, _: usize, p: &Vector3<f64>, _: f64) -> (f64, Vector3<f64>, bool) {
            (p.z, Vector3::z(), p.x > 0.0)
        }
    }

    /// Nothing holds these points along x, and each that came back under the border was worth six squares of deviations.
    #[test]
    fn points_on_a_surface_that_goes_on_are_not_drawn_under_its_border() {
        // A fifth of them beyond it, each by one deviation off the surface, to both sides.
        let place = |i: usize| {
            Point::new(
                i as f64 - 79.5,
                (i % 7) as f64,
                if i.is_multiple_of(2) { 0.5 } else { -0.5 },
            )
        };
        let touched = |i| SurfacePoint::<Tracker>::touched(place(i), 0.5);
        let points = Points::new(&(0..100).map(touched).collect::<Vec<_>>(), None, 0.0).unwrap();
        assert!(points.points().len() > LEAST_POINTS);
        let problem = Problem {
            cloud: &points.cloud,
            distances: &Sheet,
            anchors: &[],
            priors: &Priors::default(),
            kernel: Kernel::Tukey(4.5),
            facing: Some(0.0),
            sharp: &[2.0; 100],
            bends: &[],
            beyond: &[],
            settled_mm: 1e-3,
            is_dear: false,
        };
        let cost = |along_mm: f64| {
            let shift = points.cloud.centre + Vector3::x() * along_mm;
            let state = State {
                turn: Matrix3::identity(),
                shift,
                scale: 0.0,
                offset: 0.0,
            };
            problem.sum(&state).0
        };
        for along_mm in [-18.0, -4.0, 4.0, 28.0] {
            // Rounding of a sum of 100.
            assert!(
                (cost(along_mm) - cost(0.0)).abs() < 1e-9,
                "{along_mm}: {}",
                cost(along_mm)
            );
        }
        // Beyond half of all nothing is free.
        assert!(cost(40.0) > cost(0.0) + 9.0 * (MOST - 1.0));
    }
}
