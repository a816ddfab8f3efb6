//! A rigid body of emitters, as calibrated.

use geometry::{Direction, Frame, Point};
use nalgebra::{Matrix3, Vector3};

use super::MAX_EMITTERS;
use crate::registration::{Method, Pairs, Refused, fit};

/// One emitter (diode, sphere) of a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Emitter<F: Frame> {
    /// Its place in the body's frame.
    pub place: Point<F>,
    /// The way it looks; `None` for one that is seen from everywhere.
    pub normal: Option<Direction<F>>,
    /// Covariance of its place as calibrated, mm^2; zero where it is taken as exact.
    pub covariance_mm2: Matrix3<f64>,
}

/// A rigid body of emitters, checked: three or more that determine a pose, no two at one place.
#[derive(Debug, Clone, PartialEq)]
pub struct Body<F: Frame> {
    emitters: Vec<Emitter<F>>,
}

/// Why emitters are not a body.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum BodyError {
    /// Too many.
    #[error("{found} emitters; at most {MAX_EMITTERS} are handled")]
    TooMany {
        /// How many came.
        found: usize,
    },
    /// Two emitters lie so close together that no localizer tells them apart.
    #[error(
        "emitters {first} and {second} are {distance_mm:.3} mm apart; at least {least_mm} mm are needed to tell them apart"
    )]
    Together {
        /// The first of them, from 0.
        first: usize,
        /// The second.
        second: usize,
        /// How far apart they are, mm.
        distance_mm: f64,
        /// How far they should be.
        least_mm: f64,
    },
    /// They lie on a line, or are too few, or hold a NaN: no pose follows from them.
    #[error("the emitters determine no pose: {0}")]
    NoPose(#[from] Refused),
    /// They lie so nearly on a line that the roll about it is noise.
    #[error(
        "the emitters lie nearly on a line (width {width_mm:.3} mm over a length of {length_mm:.1} mm): the roll about it \
         would be noise. Use a body with emitters to the side"
    )]
    Line {
        /// Root mean square distance from the line, mm.
        width_mm: f64,
        /// Root mean square extent along it, mm.
        length_mm: f64,
    },
    /// A covariance is not one.
    #[error("emitter {index}: its covariance is not symmetric positive semidefinite and finite")]
    Covariance {
        /// Which, from 0.
        index: usize,
    },
}

/// Emitters nearer than this are one to every localizer, mm.
const LEAST_MM: f64 = 1.0;
/// A body whose emitters keep within this share of its length to a line is one: 0.1 mm of noise on a 100 mm rod of this
/// width is 6 degrees of roll.
const LEAST_WIDTH: f64 = 0.01;

impl<F: Frame> Body<F> {
    /// Checks emitters.
    ///
    /// # Errors
    /// Each variant of [`BodyError`].
    pub fn new(emitters: Vec<Emitter<F>>) -> Result<Self, BodyError> {
        if emitters.len() > MAX_EMITTERS {
            return Err(BodyError::TooMany { found: emitters.len() });
        }
        let places: Vec<Point<F>> = emitters.iter().map(|e| e.place).collect();
        // Fitted onto itself: refuses what no cloud of the same shape could be fitted to, by name.
        fit(Pairs::new(&places, &places)?, Method::Newton)?;
        // After the fit, which refuses NaN: such a distance would not be below the least.
        check_apart(&places)?;
        check_width(&places)?;
        let bad = |e: &Emitter<F>| {
            // Rounding may leave the least eigenvalue of a computed covariance below zero by some eps of the largest.
            let c = e.covariance_mm2;
            !c.iter().all(|v| v.is_finite())
                || (c - c.transpose()).amax() > 1e-12 * c.amax()
                || c.symmetric_eigenvalues().min() < -1e-12 * c.amax()
        };
        match emitters.iter().position(bad) {
            Some(index) => Err(BodyError::Covariance { index }),
            None => Ok(Self { emitters }),
        }
    }

    /// A body of exact points that are seen from everywhere.
    ///
    /// # Errors
    /// As [`Body::new`].
    pub fn of_points(places: &[Point<F>]) -> Result<Self, BodyError> {
        let emitter = |place: &Point<F>| Emitter {
            place: *place,
            normal: None,
            covariance_mm2: Matrix3::zeros(),
        };
        Self::new(places.iter().map(emitter).collect())
    }

    /// The emitters.
    pub fn emitters(&self) -> &[Emitter<F>] {
        &self.emitters
    }
}

fn check_apart<F>(places: &[Point<F>]) -> Result<(), BodyError> {
    for (second, b) in places.iter().enumerate() {
        for (first, a) in places[..second].iter().enumerate() {
            let distance_mm = a.distance(*b);
            if distance_mm < LEAST_MM {
                return Err(BodyError::Together {
                    first,
                    second,
                    distance_mm,
                    least_mm: LEAST_MM,
                });
            }
        }
    }
    Ok(())
}

fn check_width<F>(places: &[Point<F>]) -> Result<(), BodyError> {
    let count = places.len() as f64;
    let vectors = || places.iter().map(|p| Vector3::from(p.mm()));
    let mean: Vector3<f64> = vectors().sum::<Vector3<f64>>() / count;
    let spread: Matrix3<f64> = vectors().map(|v| (v - mean) * (v - mean).transpose()).sum();
    let mut values: [f64; 3] = (spread / count).symmetric_eigenvalues().into();
    values.sort_by(f64::total_cmp);
    // The two lesser moments add up to the mean squared distance from the line; rounding may leave them below zero.
    let (width_mm, length_mm) = ((values[0].max(0.0) + values[1].max(0.0)).sqrt(), values[2].sqrt());
    if width_mm < LEAST_WIDTH * length_mm {
        return Err(BodyError::Line { width_mm, length_mm });
    }
    Ok(())
}
