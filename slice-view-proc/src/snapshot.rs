//! One image of one pose of one file, without a run.

use std::path::{Path, PathBuf};

use bus::message::FrameStamp;
use bus::scene::{Extent, Filter, Plane, Scene, SceneError, Up, View, WindowLevel};
use bus::volume::OwnedVolume;
use geometry::{Ct, DoorError, PlaneError, Rigid, Tool};
use picture::PngError;

use crate::mha::{MhaError, write_mha};
use crate::overlay::Notice;
use crate::render::{Rendered, Renderer};
use crate::reslice::{Cpu, Reference, Resampler};

/// Reads a volume from a file; `phantom` is the generated patient. Handed in by the binary, as this crate knows no file
/// formats.
pub type LoadVolume = fn(&Path) -> Result<OwnedVolume, Box<dyn std::error::Error + Send + Sync>>;

/// What to draw and where to put it.
#[derive(Debug, Clone)]
pub(crate) struct Snapshot {
    pub(crate) volume: PathBuf,
    pub(crate) plane: Plane,
    pub(crate) pose: Rigid<Ct, Tool>,
    pub(crate) size: [u32; 2],
    pub(crate) pixel_mm: f64,
    pub(crate) filter: Filter,
    pub(crate) window: WindowLevel,
    pub(crate) reference: bool,
    pub(crate) out: Option<PathBuf>,
    pub(crate) hu: Option<PathBuf>,
}

/// Why there is no snapshot.
#[derive(Debug, thiserror::Error)]
pub enum SnapshotError {
    /// The volume cannot be read.
    #[error("{0}")]
    Volume(Box<dyn std::error::Error + Send + Sync>),
    /// The pose is not a pose.
    #[error("--pose: {0}")]
    Pose(DoorError),
    /// The plane is unusable.
    #[error("--size, --pixel-mm: {0}")]
    Plane(#[from] PlaneError),
    /// The embedded scene is broken.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The PNG was not written.
    #[error(transparent)]
    Png(#[from] PngError),
    /// The MetaImage was not written.
    #[error(transparent)]
    Mha(#[from] MhaError),
}

/// Draws it.
pub(crate) fn snapshot(what: &Snapshot, load: LoadVolume) -> Result<(), SnapshotError> {
    let volume = load(&what.volume).map_err(SnapshotError::Volume)?;
    let scene = Scene::parse("", Path::new("(defaults)"))?;
    let mut renderer = Renderer::new(View {
        name: "snapshot".to_owned(),
        plane: what.plane,
        extent: Extent::Local,
        size: what.size,
        field_mm: what.pixel_mm * f64::from(what.size[0].min(what.size[1])),
        filter: what.filter,
        window: what.window,
        up: Up::Superior,
    });
    let rendered = Rendered {
        volume: volume.view(),
        volume_name: &volume.hash.to_string()[..8],
        pose: Some(what.pose),
        notice: Notice::Held,
        seq: 0,
        registration_id: 0,
    };
    let resampler: &mut dyn Resampler = if what.reference { &mut Reference } else { &mut Cpu };
    let plane = renderer.render(&rendered, &scene, resampler)?;
    if let Some(path) = &what.out {
        let stamp = FrameStamp {
            volume_hash: volume.hash.0,
            ..FrameStamp::default()
        };
        picture::write_png(path, renderer.canvas(), &stamp.texts())?;
    }
    if let Some(path) = &what.hu {
        write_mha(path, &plane, renderer.hu())?;
    }
    Ok(())
}
