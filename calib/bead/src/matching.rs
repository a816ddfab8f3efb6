//! Which bead was touched, without being told: beads in the CT, some of them false, and touched points, some of them on no
//! bead, in any order.
//!
//! Two pairs (bead, touched point) agree where both distances are the same within the error of a difference of distances.
//! The largest set of pairs in which all agree, and whose registration leaves residuals that the errors explain, is found
//! by branch and bound: exactly, or not at all ([`Refused::SearchTooLong`]). A set that fits as well and places the patient
//! elsewhere is no detail: both are named ([`Refused::Ambiguous`]).
//!
//! With deviations `sb` of a bead's centre and `st` of a touched point, per axis, mm, `st` the largest along any axis where the
//! touch states a covariance ([`Stated`], to which the hand's `touch_mm` is added):
//!
//! ```text
//! |d_ct - d_touched| <= 4.5 sqrt(2 sb^2 + st_1^2 + st_2^2)        distances of two points
//! sum |r|^2 / (sb^2 + st^2) <= chi-squared(3 n - 6), at four deviations        residuals
//! ```
//!
//! A person touches beads: of touches of which more than a quarter lie on none, something is wrong that matching must not hide
//! ([`Refused::FewOnBeads`]). Nor is a set taken that touches of anybody else would match with ([`Refused::ByChance`]).
//!
//! Residuals larger than the errors told, if within what is accepted, make the errors of the result larger
//! ([`told_noise_factor`]).
//!
//! Where touches state covariances, the residuals' sum is that of [`calib::registration::chi_squared`], which knows what
//! they share.

mod chance;
mod deviations;
mod error;
mod search;
mod spread;

use geometry::{Ct, Frame, Point};
use nalgebra::Matrix3;

use deviations::Deviations;
pub use error::{Pairing, Refused};
use search::{Solution, solutions};

use calib::registration::{
    Method, Noise, Pairs, Propagated, Registration, propagated, register, rms_at, told_noise_factor,
};

/// Deviations of a difference of distances within which it counts as none.
const AGREE_DEVIATIONS: f64 = 4.5;

/// A touch on no bead is of one that is nearer than so many times the difference that counts as none.
const NEAR: f64 = 3.0;
/// Pairings as good that touches of anybody else may be expected to have.
pub const MOST_BY_CHANCE: f64 = 1e-3;

/// Deviations of the points, per axis, mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Errors {
    /// Of a bead's centre in the CT: distortion of the scanner and what the bead moved since.
    pub bead_mm: f64,
    /// Of a touched point: how far a hand is off it, and all of its error where nothing is [`Stated`].
    pub touch_mm: f64,
}

/// What a touch states of its own error, in the axes of the touches' frame; the hand's is not in it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stated {
    /// Covariance of what is this touch's own, the noise of its poses, mm^2.
    pub own: Matrix3<f64>,
    /// What three normal numbers of deviation 1, the same for all touches, move it by: the error of the tip's calibration,
    /// a column for each, mm.
    pub shared: Matrix3<f64>,
}

impl Errors {
    /// Of a pair, seen in the CT.
    pub fn noise(&self) -> Noise {
        Noise {
            sigma_mm: self.bead_mm.hypot(self.touch_mm),
        }
    }

    fn check(&self) -> Result<(), Refused> {
        let good = |x: f64| x.is_finite() && x >= 0.0;
        if good(self.bead_mm) && good(self.touch_mm) && self.noise().sigma_mm > 0.0 {
            return Ok(());
        }
        Err(Refused::Errors(*self))
    }
}

/// A registration of touched points to beads.
#[derive(Debug, Clone)]
pub struct Matched<F: Frame> {
    /// For each touched point, its bead; `None` where none is there.
    pub bead_of: Vec<Option<usize>>,
    /// Beads that nobody touched.
    pub untouched: Vec<usize>,
    /// The registration of the pairs, in the order of the touched points that have a bead.
    pub registration: Registration<Ct, F>,
    /// The noise of a pair: that told, or the root mean square of the pairs' where touches state theirs, and what residuals show above it.
    pub noise: Noise,
    /// What its variance is multiplied by for the sake of the residuals, at least 1: [`told_noise_factor`].
    pub noise_factor: f64,
    /// How many pairings as good are to be expected of touches that have nothing to do with the beads, by an estimate.
    pub by_chance: f64,
    /// Covariance of the registration, and what touches share in it: by [`propagated`], where touches state their errors; `None`
    /// where none does.
    pub propagated: Option<Propagated>,
    /// `sum |r|^2 / sigma^2` and the greatest value accepted.
    pub chi_squared: [f64; 2],
    /// Branches of the search.
    pub steps: usize,
}

