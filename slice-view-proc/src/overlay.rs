//! What is drawn over the slice: tube, tip, targets, letters, scale, words.

use bus::clock;
use bus::message::{Lost, Marks};
use bus::scene::{Extent, SlabMode, Target, ToolSpec, View};
use geometry::{Ct, Point, Rigid, SlicePlane, Tool};
use picture::{Anchor, Canvas, Line, Rgb};

use crate::accuracy::Accuracy;
use crate::letters::letters;

const TUBE: Rgb = Rgb(80, 200, 255);
const TIP: Rgb = Rgb(255, 230, 60);
const TARGET: Rgb = Rgb(90, 255, 120);
const WORDS: Rgb = Rgb(235, 235, 235);
const QUIET: Rgb = Rgb(165, 175, 190);
const WARN: Rgb = Rgb(255, 180, 0);
const ALARM: Rgb = Rgb(255, 60, 60);
/// Of replays, and of nothing else.
const REPLAY: Rgb = Rgb(220, 120, 255);

/// Targets further than this from the plane are not drawn, mm: an outline over other anatomy would mislead.
const NEAR_PLANE_MM: f64 = 10.0;

/// What the image claims about the present.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Notice {
    /// The pose is young.
    Live,
    /// The pose was asked for and not just measured.
    Held,
    /// The pose is this old, ns.
    Stale(i64),
    /// There is no pose; the slice shown, if any, is of a pose this old, ns.
    Lost(Lost, Option<i64>),
}

/// Where poses come from, as far as images must say it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Origin {
    /// The tracker, now.
    Tracker,
    /// A recording, made in the examination that is shown.
    Recording,
    /// A recording made in another examination: tube and anatomy do not belong together.
    RecordingOfAnother,
    /// A recording that does not say in which examination it was made.
    RecordingOfUnknown,
    /// The tracker, in simulated time: not the present.
    SimulatedTime,
}

impl Origin {
    /// As stamps say it.
    pub const fn code(self) -> u32 {
        match self {
            Self::Tracker => 0,
            Self::Recording | Self::RecordingOfAnother | Self::RecordingOfUnknown => 1,
            Self::SimulatedTime => 2,
        }
    }

    /// What whatever moves says in the place of LIVE.
    fn word(self) -> &'static str {
        match self {
            Self::Tracker => "LIVE",
            Self::Recording | Self::RecordingOfAnother | Self::RecordingOfUnknown => "REPLAY",
            Self::SimulatedTime => "SIMULATED TIME",
        }
    }

    /// What every image says, also a held one.
    fn warning(self) -> &'static str {
        match self {
            Self::Tracker | Self::Recording | Self::SimulatedTime => "",
            Self::RecordingOfAnother => "NOT THE EXAMINATION OF THE RECORDING",
            Self::RecordingOfUnknown => "EXAMINATION NOT VERIFIED",
        }
    }
}

/// Everything that is drawn over one slice.
#[derive(Debug, Clone, Copy)]
pub struct Overlay<'a> {
    /// The image.
    pub view: &'a View,
    /// Its plane.
    pub plane: &'a SlicePlane,
    /// The tool, drawn where there is a valid pose.
    pub pose: Option<Rigid<Ct, Tool>>,
    /// How good that pose is; `None` says nothing of it.
    pub accuracy: Option<Accuracy>,
    /// Its shape.
    pub tool: &'a ToolSpec,
    /// The targets.
    pub targets: &'a [Target],
    /// What the image claims.
    pub notice: Notice,
    /// Where the pose comes from.
    pub origin: Origin,
    /// Sequence number of the pose.
    pub seq: u64,
    /// The registration.
    pub registration_id: u64,
    /// First bytes of the volume's hash, as hex.
    pub volume: &'a str,
    /// What every image of it must say.
    pub marks: Marks,
    /// What the back end that sampled it has to say, see [`Resampler::caution`](crate::reslice::Resampler::caution).
    pub caution: &'a str,
}

