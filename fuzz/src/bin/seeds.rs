//! Writes the seeds of every target into a folder: `cargo run -p trocar-fuzz --bin seeds FOLDER`.

use std::fs;
use std::path::PathBuf;

use trocar_fuzz::{Failure, TARGETS};

fn main() -> Result<(), Failure> {
    let folder = PathBuf::from(std::env::args_os().nth(1).ok_or("give the folder for the seeds")?);
    for target in &TARGETS {
        let folder = folder.join(target.name);
        fs::create_dir_all(&folder)?;
        for (number, seed) in (target.seeds)()?.iter().enumerate() {
            fs::write(folder.join(format!("seed-{number}")), seed)?;
        }
    }
    Ok(())
}
