//! Poses on the wire: a matrix of twelve numbers, or a place with a quaternion.
//!
//! A TRANSFORM `AToB` maps places in `A` to places in `B`, in millimetres. The protocol does not say which frames these
//! are; patients are RAS (x to the right, y to the front, z to the head). Numbers stay here as they stand on the wire:
//! nothing is made a rotation that is none ([`crate::rotation`] measures it), and nothing is turned ([`crate::frame`]
//! does it).

use crate::fault::Fault;
use crate::fields::Fields;
use crate::malformed::Refusal;
use crate::wire::{Reader, put_reals};

/// The upper three rows of a matrix of a TRANSFORM or TDATA, column by column as on the wire.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Matrix {
    /// The three columns of its linear part; for an IMAGE their lengths are the voxel's in mm.
    pub columns: [[f32; 3]; 3],
    /// Its last column, mm.
    pub translation: [f32; 3],
}

impl Matrix {
    /// No motion.
    pub const IDENTITY: Self = Self {
        columns: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        translation: [0.0; 3],
    };

    /// Its three rows of four, as a person writes them.
    pub fn rows(&self) -> [[f32; 4]; 3] {
        let ([x, y, z], t) = (self.columns, self.translation);
        [0, 1, 2].map(|row| [x[row], y[row], z[row], t[row]])
    }

    /// Of three rows of four.
    pub fn from_rows(rows: [[f32; 4]; 3]) -> Self {
        let column = |c: usize| [rows[0][c], rows[1][c], rows[2][c]];
        Self {
            columns: [column(0), column(1), column(2)],
            translation: column(3),
        }
    }

    pub(crate) fn read(reader: &mut Reader<'_>) -> Result<Self, Refusal> {
        let field = "a matrix";
        Ok(Self {
            columns: [reader.reals(field)?, reader.reals(field)?, reader.reals(field)?],
            translation: reader.reals(field)?,
        })
    }

    pub(crate) fn write(&self, out: &mut Vec<u8>) -> Result<(), Fault> {
        put_reals(out, self.columns.as_flattened(), "a matrix")?;
        put_reals(out, &self.translation, "a matrix")
    }

    pub(crate) fn fields(&self, prefix: &str, fields: &mut Fields) {
        for (row, numbers) in self.rows().iter().enumerate() {
            fields.add(format!("{prefix}row{}", row + 1), &numbers[..]);
        }
    }
}

/// A quaternion `x y z w` with `w` last, as on the wire. It should be of length 1; not every sender's is.
pub type Quaternion = [f32; 4];

/// The quaternion of a POSITION, which may be left out or shortened.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Orientation {
    /// Not sent: a content of 12 bytes.
    None,
    /// `x y z` alone, of a quaternion whose `w` is not negative: 24 bytes.
    Short([f32; 3]),
    /// `x y z w`: 28 bytes.
    Full(Quaternion),
}

/// A place with an orientation: POSITION, or by its other name QTRANS.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Position {
    /// Millimetres.
    pub place: [f32; 3],
    /// The orientation.
    pub orientation: Orientation,
}

impl Position {
    /// Contents that a POSITION may have.
    pub(crate) const SIZES: &[u64] = &[12, 24, 28];

    pub(crate) fn read(reader: &mut Reader<'_>) -> Result<Self, Refusal> {
        reader.sized(crate::fault::SizeRule::OneOf(Self::SIZES))?;
        let place = reader.reals("a place")?;
        let orientation = match reader.left() {
            0 => Orientation::None,
            12 => Orientation::Short(reader.reals("a quaternion")?),
            _ => Orientation::Full(reader.reals("a quaternion")?),
        };
        Ok(Self { place, orientation })
    }

    pub(crate) fn write(&self, out: &mut Vec<u8>) -> Result<(), Fault> {
        put_reals(out, &self.place, "a place")?;
        match self.orientation {
            Orientation::None => Ok(()),
            Orientation::Short(part) => put_reals(out, &part, "a quaternion"),
            Orientation::Full(whole) => put_reals(out, &whole, "a quaternion"),
        }
    }

    pub(crate) fn fields(&self, fields: &mut Fields) {
        fields.add("place_mm", &self.place[..]);
        match &self.orientation {
            Orientation::None => {}
            Orientation::Short(part) => fields.add("quaternion_xyz", &part[..]),
            Orientation::Full(whole) => fields.add("quaternion_xyzw", &whole[..]),
        }
    }
}
