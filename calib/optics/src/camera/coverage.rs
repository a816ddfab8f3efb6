//! Whether the views say enough of the camera: how far the grid was tilted, and how much of the image it filled.

use std::fmt;

use nalgebra::{Vector2, Vector3};

use super::view::ImageSize;

/// Columns and rows of the cells in which discs are counted.
pub const CELLS: [usize; 2] = [8, 6];

/// What the views cover.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coverage {
    /// The largest difference of the grid's tilt between two views about the image's x and y axes, radians.
    pub tilt_rad: [f64; 2],
    /// The share of the 8 x 6 cells of the image in which a disc was seen.
    pub image: f64,
    /// Discs in each third of the image, by rows from the upper left.
    pub thirds: [[usize; 3]; 3],
}

impl Coverage {
    /// Of the planes' normals in the camera's frame and the pixels of all discs.
    pub(super) fn of(normals: &[Vector3<f64>], pixels: &[Vector2<f64>], size: ImageSize) -> Self {
        let range = |angle: &dyn Fn(&Vector3<f64>) -> f64| {
            let angles = normals.iter().map(angle);
            let [low, high] = angles.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], x| [a.min(x), b.max(x)]);
            (high - low).max(0.0)
        };
        let sides = [size.width, size.height];
        let cell = |p: &Vector2<f64>, n: [usize; 2]| {
            [0, 1].map(|k| (((p[k] + 0.5) / sides[k] as f64 * n[k] as f64).max(0.0) as usize).min(n[k] - 1))
        };
        let mut seen = [[false; CELLS[0]]; CELLS[1]];
        let mut thirds = [[0; 3]; 3];
        for p in pixels {
            let [i, j] = cell(p, CELLS);
            seen[j][i] = true;
            let [i, j] = cell(p, [3, 3]);
            thirds[j][i] += 1;
        }
        let filled = seen.iter().flatten().filter(|s| **s).count();
        Self {
            tilt_rad: [range(&|n| n.y.atan2(n.z)), range(&|n| n.x.atan2(n.z))],
            image: filled as f64 / (CELLS[0] * CELLS[1]) as f64,
            thirds,
        }
    }
}

/// What is asked of a calibration; `None` is not asked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gates {
    /// Root mean square residual, pixels, at most.
    pub max_rms_px: Option<f64>,
    /// Residuals, and what views say of the camera, in units of the deviations given ([`super::Calibrated::noise_ratio`],
    /// [`super::Calibrated::view_ratio`]), at most.
    pub max_noise_ratio: Option<f64>,
    /// Difference of tilt between two views about each axis of the image, radians, at least.
    pub min_tilt_rad: Option<f64>,
    /// Share of the image's cells with discs, at least.
    pub min_image: Option<f64>,
}

impl Default for Gates {
    /// A noise ratio of 3, 20 degrees about either axis, and half of the image.
    fn default() -> Self {
        Self {
            max_rms_px: None,
            max_noise_ratio: Some(3.0),
            min_tilt_rad: Some(20.0_f64.to_radians()),
            min_image: Some(0.5),
        }
    }
}

/// What falls short, and what to do. Its text is a sentence without a full stop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Short {
    /// The discs are too far from where the camera sees them.
    Residuals {
        /// Root mean square, pixels.
        rms_px: f64,
        /// The most accepted.
        limit_px: f64,
    },
    /// The discs are further from where the camera sees them than their deviations allow: something is not as it was taken
    /// to be, and the camera's deviations, which grow with the residuals, know nothing of that.
    Noise {
        /// Residuals in units of the deviations given.
        ratio: f64,
        /// The most accepted.
        limit: f64,
    },
    /// The views say different things of the camera, however small the residuals are.
    Views {
        /// How different, in units of the deviations given.
        ratio: f64,
        /// The most accepted.
        limit: f64,
    },
    /// The grid was not tilted enough.
    Tilt {
        /// The image's axis: 0 for x.
        axis: usize,
        /// The largest difference, radians.
        found_rad: f64,
        /// The least accepted.
        needed_rad: f64,
    },
    /// Discs were seen in too little of the image.
    Image {
        /// The share.
        found: f64,
        /// The least accepted.
        needed: f64,
        /// Row and column of the third with the fewest discs.
        poorest: [usize; 2],
    },
}

