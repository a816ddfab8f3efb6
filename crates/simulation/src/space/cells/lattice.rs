//! The displacement of a mesh as pictures want it: small cubes of 27 nodes, all of them near the region.
//!
//! Nodes of cubes that the surface cuts lie outside the region, where hardly any material holds them: the polynomial that is right inside may
//! have moved them by metres. So a region is covered by small cubes of one size, halves and quarters of the mesh's own, whose nodes inside the
//! region are where the mesh has them, and outside go on from those straight ahead.

use std::collections::BTreeMap;

use nalgebra::Vector3;

use super::field::Field;
use super::mesh::Mesh;

/// From one node to the next, in parts of the side of the mesh's smallest cubes.
const PARTS: i32 = 4;
/// A mesh that takes more nodes than this is not covered.
const MOST_NODES: usize = 1 << 20;

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

/// A combination of others.
type Tie = Vec<(u32, f64)>;

/// Cubes over a region and what moves their nodes.
#[derive(Debug, Clone)]
pub struct Lattice {
    /// The cubes.
    pub cubes: Vec<LatticeCube>,
    /// Where the nodes are at rest, mm.
    pub places: Vec<Vector3<f64>>,
    /// Of each node in the region what it is in free nodes of the mesh.
    inside: Vec<(u32, Tie)>,
    /// Of each of the others what it is in nodes, each after those that it is made of.
    beyond: Vec<(u32, Tie)>,
}

impl Mesh {
    /// Small cubes over the region, whose nodes are a quarter of the smallest cube's side apart. `None` where that takes too many.
    pub fn lattice(&self, field: &impl Field) -> Option<Lattice> {
        let mut lattice = Lattice {
            cubes: Vec::new(),
            places: Vec::new(),
            inside: Vec::new(),
            beyond: Vec::new(),
        };
        let mut numbers: BTreeMap<[i32; 3], u32> = BTreeMap::new();
        let least = self.cells.iter().map(|cell| cell.span).min()?;
        // Grid steps are half the smallest cube's side or less: nodes at whole multiples of `1 / fine` of a step.
        let fine = (PARTS + least - 1) / least;
        let step = least * fine / PARTS;
        let place = |at: [i32; 3]| {
            self.grid.place([0; 3]) + Vector3::from(at.map(f64::from)) * (self.grid.length(1) / f64::from(fine))
        };
        for cell in &self.cells {
            let (low, count) = (cell.corner.map(|x| x * fine), cell.span * fine / (2 * step));
            for k in 0..count.pow(3) {
                let part = [k % count, k / count % count, k / (count * count)];
                let corner: [i32; 3] = std::array::from_fn(|a| low[a] + 2 * step * part[a]);
                let [from, to] = [place(corner), place(corner.map(|x| x + 2 * step))];
                if field.bounds(&from, &to)[0] >= 0.0 {
                    continue;
                }
                let nodes = std::array::from_fn(|n| {
                    let n = n as i32;
                    let at = [n % 3, n / 3 % 3, n / 9];
                    let at = std::array::from_fn(|a| corner[a] + step * at[a]);
                    let next = numbers.len() as u32;
                    *numbers.entry(at).or_insert(next)
                });
                let side = to.x - from.x;
                lattice.cubes.push(LatticeCube { low: from, side, nodes });
            }
            (numbers.len() <= MOST_NODES).then_some(())?;
        }
        lattice.places.resize(numbers.len(), Vector3::zeros());
        for (at, number) in &numbers {
            lattice.places[*number as usize] = place(*at);
        }
        let known = lattice.take_inside(self, field);
        lattice.go_on(&numbers, step, known);
        Some(lattice)
    }
}

impl Lattice {
    /// What moves the nodes in the region; which these are.
    fn take_inside(&mut self, mesh: &Mesh, field: &impl Field) -> Vec<bool> {
        let mut known = vec![false; self.places.len()];
        for (number, place) in self.places.iter().enumerate() {
            if field.value(place) >= 0.0 {
                continue;
            }
            if let Some(shares) = mesh.shares(place) {
                let tie = shares.iter().map(|share| (share.node, share.weight)).collect();
                self.inside.push((number as u32, tie));
                known[number] = true;
            }
        }
        known
    }

    /// What moves the others, layer by layer: straight on from two nodes behind one another, in the mean of all directions where there are
    /// two; where there are none, as the nodes beside it. A linear field is gone on with as it is.
    fn go_on(&mut self, numbers: &BTreeMap<[i32; 3], u32>, step: i32, mut known: Vec<bool>) {
        loop {
            // A layer rests on those before it alone, so that its order does not matter.
            let mut layer = Vec::new();
            for (at, number) in numbers.iter().filter(|(_, number)| !known[**number as usize]) {
                let near = |way: [i32; 3], times: i32| {
                    let at = std::array::from_fn(|a| at[a] + step * times * way[a]);
                    numbers.get(&at).copied().filter(|number| known[*number as usize])
                };
                let ways = (0..27).map(|k| [k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1]);
                let beside: Vec<([i32; 3], u32)> = ways.filter_map(|way| Some((way, near(way, 1)?))).collect();
                let behind = beside.iter().filter_map(|(way, first)| Some((*first, near(*way, 2)?)));
                let pairs: Vec<(u32, u32)> = behind.collect();
                let tie: Tie = match pairs.len() {
                    0 => beside.iter().map(|(_, n)| (*n, 1.0 / beside.len() as f64)).collect(),
                    n => {
                        let part = 1.0 / n as f64;
                        pairs
                            .iter()
                            .flat_map(|(one, two)| [(*one, 2.0 * part), (*two, -part)])
                            .collect()
                    }
                };
                if !tie.is_empty() {
                    layer.push((*number, tie));
                }
            }
            if layer.is_empty() {
                return;
            }
            layer.iter().for_each(|(number, _)| known[*number as usize] = true);
            self.beyond.append(&mut layer);
        }
    }

