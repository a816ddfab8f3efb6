//! Sums over the elements of a mesh: four of one table at once, the others one by one.

use std::collections::BTreeMap;

use crate::space::cells::{Element, Mesh};
use crate::space::lanes::{CELLS, Lanes};
use crate::space::law::Material;
use crate::sparse::Triplets;

/// Elements in the order in which they are summed: the same in every run and on every machine, as the bits of an element do
/// not depend on those beside it ([`crate::space::lanes`]).
#[derive(Debug, Clone, Default)]
pub(super) struct Sums {
    /// Four elements of one table, table by table.
    fours: Vec<[u32; CELLS]>,
    /// All others, in the mesh's order.
    rest: Vec<u32>,
}

impl Sums {
    /// Of the elements of a mesh.
    pub(super) fn new(mesh: &Mesh) -> Self {
        let mut by_table: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for (number, element) in mesh.elements.iter().enumerate() {
            by_table.entry(element.table).or_default().push(number as u32);
        }
        let mut sums = Self::default();
        for elements in by_table.values() {
            // What is left of a table's elements goes with those that share theirs with no other.
            let (fours, rest) = elements.as_chunks::<CELLS>();
            sums.fours.extend(fours);
            sums.rest.extend(rest);
        }
        sums.rest.sort_unstable();
        sums
    }

    /// How many elements are done four at once, and how many one by one.
    pub(super) fn counts(&self) -> [usize; 2] {
        [CELLS * self.fours.len(), self.rest.len()]
    }

    /// The elastic energy of displacements of the free nodes. `None` where an element has none.
    pub(super) fn energy(&self, mesh: &Mesh, material: &Material, a: &[f64]) -> Option<f64> {
        let (mut energy, mut lanes, mut u) = (0.0, Lanes::new(), Buffers::default());
        for four in &self.fours {
            let (table, u) = (mesh.table(element(mesh, four[0])), u.of_four(mesh, *four, a));
            for each in lanes.energy(table, material, u) {
                energy += each?;
            }
        }
        for one in &self.rest {
            let element = element(mesh, *one);
            energy += lanes.energy_of_one(mesh.table(element), material, u.of_one(element, a))?;
        }
        Some(energy)
    }

    /// The same, and its derivatives added to `gradient`.
    pub(super) fn gradient(&self, mesh: &Mesh, material: &Material, a: &[f64], gradient: &mut [f64]) -> Option<f64> {
        let (mut energy, mut lanes, mut u) = (0.0, Lanes::new(), Buffers::default());
        let mut forces = [const { Vec::new() }; CELLS];
        for four in &self.fours {
            let (table, u) = (mesh.table(element(mesh, four[0])), u.of_four(mesh, *four, a));
            let each = forces.each_mut().map(|f| zeros(f, 3 * table.nodes()));
            for each in lanes.gradient(table, material, u, each) {
                energy += each?;
            }
            for (one, forces) in four.iter().zip(&forces) {
                scatter(element(mesh, *one), forces, gradient);
            }
        }
        for one in &self.rest {
            let (element, forces) = (element(mesh, *one), &mut forces[0]);
            let (table, u) = (mesh.table(element), u.of_one(element, a));
            energy += lanes.gradient_of_one(table, material, u, zeros(forces, u.len()))?;
            scatter(element, forces, gradient);
        }
        Some(energy)
    }

    /// The second derivatives, added to `sink` from the unknown `offset` on.
    pub(super) fn hessian(
        &self,
        (mesh, material): (&Mesh, &Material),
        a: &[f64],
        convex: bool,
        sink: &mut Triplets,
        offset: usize,
    ) -> Option<()> {
        let (mut lanes, mut u, mut packed) = (Lanes::new(), Buffers::default(), [const { Vec::new() }; CELLS]);
        let mut add = |element: &Element, packed: &[f64]| {
            let unknown = |p: usize| offset + 3 * element.nodes[p / 3] as usize + p % 3;
            sink.add_block((0..3 * element.nodes.len()).map(unknown), packed);
        };
        for four in &self.fours {
            let (table, u) = (mesh.table(element(mesh, four[0])), u.of_four(mesh, *four, a));
            // All four or none: what one of them lacks the whole matrix lacks.
            if lanes.stiffness(table, material, u, convex, &mut packed) != [true; CELLS] {
                return None;
            }
            four.iter()
                .zip(&packed)
                .for_each(|(one, packed)| add(element(mesh, *one), packed));
        }
        for one in &self.rest {
            let (element, packed) = (element(mesh, *one), &mut packed[0]);
            let u = u.of_one(element, a);
            lanes
                .stiffness_of_one(mesh.table(element), material, u, convex, packed)
                .then_some(())?;
            add(element, packed);
        }
        Some(())
    }
}

fn element(mesh: &Mesh, number: u32) -> &Element {
    &mesh.elements[number as usize]
}

/// So many zeros.
fn zeros(forces: &mut Vec<f64>, count: usize) -> &mut [f64] {
    forces.clear();
    forces.resize(count, 0.0);
    forces
}

/// Adds the forces on an element's nodes to those on all.
fn scatter(element: &Element, forces: &[f64], gradient: &mut [f64]) {
    for (node, force) in element.nodes.iter().zip(forces.chunks_exact(3)) {
        (0..3).for_each(|k| gradient[3 * *node as usize + k] += force[k]);
    }
}

/// Memory for the displacements of elements' nodes.
#[derive(Default)]
struct Buffers([Vec<f64>; CELLS]);

impl Buffers {
    fn of_one(&mut self, element: &Element, a: &[f64]) -> &[f64] {
        taken(&element.nodes, a, &mut self.0[0]);
        &self.0[0]
    }

    fn of_four(&mut self, mesh: &Mesh, four: [u32; CELLS], a: &[f64]) -> [&[f64]; CELLS] {
        for (one, u) in four.iter().zip(&mut self.0) {
            taken(&element(mesh, *one).nodes, a, u);
        }
        self.0.each_ref().map(Vec::as_slice)
    }
}

/// The displacements of an element's nodes.
pub(super) fn taken(nodes: &[u32], a: &[f64], u: &mut Vec<f64>) {
    u.clear();
    for node in nodes {
        u.extend_from_slice(&a[3 * *node as usize..3 * *node as usize + 3]);
    }
}
