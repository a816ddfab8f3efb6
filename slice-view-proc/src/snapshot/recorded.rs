//! An instant of a recording as its run showed it: the held image of a view, byte for byte that of the run and of a replay.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use bus::message::{FrameStamp, Guide, TissueHeader, TissueMeshHeader, TissueShown, ToolPose, Tracked};
use bus::volume::OwnedVolume;
use picture::write_png;
use scene::{Plane, Render, Scene, VolumeSource};

use super::SnapshotError;
use crate::accuracy::Accuracy;
use crate::guide::Chosens;
use crate::overlay::{Notice, Origin};
use crate::overview::{Anatomy, LabelFile, LoadLabels, LoadVolume, OtherLabels};
use crate::remarks::UNJUDGED;
use crate::render::{Rendered, Renderer};
use crate::reslice::{Chosen, Resampler};
use crate::shot::Shot;
use crate::tissue::{Answers, NoTissue, Tissues};

/// An instant of a recording.
#[derive(Debug, Clone, Copy)]
pub enum At<'a> {
    /// So long behind the first pose, as people type it.
    Time(&'a str),
    /// The pose of this number.
    Seq(&'a u64),
}

/// Organs at rest: their header and bytes.
pub type RecordedMesh = (TissueMeshHeader, Vec<u8>);

/// Where organs were: a state's header and the coordinates of its nodes.
pub type RecordedState = (TissueHeader, Vec<f32>);

/// What a recording holds of an instant.
#[derive(Debug)]
pub struct Recorded {
    /// The scene of the run.
    pub scene: Scene,
    /// The examination that was navigated in.
    pub volume_hash: String,
    /// The pose, which is valid.
    pub pose: ToolPose,
    /// When it was published, s behind the recording's first pose.
    pub behind_s: f64,
    /// Whether it is known for how long its measurement had stood still; the image says where it is not.
    pub standstill_judged: bool,
    /// What a person had chosen when it was captured.
    pub guide: Option<Guide>,
    /// The organs at rest and where they were for this very pose; `None` where no model answered it.
    pub tissue: Option<(RecordedMesh, RecordedState)>,
}

/// Reads an instant of a recording. Handed in by the binary, as this crate reads no recordings.
pub type LoadRecorded = fn(&Path, At<'_>) -> Result<Recorded, Box<dyn std::error::Error + Send + Sync>>;

/// Which image of which recording, and where to put it.
#[derive(Debug, Clone)]
pub(crate) struct OfRecording<'a> {
    pub(crate) recording: &'a Path,
    pub(crate) at: At<'a>,
    /// The name of the view.
    pub(crate) view: &'a str,
    /// The examination, where it lies elsewhere by now.
    pub(crate) moved_to: Option<VolumeSource>,
    pub(crate) out: &'a Path,
}

/// Why a recorded instant is not drawn.
#[derive(Debug, thiserror::Error)]
pub enum RecordedError {
    /// The recording.
    #[error("{0}")]
    Recording(Box<dyn std::error::Error + Send + Sync>),
    /// No such view.
    #[error("--view {found:?}: {recording} has the views {known}")]
    View {
        /// What was asked for.
        found: String,
        /// The recording.
        recording: PathBuf,
        /// The names of its views.
        known: String,
    },
    /// Another examination.
    #[error(
        "{recording} was recorded in examination {recorded}, and {shown} was loaded: tube and anatomy would not belong together. Give the recorded one with `--volume PATH`"
    )]
    OtherVolume {
        /// The recording.
        recording: PathBuf,
        /// The hash of the examination that was navigated in.
        recorded: String,
        /// That of the one that was loaded.
        shown: String,
    },
    /// Another label map.
    #[error("{recording}: label map {path}: {why}. Nothing is drawn; give the recorded file back its place")]
    OtherLabels {
        /// The recording.
        recording: PathBuf,
        /// The label map that its scene names.
        path: PathBuf,
        /// What it is, and what was recorded.
        why: OtherLabels,
    },
    /// What was chosen is none.
    #[error("{recording}: what was chosen at pose {seq}: {why}")]
    Guide {
        /// The recording.
        recording: PathBuf,
        /// The pose.
        seq: u64,
        /// Why.
        why: String,
    },
    /// Organs that are none, or of another examination.
    #[error("{recording}, pose {seq}: {why}. Nothing is drawn: an image of less would look like one of all")]
    Tissue {
        /// The recording.
        recording: PathBuf,
        /// The pose.
        seq: u64,
        /// Why.
        why: NoTissue,
    },
}

