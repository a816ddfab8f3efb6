//! PLY: a head that says what follows, as text or binary.

use super::MeshError;
use super::bytes::{Bytes, Scalar, corner};
use super::raw::{Raw, counted};
use super::words::Words;

/// Most elements and properties of a head: more than any writer's.
const MOST: usize = 64;
/// Most corners of a polygon.
const MOST_CORNERS: f64 = 1024.0;

/// How numbers are written.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Coding {
    Text,
    Binary { is_big: bool },
}

/// A number, or a list of them behind its length.
struct Property {
    name: String,
    length: Option<Scalar>,
    of: Scalar,
}

struct Element {
    name: String,
    count: usize,
    properties: Vec<Property>,
}

/// Where numbers come from.
enum Numbers<'a> {
    Text(Words<'a>),
    Binary(Bytes<'a>),
}

pub(super) fn read(bytes: &[u8]) -> Result<Raw, MeshError> {
    let mut raw = Raw::default();
    let mut words = Words::new(bytes, 1);
    words.expect("ply")?;
    words.line();
    let (coding, elements) = head(&mut words, &mut raw)?;
    // Before anything is held: each record takes at least a byte, or two of text.
    let least: u64 = elements
        .iter()
        .map(|element| element.least(coding))
        .fold(0, u64::saturating_add);
    let left = words.rest().len();
    if least > left as u64 {
        return Err(MeshError::CutOff {
            what: "the elements",
            needed: least,
            left,
        });
    }
    let mut numbers = match coding {
        Coding::Text => Numbers::Text(words),
        Coding::Binary { is_big } => Numbers::Binary(Bytes {
            rest: words.rest(),
            is_big,
        }),
    };
    for element in &elements {
        element.read(&mut numbers, &mut raw)?;
    }
    match &mut numbers {
        Numbers::Text(words) => match words.next() {
            b"" => Ok(raw),
            found => Err(words.refused(found, "the end of the file")),
        },
        Numbers::Binary(bytes) if bytes.rest.is_empty() => Ok(raw),
        Numbers::Binary(bytes) => Err(MeshError::TooMuch { left: bytes.rest.len() }),
    }
}

fn head(words: &mut Words<'_>, raw: &mut Raw) -> Result<(Coding, Vec<Element>), MeshError> {
    let mut coding = None;
    let mut elements: Vec<Element> = Vec::new();
    loop {
        match words.next() {
            b"format" => {
                let found = words.next();
                coding = Some(match found {
                    b"ascii" => Coding::Text,
                    b"binary_little_endian" => Coding::Binary { is_big: false },
                    b"binary_big_endian" => Coding::Binary { is_big: true },
                    _ => return Err(words.refused(found, "ascii, binary_little_endian or binary_big_endian")),
                });
                words.expect("1.0")?;
            }
            b"comment" | b"obj_info" => raw.comment(&String::from_utf8_lossy(words.line()))?,
            b"element" if elements.len() < MOST => {
                let name = String::from_utf8_lossy(words.next()).into_owned();
                let count = counted("elements", words.number("how many there are")?)?;
                elements.push(Element {
                    name,
                    count,
                    properties: Vec::new(),
                });
            }
            b"property" => match elements.last_mut() {
                Some(element) if element.properties.len() < MOST => element.properties.push(property(words)?),
                _ => return Err(words.refused(b"property", "an element before it, with at most 64 properties")),
            },
            b"end_header" => {
                // What follows begins behind the end of this line: its first byte may look like a blank.
                let left = words.rest();
                let end = left
                    .iter()
                    .position(|byte| *byte == b'\n')
                    .map_or(left.len(), |end| end + 1);
                words.skip(end);
                let coding = coding.ok_or_else(|| words.refused(b"end_header", "a format before it"))?;
                return Ok((coding, elements));
            }
            found => return Err(words.refused(found, "format, comment, element (at most 64), property or end_header")),
        }
    }
}

fn property(words: &mut Words<'_>) -> Result<Property, MeshError> {
    let first = words.next();
    let is_list = first == b"list";
    let length = if is_list { Some(scalar(words, None)?) } else { None };
    if let Some(length) = length
        && !length.is_whole()
    {
        return Err(words.refused(first, "a list whose length is a whole number"));
    }
    let of = scalar(words, (!is_list).then_some(first))?;
    let name = String::from_utf8_lossy(words.next()).into_owned();
    Ok(Property { name, length, of })
}

fn scalar(words: &mut Words<'_>, word: Option<&[u8]>) -> Result<Scalar, MeshError> {
    let word = word.unwrap_or_else(|| words.next());
    Ok(match word {
        b"char" | b"int8" => Scalar::I8,
        b"uchar" | b"uint8" => Scalar::U8,
        b"short" | b"int16" => Scalar::I16,
        b"ushort" | b"uint16" => Scalar::U16,
        b"int" | b"int32" => Scalar::I32,
        b"uint" | b"uint32" => Scalar::U32,
        b"float" | b"float32" => Scalar::F32,
        b"double" | b"float64" => Scalar::F64,
        _ => return Err(words.refused(word, "the type of a number")),
    })
}

impl Element {
    /// The fewest bytes that its records take.
    fn least(&self, coding: Coding) -> u64 {
        let of = |property: &Property| match (coding, property.length) {
            (Coding::Text, _) => 1,
            (Coding::Binary { .. }, Some(length)) => length.size(),
            (Coding::Binary { .. }, None) => property.of.size(),
        };
        let record: u64 = self.properties.iter().map(of).sum();
        // An element without properties is a promise that costs nothing.
        (self.count as u64).saturating_mul(record.max(u64::from(self.count > 0)))
    }

    fn read(&self, numbers: &mut Numbers<'_>, raw: &mut Raw) -> Result<(), MeshError> {
        let place = |name: &str| {
            self.properties
                .iter()
                .position(|p| p.name == name && p.length.is_none())
        };
        let coordinates = match self.name.as_str() {
            "vertex" => {
                let places = [place("x"), place("y"), place("z")];
                let missing = || MeshError::Head {
                    found: "a vertex without x, y, z".to_owned(),
                    expected: "all three",
                };
                let [Some(x), Some(y), Some(z)] = places else {
                    return Err(missing());
                };
                Some([x, y, z])
            }
            _ => None,
        };
        let is_corners = |p: &Property| self.name == "face" && p.length.is_some() && p.name.starts_with("vertex_ind");
        if self.name == "face" && !self.properties.iter().any(is_corners) {
            let found = "a face without vertex_indices".to_owned();
            return Err(MeshError::Head {
                found,
                expected: "its corners",
            });
        }
        // Single precision has no whole numbers beyond 2^24, and a text may say 1.5.
        if let Some(corners) = self.properties.iter().find(|p| is_corners(p) && !p.of.is_whole()) {
            return Err(MeshError::Head {
                found: format!("{} of numbers with fractions", crate::quoted(&corners.name)),
                expected: "whole numbers as corners",
            });
        }
        if matches!(self.name.as_str(), "tristrips" | "strip") && self.count > 0 {
            let what = "strips of triangles".to_owned();
            return Err(MeshError::Unread {
                what,
                instead: "save the surface as triangles",
            });
        }
        for record in 1..=self.count {
            let mut found = [0.0; MOST];
            for (property, at) in self.properties.iter().zip(0..) {
                match property.length {
                    None => found[at] = numbers.next(property.of)?,
                    Some(length) => {
                        let list = numbers.list(length, property.of)?;
                        if is_corners(property) {
                            let corners = list.iter().map(|number| corner(*number, record));
                            raw.polygon(record, &corners.collect::<Result<Vec<u32>, _>>()?)?;
                        }
                    }
                }
            }
            if let Some(places) = coordinates {
                raw.points.push(places.map(|at| found[at]));
            }
        }
        Ok(())
    }
}

impl Numbers<'_> {
    fn next(&mut self, of: Scalar) -> Result<f64, MeshError> {
        match self {
            Self::Text(words) => words.number("a number"),
            Self::Binary(bytes) => bytes.number("an element", of),
        }
    }

    /// A list behind its length. Other lists than corners, texture coordinates, may hold any number.
    fn list(&mut self, length: Scalar, of: Scalar) -> Result<Vec<f64>, MeshError> {
        let count = self.next(length)?;
        if !(0.0..=MOST_CORNERS).contains(&count) {
            let found = format!("a list of {count}");
            return Err(MeshError::Head {
                found,
                expected: "at most 1024 numbers",
            });
        }
        (0..count as usize).map(|_| self.next(of)).collect()
    }
}
