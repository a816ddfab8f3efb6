//! A slice plane: where in the patient each pixel of an image lies.

use std::fmt;

use crate::{Ct, Direction, Point, Vector, VolumeGrid};

/// Largest image side, pixels.
const MAX_SIDE: u32 = 8192;
/// Pixel sizes outside this range (mm) are refused.
const PIXEL_MM: std::ops::RangeInclusive<f64> = 1e-6..=1e3;

/// A rectangle of square pixels in the patient.
///
/// `right` and `down` are orthogonal unit vectors in LPS; the viewer looks along `right x down`, into the screen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SlicePlane {
    origin: Point<Ct>,
    right: Direction<Ct>,
    down: Direction<Ct>,
    pixel_mm: f64,
    size: [u32; 2],
}

/// Where a point of the patient falls on an image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Projected {
    /// Pixel column, continuous; whole numbers are pixel centres.
    pub x: f64,
    /// Pixel row, continuous.
    pub y: f64,
    /// Signed distance from the plane, mm; positive lies behind the plane, away from the viewer.
    pub depth_mm: f64,
}

/// Why a plane was refused.
#[derive(Debug, Clone, PartialEq)]
pub enum PlaneError {
    /// A side is zero or too long.
    Size([u32; 2]),
    /// The pixel size is not usable.
    Pixel(f64),
    /// The two image axes are not orthogonal; the cosine between them.
    Skewed(f64),
    /// The middle or the first pixel is not a place: NaN or infinite, mm.
    Centre([f64; 3]),
}

impl fmt::Display for PlaneError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Size([w, h]) => write!(f, "an image of {w} x {h} pixels; allowed are 1 to {MAX_SIDE} a side"),
            Self::Pixel(mm) => write!(
                f,
                "a pixel of {mm} mm; allowed are {} to {} mm",
                PIXEL_MM.start(),
                PIXEL_MM.end()
            ),
            Self::Centre(mm) => write!(f, "an image about {mm:?} mm; three finite numbers are needed"),
            Self::Skewed(cosine) => write!(
                f,
                "image axes with cosine {cosine} between them; they must be orthogonal"
            ),
        }
    }
}

impl std::error::Error for PlaneError {}

impl SlicePlane {
    /// The plane of `size` (width, height) pixels of `pixel_mm` whose middle is `centre`.
    ///
    /// # Errors
    /// Each variant of [`PlaneError`]; axes count as orthogonal below a cosine of 1e-12.
    pub fn centred(
        centre: Point<Ct>,
        [right, down]: [Direction<Ct>; 2],
        pixel_mm: f64,
        size: [u32; 2],
    ) -> Result<Self, PlaneError> {
        // From the centre of the first pixel to that of the last are n - 1 steps.
        let half = |n: u32| (f64::from(n) - 1.0) / 2.0 * pixel_mm;
        let plane = Self {
            origin: centre,
            right,
            down,
            pixel_mm,
            size,
        };
        plane.check()?;
        Ok(Self {
            origin: centre - right * half(size[0]) - down * half(size[1]),
            ..plane
        })
    }

    /// The plane of `size` pixels through `through` on which all of `grid` is seen: centred on it, with the smallest pixels that do so.
    ///
    /// # Errors
    /// As of [`SlicePlane::centred`].
    pub fn covering(
        grid: &VolumeGrid,
        through: Point<Ct>,
        axes: [Direction<Ct>; 2],
        size: [u32; 2],
    ) -> Result<Self, PlaneError> {
        let [right, down] = axes;
        let normal = right.cross(down);
        let centre = grid.centre();
        let centre = centre + normal * (through - centre).dot(normal);
        let (low, high) = grid.bounds();
        let diagonal = (high - low).mm();
        let across = |d: Direction<Ct>| -> f64 { d.components().iter().zip(diagonal).map(|(c, e)| c.abs() * e).sum() };
        let pixel_mm = (across(right) / f64::from(size[0])).max(across(down) / f64::from(size[1]));
        Self::centred(centre, axes, pixel_mm, size)
    }

    /// The plane whose first pixel (column 0, row 0) has its centre at `origin`; the numbers stay as they are.
    ///
    /// # Errors
    /// As [`SlicePlane::centred`], where `origin` is the place.
    pub fn from_origin(
        origin: Point<Ct>,
        [right, down]: [Direction<Ct>; 2],
        pixel_mm: f64,
        size: [u32; 2],
    ) -> Result<Self, PlaneError> {
        let plane = Self {
            origin,
            right,
            down,
            pixel_mm,
            size,
        };
        plane.check().map(|()| plane)
    }

