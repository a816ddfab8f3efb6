//! Writes the seed corpus, from nothing but this program: `cargo run --example seeds` in the folder fuzz.

use std::fs;
use std::path::Path;

use volume_loader::phantom_source::PhantomSource;
use volume_loader::{WriteOptions, dicom_out, metaimage, nifti, nrrd};

type Failure = Box<dyn std::error::Error>;

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

fn texts(folder: &Path, ending: &str, headers: &[&str]) -> Result<(), Failure> {
    for (i, header) in headers.iter().enumerate() {
        let bytes = [header.as_bytes(), b"0123456789abcdef"].concat();
        fs::write(folder.join(format!("text{i}.{ending}")), bytes)?;
    }
    Ok(())
}

fn main() -> Result<(), Failure> {
    let corpus = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus");
    let folders = ["nifti", "nrrd", "metaimage", "scene", "solids", "dicom"].map(|name| corpus.join(name));
    for folder in &folders {
        fs::create_dir_all(folder)?;
    }
    let [
        nifti_folder,
        nrrd_folder,
        meta_folder,
        scene_folder,
        solids_folder,
        dicom_folder,
    ] = &folders;
    let patient = PhantomSource::new(1, [90.0; 3])?;
    for name in ["a.nii", "a.nii.gz"] {
        nifti::write(&nifti_folder.join(name), &mut patient.clone())?;
    }
    for (name, compress) in [("plain", false), ("packed", true)] {
        let options = WriteOptions { compress };
        nrrd::write(&nrrd_folder.join(format!("{name}.nrrd")), &mut patient.clone(), options)?;
        metaimage::write(&meta_folder.join(format!("{name}.mha")), &mut patient.clone(), options)?;
    }
    texts(nrrd_folder, "nrrd", &NRRD)?;
    texts(meta_folder, "mha", &METAIMAGE)?;
    for (name, syntax) in [
        ("explicit", dicom_out::Syntax::ExplicitLittle),
        ("implicit", dicom_out::Syntax::ImplicitLittle),
        ("big", dicom_out::Syntax::ExplicitBig),
        ("rle", dicom_out::Syntax::Rle),
    ] {
        let series = corpus.join(format!("series-{name}"));
        let options = dicom_out::Options {
            syntax,
            shuffle_names: None,
        };
        dicom_out::write(&series, &mut patient.clone(), &options)?;
        fs::copy(series.join("IM0002.dcm"), dicom_folder.join(format!("{name}.dcm")))?;
        fs::remove_dir_all(series)?;
    }
    let config = Path::new(env!("CARGO_MANIFEST_DIR")).join("../config");
    scenes(&config, scene_folder)?;
    scenes(&config.join("solids"), solids_folder)
}

/// Copies the scene files of a folder.
fn scenes(from: &Path, to: &Path) -> Result<(), Failure> {
    for scene in fs::read_dir(from)? {
        let scene = scene?;
        if scene.path().extension().is_some_and(|ending| ending == "toml") {
            fs::copy(scene.path(), to.join(scene.file_name()))?;
        }
    }
    Ok(())
}
