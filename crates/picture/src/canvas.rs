//! An RGBA image and the few shapes an overlay needs. Positions are pixels; whole numbers are pixel centres.

use tiny_skia::{Color, FillRule, LineCap, Paint, PathBuilder, Pixmap, Rect, Stroke, StrokeDash, Transform};

use crate::palette::{self, Rgb};
use crate::strokes::{End, Strokes, Widths};
use crate::text::{self, Anchor};

/// How a line is drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Line {
    /// Its colour.
    pub colour: Rgb,
    /// Its width, pixels.
    pub width: f32,
    /// Solid, or dashed for what lies behind the plane.
    pub dashed: bool,
    /// Width of a dark rim on each side, pixels; 0: none. With one, the line is seen on every ground.
    pub rim: f32,
}

impl Line {
    /// A solid line.
    pub const fn solid(colour: Rgb, width: f32) -> Self {
        Self {
            colour,
            width,
            dashed: false,
            rim: 0.0,
        }
    }

    /// A dashed line.
    pub const fn dashed(colour: Rgb, width: f32) -> Self {
        Self {
            colour,
            width,
            dashed: true,
            rim: 0.0,
        }
    }

    /// The same line with a dark rim of `rim` pixels on each side.
    #[must_use]
    pub const fn with_rim(mut self, rim: f32) -> Self {
        self.rim = rim;
        self
    }

    fn stroke(&self, width: f32, dash: f32) -> Stroke {
        Stroke {
            width,
            // Round ends would close the gaps of short dashes.
            line_cap: if dash < DASH { LineCap::Butt } else { LineCap::Round },
            dash: self.dashed.then(|| StrokeDash::new(vec![dash, dash], 0.0)).flatten(),
            ..Stroke::default()
        }
    }
}

/// Dash, gap, dash, gap, pixels; `None` is solid.
pub type Dashes = Option<[f32; 4]>;

/// Length of a dash and of the gap behind it, pixels.
const DASH: f32 = 6.0;
/// The dashes of [`Line::dashed`].
pub const DASHED: Dashes = Some([DASH; 4]);
/// A small circle has at least so many dashes.
const DASHES: f32 = 6.0;

fn paint(Rgb(r, g, b): Rgb, alpha: u8) -> Paint<'static> {
    let mut paint = Paint::default();
    paint.set_color_rgba8(r, g, b, alpha);
    paint
}

/// An RGBA image, opaque everywhere.
#[derive(Debug, Clone)]
pub struct Canvas {
    pixmap: Pixmap,
    /// Memory for the lines.
    strokes: Strokes,
}

impl Canvas {
    /// A black image of `width` x `height` pixels, both at least 1.
    pub fn new(width: u32, height: u32) -> Self {
        // tiny-skia refuses only empty images and ones beyond 2^29 bytes a row; callers check their sizes long before.
        let mut pixmap = Pixmap::new(width.clamp(1, 1 << 14), height.clamp(1, 1 << 14))
            .unwrap_or_else(|| unreachable!("sides of 1 to 16384 pixels are always accepted"));
        pixmap.fill(Color::BLACK);
        Self {
            pixmap,
            strokes: Strokes::default(),
        }
    }

    /// Columns.
    pub fn width(&self) -> u32 {
        self.pixmap.width()
    }

    /// Rows.
    pub fn height(&self) -> u32 {
        self.pixmap.height()
    }

    /// The pixels: RGBA, row by row from the top.
    pub fn rgba(&self) -> &[u8] {
        self.pixmap.data()
    }

    /// The pixels, to be overwritten with opaque ones.
    pub fn rgba_mut(&mut self) -> &mut [u8] {
        self.pixmap.data_mut()
    }

    /// Makes every colour darker: each channel times `factor` / 256.
    pub fn dim(&mut self, factor: u16) {
        for pixel in self.pixmap.data_mut().chunks_exact_mut(4) {
            for channel in &mut pixel[..3] {
                *channel = ((u16::from(*channel) * factor.min(256)) >> 8) as u8;
            }
        }
    }

    /// Copies `rgba`, an image of `width` columns, with its first pixel at (`x`, `y`); what does not fit is left out.
    pub fn paste(&mut self, rgba: &[u8], width: u32, x: u32, y: u32) {
        let canvas_width = self.width() as usize;
        let columns = (width as usize).min(canvas_width.saturating_sub(x as usize));
        let first_row = y as usize;
        let height = self.height() as usize;
        let target = self.pixmap.data_mut();
        for (row, line) in rgba.chunks_exact(width as usize * 4).enumerate() {
            if first_row + row >= height {
                break;
            }
            let at = ((first_row + row) * canvas_width + x as usize) * 4;
            target[at..at + columns * 4].copy_from_slice(&line[..columns * 4]);
        }
    }

    /// A straight line.
    pub fn line(&mut self, from: [f64; 2], to: [f64; 2], line: Line) {
        self.polyline(&[from, to], line);
    }