    fn check(&self) -> Result<(), PlaneError> {
        let Self { size, pixel_mm, .. } = *self;
        if size.iter().any(|&n| n == 0 || n > MAX_SIDE) {
            return Err(PlaneError::Size(size));
        }
        if !PIXEL_MM.contains(&pixel_mm) {
            return Err(PlaneError::Pixel(pixel_mm));
        }
        let cosine = self.right.dot(self.down);
        // A comparison with NaN is false: it must not pass as a small angle.
        if cosine.is_nan() || cosine.abs() > 1e-12 {
            return Err(PlaneError::Skewed(cosine));
        }
        let place = self.origin.mm();
        if !place.iter().all(|c| c.is_finite()) {
            return Err(PlaneError::Centre(place));
        }
        Ok(())
    }

    /// Centre of the first pixel (column 0, row 0).
    pub fn origin(&self) -> Point<Ct> {
        self.origin
    }

    /// Direction of growing columns.
    pub fn right(&self) -> Direction<Ct> {
        self.right
    }

    /// Direction of growing rows.
    pub fn down(&self) -> Direction<Ct> {
        self.down
    }

    /// Direction in which the viewer looks: `right x down`.
    pub fn into_screen(&self) -> Direction<Ct> {
        // Both are unit and orthogonal, so the product is unit to a few ulp.
        Direction::wrap(self.right.cross(self.down).0)
    }

    /// Side of a pixel, mm.
    pub fn pixel_mm(&self) -> f64 {
        self.pixel_mm
    }

    /// Width and height in pixels.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// The position of pixel (`x`, `y`), continuous.
    pub fn point(&self, x: f64, y: f64) -> Point<Ct> {
        self.origin + self.step_right() * x + self.step_down() * y
    }

    /// The step from one column to the next.
    pub fn step_right(&self) -> Vector<Ct> {
        self.right * self.pixel_mm
    }

    /// The step from one row to the next.
    pub fn step_down(&self) -> Vector<Ct> {
        self.down * self.pixel_mm
    }

    /// Where `p` falls on the image, by orthogonal projection.
    pub fn project(&self, p: Point<Ct>) -> Projected {
        let d = p - self.origin;
        Projected {
            x: d.dot(self.right.vector()) / self.pixel_mm,
            y: d.dot(self.down.vector()) / self.pixel_mm,
            depth_mm: d.dot(self.into_screen().vector()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn projection_undoes_point() {
        let centre = Point::new(5.0, -7.0, 90.0);
        let plane = SlicePlane::centred(centre, [Direction::X, -Direction::Z], 0.5, [512, 256]).unwrap();
        let p = plane.project(plane.point(100.25, 20.5));
        // A dozen roundings of numbers below 512.
        assert!((p.x - 100.25).abs() < 1e-11 && (p.y - 20.5).abs() < 1e-11 && p.depth_mm.abs() < 1e-11);
        let middle = plane.project(centre);
        assert!((middle.x - 255.5).abs() < 1e-11 && (middle.y - 127.5).abs() < 1e-11);
    }

    #[test]
    fn frontal_view_looks_to_the_back() {
        let plane = SlicePlane::centred(Point::new(0.0, 0.0, 0.0), [Direction::X, -Direction::Z], 1.0, [9, 9]).unwrap();
        assert_eq!(plane.into_screen().components(), [0.0, 1.0, 0.0]);
        assert!(plane.project(Point::new(0.0, 10.0, 0.0)).depth_mm > 0.0);
    }

    #[test]
    fn refuses_unusable_planes() {
        let at = |axes, pixel, size| SlicePlane::centred(Point::new(0.0, 0.0, 0.0), axes, pixel, size);
        let axes = [Direction::X, Direction::Y];
        assert!(matches!(at(axes, 1.0, [0, 5]), Err(PlaneError::Size(_))));
        for pixel in [f64::NAN, 0.0, -1.0, 1e-7, 1.1e3, f64::INFINITY] {
            assert!(matches!(at(axes, pixel, [5, 5]), Err(PlaneError::Pixel(_))), "{pixel}");
        }
        for bad in [f64::NAN, f64::INFINITY] {
            let centred = SlicePlane::centred(Point::new(0.0, bad, 0.0), axes, 1.0, [5, 5]);
            assert!(matches!(centred, Err(PlaneError::Centre(_))), "{bad}");
        }
        assert!(matches!(
            at([Direction::X, Direction::X], 1.0, [5, 5]),
            Err(PlaneError::Skewed(_))
        ));
    }
}
