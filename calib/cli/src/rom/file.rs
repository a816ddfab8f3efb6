//! NDI tool definitions (.rom): 752 bytes, little endian. There is no public standard; the layout is the one that seven
//! tools of two makers share, and every file's checksum agrees with it:
//!
//! | byte | what |
//! |---|---|
//! | 0 to 3 | `NDI` and 0 |
//! | 4, 5 | sum of all bytes from 6 on, modulo 65536 |
//! | 24 | the largest angle at which a marker is used, degrees |
//! | 28 | number of markers, at most 20 |
//! | 32 | fewest markers for a pose |
//! | 36 to 39 | largest 3-D error, mm, float |
//! | 72 to 311 | places of the markers, 3 floats each, mm |
//! | 312 to 551 | their normals, 3 floats each; 0 where a marker has none |
//! | 580 to 591, 592 to 611 | maker and part number, text |
//! | 613 to 632 | faces that each marker belongs to, a bit each |
//! | 656 to 751 | normals of up to 8 faces, 3 floats each |

use crate::commands::common::OwnError;
use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Path, PathBuf};

/// The length of a file.
const BYTES: usize = 752;
/// The most markers of a tool.
const MAX_MARKERS: usize = 20;
/// A place further out is no millimetres.
const MAX_MM: f64 = 10_000.0;

/// A marker sphere or diode of a tool.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct RomMarker {
    pub(crate) at_mm: [f64; 3],
    /// Unit; `None` where the file has zeros.
    pub(crate) normal: Option<[f64; 3]>,
    /// The faces it belongs to, from 1.
    pub(crate) faces: Vec<usize>,
}

/// A tool definition.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Rom {
    pub(crate) maker: String,
    pub(crate) part: String,
    pub(crate) max_angle_deg: u8,
    pub(crate) min_markers: u8,
    pub(crate) max_error_mm: f64,
    pub(crate) markers: Vec<RomMarker>,
    /// Number, from 1, and unit normal of the faces that have one.
    pub(crate) faces: Vec<(usize, [f64; 3])>,
    pub(crate) blake3: String,
}

/// Why a file is no tool definition. Bytes count from 0.
#[derive(Debug, thiserror::Error)]
pub(crate) enum RomError {
    #[error("reading {path}: {source}. Check the name and the permissions")]
    Read { path: PathBuf, source: io::Error },
    #[error("reading {path}: this is not a file; give the path of an NDI tool definition (.rom)")]
    NotAFile { path: PathBuf },
    #[error(
        "reading {path}: found {found} bytes, an NDI tool definition has {BYTES}; it is cut off or of another kind"
    )]
    Length { path: PathBuf, found: u64 },
    #[error("reading {path}: byte {byte} ({what}): found {found}, expected {expected}")]
    Byte {
        path: PathBuf,
        byte: usize,
        what: &'static str,
        found: String,
        expected: String,
    },
}

impl OwnError for RomError {}

impl Rom {
    /// Reads a tool definition.
    pub(crate) fn read(path: &Path) -> Result<Self, RomError> {
        let failed = |source| RomError::Read {
            path: path.to_owned(),
            source,
        };
        // Asked for before opening: opening a pipe would wait for its writer.
        let about = fs::metadata(path).map_err(failed)?;
        if !about.is_file() {
            return Err(RomError::NotAFile { path: path.to_owned() });
        }
        let mut bytes = Vec::with_capacity(BYTES + 1);
        let file = File::open(path).map_err(failed)?;
        file.take(BYTES as u64 + 1).read_to_end(&mut bytes).map_err(failed)?;
        if bytes.len() != BYTES {
            let (path, found) = (path.to_owned(), about.len().max(bytes.len() as u64));
            return Err(RomError::Length { path, found });
        }
        Bytes { path, bytes: &bytes }.rom()
    }
}

/// The bytes of a file of the right length.
struct Bytes<'a> {
    path: &'a Path,
    bytes: &'a [u8],
}

