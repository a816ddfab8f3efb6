//! Mesh, tolerance and width of the barrier against time and error.
//!
//! `cargo bench -p simulation --bench solids_trade`. The ring of the thesis's figure 37 under w = 0.01, settled on a plane: the height of its
//! crown against 1.558977, to which finer meshes of two codes converge (1e-5). Every mesh with every barrier and exact contact, at
//! the tolerance 1e-8; and on two meshes every tolerance. A table, and `out/bench/solids-trade.{csv,png}`.

#![allow(clippy::print_stdout, reason = "the table is what this program is for")]
#![allow(clippy::unwrap_used, reason = "a step that fails here is a benchmark that fails")]

#[path = "../tests/common/mod.rs"]
mod common;
#[path = "solids_trade/dials.rs"]
mod dials;
mod shared;
#[path = "../tests/space/sphere.rs"]
mod sphere;
#[path = "../../../benches/shared/trade.rs"]
mod trade;

use common::scenes::{guard, ring_exact};
use picture::chart::{Axis, COLOURS, Chart};
use shared::{least, line, say_load, write_charts, write_csv};
use simulation::control::{Newton, Settings};
use simulation::equilibrium::settle;

/// The crown's height without a mesh and without a barrier.
const CROWN: f64 = 1.558_977;
const MESHES: [[usize; 2]; 5] = [[8, 2], [16, 2], [32, 4], [64, 4], [96, 6]];
/// Zero: exact contact, from a barrier of 0.02.
const WIDTHS: [f64; 5] = [1e-1, 1e-2, 1e-3, 1e-4, 0.0];
/// The last one stands for none.
const TOLERANCES: [f64; 6] = [1e-1, 1e-2, 1e-4, 1e-6, 1e-8, 1e-11];
/// Heights differ by rounding below this.
const ROUNDING: f64 = 1e-13;

struct Row {
    elements: [usize; 2],
    unknowns: usize,
    width: f64,
    tolerance: f64,
    milliseconds: f64,
    steps: usize,
    error: f64,
}

impl Row {
    const HEADER: &str = "along,through,unknowns,width,tolerance,ms,steps,error";

    fn of(elements: [usize; 2], width: f64, tolerance: f64) -> Option<Self> {
        let rounds = if elements[0] <= 32 { 3 } else { 1 };
        let (milliseconds, (unknowns, found, crown)) = least(rounds, || {
            let mut system = ring_exact(elements, 0.02);
            if width > 0.0 {
                system.terms.clear();
                guard(&mut system, (0.0, 1.0), 0.0, width);
            }
            let mut a = system.initial();
            let mut newton = Newton::new(Settings {
                tolerance,
                ..Settings::default()
            });
            let found = settle(&mut system, &mut newton, &mut a);
            let heights = (0..a.len() / 2).map(|n| system.bodies.point(0, n, &a).y);
            (a.len(), found, heights.fold(0.0, f64::max))
        });
        let row = Self {
            elements,
            unknowns,
            width,
            tolerance,
            milliseconds,
            steps: found.as_ref().map_or(0, |f| f.iterations),
            error: crown - CROWN,
        };
        match found {
            Ok(found) if width > 0.0 || found.exact => {
                println!("{}", row.text());
                Some(row)
            }
            Ok(_) => {
                println!("{}: not exact", row.text());
                None
            }
            Err(refused) => {
                println!("{}: {refused}", row.text());
                None
            }
        }
    }

    fn text(&self) -> String {
        let [along, through] = self.elements;
        format!(
            "{along},{through},{},{:e},{:e},{:.3},{},{:+.2e}",
            self.unknowns, self.width, self.tolerance, self.milliseconds, self.steps, self.error
        )
    }

    fn point(&self) -> [f64; 2] {
        [self.milliseconds, self.error.abs()]
    }
}

fn name(width: f64) -> String {
    if width > 0.0 {
        format!("barrier {width:.0e}")
    } else {
        "exact".to_owned()
    }
}

fn main() {
    if let Some(trade) = trade::Trade::wanted() {
        return dials::measure(&trade);
    }
    say_load();
    println!("{} (width 0: exact)", Row::HEADER);
    let meshes = MESHES.into_iter().flat_map(|m| WIDTHS.map(|w| (m, w)));
    let rows: Vec<Row> = meshes.filter_map(|(m, w)| Row::of(m, w, 1e-8)).collect();
    let looser = [[16, 2], [32, 4]].into_iter().flat_map(|m| TOLERANCES.map(|t| (m, t)));
    let tolerances: Vec<Row> = looser.filter_map(|(m, t)| Row::of(m, 1e-3, t)).collect();
    let all: Vec<String> = rows.iter().chain(&tolerances).map(Row::text).collect();
    write_csv("solids-trade", Row::HEADER, &all);
    write_charts("solids-trade", &[chart(&rows), tolerance_chart(&tolerances)]);
    say_load();
}

/// One line for each width, along it the meshes.
fn chart(rows: &[Row]) -> Chart {
    let mut chart = Chart::new(
        "Ring on a plane, error of the crown: along each line the mesh grows finer, 8 x 2 to 96 x 6",
        Axis::log("processor time from the start to equilibrium, ms"),
        Axis::log("error, radii of the ring"),
    );
    for (k, width) in WIDTHS.into_iter().enumerate() {
        let points = rows.iter().filter(|r| r.width == width).map(Row::point);
        chart.push(line(&name(width), COLOURS[k], points));
    }
    chart
}

/// One line for each mesh, along it the tolerances.
fn tolerance_chart(rows: &[Row]) -> Chart {
    let mut chart = Chart::new(
        "The same, barrier 1e-3: downwards the tolerance of the forces is 1e-1, 1e-2, 1e-4, 1e-6, 1e-8",
        Axis::linear("processor time, ms"),
        Axis::log("what the tolerance adds to the error, radii"),
    );
    for (k, elements) in [[16, 2], [32, 4]].into_iter().enumerate() {
        let name = format!("{} x {} elements", elements[0], elements[1]);
        let own: Vec<&Row> = rows.iter().filter(|r| r.elements == elements).collect();
        let Some((best, looser)) = own.split_last() else {
            continue;
        };
        let points = looser
            .iter()
            .map(|r| [r.milliseconds, (r.error - best.error).abs().max(ROUNDING)]);
        chart.push(line(&name, COLOURS[k], points));
    }
    chart
}
