//! The overview: surfaces of bone and structures, with the tube and what it is aimed at among them.
//!
//! The anatomy is drawn again where the camera moves only; its colours and depths are kept. For each pose the things of the operation are
//! drawn by themselves and laid over it, pixel by pixel: solid where they are in front, and in stripes where the anatomy is before them, as a
//! tube that vanished behind a rib would be taken for one that is not there, and one that was drawn over it for one before it.

mod anatomy;
mod things;

use std::sync::Arc;

use geometry::SlicePlane;
use picture::Canvas;
use surface::{Mesh, PAINTS, Rgb, ZBuffer};

pub use anatomy::{Anatomy, LabelFile, LoadLabels, LoadVolume, OtherLabels};
pub(crate) use things::Things;

/// Where nothing is: no grey of a slice.
const GROUND: Rgb = [12, 14, 22];
/// Bone, and the structures in turn: quiet, so that tube, targets and alarms stand out. Which structure has which says nothing.
const ANATOMY: [Rgb; PAINTS] = [
    [206, 200, 188],
    [164, 104, 92],
    [112, 134, 96],
    [104, 112, 152],
    [160, 136, 92],
    [138, 104, 136],
    [92, 130, 126],
];
/// Of what is behind, so many of these diagonals are seen.
const STRIPES: usize = 4;
const SEEN: usize = 2;

/// One image of a surface; its buffers are taken once.
#[derive(Debug)]
pub(crate) struct Overview {
    anatomy: Option<Arc<Anatomy>>,
    /// The anatomy, as it was seen along this camera.
    kept: ZBuffer,
    kept_along: Option<SlicePlane>,
    things: ZBuffer,
    solids: Mesh,
}

impl Overview {
    pub(crate) fn new(size: [u32; 2]) -> Self {
        Self {
            anatomy: None,
            kept: ZBuffer::new(size),
            kept_along: None,
            things: ZBuffer::new(size),
            solids: Mesh::default(),
        }
    }

    pub(crate) fn show(&mut self, anatomy: Arc<Anatomy>) {
        (self.anatomy, self.kept_along) = (Some(anatomy), None);
    }

    /// What the image must say of its anatomy; empty while all is there.
    pub(crate) fn caution(&self) -> &str {
        self.anatomy
            .as_ref()
            .map_or("NO ANATOMY YET", |anatomy| &anatomy.caution)
    }

    pub(crate) fn draw(&mut self, canvas: &mut Canvas, camera: &SlicePlane, things: &Things<'_>) {
        if self.kept_along != Some(*camera) {
            self.kept.clear();
            for mesh in self.anatomy.iter().flat_map(|anatomy| &anatomy.meshes) {
                self.kept.draw(mesh, camera, &ANATOMY);
            }
            self.kept_along = Some(*camera);
        }
        self.things.clear();
        things.draw(camera, &mut self.solids, &mut self.things);
        self.lay_over(canvas);
    }

    fn lay_over(&self, canvas: &mut Canvas) {
        let width = canvas.width() as usize;
        let anatomy = self.kept.depths().iter().zip(self.kept.colours());
        let things = self.things.depths().iter().zip(self.things.colours());
        let pixels = canvas.rgba_mut().as_chunks_mut::<4>().0;
        for (i, ((pixel, (far, ground)), (near, thing))) in pixels.iter_mut().zip(anatomy).zip(things).enumerate() {
            let ground = if far.is_finite() { *ground } else { GROUND };
            let is_seen = near.is_finite() && (near <= far || (i % width + i / width) % STRIPES < SEEN);
            let [r, g, b] = if is_seen { *thing } else { ground };
            *pixel = [r, g, b, 255];
        }
    }
}
