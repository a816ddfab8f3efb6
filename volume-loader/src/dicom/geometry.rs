//! Where a stack of slices lies, from each slice's own position and orientation (DICOM PS3.3, C.7.6.2.1.1).

mod error;

use ::geometry::{Affine, Ct, Point, Vector, Voxel};

use super::facts::Steps;
use super::header::Placed;
pub use error::{Gap, GeometryError};

/// Fewer slices have no inner step that could be compared with another.
const MIN_SLICES: usize = 3;
/// Cosines may be this far from unit length and right angles, and are made exact then.
const ORIENTATION_MAX: f64 = 1e-3;
/// Closer than this they are taken as they stand: six decimals, as scanners print them.
const ORIENTATION_EXACT: f64 = 1e-6;
/// Slices closer than this lie at one place, mm.
const SAME_PLACE_MM: f64 = 1e-3;
/// Positions may lie this far beside one line, mm: a tenth of a usual pixel.
const LATERAL_MAX_MM: f64 = 0.05;
/// Steps are even within this and within [`UNEVEN_PART`] of the step, mm: positions printed with two decimals.
pub(crate) const UNEVEN_MM: f64 = 0.01;
pub(crate) const UNEVEN_PART: f64 = 0.01;
/// The map may put a corner of a slice this far from where its own header puts it, mm: a tenth of what navigation can
/// tell, and above the rounding of positions printed with one decimal.
pub(crate) const CORNER_MAX_MM: f64 = 0.1;

/// Slices in order along the line of their positions.
#[derive(Debug, Clone)]
pub(crate) struct Stack {
    /// Which slice comes first, second and so on.
    pub order: Vec<usize>,
    /// The slices, in that order.
    slices: Vec<Placed>,
    /// One pixel to the right and one pixel down, mm.
    pub pixel: [Vector<Ct>; 2],
    /// Along the normal, unit length.
    pub normal: Vector<Ct>,
    /// From the first slice to the last, unit length.
    pub line: Vector<Ct>,
    /// Each slice's place along the line, mm from the first.
    pub along_mm: Vec<f64>,
    /// The steps between them.
    pub steps: Steps,
    /// How far the cosines were from exact axes, where they were made exact.
    pub straightened: Option<f64>,
}

impl Stack {
    /// Puts slices in order and checks that they lie on a line; their steps are judged by [`Stack::even`].
    ///
    /// # Errors
    /// [`GeometryError`] but `Uneven`, `Corner` and `Askew`.
    pub(crate) fn of(slices: &[Placed]) -> Result<Self, GeometryError> {
        if slices.len() < MIN_SLICES {
            return Err(GeometryError::TooFew { found: slices.len() });
        }
        Self::of_planes(slices)
    }

    /// The same for as few as one, where the step between them is known otherwise: one plane goes on along its normal.
    ///
    /// # Errors
    /// As [`Stack::of`].
    pub(crate) fn of_planes(slices: &[Placed]) -> Result<Self, GeometryError> {
        let Some(middle) = slices.get(slices.len() / 2) else {
            return Err(GeometryError::TooFew { found: 0 });
        };
        let Axes {
            row,
            column,
            straightened,
        } = axes(middle.orientation)?;
        let normal = unit(row.cross(column));
        let height = |i: usize| (position(&slices[i]) - Point::new(0.0, 0.0, 0.0)).dot(normal);
        let mut order: Vec<usize> = (0..slices.len()).collect();
        order.sort_by(|&a, &b| height(a).total_cmp(&height(b)).then(a.cmp(&b)));
        let heights: Vec<f64> = order.iter().map(|&i| height(i)).collect();
        check_places(&heights)?;
        let slices: Vec<Placed> = order.iter().map(|&i| slices[i]).collect();
        let (line, along_mm) = along_line(&slices, normal)?;
        check_places(&along_mm)?;
        let [down, right] = slices[slices.len() / 2].spacing;
        let pixel = [row * right, column * down];
        let determinant = pixel[0].cross(pixel[1]).dot(line);
        // Not a number is refused too.
        if determinant.is_nan() || determinant <= 0.0 {
            return Err(GeometryError::Mirrored { determinant });
        }
        Ok(Self {
            order,
            slices,
            pixel,
            normal,
            line,
            steps: Steps::of(&along_mm),
            along_mm,
            straightened,
        })
    }

