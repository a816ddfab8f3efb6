//! What an element in three dimensions costs: energy, forces and stiffness of a cell.
//!
//! `cargo bench -p simulation --bench elements`. Neo-Hookean cubes of 8 nodes (constant dilatation) and 27 nodes (linear dilatation), each
//! function one cell at a time by its table, and four cells at once in lanes, with AVX2 and without. Beside the times: how far the lanes'
//! numbers are from the table's, by their largest, and whether the bits with AVX2 are those without, and those of a cell alone. Table, and
//! `out/bench/solids-elements.csv`.

#![allow(clippy::print_stdout, reason = "the table is what this program is for")]
#![allow(clippy::unwrap_used, reason = "a step that fails here is a benchmark that fails")]

mod shared;

use shared::{least, peak, say_load, write_csv};
use simulation::law::Law;
use simulation::space::element::{Dilatation, Order, Table};
use simulation::space::lanes::{CELLS, Lanes};
use simulation::space::law::Material;

/// Cells of a round: more than caches hold of displacements alone, as in a mesh.
const ROUND: usize = 400;
/// Rounds, of which the least time counts.
const ROUNDS: usize = 15;

fn main() {
    say_load();
    println!("dense product: {:.1} Gflop/s of one thread", peak());
    println!("AVX2: {}", Lanes::new().is_wide());
    println!("{HEADER}");
    let mut rows = Vec::new();
    for (name, order, dilatation) in [
        ("8 plain", Order::Linear, Dilatation::Plain),
        ("8 constant", Order::Linear, Dilatation::Constant),
        ("27 plain", Order::Quadratic, Dilatation::Plain),
        ("27 linear", Order::Quadratic, Dilatation::Linear),
    ] {
        let bench = Bench::new(order, dilatation);
        rows.extend(bench.rows(name));
    }
    write_csv("solids-elements", HEADER, &rows);
    say_load();
}

const HEADER: &str = "element,function,table_us,lanes_portable_us,lanes_us,one_in_lanes_us,deviation,same_bits";

struct Bench {
    table: Table,
    material: Material,
    cells: Vec<Vec<f64>>,
}

