//! The marker segments of JPEG (ITU-T T.81, annex B) and JPEG-LS (T.87, annex C): what comes before the coded pixels.

use super::Claim;

/// Start of image, end of image, start of scan.
const SOI: u8 = 0xD8;
pub(super) const EOI: u8 = 0xD9;
const SOS: u8 = 0xDA;
const DHT: u8 = 0xC4;
const DRI: u8 = 0xDD;
/// Lossless, sequential, Huffman.
pub(super) const SOF_LOSSLESS: u8 = 0xC3;
/// JPEG-LS.
pub(super) const SOF_LS: u8 = 0xF7;

/// What stands before the pixels of the first scan.
#[derive(Debug, Clone)]
pub(super) struct Segments<'a> {
    /// Which kind of frame.
    pub process: u8,
    pub claim: Claim,
    /// Contents of Huffman table segments.
    pub tables: Vec<&'a [u8]>,
    /// Samples between restarts; 0 for none.
    pub restart: u16,
    /// The scan header after its length: count, component and tables, then three parameters.
    pub scan: [u8; 6],
    /// The coded pixels, up to the end of the data.
    pub coded: &'a [u8],
}

/// Reads the segments before the first scan of one component; the error is a sentence's part.
pub(super) fn segments(data: &[u8]) -> Result<Segments<'_>, String> {
    if data.get(..2) != Some(&[0xFF, SOI]) {
        return Err("no start of image".to_owned());
    }
    let (mut at, mut frame, mut tables, mut restart) = (2, None, Vec::new(), 0);
    loop {
        let (marker, content, next) = segment(data, at)?;
        match marker {
            0xC0..=0xC3 | 0xC5..=0xC7 | 0xC9..=0xCB | 0xCD..=0xCF | SOF_LS => {
                let found = (marker, claim(content)?);
                if frame.replace(found).is_some() {
                    return Err(format!("a second frame at byte {at}"));
                }
            }
            DHT => tables.push(content),
            DRI => restart = u16_at(content, 0).ok_or("a short restart interval")?,
            SOS => {
                let (process, claim) = frame.ok_or("a scan before its frame")?;
                let scan = content
                    .try_into()
                    .map_err(|_| format!("a scan header of {} bytes", content.len()))?;
                let coded = data.get(next..).unwrap_or_default();
                return Ok(Segments {
                    process,
                    claim,
                    tables,
                    restart,
                    scan,
                    coded,
                });
            }
            EOI => return Err("no pixels".to_owned()),
            _ => {}
        }
        at = next;
    }
}

/// The marker at `at`, its segment's content, and where the next one begins.
fn segment(data: &[u8], mut at: usize) -> Result<(u8, &[u8], usize), String> {
    let ends = || format!("the header ends at byte {}", data.len());
    if data.get(at) != Some(&0xFF) {
        return Err(format!("no marker at byte {at}"));
    }
    // Any number of FF may come before a marker.
    while data.get(at) == Some(&0xFF) {
        at += 1;
    }
    let marker = *data.get(at).ok_or_else(ends)?;
    if marker == EOI {
        return Ok((marker, &[], at + 1));
    }
    let length = usize::from(u16_at(data, at + 1).ok_or_else(ends)?);
    let content = data.get(at + 3..at + 1 + length.max(2)).ok_or_else(ends)?;
    Ok((marker, content, at + 1 + length.max(2)))
}

fn claim(content: &[u8]) -> Result<Claim, String> {
    let short = || format!("a frame header of {} bytes", content.len());
    let byte = |at: usize| content.get(at).copied().map(u16::from).ok_or_else(short);
    Ok(Claim {
        precision: byte(0)?,
        rows: u16_at(content, 1).map(u32::from).ok_or_else(short)?,
        columns: u16_at(content, 3).map(u32::from).ok_or_else(short)?,
        components: byte(5)?,
    })
}

/// A big-endian number.
pub(super) fn u16_at(bytes: &[u8], at: usize) -> Option<u16> {
    let pair = bytes.get(at..at.checked_add(2)?)?;
    Some(u16::from_be_bytes(pair.try_into().ok()?))
}
