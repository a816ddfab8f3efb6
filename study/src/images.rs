//! Examinations with the beads that were found in them: made once, known by the hash of all that they are made of, and used again.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use calib_cli::BeadsFile;
use calib_cli::cli::answer;
use chance::mix;
use geometry::{Ct, Point};
use tissue_proc::offline::Anatomist;

use crate::Words;
use crate::folder::{FolderError, io_at};
use crate::patient;
use crate::plan::{Plan, Stratum, Tissue};
use crate::steps::HANDS;
use crate::tissue::meshed;

/// Begins the name of a folder while something is made in it.
const MAKING: &str = "making-";
/// Of the beads' file, beside it.
const HASH: &str = "beads.blake3";
/// The surface of the pelvis, what it rests on, and the hash of both.
const BONE: &str = "bone.ply";
const BONE_FACTS: &str = "bone.json";
const BONE_HASH: &str = "bone.blake3";
/// Where the pelvis is, without the lumbar spine and its own cut end, and what hangs together as bone: vessels with contrast are below.
const PELVIS_MM: &str = "-150,-90,-133,150,100,-12";
const BONE_HU: &str = "300";

/// An examination's beads.
#[derive(Debug)]
pub(crate) struct Examined {
    /// Of `calib beads`.
    pub(crate) path: PathBuf,
    /// What stands in it.
    pub(crate) beads: BeadsFile,
    /// Of `calib bone`, for those that are registered by it.
    pub(crate) bone: Option<PathBuf>,
}

type Made = Arc<OnceLock<Result<Arc<Examined>, String>>>;
/// Organs by the hash of what they are made of.
type Meshed = BTreeMap<[u8; 32], Arc<OnceLock<Result<Arc<Anatomist>, String>>>>;

/// The examinations of a study, in a folder of its own.
pub(crate) struct Images {
    folder: PathBuf,
    made: Mutex<BTreeMap<String, Made>>,
    meshed: Mutex<Meshed>,
}

impl Images {
    /// Those in `folder`, which may hold some already.
    ///
    /// # Errors
    /// [`FolderError`] where beads are not those that were written.
    pub(crate) fn new(folder: PathBuf) -> Result<Self, FolderError> {
        if folder.is_dir() {
            for image in fs::read_dir(&folder).map_err(io_at(&folder))? {
                as_made(&image.map_err(io_at(&folder))?.path())?;
            }
        }
        Ok(Self {
            folder,
            made: Mutex::default(),
            meshed: Mutex::default(),
        })
    }

    /// What a step says without the names of this folder and of the operation's own, which are others each time.
    pub(crate) fn unnamed(&self, why: &str, folder: &Path) -> String {
        let own = why.replace(&*folder.to_string_lossy(), "");
        own.replace(&*self.folder.to_string_lossy(), "")
    }

    /// The examination of an operation: its own, or one that it shares with others of its stratum, and of strata whose CTs follow from the same numbers.
    pub(crate) fn of(&self, stratum: &Stratum, number: u64, metal: &[Point<Ct>]) -> Result<Arc<Examined>, String> {
        let image = number % stratum.dials.ct.images;
        let key = key(stratum, image, metal);
        let made = {
            // Who panicked while holding it has left a whole map.
            let mut all = self.made.lock().unwrap_or_else(PoisonError::into_inner);
            all.entry(key.clone()).or_default().clone()
        };
        let found = made.get_or_init(|| {
            let examined = self.examined(&key, stratum, metal);
            examined.map(Arc::new).map_err(|error| error.to_string())
        });
        found.clone()
    }

    /// The organs that the tube moves, meshed once for all operations.
    pub(crate) fn organs(&self, tissue: &Tissue) -> Result<Arc<Anatomist>, String> {
        let made = {
            let mut all = self.meshed.lock().unwrap_or_else(PoisonError::into_inner);
            all.entry(tissue.hash).or_default().clone()
        };
        let found = made.get_or_init(|| meshed(tissue).map(Arc::new).map_err(|error| error.to_string()));
        found.clone()
    }

    /// The image of the examination of an operation, made again where it is not there: for who wants to see it.
    pub(crate) fn ct(&self, stratum: &Stratum, number: u64, metal: &[Point<Ct>]) -> Result<PathBuf, Words> {
        let key = key(stratum, number % stratum.dials.ct.images, metal);
        let path = self.folder.join(&key).join("ct.mha");
        if !path.exists() {
            // With the folder of its beads.
            self.of(stratum, number, metal)?;
            let beside = tempfile::Builder::new().prefix(MAKING).tempdir_in(&self.folder)?;
            let made = patient::write(beside.path(), &stratum.dials, metal, seed(&key)?)?;
            fs::rename(made, &path)?;
        }
        Ok(path)
    }

