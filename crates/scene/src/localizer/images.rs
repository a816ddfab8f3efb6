//! Ultrasound images of the localizer's peer: `[localizer.images]`.

use std::time::Duration;

use serde::{Deserialize, Serialize};

use super::super::values::{Checked, invalid, number};
use super::label;

/// The widest image's side, mm.
const FAR_MM: f64 = 1e3;

/// `[localizer.images]`: what no message says of its images.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawImages {
    /// What the peer calls them.
    pub name: String,
    /// How rows and columns run, in the words of PLUS (`UltrasoundImageOrientation`): `MF` for rows towards the marked side, columns away
    /// from the probe.
    pub orientation: String,
    /// Sizes of a pixel along a row and along a column, mm; absent: those that messages tell.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pixel_mm: Option<[f64; 2]>,
    /// How far beams are shown from the probe's face, mm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub depth_mm: Option<f64>,
    /// A linear array: first and last beam along a row, and the face's row, mm from the centre of the first pixel.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub linear_mm: Option<[f64; 3]>,
    /// A curved array.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub convex: Option<RawConvex>,
    /// How much later than a pose of its stamp an image may come, ms; absent: [`RawImages::LATEST_MS`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub latest_ms: Option<f64>,
}

impl RawImages {
    /// What a scanner takes for an image (tens of ms, 200 at most), 25 ms for 640 x 480 bytes over 100 Mbit/s, and as much again
    /// for a network that is busy.
    pub const LATEST_MS: f64 = 300.0;
}

/// `[localizer.images.convex]`
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawConvex {
    /// The centre of the face's curve, mm from the centre of the first pixel; it may lie above the image.
    pub centre_mm: [f64; 2],
    /// The radius of the face, mm.
    pub radius_mm: f64,
    /// How far the outermost beams lean to each side from straight down, degrees.
    pub half_angle_deg: f64,
}

/// The images, checked.
#[derive(Debug, Clone, PartialEq)]
pub struct ImagesSpec {
    /// What the peer calls them.
    pub name: String,
    /// How rows and columns run: 2 or 3 of PLUS's letters.
    pub orientation: String,
    /// Sizes of a pixel, mm; `None`: those that messages tell.
    pub pixel_mm: Option<[f64; 2]>,
    /// How far beams are shown, mm, and where they run; `None`: nobody says.
    pub shown: Option<(f64, ShownBeams)>,
    /// How much later than a pose of its stamp an image may come: what is later is of another clock, or old. An offset of the two clocks
    /// that is below it is not seen.
    pub latest: Duration,
}

/// Where beams run, mm of the image's plane from the centre of its first pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ShownBeams {
    /// Side by side, down.
    Linear {
        /// The first beam along a row.
        from_mm: f64,
        /// The last one.
        to_mm: f64,
        /// The row of the face.
        face_mm: f64,
    },
    /// From one centre.
    Convex {
        /// Of the face's curve.
        centre_mm: [f64; 2],
        /// Of the face.
        radius_mm: f64,
        /// Of the outermost beams from straight down, rad.
        half_angle_rad: f64,
    },
}

pub(super) fn images(raw: &RawImages) -> Checked<ImagesSpec> {
    let pixel = |mm| number("localizer.images.pixel_mm", mm, 0.005..=2.0, "mm");
    let pixel_mm = match raw.pixel_mm {
        Some([along, down]) => Some([pixel(along)?, pixel(down)?]),
        None => None,
    };
    let (orientation, shown) = (orientation(&raw.orientation)?, shown(raw)?);
    // Where beams run is told of rows from the face down.
    if shown.is_some() && !(orientation.starts_with(['M', 'U']) && orientation[1..].starts_with('F')) {
        let allowed = "\"MF\" or \"UF\" where it is told where beams run: rows along the face, columns away from it";
        return Err(invalid(
            "localizer.images.orientation",
            format!("{orientation:?}"),
            allowed,
        ));
    }
    let latest_ms = raw.latest_ms.unwrap_or(RawImages::LATEST_MS);
    Ok(ImagesSpec {
        name: label("localizer.images.name", &raw.name)?,
        orientation,
        pixel_mm,
        shown,
        latest: Duration::from_secs_f64(number("localizer.images.latest_ms", latest_ms, 10.0..=2000.0, "ms")? / 1e3),
    })
}

/// A letter of each axis of the image: what is far from what is near, the marked side from the other, ascending from descending.
fn orientation(text: &str) -> Checked<String> {
    let axis = |letter: char| ["MU", "FN", "AD"].iter().position(|axis| axis.contains(letter));
    let axes: Vec<_> = text.chars().map(axis).collect();
    let is_each_once = axes.iter().enumerate().all(|(k, axis)| !axes[..k].contains(axis));
    match matches!(axes.len(), 2 | 3) && is_each_once && !axes.contains(&None) {
        true => Ok(text.to_owned()),
        false => Err(invalid(
            "localizer.images.orientation",
            format!("{text:?}"),
            "2 or 3 letters as PLUS has them, one each of M or U (marked side), F or N (far), A or D: \"MF\"",
        )),
    }
}

/// Depth and array, or neither.
fn shown(raw: &RawImages) -> Checked<Option<(f64, ShownBeams)>> {
    let (depth_mm, beams) = match (raw.depth_mm, raw.linear_mm, &raw.convex) {
        (None, None, None) => return Ok(None),
        (Some(depth_mm), Some([from_mm, to_mm, face_mm]), None) => {
            let key = "localizer.images.linear_mm";
            number(key, to_mm - from_mm, 1.0..=FAR_MM, "mm from the first beam to the last")?;
            for mm in [from_mm, face_mm] {
                number(key, mm, -FAR_MM..=FAR_MM, "mm")?;
            }
            let beams = ShownBeams::Linear {
                from_mm,
                to_mm,
                face_mm,
            };
            (depth_mm, beams)
        }
        (Some(depth_mm), None, Some(convex)) => (depth_mm, curved(convex)?),
        (_, Some(_), Some(_)) => {
            let allowed = "linear_mm or convex, and not both";
            return Err(invalid("localizer.images", "two arrays", allowed));
        }
        _ => {
            let allowed = "depth_mm with linear_mm or convex, or none of them";
            return Err(invalid(
                "localizer.images",
                "half of what says where beams run",
                allowed,
            ));
        }
    };
    let depth_mm = number("localizer.images.depth_mm", depth_mm, 1.0..=400.0, "mm")?;
    Ok(Some((depth_mm, beams)))
}

fn curved(raw: &RawConvex) -> Checked<ShownBeams> {
    for mm in raw.centre_mm {
        number("localizer.images.convex.centre_mm", mm, -FAR_MM..=FAR_MM, "mm")?;
    }
    let (radius, angle) = (
        "localizer.images.convex.radius_mm",
        "localizer.images.convex.half_angle_deg",
    );
    Ok(ShownBeams::Convex {
        centre_mm: raw.centre_mm,
        radius_mm: number(radius, raw.radius_mm, 1.0..=200.0, "mm")?,
        half_angle_rad: number(angle, raw.half_angle_deg, 1.0..=88.0, "degrees")?.to_radians(),
    })
}
