//! `calib bone-line`: bone in the images of a recorded sequence of a tracked ultrasound probe, as the points that `calib surface` takes.

mod args;
mod matrix;
mod seen;
#[cfg(test)]
mod tests;

use std::path::Path;

use geometry::Uncertain;
use nalgebra::{Matrix6, Vector6};
use ultrasound::Shape;

pub(crate) use args::{BONE_LINE_HELP, BoneLineArgs};

use super::calibrated::Calibrated;
use super::error::SurfaceCommandError;
use super::sweep::{Sounding, Taken};
use crate::commands::Outcome;
use crate::commands::common::CommandError;
use crate::commands::probe::frames;
use crate::live::{Listened, Looked};
use crate::poses::{Pixels, Timed, timed};
use crate::store;
use seen::Seen;

/// What images and poses give.
struct Found {
    seen: Seen,
    taken: Taken,
    /// Frames without a valid pose.
    lost: usize,
}

impl BoneLineArgs {
    /// Does what is asked.
    pub(crate) fn run(&self) -> Result<Outcome, CommandError> {
        store::check(&self.to, self.overwrite)?;
        if let Some(picture) = &self.picture {
            store::check(picture, self.overwrite)?;
        }
        let (marker, reference) = frames(&self.transform).unwrap_or_else(|| ("Probe".to_owned(), "tracker".to_owned()));
        let probe = self.calibrated(&marker)?;
        let mut warnings: Vec<String> = Vec::new();
        if self.probe.is_some() {
            let unchecked = probe.unchecked(self.unchecked_images)?;
            warnings.extend(unchecked.map(|what| format!("the probe's calibration does not say {what}: not compared")));
            probe
                .of_tool(&marker, None)
                .or_else(|why| match probe.of_marker(&marker) {
                    true => Ok(()),
                    false => Err(why),
                })?;
        }
        let shapes = self.shapes(&probe)?;
        let found = self.find(&probe, &shapes, (&marker, &reference.to_ascii_lowercase()))?;
        for warning in &warnings {
            bus::stderr_line!("calib: warning: {warning}");
        }
        let inputs = || [Some(&self.sequence), self.probe.as_ref()].into_iter().flatten();
        let Found { seen, taken, lost } = found;
        // Also where nothing was found: the picture shows why.
        let drawn = match (&self.picture, seen.png()) {
            (Some(path), Some(png)) => {
                store::write_bytes(path, png, inputs().map(|path| path.as_path()))?;
                format!("  drawn in {}\n", path.display())
            }
            _ => String::new(),
        };
        if taken.count == 0 {
            return Err(SurfaceCommandError::NoBone {
                path: self.sequence.clone(),
                images: seen.images.len(),
                reasons: seen.reasons(),
            }
            .into());
        }
        store::write(&self.to, Ok(taken.text), inputs().map(|path| path.as_path()))?;
        let mut text = seen.words(taken.count) + &drawn;
        if lost > 0 {
            text += &format!(
                "  {lost} images have no valid pose {} and give no points\n",
                self.transform
            );
        }
        if let Some(refused) = taken.refused {
            text += &format!("WARNING          {refused}\n");
        }
        for warning in warnings {
            text += &format!("WARNING          {warning}\n");
        }
        text += &format!(
            "written to {}, in the {}\n",
            self.to.display(),
            reference.to_ascii_lowercase()
        );
        Ok(Outcome { text, refused: None })
    }

    /// The calibration; without a lag of its own or --lag-ms nothing is late: image and pose are of one frame.
    fn calibrated(&self, marker: &str) -> Result<Calibrated, SurfaceCommandError> {
        let told = self.lag_ms.map(|lag| lag.0);
        match (&self.probe, &self.image_to_probe) {
            (Some(path), _) => match Calibrated::read(path, told) {
                Err(SurfaceCommandError::NoLag { .. }) => Calibrated::read(path, Some([0.0; 2])),
                other => other,
            },
            (None, given) => {
                let given = given.as_deref().unwrap_or_default();
                let (image, pixel_mm) = matrix::read(given, marker)?;
                Ok(Calibrated::of_matrix(
                    Path::new(given),
                    image,
                    pixel_mm,
                    told.unwrap_or_default(),
                ))
            }
        }
    }

