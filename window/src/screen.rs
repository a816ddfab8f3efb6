//! The screen: from a [`Model`] to shapes, and from touches and keys to what a person wishes.

mod bar;
mod button;
mod buttons;
mod cell;
mod images;
pub(crate) mod lines;
mod replay;
mod sight;
mod step_buttons;
mod steps;
pub(crate) mod tree;
mod views;
pub mod words;

use std::sync::Arc;

use bus::message::StepWish;
use egui::{Context, FontData, FontDefinitions, FontFamily, TextureId, Ui};

use crate::colours;
use crate::model::{Cell, Model, Tone};
use crate::sizes::{Screen, Sizes, smallest};
pub(crate) use bar::Band;
pub use bar::Shown;
pub(crate) use buttons::touched;
pub(crate) use cell::HU_PX;
pub use images::ImagesKey;
pub use sight::Dial;
pub use views::Views;
use words::Words;

/// What a person wishes, by a key, a button or a touch.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Wish {
    /// Aim at the next target of the scene, or at the one before.
    NextTarget {
        /// Forwards.
        is_forward: bool,
    },
    /// Show images in another window or field.
    Images(ImagesKey),
    /// Show images in a window that is so much wider, and whose centre is so much higher.
    Level {
        /// HU.
        wider_hu: i32,
        /// HU.
        up_hu: i32,
    },
    /// Turn the overview of this view, with what is near the viewer by so many pixels.
    Turn {
        /// Index in the scene's list.
        view: usize,
        /// To the right.
        right_px: i32,
        /// Downwards.
        down_px: i32,
    },
    /// Show the overview of this view as the scene says again.
    TurnBack(usize),
    /// Note this moment in the recording.
    Mark,
    /// A picture of the screen as a file.
    Shot,
    /// Hold what is shown, or follow again.
    Hold,
    /// Enlarge the image of this view, or show all again.
    Enlarge(Option<usize>),
    /// Show these images.
    Views(Views),
    /// Show the screen of steps, or the images.
    Steps(bool),
    /// Calibration, registration, check: something of the calibrator.
    Step(StepWish),
    /// The next touch is of the next point, or of the one before.
    NextPoint {
        /// Forwards.
        is_forward: bool,
    },
    /// The examination shown is the patient's.
    Confirm,
    /// It is not.
    Reject,
    /// Start the navigation, or end it.
    Navigate,
    /// The marker on the patient was moved.
    Moved,
    /// Start the localizer anew, so that it dials: what its peer kept back is gone then, and a clock that was set back is known.
    RestartLocalizer,
    /// A replay: stand still, or go on.
    Pause,
    /// A replay: one pose on.
    OnePose,
    /// A replay: the pose before.
    PoseBefore,
    /// A replay: so many seconds on, or back.
    Skip(i32),
    /// A replay: this moment, ns on the clock of the run that was recorded.
    Seek(i64),
    /// A replay: the next mark, or the one before.
    NextMark {
        /// Forwards.
        is_forward: bool,
    },
    /// A replay: faster, or slower.
    Speed {
        /// Faster.
        is_faster: bool,
    },
    /// A replay: stand still, and what is shown as files.
    Moment,
}

/// What this screen shows of the model: kept in a file, as a window that comes back shows the same.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Look {
    /// The view whose image fills the screen.
    pub enlarged: Option<usize>,
    /// Which images are shown where none is enlarged.
    pub views: Views,
    /// The steps of calibration, registration and check in the place of the images.
    pub steps: bool,
    /// The sight alone, for a second display.
    pub only_sight: bool,
    /// Why the last wish was refused; not kept.
    pub note: String,
    /// The note is of something that was done, and not of a refusal; not kept.
    pub is_done: bool,
}

/// What the painter has to know of one frame beside the shapes.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Outcome {
    /// What the person wished.
    pub wishes: Vec<Wish>,
    /// Every piece of text, with its room: for tests.
    pub words: Words,
    /// Where the coded cell is to be painted, pixels; nothing else lies there. The sight alone has none.
    pub code: Option<egui::Rect>,
}

