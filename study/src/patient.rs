//! The patient in the scanner: the generated patient with metal beads, as an examination on disk.
//!
//! A bead of radius r and metal M is seen through a Gaussian blur of deviation s, as `docs/beads.md` describes it. At the distance d
//! from its centre its share of what is seen is the integral of that Gaussian over the ball, in closed form
//!
//! ```text
//! f(d) = (erf((r + d) / (s sqrt 2)) + erf((r - d) / (s sqrt 2))) / 2
//!        - s / (d sqrt(2 pi)) (exp(-(r - d)^2 / (2 s^2)) - exp(-(r + d)^2 / (2 s^2)))                              (1)
//! ```
//!
//! and the voxel has `f M + (1 - f) tissue`, averaged over the slice's thickness, with noise, and clipped as a scanner clips.

mod erf;
mod scan;

use std::path::{Path, PathBuf};

use geometry::{Ct, Point};
use phantom::Phantom;

use crate::plan::{Beads, Dials};
pub(crate) use scan::Scan;

/// The patient of all studies.
pub(crate) fn patient() -> Phantom {
    Phantom::new(phantom::DEFAULT_SEED)
}

/// Where the metal is, mm: first the beads that are touched, then the others on the skin.
pub(crate) fn metal(patient: &Phantom, beads: &Beads) -> Vec<Point<Ct>> {
    let skin: Vec<Point<Ct>> = patient.beads().iter().map(|bead| bead.centre).collect();
    match beads {
        Beads::OnSkin(touched) => {
            let rest = (0..skin.len()).filter(|number| !touched.contains(number));
            let order = touched.iter().copied().chain(rest);
            order.filter_map(|number| skin.get(number).copied()).collect()
        }
        Beads::At(places) => {
            let own = places.iter().map(|&[x, y, z]| Point::new(x, y, z));
            // Metal cannot lie in metal.
            let is_apart = |p: &Point<Ct>| places.iter().all(|&[x, y, z]| p.distance(Point::new(x, y, z)) > 10.0);
            own.chain(skin.iter().copied().filter(is_apart)).collect()
        }
    }
}

/// How many of [`metal`] are touched for the registration.
pub(crate) fn touched(beads: &Beads) -> usize {
    match beads {
        Beads::OnSkin(numbers) => numbers.len(),
        Beads::At(places) => places.len(),
    }
}

/// Writes the examination of this seed to `folder`, and says under which name.
///
/// # Errors
/// In words: a disk that is full, a grid that cannot be.
pub(crate) fn write(folder: &Path, dials: &Dials, metal: &[Point<Ct>], seed: u64) -> Result<PathBuf, String> {
    let path = folder.join("ct.mha");
    let mut scan = Scan::new(patient(), dials, metal, seed).map_err(|error| error.to_string())?;
    let options = volume_loader::WriteOptions { compress: false };
    volume_loader::metaimage::write(&path, &mut scan, options).map_err(|error| error.to_string())?;
    Ok(path)
}
