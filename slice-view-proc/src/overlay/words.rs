//! What stands on an image in words, in the order of its importance, and where each may stand.

use bus::clock;
use bus::message::Marks;
use picture::{Anchor, Rgb, palette};
use scene::{Drawn, Extent, SlabMode, View};

use super::layout::{Caption, Layout, wrapped};
use super::ruler::place_words;
use super::shapes::Outline;
use super::{Notice, Origin, Overlay};
use geometry::letters;

/// The sides of the smallest image that gets words, pixels: below, letters large enough to be read have no room.
pub(crate) const SMALLEST_WITH_WORDS: u32 = 192;
/// The smallest scale of words: type of 12 then has 9 pixels.
const SMALLEST_UNIT: f64 = 0.75;
/// The first line of a corner, and from one line to the next.
const FIRST: f64 = 15.0;
const STEP: f64 = 17.0;
/// Of the words of alarms, usual and where there are many on a small image.
const ALARM_TYPES: [f64; 2] = [18.0, 13.0];
/// Down to this part of the image's height, alarms have the larger type.
const MOST_BANDS: f64 = 0.7;
/// How many lines of a corner are tried.
const LINES: usize = 9;

/// As wide as what it is replaced by: a scene has at most 64 targets, and an image fewer than 36 other words.
const REMARK_ROOM: &str = "88 LABELS LEFT OUT";

/// A dark band over the whole width, with words that cannot be missed.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Band {
    pub(super) top: f64,
    pub(super) height: f64,
}

/// A corner of the image, from which lines of words grow inwards.
#[derive(Debug, Clone, Copy)]
enum Corner {
    TopLeft,
    TopRight,
    BottomLeft,
    BottomRight,
}

/// All words of an image.
#[derive(Debug, Clone)]
pub(super) struct Words {
    pub(super) layout: Layout,
    pub(super) bands: Vec<Band>,
    /// Whether the scale bar has its number.
    pub(super) scale: bool,
    /// How many of those that say what the image claims, or how it lies, found no room.
    unsaid: usize,
}

/// Where words that were made larger have no room, these sizes are tried: what the image claims must stand on it.
const SMALLER: [f64; 5] = [3.0, 2.0, 1.5, 1.25, 1.0];

