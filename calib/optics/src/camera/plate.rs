//! A plate that is not flat, as it was found: the paraboloid of [`super::paraboloid`] and, where it was asked for, the field of
//! [`super::plate_field`].

use nalgebra::{DMatrix, DVector, Matrix3, Vector2, Vector3};

use super::fitted::Field;
use super::model::PARAMETERS;
use super::paraboloid::{Bend, Ruler};
use super::plate_field::Waves;
use super::view::View;

/// The field by which the discs lie off the paraboloid ([`super::Options::field`]).
#[derive(Debug, Clone, PartialEq)]
pub struct PlateField {
    waves: Waves,
    coefficients: DVector<f64>,
    /// Of the numbers of (9), then of the field's coefficients.
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
            ruler: Ruler::of(places(views)),
            bend,
            field: None,
            covariance,
        }
    }

    /// With a field, whose covariance grows by `scale`.
    pub(super) fn with(mut self, field: Option<&Field>, views: &[View], scale: f64) -> Self {
        self.field = field.map(|f| PlateField {
            waves: f.waves.clone(),
            coefficients: f.coefficients.clone(),
            covariance: f.plate(PARAMETERS) * scale,
            sizes_mm: f.prior_sd_mm,
            rms_mm: rms(views, f),
            fixed: f.effective_parameters,
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
        let field = self.field.as_ref().map(|f| f.waves.offset(at_mm, &f.coefficients));
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

/// Where the discs that are seen lie on the grid, mm.
pub(super) fn places(views: &[View]) -> impl Iterator<Item = Vector2<f64>> + Clone {
    views.iter().flat_map(|v| &v.sightings).map(|s| s.at_mm)
}

/// Root mean square of a field over the discs seen.
fn rms(views: &[View], field: &Field) -> [f64; 2] {
    let squares = places(views)
        .map(|at| field.waves.offset(at, &field.coefficients))
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
