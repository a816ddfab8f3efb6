//! Poses as a sequence of the PLUS toolkit: a MetaImage of one voxel a frame, whose header carries the transforms.

use std::io::{self, Write};
use std::path::Path;

use bus::message::{ToolPose, Tracked};
use geometry::Rigid;

use super::{ExportError, Exported, write_error};
use crate::edit::progress::Progress;
use crate::read::reader;

/// The transform's name in the header, without `Transform`: maps the tool's frame to the examination's.
pub(crate) const TRANSFORM: &str = "ToolToCt";

/// Writes the poses of `topic`. The recording is read twice: the header says how many there are.
pub(super) fn write(input: &Path, topic: &str, out: &mut impl Write) -> Result<Exported, ExportError> {
    let counted = each(input, topic, "counting", |_, _| Ok(()))?;
    header(out, counted.messages).map_err(write_error)?;
    let exported = each(input, topic, "exporting", |number, pose| frame(out, number, pose))?;
    out.write_all(b"ElementDataFile = LOCAL\n").map_err(write_error)?;
    // A voxel a frame: the form wants an image.
    io::copy(&mut io::Read::take(io::repeat(0), exported.messages), out).map_err(write_error)?;
    Ok(exported)
}

fn each(
    input: &Path,
    topic: &str,
    what: &'static str,
    mut take: impl FnMut(u64, &ToolPose) -> io::Result<()>,
) -> Result<Exported, ExportError> {
    let mut exported = Exported::default();
    let mut poses = reader::poses(input, topic)?;
    let mut progress = Progress::new(what);
    while let Some(pose) = poses.next() {
        let (read, length) = poses.progress();
        progress.at(read, length);
        match pose {
            Ok(pose) => {
                take(exported.messages, &pose).map_err(write_error)?;
                exported.messages += 1;
            }
            Err(reader::ReadError::Damage(damage)) if damage.fault.is_mere_ending() => {}
            Err(_) => exported.unreadable += 1,
        }
    }
    Ok(exported)
}

fn header(out: &mut impl Write, frames: u64) -> io::Result<()> {
    write!(
        out,
        "ObjectType = Image\nNDims = 3\nAnatomicalOrientation = RAI\nBinaryData = True\n\
         BinaryDataByteOrderMSB = False\nCenterOfRotation = 0 0 0\nCompressedData = False\nDimSize = 1 1 {frames}\n\
         ElementSpacing = 1 1 1\nElementType = MET_UCHAR\nKinds = domain domain list\nOffset = 0 0 0\n\
         TransformMatrix = 1 0 0 0 1 0 0 0 1\nUltrasoundImageOrientation = MFA\n"
    )
}

fn frame(out: &mut impl Write, number: u64, pose: &ToolPose) -> io::Result<()> {
    let (matrix, status) = match pose.tracked() {
        Ok(Tracked::Valid(ct_from_tool)) => (matrix(&ct_from_tool), "OK"),
        _ => ("1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1".to_owned(), "INVALID"),
    };
    let key = format!("Seq_Frame{number:04}_");
    let (seq, t_s) = (pose.seq, seconds(pose.t_capture_ns));
    write!(
        out,
        "{key}FrameNumber = {seq}\n{key}{TRANSFORM}Transform = {matrix}\n{key}{TRANSFORM}TransformStatus = {status}\n\
         {key}Timestamp = {t_s}\n{key}UnfilteredTimestamp = {t_s}\n{key}ImageStatus = INVALID\n"
    )
}

/// Sixteen numbers by rows.
pub(super) fn matrix<A, B>(pose: &Rigid<A, B>) -> String {
    let (rows, t) = (pose.rotation().matrix().rows(), pose.translation_mm());
    let rows = rows.iter().zip(t).map(|([a, b, c], t)| format!("{a} {b} {c} {t} "));
    rows.collect::<String>() + "0 0 0 1"
}

/// Exact: nine decimals.
pub(super) fn seconds(ns: i64) -> String {
    const SECOND: u64 = 1_000_000_000;
    let sign = if ns < 0 { "-" } else { "" };
    let ns = ns.unsigned_abs();
    format!("{sign}{}.{:09}", ns / SECOND, ns % SECOND)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stamps_are_exact() {
        assert_eq!(seconds(1_000_000_001), "1.000000001");
        assert_eq!(seconds(-5), "-0.000000005");
        assert_eq!(seconds(i64::MIN), "-9223372036.854775808");
    }
}