    /// Where the first pixel of the first slice lies.
    pub(crate) fn origin(&self) -> Point<Ct> {
        self.slices.first().map_or(Point::new(0.0, 0.0, 0.0), position)
    }

    /// The map from voxels, with `step_mm` from slice to slice along the line.
    pub(crate) fn ct_from_voxel(&self, step_mm: f64) -> Affine<Ct, Voxel> {
        let [right, down] = self.pixel;
        Affine::from_steps(self.origin(), [right, down, self.line * step_mm])
    }

    /// The step of an even grid: the difference of the last and the first position, divided.
    pub(crate) fn even_step_mm(&self) -> f64 {
        self.along_mm.last().unwrap_or(&0.0) / (self.along_mm.len() - 1) as f64
    }

    /// The largest distance in mm between a corner of a slice after its own header and after the map that takes slice k
    /// to `along(k)` mm along the line; and which slice it is.
    pub(crate) fn worst_corner(&self, [columns, rows]: [u16; 2], along: impl Fn(usize) -> f64) -> (usize, f64) {
        let [right, down] = self.pixel;
        let (x, y) = (f64::from(columns) - 1.0, f64::from(rows) - 1.0);
        let error = |k: usize, slice: &Placed| {
            let [ax, ay, az, bx, by, bz] = slice.orientation;
            let own_right = Vector::new(ax, ay, az) * slice.spacing[1];
            let own_down = Vector::new(bx, by, bz) * slice.spacing[0];
            let apart = position(slice) - (self.origin() + self.line * along(k));
            let corner = |x: f64, y: f64| (apart + (own_right - right) * x + (own_down - down) * y).norm();
            corner(0.0, 0.0)
                .max(corner(x, 0.0))
                .max(corner(0.0, y))
                .max(corner(x, y))
        };
        let errors = self.slices.iter().enumerate().map(|(k, slice)| (k, error(k, slice)));
        errors.fold((0, 0.0), |worst, next| if next.1 > worst.1 { next } else { worst })
    }

    /// Judges the steps, and an even grid of [`Stack::even_step_mm`]; gives its worst corner error, mm.
    ///
    /// # Errors
    /// [`GeometryError::Uneven`], [`GeometryError::Corner`].
    pub(crate) fn even(&self, size: [u16; 2]) -> Result<f64, GeometryError> {
        let gaps = self.gaps();
        if !gaps.is_empty() {
            return Err(GeometryError::Uneven {
                step_mm: self.steps.median_mm,
                steps: self.along_mm.len() - 1,
                gaps,
            });
        }
        let step = self.even_step_mm();
        let (slice, found_mm) = self.worst_corner(size, |k| k as f64 * step);
        if found_mm > CORNER_MAX_MM {
            return Err(GeometryError::Corner { slice, found_mm });
        }
        Ok(found_mm)
    }

    /// Judges slices that are put on an even grid, each at its own place along the line; gives the worst corner error, mm.
    ///
    /// # Errors
    /// [`GeometryError::Askew`].
    pub(crate) fn askew(&self, size: [u16; 2]) -> Result<f64, GeometryError> {
        let along = |k: usize| self.along_mm.get(k).copied().unwrap_or(0.0);
        let (slice, found_mm) = self.worst_corner(size, along);
        match found_mm > CORNER_MAX_MM {
            true => Err(GeometryError::Askew { slice, found_mm }),
            false => Ok(found_mm),
        }
    }

