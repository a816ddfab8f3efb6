//! RLE lossless: byte planes, each packed like TIFF's PackBits (DICOM PS3.5, annex G).

use super::{Image, failed};
use crate::dicom::error::FileError;

const CODEC: &str = "RLE";
/// The header: how many segments, and where up to fifteen of them begin.
const HEADER: usize = 64;

/// Decodes one frame, most significant bytes first.
///
/// # Errors
/// [`FileError::Codec`].
pub(super) fn decode(data: &[u8], image: &Image) -> Result<Vec<u16>, FileError> {
    let expected = usize::from(image.allocated / 8);
    let starts = segments(data, expected)?;
    let mut samples = vec![0_u16; image.pixels()];
    for (i, &start) in starts.iter().enumerate() {
        let end = starts.get(i + 1).copied().unwrap_or(data.len());
        let segment = data.get(start..end).filter(|_| start >= HEADER);
        let segment = segment.ok_or_else(|| {
            failed(
                CODEC,
                format!("segment {i} is said to lie at bytes {start} to {end} of {}", data.len()),
            )
        })?;
        unpack(segment, i, &mut samples)?;
    }
    Ok(samples)
}

/// Where the segments begin.
fn segments(data: &[u8], expected: usize) -> Result<Vec<usize>, FileError> {
    let header = data
        .get(..HEADER)
        .ok_or_else(|| failed(CODEC, format!("{} bytes, a header has {HEADER}", data.len())))?;
    let mut words = header
        .as_chunks()
        .0
        .iter()
        .map(|word| u32::from_le_bytes(*word) as usize);
    let found = words.next().unwrap_or(0);
    if found != expected {
        return Err(failed(
            CODEC,
            format!("{found} segments, expected {expected}: one per byte of a pixel"),
        ));
    }
    Ok(words.take(expected).collect())
}

/// Shifts each sample's bits up by a byte and puts the segment's byte below.
fn unpack(segment: &[u8], index: usize, samples: &mut [u16]) -> Result<(), FileError> {
    let total = samples.len();
    let broken = |done: usize| {
        failed(
            CODEC,
            format!("segment {index} ends or overflows at pixel {done} of {total}"),
        )
    };
    let (mut done, mut bytes) = (0, segment.iter().copied());
    while done < total {
        let control = bytes.next().ok_or_else(|| broken(done))?;
        let (count, repeated) = match control {
            0..=127 => (usize::from(control) + 1, None),
            128 => continue,
            129..=255 => (
                257 - usize::from(control),
                Some(bytes.next().ok_or_else(|| broken(done))?),
            ),
        };
        let run = samples.get_mut(done..done + count).ok_or_else(|| broken(done))?;
        for sample in run {
            let byte = match repeated {
                Some(byte) => byte,
                None => bytes.next().ok_or_else(|| broken(done))?,
            };
            *sample = *sample << 8 | u16::from(byte);
        }
        done += count;
    }
    // One byte makes the length even; more is a run that went wrong.
    match bytes.len() {
        0 | 1 => Ok(()),
        spare => Err(failed(
            CODEC,
            format!("segment {index} holds {spare} bytes more than its pixels"),
        )),
    }
}
