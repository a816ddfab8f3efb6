//! One frame of the screen: from what is known to pixels.

use egui::{Context, FullOutput, Pos2, RawInput, Rect, TexturesDelta, Ui, vec2};

use crate::code::{COLUMNS, Code, Place, ROWS, SQUARE_PX, Shown};
use crate::colours;
use crate::display::Part;
use crate::feed::Feed;
use crate::model::{Model, Tone};
use crate::paint::{Area, CpuPainter, Frame, Image, PaintError, Painter, Pixels};
use crate::screen::{self, Look, Outcome};
use crate::sizes::Screen;

/// Makes frames: the layout, the painter, and their memory.
#[derive(Debug)]
pub struct Frames {
    context: Context,
    painter: CpuPainter,
    /// Letters that were laid out and not painted yet.
    textures: TexturesDelta,
    /// Counts frames from 1.
    seq: u64,
    /// Where the last frame's coded cell was.
    place: Option<Place>,
}

/// What the coded cell of a frame has to say.
#[derive(Debug, Clone, Copy)]
pub struct Coded {
    /// The run's key.
    pub key: u32,
    /// This process.
    pub pid: u32,
}

/// A frame as it was painted.
#[derive(Debug)]
pub struct Painted {
    /// What the person wished, and all words.
    pub outcome: Outcome,
    /// What has changed on the screen.
    pub parts: Vec<Part>,
    /// The code painted, and where; `None` where the screen has no room for it.
    pub code: Option<(Code, Place)>,
}

impl Default for Frames {
    fn default() -> Self {
        Self {
            context: screen::context(),
            painter: CpuPainter::new(),
            textures: TexturesDelta::default(),
            seq: 0,
            place: None,
        }
    }
}

impl Frames {
    /// What was painted is gone, or the screen has another size: the next frame is painted whole.
    pub fn forget(&mut self) {
        self.painter.forget();
        self.place = None;
    }

    /// Paints one frame of `model`, with the images that `feed` has chosen, into `pixels`.
    ///
    /// # Errors
    /// [`PaintError`] for memory of another size than the screen's.
    pub fn paint(
        &mut self,
        (model, feed): (&Model, &Feed),
        (screen, look): (Screen, &Look),
        (events, time_s): (Vec<egui::Event>, f64),
        coded: Coded,
        pixels: &mut [u32],
    ) -> Result<Painted, PaintError> {
        let frames = feed.frames().iter().enumerate();
        let images: Vec<Image<'_>> = frames
            .filter_map(|(view, frame)| image(view, frame.as_deref()?))
            .collect();
        let show = |ui: &mut Ui| screen::show(ui, model, screen, look);
        let (outcome, mut parts) = self.paint_ui(screen, (events, time_s), &images, pixels, show)?;
        let code = self.stamp((outcome.code, coded), shown(model, look), screen, (pixels, &mut parts));
        Ok(Painted { outcome, parts, code })
    }