/// Draws it.
pub(crate) fn recorded(
    what: &OfRecording<'_>,
    (load, load_labels): (LoadVolume, LoadLabels),
    read: LoadRecorded,
) -> Result<(), SnapshotError> {
    let mut found = read(what.recording, what.at).map_err(RecordedError::Recording)?;
    if let Some(source) = &what.moved_to {
        // Region and spacing stay: it is the same examination in another place, and its hash says whether it is.
        found.scene.volume.source = source.clone();
    }
    let scene = &found.scene;
    let named = scene.views.iter().position(|view| view.name == what.view);
    let index = named.ok_or_else(|| RecordedError::View {
        found: what.view.to_owned(),
        recording: what.recording.to_owned(),
        known: scene
            .views
            .iter()
            .map(|view| view.name.as_str())
            .collect::<Vec<_>>()
            .join(", "),
    })?;
    let volume = load(&scene.volume, scene.seed).map_err(SnapshotError::Volume)?;
    let shown = volume.hash.to_string();
    if shown != found.volume_hash {
        let (recording, recorded) = (what.recording.to_owned(), found.volume_hash);
        let other = RecordedError::OtherVolume {
            recording,
            recorded,
            shown,
        };
        return Err(other.into());
    }
    let mut renderer = Renderer::new(scene.views[index].clone());
    if renderer.view().plane == Plane::Surface {
        let labels = scene.plan.labels.as_deref().map(|path| LabelFile {
            path,
            examination: &scene.volume,
            load: load_labels,
            expected: scene.plan.labels_hash.as_deref(),
            is_recorded: true,
        });
        let anatomy = Anatomy::of(&volume.view(), renderer.view().surface.bone_hu, labels, &mut || {});
        if let (Some(why), Some(labels)) = (&anatomy.other, labels) {
            let other = RecordedError::OtherLabels {
                recording: what.recording.to_owned(),
                path: labels.path.to_owned(),
                why: why.clone(),
            };
            return Err(other.into());
        }
        renderer.show_anatomy(Arc::new(anatomy));
    }
    let stamp = drawn(&mut renderer, (what.recording, &found), &volume)?;
    let mut texts = stamp.texts();
    texts.push(("view", what.view.to_owned()));
    write_png(what.out, renderer.canvas(), &texts)?;
    bus::stderr_line!(
        "slice-view-proc: pose {}, published {:.3} s behind the first one",
        found.pose.seq,
        found.behind_s
    );
    Ok(())
}

/// The held image of the instant.
fn drawn(
    renderer: &mut Renderer,
    (recording, found): (&Path, &Recorded),
    volume: &OwnedVolume,
) -> Result<FrameStamp, SnapshotError> {
    let (scene, sample) = (&found.scene, &found.pose);
    let mut chosens = Chosens::default();
    if let Some(why) = found.guide.as_ref().and_then(|guide| chosens.take(guide)) {
        let (recording, seq) = (recording.to_owned(), sample.seq);
        return Err(RecordedError::Guide { recording, seq, why }.into());
    }
    let said = chosens.at(sample.t_capture_ns).cloned().unwrap_or_default();
    let tissue = match renderer.view().plane {
        Plane::Surface => None,
        _ => answers((recording, found), volume)?,
    };
    let pose = match sample.tracked() {
        Ok(Tracked::Valid(pose)) => Some(pose),
        _ => None,
    };
    let mut what = Rendered {
        volume: volume.view(),
        volume_name: &found.volume_hash[..8],
        marks: volume.marks,
        pose,
        accuracy: pose.map(|pose| Accuracy::of(sample, pose)),
        notice: Notice::Requested,
        origin: Origin::Recording,
        remarks: match found.standstill_judged {
            true => &[],
            false => &[UNJUDGED],
        },
        chosen: said.chosen.as_ref(),
        seq: sample.seq,
        registration_id: sample.registration_id,
        tissue: Tissues::default(),
    };
    let sampling = renderer.view().sampling;
    let failed = |why| SnapshotError::Reslice {
        filter: sampling.filter,
        why,
    };
    let mut resampler = Chosen::new(Render::cpu());
    let prepared = resampler.prepare(&what.volume, &[sampling], &mut || {});
    prepared.map_err(failed)?;
    let shot = Shot {
        sample,
        now_ns: None,
        scene,
        images: &said.images,
        tissue: tissue.as_ref(),
    };
    let stamp = shot.take(renderer, &mut what, resampler.exact());
    if what.tissue.shown == TissueShown::Late {
        bus::stderr_line!(
            "slice-view-proc: {} has no state of organs of pose {}: the image has them at rest, and says so",
            recording.display(),
            sample.seq
        );
    }
    Ok(FrameStamp {
        volume_hash: volume.hash.0,
        ..stamp.map_err(SnapshotError::Render)?
    })
}

/// Where organs were; `None` where none of the scene move.
fn answers((recording, found): (&Path, &Recorded), volume: &OwnedVolume) -> Result<Option<Answers>, RecordedError> {
    let Some(spec) = &found.scene.tissue else {
        return Ok(None);
    };
    let mut answers = Answers::new(spec.piece_mm, spec.tolerance);
    if let Some((mesh, state)) = &found.tissue {
        let taken = answers.take_mesh((&mesh.0, &mesh.1), &volume.hash.0);
        let taken = taken.and_then(|()| answers.take_state(&state.0, &state.1));
        taken.map_err(|why| RecordedError::Tissue {
            recording: recording.to_owned(),
            seq: found.pose.seq,
            why,
        })?;
    }
    Ok(Some(answers))
}

#[cfg(test)]
mod tests;