    fn examined(&self, key: &str, stratum: &Stratum, metal: &[Point<Ct>]) -> Result<Examined, Words> {
        let folder = self.folder.join(key);
        let path = folder.join("beads.json");
        if !path.exists() {
            fs::create_dir_all(&self.folder)?;
            // Made beside and renamed when whole: a kill leaves no half of one under its name.
            let beside = tempfile::Builder::new().prefix(MAKING).tempdir_in(&self.folder)?;
            make(beside.path(), key, stratum, metal)?;
            fs::rename(beside.keep(), &folder)?;
        }
        let beads = serde_json::from_str(&fs::read_to_string(&path)?)?;
        let bone = stratum.dials.surface.map(|_| folder.join(BONE));
        Ok(Examined { path, beads, bone })
    }
}

/// The name of an examination's folder is the hash of what it is made of, which says nothing of what stands in it now.
fn as_made(folder: &Path) -> Result<(), FolderError> {
    let path = folder.join("beads.json");
    let name = folder.file_name().unwrap_or_default().to_string_lossy();
    // A kill leaves a folder in which an examination was being made.
    if name.starts_with(MAKING) || !path.exists() {
        return Ok(());
    }
    as_written(HASH, folder, &["beads.json"])?;
    // Only some have a bone.
    match [BONE, BONE_FACTS, BONE_HASH]
        .iter()
        .any(|name| folder.join(name).exists())
    {
        true => as_written(BONE_HASH, folder, &[BONE, BONE_FACTS]),
        false => Ok(()),
    }
}

/// Whether files are those that the hash of was written beside them.
fn as_written(written: &str, folder: &Path, names: &[&str]) -> Result<(), FolderError> {
    let written = folder.join(written);
    let found = fs::read_to_string(&written).map_err(io_at(&written))?;
    match found == hash(folder, names)? {
        true => Ok(()),
        false => Err(FolderError::Changed(
            folder.join(names.first().copied().unwrap_or_default()),
        )),
    }
}

fn make(folder: &Path, key: &str, stratum: &Stratum, metal: &[Point<Ct>]) -> Result<(), Words> {
    let ct = patient::write(folder, &stratum.dials, metal, seed(key)?)?;
    let (volume, out) = (ct.to_string_lossy(), folder.join("beads.json"));
    let out = out.to_string_lossy();
    let radius = (0.5 * stratum.dials.bead_mm).to_string();
    let found = answer(
        ["calib", "beads", &volume, "--radius-mm", &radius, "--out", &out],
        HANDS,
    );
    let bone = match (&found, stratum.dials.surface) {
        (Ok(_), Some(_)) => taken(&ct, folder),
        _ => Ok(()),
    };
    // Tens of megabytes that can be made again, and that the beads' file has the hash of.
    fs::remove_file(&ct)?;
    found
        .map(drop)
        .and(bone)
        .map_err(|why| why.replace(&*folder.to_string_lossy(), ""))?;
    fs::write(folder.join(HASH), hash(folder, &["beads.json"])?)?;
    if stratum.dials.surface.is_some() {
        fs::write(folder.join(BONE_HASH), hash(folder, &[BONE, BONE_FACTS])?)?;
    }
    Ok(())
}

/// Takes the pelvis from the image, as `calib bone` does.
fn taken(ct: &Path, folder: &Path) -> Result<(), String> {
    let (volume, out) = (ct.to_string_lossy(), folder.join(BONE));
    let bounds = format!("--box={PELVIS_MM}");
    let out = out.to_string_lossy();
    let words = [
        "calib",
        "bone",
        &volume,
        &bounds,
        "--threshold-hu",
        BONE_HU,
        "--out",
        &out,
    ];
    answer(words, HANDS).map(drop)
}

fn hash(folder: &Path, names: &[&str]) -> Result<String, FolderError> {
    let mut hash = blake3::Hasher::new();
    for path in names.iter().map(|name| folder.join(name)) {
        hash.update(&fs::read(&path).map_err(io_at(&path))?);
    }
    Ok(hash.finalize().to_hex().to_string())
}

/// 16 hexadecimal digits are a seed.
fn seed(key: &str) -> Result<u64, Words> {
    Ok(u64::from_str_radix(key, 16)?)
}

/// How many different examinations a plan has: strata whose CTs follow from the same numbers share them.
pub(crate) fn count(plan: &Plan) -> usize {
    let patient = patient::patient();
    let keys = plan.strata.iter().flat_map(|stratum| {
        let metal = patient::metal(&patient, &stratum.dials.beads);
        let images = 0..stratum.dials.ct.images.min(stratum.operations);
        images.map(|image| key(stratum, image, &metal)).collect::<Vec<_>>()
    });
    keys.collect::<BTreeSet<_>>().len()
}

/// The first digits of the hash of all that the voxels follow from.
fn key(stratum: &Stratum, image: u64, metal: &[Point<Ct>]) -> String {
    let ct = stratum.dials.ct;
    let mut hash = blake3::Hasher::new();
    hash.update(&mix(stratum.seed ^ mix(image)).to_le_bytes());
    for number in ct.spacing_mm.into_iter().chain([ct.noise_hu, stratum.dials.bead_mm]) {
        hash.update(&number.to_le_bytes());
    }
    for bead in metal {
        for mm in bead.mm() {
            hash.update(&mm.to_le_bytes());
        }
    }
    if stratum.dials.surface.is_some() {
        hash.update(BONE.as_bytes());
    }
    hash.finalize().to_hex()[..16].to_owned()
}
