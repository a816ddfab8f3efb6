//! What `calib grid` wrote, as views.
//!
//! Discs that were fitted one by one are taken by the centres of their images, as measured, and their own radii, and the
//! camera predicts where these centres are. In files that do not have them, `x_px` and `y_px` are those centres moved by the
//! shift that the nearest homography gives: that shift is put back, but for large discs, whose radius such a file does not
//! say. Grids fitted as a whole are taken as they are: images of centres.

use nalgebra::{Matrix2, Matrix3, Vector2};
use optics::camera::{ImageSize, Sighting, View};
use optics::disc::Ellipse;
use optics::grid::project;
use serde::Deserialize;

use super::error::CameraError;
use super::name_of;
use crate::input_files::source::Source;

/// Most images and most discs in one: far beyond what `calib grid` writes.
const MAX_IMAGES: usize = 10_000;
const MAX_DISCS: usize = 40_000;

#[derive(Debug, Deserialize)]
struct GridFile {
    pitch_mm: f64,
    images: Vec<ImageRecord>,
}

#[derive(Debug, Deserialize)]
struct ImageRecord {
    path: String,
    width: usize,
    height: usize,
    found: bool,
    refinement: Option<String>,
    px_from_col_row: Option<[[f64; 3]; 3]>,
    radius_pitch: Option<f64>,
    #[serde(default)]
    discs: Vec<DiscRecord>,
}

#[derive(Debug, Clone, Copy, Deserialize)]
struct DiscRecord {
    col: usize,
    row: usize,
    x_mm: f64,
    y_mm: f64,
    x_px: f64,
    y_px: f64,
    covariance_px2: [f64; 3],
    mark: bool,
    measured: Option<MeasuredRecord>,
}

#[derive(Debug, Clone, Copy, Deserialize)]
struct MeasuredRecord {
    x_px: f64,
    y_px: f64,
    radius_mm: f64,
}

/// An image in which the grid was found.
#[derive(Debug, Clone)]
pub(super) struct SeenImage {
    pub(super) path: String,
    pub(super) name: String,
    pub(super) view: View,
    /// Column and row of each disc.
    pub(super) cells: Vec<[usize; 2]>,
    /// Fitted as a whole.
    pub(super) whole: bool,
}

/// All images in which the grid was found.
#[derive(Debug)]
pub(super) struct Seen {
    pub(super) images: Vec<SeenImage>,
    pub(super) size: ImageSize,
    /// Names of those in which it was not.
    pub(super) missing: Vec<String>,
}

/// The files, each with what it holds.
pub(super) struct Grids<'a>(Vec<(&'a Source, GridFile)>);

impl<'a> Grids<'a> {
    /// Parses the files.
    pub(super) fn of(sources: &'a [Source]) -> Result<Self, CameraError> {
        let one = |source: &'a Source| {
            let path = source.path.clone();
            let json = |source| CameraError::Json {
                path: path.clone(),
                source,
            };
            let value: serde_json::Value = serde_json::from_str(&source.text).map_err(json)?;
            let version = value.get("trocar_grid").cloned();
            if version != Some(1.into()) {
                let found = version.map_or_else(|| "nothing".to_owned(), |v| v.to_string().chars().take(40).collect());
                return Err(CameraError::Version { path, found });
            }
            let json = |source| CameraError::Json {
                path: path.clone(),
                source,
            };
            let file: GridFile = serde_json::from_value(value).map_err(json)?;
            Ok((source, file))
        };
        sources.iter().map(one).collect::<Result<_, _>>().map(Self)
    }

    /// The views of all files, which must be of one size.
    pub(super) fn seen(&self) -> Result<Seen, CameraError> {
        let mut seen = Seen {
            images: Vec::new(),
            size: ImageSize { width: 0, height: 0 },
            missing: Vec::new(),
        };
        for (source, file) in &self.0 {
            let bad = |image: &ImageRecord, what: String| CameraError::BadGrid {
                path: source.path.clone(),
                image: name_of(&image.path),
                what,
            };
            for image in &file.images {
                if seen.images.len() + seen.missing.len() >= MAX_IMAGES {
                    return Err(bad(image, format!("more than {MAX_IMAGES} images")));
                }
                if !image.found {
                    seen.missing.push(name_of(&image.path));
                    continue;
                }
                let found = image.seen(file.pitch_mm).map_err(|what| bad(image, what))?;
                seen.add(
                    found,
                    ImageSize {
                        width: image.width,
                        height: image.height,
                    },
                )?;
            }
        }
        Ok(seen)
    }
}

