//! The plan that a scene names becomes part of it: its targets are the scene's, and its examination the only one.

use std::path::PathBuf;

use bus::message::VolumeHash;
use geometry::Point;
use guidance::plan::file::Changed;
use guidance::plan::{Plan, Target};
use scene::raw::{RawTarget, Source};

use super::store::{PlanStore, StoreError};

/// Why a scene's plan is not followed.
#[derive(Debug, thiserror::Error)]
pub(crate) enum FollowError {
    #[error("[plan] file of scene {scene}: {source}")]
    Store { scene: PathBuf, source: Box<StoreError> },
    #[error("[plan] file of scene {scene}: plan {path}: there is no such file; `pilot plan {}` with this --scene makes it", path.display())]
    None { scene: PathBuf, path: PathBuf },
    #[error("[plan] labels of scene {scene}: there is no file {path}")]
    Labels { scene: PathBuf, path: PathBuf },
    #[error("scene {scene}: it has [[targets]] and a [plan] file, whose targets are others; leave one of them out")]
    Both { scene: PathBuf },
    #[error("[plan] of scene {scene}: the plan {path} has the id {found}, and the scene follows {expected} alone")]
    Id {
        scene: PathBuf,
        path: PathBuf,
        found: String,
        expected: String,
    },
    #[error(
        "[plan] file of scene {scene}: nobody has confirmed the plan {path}, and the scene is strict; `pilot plan {} --confirm NAME` \
         with this --scene confirms it", path.display()
    )]
    NotConfirmed { scene: PathBuf, path: PathBuf },
    #[error(
        "[plan] file of scene {scene}: the plan {path} is for the examination {expected}, and the scene loads {found} alone ([volume] hash)"
    )]
    Volume {
        scene: PathBuf,
        path: PathBuf,
        found: String,
        expected: String,
    },
}

/// Takes the plan into the scene. What is left of `[plan]` is its id, so that the scene of a recording stands by itself.
pub(crate) fn follow(source: &mut Source) -> Result<(), FollowError> {
    let scene = source.path.clone();
    let Some(raw) = source.scene.plan.as_mut() else {
        return Ok(());
    };
    if let Some(labels) = raw.labels.as_ref().map(PathBuf::from).filter(|path| !path.exists()) {
        return Err(FollowError::Labels { scene, path: labels });
    }
    let Some(file) = raw.file.take() else { return Ok(()) };
    let path = PathBuf::from(file);
    if source.scene.targets.is_some() {
        return Err(FollowError::Both { scene });
    }
    let store = PlanStore::open(&path, Changed::Refused).map_err(|error| FollowError::Store {
        scene: scene.clone(),
        source: Box::new(error),
    })?;
    let id = store.id();
    let Some(plan) = store.plan() else {
        return Err(FollowError::None { scene, path });
    };
    if let Some(expected) = raw.id.replace(id.clone()).filter(|expected| *expected != id) {
        return Err(FollowError::Id {
            scene,
            path,
            found: id,
            expected,
        });
    }
    if source.scene.workflow.strict && plan.confirmed.is_none() {
        return Err(FollowError::NotConfirmed { scene, path });
    }
    take(source, plan).map_err(|[found, expected]| FollowError::Volume {
        scene,
        path,
        found,
        expected,
    })
}

fn take(source: &mut Source, plan: &Plan) -> Result<(), [String; 2]> {
    let hash = VolumeHash(plan.volume.0).to_string();
    let volume = &mut source.scene.volume;
    let other = volume.hash.take().filter(|other| !other.eq_ignore_ascii_case(&hash));
    if let Some(other) = other {
        return Err([other, hash]);
    }
    volume.hash = Some(hash);
    source.scene.targets = Some(plan.targets.iter().map(target).collect());
    Ok(())
}

fn target(target: &Target) -> RawTarget {
    RawTarget {
        name: target.name.clone(),
        ct_mm: target.centre.mm(),
        diameter_mm: target.diameter_mm,
        entry_ct_mm: target.entry.map(Point::mm),
        stop_mm: target.stop_mm,
    }
}
