//! A picture of the beads: each in three planes of the patient, its centre and its rim marked.

use bead::Voxels;
use geometry::{Ct, Point};
use picture::{Anchor, Canvas, Line, Rgb};

use super::file::BeadRecord;
use super::volume::Volume;

/// Pixels of a panel, and mm that it shows.
const PANEL: u32 = 150;
const FIELD_MM: f64 = 15.0;
const GAP: u32 = 6;
/// Pixels above the panels, for the words.
const TITLE: u32 = 22;
/// Beads side by side.
const ACROSS: u32 = 3;
/// HU and greys, straight between them: in one window wide enough for metal, tissue would be black. Fat and muscle are
/// told from one another, bone is light, and only metal is white.
const TONES: [[f64; 2]; 5] = [
    [-1000.0, 0.0],
    [-200.0, 40.0],
    [200.0, 120.0],
    [1500.0, 205.0],
    [3000.0, 255.0],
];
const MARK: Rgb = Rgb(255, 64, 64);
const WORDS: Rgb = Rgb(255, 230, 120);
/// Axes to the right and downwards, and the name with what is to the left and above: axial, frontal, sagittal, seen as
/// radiologists do.
const PLANES: [([f64; 3], [f64; 3], [&str; 3]); 3] = [
    ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], ["axial", "R", "A"]),
    ([1.0, 0.0, 0.0], [0.0, 0.0, -1.0], ["frontal", "R", "S"]),
    ([0.0, 1.0, 0.0], [0.0, 0.0, -1.0], ["sagittal", "A", "S"]),
];

/// Draws the beads of a volume.
pub(super) fn draw(volume: &Volume, beads: &[BeadRecord]) -> Canvas {
    let (cell_width, cell_height) = (3 * (PANEL + GAP) + 2 * GAP, PANEL + TITLE + GAP);
    let count = beads.len().max(1) as u32;
    let across = count.min(ACROSS);
    let mut canvas = Canvas::new(across * cell_width + GAP, count.div_ceil(across) * cell_height + GAP);
    if beads.is_empty() {
        canvas.text([10.0, 20.0], "no bead was found", 16.0, WORDS, Anchor::Left);
    }
    for (i, bead) in (0_u32..).zip(beads) {
        let left = GAP + i % across * cell_width;
        let top = GAP + i / across * cell_height;
        let [x, y, z] = bead.centre_mm;
        let words = format!(
            "{}   {}   r {:.2}  +- {:.3}",
            i + 1,
            Point::<Ct>::new(x, y, z).in_words(2),
            bead.radius_mm,
            bead.error_rms_mm
        );
        let at = [f64::from(left), f64::from(top + TITLE / 2)];
        canvas.text(at, &words, 14.0, WORDS, Anchor::Left);
        for (k, (right, down, name)) in (0_u32..).zip(PLANES) {
            let corner = [left + k * (PANEL + GAP), top + TITLE];
            let panel = panel(volume, bead.centre_mm, right, down);
            canvas.paste(&panel, PANEL, corner[0], corner[1]);
            mark(&mut canvas, corner, bead.radius_mm, name);
        }
    }
    canvas
}

/// The rim of the ball, and a cross with its middle left open so that the bead is seen.
fn mark(canvas: &mut Canvas, [left, top]: [u32; 2], radius_mm: f64, [name, beside, above]: [&str; 3]) {
    let per_mm = f64::from(PANEL) / FIELD_MM;
    let half = (f64::from(PANEL) - 1.0) / 2.0;
    let centre = [f64::from(left) + half, f64::from(top) + half];
    let line = Line::solid(MARK, 1.0);
    canvas.circle(centre, radius_mm * per_mm, line);
    let (near, far) = (radius_mm * per_mm + 4.0, radius_mm * per_mm + 16.0);
    for [dx, dy] in [[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]] {
        let at = |d: f64| [centre[0] + d * dx, centre[1] + d * dy];
        canvas.line(at(near), at(far), line);
    }
    // A dot of half a pixel at the very centre.
    canvas.circle(centre, 0.7, line);
    let foot = [f64::from(left) + 4.0, f64::from(top + PANEL) - 8.0];
    canvas.text(foot, &format!("{name}, {FIELD_MM} mm"), 12.0, WORDS, Anchor::Left);
    canvas.text([f64::from(left) + 4.0, centre[1]], beside, 12.0, WORDS, Anchor::Left);
    canvas.text([centre[0], f64::from(top) + 8.0], above, 12.0, WORDS, Anchor::Centre);
}

/// RGBA of a plane about a centre, interpolated between voxels.
fn panel(volume: &Volume, centre: [f64; 3], right: [f64; 3], down: [f64; 3]) -> Vec<u8> {
    let step = FIELD_MM / f64::from(PANEL);
    let half = (f64::from(PANEL) - 1.0) / 2.0;
    let mut rgba = Vec::with_capacity((PANEL * PANEL * 4) as usize);
    for j in 0..PANEL {
        for i in 0..PANEL {
            let [u, v] = [i, j].map(|k| (f64::from(k) - half) * step);
            let p = [0, 1, 2].map(|a| centre[a] + u * right[a] + v * down[a]);
            let grey = sample(volume, p).map_or(0, tone);
            rgba.extend([grey, grey, grey, 255]);
        }
    }
    rgba
}

/// The grey of a value.
pub(crate) fn tone(hu: f64) -> u8 {
    let hu = hu.clamp(TONES[0][0], TONES[TONES.len() - 1][0]);
    let piece = TONES.windows(2).find(|ends| hu <= ends[1][0]);
    piece.map_or(255, |ends| {
        let [[from, dark], [to, light]] = [ends[0], ends[1]];
        (dark + (light - dark) * (hu - from) / (to - from)).round() as u8
    })
}

/// The HU at a place, linear between the eight voxels around; `None` outside.
pub(crate) fn sample(volume: &Volume, [x, y, z]: [f64; 3]) -> Option<f64> {
    let grid = volume.grid();
    let index = (grid.voxel_from_ct() * Point::<Ct>::new(x, y, z)).mm();
    let dims = grid.dims();
    let inside = (0..3).all(|a| index[a] >= -0.5 && index[a] <= f64::from(dims[a]) - 0.5);
    if !inside {
        return None;
    }
    let mut sum = 0.0;
    for corner in 0..8_u32 {
        let (mut weight, mut voxel) = (1.0, [0; 3]);
        for a in 0..3 {
            let low = index[a].floor();
            let far = f64::from(corner >> a & 1);
            weight *= (1.0 - far) + (2.0 * far - 1.0) * (index[a] - low);
            // Beyond the outermost centres voxels are repeated.
            voxel[a] = (low + far).clamp(0.0, f64::from(dims[a] - 1)) as u32;
        }
        sum += weight * f64::from(volume.at(voxel));
    }
    Some(sum)
}

#[cfg(test)]
mod tests {
    use super::tone;

    #[test]
    fn tissue_bone_and_metal_are_told_apart() {
        let greys = [-2000.0, -1000.0, -100.0, 40.0, 400.0, 1200.0, 3071.0].map(tone);
        assert_eq!([greys[0], greys[1], greys[6]], [0, 0, 255]);
        // A step between two tissues that the eye tells apart with ease is a tenth of the range.
        let steps = greys[1..].windows(2).map(|pair| pair[1] - pair[0]);
        assert!(steps.min() >= Some(25), "{greys:?}");
    }
}
