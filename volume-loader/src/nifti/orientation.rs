//! From NIfTI's sform and qform, in RAS and some unit, to `ct_from_voxel`, in LPS and mm; and back.

use geometry::{Affine, Ct, GridError, Point, VolumeGrid, Voxel};

use super::error::HeaderError;
use super::fields::Fields;

/// The two orientations of one file may differ by this much at a corner, mm, before a person is told.
const DISAGREEMENT_MM: f64 = 1.0;
/// How far from a right angle (cosine) axes may be for a qform, which knows only rotations.
const SKEW: f64 = 1e-5;
/// And for ITK, which reads 9e-5 and refuses 1.1e-4 (SimpleITK 2.5.7): "no orthonormal definition found".
const ITK_SKEW: f64 = 1e-4;
/// How far (relative) `pixdim` may be from the length of the sform's step: both are single, and some programs round to three digits.
const STEPS: f64 = 1e-3;
/// From unknown to another template (nifti1.h, `NIFTI_XFORM`).
const CODES: std::ops::RangeInclusive<i64> = 0..=5;
/// A quaternion's a is zero where its square is below this.
const HALF_TURN: f64 = 1e-7;

type Rows = [[f64; 4]; 3];

/// The map to the patient, which form it is by, and what is doubtful about it, a sentence each.
pub(crate) struct Placed {
    pub ct_from_voxel: Affine<Ct, Voxel>,
    pub form: String,
    pub doubts: Vec<String>,
}

/// Where a header puts its voxels in the patient.
///
/// # Errors
/// [`HeaderError::Units`], [`HeaderError::Code`], [`HeaderError::NoOrientation`], [`HeaderError::Quaternion`], [`HeaderError::Sides`],
/// [`HeaderError::Mirrored`], [`HeaderError::Steps`].
pub(crate) fn ct_from_voxel(fields: &Fields) -> Result<Placed, HeaderError> {
    let (mm, mut doubts) = mm_per_unit(fields.units)?;
    let lps_mm = |ras: Rows| Affine::from_rows(lps_from_ras(ras).map(|row| row.map(|v| v * mm)));
    let (sform, qform) = (fields.sform_code, fields.qform_code);
    // A code that nobody defined is a damaged header, of which no form can be relied on.
    if [sform, qform].iter().any(|code| !CODES.contains(code)) {
        return Err(HeaderError::Code { sform, qform });
    }
    if sform <= 0 && qform <= 0 {
        return Err(HeaderError::NoOrientation { sform, qform });
    }
    if sform <= 0 {
        let form = format!("oriented by qform {qform}");
        return Ok(Placed {
            ct_from_voxel: lps_mm(ras_from_qform(fields)?),
            form,
            doubts,
        });
    }
    steps_agree(fields)?;
    let chosen = lps_mm(fields.srow);
    if qform > 0 {
        opposed(chosen, ras_from_qform(fields).map(lps_mm))?;
        doubts.extend(disagreement(fields, chosen, ras_from_qform(fields).map(lps_mm)));
    }
    Ok(Placed {
        ct_from_voxel: chosen,
        form: format!("oriented by sform {sform}"),
        doubts,
    })
}

/// RAS to LPS and back: the same change.
fn lps_from_ras([x, y, z]: Rows) -> Rows {
    // Adding zero makes -0 a plain 0.
    [x.map(|v| 0.0 - v), y.map(|v| 0.0 - v), z]
}

fn mm_per_unit(units: i64) -> Result<(f64, Vec<String>), HeaderError> {
    match units & 7 {
        0 => Ok((1.0, vec!["unit of length unknown, taken as mm".to_owned()])),
        1 => Ok((1e3, vec!["lengths converted from metres".to_owned()])),
        2 => Ok((1.0, Vec::new())),
        3 => Ok((1e-3, vec!["lengths converted from micrometres".to_owned()])),
        length => Err(HeaderError::Units { found: units, length }),
    }
}

