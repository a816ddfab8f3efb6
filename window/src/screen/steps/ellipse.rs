//! The error at the target, to scale: the ellipse that holds 95 % of it from the feet and from the front, over the target.

use bus::message::Steps;
use egui::{Align2, Pos2, Rect, Shape, Stroke, Ui, pos2, vec2};
use picture::palette;

use super::cell;
use crate::colours;
use crate::model::Tone;
use crate::screen::words::Words;
use crate::sizes::Sizes;

/// In the plane 95 % of a normal error lie within so many deviations: the root of 5.991.
const PLANE_95: f64 = 2.4477;
/// Corners of the ellipse.
const CORNERS: usize = 64;
/// The picture reaches so many times as far as what it shows.
const MARGIN: f64 = 1.25;

/// The CT axes to the right and down, with their signs.
type Axes = [(usize, f64); 2];

/// A picture: what it is called, its axes, and the letters at its left and top.
const PICTURES: [(&str, Axes, [&str; 2]); 2] = [
    ("from the feet", [(0, 1.0), (1, 1.0)], ["R", "A"]),
    ("from the front", [(0, 1.0), (2, -1.0)], ["R", "S"]),
];

pub(super) fn show(ui: &Ui, told: &Steps, radius_mm: Option<f64>, room: Rect, (sizes, words): (&Sizes, &mut Words)) {
    let line = 1.3 * sizes.plain;
    let (head, below) = room.split_top_bottom_at_y(room.top() + line);
    let title = format!(
        "registration at {}: 95 % within {:.2} mm",
        Steps::text(&told.target),
        told.target_95_mm
    );
    words.put(ui, head, &title, cell(sizes, Tone::Quiet, Align2::LEFT_CENTER));
    let reach_mm = MARGIN * told.target_95_mm.max(radius_mm.unwrap_or(0.0)).max(0.1);
    let (left, right) = below.split_left_right_at_fraction(0.5);
    for (picture, room) in PICTURES.iter().zip([left, right]) {
        let (name, axes, letters) = picture;
        let (plot, foot) = room.split_top_bottom_at_y(room.bottom() - line);
        words.put(ui, foot, name, cell(sizes, Tone::Quiet, Align2::CENTER_CENTER));
        let side = plot.width().min(plot.height()) - 2.0 * sizes.plain;
        if side < 20.0 {
            continue;
        }
        let square = Rect::from_center_size(plot.center(), vec2(side, side));
        drawn(ui, (told, *axes), (radius_mm, reach_mm), square, sizes);
        let wide = 2.0 * sizes.plain;
        let at_left = Rect::from_center_size(pos2(square.left() - sizes.plain, square.center().y), vec2(wide, line));
        let at_top = Rect::from_min_size(pos2(square.right(), square.top()), vec2(wide, line));
        words.put(ui, at_left, letters[0], cell(sizes, Tone::Quiet, Align2::CENTER_CENTER));
        words.put(
            ui,
            at_top,
            &format!("{}\u{2191}", letters[1]),
            cell(sizes, Tone::Quiet, Align2::CENTER_CENTER),
        );
    }
}

fn drawn(
    ui: &Ui,
    (told, axes): (&Steps, Axes),
    (radius_mm, reach_mm): (Option<f64>, f64),
    square: Rect,
    sizes: &Sizes,
) {
    let painter = ui.painter();
    painter.rect_filled(square, 0.0, colours::CELL);
    let scale = f64::from(square.width()) / (2.0 * reach_mm);
    if let Some(radius) = radius_mm {
        let stroke = Stroke::new(1.5 * sizes.line, colours::of(palette::TARGET));
        painter.circle_stroke(square.center(), (radius * scale) as f32, stroke);
    }
    let at = |[x, y]: [f64; 2]| -> Pos2 { square.center() + vec2((x * scale) as f32, (y * scale) as f32) };
    let outline: Vec<Pos2> = ellipse(&told.covariance, axes).map(at).collect();
    if outline.iter().all(|p| p.x.is_finite() && p.y.is_finite()) {
        painter.add(Shape::closed_line(
            outline,
            Stroke::new(2.0 * sizes.line, colours::of(palette::TIP)),
        ));
    }
}

/// The outline of the 95 % ellipse of a covariance (its upper triangle by rows) on two axes: `L (cos, sin)` with `L` its Cholesky factor.
fn ellipse(upper: &[f64; 6], [(i, si), (j, sj)]: Axes) -> impl Iterator<Item = [f64; 2]> {
    let place = |a: usize, b: usize| [[0, 1, 2], [1, 3, 4], [2, 4, 5]][a][b];
    let (xx, xy, yy) = (upper[place(i, i)], si * sj * upper[place(i, j)], upper[place(j, j)]);
    let l00 = xx.max(0.0).sqrt();
    let l10 = if l00 > 0.0 { xy / l00 } else { 0.0 };
    let l11 = (yy - l10 * l10).max(0.0).sqrt();
    (0..CORNERS).map(move |k| {
        let (sin, cos) = (std::f64::consts::TAU * k as f64 / CORNERS as f64).sin_cos();
        [PLANE_95 * l00 * cos, PLANE_95 * (l10 * cos + l11 * sin)]
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each corner has the Mahalanobis distance of the 95 % ellipse, by the inverse of the covariance.
    #[test]
    fn the_outline_is_the_ellipse_of_the_covariance_seen_so() {
        let upper = [2.0, 0.6, -0.3, 1.5, 0.2, 0.8];
        for (_, axes, _) in PICTURES {
            let [(i, si), (j, sj)] = axes;
            let full = [[2.0, 0.6, -0.3], [0.6, 1.5, 0.2], [-0.3, 0.2, 0.8]];
            let (a, b, c) = (full[i][i], si * sj * full[i][j], full[j][j]);
            let determinant = a * c - b * b;
            for [x, y] in ellipse(&upper, axes) {
                let squared = (c * x * x - 2.0 * b * x * y + a * y * y) / determinant;
                // 5.991 to the digits of the constant.
                assert!((squared - 5.9912).abs() < 1e-3, "{squared}");
            }
        }
    }
}
