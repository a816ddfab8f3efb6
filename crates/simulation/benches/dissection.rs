//! Orders of elimination of meshes in space, and what factorisations and solutions by them cost.
//!
//! `cargo bench -p simulation --bench dissection`. Cubes of hexahedra with 27 or 8 nodes, three unknowns a node, the bottom held, and
//! a bean of hexahedra of 27 nodes.
//! Minimum degree, nested dissection by the pattern alone, by places, and by places with a root of surface nodes in the middle of
//! the top. Tables and `out/bench/dissection-orders.csv`, `dissection-times.csv`. With `--export DIR` also each graph and order as text,
//! for other programs to count.

#![allow(clippy::print_stdout, reason = "the tables are what this program is for")]
#![allow(clippy::unwrap_used, reason = "a step that fails here is a benchmark that fails")]

mod shared;

use std::num::NonZeroUsize;
use std::path::Path;

use nalgebra::{Point3, Rotation3};
use rustix::time::{ClockId, clock_gettime};
use shared::{least, now, peak, say_load, write_csv};
use simulation::sparse::{Dissection, Ldl, Precision, Triplets};

fn main() {
    say_load();
    let only_orders = std::env::args().any(|a| a == "--orders");
    let export = std::env::args().skip_while(|a| a != "--export").nth(1);
    let meshes: Vec<Mesh> = [(6, 2), (8, 2), (10, 2), (12, 1), (16, 1), (20, 1)]
        .map(|(cells, order)| Mesh::cube(cells, order))
        .into();
    let beans = [12, 18].map(Mesh::bean);
    let mut orders = Vec::new();
    for mesh in meshes.iter().chain(&beans) {
        if let Some(folder) = &export {
            mesh.export(Path::new(folder));
        }
        orders.extend(mesh.orders(export.as_deref().map(Path::new)));
    }
    write_csv(
        "dissection-orders",
        "mesh,unknowns,order,fill,multiplications,seconds",
        &orders,
    );
    if only_orders {
        return;
    }
    let rate = peak();
    println!("dense product: {rate:.1} Gflop/s of one thread");
    let times: Vec<String> = meshes[..3].iter().flat_map(Mesh::times).collect();
    write_csv(
        "dissection-times",
        "unknowns,order,precision,threads,factor_ms,factor_wall_ms,gflops,solve_ms,gbs,residual",
        &times,
    );
    say_load();
}

/// Cells of a cubic grid, and a matrix of the pattern of their nodes.
struct Mesh {
    name: String,
    places: Vec<[f64; 3]>,
    matrix: Triplets,
    cells: Vec<Vec<usize>>,
}

impl Mesh {
    /// A cube of so many cells along each edge, each with `order + 1` nodes along its own; the lowest layer of nodes is held.
    fn cube(cells: usize, order: usize) -> Self {
        let name = format!("hex{} {cells}^3", if order == 2 { 27 } else { 8 });
        Self::new(name, [cells; 3], order, |_| true, 1)
    }

    /// The cells of 27 nodes of an ellipsoid with a notch, about as a kidney: nothing is held.
    fn bean(cells: usize) -> Self {
        let n = cells as f64;
        let inside = |[x, y, z]: [f64; 3]| {
            let [x, y, z] = [2.0 * x / n - 1.0, 2.0 * y / (0.6 * n) - 1.0, 2.0 * z / (0.5 * n) - 1.0];
            x * x + y * y + z * z < 1.0 && x * x + (y - 1.2) * (y - 1.2) > 0.5
        };
        let counts = [1.0, 0.6, 0.5].map(|part| (part * n).ceil() as usize);
        Self::new(format!("bean {cells}"), counts, 2, inside, 0)
    }

    /// Cells whose middle is `inside`, nodes from layer `held` on.
    fn new(name: String, counts: [usize; 3], order: usize, inside: impl Fn([f64; 3]) -> bool, held: usize) -> Self {
        let sides = counts.map(|n| n * order + 1);
        let mut numbers = vec![None; sides.iter().product()];
        let (mut places, mut matrix) = (Vec::new(), Triplets::default());
        let mut cells = Vec::new();
        for c in 0..counts.iter().product() {
            let first = [c % counts[0], c / counts[0] % counts[1], c / counts[0] / counts[1]];
            if !inside(first.map(|x| x as f64 + 0.5)) {
                continue;
            }
            let per = order + 1;
            let mut nodes = Vec::new();
            for k in 0..per.pow(3) {
                let local = [k % per, k / per % per, k / per / per];
                let at: [usize; 3] = std::array::from_fn(|d| first[d] * order + local[d]);
                if at[2] < held {
                    continue;
                }
                nodes.push(
                    *numbers[at[0] + sides[0] * (at[1] + sides[1] * at[2])].get_or_insert_with(|| {
                        places.extend([at.map(|x| x as f64 / order as f64); 3]);
                        places.len() / 3 - 1
                    }),
                );
            }
            cells.push(nodes);
        }
        matrix.reset(places.len());
        for (c, nodes) in cells.iter().enumerate() {
            let n = 3 * nodes.len();
            // Definite: the diagonal outweighs its row.
            let value = |(i, j): (usize, usize)| {
                if i == j {
                    n as f64
                } else {
                    ((i * 37 + j * 91 + c) as f64).sin()
                }
            };
            let values: Vec<f64> = (0..n).flat_map(|i| (0..=i).map(move |j| (i, j))).map(value).collect();
            let unknowns: Vec<usize> = nodes.iter().flat_map(|n| 3 * n..3 * n + 3).collect();
            matrix.add_block(unknowns.into_iter(), &values);
        }
        Self {
            name,
            places,
            matrix,
            cells,
        }
    }

