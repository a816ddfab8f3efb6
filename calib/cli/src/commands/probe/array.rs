//! Where the beams of an array run in a picture.

use exchange::plus::{ScanArray, ScanConversion};
use serde::{Deserialize, Serialize};
use ultrasound::{Beams, Shape};

/// Beams lie elsewhere in a picture that differs by more than this share of its longer side, and by more than so many pixels.
const MOVED: [f64; 2] = [0.005, 3.0];
/// Of radii, and of angles in degrees: what scanners round is less.
const OTHER_RADIUS: f64 = 0.02;
const OTHER_ANGLE_DEG: f64 = 1.0;

/// Where beams run in a picture, pixels: whole numbers are centres of pixels, u to the right, v down.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
pub enum ArrayRecord {
    /// Beams run down, side by side.
    Linear {
        /// The first beam's column.
        from_px: f64,
        /// The last one's.
        to_px: f64,
        /// The row of the face.
        face_px: f64,
    },
    /// Beams come from one centre.
    Curved {
        /// Column and row of the centre of the face's curve; it may lie above the picture.
        centre_px: [f64; 2],
        /// The face's radius, in rows.
        radius_px: f64,
        /// From the first beam to the last, degrees.
        angle_deg: f64,
    },
}

impl ArrayRecord {
    /// `linear` or `curved`.
    pub(super) fn kind(&self) -> &'static str {
        match self {
            Self::Linear { .. } => "linear",
            Self::Curved { .. } => "curved",
        }
    }

    /// The column about which the beams lie alike to both sides.
    pub(crate) fn middle_px(&self) -> f64 {
        match self {
            Self::Linear { from_px, to_px, .. } => 0.5 * (from_px + to_px),
            Self::Curved {
                centre_px: [column, _], ..
            } => *column,
        }
    }

    /// That of an image.
    pub(crate) fn of(shape: &Shape) -> Self {
        let [u, v] = shape.pixel_mm();
        match shape.beams() {
            Beams::Linear {
                from_mm,
                to_mm,
                face_mm,
            } => Self::Linear {
                from_px: from_mm / u,
                to_px: to_mm / u,
                face_px: face_mm / v,
            },
            Beams::Convex {
                centre_mm: [x, y],
                radius_mm,
                half_angle,
            } => Self::Curved {
                centre_px: [x / u, y / v],
                radius_px: radius_mm / v,
                angle_deg: 2.0 * half_angle.to_degrees(),
            },
        }
    }

    /// Of a device set of PLUS: its centre is the middle of the face.
    pub(super) fn scanned(scan: &ScanConversion) -> Self {
        let ([u, v], [column, row]) = (scan.pixel_mm, scan.centre_px);
        match scan.array {
            ScanArray::Linear { width_mm } => Self::Linear {
                from_px: column - width_mm / (2.0 * u),
                to_px: column + width_mm / (2.0 * u),
                face_px: row,
            },
            ScanArray::Curvilinear { radius_mm, theta_deg } => Self::Curved {
                centre_px: [column, row - radius_mm / v],
                radius_px: radius_mm / v,
                angle_deg: theta_deg[1] - theta_deg[0],
            },
        }
    }

    /// The same in mm of the image's plane.
    pub(crate) fn beams(&self, [u, v]: [f64; 2]) -> Beams {
        match *self {
            Self::Linear {
                from_px,
                to_px,
                face_px,
            } => Beams::Linear {
                from_mm: from_px * u,
                to_mm: to_px * u,
                face_mm: face_px * v,
            },
            Self::Curved {
                centre_px: [x, y],
                radius_px,
                angle_deg,
            } => Beams::Convex {
                centre_mm: [x * u, y * v],
                radius_mm: radius_px * v,
                half_angle: (angle_deg / 2.0).to_radians(),
            },
        }
    }

    /// The pixel of the same beam at so many times the depth. Pixels are taken for square.
    pub(crate) fn at_depth(&self, [u, v]: [f64; 2], times: f64) -> [f64; 2] {
        match *self {
            Self::Linear { face_px, .. } => [u, face_px + (v - face_px) * times],
            Self::Curved {
                centre_px: [a, b],
                radius_px,
                ..
            } => {
                let (x, y) = (u - a, v - b);
                let from_centre = x.hypot(y);
                if from_centre == 0.0 {
                    return [u, v];
                }
                let grown = (radius_px + (from_centre - radius_px) * times) / from_centre;
                [a + x * grown, b + y * grown]
            }
        }
    }

    /// How many rows of a picture of so many lie below the face.
    pub(crate) fn shown_rows(&self, rows: usize) -> f64 {
        let face = match *self {
            Self::Linear { face_px, .. } => face_px,
            Self::Curved {
                centre_px: [_, v],
                radius_px,
                ..
            } => v + radius_px,
        };
        rows as f64 - 1.0 - face
    }

    /// Whether beams run elsewhere than in another picture of this longer side, pixels.
    pub(super) fn is_other(&self, other: &Self, side_px: f64) -> bool {
        let near = |a: f64, b: f64| (a - b).abs() <= (MOVED[0] * side_px).max(MOVED[1]);
        let like = |a: f64, b: f64| (a / b - 1.0).abs() <= OTHER_RADIUS;
        let same = match (self, other) {
            (
                Self::Linear {
                    from_px: a,
                    to_px: b,
                    face_px: c,
                },
                Self::Linear {
                    from_px,
                    to_px,
                    face_px,
                },
            ) => near(*a, *from_px) && near(*b, *to_px) && near(*c, *face_px),
            (
                Self::Curved {
                    centre_px: [a, b],
                    radius_px: r,
                    angle_deg: w,
                },
                Self::Curved {
                    centre_px: [u, v],
                    radius_px,
                    angle_deg,
                },
            ) => {
                // The face is what is seen; its centre lies far above, where a radius that is a little off moves it.
                near(*a, *u)
                    && near(b + r, v + radius_px)
                    && like(*r, *radius_px)
                    && (w - angle_deg).abs() <= OTHER_ANGLE_DEG
            }
            _ => false,
        };
        !same
    }
}

impl std::fmt::Display for ArrayRecord {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Linear {
                from_px,
                to_px,
                face_px,
            } => write!(
                f,
                "a linear array, beams in columns {from_px:.1} to {to_px:.1}, face in row {face_px:.1}"
            ),
            Self::Curved {
                centre_px: [u, v],
                radius_px,
                angle_deg,
            } => write!(
                f,
                "a curved array, centre ({u:.1}, {v:.1}), radius {radius_px:.1} rows, {angle_deg:.1} degrees"
            ),
        }
    }
}
