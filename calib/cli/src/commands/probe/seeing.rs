//! The words of reading points off images, and where they are kept.

#[cfg(test)]
mod tests;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use clap::Args;
use echo::{Region, WiresOptions};
use geometry::{Probe, Reference, Rigid};
use probe::Mark;

use super::error::ProbeCommandError;
use super::phantom::Told;
use super::segment::{Sought, segment};
use crate::store;
use crate::values::Target;

/// How points are read off images; all of it is without --points only.
#[derive(Debug, Args)]
pub(crate) struct SeeingArgs {
    /// Look at these pixels only: first column and row, and the first ones beyond; letters, scales and the lines of the
    /// probe's own face stay outside
    #[arg(long, value_name = "U,V,U,V", conflicts_with = "points", value_parser = region)]
    region: Option<Region>,
    /// The direction of the phantom along which columns run, within a quarter turn
    #[arg(long, value_name = "X,Y,Z", conflicts_with_all = ["points", "wall"], allow_hyphen_values = true)]
    right: Option<Target>,
    /// The same of rows: down in the image
    #[arg(long, value_name = "X,Y,Z", conflicts_with_all = ["points", "wall"], allow_hyphen_values = true)]
    down: Option<Target>,
    /// Write the points here, as --points reads them
    #[arg(long, value_name = "FILE.csv", conflicts_with = "points")]
    points_out: Option<PathBuf>,
    /// Draw some of the images with their points here
    #[arg(long, value_name = "FILE.png", conflicts_with = "points")]
    picture: Option<PathBuf>,
}

/// Four numbers of pixels.
pub(super) fn region(text: &str) -> Result<Region, String> {
    let numbers: Option<Vec<usize>> = text.split(',').map(|word| word.trim().parse().ok()).collect();
    match numbers.as_deref() {
        Some([u, v, x, y]) => Ok(Region {
            from: [*u, *v],
            to: [*x, *y],
        }),
        _ => Err("expected four whole numbers, for instance 0,40,820,600".to_owned()),
    }
}

impl SeeingArgs {
    /// Refuses files that are there already, before the work.
    pub(super) fn check(&self) -> Result<(), ProbeCommandError> {
        for path in [&self.points_out, &self.picture].into_iter().flatten() {
            store::check(path, false)?;
        }
        Ok(())
    }

    /// The points of all images, and what was seen in words.
    pub(super) fn see(
        &self,
        sequence: &Path,
        phantom: Option<&Told>,
        names: &[String],
        poses: &BTreeMap<u32, Rigid<Reference, Probe>>,
        inputs: &[&PathBuf],
    ) -> Result<(BTreeMap<u32, Vec<Mark>>, String), ProbeCommandError> {
        let options = WiresOptions {
            right: self.right.map(|right| right.0),
            down: self.down.map(|down| down.0),
            ..WiresOptions::default()
        };
        let sought = phantom.map_or(Sought::Wall, |told| Sought::Wires(told, options));
        let mut found = segment(sequence, self.region, &sought, self.picture.is_some())?;
        if let Some(told) = phantom {
            found.keep_one_way_round(poses, told);
        }
        let mut text = found.words();
        let inputs = || inputs.iter().map(|path| path.as_path());
        if let Some(out) = &self.points_out {
            store::write(out, Ok(found.csv(names)), inputs())?;
            text += &format!("  points in {}\n", out.display());
        }
        if let (Some(out), Some(png)) = (&self.picture, found.png()) {
            store::write_bytes(out, png, inputs())?;
            text += &format!("  drawn in {}\n", out.display());
        }
        Ok((found.marks, text))
    }
}
