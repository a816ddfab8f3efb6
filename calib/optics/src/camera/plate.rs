//! A plate that is not flat: its height over the plane of the grid, the same in every view.
//!
//! With `(u, w)` the place from the middle of all discs in units of half the grid's longer side
//!
//! ```text
//! z = b1 u^2 + b2 u w + b3 w^2, mm                                                                              (9)
//! ```
//!
//! A plane is no part of it, as the pose has one. Sheet that was rolled, pressed or is held at its ends bends so; what is
//! finer is the field's ([`super::field`]).

use nalgebra::{DMatrix, DVector, Matrix3, Vector2, Vector3};

use super::field::Waves;
use super::fitted::Field;
use super::model::PARAMETERS;
use super::view::View;

/// The numbers of (9), mm.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Bend(pub(super) [f64; Self::NUMBERS]);

impl Bend {
    /// How many.
    pub(super) const NUMBERS: usize = 3;

    /// The height where the powers of the place are `bow`, mm.
    pub(super) fn height(&self, bow: &[f64; Self::NUMBERS]) -> f64 {
        self.0.iter().zip(bow).map(|(b, power)| b * power).sum()
    }
}

/// What (9) measures places in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Ruler {
    middle: Vector2<f64>,
    half: f64,
}

impl Ruler {
    /// Of views that were checked: finite places, not all of them the same.
    pub(super) fn of(views: &[View]) -> Self {
        let places = || views.iter().flat_map(|v| &v.sightings).map(|s| s.at_mm);
        let least = places().reduce(|a, b| a.inf(&b)).unwrap_or_default();
        let most = places().reduce(|a, b| a.sup(&b)).unwrap_or_default();
        Self {
            middle: (least + most) / 2.0,
            half: ((most - least).max() / 2.0).max(f64::MIN_POSITIVE),
        }
    }

    /// `(u, w)` of a place.
    pub(super) fn place(&self, at_mm: Vector2<f64>) -> Vector2<f64> {
        (at_mm - self.middle) / self.half
    }

    /// `u^2`, `u w`, `w^2` of a place.
    pub(super) fn bow(&self, at_mm: Vector2<f64>) -> [f64; Bend::NUMBERS] {
        let p = self.place(at_mm);
        [p.x * p.x, p.x * p.y, p.y * p.y]
    }
}

/// The field by which the discs lie off the paraboloid ([`super::Options::field`]).
#[derive(Debug, Clone, PartialEq)]
pub struct PlateField {
    waves: Waves,
    numbers: DVector<f64>,
    /// Of the numbers of (9), then of the field's.
    covariance: DMatrix<f64>,
    /// The deviation of the random field that the views make the likeliest, in height and of each axis in the plane, mm: before
    /// what pose, bend and focal lengths say is taken out of it.
    pub sizes_mm: [f64; 2],
    /// Root mean square of the field over the discs seen, in height and of each axis in the plane, mm.
    pub rms_mm: [f64; 2],
    /// How many of the field's numbers the views fix.
    pub fixed: f64,
}

/// How far the grid's plate is from flat.
#[derive(Debug, Clone, PartialEq)]
pub struct Plate {
    ruler: Ruler,
    bend: Bend,
    /// The field, where it was adjusted.
    pub field: Option<PlateField>,
    /// Covariance of the numbers of (9), square millimetres.
    pub covariance: Matrix3<f64>,
}

impl Plate {
    pub(super) fn new(views: &[View], bend: Bend, covariance: Matrix3<f64>) -> Self {
        Self {
            ruler: Ruler::of(views),
            bend,
            field: None,
            covariance,
        }
    }

    /// With a field, whose covariance grows by `scale`.
    pub(super) fn with(mut self, field: Option<&Field>, views: &[View], scale: f64) -> Self {
        self.field = field.map(|f| PlateField {
            waves: f.waves.clone(),
            numbers: f.numbers.clone(),
            covariance: f.plate(PARAMETERS) * scale,
            sizes_mm: f.sizes_mm,
            rms_mm: rms(views, f),
            fixed: f.fixed,
        });
        self
    }

    /// The numbers of (9): of u^2, u w and w^2, mm.
    pub fn numbers_mm(&self) -> [f64; 3] {
        self.bend.0
    }

    /// The origin of (9), on the grid, mm, and its unit, half the longer side, mm.
    pub fn ruler_mm(&self) -> (Vector2<f64>, f64) {
        (self.ruler.middle, self.ruler.half)
    }

    /// The height over the grid's plane at a place of the grid, mm, along the grid's third axis.
    pub fn height_mm(&self, at_mm: Vector2<f64>) -> f64 {
        self.offset_mm(at_mm).z
    }

    /// Where the disc of a place of the grid lies from that place, mm, along the grid's axes: the field's share of the
    /// first two is nothing without a field. Among the discs: beyond them a field grows with the square of the distance, and
    /// says nothing.
    pub fn offset_mm(&self, at_mm: Vector2<f64>) -> Vector3<f64> {
        let bend = Vector3::z() * self.bend.height(&self.ruler.bow(at_mm));
        let field = self.field.as_ref().map(|f| f.waves.offset(at_mm, &f.numbers));
        bend + field.unwrap_or_default()
    }

    /// The standard deviations of [`Plate::offset_mm`], mm.
    pub fn deviation_mm(&self, at_mm: Vector2<f64>) -> Vector3<f64> {
        let bow = Vector3::from(self.ruler.bow(at_mm));
        match &self.field {
            None => Vector3::z() * bow.dot(&(self.covariance * bow)).max(0.0).sqrt(),
            Some(field) => field.deviation_mm(at_mm, &bow),
        }
    }
}

/// Root mean square of a field over the discs seen.
fn rms(views: &[View], field: &Field) -> [f64; 2] {
    let places = views.iter().flat_map(|v| &v.sightings).map(|s| s.at_mm);
    let squares = places
        .map(|at| field.waves.offset(at, &field.numbers))
        .map(|o| o.component_mul(&o));
    let (count, sum) = squares.fold((0.0, Vector3::zeros()), |(n, sum), s| (n + 1.0, sum + s));
    let mean = sum / f64::max(count, 1.0);
    [mean.z, 0.5 * (mean.x + mean.y)].map(f64::sqrt)
}

impl PlateField {
    fn deviation_mm(&self, at_mm: Vector2<f64>, bow: &Vector3<f64>) -> Vector3<f64> {
        let ([lift, slide], m) = (self.waves.at(at_mm), self.waves.count());
        let deviation = |axis: usize, wave: &DVector<f64>| {
            let mut row = DVector::zeros(self.covariance.nrows());
            row.rows_mut(Bend::NUMBERS + axis * m, m).copy_from(wave);
            if axis == 0 {
                row.rows_mut(0, Bend::NUMBERS).copy_from(bow);
            }
            row.dot(&(&self.covariance * &row)).max(0.0).sqrt()
        };
        Vector3::new(deviation(1, &slide), deviation(2, &slide), deviation(0, &lift))
    }
}
