//! Whole ridges: from each the next best line through neighbouring beams, whatever it is a line of.

use super::grid::Grid;
use super::ridge::Ridges;

/// The most lines that are looked at in an image.
const MOST_LINES: usize = 16;
/// Places of less than this share of the least contrast are no part of any line.
const LEAST_SHARE: f32 = 0.4;
/// What a place counts at most, in least contrasts beyond the least one: no bright spot draws a line to itself alone.
const BEST: f64 = 2.0;
/// What a mm of width costs whose slope differs by 1 from that of the line there.
const BEND: f64 = 0.7;
/// Places so near to a line that was found belong to it, mm.
const OWN_MM: f64 = 1.2;
/// The steepest line, mm of depth a mm of width: just beyond the steepest slope that is looked for.
const STEEPEST: f64 = 2.4;

/// A line is cut where it turns up by more than this, rad, from what it is on one side to what it is on the other.
const CORNER: f64 = 0.6;
/// How long a side is, mm.
const SIDE_MM: f64 = 2.0;

/// A place that may be part of a line.
#[derive(Clone, Copy)]
struct Node {
    row: usize,
    /// What the best line that ends here is worth.
    worth: f64,
    /// Which of the beam before it comes from.
    from: Option<usize>,
    is_free: bool,
}

/// Lines as (first beam, the row in each beam), the best first.
///
/// The best sum of what places are worth over all lines through neighbouring beams, by dynamic programming; then
/// without
/// that one's places the next. A line may begin and end anywhere.
pub(super) fn lines(grid: &Grid, ridges: &Ridges, least_mm: f64, min_contrast: f64, shortest_mm: f64) -> Vec<Line> {
    let first = (least_mm / grid.step_mm).ceil() as usize;
    let mut nodes: Vec<Vec<Node>> = (0..grid.beams)
        .map(|beam| nodes(grid, ridges, beam, first, min_contrast))
        .collect();
    let shortest = (shortest_mm / grid.wide_mm).ceil() as usize;
    let own = (OWN_MM / grid.step_mm).round() as usize;
    let mut found = Vec::new();
    // Lines that are too short use a turn up as well, so that an image full of specks ends.
    for _ in 0..4 * MOST_LINES {
        let Some(line) = best(grid, ridges, &mut nodes, min_contrast) else {
            break;
        };
        for (beam, row) in (line.first..).zip(&line.rows) {
            for node in &mut nodes[beam] {
                node.is_free &= node.row.abs_diff(*row) > own;
            }
        }
        found.extend(
            pieces(line, grid)
                .into_iter()
                .filter(|piece| piece.rows.len() >= shortest),
        );
        if found.len() >= MOST_LINES {
            break;
        }
    }
    found
}

/// A line: in which beam it begins, and its row there and in each beam after it.
pub(super) struct Line {
    pub(super) first: usize,
    pub(super) rows: Vec<usize>,
}

/// A line, cut where it turns up sharply towards the probe: there a bone ends in the tissue behind it, or at another
/// one.
///
/// The other way it is not cut: a crest is sharp.
fn pieces(line: Line, grid: &Grid) -> Vec<Line> {
    let side = (SIDE_MM / grid.wide_mm).round().max(3.0) as usize;
    let turn = |i: usize| {
        let angle = |rows: &[usize]| (slope(rows) * grid.step_mm / grid.wide_mm).atan();
        angle(&line.rows[i..=i + side]) - angle(&line.rows[i - side..=i])
    };
    let turns: Vec<f64> = (0..line.rows.len())
        .map(|i| {
            if i >= side && i + side < line.rows.len() {
                turn(i)
            } else {
                0.0
            }
        })
        .collect();
    let is_corner = |i: usize| {
        let near = &turns[i.saturating_sub(side)..(i + side + 1).min(turns.len())];
        turns[i] < -CORNER && near.iter().all(|other| turns[i] <= *other)
    };
    let mut cuts: Vec<usize> = (0..line.rows.len()).filter(|i| is_corner(*i)).collect();
    cuts.push(line.rows.len());
    let mut from = 0;
    let cut = cuts.into_iter().map(|to| {
        let piece = Line {
            first: line.first + from,
            rows: line.rows[from..to].to_vec(),
        };
        from = to;
        piece
    });
    cut.collect()
}

/// The slope of the straight line through rows of neighbouring beams, samples a beam.
fn slope(rows: &[usize]) -> f64 {
    let middle = 0.5 * (rows.len() as f64 - 1.0);
    let (mut up, mut down) = (0.0, 0.0);
    for (i, row) in rows.iter().enumerate() {
        let x = i as f64 - middle;
        up += x * *row as f64;
        down += x * x;
    }
    if down > 0.0 { up / down } else { 0.0 }
}

fn nodes(grid: &Grid, ridges: &Ridges, beam: usize, first: usize, min_contrast: f64) -> Vec<Node> {
    let contrast = &ridges.contrast[beam * grid.depths..(beam + 1) * grid.depths];
    let least = LEAST_SHARE * min_contrast as f32;
    // The flanks of a ridge are left to it: only what is near a top can be its line.
    let is_top = |row: usize| {
        let near = &contrast[row.saturating_sub(2)..(row + 3).min(grid.depths)];
        near.iter().all(|other| *other <= contrast[row] * 1.15)
    };
    (first..grid.depths)
        .filter(|row| contrast[*row] >= least && is_top(*row))
        .map(|row| Node {
            row,
            worth: 0.0,
            from: None,
            is_free: true,
        })
        .collect()
}

/// The best line among the nodes that are free; `None` where no place is worth anything.
fn best(grid: &Grid, ridges: &Ridges, nodes: &mut [Vec<Node>], min_contrast: f64) -> Option<Line> {
    let reach = (STEEPEST * grid.wide_mm / grid.step_mm).ceil() as usize;
    let gain = |beam: usize, row: usize| {
        let contrast = f64::from(ridges.contrast[beam * grid.depths + row]);
        (contrast / min_contrast - 1.0).min(BEST) * grid.wide_mm
    };
    let (mut end, mut most) = (None, 0.0);
    for beam in 0..nodes.len() {
        let (before, rest) = nodes.split_at_mut(beam);
        let before = before.last().map_or(&[][..], Vec::as_slice);
        let mut low = 0;
        for (index, node) in rest[0].iter_mut().enumerate().filter(|(_, node)| node.is_free) {
            (node.worth, node.from) = (0.0, None);
            while low < before.len() && before[low].row + reach < node.row {
                low += 1;
            }
            let here = ridges.slope(beam * grid.depths + node.row);
            let near = before
                .iter()
                .enumerate()
                .skip(low)
                .take_while(|(_, other)| other.row <= node.row + reach);
            for (which, other) in near.filter(|(_, other)| other.is_free) {
                let slope = (node.row as f64 - other.row as f64) * grid.step_mm / grid.wide_mm;
                let expected = 0.5 * (here + ridges.slope((beam - 1) * grid.depths + other.row));
                let worth = other.worth - BEND * (slope - expected).powi(2) * grid.wide_mm;
                if worth > node.worth {
                    (node.worth, node.from) = (worth, Some(which));
                }
            }
            node.worth += gain(beam, node.row);
            if node.worth > most {
                (end, most) = (Some((beam, index)), node.worth);
            }
        }
    }
    let (mut beam, index) = end?;
    let mut node = nodes[beam][index];
    let mut rows = vec![node.row];
    while let Some(from) = node.from {
        beam -= 1;
        node = nodes[beam][from];
        rows.push(node.row);
    }
    rows.reverse();
    Some(Line { first: beam, rows })
}