    /// Paints what `show` lays out, with these images, into `pixels`; what it gave, and what has changed on the screen.
    ///
    /// # Errors
    /// [`PaintError`] for memory of another size than the screen's.
    pub fn paint_ui<T: Default>(
        &mut self,
        screen: Screen,
        (events, time_s): (Vec<egui::Event>, f64),
        images: &[Image<'_>],
        pixels: &mut [u32],
        show: impl FnMut(&mut Ui) -> T,
    ) -> Result<(T, Vec<Part>), PaintError> {
        let (outcome, laid) = self.lay_out(screen, (events, time_s), show);
        Ok((outcome, self.paint_laid(screen, laid, images, pixels)?))
    }

    /// Lays out what `show` does, and paints nothing: what it gave, and what [`Frames::paint_laid`] paints. What is not painted is to be
    /// dropped by [`Frames::drop_laid`].
    pub fn lay_out<T: Default>(
        &mut self,
        screen: Screen,
        (events, time_s): (Vec<egui::Event>, f64),
        mut show: impl FnMut(&mut Ui) -> T,
    ) -> (T, FullOutput) {
        let [width, height] = screen.pixels.map(|n| n as f32);
        let input = RawInput {
            screen_rect: Some(Rect::from_min_size(Pos2::ZERO, vec2(width, height))),
            time: Some(time_s),
            events,
            focused: true,
            ..RawInput::default()
        };
        let mut outcome = T::default();
        let output = self.context.run_ui(input, |ui| outcome = show(ui));
        (outcome, output)
    }

    /// A frame that is not painted: its letters are kept for the next one.
    pub fn drop_laid(&mut self, laid: FullOutput) {
        self.textures.append(laid.textures_delta);
    }

    /// Paints what was laid out, with these images, into `pixels`; what has changed on the screen.
    ///
    /// # Errors
    /// [`PaintError`] for memory of another size than the screen's.
    pub fn paint_laid(
        &mut self,
        screen: Screen,
        mut output: FullOutput,
        images: &[Image<'_>],
        pixels: &mut [u32],
    ) -> Result<Vec<Part>, PaintError> {
        self.seq += 1;
        self.textures.append(std::mem::take(&mut output.textures_delta));
        let primitives = self
            .context
            .tessellate(std::mem::take(&mut output.shapes), output.pixels_per_point);
        let painted = self.painter.paint(
            Frame {
                size: screen.pixels,
                pixels_per_point: output.pixels_per_point,
                clear: colours::GROUND,
                textures: &mut self.textures,
                primitives: &primitives,
                images,
            },
            Pixels { pixels, age: 1 },
        )?;
        let part = |area: &Area| {
            [
                area.x0.max(0) as u32,
                area.y0.max(0) as u32,
                area.width(),
                area.height(),
            ]
        };
        Ok(painted.damage.iter().map(part).collect())
    }

    /// Puts the coded cell of this frame into its room, if it has one: the oldest pose shown and what is claimed of it.
    pub fn stamp(
        &self,
        (room, coded): (Option<Rect>, Coded),
        (oldest_ns, shown): (i64, Shown),
        screen: Screen,
        (pixels, parts): (&mut [u32], &mut Vec<Part>),
    ) -> Option<(Code, Place)> {
        let place = place(room?, coded)?;
        let code = Code::new(self.seq, oldest_ns, shown);
        parts.push(stamp(code, place, screen.pixels[0], pixels));
        Some((code, place))
    }

    /// Whether the coded cell lies elsewhere than when this was asked last.
    pub fn has_moved(&mut self, place: Place) -> bool {
        self.place.replace(place) != Some(place)
    }
}

/// What the coded cell says of a screen: the oldest pose shown, ns, and what is claimed of it.
fn shown(model: &Model, look: &Look) -> (i64, Shown) {
    let state = &model.state;
    // In the place of the images.
    if model.steps.is_some() && look.steps && !look.only_sight {
        return (0, Shown::NotLive);
    }
    let has_images = model.cells.iter().any(|cell| cell.size.is_some());
    let shown = match state.tone {
        _ if !has_images => Shown::Nothing,
        Tone::Replay => Shown::Replay,
        Tone::Live | Tone::Quiet => Shown::Live,
        Tone::Warning | Tone::Alarm => Shown::NotLive,
    };
    (state.oldest_ns.unwrap_or(0), shown)
}

/// The image of a view, where it lies in shared memory.
pub(crate) fn image(view: usize, frame: &bus::port::Frame) -> Option<Image<'_>> {
    let header = frame.header();
    // What it may claim has been judged by the model, from the same header.
    let ages = bus::message::Ages {
        stale_ns: i64::MAX,
        lost_ns: i64::MAX,
    };
    let stamp = &header.stamp;
    Some(Image {
        id: view as u64,
        // Another image of the same pose, as one drawn again because it has grown old, is handed over at another time.
        version: (stamp.t_framed_ns as u64).rotate_left(20) ^ stamp.seq,
        size: [header.width, header.height],
        rgba: frame.shown(0, ages).rgba,
    })
}

/// The largest squares that fit into the room, at its upper right corner.
fn place(room: Rect, coded: Coded) -> Option<Place> {
    let fits = (room.width() / COLUMNS as f32).min(room.height() / ROWS as f32).floor();
    let square = (fits.max(0.0) as u32).min(*SQUARE_PX.end());
    SQUARE_PX.contains(&square).then(|| Place {
        at: [room.right() as u32 - square * COLUMNS, room.top().ceil() as u32],
        square,
        key: coded.key,
        pid: coded.pid,
    })
}

/// Puts the cell into the pixels.
fn stamp(code: Code, place: Place, columns: u32, pixels: &mut [u32]) -> Part {
    let [width, height] = place.size();
    let grid = code.grid(place.key);
    let [left, top] = place.at;
    for y in 0..height {
        let from = ((top + y) * columns + left) as usize;
        let Some(row) = pixels.get_mut(from..from + width as usize) else {
            continue;
        };
        for (x, pixel) in (0_u32..).zip(row) {
            let is_white = grid.is_white(x / place.square, y / place.square);
            *pixel = if is_white { 0xff_ffff } else { 0 };
        }
    }
    [left, top, width, height]
}
