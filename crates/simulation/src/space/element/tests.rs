//! Patch tests, rigid motions, derivatives, sizes, locking, and what is refused.

mod derivatives;
mod exact;
mod locking;
mod refused;

use nalgebra::{DMatrix, DVector, Matrix3, Matrix4, Rotation3, SMatrix, Vector3, Vector4};

use super::*;
use crate::law::{Law, Ogden};
use crate::space::law::{Fibre, Material};

const DILATATIONS: [Dilatation; 3] = [Dilatation::Plain, Dilatation::Constant, Dilatation::Linear];
const ORDERS: [Order; 2] = [Order::Linear, Order::Quadratic];

/// Deterministic numbers in (-1, 1).
fn numbers(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
    move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

fn materials() -> Vec<Material> {
    let laws = [
        Law::StVenantKirchhoff,
        Law::Linear,
        Law::NeoHookean,
        Law::StableNeoHookean,
        Law::Ogden(Ogden::new(&[(0.7, 1.3), (0.1, 5.0), (-0.2, -2.0)]).unwrap()),
    ];
    let mut materials = laws.map(|law| Material::new(law, 2.0, 0.45).unwrap()).to_vec();
    materials.push(Material {
        fibre: Some(Fibre::new(Vector3::new(1.0, 1.0, -0.3), 0.5, 0.8).unwrap()),
        ..materials[2]
    });
    materials
}

/// An element and the reference positions of its nodes.
struct Cell {
    table: Table,
    nodes: Vec<Vector3<f64>>,
}

fn cube(order: Order, size: f64, dilatation: Dilatation) -> Cell {
    let n = if order == Order::Linear { 2 } else { 3 };
    let node = |k: usize| Vector3::new((k % n) as f64, (k / n % n) as f64, (k / n / n) as f64);
    Cell {
        table: Table::cube(order, size, dilatation).unwrap(),
        nodes: (0..n * n * n).map(|k| node(k) * (size / (n - 1) as f64)).collect(),
    }
}

/// Random points whose slopes are random but for this: they reproduce constant and linear fields of the nodes.
fn scattered(nodes: usize, points: usize, dilatation: Dilatation) -> Cell {
    let mut next = numbers((nodes * 1000 + points) as u64);
    let mut place = || Vector3::new(next(), next(), next()) * 2.0;
    let at: Vec<Vector3<f64>> = (0..nodes).map(|_| place()).collect();
    let extended = |x: &Vector3<f64>| Vector4::new(1.0, x.x, x.y, x.z);
    let mass: Matrix4<f64> = at.iter().map(|x| extended(x) * extended(x).transpose()).sum();
    let mut wanted = SMatrix::<f64, 4, 3>::zeros();
    wanted.fixed_view_mut::<3, 3>(1, 0).copy_from(&Matrix3::identity());
    let points: Vec<Point> = (0..points)
        .map(|k| {
            let mut slopes: Vec<Vector3<f64>> = (0..nodes).map(|_| place() * 0.05).collect();
            for _ in 0..2 {
                let found: SMatrix<f64, 4, 3> = at.iter().zip(&slopes).map(|(x, q)| extended(x) * q.transpose()).sum();
                let change = mass.try_inverse().unwrap() * (wanted - found);
                for (x, q) in at.iter().zip(&mut slopes) {
                    *q += change.transpose() * extended(x);
                }
            }
            Point {
                weight: 0.05 + 0.01 * (k % 7) as f64,
                at: place(),
                slopes,
            }
        })
        .collect();
    Cell {
        table: Table::new(nodes, &points, dilatation).unwrap(),
        nodes: at,
    }
}

/// Cubes and scattered cells, one of them of more points than are kept between two passes.
fn cells(dilatation: Dilatation) -> Vec<Cell> {
    let mut cells = Vec::from(ORDERS.map(|order| cube(order, 1.5, dilatation)));
    for (nodes, points) in [(20, 12), (33, 80), (8, 1)] {
        cells.push(scattered(nodes, points, dilatation));
    }
    cells
}

/// Displacements `u(x)` of the nodes.
fn displaced(cell: &Cell, u: impl Fn(&Vector3<f64>) -> Vector3<f64>) -> Vec<f64> {
    cell.nodes.iter().flat_map(|x| <[f64; 3]>::from(u(x))).collect()
}

fn noisy(cell: &Cell, size: f64, seed: u64) -> Vec<f64> {
    let mut next = numbers(seed);
    (0..3 * cell.table.nodes()).map(|_| size * next()).collect()
}

/// A packed lower triangle as a full matrix.
fn full(packed: &[f64], size: usize) -> DMatrix<f64> {
    DMatrix::from_fn(size, size, |i, j| {
        let (row, column) = (i.max(j), i.min(j));
        packed[row * (row + 1) / 2 + column]
    })
}

fn stiffness(table: &Table, material: &Material, u: &[f64], convex: bool) -> DMatrix<f64> {
    let mut packed = vec![f64::NAN; 7];
    table.stiffness(material, u, convex, &mut packed).unwrap();
    let size = 3 * table.nodes();
    assert_eq!(packed.len(), size * (size + 1) / 2);
    full(&packed, size)
}

fn forces(table: &Table, material: &Material, u: &[f64]) -> (f64, DVector<f64>) {
    let mut forces = DVector::zeros(3 * table.nodes());
    let energy = table.gradient(material, u, forces.as_mut_slice()).unwrap();
    (energy, forces)
}
