//! One image from one pose.

mod organs;

use std::sync::Arc;

use bus::message::{Chosen, FrameState, Images, Marks, TissueShown};
use bus::volume::VolumeView;
use geometry::{Ct, DoorError, PlaneError, Point, Rigid, SlicePlane, Tool};
use picture::Canvas;
use scene::{Extent, Plane, Scene, View, WindowLevel};

use crate::accuracy::Accuracy;
use crate::grey::to_grey;
use crate::outside::{hatch, hatch_all};
use crate::overlay::{Notice, Origin, Overlay};
use crate::overview::{Anatomy, Overview, Things};
use crate::reslice::{Resampler, ResliceError};
use crate::tissue::Tissues;
use crate::view;
use crate::warp::NoWarp;
use organs::Organs;

/// How bright the last slice stays when there is no pose: 1 is 256.
const DIMMED: u16 = 90;
/// The same where there is a pose, but no state of the organs in time: they are not where they are drawn.
const LATE: u16 = 170;

/// Draws the images of one view; its buffers are taken once.
#[derive(Debug)]
pub struct Renderer {
    view: View,
    canvas: Canvas,
    hu: Vec<f32>,
    organs: Organs,
    /// Of the image drawn last, where a pose placed it.
    plane: Option<SlicePlane>,
    /// Of a surface view.
    surface: Option<Overview>,
    /// Where somebody asked to see it from.
    turned: Option<SlicePlane>,
    /// The scene's field, mm, and window, where nobody chose others.
    scenes: (f64, WindowLevel),
}

/// What to draw.
#[derive(Debug, Clone, Copy)]
pub struct Rendered<'a> {
    /// The volume.
    pub volume: VolumeView<'a>,
    /// The first digits of its hash, to stand on the image.
    pub volume_name: &'a str,
    /// What every image of it must say.
    pub marks: Marks,
    /// The pose that places the plane: the present one, or the last one when there is none now; `None` draws no slice.
    pub pose: Option<Rigid<Ct, Tool>>,
    /// How good it is; `None` says nothing of it.
    pub accuracy: Option<Accuracy>,
    /// What the image claims.
    pub notice: Notice,
    /// Where its pose comes from.
    pub origin: Origin,
    /// What a person must be told besides.
    pub remarks: &'a [&'a str],
    /// The target that a person chose; `None`: none.
    pub chosen: Option<&'a Chosen>,
    /// Sequence number of the pose, or of the sample that had none.
    pub seq: u64,
    /// The registration.
    pub registration_id: u64,
    /// What is shown of the tissue.
    pub tissue: Tissues<'a>,
}

