//! Pictures of states: true curved boundaries, fields with a bar of colours, arrows of forces.
//!
//! All is drawn in negative on black and inverted at the end, so that the dark rim of text becomes a white one.

pub(crate) mod colour;
mod field;
mod marks;
pub(crate) mod sheet;
pub(crate) mod view;

mod fill;

use nalgebra::Vector2;
use picture::{Anchor, Canvas, Line, Rgb};

pub(crate) use field::{Span, file_word, span};
pub(crate) use sheet::{film, strip};

use crate::model::Model;
use crate::run::State;
use crate::scene::raw::{RawField, RawUnits};
use view::{View, round_length, short};

/// Fills of solids that have no field, one after the other: light, told apart by readers who see red and green alike too.
const TINTS: [Rgb; 6] = [
    Rgb(166, 206, 227),
    Rgb(253, 205, 150),
    Rgb(178, 223, 178),
    Rgb(228, 190, 216),
    Rgb(245, 228, 156),
    Rgb(190, 200, 210),
];
const RIGID: Rgb = Rgb(176, 176, 184);
const DRIVEN: Rgb = Rgb(110, 116, 128);
const WALL: Rgb = Rgb(225, 222, 216);
const DARK: Rgb = Rgb(25, 25, 30);
const GREY: Rgb = Rgb(110, 110, 110);
const ARROWS: Rgb = Rgb(205, 0, 70);

/// The colour that becomes `colour` once the picture is inverted.
fn ink(Rgb(r, g, b): Rgb) -> Rgb {
    Rgb(255 - r, 255 - g, 255 - b)
}

/// How a picture is drawn.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Spec<'a> {
    pub(crate) title: &'a str,
    pub(crate) units: &'a RawUnits,
    pub(crate) field: RawField,
    pub(crate) span: Option<Span>,
    pub(crate) size: [u32; 2],
    /// What part of the scene is shown.
    pub(crate) region: [Vector2<f64>; 2],
    pub(crate) forces: bool,
    /// Cursors along the boundary of a solid, so far apart.
    pub(crate) cursors: Option<(usize, f64)>,
    /// One of several on a sheet: less text.
    pub(crate) small: bool,
}

/// The box round all boundaries of some states, with a margin.
pub(crate) fn region<'a>(model: &Model, states: impl Iterator<Item = &'a State>) -> [Vector2<f64>; 2] {
    let (mut low, mut high) = (Vector2::repeat(f64::INFINITY), Vector2::repeat(f64::NEG_INFINITY));
    for state in states {
        for body in 0..model.solids.len() {
            for node in &model.system.bodies.solid(body).boundary().nodes {
                let at = model.system.bodies.point(body, *node, &state.a);
                if at.x.is_finite() && at.y.is_finite() {
                    (low, high) = (low.inf(&at), high.sup(&at));
                }
            }
        }
    }
    let margin = Vector2::repeat(0.08 * (high - low).amax().max(f64::MIN_POSITIVE));
    [low - margin, high + margin]
}

/// The picture of a state.
pub(crate) fn state(model: &Model, state: &State, spec: &Spec<'_>) -> Canvas {
    let mut canvas = Canvas::new(spec.size[0], spec.size[1]);
    let (width, height) = (f64::from(canvas.width()), f64::from(canvas.height()));
    let bar = if spec.span.is_some() && !spec.small { 120.0 } else { 0.0 };
    let (top, bottom) = if spec.small { (22.0, 2.0) } else { (52.0, 34.0) };
    let view = View::new(spec.region, [4.0, top, width - 4.0 - bar, height - bottom]);
    walls(&mut canvas, &view, model, state);
    solids(&mut canvas, &view, model, state, spec);
    if let Some(span) = spec.span.filter(|_| !spec.small) {
        marks::crosses(&mut canvas, &view, model, state, spec.field, span.ramp.high);
    }
    if let Some((solid, every)) = spec.cursors.filter(|_| !spec.small) {
        marks::cursors(&mut canvas, &view, model, state, solid, every);
    }
    if state.a == model.placed && model.start != model.placed {
        marks::intruders(&mut canvas, &view, model);
    }
    let signed = spec.span.is_some_and(|s| s.ramp.signed);
    let colour = if signed { DARK } else { ARROWS };
    let largest = if spec.forces {
        marks::forces(&mut canvas, &view, state, colour, spec.small)
    } else {
        0.0
    };
    margins(&mut canvas, &view);
    captions(&mut canvas, &view, state, spec, largest);
    if let Some(span) = spec.span.filter(|_| !spec.small) {
        scale_of_colours(&mut canvas, &span, spec);
    }
    invert(&mut canvas);
    canvas
}

