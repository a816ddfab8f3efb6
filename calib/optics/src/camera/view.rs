//! What was seen, and what is asked for.

use nalgebra::{Matrix2, Vector2, Vector3};

use super::error::CameraRefused;
use super::model::PARAMETERS;
use super::paraboloid::SHARED;
use super::paraboloid::{Bend, Ruler};

/// The least number of views.
pub const LEAST_VIEWS: usize = 3;
/// The least number of discs in a view.
pub const LEAST_DISCS: usize = 8;
/// The most views that are adjusted together with a plate's field: poses are not eliminated there.
pub(super) const MOST_FIELD_VIEWS: usize = 64;
/// The largest side of an image, pixels.
const MAX_SIDE: usize = 100_000;

/// One disc in one view.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sighting {
    /// The disc's centre on the grid, mm.
    pub at_mm: Vector2<f64>,
    /// Where it was seen, pixels.
    pub pixel: Vector2<f64>,
    /// Covariance of that, pixels squared.
    pub covariance: Matrix2<f64>,
    /// The disc's radius, where `pixel` is the centre of the disc's image; `None` where it is the image of the disc's
    /// centre. Perspective and distortion make these two differ.
    pub radius_mm: Option<f64>,
}

/// The grid in one image.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct View {
    /// Its discs.
    pub sightings: Vec<Sighting>,
}

/// Columns and rows of the image, pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ImageSize {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
}

impl ImageSize {
    /// The pixel in the middle.
    pub(super) fn middle(self) -> Vector2<f64> {
        Vector2::new(self.width as f64 - 1.0, self.height as f64 - 1.0) / 2.0
    }

    /// The longer side.
    pub(super) fn side(self) -> f64 {
        self.width.max(self.height) as f64
    }
}

/// Which coefficients of the lens are free; the others are 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum LensModel {
    /// None: a pinhole.
    Pinhole,
    /// k1 and k2.
    Radial,
    /// k1, k2, p1 and p2.
    #[default]
    Brown,
    /// k1, k2, p1, p2 and k3.
    Brown5,
    /// k1, k2, and a thin prism's s1 to s4 in the place of p1 and p2: what these say of `r^2`, and of `r^4`, with the
    /// direction of either free.
    Prism,
}

/// How a camera is calibrated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// The lens.
    pub lens: LensModel,
    /// Whether the skew is free; else it is 0.
    pub skew: bool,
    /// Whether the grid's plate may be bent, the same in every view ([`super::Plate`]); else it is flat.
    pub bent: bool,
    /// Whether, besides, its discs may lie off that shape by a smooth field in height and in the plane, the same in every
    /// view, as large as the views say ([`super::Plate::offset_mm`]); the plate is then bent too.
    pub field: bool,
    /// Discs further off than this many deviations are left out; the deviation is that given, times the size of the
    /// residuals where they are larger.
    pub gate: f64,
    /// The largest share of all discs that may be left out.
    pub most_rejected: f64,
}

impl Default for Options {
    /// Brown's lens without k3, no skew, a flat plate, a gate of six deviations, a twentieth left out at most.
    fn default() -> Self {
        Self {
            lens: LensModel::Brown,
            skew: false,
            bent: false,
            field: false,
            gate: 6.0,
            most_rejected: 0.05,
        }
    }
}

impl Options {
    /// Which numbers of the camera are free, in the order of [`super::NAMES`].
    pub fn free(&self) -> [bool; PARAMETERS] {
        let [radial, tangential, sixth, prism] = match self.lens {
            LensModel::Pinhole => [false; 4],
            LensModel::Radial => [true, false, false, false],
            LensModel::Brown => [true, true, false, false],
            LensModel::Brown5 => [true, true, true, false],
            LensModel::Prism => [true, false, false, true],
        };
        let mut free = [prism; PARAMETERS];
        free[..4].fill(true);
        free[4..10].copy_from_slice(&[self.skew, radial, radial, tangential, tangential, sixth]);
        free
    }

    /// Which of the numbers that all views share are free.
    pub(super) fn shared(&self) -> [bool; SHARED] {
        let camera = self.free();
        std::array::from_fn(|k| camera.get(k).copied().unwrap_or(self.bent || self.field))
    }
}

/// Refuses what cannot be calibrated whatever the numbers are worth.
pub(super) fn check(views: &[View], size: ImageSize, options: &Options) -> Result<(), CameraRefused> {
    if views.len() < LEAST_VIEWS {
        let (found, needed) = (views.len(), LEAST_VIEWS);
        return Err(CameraRefused::TooFewViews { found, needed });
    }
    let ImageSize { width, height } = size;
    if !(1..=MAX_SIDE).contains(&width) || !(1..=MAX_SIDE).contains(&height) {
        return Err(CameraRefused::BadSize { width, height });
    }
    for (view, seen) in views.iter().enumerate() {
        let found = seen.sightings.len();
        if found < LEAST_DISCS {
            let needed = LEAST_DISCS;
            return Err(CameraRefused::TooFewDiscs { view, found, needed });
        }
        for (disc, s) in seen.sightings.iter().enumerate() {
            sighting(s, [view, disc], size)?;
        }
    }
    // The field's equations grow with the square of the views and are kept whole.
    if options.field && views.len() > MOST_FIELD_VIEWS {
        let (found, most) = (views.len(), MOST_FIELD_VIEWS);
        return Err(CameraRefused::TooManyForField { found, most });
    }
    // Numbers that fit everything say nothing of their errors.
    let measured = 2 * views.iter().map(|v| v.sightings.len()).sum::<usize>();
    let unknowns = 6 * views.len() + options.shared().iter().filter(|f| **f).count();
    if measured <= unknowns {
        return Err(CameraRefused::NoFreedom { measured, unknowns });
    }
    distinct(views)
}

