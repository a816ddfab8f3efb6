//! Solids moved by particles: motions that they have exactly, derivatives, and states against closed forms.

use nalgebra::{Matrix3, Rotation3, Vector3};
use simulation::law::Law;
use simulation::space::cells::{Ball, Mesh, Settings};
use simulation::space::equilibrium::{Tolerance, settle};
use simulation::space::frames::{self, Frames, State};
use simulation::space::law::Material;
use simulation::space::solid::{NoParticles, Particle, Particles, Solid};
use simulation::space::system::System;
use simulation::space::term::{ObstacleContact, Springs};
use simulation::space::tube::Tube;
use simulation::sparse::Triplets;

use crate::contact::obstacle::{below, newton, surface};
use crate::contact::organs::block;
use crate::random;

fn material() -> Material {
    Material::new(Law::NeoHookean, 1.0, 0.4).unwrap()
}

/// A ball of 20 mm, integrated in cubes of 7 mm, and particles 14 mm apart.
fn ball() -> (Ball, Mesh, Vec<Particle>) {
    let ball = Ball {
        centre: Vector3::new(0.0, 0.0, 21.0),
        radius: 20.0,
    };
    let corners = [Vector3::new(-21.0, -21.0, 0.0), Vector3::new(21.0, 21.0, 42.0)];
    let of = |side: f64| Mesh::new(&ball, corners, &Settings::of_side(side), &|_, _| false).unwrap();
    let particles = Particle::of_cubes(&of(14.0), 1.3);
    (ball, of(7.0), particles)
}

/// The unknowns of an affine motion, by what they are defined to be.
fn affine(particles: &[Particle], gradient: &Matrix3<f64>) -> Vec<f64> {
    let of = |p: &Particle| {
        let columns = gradient * p.radius;
        let all = [
            gradient * p.at,
            columns.column(0).into(),
            columns.column(1).into(),
            columns.column(2).into(),
        ];
        all.map(<[f64; 3]>::from).concat()
    };
    particles.iter().flat_map(of).collect()
}

#[test]
fn a_motion_without_strain_costs_nothing_and_moves_the_surface() {
    let (ball, mesh, particles) = ball();
    let solid = Particles::new(&mesh, material(), Vector3::zeros(), &particles).unwrap();
    let mut a = solid.initial();
    let turn = Rotation3::from_scaled_axis(Vector3::new(0.5, -1.0, 0.8));
    let way = Vector3::new(3.0, 4.0, -5.0);
    solid.rotate(&mut a, &turn, ball.centre);
    solid.translate(&mut a, way);
    // Rounding of a gradient of order one.
    let energy = solid.energy(&a).unwrap();
    assert!(energy.abs() < 1e-14 * mesh.volume(), "{energy:e}");
    for k in 0..solid.points() {
        let (at, _, _) = solid.reference(k);
        let exact = ball.centre + turn * (at - ball.centre) + way;
        assert!((solid.point(&a, k) - exact).norm() < 1e-12);
        assert!((solid.stretch(&a, k) - 1.0).abs() < 1e-12);
    }
}

#[test]
fn an_affine_motion_has_the_energy_of_its_density() {
    let (_, mesh, particles) = ball();
    let material = material();
    let solid = Particles::new(&mesh, material, Vector3::zeros(), &particles).unwrap();
    let gradient = Matrix3::new(0.1, 0.2, -0.1, 0.0, -0.15, 0.05, 0.1, 0.0, 0.2);
    let a = affine(&particles, &gradient);
    let exact = material.density(&gradient).unwrap() * mesh.volume();
    assert!((solid.energy(&a).unwrap() / exact - 1.0).abs() < 1e-12);
    let determinant = (Matrix3::identity() + gradient).determinant();
    assert!((solid.least_determinant(&a) - determinant).abs() < 1e-12);
    for inner in solid.inner() {
        assert!((inner.place(&a) - inner.at - gradient * inner.at).norm() < 1e-12);
    }
}

