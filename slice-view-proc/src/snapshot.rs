//! One image of one pose of one file, without a run.

mod recorded;

use std::path::{Path, PathBuf};

use bus::message::FrameStamp;
use geometry::{Ct, DoorError, PlaneError, Rigid, Tool};
use picture::PngError;
use scene::{
    Drawn, Extent, Filter, Plane, Render, Sampling, Scene, SceneError, Surface, THICKNESS_MM, Up, View, VolumeSpec,
    WindowLevel,
};

use crate::mha::{MhaError, write_mha};
use crate::overlay::{Notice, Origin};
use crate::overview::{Anatomy, LoadVolume};
use crate::render::{RenderError, Rendered, Renderer};
use crate::reslice::{Chosen, Reference, Resampler, ResliceError};
use crate::tissue::Tissues;
pub use recorded::{At, LoadRecorded, Recorded, RecordedError, RecordedMesh, RecordedState};
pub(crate) use recorded::{OfRecording, recorded};

/// What to draw and where to put it.
#[derive(Debug, Clone)]
pub(crate) struct Snapshot {
    pub(crate) volume: VolumeSpec,
    pub(crate) plane: Plane,
    pub(crate) pose: Rigid<Ct, Tool>,
    pub(crate) size: [u32; 2],
    pub(crate) pixel_mm: f64,
    pub(crate) sampling: Sampling,
    pub(crate) ahead_mm: f64,
    pub(crate) window: WindowLevel,
    pub(crate) surface: Surface,
    pub(crate) reference: bool,
    pub(crate) render: Render,
    pub(crate) out: Option<PathBuf>,
    pub(crate) hu: Option<PathBuf>,
}

/// Why there is no snapshot.
#[derive(Debug, thiserror::Error)]
pub enum SnapshotError {
    /// The image was not drawn.
    #[error(transparent)]
    Render(RenderError),
    /// The volume cannot be read.
    #[error("{0}")]
    Volume(Box<dyn std::error::Error + Send + Sync>),
    /// No direction of planes.
    #[error(
        "--view {0:?}: expected axial, frontal, sagittal, perpendicular or surface; with --recording the name of one of its views"
    )]
    View(String),
    /// The pose is not a pose.
    #[error("--pose: {0}")]
    Pose(DoorError),
    /// The plane is unusable.
    #[error("--size, --pixel-mm: {0}")]
    Plane(PlaneError),
    /// The slab is too thin, too thick or not a number.
    #[error("--slab-mm: {0} mm; allowed are {low} to {high} mm", low = THICKNESS_MM.start(), high = THICKNESS_MM.end())]
    Slab(f64),
    /// The plane's distance is not a number.
    #[error("--ahead-mm: {0} mm; a finite number is needed")]
    Ahead(f64),
    /// An overview has no voxels to be written.
    #[error("--hu: a surface has no HU; leave it out, or take another --view")]
    NoHu,
    /// The volume was not sampled.
    #[error("--filter {}: {why}", filter.name())]
    Reslice {
        /// The filter.
        filter: Filter,
        /// What is wrong.
        why: ResliceError,
    },
    /// The embedded scene is broken.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The PNG was not written.
    #[error(transparent)]
    Png(#[from] PngError),
    /// The MetaImage was not written.
    #[error(transparent)]
    Mha(#[from] MhaError),
    /// An instant of a recording was not drawn.
    #[error(transparent)]
    Recorded(#[from] RecordedError),
}

/// The generated patient without a scene is that of `volume-loader phantom`.
const SEED: u64 = 1;

/// Draws it.
pub(crate) fn snapshot(what: &Snapshot, load: LoadVolume) -> Result<(), SnapshotError> {
    if what.plane == Plane::Surface && what.hu.is_some() {
        return Err(SnapshotError::NoHu);
    }
    let mut scene = Scene::parse("", Path::new("(defaults)"))?;
    let volume = load(&what.volume, SEED).map_err(SnapshotError::Volume)?;
    // One image: there are no others whose planes could cut it.
    scene.views.clear();
    let field_mm = what.pixel_mm * f64::from(what.size[0].min(what.size[1]));
    let mut renderer = Renderer::new(View {
        name: "snapshot".to_owned(),
        plane: what.plane,
        extent: Extent::Local,
        size: what.size,
        field_mm,
        sampling: what.sampling,
        ahead_mm: what.ahead_mm,
        window: what.window,
        up: Up::Superior,
        text: 1.0,
        overlay: Drawn::All,
        surface: Surface {
            field_mm: Some(field_mm),
            ..what.surface
        },
    });
    if what.plane == Plane::Surface {
        let anatomy = Anatomy::of(&volume.view(), what.surface.bone_hu, None, &mut || {});
        renderer.show_anatomy(std::sync::Arc::new(anatomy));
    }
    let rendered = Rendered {
        volume: volume.view(),
        volume_name: &volume.hash.to_string()[..8],
        marks: volume.marks,
        pose: Some(what.pose),
        accuracy: None,
        notice: Notice::Requested,
        origin: Origin::Tracker,
        remarks: &[],
        chosen: None,
        seq: 0,
        registration_id: 0,
        tissue: Tissues::default(),
    };
    let (mut reference, mut chosen) = (Reference::default(), Chosen::new(what.render));
    let resampler: &mut dyn Resampler = if what.reference { &mut reference } else { &mut chosen };
    let prepared = resampler.prepare(&rendered.volume, &[what.sampling], &mut || {});
    let failed = |why| SnapshotError::Reslice {
        filter: what.sampling.filter,
        why,
    };
    prepared.map_err(failed)?;
    chosen.settle(&rendered.volume);
    let resampler: &mut dyn Resampler = if what.reference { &mut reference } else { &mut chosen };
    let plane = renderer.render(&rendered, &scene, resampler);
    let plane = plane.map_err(|error| match error {
        RenderError::Plane(why) => SnapshotError::Plane(why),
        RenderError::Reslice(why) => failed(why),
        other => SnapshotError::Render(other),
    })?;
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
