//! IMAGE: a grid of voxels, or a box of one. 72 bytes of header and the voxels.
//!
//! | bytes | what |
//! |---|---|
//! | 0..2 | version of this header, 1 |
//! | 2, 3 | components of a voxel; their [`Scalar`] |
//! | 4, 5 | byte order of the voxels, 1 big or 2 little; space, 1 RAS or 2 LPS |
//! | 6..12 | voxels along i, j, k |
//! | 12..48 | the steps of i, j, k in mm, as vectors: their lengths are the voxel's |
//! | 48..60 | the middle of the whole image, mm |
//! | 60..72 | first voxel and size of the box that is sent |
//!
//! The middle is that of the centres of the voxels, `(n - 1) / 2` steps from the first along each axis; 3D Slicer and
//! pyigtl agree on it. The flag of the space says what its sender wrote: Slicer and the C++ library take every image
//! for RAS, pyigtl says LPS unless told otherwise. Who receives an image must know its sender.

use std::borrow::Cow;

use super::pose::Matrix;
use super::scalar::Scalar;
use crate::fault::{Fault, SizeRule};
use crate::fields::Fields;
use crate::malformed::Refusal;
use crate::wire::{Reader, long, put_u16s};

const IMAGE_BYTES: u64 = 72;

/// The order of the bytes of a voxel's component.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ByteOrder {
    /// The highest byte first.
    Big,
    /// The lowest byte first.
    Little,
}

/// The patient axes that an image's sender states.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Space {
    /// x to the right, y to the front, z to the head.
    Ras,
    /// x to the left, y to the back, z to the head.
    Lps,
}

/// An image, or a box of one, with its voxels where they lie.
#[derive(Debug, Clone, PartialEq)]
pub struct Image<'a> {
    /// Components of a voxel, interleaved; 1 for grey.
    pub components: u8,
    /// What a component is.
    pub scalar: Scalar,
    /// The order of its bytes.
    pub order: ByteOrder,
    /// What the sender says of its axes.
    pub space: Space,
    /// Voxels along i, j, k of the whole image.
    pub dimensions: [u16; 3],
    /// The steps of i, j, k in mm as columns, and the middle of the whole image in mm, in `space`.
    pub placed: Matrix,
    /// The first voxel of the box.
    pub offset: [u16; 3],
    /// The voxels of the box along i, j, k.
    pub size: [u16; 3],
    /// The voxels of the box, i fastest, as they stand on the wire. They are counted, not looked at: those of floats
    /// may be NaN.
    pub voxels: Cow<'a, [u8]>,
}

impl<'a> Image<'a> {
    /// Where the first voxel of the whole image has its centre, mm, in [`Image::space`].
    pub fn origin(&self) -> [f64; 3] {
        let half = self.dimensions.map(|count| (f64::from(count) - 1.0) / 2.0);
        let [i, j, k] = self.placed.columns;
        [0, 1, 2].map(|axis| {
            let steps = f64::from(i[axis]) * half[0] + f64::from(j[axis]) * half[1] + f64::from(k[axis]) * half[2];
            f64::from(self.placed.translation[axis]) - steps
        })
    }

    /// Bytes of the box; `None` where that number is beyond all limits.
    fn bytes(&self) -> Option<u64> {
        let [i, j, k] = self.size.map(u64::from);
        let voxel = u64::from(self.components) * u64::from(self.scalar.bytes());
        i.checked_mul(j)?.checked_mul(k)?.checked_mul(voxel)
    }

    /// What must hold of any image, read or to be written.
    fn check(&self) -> Result<(), Fault> {
        if self.components == 0 {
            return Err(Fault::Value {
                field: "the number of components",
                found: 0,
                allowed: "1 to 255",
            });
        }
        if self.dimensions.contains(&0) {
            return Err(Fault::Dimensions(self.dimensions));
        }
        let ends = self
            .offset
            .iter()
            .zip(self.size)
            .map(|(o, s)| u32::from(*o) + u32::from(s));
        let inside = ends.zip(self.dimensions).all(|(end, whole)| end <= whole.into());
        if self.size.contains(&0) || !inside {
            return Err(Fault::Subvolume {
                offset: self.offset,
                size: self.size,
                dimensions: self.dimensions,
            });
        }
        let needed = self.bytes().map_or(u64::MAX, |bytes| bytes.saturating_add(IMAGE_BYTES));
        let found = long(self.voxels.len()) + IMAGE_BYTES;
        if found == needed {
            return Ok(());
        }
        Err(Fault::Size {
            found,
            rule: SizeRule::Exactly(needed),
        })
    }