/// Why an image was not drawn.
#[derive(Debug, thiserror::Error)]
pub enum RenderError {
    /// Its plane is unusable, see [`view::plane`].
    #[error("placing an image: {0}")]
    Plane(#[from] PlaneError),
    /// Organs were not drawn.
    #[error("drawing organs that have moved: {0}")]
    Organs(#[from] NoWarp),
    /// The plane as the organs' model has it.
    #[error("placing an image in the model of the organs: {0}")]
    Model(#[from] DoorError),
    /// The volume was not sampled.
    #[error("sampling the volume: {0}")]
    Reslice(#[from] ResliceError),
}

impl Notice {
    /// What the frame's header says of it.
    pub fn state(self) -> FrameState {
        match self {
            Self::Live => FrameState::Live,
            Self::Requested => FrameState::Requested,
            Self::Look => FrameState::Look,
            Self::Stale(_) => FrameState::Stale,
            Self::Lost(reason, _) => FrameState::Lost(reason),
        }
    }
}

impl Renderer {
    /// A renderer of `view`.
    pub fn new(view: View) -> Self {
        let [width, height] = view.size;
        Self {
            canvas: Canvas::new(width, height),
            hu: match view.plane {
                Plane::Surface => Vec::new(),
                _ => vec![0.0; width as usize * height as usize],
            },
            organs: Organs::default(),
            plane: None,
            surface: (view.plane == Plane::Surface).then(|| Overview::new(view.size)),
            turned: None,
            scenes: (view.field_mm, view.window),
            view,
        }
    }

    /// The view.
    pub fn view(&self) -> &View {
        &self.view
    }

    /// From now on images look like this: the window of all, the field of local ones; where nothing is chosen as the scene says.
    pub fn show(&mut self, images: &Images) {
        let (field_mm, window) = self.scenes;
        // Surfaces have no window, and the field of their own that their camera has.
        if self.surface.is_some() {
            return;
        }
        self.view.window = images.window.unwrap_or(window);
        if self.view.extent == Extent::Local {
            self.view.field_mm = images.field_mm.unwrap_or(field_mm);
        }
    }

    /// The image drawn last.
    pub fn canvas(&self) -> &Canvas {
        &self.canvas
    }

    /// Has a surface view show this anatomy.
    pub fn show_anatomy(&mut self, anatomy: Arc<Anatomy>) {
        if let Some(surface) = &mut self.surface {
            surface.show(anatomy);
        }
    }

    /// Has a surface view see the patient along `camera`, `None`: as the scene says; held images are always as the scene says.
    pub fn turn(&mut self, camera: Option<SlicePlane>) {
        self.turned = camera;
    }

    /// The plane of the image drawn last; `None` where no pose placed it, and of a surface, on which nothing is measured.
    pub fn plane(&self) -> Option<&SlicePlane> {
        self.plane.as_ref()
    }

    /// The HU of the slice drawn last, row by row; none of a surface.
    pub fn hu(&self) -> &[f32] {
        &self.hu
    }

    /// Pixels of the image drawn last that two places of organs claim: there the model has folded, or one organ lies in another.
    pub fn covered_twice(&self) -> usize {
        self.organs.covered_twice()
    }

    /// Draws an image; returns its plane.
    ///
    /// # Errors
    /// Each variant of [`RenderError`].
    pub fn render(
        &mut self,
        what: &Rendered<'_>,
        scene: &Scene,
        resampler: &mut dyn Resampler,
    ) -> Result<SlicePlane, RenderError> {
        let placed = what.pose.unwrap_or_else(Rigid::identity);
        let plane = match self.turned.filter(|_| what.notice != Notice::Requested) {
            Some(turned) => turned,
            None => view::plane(&self.view, what.volume.grid, &placed)?,
        };
        self.paint(what, &plane, scene, resampler)?;
        self.plane = what.pose.filter(|_| self.surface.is_none()).map(|_| plane);
        Ok(plane)
    }

    /// Draws the image of `plane` in this window of HU, whatever the tool does: `what` has no pose, and [`Notice::Look`] for its notice.
    ///
    /// # Errors
    /// [`RenderError::Reslice`].
    pub fn look(
        &mut self,
        what: &Rendered<'_>,
        (plane, window): (SlicePlane, WindowLevel),
        scene: &Scene,
        resampler: &mut dyn Resampler,
    ) -> Result<(), RenderError> {
        // Neither the window nor the distance in front of the tip is the view's own.
        let own = (self.view.window, self.view.ahead_mm);
        (self.view.window, self.view.ahead_mm) = (window, 0.0);
        let painted = self.paint(what, &plane, scene, resampler);
        (self.view.window, self.view.ahead_mm) = own;
        painted?;
        self.plane = Some(plane);
        Ok(())
    }

    fn paint(
        &mut self,
        what: &Rendered<'_>,
        plane: &SlicePlane,
        scene: &Scene,
        resampler: &mut dyn Resampler,
    ) -> Result<(), RenderError> {
        let lost = matches!(what.notice, Notice::Lost(..));
        let pose = what.pose.filter(|_| !lost);
        match &mut self.surface {
            Some(surface) => {
                let things = Things {
                    scene,
                    grid: what.volume.grid,
                    pose,
                    chosen: what.chosen,
                };
                surface.draw(&mut self.canvas, plane, &things);
            }
            None => self.cut(what, plane, resampler)?,
        }
        let is_late = what.tissue.shown == TissueShown::Late && what.tissue.late_ns.is_some();
        if lost {
            self.canvas.dim(DIMMED);
        } else if is_late {
            self.canvas.dim(LATE);
        }
        let overlay = Overlay {
            view: &self.view,
            plane,
            is_placed: self.surface.is_none() && is_cut(what),
            views: &scene.views,
            pose,
            // Asked of the grid itself, whatever the message says.
            outside: pose.is_some_and(|pose| !what.volume.grid.holds(tip(pose))),
            remarks: what.remarks,
            tool: &scene.tool,
            targets: &scene.targets,
            chosen: what.chosen,
            accuracy: what.accuracy.filter(|_| !lost),
            notice: what.notice,
            origin: what.origin,
            seq: what.seq,
            registration_id: what.registration_id,
            volume: what.volume_name,
            marks: what.marks,
            tissue: Tissues {
                covered_twice: self.organs.covered_twice(),
                ..what.tissue
            },
            caution: self.surface.as_ref().map_or(resampler.caution(), Overview::caution),
        };
        overlay.draw(&mut self.canvas);
        Ok(())
    }

    /// The slice itself, and what of it is outside.
    fn cut(
        &mut self,
        what: &Rendered<'_>,
        plane: &SlicePlane,
        resampler: &mut dyn Resampler,
    ) -> Result<(), RenderError> {
        let is_cut = is_cut(what);
        if is_cut {
            resampler.reslice(&what.volume, plane, &self.view.sampling, &mut self.hu)?;
            let sampled = (&what.volume, plane, self.view.sampling.filter);
            match &what.tissue.moved {
                Some(moved) => self.organs.put(moved, sampled, resampler, &mut self.hu)?,
                None => self.organs.clear(),
            }
        } else {
            self.organs.clear();
            self.hu.fill(f32::from(what.volume.padding_hu));
        }
        to_grey(self.view.window, &self.hu, self.canvas.rgba_mut());
        match is_cut {
            true => {
                let thickness_mm = self.view.sampling.slab.map_or(0.0, |slab| slab.thickness_mm);
                hatch(&mut self.canvas, plane, what.volume.grid, thickness_mm);
                self.organs.mark(&mut self.canvas);
            }
            false => hatch_all(&mut self.canvas),
        }
        Ok(())
    }
}

/// Whether a plane was asked for, or a pose places it.
fn is_cut(what: &Rendered<'_>) -> bool {
    what.pose.is_some() || what.notice == Notice::Look
}

fn tip(pose: Rigid<Ct, Tool>) -> Point<Ct> {
    pose * Point::<Tool>::new(0.0, 0.0, 0.0)
}
