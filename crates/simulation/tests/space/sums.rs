//! Sums over elements and springs against the same sums one by one.

use nalgebra::{Rotation3, Vector3};
use simulation::law::Law;
use simulation::space::cells::{Ball, Mesh, Plane, Settings};
use simulation::space::law::Material;
use simulation::space::solid::{Deformable, Solid};
use simulation::space::system::System;
use simulation::space::term::{Springs, Term};
use simulation::sparse::Triplets;

use crate::random;

/// A deformable solid whose points tell nothing of their nodes: springs go point by point.
#[derive(Debug)]
struct Silent(Deformable);

impl Solid for Silent {
    fn parameters(&self) -> usize {
        self.0.parameters()
    }
    fn translate(&self, a: &mut [f64], by: Vector3<f64>) {
        self.0.translate(a, by);
    }
    fn rotate(&self, a: &mut [f64], by: &Rotation3<f64>, centre: Vector3<f64>) {
        self.0.rotate(a, by, centre);
    }
    fn energy(&self, a: &[f64]) -> Option<f64> {
        self.0.energy(a)
    }
    fn gradient(&self, a: &[f64], gradient: &mut [f64]) -> Option<f64> {
        self.0.gradient(a, gradient)
    }
    fn hessian(&self, a: &[f64], convex: bool, sink: &mut Triplets, offset: usize) -> Option<()> {
        self.0.hessian(a, convex, sink, offset)
    }
    fn weight(&self, forces: &mut [f64]) {
        self.0.weight(forces);
    }
    fn least_determinant(&self, a: &[f64]) -> f64 {
        self.0.least_determinant(a)
    }
    fn stiffness_scale(&self) -> f64 {
        self.0.stiffness_scale()
    }
    fn extent(&self) -> f64 {
        self.0.extent()
    }
    fn places(&self) -> Vec<[f64; 3]> {
        self.0.places()
    }
    fn points(&self) -> usize {
        self.0.points()
    }
    fn reference(&self, point: usize) -> (Vector3<f64>, Vector3<f64>, f64) {
        self.0.reference(point)
    }
    fn point(&self, a: &[f64], point: usize) -> Vector3<f64> {
        self.0.point(a, point)
    }
    fn rows(&self, a: &[f64], point: usize, visit: &mut dyn FnMut(usize, Vector3<f64>)) {
        self.0.rows(a, point, visit);
    }
}

/// A block of 5 x 5 x 5 whole cubes, one number of which is not one of fours; a ball in cubes of two sizes.
fn meshes() -> [Mesh; 2] {
    let everywhere = Plane {
        point: Vector3::new(0.0, 0.0, 1e3),
        normal: Vector3::z(),
    };
    let corners = [Vector3::zeros(), Vector3::repeat(50.0)];
    let block = Mesh::new(&everywhere, corners, &Settings::of_side(10.0), &|_, _| false);
    let ball = Ball {
        centre: Vector3::zeros(),
        radius: 20.0,
    };
    let settings = Settings {
        levels: 1,
        ..Settings::of_side(9.0)
    };
    let ball = Mesh::new(
        &ball,
        [Vector3::repeat(-21.0), Vector3::repeat(21.0)],
        &settings,
        &|low, _| low.x < -5.0,
    );
    [block.unwrap(), ball.unwrap()]
}

fn state(count: usize) -> Vec<f64> {
    let mut state = 5;
    (0..count).map(|_| 0.3 * (random(&mut state) - 0.5)).collect()
}

fn off(found: &[f64], expected: &[f64]) -> f64 {
    let largest = expected.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    let off = found
        .iter()
        .zip(expected)
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f64::max);
    assert!(largest > 0.0 && found.len() == expected.len());
    off / largest
}

/// Energy, forces and the stiffness times a vector, element by element.
fn one_by_one(mesh: &Mesh, material: &Material, a: &[f64]) -> (f64, Vec<f64>, Vec<f64>) {
    let (mut energy, mut forces, mut sink) = (0.0, vec![0.0; a.len()], Triplets::new(a.len()));
    for element in &mesh.elements {
        let unknowns: Vec<usize> = element
            .nodes
            .iter()
            .flat_map(|n| (0..3).map(|k| 3 * *n as usize + k))
            .collect();
        let u: Vec<f64> = unknowns.iter().map(|p| a[*p]).collect();
        let (mut own, mut packed) = (vec![0.0; u.len()], Vec::new());
        energy += mesh.table(element).gradient(material, &u, &mut own).unwrap();
        unknowns.iter().zip(own).for_each(|(p, f)| forces[*p] += f);
        mesh.table(element).stiffness(material, &u, false, &mut packed).unwrap();
        sink.add_block(unknowns.into_iter(), &packed);
    }
    (energy, forces, sink.product(&state(a.len())))
}