    /// Joined straight lines.
    pub fn polyline(&mut self, points: &[[f64; 2]], line: Line) {
        let (dashes, end) = match line.dashed {
            true => (DASHED, End::Straight),
            false => (None, End::Round),
        };
        self.add(points, line, (dashes, end));
        self.paint_lines(line.colour);
    }

    /// Joined straight lines, several of them alike but for their dashes, one over the others nowhere: all rims lie under all lines.
    /// Ends are cut straight, as round ones would close the gaps of dashes.
    pub fn polylines(&mut self, parts: &[(Vec<[f64; 2]>, Dashes)], line: Line) {
        for (points, dashes) in parts {
            self.add(points, line, (*dashes, End::Straight));
        }
        self.paint_lines(line.colour);
    }

    fn add(&mut self, points: &[[f64; 2]], line: Line, (dashes, end): (Dashes, End)) {
        let widths = Widths {
            line: line.width.into(),
            rim: line.rim.into(),
        };
        let size = [self.width(), self.height()];
        self.strokes.add(size, points, (widths, end), dashes);
    }

    fn paint_lines(&mut self, colour: Rgb) {
        self.strokes.paint(self.pixmap.data_mut(), colour);
    }

    /// A circle.
    pub fn circle(&mut self, centre: [f64; 2], radius: f64, line: Line) {
        let [x, y] = corner(centre);
        let mut path = PathBuilder::new();
        path.push_circle(x, y, radius as f32);
        let around = std::f32::consts::TAU * radius as f32;
        self.stroke(path, line, DASH.min(around / (2.0 * DASHES)));
    }

    /// Filled closed contours, one in another a hole (even-odd rule); `alpha` of 255 is opaque.
    pub fn area(&mut self, contours: &[Vec<[f64; 2]>], colour: Rgb, alpha: u8) {
        let mut path = PathBuilder::new();
        for contour in contours {
            for (i, point) in contour.iter().enumerate() {
                let [x, y] = corner(*point);
                if i == 0 { path.move_to(x, y) } else { path.line_to(x, y) }
            }
            path.close();
        }
        if let Some(path) = path.finish() {
            let mut paint = paint(colour, alpha);
            paint.anti_alias = true;
            self.pixmap
                .fill_path(&path, &paint, FillRule::EvenOdd, Transform::identity(), None);
        }
    }

    /// A filled rectangle from (`x`, `y`), `alpha` of 255 is opaque.
    pub fn fill(&mut self, [x, y]: [f64; 2], [width, height]: [f64; 2], colour: Rgb, alpha: u8) {
        if let Some(rect) = Rect::from_xywh(x as f32, y as f32, width as f32, height as f32) {
            self.pixmap
                .fill_rect(rect, &paint(colour, alpha), Transform::identity(), None);
        }
    }

    /// A frame of `width` pixels along the image's border.
    pub fn border(&mut self, colour: Rgb, width: f64) {
        let (w, h) = (f64::from(self.width()), f64::from(self.height()));
        self.fill([0.0, 0.0], [w, width], colour, 255);
        self.fill([0.0, h - width], [w, width], colour, 255);
        self.fill([0.0, 0.0], [width, h], colour, 255);
        self.fill([w - width, 0.0], [width, h], colour, 255);
    }

    /// Text with a dark rim, so that it is legible on bone and on air; `at` is the point that `anchor` names.
    pub fn text(&mut self, at: [f64; 2], text: &str, size: f32, colour: Rgb, anchor: Anchor) {
        let (w, h) = (self.width(), self.height());
        text::draw(self.pixmap.data_mut(), [w, h], at, text, size, colour, anchor);
    }

    fn stroke(&mut self, path: PathBuilder, line: Line, dash: f32) {
        let Some(path) = path.finish() else { return };
        let rim = (line.rim > 0.0).then_some((palette::RIM, line.width + 2.0 * line.rim));
        for (colour, width) in rim.into_iter().chain([(line.colour, line.width)]) {
            let stroke = line.stroke(width, dash);
            self.pixmap
                .stroke_path(&path, &paint(colour, 255), &stroke, Transform::identity(), None);
        }
    }
}

