//! Which images a sequence is of: all of one size and shape, each later than the one before.

use std::path::Path;

use bus::message::{CaptureClock, UsImageHeader};

use super::{ExportError, Posed, each};

/// The most images of a sequence, as `calib` reads it.
const MOST_IMAGES: usize = calib::file::sequence::MAX_FRAMES;
/// Sides of an image, pixels, as `calib` reads it.
const SIDES: std::ops::RangeInclusive<u32> = 16..=4096;

/// An image, and where the markers were.
pub(super) struct Image {
    pub(super) seq: u64,
    pub(super) t_ns: i64,
    /// Whether its stamp is of the scanner's clock, and not of its arrival.
    pub(super) is_stamped: bool,
    pub(super) posed: Option<Posed>,
}

/// The images of a recording.
#[derive(Default)]
pub(super) struct Listed {
    pub(super) images: Vec<Image>,
    /// What all are like.
    pub(super) first: Option<UsImageHeader>,
    pub(super) left_out: u64,
}

/// Lists the images.
pub(super) fn list(input: &Path) -> Result<Listed, ExportError> {
    let mut listed = Listed::default();
    let refused = |why| ExportError::Images {
        path: input.to_owned(),
        why,
    };
    each(input, "listing images", |frame| {
        let header = frame.header;
        if let Some(why) = other(listed.first.get_or_insert(header), &header) {
            return Err(refused(why));
        }
        if listed.images.len() == MOST_IMAGES {
            return Err(refused(format!(
                "more than {MOST_IMAGES} images: cut it (recorder cut)"
            )));
        }
        let image = Image {
            seq: header.seq,
            t_ns: header.t_capture_ns,
            is_stamped: header.capture_clock() == Some(CaptureClock::Mapped),
            posed: None,
        };
        match listed.images.last().is_none_or(|last| last.t_ns < image.t_ns) {
            true => listed.images.push(image),
            false => listed.left_out += 1,
        }
        Ok(())
    })?;
    Ok(listed)
}

/// Why an image does not belong to a sequence that begins with `first`.
fn other(first: &UsImageHeader, image: &UsImageHeader) -> Option<String> {
    let (seq, [width, height]) = (image.seq, [image.width, image.height]);
    if !SIDES.contains(&width) || !SIDES.contains(&height) {
        return Some(format!(
            "image {seq} has {width} x {height} pixels; sides of 16 to 4096 are exported"
        ));
    }
    let alike = |header: &UsImageHeader| UsImageHeader {
        seq: 0,
        t_device_ns: 0,
        t_capture_ns: 0,
        t_arrival_ns: 0,
        t_publish_ns: 0,
        clock: 0,
        ..*header
    };
    (alike(first) != alike(image)).then(|| {
        format!(
            "image {seq} differs from the first in its size, its pixels, where its beams run, how it is turned or its scanner: cut the \
             recording there (recorder cut), a calibration holds for images of one kind"
        )
    })
}