/// What was found of all cells.
type Numbers = Vec<f64>;
/// Microseconds a cell, and what was found.
type Timed = (f64, Numbers);
/// A function of an element, by its name.
type Function = (&'static str, fn(&Bench, Way) -> Timed);

impl Bench {
    fn new(order: Order, dilatation: Dilatation) -> Self {
        let table = Table::cube(order, 8.0, dilatation).unwrap();
        let displacement = |cell: usize, k: usize| 0.1 * (1.7 * k as f64 + 0.31 * cell as f64).sin();
        let cells = (0..ROUND).map(|c| (0..3 * table.nodes()).map(|k| displacement(c, k)).collect());
        Self {
            cells: cells.collect(),
            table,
            material: Material::new(Law::NeoHookean, 5.0, 0.49).unwrap(),
        }
    }

    fn rows(&self, name: &str) -> Vec<String> {
        let functions: [Function; 4] = [
            ("energy", Self::energy),
            ("forces", Self::forces),
            ("stiffness", |bench, way| bench.stiffness(way, false)),
            ("convex stiffness", |bench, way| bench.stiffness(way, true)),
        ];
        let row = |(function, work): Function| {
            let [scalar, portable, wide, alone] =
                [Way::Table, Way::Portable, Way::Lanes, Way::Alone].map(|way| work(self, way));
            let same = bits(&portable.1) == bits(&wide.1) && bits(&wide.1) == bits(&alone.1);
            let row = format!(
                "{name},{function},{:.3},{:.3},{:.3},{:.3},{:.1e},{same}",
                scalar.0,
                portable.0,
                wide.0,
                alone.0,
                deviation(&scalar.1, &wide.1),
            );
            println!("{row}");
            row
        };
        functions.map(row).to_vec()
    }

    fn energy(&self, way: Way) -> Timed {
        let mut lanes = way.lanes();
        self.timed(|found| match way {
            Way::Table => found.extend(self.cells.iter().map(|u| self.table.energy(&self.material, u).unwrap())),
            Way::Alone => {
                let alone = |u: &Vec<f64>| lanes.energy_of_one(&self.table, &self.material, u).unwrap();
                found.extend(self.cells.iter().map(alone));
            }
            _ => {
                for u in self.cells.as_chunks::<CELLS>().0 {
                    found.extend(lanes.energy(&self.table, &self.material, slices(u)).map(Option::unwrap));
                }
            }
        })
    }

    fn forces(&self, way: Way) -> Timed {
        let (mut lanes, size) = (way.lanes(), 3 * self.table.nodes());
        self.timed(|found| {
            found.resize(size * ROUND, 0.0);
            let mut forces = found.chunks_exact_mut(size);
            match way {
                Way::Table => self.cells.iter().zip(forces).for_each(|(u, f)| {
                    self.table.gradient(&self.material, u, f).unwrap();
                }),
                Way::Alone => self.cells.iter().zip(forces).for_each(|(u, f)| {
                    lanes.gradient_of_one(&self.table, &self.material, u, f).unwrap();
                }),
                _ => {
                    for u in self.cells.as_chunks::<CELLS>().0 {
                        let four = std::array::from_fn(|_| forces.next().unwrap());
                        let energies = lanes.gradient(&self.table, &self.material, slices(u), four);
                        assert!(energies.iter().all(Option::is_some));
                    }
                }
            }
        })
    }

    fn stiffness(&self, way: Way, convex: bool) -> Timed {
        let mut lanes = way.lanes();
        let mut packed = [(); CELLS].map(|()| Vec::new());
        // Of each cell one row is kept: all of them would be what is measured.
        let kept = |packed: &Vec<f64>| packed[packed.len() - 3 * self.table.nodes()..].to_vec();
        self.timed(|found| match way {
            Way::Table => {
                for u in &self.cells {
                    self.table.stiffness(&self.material, u, convex, &mut packed[0]).unwrap();
                    found.extend(kept(&packed[0]));
                }
            }
            Way::Alone => {
                for u in &self.cells {
                    assert!(lanes.stiffness_of_one(&self.table, &self.material, u, convex, &mut packed[0]));
                    found.extend(kept(&packed[0]));
                }
            }
            _ => {
                for u in self.cells.as_chunks::<CELLS>().0 {
                    let regular = lanes.stiffness(&self.table, &self.material, slices(u), convex, &mut packed);
                    assert_eq!(regular, [true; CELLS]);
                    found.extend(packed.iter().flat_map(kept));
                }
            }
        })
    }

    fn timed(&self, mut work: impl FnMut(&mut Numbers)) -> Timed {
        let mut found = Vec::new();
        let (milliseconds, ()) = least(ROUNDS, || {
            found.clear();
            work(&mut found);
        });
        (1e3 * milliseconds / ROUND as f64, found)
    }
}

#[derive(Clone, Copy)]
enum Way {
    Table,
    Portable,
    Lanes,
    Alone,
}

impl Way {
    fn lanes(self) -> Lanes {
        match self {
            Self::Lanes | Self::Alone => Lanes::new(),
            _ => Lanes::portable(),
        }
    }
}

fn slices(u: &[Vec<f64>; CELLS]) -> [&[f64]; CELLS] {
    u.each_ref().map(Vec::as_slice)
}

fn bits(values: &[f64]) -> Vec<u64> {
    values.iter().map(|x| x.to_bits()).collect()
}

/// The largest difference by the largest number.
fn deviation(a: &[f64], b: &[f64]) -> f64 {
    let largest = a.iter().fold(0.0_f64, |most, a| most.max(a.abs()));
    let off = a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    off / largest
}
