//! What an image says of the tissue: MODEL and a double frame where organs are where a model has them, and why where they are not.

use bus::clock;
use bus::message::{TargetShown, TissueShown};
use geometry::{Ct, Point, Tool};
use picture::{Canvas, Line, palette};

use super::Overlay;
use crate::accuracy::ellipse_95;

/// The inner line of the double frame, from the image's rim, and how wide both are; pixels of 512.
const INSET: f64 = 11.0;
const LINE: f64 = 2.0;
/// Half the cross where a target is at rest, and the least way from there to where it is that is drawn, pixels of 512.
const CROSS: f64 = 4.0;
const LEAST_AWAY: f64 = 3.0;
/// Between the two lines of a model's ellipse where it is longest, pixels of 512.
const BETWEEN: f64 = 4.0;
/// A target that a model has moved by less than this has no word of it beside its name, mm.
const LEAST_MOVED_MM: f64 = 0.5;

/// `\u{b1}0.0 mm` would say that there is no error.
fn plus_minus(mm: f64) -> String {
    match mm {
        mm if mm < 0.05 => "< 0.1 mm".to_owned(),
        mm if mm >= 9.95 => format!("\u{b1}{mm:.0} mm"),
        mm => format!("\u{b1}{mm:.1} mm"),
    }
}

/// How much older than the pose what is told is.
fn age(age_ns: i64) -> String {
    match age_ns {
        0 => String::new(),
        age_ns => format!(", {:.0} ms AGO", clock::ms(age_ns)),
    }
}

/// Of an image in which two places claim so many pixels.
pub(crate) fn covered_twice(pixels: usize) -> String {
    format!("TISSUE COVERED TWICE: {pixels} px")
}

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
        let is_told = self.tissue_alarm().or(self.covered_twice_words()).is_some();
        if !self.has_words() && self.is_moving_replay() && is_told {
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

    /// What uncertain numbers of the model leave of the chosen target's place, where the model has it elsewhere than planned.
    pub(super) fn model_error_words(&self) -> Option<String> {
        let chosen = self.chosen.filter(|_| self.pose.is_some())?;
        let (place, shown) = self.tissue.target(chosen.centre);
        let is_moved = shown.is_moved() && place != chosen.centre;
        is_moved.then(|| match self.tissue.known(chosen.centre) {
            Some(known) => format!("MODEL {} (95 %){}", plus_minus(known.radius_95_mm), age(known.age_ns)),
            None => "MODEL ERROR UNKNOWN".to_owned(),
        })
    }

    /// The same of any target, beside how far it was moved.
    pub(super) fn moved_words(&self, planned: Point<Ct>) -> Option<String> {
        let moved_mm = self.place(planned).distance(planned);
        (moved_mm >= LEAST_MOVED_MM).then(|| {
            let known = self.tissue.known(planned);
            let error = known.map_or("\u{b1}UNKNOWN".to_owned(), |known| plus_minus(known.radius_95_mm));
            format!(", MOVED {moved_mm:.1} mm {error}")
        })
    }

    /// The model's 95 % ellipse about each target that it has moved, near the plane: two lines, as the frame of a model's image has. Where it is not
    /// known there is none, and words say so.
    pub(super) fn draw_model_errors(&self, canvas: &mut Canvas) {
        for planned in self.targets_and_chosen() {
            let (place, shown) = self.tissue.target(planned);
            let circle = self.circle(place, 0.0);
            let known = self.tissue.known(planned);
            let Some(known) = known.filter(|_| self.shows_model() && shown.is_moved() && self.is_seen(&circle)) else {
                continue;
            };
            let line = self.line(palette::TARGET, 1.0, false);
            let Some(ellipse) = ellipse_95(&known.covariance_mm2, self.plane, circle.at) else {
                continue;
            };
            // The outer line is the ellipse itself; the other, inside it, says whose it is.
            let [x, y] = circle.at;
            let reach = ellipse
                .iter()
                .map(|at| (at[0] - x).hypot(at[1] - y))
                .fold(0.0, f64::max);
            let part = 1.0 - BETWEEN * self.unit() / reach;
            let inner: Vec<[f64; 2]> = ellipse
                .iter()
                .map(|at| [x + part * (at[0] - x), y + part * (at[1] - y)])
                .collect();
            // Where two lines would run together one has to do. The ellipse itself last: nothing lies over it.
            if reach > 3.0 * BETWEEN * self.unit() {
                canvas.polyline(&inner, line);
            }
            canvas.polyline(&ellipse, line);
        }
    }

    /// The places at rest of the targets, and of the one that was chosen where that is none of these.
    fn targets_and_chosen(&self) -> impl Iterator<Item = Point<Ct>> {
        let listed = |centre: Point<Ct>| self.targets.iter().any(|target| target.centre == centre);
        let chosen = self.chosen.map(|chosen| chosen.centre);
        let chosen = chosen.filter(|centre| !listed(*centre));
        self.targets.iter().map(|target| target.centre).chain(chosen)
    }

    /// A small cross where a target is at rest, near the plane, and a thin line from there to where the model has it.
    pub(super) fn draw_places_at_rest(&self, canvas: &mut Canvas) {
        for at_rest in self.targets_and_chosen() {
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

    /// Where the model has folded, of a settled state too: its certificate is of the elements, and not of the small cubes that are drawn.
    pub(super) fn covered_twice_words(&self) -> Option<String> {
        let pixels = self.tissue.covered_twice;
        (pixels > 0).then(|| covered_twice(pixels))
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
