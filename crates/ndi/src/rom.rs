//! Tool definitions (.rom), checked before they are written to a device: one wrong file makes every pose NaN.
//!
//! There is no public standard; the layout is the one that tools of several makers share, and their checksums agree
//! with it. 752 bytes, little endian: `NDI` and 0; u16 sum of all bytes from 6 on; 24 largest angle, degrees; 28 number
//! of markers; 32 fewest for a pose; 36 largest error, f32 mm; 72 places, 312 normals, 3 f32 each; 580 maker, 592 part.

mod shape;

pub use shape::Shape;

use crate::fault::shown;
use crate::pose::{PoseError, check_place};

/// The length of a definition.
pub(crate) const BYTES: usize = 752;
/// Bytes of a piece of it, as PVWR takes them.
pub(crate) const PIECE: usize = 64;
/// Markers of a simulated tool are seen from so far to the side, degrees.
const WIDEST_DEG: u8 = 90;
/// The most markers of a tool.
pub const MOST_MARKERS: u8 = 20;

/// A tool definition that may be written to a device.
#[derive(Debug, Clone, PartialEq)]
pub struct Rom {
    bytes: Box<[u8; BYTES]>,
    /// Who made the tool; at most 12 characters.
    pub maker: String,
    /// Its part number; at most 20 characters.
    pub part: String,
    /// Places of its markers in its own frame, mm.
    pub markers_mm: Vec<[f64; 3]>,
    /// How many must be seen for a pose.
    pub least_markers: u8,
    /// The largest distance of a marker from its place, mm.
    pub most_error_mm: f64,
    /// Whether its poses have all six degrees of freedom.
    pub shape: Shape,
}

/// Why a file is no definition, or is none that should be written. Bytes count from 0.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RomError {
    /// Cut off, padded, or of another kind.
    #[error("{found} bytes; a tool definition has 752")]
    Length {
        /// Its bytes.
        found: usize,
    },
    /// Another kind of file.
    #[error("it begins with {found:?}; a tool definition begins with \"NDI\" and 0")]
    Foreign {
        /// Its first four bytes.
        found: String,
    },
    /// A damaged file.
    #[error("byte 4: the sum of the bytes is {computed:#06x}; the file says {found:#06x}")]
    Checksum {
        /// In the file.
        found: u16,
        /// Of its bytes.
        computed: u16,
    },
    /// No marker, or more than a tool has.
    #[error("byte 28: {found} markers; allowed are 3 to 20")]
    MarkerCount {
        /// In the file.
        found: u8,
    },
    /// More markers are needed than there are, or too few for a pose.
    #[error("byte 32: a pose needs {found} markers; allowed are 3 to {markers}")]
    LeastMarkers {
        /// In the file.
        found: u8,
        /// The tool's.
        markers: u8,
    },
    /// A number that is none, or a place that no tool has.
    #[error("byte {byte}: {error}")]
    Number {
        /// Where.
        byte: usize,
        /// What is wrong.
        error: PoseError,
    },
    /// An error that no pose can keep.
    #[error("byte 36: a largest error of {found_mm} mm; it must be above 0")]
    MostError {
        /// In the file, mm.
        found_mm: f64,
    },
    /// Two markers in one place.
    #[error("markers {first} and {second} are {found_mm} mm apart; they must be at least 1 mm")]
    Together {
        /// From 0.
        first: usize,
        /// From 0.
        second: usize,
        /// How far apart, mm.
        found_mm: f64,
    },
    /// All markers on a line: the turn about it is seen by nobody.
    #[error("the markers lie within {found_mm} mm of one line: the turn about it cannot be seen")]
    Collinear {
        /// The largest distance from it, mm.
        found_mm: f64,
    },
}

impl Rom {
    /// Reads a definition and checks all of it but whether its markers lie on a line, which [`Rom::checked`] refuses:
    /// there are tools made so, for a direction without the turn about it.
    ///
    /// # Errors
    /// The first thing that is wrong.
    pub fn parse(bytes: &[u8]) -> Result<Self, RomError> {
        let found = bytes.len();
        let bytes: &[u8; BYTES] = bytes.try_into().map_err(|_| RomError::Length { found })?;
        check_head(bytes)?;
        let count = byte(bytes, 28);
        if !(3..=MOST_MARKERS).contains(&count) {
            return Err(RomError::MarkerCount { found: count });
        }
        let markers_mm = (0..usize::from(count))
            .map(|marker| place(bytes, 72 + 12 * marker))
            .collect::<Result<Vec<_>, _>>()?;
        let least_markers = byte(bytes, 32);
        if !(3..=count).contains(&least_markers) {
            return Err(RomError::LeastMarkers {
                found: least_markers,
                markers: count,
            });
        }
        let shape = shape::shape(&markers_mm)?;
        Ok(Self {
            bytes: Box::new(*bytes),
            maker: text(bytes, 580, 12),
            part: text(bytes, 592, 20),
            markers_mm,
            least_markers,
            most_error_mm: most_error(bytes)?,
            shape,
        })
    }

