//! What a picture shows of the inside of solids: a number at each point, with its words and its colours.

use nalgebra::Vector2;
use simulation::q9::FieldPoint;
use simulation::solid::Solid;

use super::colour::Ramp;
use super::view::View;
use super::{fill, view::short};
use crate::model::Model;
use crate::run::State;
use crate::scene::raw::{RawField, RawUnits};
use picture::Canvas;

/// Of the numbers of a state, this part lies within the colours: corners where stress is infinite do not take them all.
const WITHIN: f64 = 0.99;
/// Points of a side of an element at which the range of a field is looked for.
const SAMPLES: u32 = 4;

/// A word for files and pictures.
pub(crate) fn file_word(field: RawField) -> &'static str {
    match field {
        RawField::Shape => "shape",
        RawField::Gradient => "gradient",
        RawField::Energy => "energy",
        RawField::VonMises => "von-mises",
        RawField::Principal => "principal",
    }
}

/// The quantity and its unit.
pub(super) fn words(field: RawField, units: &RawUnits) -> String {
    let stress = &units.stress;
    match field {
        RawField::Shape => "shape".to_owned(),
        RawField::Gradient => "|displacement gradient|".to_owned(),
        RawField::Energy => format!("elastic energy density, {stress}"),
        RawField::VonMises => format!("von Mises stress, {stress}"),
        RawField::Principal => format!("principal stress of the larger size, {stress}"),
    }
}

/// The number that a field shows at a point; NaN where it has none.
pub(super) fn value(field: RawField, point: &FieldPoint) -> f64 {
    let of_state = |f: fn(&(f64, simulation::law::Stress)) -> f64| point.state.as_ref().map_or(f64::NAN, f);
    match field {
        RawField::Shape => 0.0,
        RawField::Gradient => point.gradient.norm(),
        RawField::Energy => of_state(|s| s.0),
        RawField::VonMises => of_state(|s| s.1.von_mises()),
        RawField::Principal => of_state(|s| {
            let [a, b] = s.1.principal();
            if a.abs() >= b.abs() { a } else { b }
        }),
    }
}

/// A range of a field over states, its largest number, and how much lies beyond the colours.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Span {
    pub(crate) ramp: Ramp,
    pub(crate) largest: f64,
    /// The part of the points looked at, 0 to 1, of the state that has most of them beyond the colours.
    pub(crate) cut: f64,
}

/// The colours of a field over some states; `None` where nothing has it.
///
/// They end where the state that asks for most has all but a hundredth of its points: over all states together the many
/// calm ones would outvote the few at the end.
pub(crate) fn span<'a>(model: &Model, states: impl Iterator<Item = &'a State>, field: RawField) -> Option<Span> {
    if field == RawField::Shape {
        return None;
    }
    let (mut largest, mut high) = (0.0_f64, None);
    let mut all = Vec::new();
    for state in states {
        let numbers = numbers(model, state, field);
        largest = numbers
            .iter()
            .fold(largest, |m, n| if n.abs() > m.abs() { *n } else { m });
        let mut sizes: Vec<f64> = numbers.iter().map(|n| n.abs()).collect();
        sizes.sort_by(f64::total_cmp);
        let at = ((sizes.len() as f64 * WITHIN) as usize).min(sizes.len().saturating_sub(1));
        if let Some(size) = sizes.get(at) {
            high = Some(size.max(high.unwrap_or(0.0)));
        }
        all.push(sizes);
    }
    // Rounding of an undeformed solid is no field.
    let high = Some(high?).filter(|h| *h > 1e-12).unwrap_or(0.0);
    let above = |sizes: &Vec<f64>| {
        let within = sizes.partition_point(|s| *s <= 1.001 * high);
        1.0 - within as f64 / sizes.len().max(1) as f64
    };
    let ramp = match field {
        RawField::Principal => Ramp::about_zero(high),
        _ => Ramp::from_zero(high),
    };
    Some(Span {
        ramp,
        largest,
        cut: all.iter().map(above).fold(0.0, f64::max),
    })
}

/// The numbers of a field on a grid of every element.
fn numbers(model: &Model, state: &State, field: RawField) -> Vec<f64> {
    let bodies = &model.system.bodies;
    let mut found = Vec::new();
    for body in 0..model.solids.len() {
        let (solid, part) = (bodies.solid(body), bodies.part(body, &state.a));
        for patch in 0..solid.patches() {
            let at = grid(SAMPLES).filter_map(|at| solid.field(part, patch, at));
            found.extend(at.map(|p| value(field, &p)).filter(|n| n.is_finite()));
        }
    }
    found
}

/// Local points of a grid of `n` x `n` intervals.
fn grid(n: u32) -> impl Iterator<Item = [f64; 2]> {
    let at = move |k: u32| 2.0 * f64::from(k) / f64::from(n) - 1.0;
    (0..=n).flat_map(move |j| (0..=n).map(move |i| [at(i), at(j)]))
}

/// Fills the solids of a state with a field.
pub(super) fn fill(canvas: &mut Canvas, view: &View, model: &Model, state: &State, field: RawField, ramp: &Ramp) {
    for body in 0..model.solids.len() {
        let solid = model.system.bodies.solid(body);
        let part = model.system.bodies.part(body, &state.a);
        // As many pieces in all elements of a solid: where sides are cut alike, no gap opens between neighbours.
        let pieces = (0..solid.patches()).map(|patch| pieces(view, solid, part, patch));
        let pieces = pieces.max().unwrap_or_default();
        for patch in 0..solid.patches() {
            element(
                canvas,
                &Drawn {
                    view,
                    solid,
                    part,
                    field,
                    ramp,
                },
                patch,
                pieces,
            );
        }
    }
}

/// A solid that is being drawn.
struct Drawn<'a> {
    view: &'a View,
    solid: &'a dyn Solid,
    part: &'a [f64],
    field: RawField,
    ramp: &'a Ramp,
}

/// Pieces of about six pixels along a side of an element: colours between them run linearly.
fn pieces(view: &View, solid: &dyn Solid, part: &[f64], patch: usize) -> u32 {
    let place = |at: [f64; 2]| solid.field(part, patch, at).map_or(Vector2::zeros(), |p| p.position);
    let size = (place([1.0, 1.0]) - place([-1.0, -1.0])).norm() * view.scale;
    (size / 6.0).clamp(2.0, 16.0) as u32
}

fn element(canvas: &mut Canvas, of: &Drawn<'_>, patch: usize, n: u32) {
    let corners: Vec<fill::Corner> = grid(n)
        .map(|at| match of.solid.field(of.part, patch, at) {
            Some(p) => (of.view.pixel(p.position), value(of.field, &p)),
            None => (of.view.pixel(Vector2::zeros()), f64::NAN),
        })
        .collect();
    let across = n as usize + 1;
    for j in 0..n as usize {
        for i in 0..n as usize {
            let at = |di: usize, dj: usize| corners[(j + dj) * across + i + di];
            fill::triangle(canvas, &of.view.frame, of.ramp, [at(0, 0), at(1, 0), at(1, 1)]);
            fill::triangle(canvas, &of.view.frame, of.ramp, [at(0, 0), at(1, 1), at(0, 1)]);
        }
    }
}

/// A sentence about the largest number, where colours end below it.
pub(super) fn beyond(span: &Span) -> Option<String> {
    let over = span.largest.abs() > 1.001 * span.ramp.high;
    let percent = short(100.0 * span.cut);
    over.then(|| format!("{percent} % above, to {}", short(span.largest)))
}
