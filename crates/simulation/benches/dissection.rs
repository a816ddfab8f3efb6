//! Orders of elimination of meshes in space, and what factorisations and solutions by them cost.
//!
//! `cargo bench -p simulation --bench dissection`. Cubes of hexahedra with 27 or 8 nodes, three unknowns a node, the bottom held.
//! Minimum degree, nested dissection by the pattern alone, by places, and by places with a root of surface nodes in the middle of
//! the top. Tables and `out/bench/dissection-orders.csv`, `dissection-times.csv`. With `--export DIR` also each graph and order as text,
//! for other programs to count.

#![allow(clippy::print_stdout, reason = "the tables are what this program is for")]
#![allow(clippy::unwrap_used, reason = "a step that fails here is a benchmark that fails")]

mod shared;

use std::num::NonZeroUsize;
use std::path::Path;

use shared::{least, now, peak, say_load, write_csv};
use simulation::sparse::{Dissection, Ldl, Precision, Triplets};

fn main() {
    say_load();
    let export = std::env::args().skip_while(|a| a != "--export").nth(1);
    let meshes: Vec<Mesh> = [(6, 2), (12, 1), (8, 2), (16, 1), (10, 2), (20, 1)]
        .map(|(cells, order)| Mesh::new(cells, order))
        .into();
    let mut orders = Vec::new();
    for mesh in &meshes {
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
    let rate = peak();
    println!("dense product: {rate:.1} Gflop/s of one thread");
    let times: Vec<String> = meshes.iter().step_by(2).flat_map(Mesh::times).collect();
    write_csv(
        "dissection-times",
        "unknowns,order,precision,threads,factor_ms,gflops,solve_ms,gbs,residual",
        &times,
    );
    say_load();
}

/// A cube of cells, and a matrix of its pattern.
struct Mesh {
    name: String,
    places: Vec<[f64; 3]>,
    matrix: Triplets,
    side: usize,
}

impl Mesh {
    /// So many cells along each edge, each with `order + 1` nodes along its own.
    fn new(cells: usize, order: usize) -> Self {
        let side = cells * order + 1;
        // The lowest layer is held: it has no unknowns.
        let node = |[x, y, z]: [usize; 3]| (z > 0).then(|| 3 * (x + side * (y + side * (z - 1))));
        let mut places = vec![[0.0; 3]; 3 * side * side * (side - 1)];
        let mut matrix = Triplets::new(places.len());
        for c in 0..cells.pow(3) {
            let first = [c % cells, c / cells % cells, c / cells / cells].map(|c| c * order);
            let mut unknowns = Vec::new();
            let per = order + 1;
            for k in 0..per.pow(3) {
                let local = [k % per, k / per % per, k / per / per];
                let at: [usize; 3] = std::array::from_fn(|d| first[d] + local[d]);
                if let Some(u) = node(at) {
                    unknowns.extend([u, u + 1, u + 2]);
                    (u..u + 3).for_each(|u| places[u] = at.map(|x| x as f64 / order as f64));
                }
            }
            let n = unknowns.len();
            // Definite: the diagonal outweighs its row.
            let value = |(i, j): (usize, usize)| {
                if i == j {
                    n as f64
                } else {
                    ((i * 37 + j * 91 + c) as f64).sin()
                }
            };
            let values: Vec<f64> = (0..n).flat_map(|i| (0..=i).map(move |j| (i, j))).map(value).collect();
            matrix.add_block(unknowns.iter().copied(), &values);
        }
        let name = format!("hex{} {cells}^3", if order == 2 { 27 } else { 8 });
        Self {
            name,
            places,
            matrix,
            side,
        }
    }

    fn unknowns(&self) -> usize {
        self.places.len()
    }

    /// The unknowns of the nodes of the top within a radius, in cells, of its middle.
    fn top(&self, radius: f64) -> Vec<usize> {
        let top = self.places.iter().map(|p| p[2]).fold(0.0, f64::max);
        let near = |p: &[f64; 3]| p[2] == top && (p[0] - top / 2.0).hypot(p[1] - top / 2.0) <= radius;
        (0..self.unknowns()).filter(|u| near(&self.places[*u])).collect()
    }

    fn orders(&self, export: Option<&Path>) -> Vec<String> {
        let by_places = |root: &[usize]| Ldl::ordered_by(Dissection::by_places(&self.places, root).unwrap());
        let root = self.top(self.places[self.unknowns() - 1][2] / 4.0);
        let of_root = format!("by places with a root of {}", root.len());
        let by_pattern = Dissection::by_pattern(self.unknowns(), &[]).unwrap();
        let all = [
            ("minimum degree", Ldl::new()),
            ("by pattern", Ldl::ordered_by(by_pattern)),
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
        let (side, order) = (self.side, if self.name.starts_with("hex27") { 2 } else { 1 });
        let nodes = self.unknowns() / 3;
        let at = |n: usize| [n % side, n / side % side, n / side / side + 1];
        // Neighbours share a cell: from the first to the last node of the cells that touch the node.
        let span = |x: usize| {
            (
                x.saturating_sub(1) / order * order,
                ((x / order + 1) * order).min(side - 1),
            )
        };
        let mut text = String::new();
        for n in 0..nodes {
            let [x, y, z] = at(n).map(span);
            for k in z.0.max(1)..=z.1 {
                for j in y.0..=y.1 {
                    for i in x.0..=x.1 {
                        let m = i + side * (j + side * (k - 1));
                        if m != n {
                            text += &format!("{m} ");
                        }
                    }
                }
            }
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
        let (factor, _) = least_wall(3, || ldl.shifted(0.0).unwrap());
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
            "{},{order},{precision},{threads},{factor:.1},{:.1},{solve:.2},{:.1},{left:.0e}",
            self.unknowns(),
            2e-6 * ldl.work() as f64 / factor,
            1e-6 * bytes as f64 / solve,
        );
        println!("{row}");
        row
    }
}

/// The least time on the wall, as several threads work: in milliseconds.
fn least_wall<T>(rounds: usize, mut work: impl FnMut() -> T) -> (f64, T) {
    let wall = || {
        let time = rustix::time::clock_gettime(rustix::time::ClockId::Monotonic);
        time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
    };
    let mut best = f64::INFINITY;
    let mut round = || {
        let began = wall();
        let found = work();
        best = best.min(1e3 * (wall() - began));
        found
    };
    let mut last = round();
    for _ in 1..rounds {
        last = round();
    }
    (best, last)
}