impl fmt::Display for Short {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Residuals { rms_px, limit_px } => write!(
                f,
                "the residuals are {rms_px:.3} px RMS, at most {limit_px} are accepted: look for discs found wrong, a \
                 grid that is not flat, or a lens that needs more coefficients"
            ),
            Self::Noise { ratio, limit } => write!(
                f,
                "the residuals are {ratio:.1} times the discs' stated deviations, at most {limit} is accepted: pictures of two \
                 cameras mixed, a focus or zoom moved between pictures, a lens that needs other coefficients, or a grid that \
                 is not flat"
            ),
            Self::Views { ratio, limit } => write!(
                f,
                "what the views say of focal lengths and principal point differs by {ratio:.1} times its stated deviations, at \
                 most {limit} is accepted: pictures of two cameras mixed, a focus or zoom moved between pictures, or a lens \
                 or grid that is not as was taken"
            ),
            Self::Tilt {
                axis,
                found_rad,
                needed_rad,
            } => write!(
                f,
                "tilt the grid more about the image's {} axis: the views differ by {:.1} degrees, {:.0} are needed",
                ["x", "y"][axis.min(1)],
                found_rad.to_degrees(),
                needed_rad.to_degrees()
            ),
            Self::Image {
                found,
                needed,
                poorest: [row, column],
            } => {
                let row = ["upper", "middle", "lower"][row.min(2)];
                let column = ["left", "middle", "right"][column.min(2)];
                write!(
                    f,
                    "bring the grid to the {row} {column} of the image: discs were seen in {:.0} % of it, {:.0} % are \
                     needed",
                    found * 100.0,
                    needed * 100.0
                )
            }
        }
    }
}

impl Gates {
    /// Everything that falls short; a value equal to its limit is accepted, a NaN is not.
    /// The last are [`super::Calibrated::noise_ratio`] and [`super::Calibrated::view_ratio`].
    pub fn judge(&self, coverage: &Coverage, rms_px: f64, [noise_ratio, view_ratio]: [f64; 2]) -> Vec<Short> {
        let mut short = Vec::new();
        // A comparison with NaN is false, so that what is not known falls short.
        let kept = |found: f64, limit: f64| found <= limit;
        if let Some(limit_px) = self.max_rms_px.filter(|limit| !kept(rms_px, *limit)) {
            short.push(Short::Residuals { rms_px, limit_px });
        }
        if let Some(limit) = self.max_noise_ratio.filter(|limit| !kept(noise_ratio, *limit)) {
            let ratio = noise_ratio;
            short.push(Short::Noise { ratio, limit });
        // One of both is enough: views that disagree make the residuals large, too.
        } else if let Some(limit) = self.max_noise_ratio.filter(|limit| !kept(view_ratio, *limit)) {
            let ratio = view_ratio;
            short.push(Short::Views { ratio, limit });
        }
        for (axis, found_rad) in coverage.tilt_rad.into_iter().enumerate() {
            if let Some(needed_rad) = self.min_tilt_rad.filter(|needed| !kept(*needed, found_rad)) {
                short.push(Short::Tilt {
                    axis,
                    found_rad,
                    needed_rad,
                });
            }
        }
        let found = coverage.image;
        if let Some(needed) = self.min_image.filter(|needed| !kept(*needed, found)) {
            let places = (0..3).flat_map(|row| (0..3).map(move |column| [row, column]));
            let poorest = places.min_by_key(|[row, column]| coverage.thirds[*row][*column]);
            let poorest = poorest.unwrap_or_default();
            short.push(Short::Image { found, needed, poorest });
        }
        short
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_missing_is_said_with_what_to_do() {
        let size = ImageSize {
            width: 800,
            height: 600,
        };
        let normals = [Vector3::new(0.0, 0.0, 1.0), Vector3::new(0.6, 0.1, 0.8)];
        let pixels = [
            Vector2::new(10.0, 10.0),
            Vector2::new(790.0, 590.0),
            Vector2::new(400.0, 300.0),
        ];
        let coverage = Coverage::of(&normals, &pixels, size);
        assert_eq!(coverage.image, 3.0 / 48.0);
        assert!((coverage.tilt_rad[1] - 0.6_f64.atan2(0.8)).abs() < 1e-15);
        let short = Gates {
            max_rms_px: Some(0.3),
            ..Gates::default()
        }
        .judge(&coverage, 0.31, [3.0; 2]);
        let texts: Vec<String> = short.iter().map(Short::to_string).collect();
        assert!(texts[0].contains("0.310 px RMS"), "{texts:?}");
        assert!(
            texts[1].contains("tilt the grid more about the image's x axis: the views differ by 7.1"),
            "{texts:?}"
        );
        assert!(
            texts[2].contains("upper middle") && texts[2].contains("6 % of it, 50 %"),
            "{texts:?}"
        );
        assert_eq!(texts.len(), 3);
        let none = Gates {
            max_rms_px: None,
            max_noise_ratio: None,
            min_tilt_rad: None,
            min_image: None,
        };
        assert!(none.judge(&coverage, f64::NAN, [f64::NAN; 2]).is_empty());
        let nan = Gates {
            max_rms_px: Some(1.0),
            max_noise_ratio: Some(3.0),
            ..none
        };
        assert_eq!(nan.judge(&coverage, f64::NAN, [f64::NAN; 2]).len(), 2);
        let noise = nan.judge(&coverage, 0.5, [19.7; 2]);
        assert_eq!(
            noise,
            [Short::Noise {
                ratio: 19.7,
                limit: 3.0
            }]
        );
        let views = nan.judge(&coverage, 0.5, [1.1, 3.1]);
        assert_eq!(views, [Short::Views { ratio: 3.1, limit: 3.0 }]);
        assert!(
            noise[0]
                .to_string()
                .contains("19.7 times the discs' stated deviations, at most 3 is")
        );
    }
}
