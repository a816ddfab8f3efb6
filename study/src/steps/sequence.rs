//! Tracked images as PLUS records them: a header with the pose of each frame, and grey values.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use geometry::{Ct, Frame, Marker, Point, Reference, Rigid, Tool, Uncertain};
use nalgebra::Matrix6;

use super::Prepared;
use crate::room::{TrueRoom, seen};

/// What the chain made of the frames of a probe that is held before the localizer.
pub(super) struct Tracked {
    /// Frame by frame; `None` where it was not seen.
    poses: Vec<Option<Uncertain<Reference, Marker>>>,
    rate_hz: f64,
}

impl Tracked {
    /// The probe held so, a frame each.
    pub(super) fn of(room: &mut TrueRoom, prepared: &mut Prepared, held: &[Rigid<Ct, Tool>]) -> Self {
        let frames = room.held(held.iter().copied());
        let pose = |frame| seen(frame, &mut prepared.markers).ok().flatten();
        Self {
            poses: frames.iter().map(pose).collect(),
            rate_hz: room.rate_hz(),
        }
    }

    /// The deviations of the marker's place along each axis and of its turn about each, mm and degrees, as the chain's covariances have them
    /// in the mean: what a command is told that has one number for all frames.
    pub(super) fn noise(&self) -> [f64; 2] {
        let poses = self.poses.iter().flatten();
        let about = |pose: &Uncertain<Reference, Marker>| {
            let place = pose.transform() * Point::<Marker>::new(0.0, 0.0, 0.0);
            pose.covariance_about(place)
        };
        let count = poses.clone().count().max(1) as f64;
        let mean = poses.map(about).fold(Matrix6::zeros(), |sum, one| sum + one) / count;
        let part = |first: usize| (mean.fixed_view::<3, 3>(first, first).trace() / 3.0).sqrt();
        [part(3), part(0).to_degrees()]
    }

    /// Writes the sequence; of poses alone where there are no images.
    ///
    /// # Errors
    /// Those of the file system.
    pub(super) fn write(&self, path: &Path, [columns, rows]: [usize; 2], images: &[Vec<u8>]) -> io::Result<()> {
        let mut file = BufWriter::new(File::create_new(path)?);
        let count = self.poses.len();
        writeln!(
            file,
            "ObjectType = Image\nNDims = 3\nDimSize = {columns} {rows} {count}\nElementType = MET_UCHAR\nUltrasoundImageOrientation = MF"
        )?;
        for (number, pose) in self.poses.iter().enumerate() {
            let (pose, status) = match pose {
                Some(pose) => (pose.transform(), "OK"),
                None => (Rigid::identity(), "INVALID"),
            };
            let at = format!("Seq_Frame{number:04}_");
            writeln!(file, "{at}ProbeToReferenceTransform = {}", matrix(&pose))?;
            writeln!(file, "{at}ProbeToReferenceTransformStatus = {status}")?;
            writeln!(file, "{at}Timestamp = {:?}", number as f64 / self.rate_hz)?;
        }
        writeln!(file, "ElementDataFile = LOCAL")?;
        images.iter().try_for_each(|grey| file.write_all(grey))?;
        file.flush()
    }
}

/// The 16 numbers of a transform, by rows.
pub(super) fn matrix<A: Frame, B: Frame>(pose: &Rigid<A, B>) -> String {
    let (rows, t) = (pose.rotation().matrix().rows(), pose.translation_mm());
    let row = |i: usize| {
        let [a, b, c] = rows[i];
        format!("{a:?} {b:?} {c:?} {:?} ", t[i])
    };
    [0, 1, 2].map(row).concat() + "0 0 0 1"
}