    pub(crate) fn read(reader: &mut Reader<'a>) -> Result<Self, Refusal> {
        reader.sized(SizeRule::AtLeast(IMAGE_BYTES))?;
        let whole = reader.clone();
        one_of(reader, "the version of the image header", "1", |n| {
            (n == [0, 1]).then_some(())
        })?;
        let components = reader.u8()?;
        let scalar = Scalar::read(reader)?;
        let order = one_of(reader, "the byte order of the voxels", "1 and 2", |[n]| match n {
            1 => Some(ByteOrder::Big),
            2 => Some(ByteOrder::Little),
            _ => None,
        })?;
        let space = one_of(reader, "the space of the image", "1 and 2", |[n]| match n {
            1 => Some(Space::Ras),
            2 => Some(Space::Lps),
            _ => None,
        })?;
        let image = Self {
            components,
            scalar,
            order,
            space,
            dimensions: reader.u16s()?,
            placed: Matrix::read(reader)?,
            offset: reader.u16s()?,
            size: reader.u16s()?,
            voxels: Cow::Borrowed(reader.rest()),
        };
        image.check().map_err(|fault| whole.refuse(fault))?;
        Ok(image)
    }

    /// Its header alone: the voxels are sent from where they lie.
    pub(crate) fn write_header(&self, out: &mut Vec<u8>) -> Result<(), Fault> {
        self.check()?;
        let order = match self.order {
            ByteOrder::Big => 1,
            ByteOrder::Little => 2,
        };
        let space = match self.space {
            Space::Ras => 1,
            Space::Lps => 2,
        };
        out.extend([0, 1, self.components, self.scalar.number(), order, space]);
        put_u16s(out, &self.dimensions);
        self.placed.write(out)?;
        put_u16s(out, &self.offset);
        put_u16s(out, &self.size);
        Ok(())
    }

    /// With voxels of its own.
    pub fn into_owned(self) -> Image<'static> {
        Image {
            components: self.components,
            scalar: self.scalar,
            order: self.order,
            space: self.space,
            dimensions: self.dimensions,
            placed: self.placed,
            offset: self.offset,
            size: self.size,
            voxels: Cow::Owned(self.voxels.into_owned()),
        }
    }

    pub(crate) fn fields(&self, fields: &mut Fields) {
        fields.add("components", self.components);
        fields.add("scalar", self.scalar.word());
        fields.add(
            "byte_order",
            if self.order == ByteOrder::Big { "big" } else { "little" },
        );
        fields.add("space", if self.space == Space::Ras { "RAS" } else { "LPS" });
        fields.add("voxels", &self.dimensions[..]);
        for (name, column) in ["step_i_mm", "step_j_mm", "step_k_mm"]
            .into_iter()
            .zip(&self.placed.columns)
        {
            fields.add(name, &column[..]);
        }
        fields.add("middle_mm", &self.placed.translation[..]);
        fields.add("first_voxel_mm", &self.origin()[..]);
        fields.add("box_offset", &self.offset[..]);
        fields.add("box_voxels", &self.size[..]);
        fields.add("voxel_bytes", self.voxels.len());
    }
}

/// A number of one or two bytes of which a few alone mean something.
fn one_of<T, const N: usize>(
    reader: &mut Reader<'_>,
    field: &'static str,
    allowed: &'static str,
    meaning: impl Fn([u8; N]) -> Option<T>,
) -> Result<T, Refusal> {
    let before = reader.clone();
    let bytes = reader.array::<N>()?;
    meaning(bytes).ok_or_else(|| {
        let found = bytes.iter().fold(0, |number, byte| number << 8 | u64::from(*byte));
        before.refuse(Fault::Value { field, found, allowed })
    })
}