/// NIfTI's "method 2": rotation (a, b, c, d), spacings `pixdim[1..=3]`, and `pixdim[0]` = -1 for a mirrored third axis.
fn ras_from_qform(fields: &Fields) -> Result<Rows, HeaderError> {
    let [b, c, d] = fields.quaternion_bcd;
    let square = b * b + c * c + d * d;
    // Stored as f32: half turns come out slightly above 1. A NaN is refused here too.
    if square.is_nan() || square > 1.0 + 1e-5 {
        return Err(HeaderError::Quaternion {
            found: [b, c, d],
            norm: square.sqrt(),
        });
    }
    // As nifti1_io.c's nifti_quatern_to_mat44 does it: what f32 leaves of a half turn is one, and no turn by 0.6 mrad more.
    let (shrink, a) = match 1.0 - square < HALF_TURN {
        true => (square.sqrt(), 0.0),
        false => (1.0, (1.0 - square).sqrt()),
    };
    let (b, c, d) = (b / shrink, c / shrink, d / shrink);
    let rotation = [
        [
            a * a + b * b - c * c - d * d,
            2.0 * (b * c - a * d),
            2.0 * (b * d + a * c),
        ],
        [
            2.0 * (b * c + a * d),
            a * a + c * c - b * b - d * d,
            2.0 * (c * d - a * b),
        ],
        [
            2.0 * (b * d - a * c),
            2.0 * (c * d + a * b),
            a * a + d * d - b * b - c * c,
        ],
    ];
    // NIfTI wants them positive; a negative one would mirror the patient.
    if let Some(axis) = (0..3).find(|&axis| fields.pixdim[axis + 1] < 0.0) {
        let found_mm = fields.pixdim[axis + 1];
        return Err(GridError::Spacing { axis, found_mm }.into());
    }
    let mirror = if fields.pixdim[0] < 0.0 { -1.0 } else { 1.0 };
    let [_, sx, sy, sz, ..] = fields.pixdim;
    let steps = [sx, sy, sz * mirror];
    Ok(std::array::from_fn(|r| {
        let [x, y, z] = std::array::from_fn(|i| rotation[r][i] * steps[i]);
        [x, y, z, fields.qoffset[r]]
    }))
}

/// Refuses two orientations of which one turns an axis round, or is the other in a mirror: programs differ in which of them they go by, and so in which side is left.
fn opposed(chosen: Affine<Ct, Voxel>, other: Result<Affine<Ct, Voxel>, HeaderError>) -> Result<(), HeaderError> {
    // One that is not usable has no sides, and is told of.
    let Ok(other) = other else { return Ok(()) };
    let against = |axis: &usize| chosen.step(*axis).dot(other.step(*axis)) < 0.0;
    match (0..3).find(against) {
        Some(axis) => Err(HeaderError::Sides { axis }),
        None if chosen.determinant() * other.determinant() < 0.0 => Err(HeaderError::Mirrored),
        None => Ok(()),
    }
}

/// Refuses an sform whose steps are not those of `pixdim`: ITK goes by the one and others by the other, where one is negative even to
/// opposite sides.
fn steps_agree(fields: &Fields) -> Result<(), HeaderError> {
    for axis in 0..3 {
        let pixdim = fields.pixdim[axis + 1];
        let step = fields.srow.iter().map(|row| row[axis] * row[axis]).sum::<f64>().sqrt();
        // One of 0 says nothing, and a step of 0 or that is no number is refused with the grid.
        let is_told = step > 0.0 && step.is_finite() && pixdim != 0.0;
        // Not true of what is no number.
        let agrees = (pixdim - step).abs() <= STEPS * step;
        if is_told && !agrees {
            return Err(HeaderError::Steps { axis, step, pixdim });
        }
    }
    Ok(())
}

