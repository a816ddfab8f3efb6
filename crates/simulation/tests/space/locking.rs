//! The block of `push` at three Poisson's ratios: steps of the search, and the force.

use simulation::space::cells::Settings;

use crate::push::Pushed;

/// Force at 20 mm of the second code, N: limits of its meshes for 0.3 and 0.49; for 0.4999 that of its mesh of 14 994 unknowns, 1.6386,
/// which at 0.49 is 0.0032 above the limit there.
const FORCES: [(f64, f64); 3] = [(0.3, 1.699), (0.49, 1.636), (0.4999, 1.6354)];

/// Steps of a push of 20 mm in ten parts, and the force at the end.
fn push(settings: &Settings, nu: f64, fine: &[f64]) -> (usize, f64, usize) {
    let mut block = Pushed::new(settings, nu, fine);
    let (mut steps, mut force) = (0, 0.0);
    for depth in (1..=10).map(|k| 2.0 * f64::from(k)) {
        let found = block.to(depth).unwrap();
        (steps, force) = (steps + found.0.iterations, found.1);
    }
    (steps, force, block.unknowns())
}

#[test]
#[ignore = "a table of three pushes of 20 mm with two meshes"]
fn steps_and_force_by_poissons_ratio() {
    for (levels, fine) in [(1, &[40.0][..]), (2, &[40.0, 25.0][..])] {
        let settings = Settings {
            levels,
            ..Settings::of_side(25.0)
        };
        for (nu, exact) in FORCES {
            let (steps, force, unknowns) = push(&settings, nu, fine);
            let off = force / exact - 1.0;
            println!(
                "nu {nu}, {unknowns} unknowns: {steps} steps, force {force:.4} N, {:+.2} %",
                100.0 * off
            );
            // What is asked of cubes of 6.25 mm by the tip, at any ratio alike.
            assert!(levels < 2 || off.abs() < 0.03, "{nu}: {off}");
        }
    }
}
