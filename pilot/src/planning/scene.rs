//! The scene of a run in which a plan is made: the examination and its images, no tool.

use scene::raw::{Drawn, Extent, Plane, RawTracker, RawTrackerSource, RawView, Source};
use scene::raw::{RawWindow, Up};

use super::store::PlanStore;

/// A side of a planning image, pixels: about that of a quarter of a full-HD screen between its bars.
const SIDE: u32 = 512;

/// Leaves of a resolved scene what planning needs: the examination, whose it is, what ways are measured against, the tool's size. A plan
/// that is there already admits its own examination only.
pub(crate) fn planning_scene(source: &mut Source, store: &PlanStore) {
    let scene = &mut source.scene;
    scene.targets = Some(Vec::new());
    scene.guide.target = None;
    scene.recording = None;
    scene.tracker = RawTracker {
        source: RawTrackerSource::External,
        ..RawTracker::default()
    };
    let planes = [Plane::Axial, Plane::Frontal, Plane::Sagittal, Plane::Perpendicular];
    scene.views = Some(planes.map(view).to_vec());
    if let Some(plan) = store.plan() {
        scene.volume.hash = Some(bus::message::VolumeHash(plan.volume.0).to_string());
    }
}

fn view(plane: Plane) -> RawView {
    RawView {
        name: plane.name().to_owned(),
        plane,
        extent: Extent::Global,
        size: [SIDE; 2],
        field_mm: 100.0,
        filter: Default::default(),
        slab: None,
        minify: Default::default(),
        ahead_mm: 0.0,
        window: RawWindow::default(),
        up: Up::default(),
        text: 1.8,
        overlay: Drawn::State,
        surface: None,
    }
}
