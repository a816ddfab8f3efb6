//! An organ as bytes, and back.

use super::super::{field_text, text_field};
use super::{MeshCube, MeshOrgan, TissueMeshError};

/// Of a name.
const NAME: usize = 32;
/// Of a cube.
const CUBE: u64 = 4 * 8 + 27 * 4;
/// Nodes, cubes and values of an organ, at most.
const MOST_NODES: u64 = 1 << 23;
const MOST_CUBES: u64 = 1 << 18;
const MOST_VALUES: u64 = 1 << 26;

pub(super) fn organ_bytes(organ: &MeshOrgan, bytes: &mut Vec<u8>) {
    bytes.extend(text_field::<NAME>(&organ.name));
    for n in [organ.nodes, organ.cubes.len() as u32].iter().chain(&organ.region_dims) {
        bytes.extend(n.to_le_bytes());
    }
    for x in organ.region_origin.iter().chain([&organ.region_step_mm]) {
        bytes.extend(x.to_le_bytes());
    }
    for cube in &organ.cubes {
        cube.low
            .iter()
            .chain([&cube.side])
            .for_each(|x| bytes.extend(x.to_le_bytes()));
        cube.nodes.iter().for_each(|n| bytes.extend(n.to_le_bytes()));
    }
    organ.region.iter().for_each(|v| bytes.extend(v.to_le_bytes()));
}

/// Takes bytes one after the other.
#[derive(Debug)]
pub(super) struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Reader<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0 }
    }

    pub(super) fn left(&self) -> usize {
        self.bytes.len() - self.at
    }

    /// So many bytes, if they are there: whatever is allocated for them is no more than was sent.
    fn take(&mut self, what: &'static str, expected: u64) -> Result<&'a [u8], TissueMeshError> {
        let (at, left) = (self.at, self.left());
        let count = usize::try_from(expected).ok().filter(|count| *count <= left);
        let count = count.ok_or(TissueMeshError::Short {
            at,
            what,
            expected,
            left,
        })?;
        self.at += count;
        Ok(&self.bytes[at..self.at])
    }

    fn array<const N: usize>(&mut self, what: &'static str) -> Result<[u8; N], TissueMeshError> {
        let mut array = [0; N];
        array.copy_from_slice(self.take(what, N as u64)?);
        Ok(array)
    }

    fn count(&mut self, what: &'static str) -> Result<u64, TissueMeshError> {
        Ok(u64::from(u32::from_le_bytes(self.array(what)?)))
    }

    fn number(&mut self, what: &'static str) -> Result<f64, TissueMeshError> {
        Ok(f64::from_le_bytes(self.array(what)?))
    }

    pub(super) fn limited(
        &self,
        (organ, what): (usize, &'static str),
        found: u64,
        most: u64,
        allowed: &'static str,
    ) -> Result<u64, TissueMeshError> {
        match (1..=most).contains(&found) {
            true => Ok(found),
            false => Err(TissueMeshError::Number {
                organ,
                what,
                found,
                allowed,
            }),
        }
    }

    pub(super) fn organ(&mut self, organ: usize) -> Result<MeshOrgan, TissueMeshError> {
        let name = field_text(&self.array::<NAME>("an organ's name")?);
        let what = "an organ's numbers";
        let (nodes, cubes) = (self.count(what)?, self.count(what)?);
        let nodes = self.limited((organ, "nodes"), nodes, MOST_NODES, "1 to 8388608 are")?;
        let cubes = self.limited((organ, "cubes"), cubes, MOST_CUBES, "1 to 262144 are")?;
        // What a state needs room for is bounded by what the mesh has sent.
        self.limited((organ, "nodes"), nodes, 27 * cubes, "no more than 27 a cube are")?;
        let dims = [self.count(what)?, self.count(what)?, self.count(what)?];
        let all = dims.iter().fold(1, |all: u64, n| all.saturating_mul(*n));
        let values = self.limited((organ, "values of its region"), all, MOST_VALUES, "1 to 67108864 are")?;
        let mut region_origin = [0.0; 3];
        for x in &mut region_origin {
            *x = self.number(what)?;
        }
        let region_step_mm = self.number(what)?;
        let mut within = Reader::new(self.take("cubes", cubes * CUBE)?);
        let cubes: Result<Vec<_>, _> = (0..cubes).map(|_| within.cube()).collect();
        let region = self.take("values of a region", 4 * values)?;
        Ok(MeshOrgan {
            name,
            nodes: nodes as u32,
            cubes: cubes?,
            region_origin,
            region_step_mm,
            region_dims: dims.map(|n| n as u32),
            region: region
                .chunks_exact(4)
                .map(|v| f32::from_le_bytes([v[0], v[1], v[2], v[3]]))
                .collect(),
        })
    }

    fn cube(&mut self) -> Result<MeshCube, TissueMeshError> {
        let what = "a cube";
        let mut numbers = [0.0; 4];
        for x in &mut numbers {
            *x = self.number(what)?;
        }
        let mut nodes = [0; 27];
        for node in &mut nodes {
            *node = u32::from_le_bytes(self.array(what)?);
        }
        let [x, y, z, side] = numbers;
        Ok(MeshCube {
            low: [x, y, z],
            side,
            nodes,
        })
    }
}
