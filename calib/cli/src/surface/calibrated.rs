//! The calibration of an ultrasound probe, as points of bone need it: what it says of the image, and whether it is of these images
//! and of this tool.

#[cfg(test)]
pub(super) mod tests;

use std::path::{Path, PathBuf};

use geometry::{Image, Marker, Rigid, Uncertain, Vector};
use ultrasound::Shape;

use super::error::SurfaceCommandError;
use super::points::Shared;
use crate::commands::probe::{ImagesRecord, ProbeFile, celsius_of};
use crate::input_files::source::comments;

/// An image of pixels that differ by more than this share from those of the calibration was made at another depth.
const OTHER_PIXELS: f64 = 0.02;
/// A comment of a file of points that a probe saw, the second, begins so; its calibration's id follows, and what nothing compared.
const BY_PROBE: &str = "# by the probe's calibration ";
/// What a comment that is meant to be that one begins with, behind its `#`.
const MEANT: &str = "by the probe";
/// In the place of an id where the calibration was a matrix.
const BY_MATRIX: &str = "none, a matrix";
const UNCHECKED: &str = "; not compared: ";

/// Refuses points that a calibrated probe saw where its calibration is not given: without it their errors are told too small, and nothing
/// is held against a mirrored picture.
pub(super) fn without_probe(points: &Path, text: &str) -> Result<(), SurfaceCommandError> {
    let mut ids = said(text).map(|said| said.split_once(UNCHECKED).map_or(said, |(id, _)| id));
    match ids.find(|id| *id != BY_MATRIX) {
        None => Ok(()),
        Some(found) => Err(SurfaceCommandError::NeedsProbe {
            points: points.to_owned(),
            found: found.chars().take(64).collect(),
        }),
    }
}

/// What the comments of a file of points say of the probe's calibration: one that says it in another way is told whole, and by that is the
/// id of none.
fn said(text: &str) -> impl Iterator<Item = &str> {
    let meant = comments(text).filter(|(_, line)| line[1..].trim_start().starts_with(MEANT));
    meant.map(|(_, line)| line.strip_prefix(BY_PROBE).unwrap_or(line))
}

/// A probe's calibration.
pub(super) struct Calibrated {
    path: PathBuf,
    /// Of the file's content.
    id: String,
    pub(super) marker_from_image: Uncertain<Marker, Image>,
    pub(super) pixel_mm: [f64; 2],
    /// To be added to an image's stamp to find the pose that goes with it, and its deviation, s.
    pub(super) lag_s: [f64; 2],
    images: ImagesRecord,
    /// The temperature of the water that it was calibrated in, where that was told.
    water_celsius: Option<f64>,
}

impl Calibrated {
    /// Reads a calibration; `lag_s` (the lag and its deviation) stands in the place of the file's.
    pub(super) fn read(path: &Path, lag_s: Option<[f64; 2]>) -> Result<Self, SurfaceCommandError> {
        let file = ProbeFile::read(path).map_err(|source| SurfaceCommandError::Probe(Box::new(source)))?;
        let none = || SurfaceCommandError::NoCovariance {
            of: format!("the probe {}", path.display()),
        };
        let found = file.probe_from_image().ok_or_else(none)?;
        // The tool's marker of a run is the one on the probe.
        let [x, y, z] = found.transform().translation_mm();
        let rigid = Rigid::from_parts(found.transform().rotation(), Vector::new(x, y, z));
        Ok(Self {
            path: path.to_owned(),
            marker_from_image: Uncertain::from_upper(rigid, found.upper()).map_err(|_| none())?,
            pixel_mm: file.pixel_mm,
            lag_s: lag_s
                .or(file.lag.map(|lag| [lag.lag_s, lag.sigma_s]))
                .ok_or_else(|| SurfaceCommandError::NoLag { path: path.to_owned() })?,
            images: file.images.unwrap_or_default(),
            water_celsius: file.water.map(|water| water.celsius),
            id: file.id,
        })
    }

    /// The image in the marker by a matrix, of which neither the error nor the images are known.
    pub(super) fn of_matrix(
        path: &Path,
        marker_from_image: Rigid<Marker, Image>,
        pixel_mm: [f64; 2],
        lag_s: [f64; 2],
    ) -> Self {
        Self {
            path: path.to_owned(),
            id: BY_MATRIX.to_owned(),
            marker_from_image: marker_from_image.into(),
            pixel_mm,
            lag_s,
            images: ImagesRecord::default(),
            water_celsius: None,
        }
    }

    /// What it says of its images.
    pub(super) fn images(&self) -> &ImagesRecord {
        &self.images
    }

    /// The error that all points have by it.
    pub(super) fn shared(&self) -> Shared {
        let of = format!("the probe's calibration {}", self.path.display());
        let axis_mm = self.images.array.map(|array| array.middle_px() * self.pixel_mm[0]);
        Shared::Probe(of, Box::new(self.marker_from_image), axis_mm)
    }

    /// What images and tool cannot be compared with, in words; refused unless it is accepted.
    pub(super) fn unchecked(&self, is_accepted: bool) -> Result<Option<String>, SurfaceCommandError> {
        let unknown = self.images.unknown();
        if unknown.is_empty() {
            return Ok(None);
        }
        let what = unknown.join(", ");
        match is_accepted {
            true => Ok(Some(what)),
            false => Err(SurfaceCommandError::Unchecked {
                path: self.path.clone(),
                what,
            }),
        }
    }