    /// Where beams run, as the command line says, or else the calibration: as deep as the scanner was set to, and no deeper than the picture.
    fn shapes(&self, probe: &Calibrated) -> Result<[Shape; 2], SurfaceCommandError> {
        let size_px = Pixels::pictured(&self.sequence)?.size_px;
        let size = size_px.ok_or_else(|| SurfaceCommandError::NoPixels(self.sequence.clone()))?;
        let set = self.image_to_probe.as_deref().map(Path::new);
        let set = set.filter(|path| path.extension().is_some_and(|end| end.eq_ignore_ascii_case("xml")));
        let beamed = self.array.read(set, Some(size))?;
        if let Some(why) = &beamed.left {
            bus::stderr_line!("calib: warning: {why}");
        }
        let (array, depth_mm) = (
            beamed.array.or(probe.images().array),
            beamed.depth_mm.or(probe.images().depth_mm),
        );
        let (Some(array), Some(depth_mm)) = (array, depth_mm) else {
            return Err(SurfaceCommandError::NoBeams);
        };
        let of = |depth_mm: f64| {
            let beams = array.beams(probe.pixel_mm);
            let shape = Shape::new(size, probe.pixel_mm, beams, depth_mm);
            shape.map_err(|why| SurfaceCommandError::NoImageShape {
                path: self.sequence.clone(),
                what: why.to_string(),
            })
        };
        let told = of(depth_mm)?;
        probe.holds_for(0, &told)?;
        // A picture may end before the depth that the scanner was set to.
        Ok([told, of(depth_mm.min(array.shown_rows(size[1]) * probe.pixel_mm[1]))?])
    }

    fn find(
        &self,
        probe: &Calibrated,
        [told, shown]: &[Shape; 2],
        (tool, frame): (&str, &str),
    ) -> Result<Found, SurfaceCommandError> {
        let poses = timed(&self.sequence, &self.transform).map_err(|why| SurfaceCommandError::Poses(Box::new(why)))?;
        if !poses.iter().any(|frame| frame.pose.is_some()) {
            return Err(SurfaceCommandError::NoTracked {
                path: self.sequence.clone(),
                frames: poses.len(),
                transform: self.transform.clone(),
            });
        }
        let mut seen = seen::look(&self.sequence, shown, self.picture.is_some())?;
        // What the calibration is held against is the depth that was set, not where the picture ends.
        for image in &mut seen.images {
            image.shape = Ok(*told);
        }
        let sounding = Sounding {
            probe,
            step_mm: self.step_mm.0,
            elevation_mm: self.elevation_mm.0,
        };
        let posed: Vec<&Timed> = poses.iter().filter(|frame| frame.pose.is_some()).collect();
        let lost = seen.images.iter().filter(|image| {
            let number = image.seq;
            !posed.iter().any(|frame| u64::from(frame.number) == number)
        });
        let lost = lost.count();
        let taken = match probe.lag_s == [0.0; 2] {
            true => {
                let own = |image: &Looked| {
                    let frame = posed.iter().find(|frame| u64::from(frame.number) == image.seq)?;
                    Some((image.clone(), self.uncertain(frame)?))
                };
                let frames: Vec<_> = seen.images.iter().filter_map(own).collect();
                sounding.csv_of_own(&frames, tool, frame)
            }
            false => {
                let heard = self.heard(&poses, &mut seen)?;
                sounding.csv(&heard, tool, frame)
            }
        };
        Ok(Found { seen, taken, lost })
    }

    /// Images and poses by their times, for a lag.
    fn heard(&self, poses: &[Timed], seen: &mut Seen) -> Result<Listened, SurfaceCommandError> {
        let no_times = |frame: u32| SurfaceCommandError::NoTimes {
            path: self.sequence.clone(),
            frame,
        };
        let (mut all, mut times_s) = (Vec::new(), Vec::new());
        let zero_s = poses.iter().find_map(|frame| frame.t_s).unwrap_or(0.0);
        for frame in poses.iter().filter(|frame| frame.pose.is_some()) {
            let t_s = frame.t_s.ok_or_else(|| no_times(frame.number))? - zero_s;
            // Their order in time is what places between them are found by.
            if times_s.last().is_some_and(|last| t_s <= *last) {
                continue;
            }
            let Some(pose) = self.uncertain(frame) else { continue };
            all.push(pose);
            times_s.push(t_s);
        }
        for image in &mut seen.images {
            let number = image.seq as u32;
            let t_s = poses
                .iter()
                .find(|frame| frame.number == number)
                .and_then(|frame| frame.t_s);
            image.t_capture_ns = ((t_s.ok_or_else(|| no_times(number))? - zero_s) * 1e9).round() as i64;
        }
        Ok(Listened::recorded(all, times_s, seen.images.clone()))
    }

    /// A frame's pose with the errors that the command line says.
    fn uncertain(&self, frame: &Timed) -> Option<Uncertain<geometry::Tracker, geometry::Marker>> {
        let pose = frame.pose?;
        let [turn, shift] = [self.pose_noise_deg.to_radians(), self.pose_noise_mm].map(|sigma| sigma * sigma);
        let covariance = Matrix6::from_diagonal(&Vector6::new(turn, turn, turn, shift, shift, shift));
        let [x, y, z] = pose.translation_mm();
        Uncertain::from_covariance_about(geometry::Point::new(x, y, z), pose, covariance).ok()
    }
}
