//! Surface nets: one corner in each cell that the surface goes through, four cells joined about each edge that it cuts.
//!
//! Samples come a layer at a time, and two layers are held: what memory there is goes to the surface. Around the samples lies a shell that is
//! outside, so that what the examination cuts off is closed there, half a sample beyond the last one.
//!
//! Gibson, "Constrained elastic surface nets", MICCAI 1998; the corner is the mean of the places where the cell's edges are cut, so that it
//! lies in its cell, within half a diagonal of each of them.

use geometry::{Affine, Ct, Point, Voxel};

use crate::{Mesh, SurfaceError};

/// What is sampled.
#[derive(Debug, Clone, Copy)]
pub struct Lattice {
    /// Samples along each axis.
    pub dims: [u32; 3],
    /// From the number of a sample along each axis to the patient. May shear, and may be left-handed.
    pub ct_from_sample: Affine<Ct, Voxel>,
    /// Samples of this value and more are inside.
    pub level: f32,
    /// More triangles are refused.
    pub most: usize,
}

/// No cell corner is here.
const NONE: u32 = u32::MAX;
/// The steps from a cell's first sample to its eight.
const CORNERS: [[usize; 3]; 8] = [
    [0, 0, 0],
    [1, 0, 0],
    [0, 1, 0],
    [1, 1, 0],
    [0, 0, 1],
    [1, 0, 1],
    [0, 1, 1],
    [1, 1, 1],
];
/// The twelve edges of a cell, by the numbers of its corners.
const EDGES: [[usize; 2]; 12] = [
    [0, 1],
    [2, 3],
    [4, 5],
    [6, 7],
    [0, 2],
    [1, 3],
    [4, 6],
    [5, 7],
    [0, 4],
    [1, 5],
    [2, 6],
    [3, 7],
];

/// The surface of what is inside. `layer` writes the values of layer z row by row, and the paint of each; NaN counts as outside.
///
/// # Errors
/// [`SurfaceError::TooMany`] before more is taken than [`Lattice::most`] triangles need.
pub fn extract(
    lattice: &Lattice,
    mut layer: impl FnMut(u32, &mut [f32], &mut [u8]) -> Result<(), SurfaceError>,
) -> Result<Mesh, SurfaceError> {
    let mut nets = Nets::new(lattice);
    let [nx, ny, nz] = lattice.dims.map(|n| n as usize);
    let (mut values, mut paints) = (vec![0.0; nx * ny], vec![0; nx * ny]);
    for z in 0..=nz {
        nets.next_layer();
        if z < nz {
            layer(z as u32, &mut values, &mut paints)?;
            nets.fill(&values, &paints);
        }
        nets.corners(z);
        nets.quads()?;
    }
    nets.mesh.make_normals();
    Ok(nets.mesh)
}

/// A layer of samples with a shell about it.
#[derive(Debug, Clone)]
struct Layer {
    values: Vec<f32>,
    inside: Vec<bool>,
    paints: Vec<u8>,
}

struct Nets<'a> {
    lattice: &'a Lattice,
    /// Samples in a row and rows in a layer, those of the shell included.
    row: usize,
    rows: usize,
    /// The layers below and above the cells.
    below: Layer,
    above: Layer,
    /// The corner in each cell, of the layer of cells before and of this one, in rows as those of samples.
    before: Vec<u32>,
    here: Vec<u32>,
    mesh: Mesh,
}

impl<'a> Nets<'a> {
    fn new(lattice: &'a Lattice) -> Self {
        let [row, rows] = [0, 1].map(|axis| lattice.dims[axis] as usize + 2);
        let empty = Layer {
            values: vec![f32::NEG_INFINITY; row * rows],
            inside: vec![false; row * rows],
            paints: vec![0; row * rows],
        };
        Self {
            lattice,
            row,
            rows,
            below: empty.clone(),
            above: empty,
            before: vec![NONE; row * rows],
            here: vec![NONE; row * rows],
            mesh: Mesh::default(),
        }
    }

    /// Goes on by a layer; the one above is of the shell until it is filled.
    fn next_layer(&mut self) {
        std::mem::swap(&mut self.below, &mut self.above);
        std::mem::swap(&mut self.before, &mut self.here);
        self.above.values.fill(f32::NEG_INFINITY);
        self.above.inside.fill(false);
        self.here.fill(NONE);
    }

    fn fill(&mut self, values: &[f32], paints: &[u8]) {
        let columns = self.row - 2;
        for (y, (values, paints)) in values
            .chunks_exact(columns)
            .zip(paints.chunks_exact(columns))
            .enumerate()
        {
            let first = (y + 1) * self.row + 1;
            let place = first..first + columns;
            self.above.values[place.clone()].copy_from_slice(values);
            self.above.paints[place.clone()].copy_from_slice(paints);
            for (inside, value) in self.above.inside[place].iter_mut().zip(values) {
                *inside = *value >= self.lattice.level;
            }
        }
    }

