//! The image in the probe's marker as PLUS writes it: a matrix that takes pixels to mm.

use std::path::Path;

use exchange::plus;
use geometry::rotation::RotationMatrix;
use geometry::{Image, Marker, Rigid, Vector};
use nalgebra::Vector3;

use super::super::error::SurfaceCommandError;
use crate::input_files::source::Source;

/// The cosine between a matrix's columns from which on it is no image: half a degree.
const SHEARED: f64 = 0.01;
/// Sizes of a pixel, mm: others are metres, or no image's.
const PIXEL_MM: std::ops::RangeInclusive<f64> = 0.005..=2.0;

/// The image in the marker, mm from its first pixel, and the size of a pixel.
pub(super) type Placed = (Rigid<Marker, Image>, [f64; 2]);

/// Reads 16 numbers by rows, a file of them, or a device set with the transform from `Image` to `marker`.
pub(super) fn read(given: &str, marker: &str) -> Result<Placed, SurfaceCommandError> {
    let wrong = |what: String| SurfaceCommandError::Matrix {
        given: given.chars().take(80).collect(),
        what,
    };
    if let Some(rows) = numbers(given) {
        return placed(&rows).map_err(wrong);
    }
    let source = Source::read_whole(Path::new(given)).map_err(|error| wrong(error.to_string()))?;
    if let Some(rows) = numbers(&source.text) {
        return placed(&rows).map_err(wrong);
    }
    let set = plus::read(source.text.as_bytes())
        .map_err(|error| wrong(format!("16 numbers by rows or a device set of PLUS are read; {error}")))?;
    let mut those = set
        .definitions
        .iter()
        .filter(|one| one.from == "Image" && one.to == marker);
    match (those.next(), those.next()) {
        (Some(one), None) => placed(&one.rows).map_err(wrong),
        (Some(_), Some(_)) => Err(wrong(format!(
            "the device set has a transform from Image to {marker} twice"
        ))),
        (None, _) => Err(wrong(format!(
            "the device set has no transform from Image to {marker}, the marker of --transform"
        ))),
    }
}

/// 16 numbers apart from one another by blanks or commas.
fn numbers(text: &str) -> Option<[[f64; 4]; 4]> {
    let words = text
        .split(|c: char| c.is_ascii_whitespace() || c == ',')
        .filter(|word| !word.is_empty());
    let all: Option<Vec<f64>> = words.take(17).map(|word| word.parse().ok()).collect();
    let all: [f64; 16] = all?.try_into().ok()?;
    Some([0, 4, 8, 12].map(|i| [all[i], all[i + 1], all[i + 2], all[i + 3]]))
}

