//! Contact with bone that does not move: balance, the way there and back, squeezing, Hertz, and rest by weight.

use std::sync::Arc;

use nalgebra::{Point3, Vector3};
use simulation::control::{Newton, Settings as Control};
use simulation::law::Law;
use simulation::space::cells::{Ball, Curved, Mesh, Plane, Settings};
use simulation::space::equilibrium::{Equilibrium, NoEquilibrium, Tolerance, settle};
use simulation::space::law::Material;
use simulation::space::level_set::LevelSet;
use simulation::space::solid::Deformable;
use simulation::space::system::System;
use simulation::space::term::{ContactForce, ObstacleContact, Term, TubeContact};
use simulation::space::tube::Tube;
use simulation::sparse::Dissection;

use crate::terms::{check, scene};

const YOUNG: f64 = 5e-3;

pub(crate) fn newton(system: &System, tolerance: f64) -> Newton {
    let control = Control {
        provisional: true,
        tolerance,
        ..Control::default()
    };
    Newton::ordered_by(control, Dissection::by_places(&system.places(), &[]).unwrap())
}

/// Holds a solid on the planes of symmetry x = 0 and y = 0, and z = 0 where asked.
pub(crate) fn hold(system: &mut System, body: usize, mesh: &Mesh, axes: usize) {
    let offset = system.bodies.offset(body);
    for k in 0..axes {
        for n in mesh.nodes_where(|x| x[k].abs() < 1e-9) {
            system.fixed[offset + 3 * n + k] = true;
        }
    }
}

/// All in the half space below a height.
pub(crate) fn below(height: f64) -> Plane {
    Plane {
        point: Vector3::new(0.0, 0.0, height),
        normal: Vector3::z(),
    }
}

pub(crate) fn surface(field: impl Curved + 'static, radius: f64) -> LevelSet {
    LevelSet::new(Arc::new(field), [Vector3::repeat(-70.0), Vector3::repeat(70.0)], radius).unwrap()
}

/// A quarter of a block between a tube above and bone below.
pub(crate) struct Pressed {
    system: System,
    newton: Newton,
    a: Vec<f64>,
    height: f64,
    radius: f64,
}

impl Pressed {
    pub(crate) fn new([half, height]: [f64; 2], nu: f64, radius: f64, bone: LevelSet, settings: &Settings) -> Self {
        let corners = [Vector3::zeros(), Vector3::new(half, half, height)];
        let tip = Vector3::new(0.0, 0.0, height);
        let fine = |low: &Vector3<f64>, high: &Vector3<f64>| (tip.sup(low).inf(high) - tip).norm() < 1.5 * radius;
        let mesh = Mesh::new(&below(1e3), corners, settings, &fine).unwrap();
        let material = Material::new(Law::NeoHookean, YOUNG, nu).unwrap();
        let mut system = System::new();
        let body = system.add(Deformable::new(mesh.clone(), material, Vector3::zeros()).unwrap());
        hold(&mut system, body, &mesh, 2);
        let stiffness = 20.0 * YOUNG / settings.side;
        let bone = ObstacleContact::new(&system.bodies, body, bone, stiffness, |_, n| n.z < -0.5).unwrap();
        system.obstacles.push(bone);
        let mut pressed = Self {
            newton: newton(&system, 1e-8),
            a: system.initial(),
            system,
            height,
            radius,
        };
        let tube = TubeContact::new(
            &pressed.system.bodies,
            body,
            pressed.tube(0.0),
            2.0 * stiffness,
            |_, n| n.z > 0.5,
        );
        pressed.system.tubes.push(tube.unwrap());
        pressed
    }

    fn tube(&self, depth: f64) -> Tube {
        let tip = Point3::new(0.0, 0.0, self.height - depth + self.radius);
        Tube::straight(tip, Vector3::z(), 200.0, self.radius).unwrap()
    }

    /// State, force on the tube along its way, and on the bone.
    pub(crate) fn to(&mut self, depth: f64) -> Result<(Equilibrium, f64, ContactForce), NoEquilibrium> {
        let tube = self.tube(depth);
        self.system.tubes[0].move_to(tube);
        let found = settle(&mut self.system, &mut self.newton, &mut self.a, &Tolerance::default())?;
        let (bodies, a) = (&self.system.bodies, &self.a);
        let force = self.system.tubes[0].force(bodies, a);
        Ok((found, force.force.z, self.system.obstacles[0].force(bodies, a)))
    }
}

#[test]
fn derivatives_of_contact_with_a_plane_and_a_ball() {
    let (system, a) = scene();
    let ball = Ball {
        centre: Vector3::new(2.0, 1.0, 31.0),
        radius: 12.0,
    };
    let plane = Plane {
        point: Vector3::new(0.0, 0.0, 19.0),
        normal: Vector3::new(0.2, 0.3, -2.0),
    };
    for bone in [surface(ball, 12.0), surface(plane, 5.0)] {
        let mut contact = ObstacleContact::new(&system.bodies, 0, bone, 2.0, |_, _| true).unwrap();
        check(&contact, &system, &a);
        contact.update(&system.bodies, &a);
        check(&contact, &system, &a);
        let force = contact.force(&system.bodies, &a);
        assert!(
            force.points > 3 && force.force.z > 0.0 && force.depth > 0.5,
            "{force:?}"
        );
    }
}

