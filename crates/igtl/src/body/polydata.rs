//! POLYDATA: a surface, as VTK's polygonal data: points, lists of cells that name them, and numbers at points or cells.
//!
//! Ten `u32`: points; for vertices, lines, polygons and strips of triangles the number of cells and the bytes of their
//! list; attributes. Then the points (three `f32` each), the four lists (each cell a `u32` number of points and their
//! indices), a head of 6 bytes for each attribute (`u8` kind, `u8` components, `u32` values), their names, each ended
//! by a zero and all together padded to an even number of bytes, and their numbers as `f32`.

use super::attribute::Attribute;
use super::cells::Cells;
use crate::fault::{Fault, SizeRule};
use crate::fields::Fields;
use crate::limits::Limits;
use crate::malformed::Refusal;
use crate::wire::{Reader, counted, put_reals};

const HEAD_BYTES: u64 = 40;
const POINT_BYTES: u64 = 12;

/// A surface. Places are mm in a frame that the message does not name: patients are RAS.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PolyData {
    /// Places, mm.
    pub points: Vec<[f32; 3]>,
    /// Cells of single points.
    pub vertices: Cells,
    /// Lines from point to point.
    pub lines: Cells,
    /// Polygons.
    pub polygons: Cells,
    /// Strips of triangles.
    pub strips: Cells,
    /// Numbers at the points or cells.
    pub attributes: Vec<Attribute>,
}

const LISTS: [&str; 4] = [
    "the list of vertices",
    "the list of lines",
    "the list of polygons",
    "the list of strips",
];

impl PolyData {
    fn lists(&self) -> [&Cells; 4] {
        [&self.vertices, &self.lines, &self.polygons, &self.strips]
    }

    pub(crate) fn read(reader: &mut Reader<'_>, limits: &Limits) -> Result<Self, Refusal> {
        reader.sized(SizeRule::AtLeast(HEAD_BYTES))?;
        let points = reader.u32()?;
        let mut said = [(0, 0); 4];
        for (cells, bytes) in &mut said {
            (*cells, *bytes) = (reader.u32()?, reader.u32()?);
        }
        let attributes = reader.u32()?;
        let places = read_points(reader, points)?;
        let mut lists = LISTS.into_iter().zip(said);
        let mut list = || match lists.next() {
            Some((field, (cells, bytes))) => Cells::read(reader, cells, bytes, points, field),
            None => Ok(Cells::default()),
        };
        let (vertices, lines, polygons, strips) = (list()?, list()?, list()?, list()?);
        let attributes = Attribute::read_all(reader, attributes, limits)?;
        if reader.left() != 0 {
            return Err(reader.refuse(Fault::Size {
                found: reader.size(),
                rule: SizeRule::Exactly(reader.size() - reader.left()),
            }));
        }
        Ok(Self {
            points: places,
            vertices,
            lines,
            polygons,
            strips,
            attributes,
        })
    }

    pub(crate) fn write(&self, out: &mut Vec<u8>) -> Result<(), Fault> {
        let most = u32::MAX.into();
        let points: u32 = counted(self.points.len(), "points", most)?;
        out.extend(points.to_be_bytes());
        for (cells, field) in self.lists().into_iter().zip(LISTS) {
            cells.check(points, field)?;
            let bytes: u32 = counted(cells.bytes(), "bytes of cells", most)?;
            out.extend(cells.count().to_be_bytes());
            out.extend(bytes.to_be_bytes());
        }
        let attributes: u32 = counted(self.attributes.len(), "attributes", most)?;
        out.extend(attributes.to_be_bytes());
        put_reals(out, self.points.as_flattened(), "the place of a point")?;
        self.lists().into_iter().for_each(|cells| cells.write(out));
        Attribute::write_all(&self.attributes, out)
    }

    pub(crate) fn fields(&self, fields: &mut Fields) {
        fields.add("points", self.points.len());
        if let Some((low, high)) = self.bounds() {
            fields.add("lowest_mm", &low[..]);
            fields.add("highest_mm", &high[..]);
        }
        for (name, cells) in ["vertices", "lines", "polygons", "strips"]
            .into_iter()
            .zip(self.lists())
        {
            fields.add(name, cells.count());
        }
        fields.add("attributes", self.attributes.len());
        for (number, attribute) in self.attributes.iter().enumerate() {
            attribute.fields(&format!("attributes[{number}]."), fields);
        }
    }

    /// The lowest and the highest coordinates of all points, mm; `None` without a point.
    pub fn bounds(&self) -> Option<([f32; 3], [f32; 3])> {
        let first = *self.points.first()?;
        Some(self.points.iter().fold((first, first), |(low, high), point| {
            let by = |f: fn(f32, f32) -> f32, a: [f32; 3]| [0, 1, 2].map(|axis| f(a[axis], point[axis]));
            (by(f32::min, low), by(f32::max, high))
        }))
    }
}

/// So many points as are said, once it is known that they are there.
fn read_points(reader: &mut Reader<'_>, count: u32) -> Result<Vec<[f32; 3]>, Refusal> {
    let bytes = u64::from(count) * POINT_BYTES;
    let at = reader.at();
    let mut places = Reader::new(reader.take(bytes)?, at);
    let mut points = Vec::with_capacity(usize::try_from(places.left() / POINT_BYTES).unwrap_or_default());
    while places.left() > 0 {
        points.push(places.reals("the place of a point")?);
    }
    Ok(points)
}