    fn unknowns(&self) -> usize {
        self.places.len()
    }

    /// The unknowns of the nodes of the top within a quarter of its side, in cells, of its middle.
    fn top(&self) -> Vec<usize> {
        let ends = |d: usize| self.places.iter().map(|p| p[d]).fold(0.0, f64::max);
        let [x, y, top] = [0, 1, 2].map(ends);
        let near = |p: &[f64; 3]| p[2] == top && (p[0] - x / 2.0).hypot(p[1] - y / 2.0) <= x / 4.0;
        (0..self.unknowns()).filter(|u| near(&self.places[*u])).collect()
    }

    fn orders(&self, export: Option<&Path>) -> Vec<String> {
        let by_places = |root: &[usize]| Ldl::ordered_by(Dissection::by_places(&self.places, root).unwrap());
        // Axes that lie across the cells.
        let turn = Rotation3::from_euler_angles(0.4, 0.5, 0.6);
        let turned: Vec<[f64; 3]> = self.places.iter().map(|p| (turn * Point3::from(*p)).into()).collect();
        let turned = Dissection::by_places(&turned, &[]).unwrap();
        let root = self.top();
        let of_root = format!("by places with a root of {}", root.len());
        let by_pattern = Dissection::by_pattern(self.unknowns(), &[]).unwrap();
        let all = [
            ("minimum degree", Ldl::new()),
            ("by pattern", Ldl::ordered_by(by_pattern)),
            ("by turned places", Ldl::ordered_by(turned)),
            ("by places", by_places(&[])),
            (&of_root, by_places(&root)),
        ];
        let rows = all.into_iter().map(|(name, mut ldl)| {
            let began = now();
            ldl.take(&self.matrix);
            let seconds = now() - began;
            if let Some(folder) = export {
                let text: Vec<String> = ldl.order().iter().map(u32::to_string).collect();
                let file = format!("{}.{}", self.name, name).replace(' ', "_");
                std::fs::write(folder.join(format!("{file}.order")), text.join("\n")).unwrap();
            }
            let row = format!(
                "{},{},{name},{},{:.3e},{seconds:.3}",
                self.name,
                self.unknowns(),
                ldl.fill(),
                ldl.work() as f64
            );
            println!("{row}");
            row
        });
        rows.collect()
    }

    /// Neighbours of each node, a line a node.
    fn export(&self, folder: &Path) {
        let mut near = vec![Vec::new(); self.unknowns() / 3];
        for nodes in &self.cells {
            nodes
                .iter()
                .for_each(|n| near[*n].extend(nodes.iter().filter(|m| *m != n)));
        }
        let mut text = String::new();
        for list in &mut near {
            list.sort_unstable();
            list.dedup();
            text += &list.iter().map(usize::to_string).collect::<Vec<_>>().join(" ");
            text.push('\n');
        }
        std::fs::write(folder.join(format!("{}.graph", self.name.replace(' ', "_"))), text).unwrap();
    }

    fn times(&self) -> Vec<String> {
        let dissection = Dissection::by_places(&self.places, &[]).unwrap();
        let of = |precision: Precision, threads: usize| {
            let mut ldl = Ldl::ordered_by(dissection.clone());
            ldl.set_precision(precision);
            ldl.set_threads(NonZeroUsize::new(threads).unwrap());
            ldl
        };
        let cases = [
            ("minimum degree", "double", 1, Ldl::new()),
            ("by places", "double", 1, of(Precision::Double, 1)),
            ("by places", "single", 1, of(Precision::Single, 1)),
            ("by places", "single", 2, of(Precision::Single, 2)),
        ];
        let rows = cases.map(|(order, precision, threads, mut ldl)| self.time(order, precision, threads, &mut ldl));
        rows.into()
    }

    fn time(&self, order: &str, precision: &str, threads: usize, ldl: &mut Ldl) -> String {
        ldl.take(&self.matrix);
        let mut eliminate = || ldl.shifted(0.0).unwrap();
        let factor = least_by(ClockId::ProcessCPUTime, &mut eliminate);
        let wall = least_by(ClockId::Monotonic, &mut eliminate);
        let mut x = vec![1.0; self.unknowns()];
        let (solve, ()) = least(10, || {
            x.fill(1.0);
            ldl.solve(&mut x);
        });
        let left = self
            .matrix
            .product(&x)
            .into_iter()
            .map(|y| (y - 1.0).abs())
            .fold(0.0, f64::max);
        // Every entry is read twice.
        let bytes = 2 * ldl.fill() * if precision == "single" { 4 } else { 8 };
        let row = format!(
            "{},{order},{precision},{threads},{factor:.1},{wall:.1},{:.1},{solve:.2},{:.1},{left:.0e}",
            self.unknowns(),
            2e-6 * ldl.work() as f64 / factor,
            1e-6 * bytes as f64 / solve,
        );
        println!("{row}");
        row
    }
}

/// The least time of five rounds by a clock, in milliseconds: `least` reads that of this thread alone.
fn least_by<T>(clock: ClockId, work: &mut impl FnMut() -> T) -> f64 {
    let time = || {
        let time = clock_gettime(clock);
        time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
    };
    let rounds = (0..5).map(|_| {
        let began = time();
        work();
        1e3 * (time() - began)
    });
    rounds.fold(f64::INFINITY, f64::min)
}