#[test]
fn four_at_once_is_one_by_one() {
    for (mesh, law) in meshes()
        .iter()
        .flat_map(|m| [Law::NeoHookean, Law::StableNeoHookean].map(|law| (m, law)))
    {
        let material = Material::new(law, 1.0, 0.45).unwrap();
        let solid = Deformable::new(mesh.clone(), material, Vector3::zeros()).unwrap();
        let [four, one] = solid.together();
        assert!(four > 8 && one > 0 && four + one == mesh.elements.len(), "{four} {one}");
        let a = state(solid.parameters());
        let (energy, forces, product) = one_by_one(mesh, &material, &a);
        let run = || {
            let (mut found, mut sink) = (vec![0.0; a.len()], Triplets::new(a.len()));
            let energy = solid.gradient(&a, &mut found).unwrap();
            solid.hessian(&a, false, &mut sink, 0).unwrap();
            (
                energy,
                found,
                sink.product(&a.iter().rev().copied().collect::<Vec<f64>>()),
                sink,
            )
        };
        let found = run();
        // Some 1e3 additions, each rounded to 1e-16 of a sum whose parts do not cancel much.
        assert!((found.0 / energy - 1.0).abs() < 1e-13 && solid.energy(&a).unwrap() == found.0);
        assert!(off(&found.1, &forces) < 1e-13);
        assert!(off(&found.3.product(&state(a.len())), &product) < 1e-13);
        let again = run();
        assert_eq!((found.0, found.1, found.2), (again.0, again.1, again.2));
    }
}

#[test]
fn a_state_that_the_law_forbids_has_no_energy_wherever_it_is() {
    let [mesh, _] = meshes();
    let material = Material::new(Law::NeoHookean, 1.0, 0.45).unwrap();
    let solid = Deformable::new(mesh, material, Vector3::zeros()).unwrap();
    let count = solid.parameters();
    // A node in the middle of each element in turn: of fours in each lane, and of those done one by one.
    for node in solid.mesh().elements.iter().map(|e| e.nodes[13] as usize) {
        let mut a = vec![0.0; count];
        a[3 * node] = 40.0;
        let mut sink = Triplets::new(count);
        assert!(solid.energy(&a).is_none() && solid.gradient(&a, &mut vec![0.0; count]).is_none());
        assert!(solid.hessian(&a, false, &mut sink, 0).is_none());
    }
}

#[test]
fn springs_by_patches_are_springs_by_points() {
    for mesh in meshes() {
        let material = Material::new(Law::NeoHookean, 1.0, 0.45).unwrap();
        let solid = Deformable::new(mesh, material, Vector3::zeros()).unwrap();
        let a = state(2 * solid.parameters());
        let mut systems = [System::new(), System::new()];
        // Behind another solid, so that unknowns are counted from its own first one.
        for system in &mut systems {
            system.add(solid.clone());
        }
        systems[0].add(solid.clone());
        systems[1].add(Silent(solid));
        let found = systems.each_ref().map(|system| {
            let bodies = &system.bodies;
            let springs = Springs::new(
                bodies,
                1,
                |at, n| if n.z < 0.3 { 1.0 + 0.01 * at.x } else { 0.0 },
                |x| x * 1.01,
            );
            let (mut gradient, mut sink) = (vec![0.0; a.len()], Triplets::new(a.len()));
            let energy = springs.gradient(bodies, &a, &mut gradient).unwrap();
            assert!((springs.energy(bodies, &a).unwrap() / energy - 1.0).abs() < 1e-14);
            springs.hessian(bodies, &a, false, &mut sink).unwrap();
            (
                energy,
                gradient,
                sink.product(&state(a.len())),
                springs.reaction(bodies, &a),
            )
        });
        let [one, other] = found;
        assert!((one.0 / other.0 - 1.0).abs() < 1e-13 && one.3 == other.3);
        assert!(off(&one.1, &other.1) < 1e-13 && off(&one.2, &other.2) < 1e-13);
    }
}