impl<F: Frame> Matched<F> {
    /// Touched points that have no bead.
    pub fn without_bead(&self) -> impl Iterator<Item = usize> {
        let none = |(i, bead): (usize, &Option<usize>)| bead.is_none().then_some(i);
        self.bead_of.iter().enumerate().filter_map(none)
    }

    /// Root mean square error predicted at a target, mm.
    pub fn predicted_tre_mm(&self, target: Point<Ct>) -> f64 {
        match &self.propagated {
            Some(of) => rms_at(&of.covariance, target),
            None => self.registration.predicted_tre_mm(self.noise, target),
        }
    }
}

/// Finds which bead each touched point is, and registers; touches have the error `errors.touch_mm` and no other. Indices count
/// from 0.
///
/// At most [`MAX_BEADS`] beads and [`MAX_TOUCHED`] touched points.
///
/// # Errors
/// [`Refused`].
pub fn match_beads<F: Frame>(
    beads: &[Point<Ct>],
    touched: &[Point<F>],
    errors: &Errors,
) -> Result<Matched<F>, Refused> {
    match_stated(beads, touched, &[], errors)
}

/// The same of touches that state their errors, one for each touch; of an empty list as [`match_beads`]. The pairs have equal
/// weights in the fit: what is stated makes its covariance and says which pairs agree.
///
/// # Errors
/// [`Refused`], of these [`Refused::Stated`].
pub fn match_stated<F: Frame>(
    beads: &[Point<Ct>],
    touched: &[Point<F>],
    stated: &[Stated],
    errors: &Errors,
) -> Result<Matched<F>, Refused> {
    errors.check()?;
    let sigmas = Deviations::new(touched.len(), stated, errors)?;
    check(beads, touched, &sigmas)?;
    // Points on a line, or nearly so, leave a turn open that no pairing can tell.
    spread::check(touched, sigmas.largest_mm())?;
    let (found, steps) = solutions(beads, touched, &sigmas)?;
    let [best, rest @ ..] = found.as_slice() else {
        return Err(Refused::NoMatch {
            beads: beads.len(),
            touched: touched.len(),
            distance_mm: sigmas.largest_distance_mm(),
        });
    };
    // Two pairings that lay the patient differently: to choose would be to guess.
    if let Some(other) = rest.iter().find(|other| elsewhere(best, other, touched, &sigmas)) {
        return Err(Refused::Ambiguous {
            first: best.pairing(),
            second: other.pairing(),
            apart_mm: apart(best, other, touched),
        });
    }
    // why: three pairs can be found by chance in any two sets, and a person who touches beads does not miss most of them.
    let allowed = touched.len() / 4;
    if touched.len() - best.count > allowed {
        return Err(Refused::FewOnBeads {
            best: best.pairing(),
            touched: touched.len(),
            allowed,
        });
    }
    not_near(best, (beads, touched), &sigmas)?;
    registered(best, (beads, touched), &sigmas, steps)
}

/// Refuses touches on no bead that are plainly of one: the hand is worse than told, or that bead has moved, and what was told of all others may be as wrong.
fn not_near<F: Frame>(
    best: &Solution<F>,
    (beads, touched): (&[Point<Ct>], &[Point<F>]),
    sigmas: &Deviations,
) -> Result<(), Refused> {
    let is_free = |bead: &usize| !best.bead_of.contains(&Some(*bead));
    for (touch, _) in best.bead_of.iter().enumerate().filter(|(_, bead)| bead.is_none()) {
        let place = best.transform * touched[touch];
        let distance = |bead: &usize| beads[*bead].distance(place);
        let nearest = (0..beads.len())
            .filter(is_free)
            .min_by(|a, b| distance(a).total_cmp(&distance(b)));
        let limit_mm = NEAR * sigmas.distance_mm(touch, touch);
        if let Some(bead) = nearest.filter(|bead| distance(bead) <= limit_mm) {
            return Err(Refused::NearBead {
                touch,
                bead,
                distance_mm: distance(&bead),
                limit_mm,
            });
        }
    }
    Ok(())
}

