//! The place of the base from touches.

use geometry::Frame;
use nalgebra::{Matrix3, Vector3};

use super::result::Solved;
use super::search::{Found, Touched};
use super::touches::{centred, check, noise};
use super::{Drawing, Feature, Group, Located, Options, Refused};

/// Squares of residuals that a mirror image has at most half of are not those of chance: of a drawing that is nearly its own mirror image
/// both have nearly the same.
const HALF: f64 = 2.0;
/// Residuals below this part of the noise given are rounding.
const EXACT: f64 = 1e-6;

/// Locates the base from groups of touches, one or more for each feature.
///
/// Groups without a label are assigned by search; labels that contradict the touches are refused with those that fit.
/// Touches beyond the gate, past a groove's end included, are left out. Domain: coordinates up to 1e6 mm.
///
/// # Errors
/// [`Refused::NoFit`], [`Refused::WrongOrder`], [`Refused::Ambiguous`], [`Refused::Mirrored`], [`Refused::Unsolvable`], and what is
/// wrong with the input.
pub fn locate<F: Frame>(drawing: &Drawing, groups: &[Group<F>], options: &Options) -> Result<Located<F>, Refused> {
    options.check()?;
    check(groups)?;
    let (centre, places) = centred(groups);
    let labels: Vec<Option<Feature>> = groups.iter().map(|g| g.feature).collect();
    let touched = Touched::new(places, noise(groups, options.sigma_mm), &labels, options.limit_mm());
    let found = accepted(&touched, &labels, drawing, options)
        .map_err(|refused| explained(refused, &touched, &labels, drawing, options))?;
    let result = Solved::new(&touched, &found[0], drawing, options);
    // Before uniqueness: a motion that is free has places as good beside the best, and its name says more than
    // `Ambiguous`.
    result.held(options)?;
    result.even(groups)?;
    unique(&found, drawing, options, found[0].noise_ratio)?;
    handed(&touched, &labels, (drawing, options), &found[0])?;
    result.located(centre, groups, options)
}

/// The places that leave out few enough touches, the best first; at least one.
fn accepted(
    touched: &Touched,
    labels: &[Option<Feature>],
    drawing: &Drawing,
    options: &Options,
) -> Result<Vec<Found>, Refused> {
    let touches = touched.groups.iter().map(Vec::len).sum::<usize>();
    // A touch that slipped is left out; more than this share of them says that the drawing is another one.
    let allowed = (options.most_rejected * touches as f64).floor() as usize;
    let assignments = touched.assignments(labels);
    let places = |a: &Vec<Feature>| touched.places(a, drawing, options);
    let mut all: Vec<Found> = assignments.iter().flat_map(places).collect();
    // The sort is stable: of equals the first assignment stays first, and the result is the same every time.
    all.sort_by(|a, b| a.chi_squared.total_cmp(&b.chi_squared));
    // Kept before the refusal empties the list: the person is told what came nearest.
    let best = all.first().map(|f| (f.assignment.clone(), f.rejected(), f.noise_ratio));
    all.retain(|f| f.rejected() <= allowed && f.noise_ratio <= options.max_noise_ratio);
    if !all.is_empty() {
        return Ok(all);
    }
    let (best, rejected, noise_ratio) = best.unwrap_or((Vec::new(), touches, f64::NAN));
    Err(Refused::NoFit {
        best,
        rejected,
        touches,
        allowed,
        limit_mm: options.limit_mm(),
        noise_ratio,
        max_noise_ratio: options.max_noise_ratio,
    })
}

/// The refusal of labels under which nothing fits: the order that does, where there is one.
fn explained(
    refused: Refused,
    touched: &Touched,
    labels: &[Option<Feature>],
    drawing: &Drawing,
    options: &Options,
) -> Refused {
    let free = vec![None; labels.len()];
    if labels == free {
        return refused;
    }
    // Lines and planes anew: under the labels only those that each label allows were looked for.
    let touched = Touched::new(touched.groups.clone(), touched.noise.clone(), &free, options.limit_mm());
    let found = match accepted(&touched, &free, drawing, options) {
        Ok(found) => found,
        // Where nothing could be fitted to the labels, the nearest of all assignments says more.
        Err(nearest) => return if unfitted(&refused) { nearest } else { refused },
    };
    let said = labels.iter().zip(&found[0].assignment).map(|(l, f)| l.unwrap_or(*f));
    Refused::WrongOrder {
        said: said.collect(),
        found: found[0].assignment.clone(),
    }
}

const fn unfitted(refused: &Refused) -> bool {
    matches!(refused, Refused::NoFit { best, .. } if best.is_empty())
}

/// Refuses a second place that explains the touches nearly as well.
fn unique(found: &[Found], drawing: &Drawing, options: &Options, noise_ratio: f64) -> Result<(), Refused> {
    let best = &found[0];
    let apart = |f: &Found| {
        let at = |p: &Found, x: &Vector3<f64>| p.pose.matrix() * x + p.pose.shift;
        let distance = |x: &Vector3<f64>| (at(f, x) - at(best, x)).norm();
        drawing.ends().iter().map(distance).fold(0.0, f64::max)
    };
    // As unlikely as a touch beyond the gate.
    let margin = (options.gate * noise_ratio.max(1.0)).powi(2);
    // Starts a half-turn apart may end at one place: only what lies apart by more than a touch may is a second one.
    let rival = |f: &&Found| apart(f) > options.limit_mm() && f.chi_squared - best.chi_squared < margin;
    found[1..].iter().find(rival).map_or(Ok(()), |second| {
        Err(Refused::Ambiguous {
            assignments: [best.assignment.clone(), second.assignment.clone()],
            apart_mm: apart(second),
            chi_squared: [best.chi_squared, second.chi_squared],
        })
    })
}

/// Refuses touches whose mirror image fits the drawing clearly better: a localizer's axes that are left-handed.
fn handed(
    touched: &Touched,
    labels: &[Option<Feature>],
    (drawing, options): (&Drawing, &Options),
    best: &Found,
) -> Result<(), Refused> {
    let flip = Matrix3::from_diagonal(&Vector3::new(-1.0, 1.0, 1.0));
    let places = touched.groups.iter().map(|g| g.iter().map(|p| flip * p).collect());
    let noise = touched
        .noise
        .iter()
        .map(|g| g.iter().map(|c| c.map(|c| flip * c * flip)).collect());
    // Lines and planes of an image are not those of the touches, nor are their noises' axes.
    let image = Touched::new(places.collect(), noise.collect(), labels, options.limit_mm());
    let Ok(found) = accepted(&image, labels, drawing, options) else {
        return Ok(());
    };
    let chi_squared = [best.chi_squared, found[0].chi_squared];
    let margin = (options.gate * found[0].noise_ratio.max(1.0)).powi(2);
    // why: with a noise told too large both lie within it, and which of the two the touches are shows in their ratio alone; of exact
    // touches of a drawing that is its own mirror image that is rounding.
    let is_half = chi_squared[0] >= HALF * chi_squared[1] && best.noise_ratio > EXACT;
    if chi_squared[0] - chi_squared[1] < margin && !is_half {
        return Ok(());
    }
    Err(Refused::Mirrored { chi_squared })
}
