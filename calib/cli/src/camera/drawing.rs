//! The residuals of all views over the image, enlarged.

use std::path::Path;

use nalgebra::Vector2;
use optics::camera::{CELLS, Calibrated};
use picture::{Anchor, Canvas, Line, PngError, Rgb, write_png};

use super::read::Seen;

/// The longer side of the image in the picture, pixels; around it is a margin, above it are words.
const SIDE: f64 = 1200.0;
const MARGIN: f64 = 24.0;
const HEAD: f64 = 58.0;
/// The length at which the root mean square residual is drawn.
const DRAWN: f64 = 14.0;
const PAPER: Rgb = Rgb(18, 20, 24);
const CELL: Rgb = Rgb(62, 68, 78);
const FRAME: Rgb = Rgb(190, 195, 205);
const WORDS: Rgb = Rgb(235, 235, 235);
const OUT: Rgb = Rgb(255, 70, 70);
/// Views take turns in these.
const VIEWS: [Rgb; 6] = [
    Rgb(90, 200, 250),
    Rgb(255, 190, 60),
    Rgb(130, 230, 120),
    Rgb(230, 140, 250),
    Rgb(250, 240, 130),
    Rgb(160, 170, 255),
];
/// Names of views that find room in the head.
const NAMED: usize = 5;

/// Where a pixel of the image is in the picture.
struct Frame {
    scale: f64,
}

impl Frame {
    fn at(&self, pixel: Vector2<f64>) -> [f64; 2] {
        [
            MARGIN + (pixel.x + 0.5) * self.scale,
            HEAD + (pixel.y + 0.5) * self.scale,
        ]
    }
}

/// Writes the picture: a dot where each disc is, a line to where it was seen from where the camera sees it, so many times
/// enlarged, a colour per view, red for discs that were left out.
pub(super) fn write(path: &Path, found: &Calibrated, seen: &Seen) -> Result<(), PngError> {
    let (width, height) = (seen.size.width as f64, seen.size.height as f64);
    let frame = Frame {
        scale: SIDE / width.max(height),
    };
    let [w, h] = [2.0 * MARGIN + width * frame.scale, HEAD + MARGIN + height * frame.scale];
    let mut canvas = Canvas::new(w.ceil() as u32, h.ceil() as u32);
    canvas.fill([0.0, 0.0], [w, h], PAPER, 255);
    cells(&mut canvas, &frame, [width, height]);
    let times = enlargement(found.rms_px, frame.scale);
    for (i, (view, image)) in found.views.iter().zip(&seen.images).enumerate() {
        for (residual, sighting) in view.residuals.iter().zip(&image.view.sightings) {
            let colour = if residual.used { VIEWS[i % VIEWS.len()] } else { OUT };
            let from = frame.at(sighting.pixel);
            // A disc that was left out may be a hundred pixels off.
            let off = residual.off.cap_magnitude(12.0 * DRAWN / (times * frame.scale)) * times;
            canvas.circle(from, 1.2, Line::solid(colour, 1.0));
            canvas.line(from, frame.at(sighting.pixel + off), Line::solid(colour, 1.4));
        }
    }
    head(&mut canvas, found, seen, times);
    let texts = [
        ("rms_px", format!("{}", found.rms_px)),
        ("enlarged", format!("{times}")),
    ];
    write_png(path, &canvas, &texts)
}

/// A round number by which the root mean square residual becomes some pixels long.
fn enlargement(rms_px: f64, scale: f64) -> f64 {
    let exact = DRAWN / (rms_px.max(1e-9) * scale);
    let power = 10.0_f64.powf(exact.log10().floor());
    let steps = [5.0, 2.0, 1.0];
    steps.into_iter().find(|s| s * power <= exact).unwrap_or(1.0) * power
}

/// The image's frame and the cells that coverage counts.
fn cells(canvas: &mut Canvas, frame: &Frame, [width, height]: [f64; 2]) {
    let corner = |x: f64, y: f64| frame.at(Vector2::new(x - 0.5, y - 0.5));
    for i in 0..=CELLS[0] {
        let x = width * i as f64 / CELLS[0] as f64;
        canvas.line(corner(x, 0.0), corner(x, height), Line::solid(CELL, 1.0));
    }
    for j in 0..=CELLS[1] {
        let y = height * j as f64 / CELLS[1] as f64;
        canvas.line(corner(0.0, y), corner(width, y), Line::solid(CELL, 1.0));
    }
    let corners = [[0.0, 0.0], [width, 0.0], [width, height], [0.0, height], [0.0, 0.0]];
    canvas.polyline(&corners.map(|[x, y]| corner(x, y)), Line::solid(FRAME, 1.0));
}

fn head(canvas: &mut Canvas, found: &Calibrated, seen: &Seen, times: f64) {
    let words = format!(
        "residuals {:.3} px RMS, drawn {times} times as long; red: left out; the cross is the principal point",
        found.rms_px
    );
    canvas.text([MARGIN, 18.0], &words, 16.0, WORDS, Anchor::Left);
    let mut left = MARGIN;
    for (i, (view, image)) in found.views.iter().zip(&seen.images).enumerate().take(NAMED) {
        let name: String = image.name.chars().take(18).collect();
        let words = format!("{name} {:.3}", view.rms_px);
        canvas.text([left, 42.0], &words, 14.0, VIEWS[i % VIEWS.len()], Anchor::Left);
        // The typeface has letters of one width, 0.6 of its size.
        left += (words.chars().count() as f64 + 2.0) * 14.0 * 0.602;
    }
    let frame = Frame {
        scale: SIDE / seen.size.width.max(seen.size.height) as f64,
    };
    let [x, y] = frame.at(found.camera.centre);
    let line = Line::solid(WORDS, 1.5);
    canvas.line([x - 9.0, y], [x + 9.0, y], line);
    canvas.line([x, y - 9.0], [x, y + 9.0], line);
}
