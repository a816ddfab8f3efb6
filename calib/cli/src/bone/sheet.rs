//! A picture of the surface: its outline on three planes of the CT, at three depths each.

use bone::Bone;
use geometry::{Ct, Point};
use picture::{Anchor, Canvas, Line, Rgb};

use crate::beads::{Volume, sample, tone};

/// Pixels of a panel.
const PANEL: u32 = 380;
const GAP: u32 = 6;
/// Around the bone, mm.
const MARGIN_MM: f64 = 12.0;
const WORDS: Rgb = Rgb(255, 230, 120);
/// Deviations below the first are drawn in the first colour, and so on; mm.
const COLOURS: [(f64, Rgb); 3] = [
    (0.25, Rgb(80, 255, 120)),
    (0.6, Rgb(255, 210, 60)),
    (f64::INFINITY, Rgb(255, 80, 64)),
];
/// Where cortex is not seen.
const UNSEEN: Rgb = Rgb(190, 90, 255);
/// Depths within the bone, as shares of its extent.
const DEPTHS: [f64; 3] = [0.3, 0.5, 0.7];
/// The axis across, the axes to the right and downwards with their signs, and the names, seen as radiologists do.
const PLANES: [(usize, [usize; 2], f64, [&str; 3]); 3] = [
    (2, [0, 1], 1.0, ["axial", "R", "A"]),
    (1, [0, 2], -1.0, ["frontal", "R", "S"]),
    (0, [1, 2], -1.0, ["sagittal", "A", "S"]),
];

/// Draws a surface on its CT.
pub(super) fn draw(volume: &Volume, bone: &Bone) -> Canvas {
    let side = 3 * (PANEL + GAP) + GAP;
    let mut canvas = Canvas::new(side, side + 24);
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for place in &bone.places {
        for k in 0..3 {
            (low[k], high[k]) = (low[k].min(place.mm[k]), high[k].max(place.mm[k]));
        }
    }
    let extent = (0..3).map(|k| high[k] - low[k]).fold(0.0, f64::max) + 2.0 * MARGIN_MM;
    for (row, plane) in (0_u32..).zip(PLANES) {
        for (column, depth) in (0_u32..).zip(DEPTHS) {
            let mut middle = [0, 1, 2].map(|k| 0.5 * (low[k] + high[k]));
            middle[plane.0] = low[plane.0] + depth * (high[plane.0] - low[plane.0]);
            let corner = [GAP + column * (PANEL + GAP), GAP + row * (PANEL + GAP)];
            panel(&mut canvas, volume, bone, (plane, middle, extent), corner);
        }
    }
    let foot = format!(
        "outline of the surface; its deviation: green below {} mm, yellow below {} mm, red above; purple: cortex not seen; open where nothing is drawn",
        COLOURS[0].0, COLOURS[1].0
    );
    canvas.text(
        [f64::from(GAP), f64::from(side) + 10.0],
        &foot,
        14.0,
        WORDS,
        Anchor::Left,
    );
    canvas
}

type Cut = ((usize, [usize; 2], f64, [&'static str; 3]), [f64; 3], f64);

fn panel(
    canvas: &mut Canvas,
    volume: &Volume,
    bone: &Bone,
    ((axis, [u, v], sign, names), middle, extent): Cut,
    corner: [u32; 2],
) {
    let step = extent / f64::from(PANEL);
    let half = (f64::from(PANEL) - 1.0) / 2.0;
    let mut rgba = Vec::with_capacity((PANEL * PANEL * 4) as usize);
    for j in 0..PANEL {
        for i in 0..PANEL {
            let mut p = middle;
            p[u] += (f64::from(i) - half) * step;
            p[v] += sign * (f64::from(j) - half) * step;
            let grey = sample(volume, p).map_or(0, tone);
            rgba.extend([grey, grey, grey, 255]);
        }
    }
    canvas.paste(&rgba, PANEL, corner[0], corner[1]);
    let at = |p: [f64; 3]| {
        [
            f64::from(corner[0]) + half + (p[u] - middle[u]) / step,
            f64::from(corner[1]) + half + sign * (p[v] - middle[v]) / step,
        ]
    };
    let marked = bone.unseen.iter().map(|triangle| (triangle, true));
    for (triangle, is_unseen) in bone.triangles.iter().map(|triangle| (triangle, false)).chain(marked) {
        let places = triangle.map(|i| &bone.places[i as usize]);
        if let Some([from, to]) = crossed(places.map(|p| p.mm.into()), axis, middle[axis]) {
            let deviation = places.iter().map(|p| p.total_mm()).fold(0.0, f64::max);
            let colour = COLOURS
                .iter()
                .find(|(most, _)| deviation < *most)
                .map_or(COLOURS[2].1, |c| c.1);
            let colour = if is_unseen { UNSEEN } else { colour };
            canvas.line(at(from), at(to), Line::solid(colour, 1.2));
        }
    }
    let [left, top] = corner.map(f64::from);
    let words = format!(
        "{}  {}",
        names[0],
        Point::<Ct>::new(middle[0], middle[1], middle[2]).in_words(0)
    );
    canvas.text(
        [left + 5.0, top + f64::from(PANEL) - 10.0],
        &words,
        13.0,
        WORDS,
        Anchor::Left,
    );
    canvas.text([left + 5.0, top + half], names[1], 14.0, WORDS, Anchor::Left);
    canvas.text([left + half, top + 10.0], names[2], 14.0, WORDS, Anchor::Centre);
}

/// Where a triangle crosses the plane of a coordinate.
fn crossed(corners: [[f64; 3]; 3], axis: usize, at: f64) -> Option<[[f64; 3]; 2]> {
    let mut found = Vec::with_capacity(2);
    for k in 0..3 {
        let (a, b) = (corners[k], corners[(k + 1) % 3]);
        if (a[axis] < at) != (b[axis] < at) {
            let share = (at - a[axis]) / (b[axis] - a[axis]);
            found.push([0, 1, 2].map(|i| a[i] + share * (b[i] - a[i])));
        }
    }
    found.try_into().ok()
}