    /// Where all nodes are with these displacements of the mesh's free nodes (three numbers each, mm), behind what `into` has.
    pub fn displaced(&self, part: &[f64], into: &mut Vec<f32>) {
        let mut moved = vec![Vector3::zeros(); self.places.len()];
        for (number, tie) in &self.inside {
            let each = tie.iter().map(|(node, weight)| {
                let first = 3 * *node as usize;
                Vector3::new(part[first], part[first + 1], part[first + 2]) * *weight
            });
            moved[*number as usize] = each.sum();
        }
        for (number, tie) in &self.beyond {
            let each = tie.iter().map(|(node, weight)| moved[*node as usize] * *weight);
            moved[*number as usize] = each.sum();
        }
        for (place, by) in self.places.iter().zip(&moved) {
            into.extend((place + by).iter().map(|x| *x as f32));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Ball, Settings};
    use super::*;
    use crate::space::element::shape;

    const BALL: Ball = Ball {
        centre: Vector3::new(0.3, -0.2, 0.1),
        radius: 10.0,
    };

    /// A ball in cubes of two sizes, so that nodes hang and cubes at its surface are nearly empty.
    fn mesh() -> Mesh {
        let settings = Settings {
            levels: 1,
            ..Settings::of_side(5.0)
        };
        let corners = [Vector3::repeat(-11.0), Vector3::repeat(11.5)];
        let refine = |low: &Vector3<f64>, _: &Vector3<f64>| low.x > 0.0;
        Mesh::new(&BALL, corners, &settings, &refine).unwrap()
    }

    #[test]
    fn cubes_inside_move_every_place_as_the_mesh_does() {
        let mesh = mesh();
        let lattice = mesh.lattice(&BALL).unwrap();
        let part: Vec<f64> = (0..mesh.unknowns())
            .map(|k| ((k * 37) % 101) as f64 / 50.0 - 1.0)
            .collect();
        let mut now = Vec::new();
        lattice.displaced(&part, &mut now);
        let mut inside = 0;
        for cube in &lattice.cubes {
            let place = |node: u32| Vector3::from_fn(|a, _| f64::from(now[3 * node as usize + a]));
            if !cube
                .nodes
                .iter()
                .all(|n| BALL.value(&lattice.places[*n as usize]) < 0.0)
            {
                continue;
            }
            inside += 1;
            for at in [[0.0, 0.0, 0.0], [0.3, -0.7, 0.9], [-0.99, 0.2, 0.5]] {
                let values = shape::values_27(at);
                let by_cube: Vector3<f64> = (0..27).map(|k| place(cube.nodes[k]) * values[k]).sum();
                let rest = cube.low + (Vector3::from(at).add_scalar(1.0)) * (0.5 * cube.side);
                let moved = mesh.shares(&rest).unwrap();
                let moved: Vector3<f64> = moved
                    .iter()
                    .map(|share| {
                        let first = 3 * share.node as usize;
                        Vector3::new(part[first], part[first + 1], part[first + 2]) * share.weight
                    })
                    .sum();
                // Coordinates are off by half an ulp of 16, 1e-6 mm; weights of 27 nodes sum to at most 2 in magnitude.
                assert!(
                    (by_cube - rest - moved).amax() < 4e-6,
                    "{rest} {}",
                    by_cube - rest - moved
                );
            }
        }
        assert!(inside > 100, "{inside}");
    }

    #[test]
    fn nodes_outside_go_on_straight_ahead() {
        let mesh = mesh();
        let lattice = mesh.lattice(&BALL).unwrap();
        let linear = |x: &Vector3<f64>| Vector3::new(0.3 + 0.1 * x.y, -0.2 * x.x, 0.05 * x.z + 0.1 * x.x);
        let part: Vec<f64> = mesh.nodes.iter().flat_map(|x| <[f64; 3]>::from(linear(x))).collect();
        let mut now = Vec::new();
        lattice.displaced(&part, &mut now);
        let outside = lattice.places.iter().filter(|place| BALL.value(place) >= 0.0);
        assert!(outside.count() > 100);
        for (number, place) in lattice.places.iter().enumerate() {
            let found = Vector3::from_fn(|a, _| f64::from(now[3 * number + a]));
            // As above; going on triples an error in each of at most two layers of nodes.
            let off = (found - place - linear(place)).amax();
            assert!(off < 1e-5, "{place} {off}");
        }
    }
}
