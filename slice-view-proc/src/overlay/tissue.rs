//! What an image says of the tissue: MODEL and a double frame where organs are where a model has them, and why where they are not.

use bus::clock;
use bus::message::{TargetShown, TissueShown};
use geometry::{Ct, Point, Tool};
use picture::{Canvas, Line, palette};

use super::Overlay;

/// The inner line of the double frame, from the image's rim, and how wide both are; pixels of 512.
const INSET: f64 = 11.0;
const LINE: f64 = 2.0;
/// Half the cross where a target is at rest, and the least way from there to where it is that is drawn, pixels of 512.
const CROSS: f64 = 4.0;
const LEAST_AWAY: f64 = 3.0;

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

    /// Where this image has a place: overviews have all at rest.
    pub(super) fn place(&self, at_rest: Point<Ct>) -> Point<Ct> {
        match self.shows_model() {
            true => self.tissue.place(at_rest),
            false => at_rest,
        }
    }

    /// The target that a person chose and the distance from the tip to its centre: where the model has it, and where it was planned, where an organ moves
    /// it. No other takes its place, however near.
    pub(super) fn chosen_words(&self) -> Option<String> {
        let (chosen, tip) = (self.chosen?, self.pose? * Point::<Tool>::new(0.0, 0.0, 0.0));
        let (name, (place, shown)) = (&chosen.name, self.tissue.target(chosen.centre));
        let [now, planned] = [place, chosen.centre].map(|place| place.distance(tip));
        Some(match shown {
            // In no organ of a state that is not settled it stays, to the bit.
            shown if shown.is_moved() && place != chosen.centre => {
                format!("{name} {now:.1} mm, AT REST {planned:.1} mm")
            }
            TargetShown::Beside => format!("{name} {planned:.1} mm, {}", shown.words()),
            // What else there is to say of the tissue stands on the image by itself.
            _ => format!("{name} {planned:.1} mm"),
        })
    }

    /// A small cross where a target is at rest, near the plane, and a thin line from there to where the model has it.
    pub(super) fn draw_places_at_rest(&self, canvas: &mut Canvas) {
        let listed = |centre: Point<Ct>| self.targets.iter().any(|target| target.centre == centre);
        let chosen = self
            .chosen
            .map(|chosen| chosen.centre)
            .filter(|centre| !listed(*centre));
        for at_rest in self.targets.iter().map(|target| target.centre).chain(chosen) {
            let (from, to) = (self.circle(at_rest, 0.0), self.circle(self.place(at_rest), 0.0));
            let away = (to.at[0] - from.at[0]).hypot(to.at[1] - from.at[1]);
            // Nearer the cross would fill the circle about the moved place.
            if away < LEAST_AWAY * self.unit() || !self.is_seen(&from) {
                continue;
            }
            let ([x, y], r) = (from.at, CROSS * self.unit());
            let line = self.line(palette::TARGET, 1.0, false);
            canvas.line([x - r, y - r], [x + r, y + r], line);
            canvas.line([x - r, y + r], [x + r, y - r], line);
            // Over other anatomy than the target's a line would mislead.
            if self.is_seen(&to) {
                canvas.line(from.at, to.at, line);
            }
        }
    }

    /// What a person must be told of the tissue.
    pub(super) fn tissue_alarm(&self) -> Option<String> {
        let is_known = self.tissue.shown != TissueShown::None;
        if self.is_surface() && is_known {
            return Some("ORGANS AT REST".to_owned());
        }
        Some(match self.tissue.shown {
            TissueShown::None | TissueShown::Settled => return None,
            TissueShown::Approximate => "MODEL NOT SETTLED".to_owned(),
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