impl Overlay<'_> {
    /// The scale of words: sizes are meant for 512 pixels.
    fn word_unit(&self) -> f64 {
        self.unit().max(SMALLEST_UNIT) * self.view.text
    }

    /// Whether the image has room for words at all.
    pub(super) fn has_words(&self) -> bool {
        self.view.size.iter().all(|side| *side >= SMALLEST_WITH_WORDS)
    }

    /// The words in their places. Where some are left out, that itself stands on the image, in room kept for it: it must not
    /// push about what it counts.
    pub(super) fn words(&self) -> Words {
        let mut words = self.words_of_size();
        for text in SMALLER {
            if words.unsaid > 0 && text < self.view.text {
                let view = &View {
                    text,
                    ..self.view.clone()
                };
                words = Overlay { view, ..*self }.words_of_size();
            }
        }
        words
    }

    /// Whether the image says all that it can say by itself, or leaves what is no state to a window around it.
    fn says_all(&self) -> bool {
        self.view.overlay == Drawn::All
    }

    fn words_of_size(&self) -> Words {
        let mut words = self.arranged(false);
        if words.layout.left_out > 0 {
            words = self.arranged(true);
            let left_out = match self.is_surface() {
                true => "LABELS LEFT OUT".to_owned(),
                false => left_out_words(words.layout.left_out),
            };
            words.layout.fill(REMARK_ROOM, &left_out);
        }
        words
    }

    /// All words but how many are left out, with room for that where `counted`.
    fn arranged(&self, counted: bool) -> Words {
        let [width, height] = self.view.size;
        let mut layout = Layout::new(width, height);
        layout.place(self.replay_word());
        layout.place(self.model_word());
        let bands = self.bands(&mut layout);
        // A window around a surface has no plane to tell them by.
        let has_letters = self.says_all() || self.is_surface();
        for letter in self.letters().into_iter().filter(|_| has_letters) {
            layout.place(letter);
        }
        layout.place(self.force_word());
        // The state may stand on many lines; what comes before may not.
        let (state, colour) = self.state_words();
        let spots = [Corner::TopRight, Corner::BottomRight]
            .map(|corner| self.spots(corner))
            .concat();
        layout.place(self.caption(state, 13.0, colour, spots));
        let unsaid = layout.left_out;
        let scale = !self.is_surface() && self.scale_words(&mut layout);
        for caption in self.corners(counted) {
            layout.place(caption);
        }
        if let Some(pose) = self.pose {
            let [low, high] = self.about_the_tip(pose);
            layout.keep_free(low, high);
        }
        if self.view.extent == Extent::Local && self.says_all() && !self.is_surface() {
            for outline in self.outlines() {
                layout.place(self.label(&outline));
            }
        }
        // The dashes of a line say the same as its name: where this has no room, nothing is lost.
        for label in self.cut_labels().into_iter().filter(|_| self.says_all()) {
            layout.place_if_room(label);
        }
        let marks = self.marks.words();
        let unusual = unusual(self.view).unwrap_or_default();
        let others = [self.origin.warning(), self.caution, &marks, &unusual];
        let is_there = |text: &str| text.is_empty() || layout.placed.iter().any(|placed| placed.text == text);
        let unsaid = unsaid + others.iter().filter(|text| !is_there(text)).count();
        Words {
            layout,
            bands,
            scale,
            unsaid,
        }
    }

    fn caption(&self, text: impl Into<String>, size: f64, colour: Rgb, spots: Vec<([f64; 2], Anchor)>) -> Caption {
        Caption {
            text: text.into(),
            size: (size * self.word_unit()) as f32,
            colour,
            spots,
        }
    }

    /// Whatever moves in a replay says so.
    fn replay_word(&self) -> Caption {
        let word = if self.is_moving_replay() {
            self.origin.word()
        } else {
            ""
        };
        let at = [f64::from(self.view.size[0]) / 2.0, 44.0 * self.word_unit()];
        self.caption(word, 24.0, palette::REPLAY, vec![(at, Anchor::Centre)])
    }

    /// Organs are where a model has them.
    fn model_word(&self) -> Caption {
        let word = if self.shows_model() { "MODEL" } else { "" };
        let at = [0.5, 0.3, 0.7].map(|part| {
            let x = part * f64::from(self.view.size[0]);
            ([x, 44.0 * self.word_unit()], Anchor::Centre)
        });
        self.caption(word, 20.0, palette::WORDS, at.into())
    }

    /// What the moved organ does to the tube, by the model.
    fn force_word(&self) -> Caption {
        let force = self
            .tissue
            .force_n
            .filter(|(force, _)| self.shows_model() && force.is_finite());
        let word = force.map_or(String::new(), |(force, error)| {
            let error = error.map_or_else(|| "UNKNOWN".to_owned(), |error| format!("{error:.2}"));
            format!("{force:.2}\u{a0}N \u{b1}{error} (95\u{a0}%) ON THE TUBE")
        });
        let at = [0.5, 0.3, 0.7].map(|part| {
            let x = part * f64::from(self.view.size[0]);
            ([x, 64.0 * self.word_unit()], Anchor::Centre)
        });
        self.caption(word, 12.0, palette::WORDS, at.into())
    }

    /// Alarms, each in a band of its own, below one another; in smaller type where they would leave the letters no room.
    fn bands(&self, layout: &mut Layout) -> Vec<Band> {
        let [width, height] = self.view.size.map(f64::from);
        let leaves_room = |size| {
            let end = self.alarm_bands(size).last().map(|(band, ..)| band.top + band.height);
            end.is_none_or(|end| end <= MOST_BANDS * height)
        };
        let [large, small] = ALARM_TYPES;
        let size = if leaves_room(large) { large } else { small };
        let u = self.word_unit() * size / large;
        let mut bands = Vec::new();
        for (band, lines, colour) in self.alarm_bands(size) {
            for (k, line) in lines.into_iter().enumerate() {
                let at = [width / 2.0, band.top + (17.0 + 22.0 * k as f64) * u];
                layout.place(self.caption(line, size, colour, vec![(at, Anchor::Centre)]));
            }
            layout.keep_free([0.0, band.top], [width, band.top + band.height]);
            bands.push(band);
        }
        bands
    }

    /// The bands of the alarms in type of this size, with the lines and their colour.
    fn alarm_bands(&self, size: f64) -> Vec<(Band, Vec<String>, Rgb)> {
        let width = f64::from(self.view.size[0]) - 30.0 * self.word_unit();
        let u = self.word_unit() * size / ALARM_TYPES[0];
        let mut top = 62.0 * self.word_unit();
        let band = |(text, colour): (String, Rgb)| {
            let lines = wrapped(&text, (size * self.word_unit()) as f32, width);
            let height = (12.0 + 22.0 * lines.len() as f64) * u;
            let band = Band { top, height };
            top += height + 2.0 * u;
            (band, lines, colour)
        };
        self.alarms().into_iter().map(band).collect()
    }

    fn alarms(&self) -> Vec<(String, Rgb)> {
        let mut alarms = Vec::new();
        match self.notice {
            Notice::Stale(_) if self.is_surface() => alarms.push(("POSE OLD".to_owned(), palette::WARN)),
            Notice::Lost(reason, _) if self.is_surface() => {
                alarms.push((format!("NO POSE: {}", reason.words()), palette::ALARM));
            }
            Notice::Stale(age) => alarms.push((format!("POSE {}\u{a0}OLD", age_words(age)), palette::WARN)),
            Notice::Lost(reason, age) => {
                let age = age.map(|age| format!(", image\u{a0}{}\u{a0}old", age_words(age)));
                let text = format!("NO POSE: {}{}", reason.words(), age.unwrap_or_default());
                alarms.push((text, palette::ALARM));
            }
            Notice::Live | Notice::Requested | Notice::Look => {}
        }
        if self.outside {
            // Of a part nobody here knows where the examination ends.
            let text = match self.marks.has(Marks::PART) {
                true => "TIP OUTSIDE THE LOADED PART",
                false => "TIP OUTSIDE THE CT",
            };
            alarms.push((text.to_owned(), palette::WARN));
        }
        alarms.extend(self.tissue_alarm().map(|text| (text, palette::WARN)));
        alarms.extend(self.covered_twice_words().map(|text| (text, palette::WARN)));
        alarms.extend(self.remarks.iter().map(|remark| ((*remark).to_owned(), palette::WARN)));
        alarms
    }

    /// Orientation letters in the middle of each side, or beside where an alarm stands there.
    fn letters(&self) -> [Caption; 4] {
        let [w, h] = self.view.size.map(f64::from);
        let inset = 14.0 * self.word_unit();
        let (right, down) = (self.plane.right(), self.plane.down());
        let along = [0.5, 0.6, 0.7, 0.8, 0.4, 0.3, 0.2, 0.9, 0.1];
        let column = |x: f64, anchor| along.map(|part| ([x, part * h], anchor)).to_vec();
        let row = |y: f64| along.map(|part| ([part * w, y], Anchor::Centre)).to_vec();
        [
            (-down, row(inset)),
            (-right, column(inset, Anchor::Left)),
            (right, column(w - inset, Anchor::Right)),
            (down, row(h - inset)),
        ]
        .map(|(direction, spots)| self.caption(letters(direction), 20.0, palette::WORDS, spots))
    }

    /// The number of the scale bar, above it; returns whether there was room.
    fn scale_words(&self, layout: &mut Layout) -> bool {
        let u = self.word_unit();
        let ([from, to], mm) = self.scale();
        let tick = 4.0 * self.unit() + 3.0;
        layout.keep_free([from[0] - 3.0, from[1] - tick], [to[0] + 3.0, to[1] + tick]);
        let at = [from[0], from[1] - tick - 7.0 * u];
        layout.place(self.caption(format!("{mm} mm"), 13.0, palette::WORDS, vec![(at, Anchor::Left)]))
    }

    /// The lines of the four corners, what matters most first.
    fn corners(&self, counted: bool) -> Vec<Caption> {
        let chosen = self.chosen_words().filter(|_| self.says_all());
        let model_error = self
            .model_error_words()
            .filter(|_| self.says_all() && !self.is_surface());
        let model_error = model_error.unwrap_or_default();
        let accuracy = self.accuracy.as_ref();
        let room = if counted { REMARK_ROOM } else { "" };
        let ids = format!("vol {} reg {:08x}", self.volume, self.registration_id >> 32);
        let place = place_words(self.plane).filter(|_| self.is_placed);
        // No picture is taken for one in another window, also where a window around it says the rest; who asked for a plane knows.
        let [place, window] = match !self.is_surface() && (self.says_all() || self.notice != Notice::Look) {
            true => [place.unwrap_or_default(), self.window_words()],
            false => Default::default(),
        };
        let [title, ids] = match self.says_all() {
            true if self.is_surface() => [self.title(), String::new()],
            true => [self.title(), ids],
            false => Default::default(),
        };
        let delay = accuracy.and_then(|a| a.delay_words()).unwrap_or_default();
        let [accuracy, chosen, delay] = match self.is_surface() {
            true => ["", "", if delay.is_empty() { "" } else { "SMOOTHED" }].map(str::to_owned),
            false => [
                accuracy.map(|a| a.words()).unwrap_or_default(),
                chosen.unwrap_or_default(),
                delay,
            ],
        };
        use Corner::{BottomLeft, BottomRight, TopLeft, TopRight};
        let lines = [
            (TopLeft, title, 15.0, palette::WORDS),
            (TopLeft, place, 13.0, palette::WORDS),
            (BottomRight, self.origin.warning().to_owned(), 13.0, palette::ALARM),
            (BottomRight, room.to_owned(), 12.0, palette::WORDS),
            (TopRight, accuracy, 13.0, palette::TIP),
            (BottomRight, chosen, 13.0, palette::TARGET),
            (BottomRight, model_error, 13.0, palette::TARGET),
            (BottomRight, self.caution.to_owned(), 13.0, palette::WARN),
            (BottomRight, self.marks.words(), 13.0, palette::WORDS),
            (BottomLeft, delay, 13.0, palette::WORDS),
            (TopLeft, unusual(self.view).unwrap_or_default(), 12.0, palette::WORDS),
            (TopLeft, window, 12.0, palette::QUIET),
            (TopRight, ids, 12.0, palette::QUIET),
        ];
        let caption = |(corner, text, size, colour): (Corner, String, f64, Rgb)| {
            self.caption(text, size, colour, self.spots(corner))
        };
        lines.map(caption).into()
    }

    fn spots(&self, corner: Corner) -> Vec<([f64; 2], Anchor)> {
        let (u, [w, h]) = (self.word_unit(), self.view.size.map(f64::from));
        let line = |k: usize| {
            let step = STEP * u * k as f64;
            let (left, right) = (12.0 * u, w - 12.0 * u);
            match corner {
                Corner::TopLeft => ([left, FIRST * u + step], Anchor::Left),
                Corner::TopRight => ([right, FIRST * u + step], Anchor::Right),
                Corner::BottomLeft => ([left, h - FIRST * u - step], Anchor::Left),
                Corner::BottomRight => ([right, h - FIRST * u - step], Anchor::Right),
            }
        };
        (0..LINES).map(line).collect()
    }

    /// The window of HU, and of images that show a part what their shorter side shows.
    fn window_words(&self) -> String {
        let window = format!("W {} C {}", self.view.window.width_hu, self.view.window.centre_hu);
        let field_mm = self.plane.pixel_mm() * f64::from(self.view.size[0].min(self.view.size[1]));
        let is_whole = self.view.extent == Extent::Global && self.notice != Notice::Look;
        match is_whole {
            true => window,
            false => format!("{window}, field {} mm", (10.0 * field_mm).round() / 10.0),
        }
    }

    /// How far from the left side nothing is written, pixels.
    pub(super) fn beside_words(&self) -> f64 {
        (12.0 * self.word_unit() - 3.0).max(1.0)
    }

    /// Words beside the outer ends of a line in two parts, from its ends inwards and on either side of it.
    pub(super) fn beside_ends(&self, text: String, parts: [Option<[[f64; 2]; 2]>; 2]) -> Caption {
        let u = self.word_unit();
        let mut spots = Vec::new();
        for inwards in [14.0, 30.0, 46.0, 62.0, 78.0] {
            for [from, to] in parts.into_iter().flatten() {
                let [dx, dy] = [to[0] - from[0], to[1] - from[1]];
                let length = dx.hypot(dy);
                let [dx, dy] = [dx / length * u, dy / length * u];
                if inwards * u > length {
                    continue;
                }
                for beside in [14.0, -14.0] {
                    let at = [
                        from[0] + inwards * dx - beside * dy,
                        from[1] + inwards * dy + beside * dx,
                    ];
                    spots.push((at, Anchor::Centre));
                }
            }
        }
        self.caption(text, 12.0, palette::CUT, spots)
    }

    fn title(&self) -> String {
        // Whatever the view's own plane is, this one was asked for.
        if self.notice == Notice::Look {
            return "LOOK".to_owned();
        }
        if self.is_surface() {
            return format!("SURFACE from {}", letters(-self.plane.into_screen()));
        }
        let extent = match self.view.extent {
            Extent::Global => "global",
            Extent::Local => "local",
        };
        format!("{} {extent}", self.view.plane.name().to_uppercase())
    }

    fn state_words(&self) -> (String, Rgb) {
        let seq = self.seq;
        match self.notice {
            Notice::Live if self.is_surface() && self.origin != Origin::Tracker => {
                (self.origin.word().to_owned(), palette::REPLAY)
            }
            Notice::Live if self.is_surface() => ("LIVE".to_owned(), palette::WORDS),
            Notice::Requested if self.is_surface() => ("HELD".to_owned(), palette::WORDS),
            Notice::Stale(_) if self.is_surface() => ("OLD".to_owned(), palette::WARN),
            Notice::Lost(..) if self.is_surface() => ("LOST".to_owned(), palette::ALARM),
            Notice::Live if self.origin != Origin::Tracker => {
                (format!("{} seq {seq}", self.origin.word()), palette::REPLAY)
            }
            Notice::Live => (format!("LIVE seq {seq}"), palette::WORDS),
            Notice::Requested => (format!("HELD seq {seq}"), palette::WORDS),
            Notice::Look => ("NOT FOLLOWING".to_owned(), palette::WARN),
            Notice::Stale(_) => (format!("seq {seq}"), palette::WARN),
            Notice::Lost(..) => (format!("seq {seq}"), palette::ALARM),
        }
    }

    /// A target's name beside it, with its distance where the plane misses it, and how far a model has moved it, as along the tube no
    /// image across it shows that. Above its right first: the tube comes from the
    /// side or from below more often than from there.
    fn label(&self, outline: &Outline<'_>) -> Caption {
        let (target, reach, outline) = (outline.target, outline.reach_px, &outline.circle);
        let name = &target.name;
        let mut text = match outline.cut {
            true => name.clone(),
            false => format!("{name} {:+.1} mm", outline.depth_mm),
        };
        text += &self.moved_words(target.centre).unwrap_or_default();
        let ([x, y], u) = (outline.at, self.word_unit());
        let (reach, lift) = (reach, reach + 6.0 * u);
        let beside = reach + 4.0 * u;
        let spots = vec![
            ([x + reach, y - lift], Anchor::Left),
            ([x + reach, y + lift], Anchor::Left),
            ([x - reach, y - lift], Anchor::Right),
            ([x - reach, y + lift], Anchor::Right),
            ([x + beside, y], Anchor::Left),
            ([x - beside, y], Anchor::Right),
            ([x, y - lift - 4.0 * u], Anchor::Centre),
            ([x, y + lift + 4.0 * u], Anchor::Centre),
        ];
        self.caption(text, 12.0, palette::TARGET, spots)
    }
}

/// How many captions found no spot; none says nothing.
fn left_out_words(left_out: usize) -> String {
    match left_out {
        0 => String::new(),
        1 => "1 LABEL LEFT OUT".to_owned(),
        n => format!("{n} LABELS LEFT OUT"),
    }
}

/// An age, in one piece: the space does not break.
pub(super) fn age_words(age_ns: i64) -> String {
    match clock::ms(age_ns) {
        ms if ms < 1000.0 => format!("{ms:.0}\u{a0}ms"),
        ms => format!("{:.1}\u{a0}s", ms / 1000.0),
    }
}

/// What makes the image other than the thin plane through the tip: it must be said, or it would be taken for that.
pub(super) fn unusual(view: &View) -> Option<String> {
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
