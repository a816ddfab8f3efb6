//! VTK's legacy files, of which PolyData of polygons are read: versions 1 to 4 with cells as lists, and 5 with offsets.

use super::MeshError;
use super::bytes::{Bytes, Scalar, corner};
use super::raw::{Raw, counted};
use super::words::Words;
use crate::quoted;

/// What every file begins with.
const HEAD: &[u8] = b"# vtk DataFile Version ";

/// The numbers of a file: its head and the words that say what follows are text whatever they are.
struct Numbers<'a> {
    words: Words<'a>,
    is_text: bool,
}

pub(super) fn read(bytes: &[u8]) -> Result<Raw, MeshError> {
    let mut raw = Raw::default();
    let mut words = Words::new(bytes, 1);
    let head = words.line();
    let version = head.strip_prefix(HEAD).and_then(|version| version.first().copied());
    if !matches!(version, Some(b'1'..=b'5')) {
        let found = quoted(&String::from_utf8_lossy(&head[..head.len().min(64)]));
        return Err(MeshError::Head {
            found,
            expected: "# vtk DataFile Version 1 to 5",
        });
    }
    raw.comment(&String::from_utf8_lossy(words.line()))?;
    let is_text = match words.next() {
        b"ASCII" => true,
        b"BINARY" => false,
        found => return Err(words.refused(found, "ASCII or BINARY")),
    };
    words.expect("DATASET")?;
    words.expect("POLYDATA")?;
    let mut numbers = Numbers { words, is_text };
    let has_offsets = version == Some(b'5');
    while numbers.section(&mut raw, has_offsets)? {}
    Ok(raw)
}

