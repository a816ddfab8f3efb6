//! Which files pictures are made of besides the examination: a run writes their hashes into its scene, so that they are in its recording, and
//! a replay refuses others.

use std::io::Read;
use std::path::{Path, PathBuf};

use bus::volume::LabelMap;
use scene::Scene;
use scene::VolumeSpec;
use scene::raw::{Plane, RawScene};

/// Reads the label map of an examination; the number is the generated patient's seed.
pub(crate) type LoadLabels = fn(&Path, &VolumeSpec, u64) -> Result<LabelMap, Box<dyn std::error::Error + Send + Sync>>;

/// A longer file is no scene of organs, bytes.
const MOST_BYTES: u64 = 4 << 20;

/// Another file than pictures are to be made of, in words.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub(crate) struct OtherFile(String);

/// What a file is: its BLAKE3, or that of a label map's geometry and voxels.
struct Found {
    what: &'static str,
    key: &'static str,
    path: PathBuf,
    hash: String,
}

/// Which files are looked at.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Made {
    /// The label map, of which an overview has its structures.
    pub(crate) overview: bool,
    /// The scene of organs and its label map, which a model moves.
    pub(crate) organs: bool,
}

impl Made {
    /// What the pictures of a run that navigates are made of.
    pub(crate) fn by(scene: &Scene) -> Self {
        Self {
            overview: scene.views.iter().any(|view| view.plane == Plane::Surface),
            organs: scene.tissue.is_some(),
        }
    }
}

/// Writes into `raw` what the files are of which pictures are made.
///
/// # Errors
/// [`OtherFile`] where the scene says already which, and they are others.
pub(crate) fn write(raw: &mut RawScene, scene: &Scene, load: LoadLabels) -> Result<(), OtherFile> {
    for found in found(scene, Made::by(scene), load) {
        refuse(raw, &found, "the scene")?;
        if let Some(slot) = slot(raw, found.key) {
            *slot = Some(found.hash);
        }
    }
    Ok(())
}

/// Holds the files of `scene` against what `raw` says of them; in words those of which it says nothing.
///
/// # Errors
/// [`OtherFile`].
pub(crate) fn check(
    raw: &mut RawScene,
    (scene, made): (&Scene, Made),
    whose: &Path,
    load: LoadLabels,
) -> Result<Vec<String>, OtherFile> {
    let mut unknown = Vec::new();
    for found in found(scene, made, load) {
        refuse(raw, &found, &whose.display().to_string())?;
        if slot(raw, found.key).is_none_or(|slot| slot.is_none()) {
            unknown.push(format!(
                "{} does not say which {} it was made with: it is not known whether {} is that one",
                whose.display(),
                found.what,
                found.path.display()
            ));
        }
    }
    Ok(unknown)
}

fn refuse(raw: &mut RawScene, found: &Found, scene: &str) -> Result<(), OtherFile> {
    match slot(raw, found.key).and_then(|slot| slot.clone()) {
        Some(expected) if !expected.eq_ignore_ascii_case(&found.hash) => Err(OtherFile(format!(
            "{} {}: its hash is {}, and {expected} is expected ({} of {scene}): pictures would show something else. Put the expected file in \
             its place",
            found.what,
            found.path.display(),
            found.hash,
            found.key
        ))),
        _ => Ok(()),
    }
}

/// Where a scene says which file it is.
fn slot<'a>(raw: &'a mut RawScene, key: &str) -> Option<&'a mut Option<String>> {
    match key {
        PLAN_LABELS => raw.plan.as_mut().map(|plan| &mut plan.labels_hash),
        ORGANS => raw.tissue.as_mut().map(|tissue| &mut tissue.organs_hash),
        _ => raw.tissue.as_mut().map(|tissue| &mut tissue.labels_hash),
    }
}

const PLAN_LABELS: &str = "plan.labels_hash";
const ORGANS: &str = "tissue.organs_hash";
const ORGAN_LABELS: &str = "tissue.labels_hash";

/// Takes over what the scene of a recording says of its files.
pub(crate) fn take_over(raw: &mut RawScene, recorded: &mut RawScene) {
    for key in [PLAN_LABELS, ORGANS, ORGAN_LABELS] {
        let said = slot(recorded, key).and_then(|slot| slot.clone());
        if let (Some(said), Some(slot)) = (said, slot(raw, key)) {
            *slot = Some(said);
        }
    }
}

/// The files that are there. Whoever makes pictures of one that cannot be read says that it is missing.
fn found(scene: &Scene, made: Made, load: LoadLabels) -> Vec<Found> {
    let map = |what, key, path: PathBuf| {
        // The generated patient's structures are no file.
        let is_file = !scene::is_generated(&path) && path.exists();
        let map = is_file.then(|| load(&path, &scene.volume, scene.seed))?.ok()?;
        let hash = map.volume.hash.to_string();
        Some(Found { what, key, path, hash })
    };
    let labels = scene.plan.labels.clone().filter(|_| made.overview);
    let labels = labels.and_then(|path| map("the label map", PLAN_LABELS, path));
    let organs = scene.tissue.as_ref().filter(|_| made.organs);
    let organs = organs.and_then(|spec| Some((spec.organs.clone(), text(&spec.organs)?)));
    let of_organs = organs.as_ref().and_then(|(path, text)| {
        let labels = labels_of(path, text)?;
        map("the label map of the organs", ORGAN_LABELS, labels)
    });
    let organs = organs.map(|(path, text)| Found {
        what: "the scene of organs",
        key: ORGANS,
        path,
        hash: blake3::hash(text.as_bytes()).to_string(),
    });
    labels.into_iter().chain(organs).chain(of_organs).collect()
}

