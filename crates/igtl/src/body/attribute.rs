//! Numbers at the points or cells of a POLYDATA.
//!
//! The C++ library (3.x) is at one with the protocol about scalars, vectors, normals and tensors at points. Colours,
//! texture coordinates and whatever belongs to cells it writes and reads with nine numbers each, as if they were
//! tensors, and fills up what it does not have with what lies in its memory. Such vectors, normals and colours are
//! refused here by their number of components; and who sends to that library does well to send it the first four kinds
//! at points alone.

use crate::fault::Fault;
use crate::fields::Fields;
use crate::limits::Limits;
use crate::malformed::Refusal;
use crate::name::shown;
use crate::wire::{Reader, counted, long, put_reals};

const HEAD_BYTES: u64 = 6;
/// The longest name that the C++ library reads.
const MOST_NAME: u64 = 255;
/// Attributes at cells have this bit beside their kind.
const OF_CELLS: u8 = 0x10;

/// What the numbers of an attribute are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AttributeKind {
    /// Any number of components.
    Scalars,
    /// Three.
    Vectors,
    /// Three.
    Normals,
    /// Nine.
    Tensors,
    /// Four: a colour.
    Rgba,
    /// Coordinates of a texture, any number of components.
    Texture,
}

impl AttributeKind {
    const ALL: [(Self, u8, &'static str); 6] = [
        (Self::Scalars, 0, "scalars"),
        (Self::Vectors, 1, "vectors"),
        (Self::Normals, 2, "normals"),
        (Self::Tensors, 3, "tensors"),
        (Self::Rgba, 4, "RGBA"),
        (Self::Texture, 5, "texture"),
    ];

    const fn components(self) -> Option<u8> {
        match self {
            Self::Scalars | Self::Texture => None,
            Self::Vectors | Self::Normals => Some(3),
            Self::Tensors => Some(9),
            Self::Rgba => Some(4),
        }
    }

    fn row(self) -> (u8, &'static str) {
        let row = Self::ALL.into_iter().find(|(kind, ..)| *kind == self);
        row.map_or((0, "scalars"), |(_, number, word)| (number, word))
    }
}

/// An attribute: `components` numbers for each of some points or cells.
#[derive(Debug, Clone, PartialEq)]
pub struct Attribute {
    /// What its numbers are.
    pub kind: AttributeKind,
    /// Whether they belong to cells; else to points.
    pub of_cells: bool,
    /// How many for each; a multiple of it are in `values`.
    pub components: u8,
    /// Its name, without a zero.
    pub name: Vec<u8>,
    /// The numbers.
    pub values: Vec<f32>,
}

/// What stands before the names.
struct Head {
    kind: AttributeKind,
    of_cells: bool,
    components: u8,
    count: u32,
}

impl Attribute {
    /// What must hold of any, read or to be written.
    fn check(kind: AttributeKind, components: u8) -> Result<(), Fault> {
        let needed = kind.components();
        if components == 0 || needed.is_some_and(|needed| needed != components) {
            return Err(Fault::Value {
                field: "the components of an attribute",
                found: components.into(),
                allowed: "3 of a vector or normal, 9 of a tensor, 4 of a colour, else 1 or more",
            });
        }
        Ok(())
    }

    pub(crate) fn read_all(reader: &mut Reader<'_>, count: u32, limits: &Limits) -> Result<Vec<Self>, Refusal> {
        // An attribute without a value is seven bytes on the wire and ten times that here: their number needs a bound
        // of its own.
        if count > limits.elements {
            return Err(reader.refuse(Fault::TooMany {
                what: "attributes",
                found: count.into(),
                most: limits.elements.into(),
            }));
        }
        let at = reader.at();
        let mut heads = Reader::new(reader.take(u64::from(count) * HEAD_BYTES)?, at);
        let mut attributes = Vec::new();
        let mut sizes = Vec::new();
        let mut names_bytes = 0;
        while heads.left() > 0 {
            let head = read_head(&mut heads)?;
            let name = read_name(reader)?;
            names_bytes += long(name.len()) + 1;
            sizes.push(head.count);
            attributes.push(Self {
                kind: head.kind,
                of_cells: head.of_cells,
                components: head.components,
                name: name.to_vec(),
                values: Vec::new(),
            });
        }
        reader.take(names_bytes % 2)?;
        for (attribute, count) in attributes.iter_mut().zip(sizes) {
            attribute.values = read_values(reader, u64::from(count) * u64::from(attribute.components))?;
        }
        Ok(attributes)
    }

