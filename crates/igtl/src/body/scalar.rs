//! What a voxel is made of.

use crate::fault::Fault;
use crate::malformed::Refusal;
use crate::wire::Reader;

/// The type of a component of a voxel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Scalar {
    /// 8 bits with a sign.
    Int8,
    /// 8 bits.
    Uint8,
    /// 16 bits with a sign.
    Int16,
    /// 16 bits.
    Uint16,
    /// 32 bits with a sign.
    Int32,
    /// 32 bits.
    Uint32,
    /// Single precision.
    Float32,
    /// Double precision.
    Float64,
}

impl Scalar {
    /// All of them.
    pub const ALL: [Self; 8] = [
        Self::Int8,
        Self::Uint8,
        Self::Int16,
        Self::Uint16,
        Self::Int32,
        Self::Uint32,
        Self::Float32,
        Self::Float64,
    ];

    /// The number on the wire.
    pub const fn number(self) -> u8 {
        match self {
            Self::Int8 => 2,
            Self::Uint8 => 3,
            Self::Int16 => 4,
            Self::Uint16 => 5,
            Self::Int32 => 6,
            Self::Uint32 => 7,
            Self::Float32 => 10,
            Self::Float64 => 11,
        }
    }

    /// Its bytes.
    pub const fn bytes(self) -> u8 {
        match self {
            Self::Int8 | Self::Uint8 => 1,
            Self::Int16 | Self::Uint16 => 2,
            Self::Int32 | Self::Uint32 | Self::Float32 => 4,
            Self::Float64 => 8,
        }
    }

    /// In a word.
    pub const fn word(self) -> &'static str {
        match self {
            Self::Int8 => "int8",
            Self::Uint8 => "uint8",
            Self::Int16 => "int16",
            Self::Uint16 => "uint16",
            Self::Int32 => "int32",
            Self::Uint32 => "uint32",
            Self::Float32 => "float32",
            Self::Float64 => "float64",
        }
    }

    pub(crate) fn read(reader: &mut Reader<'_>) -> Result<Self, Refusal> {
        let before = reader.clone();
        let found = reader.u8()?;
        let scalar = Self::ALL.into_iter().find(|scalar| scalar.number() == found);
        scalar.ok_or_else(|| {
            before.refuse(Fault::Value {
                field: "the type of a voxel",
                found: found.into(),
                allowed: "2 to 7, 10 and 11",
            })
        })
    }
}
