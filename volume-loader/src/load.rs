//! From a scene's volume to a source of voxels.

pub(crate) mod names;
pub(crate) mod origin;
pub(crate) mod segmentation;
pub(crate) mod structure_set;

use std::path::Path;

use bus::run::free_memory_bytes;
use bus::volume::{LabelMap, Layout, OwnedVolume, Voxels};
use scene::{FileSpec, VolumeSource, VolumeSpec, is_generated};

use self::origin::Belongs;
use crate::dicom;
use crate::error::LoadError;
use crate::fill::fill;
use crate::inspect::{Changed, warnings};
use crate::nifti::{HeaderError, NiftiSource};
use crate::part::part;
use crate::phantom_source::{PhantomLabels, PhantomSource};
use crate::raster::{Head, OpenOptions};
use crate::source::{Conversion, Place, ReadError, VoxelSource};
use crate::{metaimage, nrrd};

/// Opens the source of a scene's volume, or of its part; `seed` is the generated patient's.
///
/// # Errors
/// [`LoadError::Read`], [`LoadError::Grid`], [`LoadError::Region`].
pub fn open(spec: &VolumeSpec, seed: u64) -> Result<Box<dyn VoxelSource>, LoadError> {
    let source: Box<dyn VoxelSource> = match &spec.source {
        VolumeSource::Phantom { spacing_mm } => Box::new(PhantomSource::new(seed, [*spacing_mm; 3])?),
        VolumeSource::File(file) => open_file(file)?,
    };
    Ok(part(source, spec)?)
}

/// A folder is a DICOM series, and so is a file that begins as DICOM; another is told by the ending of its name: NRRD (`.nrrd`,
/// `.nhdr`), MetaImage (`.mha`, `.mhd`), and NIfTI with any other, by its first bytes.
fn open_file(file: &FileSpec) -> Result<Box<dyn VoxelSource>, ReadError> {
    let (path, assume_lps) = (&file.path, file.assume_lps);
    let options = dicom::Options { regrid: file.regrid };
    let series = file.series.map(|number| number as usize);
    if let Some(source) = dicom::open_path(path, series, options)? {
        return Ok(Box::new(source));
    }
    let ending = path.extension().and_then(|ending| ending.to_str());
    Ok(match ending.map(str::to_ascii_lowercase).as_deref() {
        Some("nrrd" | "nhdr") => Box::new(nrrd::open(path, OpenOptions { assume_lps })?),
        Some("mha" | "mhd") => Box::new(metaimage::open(path, OpenOptions { assume_lps })?),
        Some("nii" | "gz") => Box::new(NiftiSource::open(path)?),
        _ => Box::new(NiftiSource::open(path).map_err(|error| unknown(path, error).unwrap_or_else(|error| error))?),
    })
}

/// What is told of a file whose name says nothing, where it is no NIfTI file either.
fn unknown(path: &Path, error: ReadError) -> Result<ReadError, ReadError> {
    let stranger = match &error {
        ReadError::Header { source, .. } => matches!(source, HeaderError::NotNifti { .. }),
        // Not even as long as the shortest header.
        ReadError::Truncated { place, .. } | ReadError::BrokenOff { place, .. } | ReadError::Corrupt { place, .. } => {
            *place == Place::Header
        }
        _ => false,
    };
    if !stranger {
        return Ok(error);
    }
    let head = Head::read_some(path, 16)?;
    let found = head.first(16);
    let hint = match found {
        [b'N', b'R', b'R', b'D', ..] => ", as of an NRRD file: name it .nrrd or .nhdr",
        [b'O', b'b', b'j', b'e', b'c', b't', ..] | [b'N', b'D', b'i', b'm', b's', ..] => {
            ", as of a MetaImage file: name it .mha or .mhd"
        }
        _ => "",
    };
    Ok(ReadError::Unknown {
        path: path.to_owned(),
        found: found.to_vec(),
        hint,
    })
}

/// Reads an examination into this process's own memory; the generated patient is that of this seed.
///
/// # Errors
/// [`LoadError`].
pub fn load_seeded(spec: &VolumeSpec, seed: u64) -> Result<OwnedVolume, Box<dyn std::error::Error + Send + Sync>> {
    Ok(load_owned(spec, seed)?)
}

/// Reads a label map of an examination: each voxel as it stands in the file, or a segmentation of DICOM, which must share the frame of
/// reference with an examination that is DICOM too.
///
/// # Errors
/// [`LoadError`]; [`LoadError::NotLabels`] where a voxel would have to be changed.
pub fn load_labels(
    path: &Path,
    examination: &VolumeSpec,
) -> Result<LabelMap, Box<dyn std::error::Error + Send + Sync>> {
    load_labels_seeded(path, examination, 1)
}