fn disagreement(
    fields: &Fields,
    chosen: Affine<Ct, Voxel>,
    other: Result<Affine<Ct, Voxel>, HeaderError>,
) -> Option<String> {
    let other = match other {
        Ok(other) => other,
        Err(error) => return Some(format!("the qform is not used, and not usable: {error}")),
    };
    let [_, nx, ny, nz, ..] = fields.dim;
    let corner = |i: i32| {
        let far = |axis: i32, n: i64| if i >> axis & 1 == 1 { (n - 1) as f64 } else { 0.0 };
        let voxel = Point::<Voxel>::new(far(0, nx), far(1, ny), far(2, nz));
        (chosen * voxel).distance(other * voxel)
    };
    let apart = (0..8).map(corner).fold(0.0, f64::max);
    let text = format!("the qform puts a corner {apart:.1} mm elsewhere and is not used");
    (apart > DISAGREEMENT_MM).then_some(text)
}

/// What the writer puts into a header.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct RasForms {
    /// The sform's rows, mm.
    pub srow: Rows,
    /// The quaternion's b, c, d and `pixdim[0]`; absent where the axes are not at right angles.
    pub quaternion_bcd_qfac: Option<([f64; 3], f64)>,
}

/// Whether the axes of a grid are so far from right angles that programs built on ITK refuse a NIfTI file of it.
pub fn is_sheared(grid: &VolumeGrid) -> bool {
    let axes = axes(&lps_from_ras(grid.ct_from_voxel().rows()), grid.spacing_mm());
    worst_cosine(&axes) > ITK_SKEW
}

/// The columns of the first three, made of unit length.
fn axes(rows: &Rows, spacing_mm: [f64; 3]) -> [[f64; 3]; 3] {
    std::array::from_fn(|r| std::array::from_fn(|c| rows[r][c] / spacing_mm[c]))
}

/// The largest cosine between two columns.
fn worst_cosine(axes: &[[f64; 3]; 3]) -> f64 {
    let dot = |a: usize, b: usize| axes.iter().map(|row| row[a] * row[b]).sum::<f64>();
    [dot(0, 1), dot(0, 2), dot(1, 2)]
        .into_iter()
        .fold(0.0, |worst: f64, cosine| worst.max(cosine.abs()))
}

/// Both forms of `ct_from_voxel`, whose steps are `spacing_mm` long.
pub(crate) fn ras_forms(ct_from_voxel: &Affine<Ct, Voxel>, spacing_mm: [f64; 3]) -> RasForms {
    let srow = lps_from_ras(ct_from_voxel.rows());
    let mut axes = axes(&srow, spacing_mm);
    if worst_cosine(&axes) > SKEW {
        return RasForms {
            srow,
            quaternion_bcd_qfac: None,
        };
    }
    let qfac = if ct_from_voxel.determinant() < 0.0 { -1.0 } else { 1.0 };
    axes.iter_mut().for_each(|row| row[2] *= qfac);
    RasForms {
        srow,
        quaternion_bcd_qfac: Some((quaternion_bcd(&axes), qfac)),
    }
}

/// b, c, d of the rotation `m` with a >= 0: the largest component first, so that no division is by a small number.
fn quaternion_bcd(m: &[[f64; 3]; 3]) -> [f64; 3] {
    let (x, y, z) = (m[0][0], m[1][1], m[2][2]);
    // Four times the square of a, b, c, d.
    let squares = [1.0 + x + y + z, 1.0 + x - y - z, 1.0 - x + y - z, 1.0 - x - y + z];
    let largest = (0..4).fold(0, |best, i| if squares[i] > squares[best] { i } else { best });
    let [ab, ac, ad] = [m[2][1] - m[1][2], m[0][2] - m[2][0], m[1][0] - m[0][1]];
    let [bc, bd, cd] = [m[0][1] + m[1][0], m[0][2] + m[2][0], m[1][2] + m[2][1]];
    // Row of four times the outer product of (a, b, c, d) with itself.
    let row = match largest {
        0 => [squares[0], ab, ac, ad],
        1 => [ab, squares[1], bc, bd],
        2 => [ac, bc, squares[2], cd],
        _ => [ad, bd, cd, squares[3]],
    };
    let size = 2.0 * squares[largest].sqrt();
    let sign = if row[0] < 0.0 { -1.0 } else { 1.0 };
    [row[1], row[2], row[3]].map(|v| sign * v / size)
}
