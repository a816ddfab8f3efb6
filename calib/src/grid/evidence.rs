//! Whether a disc is where a fitted grid says.

use nalgebra::{Matrix4, Vector2, Vector4};

use super::homography::project;
use super::whole::{Whole, point};
use crate::disc::{Blurred, Ellipse};
use crate::image::Image;

/// The share of the expected contrast at a cell, and its standard deviation; none outside the image.
///
/// Least squares of the pixels on the disc's coverage beside a plane of grey, so that shade and edges of the paper do
/// not count. Other discs of the grid are taken out first.
pub(crate) fn amplitude(image: &Image, whole: &Whole, cell: [i32; 2]) -> Option<[f64; 2]> {
    let (width, height) = (image.width(), image.height());
    let model = |c: [i32; 2]| {
        Some(Blurred::new(
            Ellipse::of_circle(&whole.h, point(c), whole.radius)?,
            whole.sigma,
        ))
    };
    let own = model(cell)?;
    let around = |[dx, dy]: [i32; 2]| model([cell[0] + dx, cell[1] + dy]);
    let others: Vec<Blurred> = [[1, 0], [-1, 0], [0, 1], [0, -1]]
        .into_iter()
        .filter_map(around)
        .collect();
    let centre = project(&whole.h, point(cell));
    let inside = centre.x > 0.0 && centre.y > 0.0 && centre.x < width as f64 - 1.0 && centre.y < height as f64 - 1.0;
    if !inside {
        return None;
    }
    let off = (centre - whole.origin) / 100.0;
    let contrast = whole.contrast[0] + whole.contrast[1] * off.x + whole.contrast[2] * off.y;
    let back = whole.h.try_inverse()?;
    let [columns, rows] = own.window(2.5 * whole.sigma, width, height);
    let (mut matrix, mut vector, mut count) = (Matrix4::zeros(), Vector4::zeros(), 0);
    for y in rows[0]..rows[1] {
        for x in columns[0]..columns[1] {
            let place = Vector2::new(x as f64, y as f64);
            let at = project(&back, place) - point(cell);
            if at.x.abs() > 0.6 || at.y.abs() > 0.6 {
                continue;
            }
            let rest: f64 = others.iter().map(|o| o.value(place.x, place.y)).sum();
            let value = f64::from(image.sample(x, y)) + contrast * rest;
            let d = place - centre;
            let row = Vector4::new(own.value(place.x, place.y), 1.0, d.x, d.y);
            matrix += row * row.transpose();
            vector += row * value;
            count += 1;
        }
    }
    if count < 8 {
        return None;
    }
    let inverse = matrix.try_inverse()?;
    let found = inverse * vector;
    let deviation = whole.noise * inverse[(0, 0)].max(0.0).sqrt();
    Some([-found[0] / contrast, deviation / contrast.abs()])
}
