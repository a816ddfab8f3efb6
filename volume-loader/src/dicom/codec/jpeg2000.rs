//! JPEG 2000 (ISO/IEC 15444-1), decoded by `hayro-jpeg2000`; the codestream's parameters are judged here first.
//!
//! The decoder works in f32: reversible transforms of up to 16 bits are exact there, 24 bits of mantissa.

use hayro_jpeg2000::{DecodeSettings, DecoderContext, Image as Stream};

use super::jpeg::u16_at;
use super::{Claim, Image, failed};
use crate::dicom::error::FileError;

const CODEC: &str = "JPEG 2000";
/// Markers (annex A).
const SOC: u16 = 0xFF4F;
const SIZ: u16 = 0xFF51;
const COD: u16 = 0xFF52;
const COC: u16 = 0xFF53;
const SOT: u16 = 0xFF90;
const SOD: u16 = 0xFF93;
const EOC: u16 = 0xFFD9;
/// Code blocks times layers: what the decoder holds lists for. Usual are a few thousand.
const MAX_PARTS: u64 = 1 << 20;
/// Tiles in an image; usual is one.
const MAX_TILES: u64 = 4096;

/// What a codestream's main header says.
#[derive(Debug, Clone, Copy)]
struct Main {
    claim: Claim,
    signed: bool,
    tiles: u64,
    style: Style,
}

/// The coding style (A.6.1).
#[derive(Debug, Clone, Copy)]
struct Style {
    layers: u16,
    /// Logarithm of the pixels in a code block.
    block: u8,
    /// Logarithm of the smallest precinct's side.
    precinct: u8,
    reversible: bool,
}

/// Decodes one component.
///
/// # Errors
/// [`FileError::Mismatch`], [`FileError::Codec`].
pub(super) fn decode(data: &[u8], image: &Image) -> Result<Vec<u16>, FileError> {
    let main = main_header(data).map_err(|detail| failed(CODEC, detail))?;
    image.check(CODEC, main.claim)?;
    check_signs(&main, image)?;
    check_effort(&main, image).map_err(|detail| failed(CODEC, detail))?;
    let settings = DecodeSettings {
        resolve_palette_indices: false,
        strict: true,
        target_resolution: None,
    };
    let broken = |error: hayro_jpeg2000::DecodeError| failed(CODEC, error.to_string());
    let stream = Stream::new(data, &settings).map_err(broken)?;
    let mut context = DecoderContext::default();
    let decoded = stream.decode(&mut context).map_err(broken)?;
    let component = decoded
        .components()
        .first()
        .ok_or_else(|| failed(CODEC, "no component"))?;
    // The decoder shifts signed samples as if they were unsigned.
    let shift = if main.signed {
        -(1_i32 << (main.claim.precision - 1))
    } else {
        0
    };
    let least = shift;
    let most = shift + (1_i32 << main.claim.precision) - 1;
    let sample = |&value: &f32| ((value.round() as i32).saturating_add(shift)).clamp(least, most) as u16;
    Ok(component.samples().iter().map(sample).collect())
}

/// The wavelet that rounds is the lossy one.
///
/// # Errors
/// [`FileError::Codec`].
pub(super) fn is_lossy(data: &[u8]) -> Result<bool, FileError> {
    let main = main_header(data).map_err(|detail| failed(CODEC, detail))?;
    Ok(!main.style.reversible)
}

fn check_signs(main: &Main, image: &Image) -> Result<(), FileError> {
    if main.signed == image.signed {
        return Ok(());
    }
    let signs = |signed| if signed { "signed samples" } else { "unsigned samples" };
    Err(FileError::Mismatch {
        codec: CODEC,
        found: signs(main.signed).to_owned(),
        expected: signs(image.signed).to_owned(),
    })
}

/// Streams made to exhaust memory have many tiny parts.
fn check_effort(main: &Main, image: &Image) -> Result<(), String> {
    let style = main.style;
    let blocks = (image.pixels() as u64 >> style.block) + 4 * main.tiles;
    let parts = blocks.saturating_mul(u64::from(style.layers));
    if main.tiles > MAX_TILES || parts > MAX_PARTS || style.precinct < 4 {
        return Err(format!(
            "{} tiles, {blocks} code blocks in {} layers, precincts down to 2^{}: expected at most {MAX_TILES} tiles and \
             {MAX_PARTS} blocks times layers, and at least 2^4",
            main.tiles, style.layers, style.precinct
        ));
    }
    Ok(())
}