fn sighting(s: &Sighting, [view, disc]: [usize; 2], size: ImageSize) -> Result<(), CameraRefused> {
    let radius = s.radius_mm.unwrap_or(1.0);
    let numbers = [s.at_mm.x, s.at_mm.y, s.pixel.x, s.pixel.y, radius];
    if !numbers.iter().all(|x| x.is_finite()) || radius <= 0.0 {
        return Err(CameraRefused::NotFinite { view, disc });
    }
    if (s.pixel - size.middle()).amax() > 1.5 * size.side() {
        let ImageSize { width, height } = size;
        return Err(CameraRefused::OffImage {
            view,
            disc,
            pixel: s.pixel.into(),
            width,
            height,
        });
    }
    let c = s.covariance;
    let good = c[(0, 1)] == c[(1, 0)] && c[(0, 0)] > 0.0 && c.determinant() > 0.0 && c.iter().all(|x| x.is_finite());
    good.then_some(()).ok_or(CameraRefused::BadCovariance { view, disc })
}

/// Refuses a view that comes twice: noise never repeats to a millionth of its deviation.
fn distinct(views: &[View]) -> Result<(), CameraRefused> {
    for (second, b) in views.iter().enumerate() {
        for (first, a) in views[..second].iter().enumerate() {
            if let Some(apart_px) = apart(a, b) {
                return Err(CameraRefused::Identical {
                    first,
                    second,
                    apart_px,
                });
            }
        }
    }
    Ok(())
}

/// The greatest distance of the discs of two views, where that is nothing beside their deviations.
fn apart(a: &View, b: &View) -> Option<f64> {
    if a.sightings.len() != b.sightings.len() {
        return None;
    }
    let mut most = 0.0_f64;
    for (a, b) in a.sightings.iter().zip(&b.sightings) {
        let off = (a.pixel - b.pixel).amax();
        if a.at_mm != b.at_mm || off > 1e-6 * a.covariance.trace().sqrt() {
            return None;
        }
        most = most.max(off);
    }
    Some(most)
}

/// A sighting made ready: about the middle of its view's discs, with its information.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ready {
    /// Place in its view.
    pub(super) disc: usize,
    /// On the grid about the view's centre, z = 0, mm.
    pub(super) place: Vector3<f64>,
    pub(super) pixel: Vector2<f64>,
    pub(super) information: Matrix2<f64>,
    pub(super) radius_mm: Option<f64>,
    /// What the plate's bend lifts it by.
    pub(super) bow: [f64; Bend::NUMBERS],
}

/// The sightings of a view about their middle, mm.
#[derive(Debug, Clone)]
pub(super) struct Station {
    pub(super) centre: Vector2<f64>,
    pub(super) sightings: Vec<Ready>,
}

impl Station {
    /// Of a view that was checked.
    pub(super) fn of(view: &View, ruler: &Ruler) -> Self {
        // About the middle of its discs a pose's turn and shift are nearly uncorrelated.
        let centre = view.sightings.iter().map(|s| s.at_mm).sum::<Vector2<f64>>() / view.sightings.len() as f64;
        let ready = |(disc, s): (usize, &Sighting)| {
            let place = s.at_mm - centre;
            Some(Ready {
                disc,
                place: Vector3::new(place.x, place.y, 0.0),
                pixel: s.pixel,
                information: s.covariance.try_inverse()?,
                radius_mm: s.radius_mm,
                bow: ruler.bow(s.at_mm),
            })
        };
        Self {
            centre,
            sightings: view.sightings.iter().enumerate().filter_map(ready).collect(),
        }
    }
}

impl Station {
    /// The places of its discs on the grid, mm, as they were given.
    pub(super) fn places(&self) -> impl Iterator<Item = Vector2<f64>> {
        self.sightings.iter().map(|s| s.place.xy() + self.centre)
    }

    /// The sightings that are kept, about the same middle.
    pub(super) fn only(&self, kept: &[bool]) -> Self {
        let both = self.sightings.iter().zip(kept);
        Self {
            centre: self.centre,
            sightings: both.filter(|(_, kept)| **kept).map(|(s, _)| *s).collect(),
        }
    }

    /// The sightings with their information times these weights.
    pub(super) fn weighed(&self, weights: &[f64]) -> Self {
        let weigh = |(s, weight): (&Ready, &f64)| Ready {
            information: s.information * *weight,
            ..*s
        };
        Self {
            centre: self.centre,
            sightings: self.sightings.iter().zip(weights).map(weigh).collect(),
        }
    }
}