fn invert(canvas: &mut Canvas) {
    for pixel in canvas.rgba_mut().chunks_exact_mut(4) {
        pixel[..3].iter_mut().for_each(|channel| *channel = 255 - *channel);
    }
}

fn walls(canvas: &mut Canvas, view: &View, model: &Model, state: &State) {
    let all = || model.walls.iter().zip(&state.walls);
    let [left, top, right, bottom] = view.frame;
    let diagonal = (right - left).hypot(bottom - top) / view.scale;
    let middle = view.place([0.5 * (left + right), 0.5 * (top + bottom)]);
    for (wall, offset) in all() {
        let along = Vector2::new(-wall.normal.y, wall.normal.x) * diagonal;
        let foot = middle + wall.normal * (offset - middle.dot(&wall.normal));
        let ends = [foot - along, foot + along].map(|p| view.pixel(p));
        canvas.line(ends[0], ends[1], Line::solid(ink(GREY), 3.0));
    }
    // Over the lines: of each, what lies in a wall is covered.
    for (wall, offset) in all() {
        canvas.area(&[view.half_plane(wall.normal, *offset)], ink(WALL), 255);
    }
}

fn solids(canvas: &mut Canvas, view: &View, model: &Model, state: &State, spec: &Spec<'_>) {
    let bodies = &model.system.bodies;
    let all: Vec<_> = (0..model.solids.len())
        .map(|k| marks::contours(view, bodies.solid(k), bodies.part(k, &state.a)))
        .collect();
    for (k, contours) in all.iter().enumerate() {
        let rigid = bodies.solid(k).patches() == 0;
        let colour = match (model.solids[k].driven, rigid) {
            (true, _) => DRIVEN,
            (false, true) => RIGID,
            (false, false) => TINTS[k % TINTS.len()],
        };
        // Solids may overlap where the scene lets them: both are seen.
        let alpha = if state.found.is_some() { 255 } else { 200 };
        canvas.area(contours, ink(colour), alpha);
    }
    if let Some(span) = spec.span {
        field::fill(canvas, view, model, state, spec.field, &span.ramp);
    }
    for (k, contours) in all.iter().enumerate() {
        let thin = Line::solid(ink(Rgb(140, 140, 140)), 0.8);
        if !spec.small && bodies.solid(k).patches() <= 2000 {
            marks::mesh(canvas, view, bodies.solid(k), bodies.part(k, &state.a), thin);
        }
        marks::outline(
            canvas,
            contours,
            Line::solid(ink(DARK), if spec.small { 1.2 } else { 1.8 }),
        );
    }
}

/// Clears what was drawn beyond the frame.
fn margins(canvas: &mut Canvas, view: &View) {
    let (width, height) = (f64::from(canvas.width()), f64::from(canvas.height()));
    let [_, top, right, bottom] = view.frame;
    canvas.fill([0.0, 0.0], [width, top], Rgb(0, 0, 0), 255);
    canvas.fill([0.0, bottom], [width, (height - bottom).max(0.5)], Rgb(0, 0, 0), 255);
    canvas.fill([right, 0.0], [(width - right).max(0.5), height], Rgb(0, 0, 0), 255);
}