/// The same; the generated patient is that of this seed.
///
/// # Errors
/// [`LoadError`]; [`LoadError::NotLabels`] where a voxel would have to be changed.
pub fn load_labels_seeded(
    path: &Path,
    examination: &VolumeSpec,
    seed: u64,
) -> Result<LabelMap, Box<dyn std::error::Error + Send + Sync>> {
    let (source, belongs) = open_labels(path, Some(examination), seed)?;
    for warning in source.facts().warnings {
        bus::stderr_line!("label map {}: {warning}", path.display());
    }
    Ok(LabelMap {
        volume: labels_in(source)?,
        is_in_its_frame: belongs.is_in_its_frame,
        doubts: belongs.doubts,
    })
}

/// Reads a label map beside no examination: each voxel as it stands in the file.
///
/// # Errors
/// [`LoadError`]; [`LoadError::NotLabels`] where a voxel would have to be changed.
pub fn load_label_map(path: &Path) -> Result<OwnedVolume, Box<dyn std::error::Error + Send + Sync>> {
    let (source, _) = open_labels(path, None, 1)?;
    for warning in source.facts().warnings {
        bus::stderr_line!("label map {}: {warning}", path.display());
    }
    Ok(labels_in(source)?)
}

/// Opens a label map; with `examination` it is refused where it is known to be of another. With how it belongs to that.
/// The word `phantom` is the structures of the generated patient, whose seed is `seed`, and goes with that patient alone.
///
/// # Errors
/// [`LoadError::Read`], [`LoadError::Grid`], [`LoadError::Generated`].
pub(crate) fn open_labels(
    path: &Path,
    examination: Option<&VolumeSpec>,
    seed: u64,
) -> Result<(Box<dyn VoxelSource>, Belongs), LoadError> {
    if is_generated(path) {
        let spacing_mm = match examination.map(|examination| &examination.source) {
            Some(VolumeSource::Phantom { spacing_mm }) => [*spacing_mm; 3],
            Some(VolumeSource::File(file)) => {
                return Err(LoadError::Generated {
                    path: file.path.clone(),
                });
            }
            None => phantom::DEFAULT_SPACING_MM,
        };
        return Ok((Box::new(PhantomLabels::new(seed, spacing_mm)?), Belongs::default()));
    }
    Ok(match segmentation::open(path, examination)? {
        Some((source, belongs)) => (Box::new(source), belongs),
        None => (open(&VolumeSpec::of_path(path.to_owned()), 1)?, Belongs::default()),
    })
}

/// The labels of a map, whole.
///
/// # Errors
/// [`LoadError`]; [`LoadError::NotLabels`] where a voxel would have to be changed.
pub(crate) fn labels_in(mut source: Box<dyn VoxelSource>) -> Result<OwnedVolume, LoadError> {
    let (volume, changed) = counted(source.as_mut())?;
    for remark in source.remarks() {
        bus::stderr_line!("label map: {remark}");
    }
    let clamped = changed.clamped_low + changed.clamped_high;
    match changed.rounded + changed.not_finite + clamped {
        0 => Ok(volume),
        _ => Err(LoadError::NotLabels {
            rounded: changed.rounded,
            clamped,
            not_finite: changed.not_finite,
        }),
    }
}

/// As [`load_seeded`]; the generated patient is that of seed 1.
///
/// # Errors
/// [`LoadError`].
pub fn load(spec: &VolumeSpec) -> Result<OwnedVolume, Box<dyn std::error::Error + Send + Sync>> {
    load_seeded(spec, 1)
}

/// What is told of an examination beside its voxels.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Told {
    /// The kind of scanner by DICOM's word, such as `CT` or `MR`; `None` where the format does not say.
    pub modality: Option<String>,
    /// What is doubtful about it, a sentence each, as `inspect` has it.
    pub warnings: Vec<String>,
}

/// As [`load`], with what is told of it.
///
/// # Errors
/// [`LoadError`].
pub fn load_told(spec: &VolumeSpec) -> Result<(OwnedVolume, Told), Box<dyn std::error::Error + Send + Sync>> {
    load_told_seeded(spec, 1)
}