    pub(crate) fn write_all(attributes: &[Self], out: &mut Vec<u8>) -> Result<(), Fault> {
        for attribute in attributes {
            Self::check(attribute.kind, attribute.components)?;
            let rule = crate::fault::SizeRule::MultipleOf(attribute.components.into());
            let found = long(attribute.values.len());
            if !rule.admits(found) {
                return Err(Fault::Size { found, rule });
            }
            let count = attribute.values.len() / usize::from(attribute.components);
            let count: u32 = counted(count, "values of an attribute", u32::MAX.into())?;
            let at = if attribute.of_cells { OF_CELLS } else { 0 };
            out.extend([attribute.kind.row().0 | at, attribute.components]);
            out.extend(count.to_be_bytes());
        }
        let before = out.len();
        for attribute in attributes {
            check_name(&attribute.name)?;
            out.extend(&attribute.name);
            out.push(0);
        }
        if !(out.len() - before).is_multiple_of(2) {
            out.push(0);
        }
        attributes
            .iter()
            .try_for_each(|attribute| put_reals(out, &attribute.values, "an attribute"))
    }

    pub(crate) fn fields(&self, prefix: &str, fields: &mut Fields) {
        fields.add(format!("{prefix}name"), shown(&self.name));
        fields.add(format!("{prefix}kind"), self.kind.row().1);
        fields.add(format!("{prefix}of"), if self.of_cells { "cells" } else { "points" });
        fields.add(format!("{prefix}components"), self.components);
        fields.add(format!("{prefix}values"), self.values.len());
    }
}

fn check_name(name: &[u8]) -> Result<(), Fault> {
    let found = long(name.len());
    if found > MOST_NAME {
        return Err(Fault::TextLength {
            found,
            allowed: MOST_NAME,
        });
    }
    match name.iter().find(|byte| byte.is_ascii_control()) {
        None => Ok(()),
        Some(byte) => Err(Fault::NameByte {
            field: "the name of an attribute",
            byte: *byte,
            allowed: "anything but control characters",
        }),
    }
}

fn read_head(heads: &mut Reader<'_>) -> Result<Head, Refusal> {
    let before = heads.clone();
    let (number, components, count) = (heads.u8()?, heads.u8()?, heads.u32()?);
    let kind = AttributeKind::ALL
        .into_iter()
        .find(|(_, row, _)| *row == number & !OF_CELLS);
    let Some((kind, ..)) = kind else {
        return Err(before.refuse(Fault::Value {
            field: "the kind of an attribute",
            found: number.into(),
            allowed: "0 to 5, at cells 16 to 21",
        }));
    };
    Attribute::check(kind, components).map_err(|fault| before.refuse(fault))?;
    Ok(Head {
        kind,
        of_cells: number & OF_CELLS != 0,
        components,
        count,
    })
}

/// The bytes up to the next zero, which is read with them.
fn read_name<'a>(reader: &mut Reader<'a>) -> Result<&'a [u8], Refusal> {
    let before = reader.clone();
    let length = before.clone().rest().iter().position(|byte| *byte == 0);
    let Some(length) = length else {
        return Err(before.refuse(Fault::TextLength {
            found: before.left(),
            allowed: MOST_NAME,
        }));
    };
    let name = reader.take(long(length))?;
    check_name(name).map_err(|fault| before.refuse(fault))?;
    reader.u8()?;
    Ok(name)
}

fn read_values(reader: &mut Reader<'_>, count: u64) -> Result<Vec<f32>, Refusal> {
    let at = reader.at();
    let mut numbers = Reader::new(reader.take(count.saturating_mul(4))?, at);
    let mut values = Vec::with_capacity(usize::try_from(numbers.left() / 4).unwrap_or_default());
    while numbers.left() > 0 {
        values.push(numbers.real("an attribute")?);
    }
    Ok(values)
}