/// The registration of the pairs that were found.
fn registered<F: Frame>(
    best: &Solution<F>,
    (beads, touched): (&[Point<Ct>], &[Point<F>]),
    sigmas: &Deviations,
    steps: usize,
) -> Result<Matched<F>, Refused> {
    let (to, from): (Vec<_>, Vec<_>) = best.pairs().map(|(i, j)| (beads[i], touched[j])).unzip();
    // What was paired may be fewer points than were touched, and in a worse shape.
    spread::check(&from, sigmas.largest_mm())?;
    // By the ball that residuals were allowed, not by what they came to: others would be taken as well.
    let radius_mm = sigmas.largest_mm() * search::most(best.count).sqrt();
    let by_chance = chance::expected(&from, touched.len(), beads, radius_mm);
    if by_chance > MOST_BY_CHANCE {
        return Err(Refused::ByChance {
            best: best.pairing(),
            beads: beads.len(),
            by_chance,
        });
    }
    let pairs = Pairs::new(&to, &from)?;
    let registration = register(pairs, Method::default())?;
    let errors = sigmas.of_pairs(best.pairs().map(|(_, j)| j));
    // What residuals show is in the error, as far as it may be accepted at all.
    let noise_factor = told_noise_factor(best.chi_squared, search::freedom(best.count));
    let told = sigmas.noise(errors.as_deref());
    Ok(Matched {
        untouched: (0..beads.len()).filter(|i| !best.bead_of.contains(&Some(*i))).collect(),
        bead_of: best.bead_of.clone(),
        propagated: errors
            .as_ref()
            .and_then(|errors| propagated(&registration.fit, pairs, errors))
            .map(|of| of.with_own_times(noise_factor)),
        registration,
        noise: Noise {
            sigma_mm: told.sigma_mm * noise_factor.sqrt(),
        },
        noise_factor,
        by_chance,
        chi_squared: [best.chi_squared, search::most(best.count)],
        steps,
    })
}

/// The most beads.
pub const MAX_BEADS: usize = 64;
/// The most touched points.
pub const MAX_TOUCHED: usize = 32;

fn check<F: Frame>(beads: &[Point<Ct>], touched: &[Point<F>], sigmas: &Deviations) -> Result<(), Refused> {
    for (what, found, most) in [
        ("beads", beads.len(), MAX_BEADS),
        ("touched points", touched.len(), MAX_TOUCHED),
    ] {
        if found < 3 {
            return Err(Refused::TooFew { what, found });
        }
        if found > most {
            return Err(Refused::TooMany { what, found, most });
        }
    }
    finite("bead", beads.iter().map(|p| p.mm()))?;
    finite("touched point", touched.iter().map(|p| p.mm()))?;
    // A point touched twice would count as two, and could be matched to two beads.
    for (second, p) in touched.iter().enumerate() {
        for (first, q) in touched[..second].iter().enumerate() {
            let distance_mm = p.distance(*q);
            let least_mm = sigmas.distance_mm(first, second);
            if distance_mm <= least_mm {
                return Err(Refused::TouchedTwice {
                    first,
                    second,
                    distance_mm,
                    least_mm,
                });
            }
        }
    }
    Ok(())
}

fn finite(what: &'static str, points: impl Iterator<Item = [f64; 3]>) -> Result<(), Refused> {
    for (index, found) in points.enumerate() {
        if !found.iter().all(|x| x.is_finite()) {
            return Err(Refused::NotFinite { what, index, found });
        }
    }
    Ok(())
}

/// The greatest distance between the places that two solutions give the touched points, mm.
fn apart<F: Frame>(a: &Solution<F>, b: &Solution<F>, touched: &[Point<F>]) -> f64 {
    let distance = |p: &Point<F>| (a.transform * *p).distance(b.transform * *p);
    touched.iter().map(distance).fold(0.0, f64::max)
}

/// Whether two solutions place the patient differently: by more than hand and bead err. Both are of the same touched points: what these state of their
/// errors is no reason to take the two for one.
fn elsewhere<F: Frame>(a: &Solution<F>, b: &Solution<F>, touched: &[Point<F>], sigmas: &Deviations) -> bool {
    apart(a, b, touched) > sigmas.alike_mm()
}

#[cfg(test)]
mod tests;