    /// The same, for a tool whose poses must have all six degrees of freedom.
    ///
    /// # Errors
    /// The first thing that is wrong; [`RomError::Collinear`].
    pub fn checked(bytes: &[u8]) -> Result<Self, RomError> {
        let rom = Self::parse(bytes)?;
        match rom.shape {
            Shape::Body => Ok(rom),
            Shape::Line { off_mm } => Err(RomError::Collinear { found_mm: off_mm }),
        }
    }

    /// A definition of these markers for a simulated device: whatever a real one needs besides places (normals, faces, the kind
    /// of tool) is left empty, and none has been tried with it. A pose needs 3 markers, within 1 mm. Of `maker` the first 12
    /// bytes are kept, of `part` 20.
    ///
    /// # Errors
    /// As [`Rom::checked`] of what is written.
    pub fn simulated(maker: &str, part: &str, markers_mm: &[[f64; 3]]) -> Result<Self, RomError> {
        let found = u8::try_from(markers_mm.len()).unwrap_or(u8::MAX);
        if found > MOST_MARKERS {
            return Err(RomError::MarkerCount { found });
        }
        let mut bytes = vec![0; BYTES];
        put(&mut bytes, 0, b"NDI\0");
        put(&mut bytes, 24, &[WIDEST_DEG]);
        put(&mut bytes, 28, &[found]);
        put(&mut bytes, 32, &[3]);
        put(&mut bytes, 36, &1.0_f32.to_le_bytes());
        for (number, coordinate) in markers_mm.iter().flatten().enumerate() {
            // Single precision is what the file has.
            put(&mut bytes, 72 + 4 * number, &(*coordinate as f32).to_le_bytes());
        }
        put(&mut bytes, 580, maker.as_bytes().get(..12).unwrap_or(maker.as_bytes()));
        put(&mut bytes, 592, part.as_bytes().get(..20).unwrap_or(part.as_bytes()));
        let sum = checksum(&bytes).to_le_bytes();
        put(&mut bytes, 4, &sum);
        Self::checked(&bytes)
    }

    /// All bytes of the file.
    pub fn bytes(&self) -> &[u8; BYTES] {
        &self.bytes
    }

    /// Its pieces with their addresses, in order; zeros behind the last byte.
    pub fn pieces(&self) -> impl Iterator<Item = (u16, [u8; PIECE])> + '_ {
        self.bytes.chunks(PIECE).zip(0_u16..).map(|(bytes, number)| {
            let mut piece = [0; PIECE];
            bytes.iter().zip(&mut piece).for_each(|(byte, into)| *into = *byte);
            (number * 64, piece)
        })
    }
}

fn check_head(bytes: &[u8; BYTES]) -> Result<(), RomError> {
    let head = bytes.get(..4).unwrap_or_default();
    if head != b"NDI\0" {
        let found = shown(head);
        return Err(RomError::Foreign { found });
    }
    let found = u16::from_le_bytes([byte(bytes, 4), byte(bytes, 5)]);
    let computed = checksum(bytes);
    if found != computed {
        return Err(RomError::Checksum { found, computed });
    }
    Ok(())
}

/// The sum of all bytes from 6 on.
pub fn checksum(bytes: &[u8]) -> u16 {
    bytes
        .iter()
        .skip(6)
        .fold(0, |sum, byte| sum.wrapping_add(u16::from(*byte)))
}

fn put(bytes: &mut [u8], at: usize, what: &[u8]) {
    if let Some(into) = bytes.get_mut(at..at + what.len()) {
        into.copy_from_slice(what);
    }
}

fn byte(bytes: &[u8; BYTES], at: usize) -> u8 {
    bytes.get(at).copied().unwrap_or_default()
}

fn number(bytes: &[u8; BYTES], at: usize) -> f64 {
    let four = bytes.get(at..).and_then(|rest| rest.first_chunk());
    four.map_or(f64::NAN, |four| f64::from(f32::from_le_bytes(*four)))
}

fn place(bytes: &[u8; BYTES], at: usize) -> Result<[f64; 3], RomError> {
    let place = [number(bytes, at), number(bytes, at + 4), number(bytes, at + 8)];
    check_place(&place, "place of a marker").map_err(|error| RomError::Number { byte: at, error })?;
    Ok(place)
}

fn most_error(bytes: &[u8; BYTES]) -> Result<f64, RomError> {
    let found_mm = number(bytes, 36);
    check_place(&[found_mm; 3], "largest error").map_err(|error| RomError::Number { byte: 36, error })?;
    if found_mm <= 0.0 {
        return Err(RomError::MostError { found_mm });
    }
    Ok(found_mm)
}

fn text(bytes: &[u8; BYTES], at: usize, length: usize) -> String {
    let field = bytes.get(at..at + length).unwrap_or_default();
    shown(field.split(|byte| *byte == 0).next().unwrap_or_default())
}
