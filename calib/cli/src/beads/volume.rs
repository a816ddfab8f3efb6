//! The CT, read by whoever knows its format.

use std::path::{Path, PathBuf};

use bead::Voxels;
use bus::volume::{LabelMap, OwnedVolume};
use clap::Args;
use geometry::VolumeGrid;
use guidance::safety::LabelNames;
use scene::{FileSpec, VolumeSource, VolumeSpec};

use super::error::BeadsError;
use crate::text::shown;
use crate::values::Positive;

/// Reads a volume from a file or a folder. Handed in by the binary, as this crate knows no formats of volumes.
pub type LoadVolume = fn(&VolumeSpec) -> Result<Loaded, Box<dyn std::error::Error + Send + Sync>>;

/// A volume, and what was told of it.
#[derive(Debug)]
pub struct Loaded {
    /// The voxels.
    pub volume: OwnedVolume,
    /// The kind of scanner by DICOM's word; `None` where the file does not say.
    pub modality: Option<String>,
    /// What is doubtful about it, a sentence each.
    pub warnings: Vec<String>,
}

/// How the CT is to be read where its files leave a choice.
#[derive(Debug, Clone, Args)]
pub(crate) struct ReadArgs {
    /// Which DICOM series of a folder, from 1
    #[arg(long, value_name = "NUMBER", value_parser = clap::value_parser!(u32).range(1..))]
    series: Option<u32>,
    /// Take the axes of a file without orientation as left, posterior, superior
    #[arg(long)]
    assume_lps: bool,
    /// Voxel spacing of the generated patient, where the CT is `phantom`
    #[arg(long, value_name = "MM", allow_hyphen_values = true)]
    spacing_mm: Option<Positive>,
}

/// Reads a label map of a volume from a file. Handed in as [`LoadVolume`] is.
pub type LoadLabels = fn(&Path, &VolumeSpec) -> Result<LabelMap, Box<dyn std::error::Error + Send + Sync>>;

/// Reads the names that a label map comes with. Handed in as [`LoadVolume`] is.
pub type ReadLabelNames = fn(&Path) -> Result<LabelNames, Box<dyn std::error::Error + Send + Sync>>;

/// Warnings as lines.
pub(crate) fn warned(warnings: &[String]) -> String {
    warnings
        .iter()
        .map(|warning| format!("warning: {}\n", shown(warning)))
        .collect()
}

/// A volume in memory.
pub(crate) struct Volume(pub(crate) OwnedVolume);

impl ReadArgs {
    /// The hash of a volume, as it stands in files and on images.
    pub(crate) fn hash(&self, path: &Path, load: LoadVolume) -> Result<String, BeadsError> {
        Ok(self.load(path, load)?.0.hash.to_string())
    }

    pub(crate) fn load(&self, path: &Path, load: LoadVolume) -> Result<Volume, BeadsError> {
        let loaded = load(&self.spec(path)?).map_err(BeadsError::Volume)?;
        Ok(Volume(loaded.volume))
    }

    /// The same of what must be a CT, with what is doubtful about it: its numbers are taken as HU.
    pub(crate) fn load_ct(
        &self,
        path: &Path,
        load: LoadVolume,
        accepts_other: bool,
    ) -> Result<(Volume, Vec<String>), BeadsError> {
        let loaded = load(&self.spec(path)?).map_err(BeadsError::Volume)?;
        let mut warnings = loaded.warnings;
        match loaded.modality {
            Some(modality) if modality != "CT" && !accepts_other => {
                return Err(BeadsError::NotCt {
                    path: path.to_owned(),
                    modality,
                });
            }
            Some(modality) if modality != "CT" => warnings.push(format!(
                "taken as a CT by --accept-not-ct, though it is of the modality {modality}"
            )),
            _ => {}
        }
        Ok((Volume(loaded.volume), warnings))
    }

    /// What is to be read of a file, a folder, or `phantom`.
    pub(crate) fn spec(&self, path: &Path) -> Result<VolumeSpec, BeadsError> {
        let mut spec = VolumeSpec::of_path(PathBuf::from(path));
        match &mut spec.source {
            VolumeSource::File(_) if self.spacing_mm.is_some() => {
                return Err(BeadsError::SpacingOfFile { path: path.to_owned() });
            }
            VolumeSource::File(FileSpec { series, assume_lps, .. }) => {
                (*series, *assume_lps) = (self.series, self.assume_lps);
            }
            VolumeSource::Phantom { spacing_mm } => *spacing_mm = self.spacing_mm.map_or(*spacing_mm, |mm| mm.0),
        }
        Ok(spec)
    }
}

impl Voxels for Volume {
    fn grid(&self) -> &VolumeGrid {
        &self.0.grid
    }

    fn at(&self, voxel: [u32; 3]) -> i16 {
        self.0.view().at(voxel)
    }

    fn row(&self, y: u32, z: u32, out: &mut [i16]) {
        let layout = &self.0.layout;
        let first = layout.table(1)[y as usize] + layout.table(2)[z as usize];
        for (value, x) in out.iter_mut().zip(layout.table(0)) {
            *value = self.0.voxels[(first + x) as usize];
        }
    }
}
