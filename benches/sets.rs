//! How often all views show one pose, to a viewer that gathers their images.
//!
//! `cargo bench --bench sets -- [SECONDS] [load N]`: navigates in config/demo.toml beside N busy loops (0), joins as a guest, decides 60
//! times a second for SECONDS (20) what to show, three times, and prints the share of decisions in which all views show one pose, how many
//! poses a second all of them showed, the ages of these, and the images a second of each view.

#![allow(clippy::print_stdout, reason = "the table is what this program is for")]
#![allow(clippy::unwrap_used, reason = "a step that fails here is a benchmark that fails")]
#![allow(unreachable_pub, reason = "a module of this program, and not a crate")]

#[path = "sets/count.rs"]
mod count;
#[path = "../tests/support/load.rs"]
mod load;
#[path = "../tests/support/mod.rs"]
mod support;

use std::path::Path;

use load::Load;
use support::World;

fn main() {
    let (_, seconds, load) = load::asked();
    let (seconds, load) = (seconds.unwrap_or(20.0), load.unwrap_or(0));
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("config/demo.toml");
    let checked = scene::Scene::load(&scene).unwrap();
    let views: Vec<String> = checked.views.iter().map(|view| view.name.clone()).collect();
    let stale_ns = bus::clock::ns(checked.limits.stale);
    println!("| beside {load} busy loops: one pose | sets a second | age, ms, p50 / p99 | images a second |");
    println!("|---|---|---|---|");
    let world = World::new();
    let pilot = world.start(&scene, &world.path("out"), "default");
    pilot.wait_live();
    let _load = Load::new(load);
    for _ in 0..3 {
        println!(
            "| {} |",
            count::count(&world.run_dir("default"), &views, stale_ns, seconds).row()
        );
    }
    pilot.stop();
}
