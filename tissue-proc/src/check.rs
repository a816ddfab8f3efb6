//! Whether the organs of a scene can be moved in a run: all that the process refuses at its start, before anything is started.

use std::convert::Infallible;
use std::time::Duration;

use geometry::VolumeGrid;
use scene::{Scene, VolumeSpec};

use crate::anatomy::{LoadLabels, NoAnatomy, labels, make, read};
use crate::work::beside;

type Cause = Box<dyn std::error::Error + Send + Sync>;

/// The voxels of an examination that a scene loads, of its part where it takes one; the number is the generated patient's seed.
pub type Voxels = fn(&VolumeSpec, u64) -> Result<VolumeGrid, Cause>;

/// Both readers of files: of an examination's voxels, and of label maps.
pub type Reads = (Voxels, LoadLabels);

/// Signs of life while organs are meshed.
const EVERY: Duration = Duration::from_secs(5);

/// The text of the scene of organs: its values and the tube.
///
/// # Errors
/// What the process would refuse, in its words.
pub fn text(scene: &Scene) -> Result<(), Cause> {
    match &scene.tissue {
        Some(spec) => Ok(read((scene, spec)).map(|_| ())?),
        None => Ok(()),
    }
}

/// That, and its label map beside the examination's voxels.
///
/// # Errors
/// As of [`text`]; what reading the examination's geometry says.
pub fn map(scene: &Scene, (voxels, load): Reads) -> Result<(), Cause> {
    let Some(spec) = &scene.tissue else { return Ok(()) };
    let (source, plan) = read((scene, spec))?;
    let grid = voxels(&scene.volume, scene.seed)?;
    labels((&source, &plan), (scene, &grid), load)?;
    Ok(())
}

/// That, and everything that is made of it at the start of a run: in words, what. Every 5 s a line on stderr says that it goes on.
///
/// # Errors
/// As of [`map`].
pub fn meshes(scene: &Scene, (voxels, load): Reads) -> Result<Option<String>, Cause> {
    let Some(spec) = &scene.tissue else { return Ok(None) };
    read((scene, spec))?;
    let grid = voxels(&scene.volume, scene.seed)?;
    let mut waited = Duration::ZERO;
    let work = || make((scene, spec), (&grid, [0; 32]), load).map(|anatomy| anatomy.said);
    let made: Result<Result<String, NoAnatomy>, Infallible> = beside(EVERY, work, || {
        waited += EVERY;
        bus::stderr_line!("meshing the organs of [tissue]: {} s so far", waited.as_secs());
        Ok(())
    });
    let Ok(made) = made;
    Ok(Some(made?))
}
