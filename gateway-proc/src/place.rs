//! From Trocar's frames to those of the wire: patients are RAS there, LPS here. `S = diag(-1, -1, 1)` turns one into the other.

use geometry::{Rigid, SlicePlane, VolumeGrid};
use igtl::{ByteOrder, Image, Matrix, Scalar, Space, frame};

/// The thickness of a slice that is sent, mm: its images are of no thickness, and a receiver wants one.
const THICKNESS_MM: f64 = 1.0;
/// How far two steps of a volume may be off a right angle, degrees: 0.07 mm over 400 mm.
const SQUARE_DEGREES: f64 = 0.01;

/// A rigid motion as it stands on the wire, its frames as they are.
pub(crate) fn matrix<To, From>(pose: &Rigid<To, From>) -> Matrix {
    let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    Matrix {
        columns: axes.map(|axis| pose.rotation().apply(axis).map(single)),
        translation: pose.translation_mm().map(single),
    }
}

/// A pose in the patient as it stands on the wire: `S R S` and `S t`. Both frames are turned, as a receiver in RAS reads the files of
/// a tool's model from LPS too; the tool's axis, z, stays what it is.
pub(crate) fn in_ras<To, From>(pose: &Rigid<To, From>) -> Matrix {
    frame::turned_both(&matrix(pose))
}

/// A place of the patient, LPS mm, as it stands on the wire.
pub(crate) fn point_in_ras(mm: [f64; 3]) -> [f32; 3] {
    frame::turned(mm.map(single))
}

/// Single precision is what the wire carries: 0.03 um at 500 mm.
fn single(number: f64) -> f32 {
    number as f32
}

fn image(dimensions: [u16; 3], steps: [[f64; 3]; 3], middle: [f64; 3]) -> Image<'static> {
    let lps = Matrix {
        columns: steps.map(|step| step.map(single)),
        translation: middle.map(single),
    };
    Image {
        components: 1,
        scalar: Scalar::Uint8,
        order: if cfg!(target_endian = "little") {
            ByteOrder::Little
        } else {
            ByteOrder::Big
        },
        space: Space::Ras,
        dimensions,
        placed: frame::turned_target(&lps),
        offset: [0; 3],
        size: dimensions,
        voxels: Vec::new().into(),
    }
}

/// An image of red, green and blue in this plane, without its pixels: i goes right, j down, k into the screen, which is a
/// right-handed system. `None` where a side is longer than the wire can say.
pub(crate) fn of_plane(plane: &SlicePlane) -> Option<Image<'static>> {
    let [width, height] = plane.size();
    let dimensions = [u16::try_from(width).ok()?, u16::try_from(height).ok()?, 1];
    let pixel = |direction: [f64; 3]| direction.map(|component| component * plane.pixel_mm());
    let steps = [
        pixel(plane.right().components()),
        pixel(plane.down().components()),
        plane
            .into_screen()
            .components()
            .map(|component| component * THICKNESS_MM),
    ];
    let middle = plane.point((f64::from(width) - 1.0) / 2.0, (f64::from(height) - 1.0) / 2.0);
    Some(Image {
        components: 3,
        ..image(dimensions, steps, middle.mm())
    })
}

/// Why a volume cannot be said in an IMAGE.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub(crate) enum PlaceError {
    /// More voxels than 16 bits count, or more than a message holds.
    #[error(
        "{dims:?} voxels do not fit into an IMAGE: at most 65535 a side and 2147483575 bytes in all; load a part of the examination"
    )]
    TooLarge {
        /// How many there are.
        dims: [u32; 3],
    },
    /// Its axes are no axes that an IMAGE can say; a tilted gantry's volume is sheared.
    #[error(
        "an IMAGE cannot say where these voxels lie: {0}. Receivers would draw them as if they were at right angles"
    )]
    Grid(#[from] igtl::GridError),
}