impl Seen {
    fn add(&mut self, image: SeenImage, size: ImageSize) -> Result<(), CameraError> {
        if let Some(first) = self.images.first().filter(|_| size != self.size) {
            return Err(CameraError::Sizes {
                first: first.name.clone(),
                second: image.name,
                sizes: [self.size, size].map(|s| [s.width, s.height]),
            });
        }
        self.size = size;
        self.images.push(image);
        Ok(())
    }
}

impl ImageRecord {
    fn seen(&self, pitch_mm: f64) -> Result<SeenImage, String> {
        if self.discs.len() > MAX_DISCS {
            return Err(format!("{} discs; at most {MAX_DISCS} are taken", self.discs.len()));
        }
        let whole = match self.refinement.as_deref() {
            Some("whole") => true,
            Some("each") => false,
            // Fifteen numbers that all discs share, eight of a plane and seven of a lens that is none of the camera's models:
            // no camera is to be had from them, with or without a lens.
            Some("lens") => {
                return Err(
                    "the grid was fitted behind a lens of its own, so that its discs lie where that has them and \
                            say nothing of their own. Run calib grid with --one-by-one"
                        .to_owned(),
                );
            }
            other => {
                return Err(format!(
                    "refinement is {other:?}, expected \"whole\", \"lens\" or \"each\""
                ));
            }
        };
        let rows = self.px_from_col_row.ok_or("px_from_col_row is missing")?;
        let radius = self.radius_pitch.ok_or("radius_pitch is missing")?;
        let numbers = [pitch_mm, radius];
        if !numbers.iter().all(|x| x.is_finite() && *x > 0.0) || !rows.as_flattened().iter().all(|x| x.is_finite()) {
            return Err(format!(
                "pitch_mm {pitch_mm}, radius_pitch {radius} and px_from_col_row must be finite, the first two above 0"
            ));
        }
        let h = Matrix3::from_fn(|i, j| rows[i][j]);
        // A whole grid holds eight numbers: independent discs of this deviation would hold the same.
        let spread = self
            .discs
            .iter()
            .map(|d| d.covariance_px2[0] + d.covariance_px2[2])
            .sum::<f64>()
            / 8.0;
        let shared = whole.then(|| Matrix2::identity() * spread);
        let one = |d: &DiscRecord| d.sighting(&h, radius, pitch_mm, shared);
        Ok(SeenImage {
            path: self.path.clone(),
            name: name_of(&self.path),
            view: View {
                sightings: self.discs.iter().map(one).collect(),
            },
            cells: self.discs.iter().map(|d| [d.col, d.row]).collect(),
            whole,
        })
    }
}

impl DiscRecord {
    fn sighting(&self, h: &Matrix3<f64>, radius: f64, pitch_mm: f64, shared: Option<Matrix2<f64>>) -> Sighting {
        let [a, b, c] = self.covariance_px2;
        let own = Matrix2::new(a, b, b, c);
        if let Some(measured) = self.measured.filter(|_| shared.is_none()) {
            return Sighting {
                at_mm: Vector2::new(self.x_mm, self.y_mm),
                pixel: Vector2::new(measured.x_px, measured.y_px),
                covariance: own,
                radius_mm: Some(measured.radius_mm),
            };
        }
        let cell = Vector2::new(self.col as f64, self.row as f64);
        let shift = || Ellipse::of_circle(h, cell, radius).map(|e| e.centre - project(h, cell));
        let shift = shift().filter(|_| shared.is_none() && !self.mark);
        Sighting {
            at_mm: Vector2::new(self.x_mm, self.y_mm),
            pixel: Vector2::new(self.x_px, self.y_px) + shift.unwrap_or_default(),
            covariance: shared.unwrap_or(own),
            radius_mm: shift.map(|_| radius * pitch_mm),
        }
    }
}