/// The label map that a scene of organs names, as its readers take it; `None` where it cannot be read, which they say themselves.
pub(crate) fn labels_of_organs(organs: &Path) -> Option<PathBuf> {
    labels_of(organs, &text(organs)?)
}

fn labels_of(organs: &Path, text: &str) -> Option<PathBuf> {
    let named: toml::Table = text.parse().ok()?;
    let labels = named.get("space")?.get("labels")?.as_str()?;
    Some(scene::labels_beside(organs, Path::new(labels)))
}

fn text(path: &Path) -> Option<String> {
    let mut text = String::new();
    let (file, _) = scene::file::open(path).ok()?;
    file.take(MOST_BYTES + 1).read_to_string(&mut text).ok()?;
    (text.len() as u64 <= MOST_BYTES).then_some(text)
}

#[cfg(test)]
mod tests {
    use super::*;
    use bus::message::{Marks, VolumeHash};
    use bus::volume::{Layout, OwnedVolume, Voxels};
    use geometry::{Affine, VolumeGrid};
    use scene::raw;
    use std::fs;

    const SCENE: &str = "[recording]\n[tissue]\norgans = \"o.toml\"\n[plan]\nlabels = \"l.nii\"\n[[views]]\nname = \"s\"\nplane = \"surface\"\nextent = \"global\"\n";

    /// A map whose hash is that of the file.
    fn load(path: &Path, _: &VolumeSpec, _: u64) -> Result<LabelMap, Box<dyn std::error::Error + Send + Sync>> {
        let hash = VolumeHash(*blake3::hash(&fs::read(path)?).as_bytes());
        let rows = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
        let layout = Layout::new([1; 3], [1; 3])?;
        let volume = OwnedVolume {
            grid: VolumeGrid::checked([1; 3], Affine::from_rows(rows))?,
            voxels: Voxels::zeroed(layout.stored() as usize),
            layout,
            padding_hu: 0,
            hash,
            marks: Marks::NONE,
        };
        Ok(LabelMap {
            volume,
            is_in_its_frame: false,
            doubts: Vec::new(),
        })
    }

    /// Organs of today's files were moved again as those of the run.
    #[test]
    fn files_that_pictures_are_made_of_are_known_by_their_hash_and_others_refused() {
        let folder = tempfile::tempdir().unwrap();
        let put = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
        put("o.toml", "[space]\nlabels = \"k.nii\"\n");
        put("k.nii", "kidney");
        put("l.nii", "labels");
        put("s.toml", SCENE);
        let (path, all) = (
            folder.path().join("s.toml"),
            Made {
                overview: true,
                organs: true,
            },
        );
        let mut raw = raw::load(&path).unwrap();
        let scene = Scene::from_raw(&raw).unwrap();
        let recording = Path::new("s.mcap");
        // Before anything is written down, nobody knows.
        let unknown = check(&mut raw.scene, (&scene, all), recording, load).unwrap();
        assert_eq!(unknown.len(), 3, "{unknown:?}");
        write(&mut raw.scene, &scene, load).unwrap();
        assert_eq!(check(&mut raw.scene, (&scene, all), recording, load).unwrap(), [""; 0]);
        for (name, key) in [("o.toml", ORGANS), ("k.nii", ORGAN_LABELS), ("l.nii", PLAN_LABELS)] {
            let was = fs::read(folder.path().join(name)).unwrap();
            let other = [&was[..], b"# another\n"].concat();
            fs::write(folder.path().join(name), &other).unwrap();
            let refused = check(&mut raw.scene, (&scene, all), recording, load)
                .unwrap_err()
                .to_string();
            let hashes = [&was, &other].map(|bytes| blake3::hash(bytes).to_string());
            assert!(
                [name, key, &hashes[0], &hashes[1]]
                    .iter()
                    .all(|word| refused.contains(word)),
                "{refused}"
            );
            // The same for a run of a scene that says which they are.
            assert!(write(&mut raw.scene, &scene, load).is_err());
            fs::write(folder.path().join(name), was).unwrap();
        }
        // Another scene says nothing of them: what the recorded one says holds.
        let mut other = raw::load(&path).unwrap();
        take_over(&mut other.scene, &mut raw.scene);
        put("k.nii", "liver");
        assert!(check(&mut other.scene, (&scene, all), recording, load).is_err());
        // Where states are the recorded ones no organs are read.
        let shown = Made {
            overview: true,
            organs: false,
        };
        assert!(check(&mut other.scene, (&scene, shown), recording, load).is_ok());
    }
}