/// A volume's IMAGE without its voxels, and whether its slices go out from last to first: those of a left-handed grid do, so that the
/// axes are right-handed and every voxel stays at its place.
pub(crate) fn of_grid(grid: &VolumeGrid) -> Result<(Image<'static>, bool), PlaceError> {
    let dims = grid.dims();
    let bytes = grid.voxels().saturating_mul(2);
    let too_large = || PlaceError::TooLarge { dims };
    if bytes > 2_147_483_575 {
        return Err(too_large());
    }
    let mut dimensions = [0; 3];
    for (to, from) in dimensions.iter_mut().zip(dims) {
        *to = u16::try_from(from).map_err(|_| too_large())?;
    }
    let affine = grid.ct_from_voxel();
    let rows = affine.rows();
    let column = |at: usize| rows.map(|row| row[at]);
    let half = dims.map(|n| (f64::from(n) - 1.0) / 2.0);
    let middle = rows.map(|[i, j, k, offset]| i * half[0] + j * half[1] + k * half[2] + offset);
    let is_reversed = affine.determinant() < 0.0;
    let k = column(2).map(|n| if is_reversed { -n } else { n });
    let image = Image {
        scalar: Scalar::Int16,
        ..image(dimensions, [column(0), column(1), k], middle)
    };
    igtl::check_grid(&image, SQUARE_DEGREES)?;
    Ok((image, is_reversed))
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::{Affine, Ct, Direction, Point, Tool, Vector};

    /// Where an IMAGE says that the centre of a voxel lies, LPS.
    fn place(image: &Image<'_>, voxel: [f64; 3]) -> [f64; 3] {
        let [i, j, k] = image.placed.columns;
        let ras = [0, 1, 2].map(|a| {
            image.origin()[a] + f64::from(i[a]) * voxel[0] + f64::from(j[a]) * voxel[1] + f64::from(k[a]) * voxel[2]
        });
        [-ras[0], -ras[1], ras[2]]
    }

    fn off(a: [f64; 3], b: [f64; 3]) -> f64 {
        a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn a_tip_on_the_patients_left_has_a_negative_x_on_the_wire() {
        let pose: Rigid<Ct, Tool> =
            Rigid::from_rotation_vector(Vector::new(0.3, -0.2, 0.9), Vector::new(40.0, 30.0, -7.5)).unwrap();
        let wire = in_ras(&pose);
        assert_eq!(wire.translation, [-40.0, -30.0, -7.5]);
        // A point of the tool, in the tool's frame as a receiver in RAS has it, lies where Trocar has it.
        for mm in [[0.0, 0.0, -180.0], [3.0, -4.0, 5.0]] {
            let lps = (pose * Point::<Tool>::new(mm[0], mm[1], mm[2])).mm();
            let turned = [-mm[0], -mm[1], mm[2]];
            let ras = wire
                .rows()
                .map(|row| f64::from(row[3]) + (0..3).map(|a| f64::from(row[a]) * turned[a]).sum::<f64>());
            // Single precision: 2^-24 of 180 mm, twelve times.
            assert!(off([-ras[0], -ras[1], ras[2]], lps) < 1e-4, "{ras:?} {lps:?}");
        }
        assert!(igtl::rotation::check(&wire.columns, 1e-6).is_ok());
    }

    #[test]
    fn pixels_of_a_slice_lie_where_the_plane_says() {
        let axes = [Direction::X, Direction::Y];
        let plane = SlicePlane::centred(Point::new(12.0, -34.0, 56.0), axes, 0.5, [64, 48]).unwrap();
        let image = of_plane(&plane).unwrap();
        assert_eq!((image.dimensions, image.components), ([64, 48, 1], 3));
        for (x, y) in [(0.0, 0.0), (63.0, 0.0), (0.0, 47.0), (10.0, 20.0)] {
            assert!(off(place(&image, [x, y, 0.0]), plane.point(x, y).mm()) < 1e-4);
        }
        assert!(igtl::check_grid(&image, 0.01).is_ok());
    }

    fn grid(rows: [[f64; 4]; 3]) -> VolumeGrid {
        VolumeGrid::checked([5, 7, 9], Affine::from_rows(rows)).unwrap()
    }

    #[test]
    fn voxels_stay_at_their_places_also_where_the_grid_is_left_handed() {
        for (sign, reversed) in [(1.0, false), (-1.0, true)] {
            let rows = [
                [0.7, 0.0, 0.0, -100.0],
                [0.0, 0.8, 0.0, 20.0],
                [0.0, 0.0, 1.5 * sign, 300.0],
            ];
            let (image, is_reversed) = of_grid(&grid(rows)).unwrap();
            assert_eq!(is_reversed, reversed);
            for [i, j, k] in [[0, 0, 0], [4, 0, 0], [0, 6, 0], [0, 0, 8], [1, 2, 3]] {
                let ct = rows.map(|row| row[0] * f64::from(i) + row[1] * f64::from(j) + row[2] * f64::from(k) + row[3]);
                let sent = if is_reversed { 8 - k } else { k };
                assert!(
                    off(place(&image, [i, j, sent].map(f64::from)), ct) < 1e-4,
                    "{i} {j} {k}"
                );
            }
            assert!(igtl::rotation::deviation(&image.placed.columns).determinant > 0.0);
        }
    }

    #[test]
    fn a_tilted_gantry_is_refused_with_its_angle() {
        let degrees = 12.0_f64;
        let shear = 1.5 * degrees.to_radians().tan();
        let rows = [[0.7, 0.0, 0.0, 0.0], [0.0, 0.7, shear, 0.0], [0.0, 0.0, 1.5, 0.0]];
        let error = of_grid(&grid(rows)).unwrap_err().to_string();
        assert!(
            error.contains("j and k are off a right angle by 12.000 degrees"),
            "{error}"
        );
    }

    #[test]
    fn a_volume_that_is_too_long_for_the_wire_is_refused_with_its_size() {
        let rows = [[0.5, 0.0, 0.0, 0.0], [0.0, 0.5, 0.0, 0.0], [0.0, 0.0, 0.5, 0.0]];
        let long = VolumeGrid::checked([16_384, 8_192, 9], Affine::from_rows(rows));
        let error = of_grid(&long.unwrap()).unwrap_err().to_string();
        assert!(error.contains("[16384, 8192, 9] voxels"), "{error}");
    }
}
