//! Dials of solids, one at a time: in the plane the ring of the thesis's figure 37, in space the thick ball under pressure.

use simulation::control::{Newton, Settings};
use simulation::equilibrium::settle;
use simulation::space::cells::Settings as Cells;
use simulation::space::element::{Dilatation, Order};

use super::common::scenes::{guard, ring_exact};
use super::sphere::{RADII, octant};
use super::trade::{Dial, Row, Trade, turns};
use super::{CROWN, MESHES, TOLERANCES, WIDTHS, name};

const RING: &str =
    "height of the crown to the 1.558977 that finer meshes of two codes converge to (1e-5 of the radius)";
const BALL: &str = "largest error of a displacement on the surfaces to Lame's closed form; Poisson's ratio 0.49";

/// The crown of the ring in equilibrium.
fn crown(elements: [usize; 2], width: f64, tolerance: f64) -> f64 {
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
    settle(&mut system, &mut newton, &mut a).unwrap();
    let heights = (0..a.len() / 2).map(|n| system.bodies.point(0, n, &a).y);
    heights.fold(0.0, f64::max)
}

pub(crate) fn measure(trade: &Trade) {
    let rings = |name, chosen: &str, against, cases: &[(String, [usize; 2], f64, f64)], truth: f64| {
        let mut errors = vec![0.0; cases.len()];
        let times = turns(trade.rounds(1, 5), cases.len(), |k| {
            let (_, elements, width, tolerance) = cases[k];
            errors[k] = (crown(elements, width, tolerance) - truth).abs();
        });
        let dial = Dial {
            name,
            chosen: chosen.to_owned(),
            time_unit: "ms to equilibrium",
            error_unit: "radii of the ring",
            against,
        };
        // What differs by less than rounding is alike.
        let row = |k: usize| -> Row { (cases[k].0.clone(), 1e3 * times[k], errors[k].max(super::ROUNDING)) };
        trade.write(&dial, &(0..cases.len()).map(row).collect::<Vec<_>>());
    };
    let meshes = MESHES.map(|m| (format!("{} x {}", m[0], m[1]), m, 0.0, 1e-8));
    rings("plane-mesh", "32 x 4", RING, &meshes, CROWN);
    let widths = WIDTHS.map(|w| (name(w), [32, 4], w, 1e-8));
    rings("plane-barrier", "exact", RING, &widths, CROWN);
    let (last, looser) = TOLERANCES.split_last().unwrap();
    let tolerances: Vec<_> = looser.iter().map(|t| (format!("{t:.0e}"), [32, 4], 1e-3, *t)).collect();
    let settled = crown([32, 4], 1e-3, *last);
    let against = "height of the crown to that of the same mesh and barrier at 1e-11";
    rings("plane-tolerance", "1e-8", against, &tolerances, settled);
    cubes(trade);
}

/// Cubes of 27 nodes with linear dilatations, and of 8 with constant ones.
fn cubes(trade: &Trade) {
    let quadratic = Cells::of_side;
    let linear = |side| Cells {
        order: Order::Linear,
        dilatation: Dilatation::Constant,
        ..Cells::of_side(side)
    };
    // Sides that do not divide the radii: the surfaces cut cubes anyhow, as an organ's do.
    let part = |n: f64| RADII[1] / (n + 0.37);
    let sides: Vec<_> = [2.0, 3.0, 4.0, 6.0, 8.0]
        .map(|n| (format!("{:.1} mm", part(n)), quadratic(part(n))))
        .to_vec();
    balls(trade, "space-cube", &format!("{:.1} mm", part(4.0)), &sides);
    let elements = [
        (27, 4.0, quadratic(part(4.0))),
        (8, 4.0, linear(part(4.0))),
        (8, 8.0, linear(part(8.0))),
        (8, 12.0, linear(part(12.0))),
        (8, 16.0, linear(part(16.0))),
    ];
    let name = |nodes: usize, n: f64| format!("{nodes} nodes of {:.1} mm", part(n));
    let elements: Vec<_> = elements.map(|(nodes, n, cells)| (name(nodes, n), cells)).to_vec();
    balls(trade, "space-element", &name(27, 4.0), &elements);
}

fn balls(trade: &Trade, name: &'static str, chosen: &str, cases: &[(String, Cells)]) {
    let mut errors = vec![0.0; cases.len()];
    let times = turns(trade.rounds(1, 3), cases.len(), |k| {
        errors[k] = octant(&cases[k].1, 0.49).0
    });
    let dial = Dial {
        name,
        chosen: chosen.to_owned(),
        time_unit: "ms for mesh and equilibrium",
        error_unit: "of the largest displacement",
        against: BALL,
    };
    let row = |k: usize| -> Row { (cases[k].0.clone(), 1e3 * times[k], errors[k]) };
    trade.write(&dial, &(0..cases.len()).map(row).collect::<Vec<_>>());
}