/// Reads the main header, and sees that no tile has a coding style of its own.
fn main_header(data: &[u8]) -> Result<Main, String> {
    if u16_at(data, 0) != Some(SOC) {
        return Err("no start of codestream".to_owned());
    }
    let (mut at, mut size, mut style) = (2, None, None);
    loop {
        let marker = u16_at(data, at).ok_or("the main header ends early")?;
        if marker == SOT {
            check_tile_parts(data, at)?;
            let (claim, signed, tiles) = size.ok_or("no image size")?;
            let style = style.ok_or("no coding style")?;
            return Ok(Main {
                claim,
                signed,
                tiles,
                style,
            });
        }
        let (content, next) = segment(data, at)?;
        match marker {
            SIZ => size = Some(image_size(content).ok_or("an unusable image size")?),
            COD => style = Some(coding_style(content).ok_or("an unusable coding style")?),
            COC => return Err("a coding style for one component only".to_owned()),
            _ => {}
        }
        at = next;
    }
}

/// A segment's content, and where the next marker stands.
fn segment(data: &[u8], at: usize) -> Result<(&[u8], usize), String> {
    let ends = || format!("a header ends at byte {}", data.len());
    let length = usize::from(u16_at(data, at + 2).ok_or_else(ends)?).max(2);
    let content = data.get(at + 4..at + 2 + length).ok_or_else(ends)?;
    Ok((content, at + 2 + length))
}

fn u32_at(bytes: &[u8], at: usize) -> Option<u32> {
    Some(u32::from(u16_at(bytes, at)?) << 16 | u32::from(u16_at(bytes, at + 2)?))
}

/// SIZ (A.5.1): dimensions and precision, the sign, and how many tiles there are.
fn image_size(content: &[u8]) -> Option<(Claim, bool, u64)> {
    let word = |index: usize| u32_at(content, 2 + 4 * index);
    let [right, bottom, left, top] = [word(0)?, word(1)?, word(2)?, word(3)?];
    let [tile_columns, tile_rows] = [word(4)?, word(5)?];
    let (columns, rows) = (right.checked_sub(left)?, bottom.checked_sub(top)?);
    let tiles = |size: u32, tile: u32| Some(u64::from(size.checked_div(tile)?) + 2);
    let (depth, x, y) = (*content.get(36)?, *content.get(37)?, *content.get(38)?);
    let claim = Claim {
        columns,
        rows,
        components: u16_at(content, 34)?,
        precision: u16::from(depth & 0x7F) + 1,
    };
    let whole = x == 1 && y == 1;
    whole.then_some((
        claim,
        depth & 0x80 != 0,
        tiles(columns, tile_columns)? * tiles(rows, tile_rows)?,
    ))
}

/// COD (A.6.1).
fn coding_style(content: &[u8]) -> Option<Style> {
    let own_precincts = content.first()? & 1 == 1;
    let [width, height] = [*content.get(6)?, *content.get(7)?];
    let precincts = if own_precincts { content.get(10..)? } else { &[0xFF] };
    let smallest = precincts.iter().map(|&p| (p & 15).min(p >> 4)).min();
    Some(Style {
        layers: u16_at(content, 2)?,
        block: (width & 15) + (height & 15) + 4,
        precinct: smallest.unwrap_or(15),
        reversible: *content.get(9)? == 1,
    })
}

/// Goes from tile part to tile part; a coding style there would escape [`check_effort`].
fn check_tile_parts(data: &[u8], mut at: usize) -> Result<(), String> {
    while u16_at(data, at) == Some(SOT) {
        let (content, mut next) = segment(data, at)?;
        let length = u32_at(content, 2).ok_or("a short tile part header")? as usize;
        loop {
            match u16_at(data, next).ok_or("a tile part ends in its header")? {
                SOD => break,
                COD | COC => return Err("a tile with a coding style of its own".to_owned()),
                _ => next = segment(data, next)?.1,
            }
        }
        // A length of 0 reaches to the end of the codestream.
        if length == 0 {
            return Ok(());
        }
        let end = at.saturating_add(length);
        if end <= next {
            return Err(format!("a tile part of {length} bytes at byte {at}"));
        }
        at = end;
    }
    match u16_at(data, at) {
        Some(EOC) => Ok(()),
        _ => Err(format!(
            "no tile part and no end of codestream at byte {at} of {}",
            data.len()
        )),
    }
}
