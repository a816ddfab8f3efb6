//! The header of a sequence of images, and what a calibration of the probe is told of them.

use std::io::{self, Write};

use bus::message::UsImageHeader;
use geometry::Rigid;

use super::super::sequence::{matrix, seconds};
use super::listed::Image;

/// The markers' frames by the names that PLUS's own device sets have for them.
const PROBE: &str = "ProbeToTracker";
const REFERENCE: &str = "ReferenceToTracker";

/// Writes the header of all `images`, which are like `first`.
pub(super) fn header(out: &mut impl Write, first: &UsImageHeader, images: &[Image]) -> io::Result<()> {
    let (width, height, count) = (first.width, first.height, images.len());
    write!(
        out,
        "ObjectType = Image\nNDims = 3\nAnatomicalOrientation = RAI\nBinaryData = True\n\
         BinaryDataByteOrderMSB = False\nCenterOfRotation = 0 0 0\nCompressedData = False\nDimSize = {width} {height} {count}\n\
         ElementSpacing = 1 1 1\nElementType = MET_UCHAR\nKinds = domain domain list\nOffset = 0 0 0\n\
         TransformMatrix = 1 0 0 0 1 0 0 0 1\n"
    )?;
    // As the source says it; where it says nothing, nothing is said.
    if let Some(turned) = first.orientation() {
        writeln!(out, "UltrasoundImageOrientation = {turned}")?;
    }
    let has_reference = images
        .iter()
        .any(|image| image.posed.is_some_and(|posed| posed.reference.is_some()));
    for (number, image) in images.iter().enumerate() {
        let key = format!("Seq_Frame{number:04}_");
        transform(out, &key, PROBE, image.posed.map(|posed| posed.marker).as_ref())?;
        if has_reference {
            let reference = image.posed.and_then(|posed| posed.reference);
            transform(out, &key, REFERENCE, reference.as_ref())?;
        }
        let (seq, t_s) = (image.seq, seconds(image.t_ns));
        write!(
            out,
            "{key}FrameNumber = {seq}\n{key}Timestamp = {t_s}\n{key}UnfilteredTimestamp = {t_s}\n{key}ImageStatus = OK\n"
        )?;
    }
    out.write_all(b"ElementDataFile = LOCAL\n")
}

fn transform<A, B>(out: &mut impl Write, key: &str, name: &str, pose: Option<&Rigid<A, B>>) -> io::Result<()> {
    let (numbers, status) = match pose {
        Some(pose) => (matrix(pose), "OK"),
        None => ("1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1".to_owned(), "INVALID"),
    };
    write!(
        out,
        "{key}{name}Transform = {numbers}\n{key}{name}TransformStatus = {status}\n"
    )
}

/// Where the beams of the images run and whose they are, as `calib probe` is told it.
pub(super) fn options(first: &UsImageHeader, tool: &str) -> Option<String> {
    let [u, v] = first.pixel_mm;
    let [a, b, c, half_angle] = first.beams;
    let array = match first.array {
        UsImageHeader::LINEAR => format!("linear:{},{},{}", short(a / u), short(b / u), short(c / v)),
        UsImageHeader::CONVEX => {
            let angle = 2.0 * half_angle.to_degrees();
            format!(
                "curved:{},{},{},{}",
                short(a / u),
                short(b / v),
                short(c / v),
                short(angle)
            )
        }
        _ => return None,
    };
    // Numbers that can be no image's are not passed on.
    first.shape().ok()?;
    Some(format!(
        "--array {array} --depth-mm {} --tool {tool}",
        short(first.depth_mm)
    ))
}

/// A thousandth of a pixel is less than anybody sees.
fn short(number: f64) -> f64 {
    (number * 1e3).round() / 1e3
}