impl Overlay<'_> {
    /// Draws it all.
    pub fn draw(&self, canvas: &mut Canvas) {
        self.targets(canvas);
        if let Some(pose) = self.pose {
            self.tube(canvas, pose);
        }
        self.letters(canvas);
        self.scale_bar(canvas);
        self.words(canvas);
        self.replay(canvas);
        self.notice(canvas);
    }

    /// Sizes are meant for 512 pixels and follow the image.
    fn unit(&self) -> f64 {
        let shorter = self.view.size[0].min(self.view.size[1]);
        (f64::from(shorter) / 512.0).clamp(0.4, 3.0)
    }

    fn text(&self, canvas: &mut Canvas, at: [f64; 2], text: &str, size: f64, colour: Rgb, anchor: Anchor) {
        canvas.text(at, text, (size * self.unit()) as f32, colour, anchor);
    }

    fn line(&self, colour: Rgb, width: f64, dashed: bool) -> Line {
        Line {
            colour,
            width: (width * self.unit()) as f32,
            dashed,
        }
    }

    /// The tube's axis from the tip to the handle: dashed where the handle lies behind the plane by more than the tube's
    /// radius, else solid (in front, or cut by the plane). The tip; and where the tube is seen along its axis, its outline.
    fn tube(&self, canvas: &mut Canvas, pose: Rigid<Ct, Tool>) {
        let tip = self.plane.project(pose * Point::<Tool>::new(0.0, 0.0, 0.0));
        let handle = self
            .plane
            .project(pose * Point::<Tool>::new(0.0, 0.0, -self.tool.length_mm));
        let (tip_px, handle_px) = ([tip.x, tip.y], [handle.x, handle.y]);
        let behind = handle.depth_mm > self.tool.diameter_mm / 2.0;
        let projected = (tip_px[0] - handle_px[0]).hypot(tip_px[1] - handle_px[1]);
        let radius_px = self.tool.diameter_mm / 2.0 / self.plane.pixel_mm();
        // Along the axis the line is a point: the outline says more.
        if projected > radius_px {
            canvas.line(handle_px, tip_px, self.line(TUBE, 2.0, behind));
        } else {
            canvas.circle(tip_px, radius_px, self.line(TUBE, 1.5, false));
        }
        let error = self.error_at_tip(tip_px);
        if let Some(error) = &error {
            canvas.polyline(error, self.line(TIP, 1.2, false));
        }
        // Outside the ellipse, which it would fill.
        let reach = |p: &[f64; 2]| (p[0] - tip_px[0]).hypot(p[1] - tip_px[1]);
        let widest = error.iter().flatten().map(reach).fold(0.0, f64::max);
        let gap = (3.0 * self.unit()).max(widest + 1.5 * self.unit());
        let arm = gap + 6.0 * self.unit();
        for [dx, dy] in [[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]] {
            let from = [tip.x + dx * gap, tip.y + dy * gap];
            let to = [tip.x + dx * arm, tip.y + dy * arm];
            canvas.line(from, to, self.line(TIP, 1.5, false));
        }
    }

    /// The 95 % ellipse about the tip, on images that show the tip enlarged.
    fn error_at_tip(&self, tip: [f64; 2]) -> Option<Vec<[f64; 2]>> {
        match self.view.extent {
            Extent::Local => self.accuracy?.ellipse(self.plane, tip),
            Extent::Global => None,
        }
    }

    /// Each target near the plane: its cut where the plane meets it, else its outline, dashed, with its distance from
    /// the plane.
    fn targets(&self, canvas: &mut Canvas) {
        for target in self.targets {
            let at = self.plane.project(target.centre);
            if at.depth_mm.abs() > NEAR_PLANE_MM {
                continue;
            }
            let radius = target.diameter_mm / 2.0;
            let cut_sq = radius * radius - at.depth_mm * at.depth_mm;
            let cut = cut_sq > 0.0;
            let radius_px = (if cut { cut_sq.sqrt() } else { radius } / self.plane.pixel_mm()).max(3.0 * self.unit());
            canvas.circle([at.x, at.y], radius_px, self.line(TARGET, 1.5, !cut));
            if self.view.extent == Extent::Local {
                let label = match cut {
                    true => target.name.clone(),
                    false => format!("{} {:+.0} mm", target.name, at.depth_mm),
                };
                // Above the circle's right: the tube comes from the side or from below more often than from there.
                let beside = [at.x + radius_px, at.y - radius_px - 6.0 * self.unit()];
                self.text(canvas, beside, &label, 12.0, TARGET, Anchor::Left);
            }
        }
    }

    fn letters(&self, canvas: &mut Canvas) {
        let (w, h) = (f64::from(canvas.width()), f64::from(canvas.height()));
        let inset = 14.0 * self.unit();
        let (right, down) = (self.plane.right(), self.plane.down());
        let sides = [
            ([inset, h / 2.0], -right, Anchor::Left),
            ([w - inset, h / 2.0], right, Anchor::Right),
            ([w / 2.0, inset], -down, Anchor::Centre),
            ([w / 2.0, h - inset], down, Anchor::Centre),
        ];
        for (at, direction, anchor) in sides {
            self.text(canvas, at, &letters(direction), 20.0, WORDS, anchor);
        }
    }

    /// A bar of a round length, about a quarter of the width.
    fn scale_bar(&self, canvas: &mut Canvas) {
        let mm = round_length(f64::from(canvas.width()) * self.plane.pixel_mm() / 4.0);
        let (u, h) = (self.unit(), f64::from(canvas.height()));
        let (x0, y) = (14.0 * u, h - 16.0 * u);
        let x1 = x0 + mm / self.plane.pixel_mm();
        for (colour, width) in [(Rgb(0, 0, 0), 4.0), (WORDS, 1.8)] {
            let line = self.line(colour, width, false);
            canvas.line([x0, y], [x1, y], line);
            canvas.line([x0, y - 4.0 * u], [x0, y + 4.0 * u], line);
            canvas.line([x1, y - 4.0 * u], [x1, y + 4.0 * u], line);
        }
        self.text(
            canvas,
            [x0, y - 14.0 * u],
            &format!("{mm} mm"),
            13.0,
            WORDS,
            Anchor::Left,
        );
    }

    fn words(&self, canvas: &mut Canvas) {
        let (w, h, u) = (f64::from(canvas.width()), f64::from(canvas.height()), self.unit());
        let (left, right, first, step) = (12.0 * u, w - 12.0 * u, 15.0 * u, 17.0 * u);
        let extent = match self.view.extent {
            Extent::Global => "global",
            Extent::Local => "local",
        };
        let title = format!("{} {extent}", self.view.plane.name().to_uppercase());
        self.text(canvas, [left, first], &title, 15.0, WORDS, Anchor::Left);
        let window = &self.view.window;
        let window = format!("W {} C {}", window.width_hu, window.centre_hu);
        self.text(canvas, [left, first + step], &window, 12.0, QUIET, Anchor::Left);
        if let Some(words) = unusual(self.view) {
            self.text(canvas, [left, first + 2.0 * step], &words, 12.0, WORDS, Anchor::Left);
        }
        // Not at the top, where a banner may hide them.
        let warning = self.origin.warning();
        let lines = [
            (1.0, self.marks.words(), WARN),
            (2.0, self.caution.to_owned(), WARN),
            (3.0, warning.to_owned(), ALARM),
        ];
        for (line, words, colour) in lines {
            let at = [right, h - 16.0 * u - line * step];
            self.text(canvas, at, &words, 13.0, colour, Anchor::Right);
        }
        let ids = format!("vol {} reg {:08x}", self.volume, self.registration_id >> 32);
        self.text(canvas, [right, first + step], &ids, 12.0, QUIET, Anchor::Right);
        if let Some(accuracy) = &self.accuracy {
            let at = [right, first + 2.0 * step];
            self.text(canvas, at, &accuracy.words(), 13.0, TIP, Anchor::Right);
            if let Some(words) = accuracy.delay_words() {
                // Above the scale bar and its length.
                self.text(canvas, [left, h - 52.0 * u], &words, 13.0, WARN, Anchor::Left);
            }
        }
        if let Some((target, mm)) = self.nearest_target() {
            let text = format!("{target} {mm:.1} mm");
            self.text(canvas, [right, h - 16.0 * u], &text, 13.0, TARGET, Anchor::Right);
        }
    }

    /// The target nearest to the tip and the distance from the tip to its centre, mm.
    fn nearest_target(&self) -> Option<(&str, f64)> {
        let tip = self.pose? * Point::<Tool>::new(0.0, 0.0, 0.0);
        self.targets
            .iter()
            .map(|t| (t.name.as_str(), t.centre.distance(tip)))
            .min_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// Whatever moves in a replay says so, so that nobody takes it for the present: a frame and a word in a colour that
    /// nothing else has. A held image claims nothing of the present, and is the same bytes as in the run that was recorded.
    fn replay(&self, canvas: &mut Canvas) {
        if self.origin == Origin::Tracker || self.notice == Notice::Held {
            return;
        }
        let (w, u) = (f64::from(canvas.width()), self.unit());
        canvas.border(REPLAY, 5.0 * u);
        let word = self.origin.word();
        self.text(canvas, [w / 2.0, 44.0 * u], word, 24.0, REPLAY, Anchor::Centre);
    }

    fn notice(&self, canvas: &mut Canvas) {
        if self.accuracy.is_some_and(|accuracy| accuracy.outside()) {
            // Below where a banner may be.
            self.band(canvas, 98.0, "TIP OUTSIDE THE CT", WARN);
        }
        let (w, u) = (f64::from(canvas.width()), self.unit());
        let corner = [w - 12.0 * u, 15.0 * u];
        let seq = self.seq;
        match self.notice {
            Notice::Live if self.origin != Origin::Tracker => {
                self.text(
                    canvas,
                    corner,
                    &format!("{} seq {seq}", self.origin.word()),
                    13.0,
                    REPLAY,
                    Anchor::Right,
                );
            }
            Notice::Live => self.text(canvas, corner, &format!("LIVE seq {seq}"), 13.0, TARGET, Anchor::Right),
            Notice::Held => self.text(canvas, corner, &format!("HELD seq {seq}"), 13.0, WORDS, Anchor::Right),
            Notice::Stale(age) => {
                self.text(canvas, corner, &format!("seq {seq}"), 13.0, WARN, Anchor::Right);
                self.banner(canvas, &format!("POSE {} OLD", age_words(age)), WARN);
            }
            Notice::Lost(reason, age) => {
                self.text(canvas, corner, &format!("seq {seq}"), 13.0, ALARM, Anchor::Right);
                let age = age
                    .map(|age| format!(", image {} old", age_words(age)))
                    .unwrap_or_default();
                self.banner(canvas, &format!("NO POSE: {}{age}", reason.words()), ALARM);
            }
        }
    }

    /// Words that cannot be missed: a coloured frame and a dark band with the text.
    fn banner(&self, canvas: &mut Canvas, text: &str, colour: Rgb) {
        canvas.border(colour, 5.0 * self.unit());
        self.band(canvas, 62.0, text, colour);
    }

    /// A dark band with words, its upper side at `y` of 512.
    fn band(&self, canvas: &mut Canvas, y: f64, text: &str, colour: Rgb) {
        let (w, u) = (f64::from(canvas.width()), self.unit());
        canvas.fill([5.0 * u, y * u], [w - 10.0 * u, 34.0 * u], Rgb(0, 0, 0), 200);
        self.text(canvas, [w / 2.0, (y + 17.0) * u], text, 18.0, colour, Anchor::Centre);
    }
}

