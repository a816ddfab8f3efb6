//! Numbers that are none are refused by name.

use nalgebra::{Isometry3, Point3, UnitQuaternion, Vector3};
use simulation::control::Failed;
use simulation::law::Law;
use simulation::space::cells::{Mesh, Settings};
use simulation::space::equilibrium::{NoEquilibrium, Tolerance, settle};
use simulation::space::law::Material;
use simulation::space::solid::Deformable;
use simulation::space::system::System;
use simulation::space::term::{Springs, TubeContact};
use simulation::space::tube::{Tube, TubeError};

use crate::common::{everywhere, newton};

#[test]
fn of_a_tube() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let tip = Tube::straight(Point3::new(bad, 0.0, 0.0), Vector3::z(), 100.0, 5.0);
        assert_eq!(tip.map(|_| ()), Err(TubeError::Pose), "{bad}");
        let along = Tube::straight(Point3::origin(), Vector3::new(0.0, bad, 1.0), 100.0, 5.0);
        assert!(matches!(along, Err(TubeError::Point { .. })), "{bad} {along:?}");
        let length = Tube::straight(Point3::origin(), Vector3::z(), bad, 5.0);
        assert!(matches!(length, Err(TubeError::Point { .. })), "{bad} {length:?}");
        let radius = Tube::straight(Point3::origin(), Vector3::z(), 100.0, bad);
        assert!(matches!(radius, Err(TubeError::Radius { .. })), "{bad} {radius:?}");
        let tube = Tube::straight(Point3::origin(), Vector3::z(), 100.0, 5.0).unwrap();
        assert_eq!(
            tube.at(Isometry3::translation(0.0, bad, 0.0)).map(|_| ()),
            Err(TubeError::Pose)
        );
        let turn = UnitQuaternion::new_unchecked(nalgebra::Quaternion::new(bad, 0.0, 0.0, 0.0));
        let pose = Isometry3::from_parts(nalgebra::Translation3::identity(), turn);
        assert_eq!(tube.at(pose).map(|_| ()), Err(TubeError::Pose));
    }
}

/// A block on a bed with a tube on it, and a search for its state from `a` with `change` made.
fn settled(change: impl Fn(&mut System, &mut Vec<f64>, &Mesh)) -> Result<(), NoEquilibrium> {
    let corners = [Vector3::zeros(), Vector3::repeat(10.0)];
    let mesh = Mesh::new(&everywhere(1e3), corners, &Settings::of_side(5.0), &|_, _| false).unwrap();
    let material = Material::new(Law::NeoHookean, 1.0, 0.45).unwrap();
    let mut system = System::new();
    system.add(Deformable::new(mesh.clone(), material, Vector3::zeros()).unwrap());
    let tube = Tube::straight(Point3::new(5.0, 5.0, 14.5), Vector3::z(), 100.0, 5.0).unwrap();
    let contact = TubeContact::new(&system.bodies, 0, tube, 10.0, |_, _| true).unwrap();
    system.tubes.push(contact);
    let bed = Springs::new(&system.bodies, 0, |_, n| if n.z < -0.5 { 1.0 } else { 0.0 }, |x| *x);
    system.others.push(Box::new(bed));
    let mut a = system.initial();
    change(&mut system, &mut a, &mesh);
    let mut newton = newton(&system, 1e-8);
    let asked = newton.settings;
    let found = settle(&mut system, &mut newton, &mut a, &Tolerance::default()).map(|_| ());
    // Rounds have tolerances of their own: left behind, the next search would call balanced what is not.
    assert_eq!(newton.settings, asked);
    found
}

#[test]
fn of_a_state_a_load_a_weight_and_a_spring() {
    assert_eq!(settled(|_, _, _| {}), Ok(()));
    for bad in [f64::NAN, f64::INFINITY] {
        let none = Err(NoEquilibrium::Search {
            round: 1,
            failed: Failed::NoEnergy,
        });
        assert_eq!(settled(|_, a, _| a[7] = bad), none, "{bad}");
        assert_eq!(settled(|system, _, _| system.loads[7] = bad), none, "{bad}");
        let spring = |system: &mut System, place: f64, stiff: f64| {
            let springs = Springs::new(&system.bodies, 0, |_, _| stiff, |x| x * place);
            system.others.push(Box::new(springs));
        };
        assert_eq!(settled(|system, _, _| spring(system, bad, 1.0)), none, "{bad}");
        assert_eq!(
            settled(|system, _, _| spring(system, 1.0, f64::INFINITY)),
            none,
            "{bad}"
        );
        let heavy = |system: &mut System, a: &mut Vec<f64>, mesh: &Mesh| {
            let material = Material::new(Law::NeoHookean, 1.0, 0.45).unwrap();
            system.add(Deformable::new(mesh.clone(), material, Vector3::new(0.0, 0.0, bad)).unwrap());
            a.resize(system.bodies.size(), 0.0);
        };
        assert_eq!(settled(heavy), none, "{bad}");
        assert!(
            Material::new(Law::NeoHookean, bad, 0.45).is_err() && Material::new(Law::NeoHookean, 1.0, bad).is_err()
        );
    }
}

#[test]
fn a_spring_whose_stiffness_is_no_number_holds_nothing() {
    let count = std::cell::Cell::new(0);
    let spring = |system: &mut System, _: &mut Vec<f64>, _: &Mesh| {
        let springs = Springs::new(&system.bodies, 0, |_, _| f64::NAN, |x| *x);
        count.set(springs.len());
        system.others.push(Box::new(springs));
    };
    assert_eq!((settled(spring), count.get()), (Ok(()), 0));
}