/// As [`load_seeded`], with what is told of it.
///
/// # Errors
/// [`LoadError`].
pub fn load_told_seeded(
    spec: &VolumeSpec,
    seed: u64,
) -> Result<(OwnedVolume, Told), Box<dyn std::error::Error + Send + Sync>> {
    let mut source = open(spec, seed)?;
    let facts = source.facts();
    let (volume, conversion) = counted(source.as_mut())?;
    let modality = facts.extra.get("modality").and_then(|word| word.as_str());
    let mut warnings = facts.warnings;
    warnings.extend(source.remarks());
    let marks = volume.marks.words();
    warnings.extend(warnings::of_volume(&volume.view(), &Changed::from(conversion), &marks));
    Ok((
        volume,
        Told {
            modality: modality.map(str::to_owned),
            warnings,
        },
    ))
}

fn load_owned(spec: &VolumeSpec, seed: u64) -> Result<OwnedVolume, LoadError> {
    Ok(counted(open(spec, seed)?.as_mut())?.0)
}

fn counted(source: &mut dyn VoxelSource) -> Result<(OwnedVolume, Conversion), LoadError> {
    let grid = *source.grid();
    let layout = Layout::choose(grid.dims())?;
    let padding_hu = source.padding_hu();
    check_memory(layout.stored() * 2)?;
    let mut voxels = Voxels::zeroed(layout.stored() as usize);
    let filled = fill(source, &layout, &mut voxels, |_| true)?;
    let volume = OwnedVolume {
        grid,
        layout,
        voxels,
        padding_hu,
        hash: filled.hash,
        marks: source.marks(),
    };
    Ok((volume, filled.conversion))
}

/// A header may promise more than any machine holds: asked before anything is allocated.
fn check_memory(bytes: u64) -> Result<(), LoadError> {
    match free_memory_bytes() {
        Some(free) if free < bytes => Err(LoadError::Memory {
            needed_mib: bytes.div_ceil(1 << 20),
            free_mib: free >> 20,
        }),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::raster::test_files::{SHEARED, TURNED, given};
    use crate::write::WriteOptions;

    /// Any path that ended so and was not there was the generated patient's labels.
    #[test]
    fn the_generated_patients_labels_are_one_word_and_go_with_no_other_examination() {
        let said = |path: &str, of: Option<&str>| {
            let examination = of.map(|of| VolumeSpec::of_path(of.into()));
            let opened = open_labels(Path::new(path), examination.as_ref(), 1);
            opened.map(|_| ()).map_err(|error| error.to_string())
        };
        assert_eq!(said("phantom", None), Ok(()));
        assert_eq!(said("phantom", Some("phantom")), Ok(()));
        let folder = tempfile::tempdir().unwrap();
        let missing = folder.path().join("phantom");
        for path in ["./phantom", "ct/phantom", "phantom/", missing.to_str().unwrap()] {
            let why = said(path, None).unwrap_err();
            assert!(why.contains(path) && why.contains("there is no such file"), "{why}");
        }
        let why = said("phantom", Some("ct.nii.gz")).unwrap_err();
        assert!(
            why.contains("the generated patient") && why.contains("the examination is ct.nii.gz"),
            "{why}"
        );
    }

    #[test]
    fn each_ending_is_read_as_its_format_and_all_give_one_volume() {
        let folder = tempfile::tempdir().unwrap();
        let mut hashes = Vec::new();
        for (name, compress) in [("a.nrrd", false), ("b.NRRD", true), ("c.nhdr", false), ("d.nhdr", true)] {
            let path = folder.path().join(name.to_lowercase());
            nrrd::write(&path, &mut given(SHEARED), WriteOptions { compress }).unwrap();
            let named = folder.path().join(name);
            std::fs::rename(&path, &named).unwrap();
            hashes.push(load(&VolumeSpec::of_path(named)).unwrap().hash);
        }
        assert!(hashes.iter().all(|hash| *hash == hashes[0]), "{hashes:?}");
        let grid = given(TURNED[3]).grid;
        for name in ["a.mha", "b.mhd", "c.nii", "d.nii.gz"] {
            let path = folder.path().join(name);
            match name.split_once(".n") {
                Some(_) => crate::nifti::write(&path, &mut given(TURNED[3])).map(|_| ()),
                None => metaimage::write(&path, &mut given(TURNED[3]), WriteOptions::default()).map(|_| ()),
            }
            .unwrap();
            let volume = load(&VolumeSpec::of_path(path.clone())).unwrap();
            // Whole numbers, exact in each format.
            assert_eq!(volume.grid, grid, "{name}");
            assert_eq!(volume.view().at([4, 3, 2]), 19 - 1400, "{name}");
        }
    }
}
