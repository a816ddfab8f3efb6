//! The three planes as one picture: axial over frontal, sagittal beside frontal, so that one height is one z and one column
//! one x; words in the corner that is left.

use picture::{Anchor, Canvas, Line, Rgb};
use scene::WindowLevel;

use super::Summary;
use super::planes::{Plane, Planes, Shown};

/// Around each plane, pixels: room for a letter.
const MARGIN: u32 = 34;
/// Least room for the words, pixels.
const WORDS_WIDTH: u32 = 300;
const WORDS_HEIGHT: u32 = 250;
const WORDS: Rgb = Rgb(235, 235, 235);
const QUIET: Rgb = Rgb(165, 175, 190);
const WARN: Rgb = Rgb(255, 180, 0);
/// Not measured: no HU is shown in these.
const PADDING: [u8; 4] = [0, 0, 72, 255];
const OUTSIDE: [u8; 4] = [18, 20, 26, 255];
/// Room for the bar's words and half a letter, pixels.
const BAR_WORDS: f64 = 90.0;
/// Lengths of the scale bar, mm.
const BARS_MM: [f64; 6] = [1000.0, 100.0, 50.0, 20.0, 10.0, 1.0];

/// The picture of `planes` under `window`.
pub(super) fn draw(planes: &Planes, summary: &Summary, window: WindowLevel) -> Canvas {
    let [axial, frontal, sagittal] = &planes.planes;
    let words_at = [3 * MARGIN + axial.size[0], MARGIN];
    let lower = 3 * MARGIN + axial.size[1].max(WORDS_HEIGHT);
    let width = words_at[0] + sagittal.size[0].max(WORDS_WIDTH) + MARGIN;
    let mut canvas = Canvas::new(width, lower + frontal.size[1] + MARGIN);
    plane(&mut canvas, axial, [MARGIN, MARGIN], window);
    plane(&mut canvas, frontal, [MARGIN, lower], window);
    plane(&mut canvas, sagittal, [words_at[0], lower], window);
    scale_bar(&mut canvas, axial, planes.pixel_mm);
    words(&mut canvas, words_at.map(f64::from), summary, window);
    canvas
}

/// A plane with its letters and its name.
fn plane(canvas: &mut Canvas, plane: &Plane, at: [u32; 2], window: WindowLevel) {
    let pixels: Vec<u8> = plane.shown().flat_map(|shown| pixel(shown, window)).collect();
    canvas.paste(&pixels, plane.size[0], at[0], at[1]);
    let ([x, y], [width, height]) = (at.map(f64::from), plane.size.map(f64::from));
    let half = f64::from(MARGIN) / 2.0;
    let [left, right, top, bottom] = [
        [x - half, y + height / 2.0],
        [x + width + half, y + height / 2.0],
        [x + width / 2.0, y - half],
        [x + width / 2.0, y + height + half],
    ];
    for (place, letter) in [left, right, top, bottom].into_iter().zip(plane.view.letters) {
        canvas.text(place, letter, 20.0, WORDS, Anchor::Centre);
    }
    canvas.text([x, y - half], plane.view.name, 14.0, QUIET, Anchor::Left);
}

fn pixel(shown: Shown, window: WindowLevel) -> [u8; 4] {
    match shown {
        Shown::Outside => OUTSIDE,
        Shown::Padding => PADDING,
        Shown::Measured(hu) => {
            let black = window.centre_hu - window.width_hu / 2.0;
            // `as` saturates: black below the window, white above.
            let grey = (255.0 * (f64::from(hu) - black) / window.width_hu).round() as u8;
            [grey, grey, grey, 255]
        }
    }
}

/// The longest bar, with its words, that fits under the left half of the axial plane.
fn scale_bar(canvas: &mut Canvas, axial: &Plane, pixel_mm: f64) {
    let half = f64::from(axial.size[0]) / 2.0;
    let Some(length_mm) = BARS_MM.into_iter().find(|mm| mm / pixel_mm + BAR_WORDS <= half) else {
        return;
    };
    let margin = f64::from(MARGIN);
    let y = margin + f64::from(axial.size[1]) + margin / 2.0;
    let end = margin + length_mm / pixel_mm;
    canvas.line([margin, y], [end, y], Line::solid(WORDS, 2.0));
    for x in [margin, end] {
        canvas.line([x, y - 4.0], [x, y + 4.0], Line::solid(WORDS, 2.0));
    }
    canvas.text([end + 8.0, y], &format!("{length_mm} mm"), 14.0, WORDS, Anchor::Left);
}

fn words(canvas: &mut Canvas, [x, y]: [f64; 2], summary: &Summary, window: WindowLevel) {
    let place = &summary.place;
    let ([nx, ny, nz], [sx, sy, sz], [dx, dy, dz]) = (place.dims, place.spacing_mm, place.size_mm);
    let mut lines = vec![
        (format!("{nx} x {ny} x {nz} voxels"), WORDS),
        (format!("{sx:.3} x {sy:.3} x {sz:.3} mm"), WORDS),
        (format!("{dx:.1} x {dy:.1} x {dz:.1} mm"), WORDS),
        (
            format!("{}, tilt {:.2} degrees", place.letters, place.tilt_degrees),
            WORDS,
        ),
    ];
    if let Some(hu) = &summary.hu {
        lines.push((format!("{} to {} HU", hu.min, hu.max), WORDS));
    }
    let WindowLevel { centre_hu, width_hu } = window;
    lines.push((format!("window {width_hu} HU around {centre_hu}"), WORDS));
    lines.push((format!("volume {}", summary.hash.get(..16).unwrap_or_default()), QUIET));
    if !summary.marks.is_empty() {
        lines.push((summary.marks.clone(), WARN));
    }
    if !summary.warnings.is_empty() {
        lines.push((format!("warnings: {}, in the report", summary.warnings.len()), WARN));
    }
    for (i, (line, colour)) in lines.iter().enumerate() {
        canvas.text([x, y + 10.0 + 22.0 * i as f64], line, 15.0, *colour, Anchor::Left);
    }
}
