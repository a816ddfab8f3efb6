//! What the overview shows of an examination: made once.

use std::path::Path;
use std::time::Duration;

use bus::volume::{LabelMap, OwnedVolume, VolumeView};
use geometry::VolumeGrid;
use scene::VolumeSpec;
use surface::{Field, Mesh, SurfaceError};

/// Reads a volume from a file or a folder, or generates the patient of a seed. Handed in by the binary, as this crate knows no file formats.
pub type LoadVolume = fn(&VolumeSpec, u64) -> Read<OwnedVolume>;

/// Reads the label map of an examination from a file.
pub type LoadLabels = fn(&Path, &VolumeSpec) -> Read<LabelMap>;

type Read<T> = Result<T, Box<dyn std::error::Error + Send + Sync>>;

/// A label map that is to be read.
#[derive(Debug, Clone, Copy)]
pub struct LabelFile<'a> {
    /// Its file.
    pub path: &'a Path,
    /// Whose structures it has.
    pub examination: &'a VolumeSpec,
    /// Who reads it.
    pub load: LoadLabels,
    /// The hash of the only one that is shown; `None`: nothing says which.
    pub expected: Option<&'a str>,
    /// Whether what is shown was recorded: then nothing but the hash says that it is the map of the run.
    pub is_recorded: bool,
}

/// While surfaces are made, a sign of life is given this often.
const ALIVE: Duration = Duration::from_millis(50);

/// The surfaces of an examination, with what images of them must say.
#[derive(Debug)]
pub struct Anatomy {
    pub(crate) meshes: Vec<Mesh>,
    pub(crate) caution: String,
    /// Why the structures of another label map than the expected one are not shown.
    pub(crate) other: Option<OtherLabels>,
}

/// Another label map than the expected one.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "its hash is {found}, and {expected} is expected (plan.labels_hash): it may have other structures than were seen"
)]
pub struct OtherLabels {
    /// The hash of the one that lies there.
    pub found: String,
    /// That of the one that is to be shown.
    pub expected: String,
}

