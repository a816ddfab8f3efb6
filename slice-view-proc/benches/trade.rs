//! Error against time: every filter on every back end, for images of 256, 512 and 1024 pixels a side.
//!
//! `cargo xtask bench trade`. Errors are distances from what the volume really is, not from another interpolation: a sum
//! of waves that a scanner could just have resolved, and the generated patient, whose edges are sharper than voxels. Both
//! are stored as whole HU, as scanners do; that alone costs 0.29 HU RMS. The table goes to stdout and to
//! `out/bench/trade.csv`, the picture to `out/bench/trade.png`. A card takes part where there is one, and so does a program
//! that stands for one (lavapipe): its name is printed, and its times are those of the machine's cores.

#![allow(
    clippy::print_stderr,
    clippy::print_stdout,
    reason = "the table is what this program is for"
)]

#[path = "trade/fields.rs"]
mod fields;
#[path = "trade/measure.rs"]
mod measure;
#[path = "trade/plot.rs"]
mod plot;
mod shared;

use shared::figures::load;

fn main() {
    println!("{}", load());
    let mut rows = Vec::new();
    for field in fields::all() {
        let measured = measure::measure(&field);
        println!("\n{}", field.name);
        print!("{}", measure::table(&measured));
        rows.extend(measured);
    }
    println!("\n{}", load());
    match plot::write(&rows) {
        Ok(folder) => println!("written: trade.csv and trade.png in {}", folder.display()),
        Err(error) => {
            eprintln!("trade: error: {error}");
            std::process::exit(1);
        }
    }
}
