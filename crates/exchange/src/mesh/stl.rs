//! STL: text, or a head of 80 bytes, a count and 50 bytes a triangle, least significant byte first.

use super::MeshError;
use super::bytes::{Bytes, Scalar};
use super::raw::{Raw, counted};
use super::words::Words;

/// Bytes of a binary head.
const HEAD: usize = 80;
/// Bytes of a triangle: normal, three corners, an attribute.
const TRIANGLE: u64 = 50;

/// Many binary files begin with `solid` too: what tells them apart is that their length is that of the triangles they promise.
pub(super) fn read(bytes: &[u8]) -> Result<Raw, MeshError> {
    let count = bytes
        .get(HEAD..HEAD + 4)
        .and_then(|four| four.first_chunk())
        .map(|four| u32::from_le_bytes(*four));
    let promised = count.map(|count| u64::from(count) * TRIANGLE + HEAD as u64 + 4);
    let is_binary = promised == Some(bytes.len() as u64);
    let first = bytes.trim_ascii_start().first_chunk::<5>();
    let is_solid = first.is_some_and(|first| first.eq_ignore_ascii_case(b"solid"));
    match is_binary || !is_solid {
        true => binary(bytes, count),
        false => text(bytes),
    }
}

fn binary(bytes: &[u8], count: Option<u32>) -> Result<Raw, MeshError> {
    let mut raw = Raw::default();
    let head = &bytes[..bytes.len().min(HEAD)];
    let cut_off = MeshError::CutOff {
        what: "the head of a binary STL",
        needed: HEAD as u64 + 4,
        left: bytes.len(),
    };
    let count = counted("triangles", u64::from(count.ok_or(cut_off)?))?;
    raw.comment(&String::from_utf8_lossy(head).replace('\0', " "))?;
    let mut rest = Bytes {
        rest: &bytes[HEAD + 4..],
        is_big: false,
    };
    let all = rest.take("the triangles", count as u64, TRIANGLE)?;
    if !rest.rest.is_empty() {
        return Err(MeshError::TooMuch { left: rest.rest.len() });
    }
    for (triangle, place) in all.chunks_exact(TRIANGLE as usize).zip(0_u32..) {
        // Behind the normal, which the corners' order tells too.
        let number = |i: usize| Scalar::F32.read(&triangle[12 + 4 * i..], false);
        raw.points
            .extend([0, 3, 6].map(|i| [number(i), number(i + 1), number(i + 2)]));
        raw.triangles.push([3 * place, 3 * place + 1, 3 * place + 2]);
    }
    Ok(raw)
}

fn text(bytes: &[u8]) -> Result<Raw, MeshError> {
    let mut raw = Raw::default();
    let mut words = Words::new(bytes, 1);
    words.expect("solid")?;
    raw.comment(&String::from_utf8_lossy(words.line()))?;
    loop {
        match words.next() {
            word if word.eq_ignore_ascii_case(b"facet") => {}
            word if word.eq_ignore_ascii_case(b"endsolid") => break,
            found => return Err(words.refused(found, "facet or endsolid: the file is cut off, or no text")),
        }
        words.expect("normal")?;
        words.point()?;
        words.expect("outer")?;
        words.expect("loop")?;
        let first = raw.points.len() as u32;
        for _ in 0..3 {
            words.expect("vertex")?;
            raw.points.push(words.point()?);
        }
        words.expect("endloop")?;
        words.expect("endfacet")?;
        raw.triangles.push([first, first + 1, first + 2]);
        counted("triangles", raw.triangles.len() as u64)?;
    }
    raw.comment(&String::from_utf8_lossy(words.line()))?;
    match words.next() {
        b"" => Ok(raw),
        found => Err(words.refused(found, "the end of the file: one solid is read")),
    }
}