/// A matrix whose first two columns are a pixel's steps along a row and along a column, and its last the first pixel.
fn placed(rows: &[[f64; 4]; 4]) -> Result<Placed, String> {
    if !rows.iter().flatten().all(|x| x.is_finite()) || rows[3] != [0.0, 0.0, 0.0, 1.0] {
        return Err("16 finite numbers by rows are needed, the last of them 0 0 0 1".to_owned());
    }
    let column = |j: usize| Vector3::new(rows[0][j], rows[1][j], rows[2][j]);
    let pixel_mm = [column(0).norm(), column(1).norm()];
    if !pixel_mm.iter().all(|mm| PIXEL_MM.contains(mm)) {
        return Err(format!(
            "pixels of {:.5} x {:.5} mm; 0.005 to 2 mm are allowed: are these metres, or a matrix without the pixels' size?",
            pixel_mm[0], pixel_mm[1]
        ));
    }
    let (u, v) = (column(0) / pixel_mm[0], column(1) / pixel_mm[1]);
    if u.dot(&v).abs() > SHEARED {
        return Err(format!(
            "rows and columns are {:.2} degrees apart; 90 are expected",
            u.dot(&v).clamp(-1.0, 1.0).acos().to_degrees()
        ));
    }
    // What is left of the shear is shared by both.
    let unit = |axis: Vector3<f64>| axis.try_normalize(1e-6).ok_or("rows and columns are one direction");
    let (sum, difference) = (unit(u + v)?, unit(u - v)?);
    let half = 0.5_f64.sqrt();
    let (u, v) = ((sum + difference) * half, (sum - difference) * half);
    let w = u.cross(&v);
    if column(2).dot(&w) < 0.0 {
        return Err(
            "its third column is on the other side of the image than its first two say: a mirrored image".to_owned(),
        );
    }
    let rows_of = [0, 1, 2].map(|i| [u[i], v[i], w[i]]);
    let rotation = RotationMatrix::new(rows_of, 1e-9).map_err(|error| error.to_string())?;
    let [x, y, z] = column(3).into();
    let far = [x, y, z].into_iter().any(|mm: f64| mm.abs() > 1e4);
    if far {
        return Err("the first pixel is more than 10 m from the marker".to_owned());
    }
    Ok((Rigid::from_parts(rotation.rotation(), Vector::new(x, y, z)), pixel_mm))
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::Point;

    /// Of PLUS's recording of a bone.
    const PLUS: &str = "0.000796231 0.0854272 0.000850194 12.74 -0.0853999 0.000772721 0.00233653 50.76 \
                        0.00232863 -0.000871617 0.0853992 -0.5 0 0 0 1";

    #[test]
    fn a_pixel_goes_where_the_matrix_takes_it() {
        let (image, [u, v]) = read(PLUS, "Probe").unwrap();
        for px in [[0.0, 0.0], [820.0, 0.0], [0.0, 616.0], [410.0, 300.0]] {
            let [x, y, z] = (image * Point::new(px[0] * u, px[1] * v, 0.0)).mm();
            let n: Vec<f64> = PLUS
                .split_ascii_whitespace()
                .map(|word| word.parse().unwrap())
                .collect();
            let by = |i: usize| n[4 * i] * px[0] + n[4 * i + 1] * px[1] + n[4 * i + 3];
            // Six digits of 0.085 mm over 820 pixels, and what is left of the shear.
            assert!((x - by(0)).hypot(y - by(1)).hypot(z - by(2)) < 2e-3, "{px:?}");
        }
        let set = format!(
            "<PlusConfiguration><CoordinateDefinitions><Transform From=\"Image\" To=\"Probe\" Matrix=\"{PLUS}\"/>\
             </CoordinateDefinitions></PlusConfiguration>"
        );
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("set.xml");
        std::fs::write(&path, set).unwrap();
        let path = path.to_str().unwrap();
        assert_eq!(read(path, "Probe").unwrap().1, [u, v]);
        let words = read(path, "Needle").unwrap_err().to_string();
        assert!(words.contains("no transform from Image to Needle"), "{words}");
        let words = read("/no/such", "Probe").unwrap_err().to_string();
        assert!(words.contains("--image-to-probe /no/such"), "{words}");
    }

    #[test]
    fn what_is_no_image_in_a_marker_is_refused_by_name() {
        for (matrix, words) in [
            ("1e-4 0 0 0 0 1e-4 0 0 0 0 1e-4 0 0 0 0 1", "metres"),
            ("0.1 0.01 0 0 0 0.1 0 0 0 0 0.1 0 0 0 0 1", "degrees apart"),
            ("0.1 0 0 0 0 0.1 0 0 0 0 -0.1 0 0 0 0 1", "a mirrored image"),
            ("0.1 0 0 0 0 0.1 0 0 0 0 0.1 0 0 0 1 1", "the last of them 0 0 0 1"),
            ("0.1 0 0 nan 0 0.1 0 0 0 0 0.1 0 0 0 0 1", "16 finite numbers"),
            ("0.1 0 0 1e5 0 0.1 0 0 0 0 0.1 0 0 0 0 1", "10 m"),
        ] {
            let error = read(matrix, "Probe").unwrap_err().to_string();
            assert!(error.contains(words), "{matrix}: {error}");
        }
    }
}
