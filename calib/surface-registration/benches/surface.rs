//! How often a registration by the surface is right, how near it comes, what it promises, what it refuses and what it takes.
//!
//! ```text
//! cargo bench -p surface-registration --bench surface -- [runs] [words of rows]      the table
//! cargo bench -p surface-registration --bench surface -- [runs] --dials FILE.png     what each number of the options is worth
//! cargo bench -p surface-registration --bench surface -- [runs] --dump DIR           points for other programs, and what this one makes of them
//! ```
//!
//! Points are drawn on the phantom of `shared/oracles/surface` (`TROCAR_SHARED`), seeds of this bench's own. A run is right with a root
//! mean square TRE below 2 mm at six targets, wrong from 4 mm on. The right ones that were refused are counted apart where what the points
//! were told to be holds, and where a refusal is right (`surface/kinds.rs`). Times are those that a thread had a processor for, means over the runs, and medians
//! (of one start: the least of five more).

#![allow(clippy::print_stdout, reason = "the table is what this program is for")]
#![allow(clippy::unwrap_used, reason = "a step that fails here is a benchmark that fails")]

#[path = "../tests/common/mod.rs"]
mod common;
#[path = "surface/count.rs"]
mod count;
#[path = "surface/dials.rs"]
mod dials;
#[path = "surface/dump.rs"]
mod dump;
#[path = "surface/ends.rs"]
mod ends;
#[path = "surface/kinds.rs"]
mod kinds;
#[path = "surface/rows.rs"]
mod rows;
#[path = "surface/run.rs"]
mod run;
#[path = "../../../benches/shared/trade.rs"]
mod trade;

use common::draw::Source;
use common::oracle;
use count::Count;
use geometry::Ct;
use kinds::Gates;
use rows::From;
use run::{Scene, seconds};
use surface_registration::{Effort, Field, Options, Spacing, Surface};

fn main() {
    // Cargo adds `--bench`.
    let args: Vec<String> = std::env::args().skip(1).filter(|a| a != "--bench").collect();
    let after = |name: &str| {
        let place = args.iter().position(|a| a == name)?;
        args.get(place + 1).cloned()
    };
    let runs = args.first().and_then(|a| a.parse().ok()).unwrap_or(80);
    let first_seed = after("--seed").and_then(|a| a.parse().ok()).unwrap_or(7_000_000);
    let Some(bone) = oracle::bone("pelvis-phantom") else {
        return;
    };
    let (surface_s, surface) = seconds(|| Surface::<Ct>::new(&bone.0, &bone.1).unwrap());
    let (field_s, field) = seconds(|| Field::new(&surface, Spacing::default()).unwrap());
    println!(
        "surface {surface_s:.3} s, field {field_s:.3} s ({} nodes); {:?}",
        field.nodes(),
        Effort::default()
    );
    let scene = Scene {
        surface,
        field,
        source: Source::new(&bone),
    };
    if let Some(trade) = trade::Trade::wanted() {
        return dials::trade(&trade, scene);
    }
    if let Some(file) = after("--dials") {
        return dials::dials(&bone, scene, runs, &file);
    }
    if let Some(folder) = after("--dump") {
        return dump::dump(&bone, &scene, runs, &folder);
    }
    let words: Vec<&String> = args.iter().skip(1).take_while(|a| !a.starts_with("--")).collect();
    println!(
        "| row | right | wrong | silent | right refused | moved, right moved | TRE mm | over bound: median, rms | 95 % | chi2/3 | taken: mm, predicted; greatest ratio, over 3 | ms: mean, median |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|---|");
    let (mut all, mut gates) = (Count::default(), Gates::default());
    for row in rows::rows()
        .iter()
        .filter(|row| words.iter().all(|word| row.name.contains(word.as_str())))
    {
        let mut count = Count::default();
        for seed in 0..runs {
            run::run(&scene, row, &Options::default(), first_seed + seed, &mut count);
        }
        println!("{}", count.line(row.name));
        if !matches!(row.from, From::One(..)) {
            all.add(&count);
            gates.row(row.name, &count.kinds);
        }
    }
    ends::ends(runs, first_seed, &words, (&mut all, &mut gates));
    println!("{}\n{}", gates.text(), all.last());
}
