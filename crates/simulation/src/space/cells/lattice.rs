//! All cubes with all of their nodes, as pictures want them: also those that hang or are extended.

use nalgebra::Vector3;

use super::mesh::Mesh;
use crate::space::element::Order;

/// A cube of 27 nodes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LatticeCube {
    /// Its lowest corner at rest, mm.
    pub low: Vector3<f64>,
    /// Its side, mm.
    pub side: f64,
    /// Its nodes, fastest along x, then y, then z.
    pub nodes: [u32; 27],
}

/// The nodes of all cubes, each a combination of free nodes.
#[derive(Debug, Clone)]
pub struct Lattice {
    /// The cubes.
    pub cubes: Vec<LatticeCube>,
    /// Where the nodes are at rest, mm.
    pub places: Vec<Vector3<f64>>,
    /// Of each node what it is in free nodes.
    ties: Vec<Vec<(u32, f64)>>,
}

impl Mesh {
    /// All cubes with all of their nodes; `None` where cubes have 8 nodes.
    pub fn lattice(&self) -> Option<Lattice> {
        if self.order != Order::Quadratic {
            return None;
        }
        let mut lattice = Lattice {
            cubes: Vec::with_capacity(self.cells.len()),
            places: vec![Vector3::zeros(); self.ties.ties.len()],
            ties: self.ties.ties.clone(),
        };
        for (cell, nodes) in self.cells.iter().zip(&self.ties.of_cell) {
            let half = cell.span / 2;
            for (k, node) in (0_i32..).zip(nodes) {
                let step = [k % 3, k / 3 % 3, k / 9].map(|n| n * half);
                let at = std::array::from_fn(|a| cell.corner[a] + step[a]);
                lattice.places[*node as usize] = self.grid.place(at);
            }
            lattice.cubes.push(LatticeCube {
                low: self.grid.place(cell.corner),
                side: self.grid.length(cell.span),
                nodes: nodes.as_slice().try_into().ok()?,
            });
        }
        Some(lattice)
    }
}

impl Lattice {
    /// Where all nodes are with these displacements of the free ones (three numbers each, mm), behind what `into` has.
    pub fn displaced(&self, part: &[f64], into: &mut Vec<f32>) {
        for (place, tie) in self.places.iter().zip(&self.ties) {
            let mut at = *place;
            for (node, weight) in tie {
                let first = 3 * *node as usize;
                at += Vector3::new(part[first], part[first + 1], part[first + 2]) * *weight;
            }
            into.extend(at.iter().map(|x| *x as f32));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Ball, Settings};
    use super::*;
    use crate::space::element::shape;

    /// A ball in cubes of two sizes, so that nodes hang and cubes at its surface are nearly empty.
    fn mesh() -> Mesh {
        let ball = Ball {
            centre: Vector3::new(0.3, -0.2, 0.1),
            radius: 10.0,
        };
        let settings = Settings {
            levels: 1,
            ..Settings::of_side(5.0)
        };
        let corners = [Vector3::repeat(-11.0), Vector3::repeat(11.5)];
        Mesh::new(&ball, corners, &settings, &|low: &Vector3<f64>, _: &Vector3<f64>| {
            low.x > 0.0
        })
        .unwrap()
    }

    #[test]
    fn cubes_move_every_place_as_the_mesh_does() {
        let mesh = mesh();
        let lattice = mesh.lattice().unwrap();
        let sides: std::collections::BTreeSet<u64> = lattice.cubes.iter().map(|c| c.side.to_bits()).collect();
        assert!(sides.len() == 2 && lattice.places.len() > mesh.nodes.len());
        let part: Vec<f64> = (0..mesh.unknowns())
            .map(|k| ((k * 37) % 101) as f64 / 50.0 - 1.0)
            .collect();
        let mut now = Vec::new();
        lattice.displaced(&part, &mut now);
        for cube in &lattice.cubes {
            let place = |node: u32| Vector3::from_fn(|a, _| f64::from(now[3 * node as usize + a]));
            for at in [[0.0, 0.0, 0.0], [0.3, -0.7, 0.9], [-0.99, 0.2, 0.5]] {
                let values = shape::values_27(at);
                let by_cube: Vector3<f64> = (0..27).map(|k| place(cube.nodes[k]) * values[k]).sum();
                let rest = cube.low + (Vector3::from(at).add_scalar(1.0)) * (0.5 * cube.side);
                let moved: Vector3<f64> = mesh
                    .shares(&rest)
                    .unwrap()
                    .iter()
                    .map(|share| {
                        let first = 3 * share.node as usize;
                        Vector3::new(part[first], part[first + 1], part[first + 2]) * share.weight
                    })
                    .sum();
                // Each coordinate of a node is off by half an ulp of 32, as extended nodes go, 2e-6 mm; weights of 27 nodes sum to at most 2 in magnitude.
                assert!(
                    (by_cube - rest - moved).amax() < 1e-5,
                    "{rest} {}",
                    by_cube - rest - moved
                );
            }
        }
    }

    #[test]
    fn a_mesh_at_rest_lies_where_its_cubes_do() {
        let mesh = mesh();
        let lattice = mesh.lattice().unwrap();
        let mut now = Vec::new();
        lattice.displaced(&vec![0.0; mesh.unknowns()], &mut now);
        for cube in &lattice.cubes {
            for (node, sign) in [(0, 0.0), (13, 0.5), (26, 1.0)] {
                let at = 3 * cube.nodes[node] as usize;
                let place = Vector3::from_fn(|a, _| f64::from(now[at + a]));
                // Half an ulp of 16 mm.
                assert!((place - cube.low.add_scalar(sign * cube.side)).amax() < 1e-6);
            }
        }
    }
}