    fn gaps(&self) -> Vec<Gap> {
        let expected = self.steps.median_mm;
        let most = UNEVEN_MM.max(UNEVEN_PART * expected);
        let steps = self.along_mm.iter().zip(self.along_mm.iter().skip(1)).enumerate();
        let gap = |(after, (&low, &high)): (usize, (&f64, &f64))| Gap {
            after,
            position_mm: low,
            expected_mm: expected,
            found_mm: high - low,
            missing: (((high - low) / expected).round() as u64).saturating_sub(1),
        };
        steps
            .map(gap)
            .filter(|gap| (gap.found_mm - expected).abs() > most)
            .collect()
    }

    /// Angle between the line of positions and the normal, degrees: the tilt of the gantry.
    pub(crate) fn tilt_deg(&self) -> f64 {
        let sine = self.line.cross(self.normal).norm();
        sine.atan2(self.line.dot(self.normal)).to_degrees()
    }

    /// First pixel of each slice, in order along the stack.
    pub(crate) fn positions(&self) -> Vec<[f64; 3]> {
        self.slices.iter().map(|slice| slice.position).collect()
    }
}

fn position(slice: &Placed) -> Point<Ct> {
    let [x, y, z] = slice.position;
    Point::new(x, y, z)
}

fn unit(v: Vector<Ct>) -> Vector<Ct> {
    v.direction().map_or(v, |direction| direction.vector())
}

/// Directions of a row and of a column.
struct Axes {
    row: Vector<Ct>,
    column: Vector<Ct>,
    /// How far they were off, where they had to be made exact.
    straightened: Option<f64>,
}

fn axes(found: [f64; 6]) -> Result<Axes, GeometryError> {
    let [ax, ay, az, bx, by, bz] = found;
    let (row, column) = (Vector::new(ax, ay, az), Vector::new(bx, by, bz));
    let deviations = [row.norm() - 1.0, column.norm() - 1.0, row.dot(column)];
    let error = deviations.iter().fold(0.0, |most: f64, d| most.max(d.abs()));
    if error > ORIENTATION_MAX {
        return Err(GeometryError::Orientation { found, error });
    }
    if error <= ORIENTATION_EXACT {
        return Ok(Axes {
            row,
            column,
            straightened: None,
        });
    }
    let row = unit(row);
    Ok(Axes {
        row,
        column: unit(column - row * row.dot(column)),
        straightened: Some(error),
    })
}

/// No two of ascending `places` may be one.
fn check_places(places: &[f64]) -> Result<(), GeometryError> {
    let (mut groups, mut size) = (Vec::new(), 1);
    for (low, high) in places.iter().zip(places.iter().skip(1)) {
        if high - low < SAME_PLACE_MM {
            size += 1;
            continue;
        }
        groups.push(std::mem::replace(&mut size, 1));
    }
    groups.push(size);
    groups.retain(|&size| size > 1);
    let total = places.len();
    match groups.is_empty() {
        true => Ok(()),
        false => Err(GeometryError::Duplicates { groups, total }),
    }
}

/// The direction from the first slice to the last, and each slice's place along it; of one slice, its normal.
fn along_line(slices: &[Placed], normal: Vector<Ct>) -> Result<(Vector<Ct>, Vec<f64>), GeometryError> {
    let ends = slices
        .first()
        .zip(slices.last())
        .map(|(a, b)| (position(a), position(b)));
    let Some((first, last)) = ends else {
        return Err(GeometryError::TooFew { found: 0 });
    };
    let line = if slices.len() == 1 { normal } else { unit(last - first) };
    let mut along = Vec::with_capacity(slices.len());
    for (slice, placed) in slices.iter().enumerate() {
        let from_first = position(placed) - first;
        let mm = from_first.dot(line);
        let found_mm = (from_first - line * mm).norm();
        // Not a number where positions overflow: refused too.
        if found_mm.is_nan() || found_mm > LATERAL_MAX_MM {
            return Err(GeometryError::NotOnALine { slice, found_mm });
        }
        along.push(mm);
    }
    Ok((line, along))
}
