//! From the bytes of a file to a transform.

use std::str;

use geometry::rotation::RotationMatrix;
use geometry::{Affine, Frame, Named, Point, Rigid, Vector};

use super::parts::{Part, is_allowed, stretches};
use super::{ItkError, MAX_BYTES, MAX_PARTS, MOST_OFF, hdf5};
use crate::{quoted, unmarked};

/// What every text begins with.
const HEAD: &str = "#Insight Transform File V1.0";
/// Most numbers of a line that are kept: more than any rigid transform has.
const MOST_NUMBERS: usize = 16;
const IDENTITY: [[f64; 4]; 3] = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];

/// A transform of a file.
#[derive(Debug, Clone, PartialEq)]
pub struct Transform<To: Frame, From: Frame> {
    /// Takes points of `From`, the output or fixed image, to points of `To`, the input or moving image. Of a composite, all of it.
    pub to_from_from: Rigid<To, From>,
    /// What the file holds and that was taken for.
    file: Affine<To, From>,
    /// The kinds, in the order of the file.
    pub kinds: Vec<String>,
    /// The largest Frobenius distance of a matrix of it, and of their product, from the rotation that was taken for it.
    pub most_off: f64,
}

impl<To: Frame, From: Frame> Transform<To, From> {
    /// How far the image of a point lies from where the file has it, in the file's unit: a matrix that is a little off is put right about
    /// the file's centre, which may be far away.
    pub fn moved(&self, point: Point<From>) -> f64 {
        (self.file * point).distance(self.to_from_from * point)
    }
}

/// Reads a file, text or HDF5. `To` and `From` are said by the caller: the file maps points of `From` to points of `To`, and holds
/// neither's name.
///
/// # Errors
/// Each variant of [`ItkError`].
pub fn read<To: Frame, From: Frame>(bytes: &[u8]) -> Result<Transform<To, From>, ItkError> {
    if bytes.len() > MAX_BYTES {
        return Err(ItkError::TooLong { bytes: bytes.len() });
    }
    let parts = match bytes.starts_with(&hdf5::SIGNATURE) {
        true => hdf5::parts(bytes)?,
        false => of_text(unmarked(bytes))?,
    };
    let (composite, parts) = match &parts[..] {
        [] => return Err(ItkError::Empty),
        // Of nothing it would be the identity, which nobody said.
        [first] if first.is_composite() => return Err(ItkError::Empty),
        [first, rest @ ..] if first.is_composite() => {
            first.without_numbers()?;
            (true, rest)
        }
        parts => (false, parts),
    };
    if !composite && parts.len() > 1 {
        return Err(ItkError::Several { found: parts.len() });
    }
    let mut whole = Rigid::<Named, Named>::identity();
    let mut file = Affine::<Named, Named>::from_rows(IDENTITY);
    let mut most_off = 0.0_f64;
    for (part, number) in parts.iter().zip(1..) {
        let taken = part.rigid(number)?;
        // The last of a composite is applied to a point first.
        (whole, file) = (whole * taken.rigid, file * taken.file);
        most_off = most_off.max(taken.off);
    }
    // What is a little off in each of many parts is far off in all of them.
    let off = of_whole(&file)?;
    most_off = most_off.max(off);
    let [x, y, z] = whole.translation_mm();
    // Centres and translations, each of which may be, can add up to what may not.
    if let Some(found) = [x, y, z].iter().find(|c| !is_allowed(**c)) {
        return Err(ItkError::Number {
            part: parts.len(),
            kind: "with its centre and those before it".to_owned(),
            found: found.to_string(),
        });
    }
    Ok(Transform {
        to_from_from: Rigid::from_parts(whole.rotation(), Vector::new(x, y, z)),
        file: Affine::from_rows(file.rows()),
        kinds: parts.iter().map(|part| part.kind.clone()).collect(),
        most_off,
    })
}

/// How far all of it is from a rigid transform; refused where that is too far.
fn of_whole(file: &Affine<Named, Named>) -> Result<f64, ItkError> {
    let rows = file.rows().map(|[x, y, z, _]| [x, y, z]);
    let columns = stretches(file);
    let nearest = RotationMatrix::nearest(rows).map_err(|_| ItkError::Composite {
        off: f64::INFINITY,
        columns,
    })?;
    match nearest.distance <= MOST_OFF {
        true => Ok(nearest.distance),
        false => Err(ItkError::Composite {
            off: nearest.distance,
            columns,
        }),
    }
}

fn of_text(bytes: &[u8]) -> Result<Vec<Part>, ItkError> {
    let mut parts: Vec<Part> = Vec::new();
    for (line, number) in bytes.split(|byte| *byte == b'\n').zip(1..) {
        let not_text = || {
            let found = quoted(&String::from_utf8_lossy(&line[..line.len().min(64)]));
            ItkError::Line {
                line: number,
                found,
                expected: "text",
            }
        };
        let text = if number == 1 {
            ""
        } else {
            str::from_utf8(line).map_err(|_| not_text())?.trim()
        };
        if number == 1 {
            let head = String::from_utf8_lossy(&line[..line.len().min(64)]);
            if head.trim_end() != HEAD {
                return Err(ItkError::Head { found: quoted(&head) });
            }
        } else if !text.is_empty() && !text.starts_with('#') {
            take(&mut parts, number, text)?;
        }
    }
    Ok(parts)
}

/// One line that is neither empty nor a comment.
fn take(parts: &mut Vec<Part>, line: usize, text: &str) -> Result<(), ItkError> {
    let refused = |expected| {
        Err(ItkError::Line {
            line,
            found: quoted(text),
            expected,
        })
    };
    let Some((key, value)) = text.split_once(':') else {
        return refused("Transform:, Parameters: or FixedParameters:");
    };
    if key == "Transform" {
        if parts.len() > MAX_PARTS {
            return Err(ItkError::TooMany);
        }
        let kind = value.trim().to_owned();
        let part = Part {
            kind,
            ..Part::default()
        };
        // At once: the parameters of a deformation may be millions.
        let place = if parts.first().is_some_and(Part::is_composite) {
            parts.len()
        } else {
            parts.len() + 1
        };
        part.known(place)?;
        if part.is_composite() && !parts.is_empty() {
            return refused("a composite as the first transform alone");
        }
        parts.push(part);
        return Ok(());
    }
    let Some(part) = parts.last_mut() else {
        return refused("Transform: before its numbers");
    };
    let place = match key {
        "Parameters" => &mut part.parameters,
        "FixedParameters" => &mut part.fixed,
        _ => return refused("Transform:, Parameters: or FixedParameters:"),
    };
    if !place.is_empty() {
        return refused("the numbers of a transform once");
    }
    for word in value.split_ascii_whitespace() {
        match word.parse::<f64>() {
            Ok(number) if place.len() < MOST_NUMBERS => place.push(number),
            Ok(_) => return refused("at most 16 numbers"),
            Err(_) => return refused("numbers"),
        }
    }
    Ok(())
}
