//! What it costs to sum a solid's energy, forces and stiffness, and an elastic bed's: elements four at once and springs by patches, beside
//! elements one by one and springs point by point.
//!
//! `cargo bench -p simulation --bench assembly`. A block of whole cubes, a graded quarter of a block, a bean of voxels and, where
//! `TROCAR_SHARED` (or `../shared`) has it, a kidney of a CT. Table, and `out/bench/solids-assembly.csv`.

#![allow(clippy::print_stdout, reason = "the table is what this program is for")]
#![allow(clippy::unwrap_used, reason = "a step that fails here is a benchmark that fails")]

#[path = "assembly/regions.rs"]
mod regions;
mod shared;
#[path = "assembly/single.rs"]
mod single;

use shared::{least, say_load, write_csv};
use simulation::law::Law;
use simulation::space::cells::Mesh;
use simulation::space::law::Material;
use simulation::space::solid::{Deformable, Solid};
use simulation::space::system::System;
use simulation::space::term::{Springs, Term};
use simulation::sparse::{Dissection, Ldl, Triplets};
use single::OneByOne;

/// Rounds, of which the least time counts.
const ROUNDS: usize = 25;

const HEADER: &str = "mesh,unknowns,elements_by_four,elements_by_one,spring_points,what,before_us,after_us";

fn main() {
    say_load();
    println!("{HEADER}");
    let mut rows = Vec::new();
    for (name, mesh) in regions::all() {
        rows.extend(Bench::new(mesh).rows(name));
    }
    write_csv("solids-assembly", HEADER, &rows);
    say_load();
}

/// One mesh as two systems: as it is, and with all sums one by one.
struct Bench {
    systems: [System; 2],
    springs: [Springs; 2],
    a: Vec<f64>,
    counts: [usize; 2],
}

impl Bench {
    fn new(mesh: Mesh) -> Self {
        let material = Material::new(Law::NeoHookean, 5e-3, 0.49).unwrap();
        let solid = Deformable::new(mesh, material, nalgebra::Vector3::zeros()).unwrap();
        let a = (0..solid.parameters()).map(|k| 0.05 * (1.7 * k as f64).sin()).collect();
        let counts = solid.together();
        let mut systems = [System::new(), System::new()];
        systems[0].add(OneByOne {
            solid: solid.clone(),
            material,
        });
        systems[1].add(solid);
        // The half of the surface that looks down is held.
        let springs =
            |system: &System| Springs::new(&system.bodies, 0, |_, n| if n.z < 0.0 { 1e-2 } else { 0.0 }, |x| *x);
        let springs = systems.each_ref().map(springs);
        Self {
            systems,
            springs,
            a,
            counts,
        }
    }

    fn rows(&self, name: &str) -> Vec<String> {
        let size = self.a.len();
        let each: [(&str, [f64; 2]); 7] = [
            (
                "energy of the solid",
                self.of_solid(|solid, a, _, _| solid.energy(a).is_some()),
            ),
            (
                "forces of the solid",
                self.of_solid(|solid, a, g, _| solid.gradient(a, g).is_some()),
            ),
            (
                "stiffness of the solid",
                self.of_solid(|solid, a, _, sink| solid.hessian(a, false, sink, 0).is_some()),
            ),
            (
                "energy of springs",
                self.of_springs(|s, y, a, _, _| s.energy(&y.bodies, a).is_some()),
            ),
            (
                "forces of springs",
                self.of_springs(|s, y, a, g, _| s.gradient(&y.bodies, a, g).is_some()),
            ),
            (
                "stiffness of springs",
                self.of_springs(|s, y, a, _, sink| s.hessian(&y.bodies, a, false, sink).is_some()),
            ),
            ("factorisation with taking up", self.factored()),
        ];
        let row = |(what, [before, after]): (&str, [f64; 2])| {
            let [four, one] = self.counts;
            let row = format!(
                "{name},{size},{four},{one},{},{what},{before:.0},{after:.0}",
                self.springs[1].len()
            );
            println!("{row}");
            row
        };
        each.map(row).to_vec()
    }

    fn of_solid(&self, work: impl Fn(&dyn Solid, &[f64], &mut [f64], &mut Triplets) -> bool) -> [f64; 2] {
        self.systems
            .each_ref()
            .map(|system| self.timed(|a, g, sink| work(system.bodies.solid(0), a, g, sink)))
    }

    fn of_springs(&self, work: impl Fn(&Springs, &System, &[f64], &mut [f64], &mut Triplets) -> bool) -> [f64; 2] {
        [0, 1].map(|k| self.timed(|a, g, sink| work(&self.springs[k], &self.systems[k], a, g, sink)))
    }

    /// The matrix of solid and springs, taken up and factored.
    fn factored(&self) -> [f64; 2] {
        [0, 1].map(|k| {
            let (system, mut sink) = (&self.systems[k], Triplets::new(self.a.len()));
            system.bodies.solid(0).hessian(&self.a, true, &mut sink, 0).unwrap();
            self.springs[k]
                .hessian(&system.bodies, &self.a, true, &mut sink)
                .unwrap();
            let mut ldl = Ldl::ordered_by(Dissection::by_places(&system.places(), &[]).unwrap());
            ldl.factor(&sink, 0.0).unwrap();
            1e3 * least(ROUNDS, || ldl.factor(&sink, 0.0).unwrap()).0
        })
    }

    /// Microseconds.
    fn timed(&self, mut work: impl FnMut(&[f64], &mut [f64], &mut Triplets) -> bool) -> f64 {
        let (mut gradient, mut sink) = (vec![0.0; self.a.len()], Triplets::new(self.a.len()));
        let (milliseconds, ()) = least(ROUNDS, || {
            sink.reset(self.a.len());
            assert!(work(&self.a, &mut gradient, &mut sink));
        });
        1e3 * milliseconds
    }
}