#[test]
fn derivatives_by_differences() {
    let (_, mesh, particles) = ball();
    let solid = Particles::new(&mesh, material(), Vector3::new(0.01, -0.02, 0.03), &particles).unwrap();
    let mut state = 5;
    let n = solid.parameters();
    let a: Vec<f64> = (0..n).map(|_| 0.4 * (random(&mut state) - 0.5)).collect();
    let direction: Vec<f64> = (0..n).map(|_| random(&mut state) - 0.5).collect();
    let mut gradient = vec![0.0; n];
    let energy = solid.gradient(&a, &mut gradient).unwrap();
    assert!((energy / solid.energy(&a).unwrap() - 1.0).abs() < 1e-12);
    let mut hessian = Triplets::new(n);
    solid.hessian(&a, false, &mut hessian, 0).unwrap();
    let h = 1e-5;
    let sides = [h, -h].map(|h| {
        let a: Vec<f64> = a.iter().zip(&direction).map(|(a, d)| a + h * d).collect();
        let mut gradient = vec![0.0; n];
        (solid.gradient(&a, &mut gradient).unwrap(), gradient)
    });
    let slope: f64 = gradient.iter().zip(&direction).map(|(g, d)| g * d).sum();
    let size: f64 = gradient.iter().zip(&direction).map(|(g, d)| (g * d).abs()).sum();
    assert!(((sides[0].0 - sides[1].0) / (2.0 * h) - slope).abs() < 1e-7 * size);
    let product = hessian.product(&direction);
    let most = product.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    for (exact, (up, down)) in product.iter().zip(sides[0].1.iter().zip(&sides[1].1)) {
        // h^2 times third derivatives, and rounding by h.
        assert!(((up - down) / (2.0 * h) - exact).abs() < 1e-7 * most);
    }
}

/// Slopes and curvatures of shares, by differences of their values.
#[test]
fn shares_are_twice_differentiable() {
    let (_, mesh, particles) = ball();
    let solid = Particles::new(&mesh, material(), Vector3::zeros(), &particles).unwrap();
    let (h, at) = (1e-4, Vector3::new(3.0, -8.0, 17.0));
    let here = solid.shares(&at).unwrap();
    assert!(here.len() >= 4 * 8);
    for k in 0..3 {
        let [up, down] = [h, -h].map(|h| solid.shares(&(at + Vector3::ith(k, h))).unwrap());
        assert!(here.len() == up.len() && up.len() == down.len());
        for ((s, up), down) in here.iter().zip(&up).zip(&down) {
            // Third derivatives are some 100 by the radius' cube, and more where kernels end; rounding is 1e-16 by h.
            assert!(((up.weight - down.weight) / (2.0 * h) - s.slope[k]).abs() < 1e-9);
            let curved = (up.slope - down.slope) / (2.0 * h);
            assert!((curved - s.curvature.column(k)).norm() < 1e-8);
        }
    }
}

#[test]
fn a_ball_of_particles_rests_on_bone() {
    let (_, mesh, particles) = ball();
    let weight = -Vector3::z() * 1e-4;
    let solid = Particles::new(&mesh, material(), weight, &particles).unwrap();
    let mut system = System::new();
    let body = system.add(solid);
    // A soft bath keeps it from turning and going aside; it takes its part of the weight.
    let bath = Springs::new(&system.bodies, body, |_, _| 1e-6, |x| *x);
    system.others.push(Box::new(bath));
    let bone = ObstacleContact::new(&system.bodies, body, surface(below(0.0), 10.0), 2.0, |_, n| n.z < 0.0).unwrap();
    system.obstacles.push(bone);
    let (mut search, mut a) = (newton(&system, 1e-8), system.initial());
    settle(&mut system, &mut search, &mut a, &Tolerance::default()).unwrap();
    let force = system.obstacles[0].force(&system.bodies, &a).force.z;
    let mut held = vec![0.0; a.len()];
    system.others[0].gradient(&system.bodies, &a, &mut held).unwrap();
    // A translation of all particles has the sum of all forces.
    let by_bath: f64 = held.iter().skip(2).step_by(12).sum();
    let sum = force + by_bath - weight.z * mesh.volume();
    assert!(sum.abs() < 1e-6 * (weight.z * mesh.volume()).abs(), "{force} {by_bath}");
}

