//! Seeds of volumes and scenes, from nothing but this program and config/.

use std::fs;
use std::path::{Path, PathBuf};

use volume_loader::phantom_source::PhantomSource;
use volume_loader::{WriteOptions, dicom_out, metaimage, nifti as nifti_file, nrrd as nrrd_file};

use crate::{Failure, Folder, enhanced};

type Seeds = Result<Vec<Vec<u8>>, Failure>;

/// Headers whose varieties the writers do not write; sixteen bytes of voxels follow each.
const NRRD: [&str; 4] = [
    "NRRD0001\ntype: uchar\ndimension: 3\nsizes: 2 2 2\nspacings: 1 1 2\nencoding: raw\n\n",
    "NRRD0005\n# c\nk:=v\ntype: short\ndimension: 4\nspace: RAS\nsizes: 1 2 2 2\nspace directions: none (1,0,0) (0,1,0) \
     (0,0.1,2)\nspace origin: (1,2,3)\nspace units: \"mm\" \"cm\" \"um\"\nkinds: list domain domain \
     domain\nendian: big\nencoding: raw\nbyte skip: -1\n\n",
    "NRRD0004\ntype: float\ndimension: 3\nspace: LAS\nsizes: 2 2 1\nspace directions: (1,0,0) (0,1,0) (0,0,2)\nspace \
     origin: (1,2,3)\ncenters: cell cell node\nencoding: ascii\nline skip: 1\n\n1\n1 2.5 nan -4 ",
    "NRRD0004\ntype: int8\ndimension: 3\nspace: LPS\nsizes: 2 2 2\nspace directions: (1,0,0) (0,1,0) (0,0,2)\nspace \
     origin: (1,2,3)\nencoding: hex\ndata file: LIST 3\na%02d.raw\nb.raw\n",
];
const METAIMAGE: [&str; 2] = [
    "NDims = 3\nBinaryData = False\nRotation = 1 0 0 0 1 0 0 0 1\nPosition = 0 0 0\nDistanceUnits = cm\nElementSize = 1 \
     1 2\nDimSize = 2 2 1\nAnatomicalOrientation = RAS\nElementType = MET_DOUBLE\nElementDataFile = LOCAL\n1 2 3 4\n",
    "NDims = 3\nHeaderSize = -1\nElementByteOrderMSB = True\nElementSpacing = 1 1 1\nDimSize = 2 2 2\nElementType = \
     MET_USHORT\nElementDataFile = a%03d.raw 1 2 1\n",
];

fn patient() -> Result<PhantomSource, Failure> {
    Ok(PhantomSource::new(1, [90.0; 3])?)
}

/// What `write` puts into files of these names.
fn written<T>(names: &[&str], mut write: impl FnMut(&Path) -> Result<T, Failure>) -> Seeds {
    let folder = Folder::new()?;
    let one = |name: &&str| {
        let path = folder.path().join(name);
        write(&path)?;
        Ok(fs::read(&path)?)
    };
    names.iter().map(one).collect()
}

fn with_voxels<'a>(headers: &'a [&str]) -> impl Iterator<Item = Vec<u8>> + 'a {
    headers.iter().map(|h| [h.as_bytes(), b"0123456789abcdef"].concat())
}

fn is_packed(path: &Path) -> WriteOptions {
    WriteOptions {
        compress: path.to_string_lossy().contains("packed"),
    }
}

pub(crate) fn nifti() -> Seeds {
    written(&["a.nii", "a.nii.gz"], |path| {
        Ok(nifti_file::write(path, &mut patient()?)?)
    })
}

pub(crate) fn nrrd() -> Seeds {
    let mut seeds = written(&["plain.nrrd", "packed.nrrd"], |path| {
        Ok(nrrd_file::write(path, &mut patient()?, is_packed(path))?)
    })?;
    seeds.extend(with_voxels(&NRRD));
    Ok(seeds)
}

pub(crate) fn metaimage() -> Seeds {
    let mut seeds = written(&["plain.mha", "packed.mha"], |path| {
        Ok(metaimage::write(path, &mut patient()?, is_packed(path))?)
    })?;
    seeds.extend(with_voxels(&METAIMAGE));
    Ok(seeds)
}

pub(crate) fn dicom() -> Seeds {
    use dicom_out::Syntax::{ExplicitBig, ExplicitLittle, ImplicitLittle, Rle};
    let folder = Folder::new()?;
    let one = |(i, syntax)| {
        let series = folder.path().join(format!("{i}"));
        let options = dicom_out::Options {
            syntax,
            shuffle_names: None,
        };
        dicom_out::write(&series, &mut patient()?, &options)?;
        Ok(fs::read(series.join("IM0002.dcm"))?)
    };
    let syntaxes = [ExplicitLittle, ImplicitLittle, ExplicitBig, Rle];
    let mut seeds: Vec<Vec<u8>> = syntaxes
        .into_iter()
        .enumerate()
        .map(one)
        .collect::<Result<_, Failure>>()?;
    seeds.extend([enhanced::native(), enhanced::packed()]);
    Ok(seeds)
}

fn config() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../config")
}

/// The scene files of a folder.
fn scenes(folder: &Path) -> Seeds {
    let mut paths = Vec::new();
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        if path.extension().is_some_and(|ending| ending == "toml") {
            paths.push(path);
        }
    }
    // In an order that is the same everywhere, so that mutations are.
    paths.sort();
    paths.iter().map(|path| Ok(fs::read(path)?)).collect()
}

pub(crate) fn scene() -> Seeds {
    scenes(&config())
}

pub(crate) fn solids() -> Seeds {
    scenes(&config().join("solids"))
}
