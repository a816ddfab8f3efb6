//! Lines of `operations.csv`: empty ones, and what is known put into them.

use geometry::{Ct, Point};
use phantom::Landmark;

use super::FAIL;
use crate::plan::Stratum;
use crate::record::{Ended, Reasons, Row};
use crate::steps::Misplaced;
use crate::truth::{LINKS, Told, alone, length};

/// A refusal of the check is right where the registration is truly off at the target by more than the radius that its own covariance
/// gives for 95 of 100, or by more than is allowed. A check that could not be made says nothing of it.
pub(super) fn is_right(check: &str, [found_mm, radius_mm]: [f64; 2], max_mm: f64) -> Option<bool> {
    (check == FAIL).then_some(found_mm > radius_mm.min(max_mm))
}

/// What is told of a registration that a step refused: its own error at the target. The refusal is judged as one of the check is.
pub(super) fn misplaced(registration: &Misplaced, max_mm: f64, target: Point<Ct>, row: Row) -> Row {
    let told = alone(&registration.found, registration.truly, target);
    let mut links = row.links;
    links[0] = [length(told.error), told.rms_mm];
    Row {
        right: Some(length(told.error) > told.ball_95_mm.min(max_mm)),
        tre_mm: length(told.error),
        predicted_mm: told.ball_95_mm,
        nees: told.nees.unwrap_or(f64::NAN),
        links,
        ..row
    }
}

pub(super) fn with(told: &Told, predicted_mm: f64, row: Row) -> Row {
    Row {
        tre_mm: length(told.error),
        predicted_mm,
        nees: told.nees,
        links: told
            .links
            .map(|link| [length(link.found), link.predicted_rms_mm.unwrap_or(f64::NAN)]),
        rest_mm: told.rest_mm(),
        ..row
    }
}

/// A line of which nothing is known yet.
pub(super) fn empty(stratum: &Stratum, number: u64, target: &Landmark) -> Row {
    Row {
        stratum: stratum.name.clone(),
        number,
        target: target.name.clone(),
        ended: Ended::Refused,
        step: String::new(),
        check: String::new(),
        bump: String::new(),
        right: None,
        tre_mm: f64::NAN,
        predicted_mm: f64::NAN,
        nees: f64::NAN,
        miss_mm: f64::NAN,
        time_s: f64::NAN,
        strokes: 0,
        pictures: [0; 2],
        reasons: Reasons::default(),
        links: [[f64::NAN; 2]; LINKS.len()],
        rest_mm: f64::NAN,
        model: String::new(),
        model_numbers: [f64::NAN; 4],
        why: String::new(),
    }
}