fn captions(canvas: &mut Canvas, view: &View, state: &State, spec: &Spec<'_>, largest: f64) {
    let fails = state.measures.as_ref().is_some_and(|m| !m.fails().is_empty());
    let warned = fails || state.label.starts_with("NOT");
    let label = if fails {
        format!("NOT certified, {}", state.label)
    } else {
        state.label.clone()
    };
    let colour = ink(if warned { Rgb(200, 0, 0) } else { DARK });
    if spec.small {
        canvas.text([8.0, 11.0], &label, 13.0, colour, Anchor::Left);
        return;
    }
    canvas.text([10.0, 15.0], spec.title, 17.0, ink(DARK), Anchor::Left);
    let what = match spec.field {
        RawField::Shape => label,
        field => format!("{label}: {}", field::words(field, spec.units)),
    };
    canvas.text([10.0, 38.0], &what, 14.0, colour, Anchor::Left);
    let bottom = f64::from(canvas.height()) - 15.0;
    let length = round_length((view.frame[2] - view.frame[0]) / view.scale);
    let pixels = length * view.scale;
    canvas.line([12.0, bottom], [12.0 + pixels, bottom], Line::solid(ink(DARK), 2.5));
    let text = format!("{} {}", short(length), spec.units.length);
    canvas.text([20.0 + pixels, bottom], &text, 13.0, ink(DARK), Anchor::Left);
    let right = f64::from(canvas.width()) - 10.0;
    if largest > 0.0 {
        let text = format!(
            "largest force {} {} {}",
            short(largest),
            spec.units.stress,
            spec.units.length
        );
        let signed = spec.span.is_some_and(|s| s.ramp.signed);
        let colour = ink(if signed { DARK } else { ARROWS });
        canvas.text([right, bottom], &text, 13.0, colour, Anchor::Right);
    } else if let Some((text, colour)) = marks::legend(spec.field, spec.cursors.is_some()) {
        canvas.text([right, bottom], text, 13.0, ink(colour), Anchor::Right);
    }
}

/// The bar of colours with its numbers.
fn scale_of_colours(canvas: &mut Canvas, span: &Span, spec: &Spec<'_>) {
    let (width, height) = (f64::from(canvas.width()), f64::from(canvas.height()));
    let (left, top, bottom) = (width - 105.0, 84.0, height - 70.0);
    let rows = (bottom - top).max(1.0) as u32;
    let ramp = &span.ramp;
    for row in 0..=rows {
        let part = 1.0 - f64::from(row) / f64::from(rows);
        let colour = ramp.colour(ramp.low + (ramp.high - ramp.low) * part);
        canvas.fill([left, top + f64::from(row)], [20.0, 1.0], ink(colour), 255);
    }
    let frame = [
        [left, top],
        [left + 20.0, top],
        [left + 20.0, bottom + 1.0],
        [left, bottom + 1.0],
        [left, top],
    ];
    canvas.polyline(&frame, Line::solid(ink(DARK), 1.0));
    for k in 0..=4 {
        let part = 0.25 * f64::from(k);
        let y = bottom - (bottom - top) * part;
        canvas.line([left + 20.0, y], [left + 25.0, y], Line::solid(ink(DARK), 1.0));
        let number = short(ramp.low + (ramp.high - ramp.low) * part);
        canvas.text([left + 30.0, y], &number, 13.0, ink(DARK), Anchor::Left);
    }
    let unit = if spec.field == RawField::Gradient {
        "-"
    } else {
        spec.units.stress.as_str()
    };
    canvas.text([left, top - 16.0], unit, 13.0, ink(DARK), Anchor::Left);
    if let Some(text) = field::beyond(span) {
        canvas.text([width - 8.0, bottom + 20.0], &text, 11.0, ink(GREY), Anchor::Right);
    }
}