    /// Refuses the tool of a run that is not that of the calibration; `alias` is the calibration's name for it where that is another.
    pub(super) fn of_tool(&self, tool: &str, alias: Option<&str>) -> Result<(), SurfaceCommandError> {
        match &self.images.tool {
            Some(expected) if !expected.eq_ignore_ascii_case(alias.unwrap_or(tool)) => {
                Err(SurfaceCommandError::OtherTool {
                    path: self.path.clone(),
                    expected: expected.clone(),
                    found: tool.to_owned(),
                    alias: alias.map(str::to_owned),
                })
            }
            _ => Ok(()),
        }
    }

    /// Whether it was made with a marker of this name.
    pub(super) fn of_marker(&self, marker: &str) -> bool {
        self.images
            .marker
            .as_deref()
            .is_some_and(|own| own.eq_ignore_ascii_case(marker))
    }

    /// Refuses an image that it does not hold for.
    pub(super) fn holds_for(&self, seq: u64, shape: &Shape) -> Result<(), SurfaceCommandError> {
        if let Some(what) = self.images.differs(shape) {
            return Err(SurfaceCommandError::OtherImages { seq, what });
        }
        let (found, expected) = (shape.pixel_mm(), self.pixel_mm);
        match (0..2).any(|i| (found[i] / expected[i] - 1.0).abs() > OTHER_PIXELS) {
            true => Err(SurfaceCommandError::OtherDepth {
                seq,
                found,
                expected,
                cause: self.cause(found[1] / expected[1]),
            }),
            false => Ok(()),
        }
    }

    /// What the likely cause of other pixels is, of which one is so many times as long along the beam.
    fn cause(&self, times: f64) -> String {
        match (self.water_celsius, celsius_of(times)) {
            (None, Some(celsius)) => format!(
                ": the depth was changed since, or the probe was calibrated in water of about {celsius:.0} C, which shows depths {:.1} % too \
                 long, without telling it (calib probe --water-celsius). Calibrate at the depth that is used, with the water's temperature",
                100.0 * (times - 1.0)
            ),
            (Some(celsius), _) => format!(
                ": the depth was changed since, or the water of the calibration was not that of {celsius:.1} C that was told; calibrate at the \
                 depth that is used"
            ),
            (None, None) => ": the depth was changed since; calibrate at the depth that is used".to_owned(),
        }
    }

    /// Refuses an image that is turned or mirrored against those of the calibration, where both say how they are turned. The third letter
    /// is of the direction across images.
    pub(super) fn is_turned_alike(&self, seq: u64, found: Option<&str>) -> Result<(), SurfaceCommandError> {
        let in_plane = |text: &str| text.chars().take(2).collect::<String>();
        match (found, self.images.orientation.as_deref()) {
            (Some(found), Some(expected)) if in_plane(found) != in_plane(expected) => {
                Err(SurfaceCommandError::OtherOrientation {
                    seq,
                    found: found.to_owned(),
                    expected: expected.to_owned(),
                })
            }
            _ => Ok(()),
        }
    }

    /// That it was not compared how images are turned, and by whom it is not told; `None` where it was. `is_told` is of the images.
    pub(super) fn not_compared(&self, is_told: bool) -> Option<String> {
        let who = match (is_told, self.images.orientation.is_some()) {
            (true, true) => return None,
            (true, false) => "the probe's calibration does not say how images are turned",
            (false, true) => "the run's images do not say how they are turned",
            (false, false) => "neither the run's images nor the probe's calibration say how images are turned",
        };
        Some(format!(
            "{who}: that nothing was mirrored on the scanner since the calibration is for you to see"
        ))
    }

    /// The second line of the file of points.
    pub(super) fn comment(&self) -> String {
        let unknown = self.images.unknown();
        match unknown.is_empty() {
            true => format!("{BY_PROBE}{}", self.id),
            false => format!("{BY_PROBE}{}{UNCHECKED}{}", self.id, unknown.join(", ")),
        }
    }

    /// Refuses points that were made with another calibration, and unless it is accepted such as do not say with which; what was not
    /// compared when they were made, in words.
    pub(super) fn made(
        &self,
        points: &Path,
        text: &str,
        is_accepted: bool,
    ) -> Result<Option<String>, SurfaceCommandError> {
        let id = |said: &&str| said.split_once(UNCHECKED).map_or(*said, |(id, _)| id) == self.id;
        // Of several, one that is not this calibration's.
        let Some(said) = said(text).find(|said| !id(said)).or_else(|| said(text).next()) else {
            let what = "that its points were made with this calibration";
            return match is_accepted {
                true => Ok(Some(format!("{} does not say {what}", points.display()))),
                false => Err(SurfaceCommandError::Unchecked {
                    path: points.to_owned(),
                    what: what.to_owned(),
                }),
            };
        };
        let (found, unchecked) = said.split_once(UNCHECKED).unwrap_or((said, ""));
        if found != self.id {
            return Err(SurfaceCommandError::OtherCalibration {
                points: points.to_owned(),
                found: found.chars().take(64).collect(),
                path: self.path.clone(),
                expected: self.id.clone(),
            });
        }
        let words = |what: &str| {
            format!(
                "when the points were made, these were not compared: {}",
                crate::text::shown(what)
            )
        };
        Ok((!unchecked.is_empty()).then(|| words(unchecked)))
    }
}