/// The largest of 1, 2, 5 x 10^n mm up to `mm`.
fn round_length(mm: f64) -> f64 {
    let power = 10_f64.powf(mm.log10().floor());
    let digit = mm / power;
    power
        * if digit >= 5.0 {
            5.0
        } else if digit >= 2.0 {
            2.0
        } else {
            1.0
        }
}

fn age_words(age_ns: i64) -> String {
    match clock::ms(age_ns) {
        ms if ms < 1000.0 => format!("{ms:.0} ms"),
        ms => format!("{:.1} s", ms / 1000.0),
    }
}

/// What makes the image other than the thin plane through the tip: it must be said, or it would be taken for that.
fn unusual(view: &View) -> Option<String> {
    let slab = view.sampling.slab.map(|slab| {
        let mode = match slab.mode {
            SlabMode::Mean => "MEAN",
            SlabMode::Maximum => "MAX",
            SlabMode::Minimum => "MIN",
        };
        format!("{mode} {} mm", slab.thickness_mm)
    });
    let ahead = (view.ahead_mm != 0.0).then(|| format!("{:+} mm AHEAD", view.ahead_mm));
    let words: Vec<String> = slab.into_iter().chain(ahead).collect();
    (!words.is_empty()).then(|| words.join(", "))
}

#[cfg(test)]
mod tests;
