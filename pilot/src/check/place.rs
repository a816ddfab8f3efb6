//! Where the examination lies in the patient, and whether what is aimed at lies in it.

use std::ffi::OsStr;
use std::path::Path;

use bus::message::VolumeHeader;
use bus::volume::LabelMap;
use geometry::{Ct, Point, VolumeGrid};
use guidance::safety::GridMatch;
use phantom::Phantom;
use scene::raw::Source;
use scene::steps::{KnownPoint, Registering};
use scene::{Scene, TrackerSource};
use serde::Deserialize;

use crate::spawn;

/// Where the voxels of an examination lie, before a part of it is taken.
#[derive(Debug, Clone)]
pub(super) struct Examination {
    grid: VolumeGrid,
    /// Whether all of it is loaded as it is.
    is_whole: bool,
    /// What is doubtful about it, by the loader's words.
    warnings: Vec<String>,
}

/// What `volume-loader inspect --json` says of it. It says more.
#[derive(Debug, Deserialize)]
struct Place {
    dims: [u32; 3],
    ct_from_voxel: [[f64; 4]; 3],
    warnings: Vec<String>,
}

impl Examination {
    /// The examination of a scene, or why there is none.
    pub(super) fn of(source: &Source, scene: &Scene) -> Result<Self, String> {
        match Self::generated(source, scene) {
            Some(generated) => generated,
            None => Self::inspected(source),
        }
    }

    /// The generated patient's; `None` for a file.
    pub(super) fn generated(source: &Source, scene: &Scene) -> Option<Result<Self, String>> {
        let volume = &source.scene.volume;
        let grid = || Phantom::new(scene.seed).grid([volume.spacing_mm; 3]);
        (volume.source == "phantom").then(|| {
            grid()
                .map_err(|error| format!("volume.spacing_mm: {error}"))
                .map(|grid| Self {
                    grid,
                    is_whole: is_whole(source),
                    warnings: Vec::new(),
                })
        })
    }

    /// What the loader says of a file or a folder. Its own words, if it refuses, stand on stderr.
    fn inspected(source: &Source) -> Result<Self, String> {
        let volume = &source.scene.volume;
        let path = Path::new(&volume.source);
        let refused = |why: &str| format!("volume.source {}: {why}", path.display());
        match path.metadata() {
            Err(error) => return Err(refused(&error.to_string())),
            // Opening a pipe would wait for its writer.
            Ok(facts) if !facts.is_file() && !facts.is_dir() => {
                return Err(refused("it is neither a file nor a folder"));
            }
            Ok(_) => {}
        }
        let series = volume.series.map(|series| series.to_string());
        let mut arguments: Vec<&OsStr> = vec!["inspect".as_ref(), path.as_os_str(), "--json".as_ref()];
        if let Some(series) = &series {
            arguments.push("--series".as_ref());
            arguments.push(series.as_ref());
        }
        for (on, flag) in [(volume.regrid, "--regrid"), (volume.assume_lps, "--assume-lps")] {
            if on {
                arguments.push(flag.as_ref());
            }
        }
        let (program, output) = spawn::ask("volume-loader", &arguments);
        let output = output.map_err(|error| refused(&format!("asking {}: {error}", program.display())))?;
        if !output.status.success() {
            return Err(refused("it cannot be loaded, for the reason that the loader gives"));
        }
        let place: Place = serde_json::from_slice(&output.stdout)
            .map_err(|_| refused("it holds several series: choose one with volume.series"))?;
        let header = VolumeHeader {
            dims: place.dims,
            ct_from_voxel: place.ct_from_voxel,
            ..VolumeHeader::default()
        };
        let grid = header.grid().map_err(|error| refused(&error.to_string()))?;
        Ok(Self {
            grid,
            is_whole: is_whole(source),
            warnings: place.warnings,
        })
    }

    /// What is doubtful about it, a line each.
    pub(super) fn doubts(&self) -> impl Iterator<Item = String> {
        self.warnings
            .iter()
            .map(|words| format!("warning: the examination: {words}"))
    }

    /// How a label map lies beside its voxels.
    pub(super) fn lies_under(&self, labels: &LabelMap) -> GridMatch {
        labels.lies_on(&self.grid)
    }

    /// How many voxels are loaded, where that is all of them.
    pub(super) fn loaded_voxels(&self) -> Option<u64> {
        let voxels = self.grid.dims().iter().map(|&n| u64::from(n)).product();
        self.is_whole.then_some(voxels)
    }

    /// How far a point lies outside, mm, along the examination's axes; `None` for one inside. A voxel reaches half a step around
    /// its middle. Where the axes are not at right angles the nearest place may be a little nearer.
    pub(super) fn outside_mm(&self, p: Point<Ct>) -> Option<f64> {
        let voxel = (self.grid.voxel_from_ct() * p).mm();
        let sides = voxel.into_iter().zip(self.grid.dims());
        let held: Vec<f64> = sides.map(|(v, n)| v.clamp(-0.5, f64::from(n) - 0.5)).collect();
        let held = [held[0], held[1], held[2]];
        (held != voxel).then(|| (self.grid.ct_from_voxel() * Point::new(held[0], held[1], held[2])).distance(p))
    }
}

fn is_whole(source: &Source) -> bool {
    source.scene.volume.region.is_none() && source.scene.volume.downsample == [1, 1, 1]
}

/// Targets, entries and points to be touched outside the examination: tube and words would point at nothing.
pub(super) fn faults(scene: &Scene, examination: &Examination) -> Vec<String> {
    let targets = scene.targets.iter().flat_map(|target| {
        let entry = target
            .entry
            .map(|entry| (format!("the entry of target {:?}", target.name), entry));
        [Some((format!("target {:?}", target.name), target.centre)), entry]
    });
    let targets = targets.flatten();
    let steps = scene.steps.iter().flat_map(|steps| {
        let points = match &steps.register {
            Some(Registering::Points(points)) => &points[..],
            Some(Registering::Beads(_)) | None => &[],
        };
        let named = |table, points: &[KnownPoint]| -> Vec<(String, Point<Ct>)> {
            let one = |point: &KnownPoint| (format!("{table}, {:?},", point.name), point.place);
            points.iter().map(one).collect()
        };
        [named("steps.points", points), named("steps.check_points", &steps.check)].concat()
    });
    let entry = match &scene.tracker.source {
        TrackerSource::Simulated(simulation) => simulation.approach.entry,
        _ => None,
    };
    let entry = entry.map(|entry| ("the entry (tracker.approach.entry_ct_mm)".to_owned(), entry));
    let outside = |(what, at): (String, Point<Ct>)| {
        let mm = examination.outside_mm(at)?;
        let place = at.in_words(1);
        Some(format!("{what} at {place} lies {mm:.1} mm outside the CT"))
    };
    targets.chain(entry).chain(steps).filter_map(outside).collect()
}