/// Why there are no structures.
#[derive(Debug, thiserror::Error)]
enum NoStructures {
    #[error(transparent)]
    Other(#[from] OtherLabels),
    #[error(transparent)]
    Read(#[from] Box<dyn std::error::Error + Send + Sync>),
    // Of other voxels it may be of another patient.
    #[error("its voxels are not those of the examination")]
    Grid,
    #[error(transparent)]
    Surface(#[from] SurfaceError),
}

impl Anatomy {
    /// Bone from `bone_hu` on, and the structures of the label map that is named, which must be of the voxels of `volume`. Whatever is not
    /// there is told on the images, and why on stderr. Calls `alive` several times a second.
    pub fn of(volume: &VolumeView<'_>, bone_hu: f64, labels: Option<LabelFile<'_>>, alive: &mut dyn FnMut()) -> Self {
        let (mut meshes, mut cautions, mut other) = (Vec::new(), Vec::new(), None);
        match meanwhile(alive, || bone(volume, bone_hu)) {
            Ok(mesh) if mesh.is_empty() => cautions.push("NO BONE FOUND"),
            Ok(mesh) => meshes.push(mesh),
            Err(error) => {
                bus::stderr_line!("slice-view-proc: error: bone from {bone_hu} HU on: {error}. It is not shown");
                cautions.push("BONE NOT SHOWN");
            }
        }
        if let Some(map) = labels {
            match meanwhile(alive, || structures(&map, volume.grid)) {
                Ok((mesh, _)) if mesh.is_empty() => cautions.push("NO STRUCTURES FOUND"),
                Ok((mesh, is_doubtful)) => {
                    meshes.push(mesh);
                    if is_doubtful {
                        cautions.push("STRUCTURES IN DOUBT");
                    }
                    if map.is_recorded && map.expected.is_none() {
                        cautions.push("STRUCTURES NOT VERIFIED");
                    }
                }
                Err(why) => {
                    bus::stderr_line!(
                        "slice-view-proc: error: label map {}: {why}. It is not shown",
                        map.path.display()
                    );
                    cautions.push("STRUCTURES NOT SHOWN");
                    if let NoStructures::Other(why) = why {
                        other = Some(why);
                    }
                }
            }
        }
        Self {
            meshes,
            caution: cautions.join(", "),
            other,
        }
    }

    /// The triangles of all surfaces together.
    pub fn triangles(&self) -> usize {
        self.meshes.iter().map(|mesh| mesh.triangles().len()).sum()
    }
}

fn bone(volume: &VolumeView<'_>, bone_hu: f64) -> Result<Mesh, SurfaceError> {
    let mut field = Field {
        grid: volume.grid,
        read: &mut |z, slice| volume.slice(z, slice),
    };
    surface::bone(&mut field, bone_hu)
}

/// The surfaces of a label map, and whether its reader doubts whose they are; why is told on stderr.
fn structures(map: &LabelFile<'_>, ct: &VolumeGrid) -> Result<(Mesh, bool), NoStructures> {
    let labels = (map.load)(map.path, map.examination)?;
    let found = labels.volume.hash.to_string();
    if let Some(expected) = map.expected.filter(|expected| *expected != found) {
        let expected = expected.to_owned();
        return Err(OtherLabels { found, expected }.into());
    }
    if labels.lies_on(ct).is_doubtful() {
        return Err(NoStructures::Grid);
    }
    let view = labels.volume.view();
    let mut field = Field {
        grid: &labels.volume.grid,
        read: &mut |z, slice| view.slice(z, slice),
    };
    Ok((surface::structures(&mut field)?, !labels.doubts.is_empty()))
}

/// Does long work while this thread gives signs of life.
fn meanwhile<T: Send>(alive: &mut dyn FnMut(), work: impl FnOnce() -> T + Send) -> T {
    std::thread::scope(|scope| {
        let working = scope.spawn(work);
        while !working.is_finished() {
            alive();
            std::thread::sleep(ALIVE);
        }
        working.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use bus::message::{Marks, VolumeHash};
    use bus::volume::{Layout, Voxels};
    use geometry::Affine;

    fn cube() -> OwnedVolume {
        let rows = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
        let layout = Layout::new([16; 3], [1; 3]).unwrap();
        let mut voxels = Voxels::zeroed(layout.stored() as usize);
        for at in 0..4096 {
            let place = [at % 16, at / 16 % 16, at / 256];
            voxels[layout.offset(place)] = i16::from(place.iter().all(|i| (4..12).contains(i)));
        }
        OwnedVolume {
            grid: VolumeGrid::checked([16; 3], Affine::from_rows(rows)).unwrap(),
            layout,
            voxels,
            padding_hu: 0,
            hash: VolumeHash([0; 32]),
            marks: Marks::NONE,
        }
    }

    fn labels(doubts: &[&str]) -> Read<LabelMap> {
        Ok(LabelMap {
            volume: cube(),
            is_in_its_frame: true,
            doubts: doubts.iter().map(|doubt| (*doubt).to_owned()).collect(),
        })
    }

    /// Structures that nobody approved were drawn like any others.
    #[test]
    fn structures_in_doubt_are_drawn_and_said_to_be_in_doubt() {
        let (volume, examination) = (cube(), VolumeSpec::of_path("ct".into()));
        let loads: [(LoadLabels, &str); 2] = [
            (|_, _| labels(&[]), "NO BONE FOUND"),
            (|_, _| labels(&["UNAPPROVED"]), "NO BONE FOUND, STRUCTURES IN DOUBT"),
        ];
        for (load, caution) in loads {
            let map = LabelFile {
                path: Path::new("organs.dcm"),
                examination: &examination,
                load,
                expected: None,
                is_recorded: false,
            };
            let anatomy = Anatomy::of(&volume.view(), 300.0, Some(map), &mut || {});
            assert_eq!((anatomy.caution.as_str(), anatomy.meshes.len()), (caution, 1));
        }
    }
}
