//! What an image says of the tissue: MODEL and a double frame where organs are where a model has them, and why where they are not.

use bus::clock;
use bus::message::TissueShown;
use picture::{Canvas, Line, palette};

use super::Overlay;

/// The inner line of the double frame, from the image's rim, and how wide both are; pixels of 512.
const INSET: f64 = 11.0;
const LINE: f64 = 2.0;

impl Overlay<'_> {
    /// Whether organs are shown where a model has them.
    pub(super) fn shows_model(&self) -> bool {
        self.tissue.moved.is_some() && !self.is_surface()
    }

    /// Two lines around an image of a model: no colour of its own, so that it stays told apart by whoever sees none.
    pub(super) fn model_frame(&self, canvas: &mut Canvas) {
        if !self.shows_model() {
            return;
        }
        for inset in [0.5 * LINE, INSET] {
            self.inner_line(canvas, inset, Line::solid(palette::WORDS, (LINE * self.unit()) as f32));
        }
    }

    /// A line within the frame of a moving replay that has no room for words: what it would say of the tissue. The frame itself says that
    /// it is a replay.
    pub(super) fn wordless_frame(&self, canvas: &mut Canvas) {
        if !self.has_words() && self.is_moving_replay() && self.tissue_alarm().is_some() {
            // Two pixels: a thinner line has hardly its colour on so small an image.
            self.inner_line(canvas, INSET, Line::solid(palette::WARN, 2.0));
        }
    }

    /// A line around the image, so far from its rim, pixels of 512.
    fn inner_line(&self, canvas: &mut Canvas, inset: f64, line: Line) {
        let [width, height] = self.view.size.map(f64::from);
        let inset = inset * self.unit();
        let corners = [
            [inset, inset],
            [width - inset, inset],
            [width - inset, height - inset],
            [inset, height - inset],
            [inset, inset],
        ];
        canvas.polyline(&corners, line);
    }

    /// Whether a target that is drawn lies in an organ that is shown moved: it is where it was, and so is its distance.
    fn has_target_inside(&self) -> bool {
        let chosen = self.chosen.map(|chosen| chosen.centre);
        let mut places = self.targets.iter().map(|target| target.centre).chain(chosen);
        self.tissue
            .moved
            .is_some_and(|moved| places.any(|place| moved.holds(place)))
    }

    /// What a person must be told of the tissue.
    pub(super) fn tissue_alarm(&self) -> Option<String> {
        let is_known = self.tissue.shown != TissueShown::None;
        if self.is_surface() && is_known {
            return Some("ORGANS AT REST".to_owned());
        }
        Some(match self.tissue.shown {
            TissueShown::Settled if self.has_target_inside() => "TARGETS IN THE ORGAN ARE SHOWN AT REST".to_owned(),
            TissueShown::None | TissueShown::Settled => return None,
            TissueShown::Approximate => "MODEL NOT SETTLED, TARGETS AT REST".to_owned(),
            TissueShown::Late => match self.tissue.late_ns {
                Some(late) => format!("TISSUE LATE {:.0}\u{a0}ms: ORGANS AT REST", clock::ms(late)),
                None => "NO TISSUE OF THIS POSE: ORGANS AT REST".to_owned(),
            },
            TissueShown::CatchingUp => "TISSUE CATCHING UP: ORGANS AT REST".to_owned(),
            TissueShown::Refused => "TISSUE REFUSED: ORGANS AT REST".to_owned(),
            TissueShown::Rigid => "ORGANS AT REST".to_owned(),
        })
    }
}
