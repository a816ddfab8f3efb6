//! Error against time: every filter on every back end, for images of 256, 512 and 1024 pixels a side.
//!
//! `cargo bench -p slice-view-proc --bench trade`; for `cargo xtask bench trade` one dial at a time. Errors are distances from what the volume really is, not from another interpolation: a sum
//! of waves that a scanner could just have resolved, and the generated patient, whose edges are sharper than voxels. Both
//! are stored as whole HU, as scanners do; that alone costs 0.29 HU RMS. A card takes part where there is one, and so does a program
//! that stands for one (lavapipe): its name is printed, and its times are those of the machine's cores.

#![allow(clippy::print_stdout, reason = "the table is what this program is for")]

#[path = "trade/dials.rs"]
mod dials;
#[path = "trade/fields.rs"]
mod fields;
#[path = "trade/measure.rs"]
mod measure;
#[path = "../../benches/shared/trade.rs"]
mod row;
mod shared;

use shared::figures::load;

fn main() {
    if let Some(trade) = row::Trade::wanted() {
        return dials::measure(&trade);
    }
    println!("{}", load());
    for field in fields::all() {
        let measured = measure::measure(&field);
        println!("\n{}", field.name);
        print!("{}", measure::table(&measured));
    }
    println!("\n{}", load());
}