impl Numbers<'_> {
    /// One part of the file; false where nothing follows that is read.
    fn section(&mut self, raw: &mut Raw, has_offsets: bool) -> Result<bool, MeshError> {
        match self.words.next() {
            b"POINTS" if !raw.points.is_empty() => return Err(self.words.refused(b"POINTS", "the points once")),
            b"POINTS" => {
                let count = counted("points", self.words.number("how many points there are")?)?;
                let of = self.scalar()?;
                let flat = self.all("the points", count as u64 * 3, of)?;
                raw.points.extend(flat.chunks_exact(3).map(|p| [p[0], p[1], p[2]]));
            }
            b"POLYGONS" => self.cells(raw, has_offsets, true)?,
            // Single points and lines have no face; they are read over.
            b"VERTICES" | b"LINES" => {
                let mut none = Raw::default();
                self.cells(&mut none, has_offsets, false)?;
            }
            b"TRIANGLE_STRIPS" => {
                let what = "strips of triangles".to_owned();
                return Err(MeshError::Unread {
                    what,
                    instead: "save the surface as triangles",
                });
            }
            b"METADATA" => self.metadata(),
            // What the file carries may come before the points.
            b"FIELD" if raw.points.is_empty() => self.field()?,
            // What points and cells carry comes last, and is left out.
            b"" | b"POINT_DATA" | b"CELL_DATA" | b"FIELD" => return Ok(false),
            found => {
                return Err(self
                    .words
                    .refused(found, "POINTS, POLYGONS, VERTICES, LINES, POINT_DATA or CELL_DATA"));
            }
        }
        Ok(true)
    }

    /// Arrays of numbers, which are read over.
    fn field(&mut self) -> Result<(), MeshError> {
        self.words.next();
        let arrays = counted("arrays", self.words.number("how many arrays there are")?)?;
        for _ in 0..arrays {
            while self.words.next() == b"METADATA" {
                self.metadata();
            }
            let size: u64 = self.words.number("how many numbers belong together")?;
            let count: u64 = self.words.number("how many of these there are")?;
            let of = self.scalar()?;
            let all = counted("numbers of an array", size.saturating_mul(count))?;
            self.all("an array", all as u64, of)?;
        }
        Ok(())
    }

    /// Names of components and the like, up to an empty line.
    fn metadata(&mut self) {
        self.words.line();
        while !self.words.rest().is_empty() && !self.words.line().is_empty() {}
    }

    /// Lists of corners, each behind its length, or all of them behind where each begins.
    fn cells(&mut self, raw: &mut Raw, has_offsets: bool, is_face: bool) -> Result<(), MeshError> {
        let count = counted("polygons", self.words.number("how many polygons there are")?)?;
        let size = counted("numbers of polygons", self.words.number("how many numbers they have")?)?;
        let lists = match has_offsets {
            true => self.by_offsets(count, size)?,
            false => {
                let flat = self.all("the polygons", size as u64, Scalar::I32)?;
                by_lengths(&flat, count)?
            }
        };
        for (corners, place) in lists.iter().zip(1..) {
            if is_face {
                raw.polygon(place, corners)?;
            }
        }
        Ok(())
    }

    fn by_offsets(&mut self, count: usize, size: usize) -> Result<Vec<Vec<u32>>, MeshError> {
        let mut of = |what: &'static str, count: usize, word: &'static str| {
            self.words.expect(word)?;
            let of = self.scalar()?;
            self.all(what, count as u64, of)
        };
        let offsets = of("where the polygons begin", count, "OFFSETS")?;
        let corners = of("the polygons", size, "CONNECTIVITY")?;
        let bad = |place: usize| MeshError::Polygon { place, corners: 0 };
        // From the first corner to the last: what lies before or behind is of no polygon, and would be lost.
        let ends = [offsets.first(), offsets.last()].map(|end| end.copied());
        let is_whole = ends == [Some(0.0), Some(corners.len() as f64)] || (offsets.is_empty() && corners.is_empty());
        if !is_whole {
            return Err(MeshError::Offsets {
                first: ends[0].unwrap_or(f64::NAN),
                last: ends[1].unwrap_or(f64::NAN),
                corners: corners.len(),
            });
        }
        let between = |(pair, place): (&[f64], usize)| {
            let [from, to] = [corner(pair[0], place)? as usize, corner(pair[1], place)? as usize];
            let list = corners.get(from..to).ok_or_else(|| bad(place))?;
            list.iter().map(|number| corner(*number, place)).collect()
        };
        offsets.windows(2).zip(1..).map(between).collect()
    }

    fn scalar(&mut self) -> Result<Scalar, MeshError> {
        let found = self.words.next();
        Ok(match found.to_ascii_lowercase().as_slice() {
            b"char" => Scalar::I8,
            b"unsigned_char" => Scalar::U8,
            b"short" => Scalar::I16,
            b"unsigned_short" => Scalar::U16,
            b"int" => Scalar::I32,
            b"unsigned_int" => Scalar::U32,
            b"vtktypeint64" | b"long" | b"vtkidtype" => Scalar::I64,
            b"float" => Scalar::F32,
            b"double" => Scalar::F64,
            _ => return Err(self.words.refused(found, "the type of a number")),
        })
    }

    /// So many numbers; what is not there is refused before anything is held.
    fn all(&mut self, what: &'static str, count: u64, of: Scalar) -> Result<Vec<f64>, MeshError> {
        if !self.is_text {
            // Behind the end of the line that says what they are.
            self.words.line();
            let mut bytes = Bytes {
                rest: self.words.rest(),
                is_big: true,
            };
            let taken = bytes.take(what, count, of.size())?;
            self.words.skip(taken.len());
            return Ok(taken
                .chunks_exact(of.size() as usize)
                .map(|one| of.read(one, true))
                .collect());
        }
        // A digit and a blank each, but the last.
        let (needed, left) = ((2 * count).saturating_sub(1), self.words.rest().len());
        if needed > left as u64 {
            return Err(MeshError::CutOff { what, needed, left });
        }
        (0..count).map(|_| self.words.number("a number")).collect()
    }
}

fn by_lengths(flat: &[f64], count: usize) -> Result<Vec<Vec<u32>>, MeshError> {
    let mut lists = Vec::new();
    let mut rest = flat;
    for place in 1..=count {
        let length = rest
            .first()
            .map(|length| corner(*length, place))
            .transpose()?
            .unwrap_or(0) as usize;
        let list = rest.get(1..).and_then(|rest| rest.split_at_checked(length));
        let (list, others) = list.ok_or(MeshError::Polygon { place, corners: length })?;
        lists.push(
            list.iter()
                .map(|number| corner(*number, place))
                .collect::<Result<_, _>>()?,
        );
        rest = others;
    }
    match rest.is_empty() {
        true => Ok(lists),
        false => Err(MeshError::TooMuch { left: rest.len() }),
    }
}