/// The font of the screen: that of the images, whose letters are all equally wide, so that digits stay where they are.
pub fn fonts() -> FontDefinitions {
    let mut fonts = FontDefinitions::empty();
    let hack = FontData::from_static(epaint_default_fonts::HACK_REGULAR);
    fonts.font_data.insert("Hack".to_owned(), Arc::new(hack));
    for family in [FontFamily::Proportional, FontFamily::Monospace] {
        fonts.families.insert(family, vec!["Hack".to_owned()]);
    }
    fonts
}

/// A context without animations, so that a frame is a function of the model and of what was touched.
pub fn context() -> Context {
    let context = Context::default();
    set_up(&context);
    context
}

fn set_up(context: &Context) {
    context.set_fonts(fonts());
    context.all_styles_mut(|style| {
        style.animation_time = 0.0;
        style.interaction.selectable_labels = false;
        style.visuals.panel_fill = colours::GROUND;
    });
}

/// The texture of a view's image.
pub const fn texture(view: usize) -> TextureId {
    TextureId::User(view as u64)
}

/// Lays the screen out. `ui` covers it all, in pixels.
pub fn show(ui: &mut Ui, model: &Model, screen: Screen, look: &Look) -> Outcome {
    let mut outcome = Outcome::default();
    let steps = model.steps.as_ref().filter(|_| look.steps && !look.only_sight);
    let shown = match look.only_sight {
        true => Vec::new(),
        false => look.views.of(&model.cells),
    };
    let images = shown.len();
    let has_bar = model.replay.is_some() && !look.only_sight;
    let Some(sizes) = Sizes::with_bar(screen, images, has_bar) else {
        words::too_small(ui, screen, smallest(images), &mut outcome.words);
        return outcome;
    };
    let room = {
        let tone = if look.is_done { Tone::Quiet } else { Tone::Warning };
        let (sizes, note) = (&sizes, (look.note.as_str(), tone));
        Band { model, sizes, note }.show(ui, &mut outcome.words)
    };
    // Its watcher takes one window of a run for the run's: the sight alone is not to be taken for the window with the images.
    outcome.code = (!look.only_sight).then_some(room);
    match steps {
        Some(steps) => steps::show(ui, steps, &sizes, &mut outcome),
        None => cells((ui, model, &shown), &sizes, look, &mut outcome),
    }
    replay::show(ui, model, &sizes, &mut outcome);
    buttons::show(ui, model, &sizes, look, &mut outcome);
    if steps.is_none() {
        images::keys(ui, &mut outcome);
    }
    outcome
}

fn cells((ui, model, shown): (&mut Ui, &Model, &[&Cell]), sizes: &Sizes, look: &Look, outcome: &mut Outcome) {
    let enlarged = look
        .enlarged
        .and_then(|view| model.cells.iter().find(|cell| cell.view == view));
    if let (Some(cell), false) = (enlarged, look.only_sight) {
        let [image, sight] = enlarged_rects(sizes);
        cell::show(ui, cell, image, sizes, outcome);
        sight::show(ui, model, sight, sizes, &mut outcome.words);
        return;
    }
    sight::show(ui, model, sizes.cells[sizes.sight], sizes, &mut outcome.words);
    let rects = sizes.cells.iter().enumerate().filter(|(k, _)| *k != sizes.sight);
    for (cell, (_, rect)) in shown.iter().zip(rects) {
        cell::show(ui, cell, *rect, sizes, outcome);
    }
}

/// One image as large as it goes, with the sight beside it.
fn enlarged_rects(sizes: &Sizes) -> [egui::Rect; 2] {
    let bottom = sizes.bar.map_or(sizes.foot.top(), |bar| bar.top());
    let top = sizes.top.bottom();
    let least = sizes.cells[sizes.sight].width();
    let side = (bottom - top).min(sizes.top.width() - least);
    let image = egui::Rect::from_min_size(egui::pos2(0.0, top), egui::Vec2::splat(side));
    let left = egui::vec2(sizes.top.width() - side, bottom - top);
    let beside = egui::Rect::from_min_size(egui::pos2(side, top), egui::Vec2::splat(left.min_elem()));
    [image, beside]
}

#[cfg(test)]
pub(crate) mod tests;