/// Loaded on all sides as a uniform strain asks for, a cube has that strain, and particles have it exactly: what is off comes of integrals of shares, which
/// are no polynomials.
#[test]
fn a_uniform_strain_is_found_the_nearer_the_smaller_the_cubes() {
    let strain = Matrix3::new(0.1, 0.05, 0.0, 0.0, -0.08, 0.0, 0.1, 0.0, 0.05);
    let (_, stress) = material().stress(&strain).unwrap();
    let off = [10.0, 5.0, 2.5].map(|side| {
        let of = |side| block([[-10.0; 3], [10.0; 3]], &Settings::of_side(side), &|_, _| false);
        let particles = Particle::of_cubes(&of(10.0), 1.3);
        let solid = Particles::new(&of(side), material(), Vector3::zeros(), &particles).unwrap();
        let mut loads = vec![0.0; solid.parameters()];
        for k in 0..solid.points() {
            let (_, n, area) = solid.reference(k);
            let force = Vector3::from_fn(|i, _| stress[i] * n.x + stress[i + 3] * n.y + stress[i + 6] * n.z) * area;
            solid.rows(&loads.clone(), k, &mut |p, by| loads[p] += force.dot(&by));
        }
        let mut system = System::new();
        let body = system.add(solid);
        let loads: Vec<(usize, f64)> = loads.into_iter().enumerate().collect();
        system.load(body, &loads);
        // Soft springs where the strain has the surface: nothing but turns and ways are theirs.
        let springs = Springs::new(&system.bodies, body, |_, _| 1e-3, |x| x + strain * x);
        system.others.push(Box::new(springs));
        let (mut search, mut a) = (newton(&system, 1e-10), system.initial());
        settle(&mut system, &mut search, &mut a, &Tolerance::default()).unwrap();
        let each = system.bodies.solid(body).inner();
        let off = each.iter().map(|i| (i.place(&a) - i.at - strain * i.at).norm());
        off.fold(0.0, f64::max)
    });
    println!("off by {off:?} mm of 2 mm");
    // Gauss's rule of three points an axis has order six; particles 10 mm apart are not far in it: a fourth stands for order two at least.
    assert!(
        off[0] < 0.03 && off[1] < off[0] / 4.0 && off[2] < off[1] / 4.0,
        "{off:?}"
    );
}

/// What nobody proves to be upright between the points looked at is never told as settled.
#[test]
fn frames_of_particles_are_approximate() {
    let (ball, mesh, particles) = ball();
    let solid = Particles::new(&mesh, material(), Vector3::zeros(), &particles).unwrap();
    let mut system = System::new();
    let body = system.add(solid);
    let bath = Springs::new(&system.bodies, body, |_, _| 0.01, |x| *x);
    system.others.push(Box::new(bath));
    let tip = |depth: f64| ball.centre + Vector3::z() * (ball.radius + 8.0 - depth);
    let tube = Tube::straight(tip(-1.0).into(), Vector3::z(), 100.0, 8.0).unwrap();
    let a = system.initial();
    let mut frames = Frames::new(system, a, body, tube, frames::Settings::default(), |_, n| n.z > 0.0).unwrap();
    let mut pose = *frames.tube().pose();
    let mut pressed = false;
    for _ in 0..6 {
        pose.translation.z -= 0.5;
        let frame = frames.frame(&pose);
        assert!(!matches!(frame.state, State::Settled), "{frame:?}");
        pressed |= frame.force.force.z > 0.0;
    }
    assert!(pressed);
}

#[test]
fn particles_that_move_no_solid_are_refused() {
    let (ball, mesh, particles) = ball();
    let of = |particles: &[Particle]| Particles::new(&mesh, material(), Vector3::zeros(), particles).map(|_| ());
    assert!(matches!(of(&[]), Err(NoParticles::Uncovered { .. })));
    assert!(matches!(
        of(&particles[..particles.len() / 2]),
        Err(NoParticles::Uncovered { .. })
    ));
    for (at, radius) in [
        (f64::NAN, 10.0),
        (0.0, f64::NAN),
        (0.0, 0.0),
        (0.0, -1.0),
        (f64::INFINITY, 1.0),
    ] {
        let mut all = particles.clone();
        all.push(Particle {
            at: Vector3::repeat(at),
            radius,
        });
        let particle = particles.len();
        assert_eq!(of(&all), Err(NoParticles::Particle { particle }));
    }
    let mut all = particles.clone();
    all.push(Particle {
        at: ball.centre + Vector3::x() * 1e9,
        radius: 1.0,
    });
    assert_eq!(
        of(&all),
        Err(NoParticles::Idle {
            particle: particles.len()
        })
    );
    // Large ones, of which too many reach each cube.
    let large: Vec<Particle> = (0..200)
        .map(|k| Particle {
            at: ball.centre + Vector3::z() * f64::from(k) * 0.1,
            radius: 100.0,
        })
        .collect();
    assert!(matches!(of(&large), Err(NoParticles::Table(_))));
}