#[test]
fn what_the_tube_pushes_the_bone_carries_and_the_way_back_is_the_way_there() {
    let ball = Ball {
        centre: Vector3::new(0.0, 0.0, -40.0),
        radius: 40.0,
    };
    let settings = Settings {
        levels: 1,
        ..Settings::of_side(15.0)
    };
    for bone in [surface(below(0.0), 10.0), surface(ball, 40.0)] {
        let mut block = Pressed::new([45.0, 45.0], 0.45, 10.0, bone, &settings);
        let ways = [1.0, 4.0, 7.0, 10.0, 7.0, 4.0, 1.0];
        let found = ways.map(|depth| {
            let (found, tube, bone) = block.to(depth).unwrap();
            println!(
                "{depth} mm: tube {tube:.8} N, bone {:.8} N at {} points, least J {:.3}, depth {:.1e}, {} rounds, {} steps",
                bone.force.z, bone.points, found.least_determinant, found.depth, found.rounds, found.iterations
            );
            // Some thousand unknowns each within 1e-8 of the largest force, which is a twentieth of the sum, and pressures
            // within 1e-6 of that.
            assert!((tube + bone.force.z).abs() < 1e-6 * tube, "{tube} {bone:?}");
            tube
        });
        for k in 0..3 {
            // Both within the tolerances of forces.
            assert!((found[k] / found[6 - k] - 1.0).abs() < 1e-5, "{found:?}");
        }
    }
}

#[test]
fn tissue_is_squeezed_between_tube_and_bone_to_three_tenths_of_its_volume() {
    // A layer of 20 mm under a tube of 60 mm radius, which covers most of it.
    let bone = surface(below(0.0), 10.0);
    let mut layer = Pressed::new([30.0, 20.0], 0.1, 60.0, bone, &Settings::of_side(10.0));
    let (mut least, mut depth) = (1.0, 0.0);
    while least > 0.3 && depth < 18.5 {
        depth += 1.0;
        let (found, tube, bone) = layer.to(depth).unwrap();
        println!(
            "{depth} mm: {tube:.6} N, J {:.3}, {} steps",
            found.least_determinant, found.iterations
        );
        assert!((tube + bone.force.z).abs() < 1e-6 * tube, "{tube} {bone:?}");
        least = found.least_determinant;
    }
    assert!(least <= 0.3, "{least} at {depth} mm");
}

#[test]
fn what_is_in_the_bone_or_cannot_see_it_is_refused() {
    let settings = Settings::of_side(15.0);
    let refused = |bone| {
        let mut block = Pressed::new([45.0, 45.0], 0.45, 40.0, bone, &settings);
        block.to(1.0).map(|(found, _, _)| found.rounds)
    };
    let deep = refused(surface(below(6.0), 10.0));
    assert!(
        matches!(deep, Err(NoEquilibrium::TooDeep { most: 5.0, .. })),
        "{deep:?}"
    );
    // A ball of 4 mm between points 3 mm from the middle between them.
    let ball = Ball {
        centre: Vector3::new(0.0, 0.0, -4.0),
        radius: 4.0,
    };
    let coarse = refused(surface(ball, 4.0));
    assert!(
        matches!(coarse, Err(NoEquilibrium::TooCoarse { most: 2.0, .. })),
        "{coarse:?}"
    );
}

#[test]
fn a_body_rests_on_bone_by_its_weight() {
    // A quarter of a ball, 1 g/cm^3.
    let (radius, weight) = (20.0, 9.81e-6);
    let centre = Vector3::new(0.0, 0.0, radius + 1.0);
    let ball = Ball { centre, radius };
    let corners = [Vector3::zeros(), Vector3::new(21.0, 21.0, 42.0)];
    let settings = Settings {
        levels: 1,
        ..Settings::of_side(7.0)
    };
    let foot = Vector3::zeros();
    let mesh = Mesh::new(&ball, corners, &settings, &|low, high| {
        foot.sup(low).inf(high).norm() < 10.0
    })
    .unwrap();
    let volume = mesh.volume();
    let material = Material::new(Law::NeoHookean, YOUNG, 0.45).unwrap();
    let mut system = System::new();
    let body = system.add(Deformable::new(mesh.clone(), material, -Vector3::z() * weight).unwrap());
    hold(&mut system, body, &mesh, 2);
    let bone = ObstacleContact::new(&system.bodies, body, surface(below(0.0), 10.0), 0.02, |_, n| n.z < 0.0).unwrap();
    system.obstacles.push(bone);
    let (mut search, mut a) = (newton(&system, 1e-8), system.initial());
    let found = settle(&mut system, &mut search, &mut a, &Tolerance::default()).unwrap();
    let force = system.obstacles[0].force(&system.bodies, &a);
    println!("{found:?}, {force:?}, weight {}", weight * volume);
    // A thousand unknowns within 1e-8 of the largest force, and pressures within 1e-6 of it.
    assert!((force.force.z / (-weight * volume) - 1.0).abs() < 1e-6);
    // It came down by the gap and more.
    assert!(force.points > 3 && a[3 * mesh.nodes_where(|x| x.norm() < 8.0)[0] + 2] < -0.9);
}