/// tiny-skia counts from pixel corners, we from pixel centres. Far points are pulled in, so that f32 stays exact enough.
fn corner([x, y]: [f64; 2]) -> [f32; 2] {
    [x, y].map(|c| (c.clamp(-1e5, 1e5) + 0.5) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pixel(canvas: &Canvas, x: u32, y: u32) -> [u8; 4] {
        let at = ((y * canvas.width() + x) * 4) as usize;
        canvas.rgba()[at..at + 4].try_into().unwrap()
    }

    #[test]
    fn lines_run_through_pixel_centres() {
        let mut canvas = Canvas::new(20, 20);
        canvas.line([2.0, 10.0], [17.0, 10.0], Line::solid(Rgb(255, 0, 0), 1.0));
        assert_eq!(pixel(&canvas, 9, 10), [255, 0, 0, 255]);
        assert_eq!(pixel(&canvas, 9, 9), [0, 0, 0, 255]);
        assert_eq!(pixel(&canvas, 9, 11), [0, 0, 0, 255]);
    }

    /// Yellow on bone and blue on fat had a contrast of 1.2.
    #[test]
    fn a_line_with_a_rim_is_seen_on_every_grey() {
        for grey in 0..=255 {
            for colour in [palette::TUBE, palette::TIP, palette::TARGET, palette::CUT] {
                // On a row of pixels, and between two.
                for y in [10.0, 10.5] {
                    let mut canvas = Canvas::new(20, 20);
                    canvas.fill([0.0, 0.0], [20.0, 20.0], Rgb(grey, grey, grey), 255);
                    canvas.line([2.0, y], [17.0, y], Line::solid(colour, 1.3).with_rim(1.35));
                    let row = |y: u32| {
                        let [r, g, b, _] = pixel(&canvas, 9, y);
                        Rgb(r, g, b)
                    };
                    // Between the line and its rim, whatever the ground is.
                    let line = row(10);
                    let most = (7..14).map(|y| palette::contrast(row(y), line)).fold(1.0, f64::max);
                    assert!(most >= 3.0, "{colour:?} on {grey} at {y}: {most}");
                }
            }
        }
    }

    /// Also where they cross, whichever way each of them goes.
    #[test]
    fn lines_together_cover_what_they_cover_one_by_one() {
        let ends = [
            vec![[2.0, 10.0], [17.0, 10.0]],
            vec![[17.0, 12.0], [2.0, 8.0]],
            vec![[9.0, 18.0], [9.0, 2.0]],
        ];
        let line = Line::solid(Rgb(255, 0, 0), 3.0);
        let (mut together, mut apart) = (Canvas::new(20, 20), Canvas::new(20, 20));
        together.polylines(&ends.clone().map(|points| (points, None)), line);
        ends.iter()
            .for_each(|points| apart.polylines(&[(points.clone(), None)], line));
        for (x, y) in (0..20).flat_map(|x| (0..20).map(move |y| (x, y))) {
            let [a, b] = [&together, &apart].map(|canvas| pixel(canvas, x, y)[0]);
            // Where two edges share a pixel its part is counted once, and not twice.
            assert!(a <= b && b - a < 70 && (a > 0) == (b > 0), "{x} {y}: {a} {b}");
        }
        let mut dashed = Canvas::new(40, 20);
        dashed.polylines(&[(vec![[0.0, 10.0], [39.0, 10.0]], DASHED)], line);
        let row = [2, 8, 15, 21].map(|x| pixel(&dashed, x, 10)[0] > 128);
        assert_eq!(row, [true, false, true, false]);
    }

    #[test]
    fn an_area_within_an_area_is_a_hole() {
        let mut canvas = Canvas::new(20, 20);
        let square = |low: f64, high: f64| vec![[low, low], [high, low], [high, high], [low, high]];
        canvas.area(&[square(2.0, 17.0), square(7.0, 12.0)], Rgb(10, 20, 30), 255);
        assert_eq!(pixel(&canvas, 4, 10), [10, 20, 30, 255]);
        assert_eq!(pixel(&canvas, 10, 10), [0, 0, 0, 255]);
        assert_eq!(pixel(&canvas, 0, 10), [0, 0, 0, 255]);
        canvas.area(&[vec![], vec![[1.0, 1.0]]], Rgb(1, 1, 1), 255);
    }

    #[test]
    fn pasting_stops_at_the_border() {
        let mut canvas = Canvas::new(4, 4);
        canvas.paste(&[255; 3 * 3 * 4], 3, 2, 3);
        assert_eq!(pixel(&canvas, 1, 3), [0, 0, 0, 255]);
        assert_eq!(pixel(&canvas, 3, 3), [255; 4]);
    }

    #[test]
    fn text_leaves_a_mark_and_never_leaves_the_image() {
        let mut canvas = Canvas::new(64, 32);
        canvas.text([60.0, 30.0], "R\u{1F600}é", 14.0, Rgb(255, 255, 0), Anchor::Left);
        canvas.text([2.0, 16.0], "R", 14.0, Rgb(255, 255, 0), Anchor::Left);
        assert!(canvas.rgba().chunks(4).any(|p| p[0] > 200 && p[2] == 0));
        canvas.text([-500.0, 1e9], "far", 14.0, Rgb(1, 1, 1), Anchor::Centre);
    }

    #[test]
    fn dimming_keeps_pixels_opaque() {
        let mut canvas = Canvas::new(2, 2);
        canvas.paste(&[200; 16], 2, 0, 0);
        canvas.rgba_mut()[3] = 255;
        canvas.dim(128);
        assert_eq!(pixel(&canvas, 0, 0), [100, 100, 100, 255]);
    }
}