impl Bytes<'_> {
    fn rom(&self) -> Result<Rom, RomError> {
        self.check_head()?;
        let count = self.bytes[28];
        if !(1..=MAX_MARKERS as u8).contains(&count) {
            return Err(self.bad(28, "number of markers", count, "1 to 20"));
        }
        let markers: Vec<RomMarker> = (0..count as usize).map(|i| self.marker(i)).collect::<Result<_, _>>()?;
        let mut faces = Vec::new();
        for face in 0..8 {
            if let Some(normal) = self.normal(656 + 12 * face, "normal of a face")? {
                faces.push((face + 1, normal));
            }
        }
        Ok(Rom {
            maker: self.text(580, 12),
            part: self.text(592, 20),
            max_angle_deg: self.bytes[24],
            min_markers: self.bytes[32],
            max_error_mm: self.float(36, "largest 3-D error")?,
            markers,
            faces,
            blake3: blake3::hash(self.bytes).to_hex().to_string(),
        })
    }

    fn check_head(&self) -> Result<(), RomError> {
        if &self.bytes[..4] != b"NDI\0" {
            let found = format!("{:?}", String::from_utf8_lossy(&self.bytes[..4]));
            return Err(self.bad(0, "magic", found, "\"NDI\\0\""));
        }
        let said = u16::from_le_bytes([self.bytes[4], self.bytes[5]]);
        let sum = self.bytes[6..]
            .iter()
            .fold(0_u16, |sum, b| sum.wrapping_add(u16::from(*b)));
        if said != sum {
            let expected = format!("{sum:#06x}, the sum of the bytes that follow: the file is damaged");
            return Err(self.bad(4, "checksum", format!("{said:#06x}"), expected));
        }
        Ok(())
    }

    fn marker(&self, i: usize) -> Result<RomMarker, RomError> {
        let membership = self.bytes[613 + i];
        let face = |bit: &usize| membership >> bit & 1 == 1;
        Ok(RomMarker {
            at_mm: self.vector(72 + 12 * i, "place of a marker, mm")?,
            normal: self.normal(312 + 12 * i, "normal of a marker")?,
            faces: (0..8).filter(face).map(|bit| bit + 1).collect(),
        })
    }

    fn float(&self, byte: usize, what: &'static str) -> Result<f64, RomError> {
        let mut four = [0; 4];
        four.copy_from_slice(&self.bytes[byte..byte + 4]);
        let value = f64::from(f32::from_le_bytes(four));
        if value.is_finite() && value.abs() <= MAX_MM {
            return Ok(value);
        }
        Err(self.bad(byte, what, value, "a finite number of at most 10000"))
    }

    fn vector(&self, byte: usize, what: &'static str) -> Result<[f64; 3], RomError> {
        let at = |k: usize| self.float(byte + 4 * k, what);
        Ok([at(0)?, at(1)?, at(2)?])
    }

    /// A unit vector, or `None` for zeros.
    fn normal(&self, byte: usize, what: &'static str) -> Result<Option<[f64; 3]>, RomError> {
        let v = self.vector(byte, what)?;
        let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
        if length == 0.0 {
            return Ok(None);
        }
        if (length - 1.0).abs() > 0.01 {
            return Err(self.bad(
                byte,
                what,
                format!("{v:?}, of length {length:.4}"),
                "length 1, or zeros",
            ));
        }
        Ok(Some(v.map(|x| x / length)))
    }

    /// Text that ends with 0; what is no printable ASCII becomes a question mark.
    fn text(&self, byte: usize, length: usize) -> String {
        let field = &self.bytes[byte..byte + length];
        let ended = field.split(|b| *b == 0).next().unwrap_or_default();
        let shown = |b: &u8| if (0x20..0x7f).contains(b) { *b as char } else { '?' };
        ended.iter().map(shown).collect()
    }

    fn bad(&self, byte: usize, what: &'static str, found: impl ToString, expected: impl ToString) -> RomError {
        RomError::Byte {
            path: self.path.to_owned(),
            byte,
            what,
            found: found.to_string(),
            expected: expected.to_string(),
        }
    }
}

#[cfg(test)]
mod tests;
