//! Which samples of boundaries are near which arcs: five ways to find out.
//!
//! `cargo bench -p simulation --bench detection`. The thesis's quadtree of samples, a tree of bounds, a grid, boxes of arcs
//! sorted along an axis, which the crate uses (`constraint::near_boxes`), and comparing all with all, which is the oracle: the same pairs,
//! counted and summed up. On the states of figures 38 and 40 at rest, and on heaps of round solids of 100 to 100 000 samples. Every
//! structure is made anew in every state, as it must be where solids move. A table, and `out/bench/solids-detection.{csv,png}`.

#![allow(clippy::print_stdout, reason = "the table is what this program is for")]
#![allow(clippy::unwrap_used, reason = "a step that fails here is a benchmark that fails")]

#[path = "../tests/common/mod.rs"]
mod common;
mod shared;
mod structures;

use common::scenes::{five, ring_in_ring};
use nalgebra::Vector2;
use picture::chart::{Axis, COLOURS, Chart};
use shared::{least, line, say_load, write_charts, write_csv};
use simulation::equilibrium::settled;
use simulation::law::Law;
use simulation::system::System;
use structures::{Arc, Found, WAYS};

/// Samples of each arc.
const SAMPLES: usize = 4;

struct Row {
    scene: String,
    samples: usize,
    pairs: usize,
    /// Milliseconds of each way; none where it would take too long.
    times: Vec<Option<f64>>,
}

impl Row {
    fn of(scene: &str, arcs: &[Arc], within: f64) -> Self {
        let rounds = (200_000 / arcs.len()).clamp(3, 100);
        let mut oracle: Option<Found> = None;
        let mut times = Vec::new();
        for (name, way) in WAYS {
            if name == "all with all" && arcs.len() > 6_000 {
                times.push(None);
                continue;
            }
            let rounds = if name == "all with all" { 2 } else { rounds };
            let (time, found) = least(rounds, || way(arcs, within));
            let known = oracle.get_or_insert(found);
            assert_eq!(*known, found, "{scene}: {name} finds other pairs");
            times.push(Some(time));
        }
        let row = Self {
            scene: scene.to_owned(),
            samples: SAMPLES * arcs.len(),
            pairs: oracle.unwrap().pairs,
            times,
        };
        println!("{}", row.text());
        row
    }

    fn text(&self) -> String {
        let times = self
            .times
            .iter()
            .map(|t| t.map_or("-".to_owned(), |t| format!("{t:.4}")));
        format!(
            "{},{},{},{}",
            self.scene,
            self.samples,
            self.pairs,
            times.collect::<Vec<_>>().join(",")
        )
    }
}

/// The arcs of all solids in a state, each solid's own number beside them.
fn arcs(system: &System, a: &[f64]) -> Vec<Arc> {
    let solids = 0..system.bodies.len();
    let each = solids.flat_map(|body| {
        let boundary = system.bodies.solid(body).boundary();
        boundary.arcs.iter().map(move |arc| (body, *arc))
    });
    each.map(|(body, arc)| Arc::new(body, arc.map(|n| system.bodies.point(body, n, a))))
        .collect()
}

fn at_rest(mut system: System) -> Vec<Arc> {
    let mut a = system.initial();
    settled(&mut system, &mut a).unwrap();
    arcs(&system, &a)
}

/// Round solids of eight arcs in rows, a little apart, each turned and squeezed otherwise.
fn heap(solids: usize) -> Vec<Arc> {
    let side = (solids as f64).sqrt().ceil() as usize;
    let arc = |body: usize, k: usize| {
        let centre = Vector2::new((body % side) as f64, (body / side) as f64);
        let squeeze = 1.0 + 0.1 * (body as f64).sin();
        let at = |part: f64| {
            let angle = std::f64::consts::TAU * (k as f64 + part) / 8.0 + body as f64;
            centre + Vector2::new(angle.cos() * squeeze, angle.sin() / squeeze) * 0.47
        };
        Arc::new(body, [at(0.0), at(0.5), at(1.0)])
    };
    (0..solids)
        .flat_map(|body| (0..8).map(move |k| (body, k)))
        .map(|(b, k)| arc(b, k))
        .collect()
}

fn main() {
    say_load();
    let header = format!("scene,samples,pairs,{}", WAYS.map(|w| w.0).join(","));
    println!("milliseconds: {header}");
    let mut rows = vec![
        Row::of("figure 38 at rest", &at_rest(ring_in_ring([12, 2], 0.01, 1e-2)), 1e-2),
        Row::of("figure 40 at rest", &at_rest(five(2, Law::NeoHookean, 1e-2)), 1e-2),
    ];
    let heaps = [4, 10, 32, 100, 316, 1000, 3160].map(|solids| Row::of("heap", &heap(solids), 0.05));
    let chart = chart(&heaps);
    rows.extend(heaps);
    write_csv(
        "solids-detection",
        &header,
        &rows.iter().map(Row::text).collect::<Vec<_>>(),
    );
    write_charts("solids-detection", &[chart]);
    say_load();
}

fn chart(rows: &[Row]) -> Chart {
    let mut chart = Chart::new(
        "Samples near arcs of other solids, heaps of round solids",
        Axis::log("samples"),
        Axis::log("processor time, ms"),
    );
    for (k, (name, _)) in WAYS.iter().enumerate() {
        let points = rows.iter().filter_map(|r| Some([r.samples as f64, r.times[k]?]));
        chart.push(line(name, COLOURS[k], points));
    }
    chart
}