    /// Puts a corner into each cell between the two layers that the surface goes through; `z` is the number of the upper one.
    fn corners(&mut self, z: usize) {
        let row = self.row;
        for y in 0..self.rows - 1 {
            for x in 0..row - 1 {
                let at = y * row + x;
                let four = |layer: &Layer| {
                    [at, at + 1, at + row, at + row + 1]
                        .map(|i| u8::from(layer.inside[i]))
                        .iter()
                        .sum::<u8>()
                };
                let count = four(&self.below) + four(&self.above);
                if count == 0 || count == 8 {
                    continue;
                }
                let [cx, cy, cz] = self.mean_of_cuts(at);
                // The shell's sample has number -1.
                let place = [x as f64 - 1.0 + cx, y as f64 - 1.0 + cy, z as f64 - 1.0 + cz];
                let point = self.lattice.ct_from_sample * Point::new(place[0], place[1], place[2]);
                self.here[at] = self.mesh.points.len() as u32;
                self.mesh.points.push(point.mm().map(|mm| mm as f32));
            }
        }
    }

    /// Where the surface cuts the edges of the cell at `at`, on the average, from the cell's first sample, in samples.
    fn mean_of_cuts(&self, at: usize) -> [f64; 3] {
        let values = CORNERS.map(|[x, y, z]| {
            let layer = if z == 0 { &self.below } else { &self.above };
            let i = at + y * self.row + x;
            (layer.values[i], layer.inside[i])
        });
        let (mut sum, mut cuts) = ([0.0; 3], 0.0);
        for [from, to] in EDGES {
            let ((a, a_inside), (b, b_inside)) = (values[from], values[to]);
            if a_inside == b_inside {
                continue;
            }
            let part = f64::from((self.lattice.level - a) / (b - a));
            // Towards the shell, and towards what is no number, there is nothing to go by.
            let part = if part.is_finite() && a.is_finite() && b.is_finite() {
                part
            } else {
                0.5
            };
            for axis in 0..3 {
                let [from, to] = [from, to].map(|corner| CORNERS[corner][axis] as f64);
                sum[axis] += from + (to - from) * part;
            }
            cuts += 1.0;
        }
        sum.map(|sum| sum / cuts)
    }

    /// Joins the cells about each edge that is cut: those within the layer below, and those from it to the one above.
    fn quads(&mut self) -> Result<(), SurfaceError> {
        let row = self.row;
        for y in 0..self.rows - 1 {
            for x in 0..row - 1 {
                let at = y * row + x;
                let is_inside = self.below.inside[at];
                let (here, before) = (&self.here, &self.before);
                // In the order in which they go anticlockwise, seen from the end of the edge.
                let along = [
                    (self.below.inside[at + 1], at + 1, false),
                    (self.below.inside[at + row], at + row, false),
                    (self.above.inside[at], at, true),
                ];
                for (axis, (is_end_inside, end, is_above)) in along.into_iter().enumerate() {
                    if is_inside == is_end_inside {
                        continue;
                    }
                    // The shell is outside, so that an edge that is cut has a cell on each side.
                    let cells = match axis {
                        0 => [before[at - row], before[at], here[at], here[at - row]],
                        1 => [before[at - 1], here[at - 1], here[at], before[at]],
                        _ => [here[at - row - 1], here[at - row], here[at], here[at - 1]],
                    };
                    let end_layer = if is_above { &self.above } else { &self.below };
                    let paint = match is_inside {
                        true => self.below.paints[at],
                        false => end_layer.paints[end],
                    };
                    quad(&mut self.mesh, self.lattice, cells, is_inside, paint)?;
                }
            }
        }
        Ok(())
    }
}

/// Two triangles, turned outwards: along the edge where its start is inside, and the other way round where space is mirrored.
fn quad(mesh: &mut Mesh, lattice: &Lattice, cells: [u32; 4], is_along: bool, paint: u8) -> Result<(), SurfaceError> {
    if mesh.triangles.len() + 2 > lattice.most {
        return Err(SurfaceError::TooMany { most: lattice.most });
    }
    let is_right_handed = lattice.ct_from_sample.determinant() > 0.0;
    let [a, b, c, d] = match is_along == is_right_handed {
        true => cells,
        false => [cells[3], cells[2], cells[1], cells[0]],
    };
    mesh.triangles.extend([[a, b, c], [a, c, d]]);
    mesh.paints.extend([paint; 2]);
    Ok(())
}
