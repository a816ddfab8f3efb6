//! Straight lines with a dark rim, by the distance of pixels from them.
//!
//! What a pixel is covered by is the distance of its centre from the line's edge, 0 half a pixel outside and 1 half a pixel inside: exact
//! along rows and columns, elsewhere off by a tenth and a half at most. A pixel that several lines cover is covered by the one that covers
//! it most, so that joints and crossings are no darker than the rest. A path that is filled costs as much as it is tall and wide; this
//! costs as much as the lines are long.

use crate::palette::{self, Rgb};

/// What a pixel on the edge is further away than when it is not covered at all.
const SOFT: f64 = 0.5;
/// No line goes further, pixels.
const FAR: f64 = 1e5;

/// The lines drawn together, and the memory for them.
#[derive(Debug, Clone, Default)]
pub(crate) struct Strokes {
    /// Of each pixel: how much the rim covers it, and the line, of 255.
    cover: Vec<[u8; 2]>,
    /// Those that are covered.
    touched: Vec<u32>,
}

/// How wide the lines are, pixels.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Widths {
    pub(crate) line: f64,
    pub(crate) rim: f64,
}

/// How a line ends: round, or cut straight.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum End {
    Round,
    Straight,
}

/// A line from one point to another.
#[derive(Debug, Clone, Copy)]
struct Segment {
    from: [f64; 2],
    to: [f64; 2],
    ends: [End; 2],
}

impl Strokes {
    /// Takes in joined lines; `dashes` are dash, gap, dash, gap, pixels.
    pub(crate) fn add(
        &mut self,
        size: [u32; 2],
        points: &[[f64; 2]],
        (widths, end): (Widths, End),
        dashes: Option<[f32; 4]>,
    ) {
        let [width, height] = size.map(|n| n as usize);
        self.cover.resize(width * height, [0; 2]);
        if points.iter().flatten().any(|c| !c.is_finite()) {
            return;
        }
        match dashes.filter(|dashes| dashes.iter().all(|d| *d > 0.0)) {
            Some(dashes) => self.dashed(size, points, widths, dashes),
            None => {
                let last = points.len().saturating_sub(2);
                for (i, pair) in points.windows(2).enumerate() {
                    let [from, to] = near(pair);
                    let ends = [i == 0, i == last].map(|is_end| if is_end { end } else { End::Round });
                    self.segment(size, Segment { from, to, ends }, widths);
                }
            }
        }
    }

    /// Every second part of the lines, by their length from the first point; dashes go round corners.
    fn dashed(&mut self, size: [u32; 2], points: &[[f64; 2]], widths: Widths, dashes: [f32; 4]) {
        let (mut dash, mut left) = (0, f64::from(dashes[0]));
        let mut begins = End::Straight;
        for pair in points.windows(2) {
            let [from, to] = near(pair);
            let length = (to[0] - from[0]).hypot(to[1] - from[1]);
            let at = |s: f64| [0, 1].map(|k| from[k] + (to[k] - from[k]) * (s / length));
            let mut s = 0.0;
            while s < length {
                let until = (s + left).min(length);
                let is_whole = s + left <= length;
                if dash % 2 == 0 {
                    let ends = [begins, if is_whole { End::Straight } else { End::Round }];
                    let (from, to) = (at(s), at(until));
                    self.segment(size, Segment { from, to, ends }, widths);
                }
                begins = if is_whole { End::Straight } else { End::Round };
                left -= until - s;
                if is_whole {
                    dash = (dash + 1) % dashes.len();
                    left = f64::from(dashes[dash]);
                }
                s = until;
            }
        }
    }

    fn segment(&mut self, [width, height]: [u32; 2], segment: Segment, widths: Widths) {
        let (half, rim) = (widths.line / 2.0, widths.line / 2.0 + widths.rim);
        let reach = rim + SOFT;
        let Some(segment) = segment.within([f64::from(width), f64::from(height)], reach) else {
            return;
        };
        let ([ax, ay], [bx, by]) = (segment.from, segment.to);
        let length = (bx - ax).hypot(by - ay);
        // A point is round whichever way it goes, and nothing where it is cut straight.
        let [dx, dy] = if length > 0.0 {
            [(bx - ax) / length, (by - ay) / length]
        } else {
            [1.0, 0.0]
        };
        let rows = pixels(ay.min(by) - reach, ay.max(by) + reach, height);
        for y in rows {
            let fy = f64::from(y);
            // Where the row is nearer to the endless line than its reach.
            let (mut low, mut high) = (ax.min(bx) - reach, ax.max(bx) + reach);
            if dy.abs() > 1e-9 {
                let (middle, side) = (ax + dx * (fy - ay) / dy, reach / dy.abs());
                (low, high) = (low.max(middle - side), high.min(middle + side));
            }
            for x in pixels(low, high, width) {
                let [px, py] = [f64::from(x) - ax, fy - ay];
                let (along, across) = (px * dx + py * dy, (py * dx - px * dy).abs());
                let cover = |half: f64| segment.cover(along, across, length, half);
                let cover = [if widths.rim > 0.0 { cover(rim) } else { 0.0 }, cover(half)];
                self.touch((y * width + x) as usize, cover);
            }
        }
    }

    fn touch(&mut self, at: usize, cover: [f64; 2]) {
        let [rim, line] = cover.map(|part| (255.0 * part + 0.5) as u8);
        let before = &mut self.cover[at];
        if *before == [0; 2] && (rim, line) != (0, 0) {
            self.touched.push(at as u32);
        }
        *before = [before[0].max(rim), before[1].max(line)];
    }

    /// Puts all of it over the pixels, RGBA row by row: the rim first, and nothing is left of it here.
    pub(crate) fn paint(&mut self, rgba: &mut [u8], colour: Rgb) {
        for at in self.touched.drain(..) {
            let at = at as usize;
            let [rim, line] = std::mem::take(&mut self.cover[at]);
            let pixel = &mut rgba[4 * at..4 * at + 3];
            for (Rgb(r, g, b), cover) in [(palette::RIM, rim), (colour, line)] {
                for (channel, to) in pixel.iter_mut().zip([r, g, b]) {
                    let (from, part) = (u32::from(*channel), u32::from(cover));
                    *channel = ((from * (255 - part) + u32::from(to) * part + 127) / 255) as u8;
                }
            }
        }
    }
}

impl Segment {
    /// What of it may cover pixels of the image; an end that was outside ends nothing.
    fn within(self, [width, height]: [f64; 2], reach: f64) -> Option<Self> {
        let (mut low, mut high) = (0.0_f64, 1.0_f64);
        let way = [self.to[0] - self.from[0], self.to[1] - self.from[1]];
        for (k, most) in [width, height].into_iter().enumerate() {
            // Beyond twice the reach, so that straight ends stay outside too.
            let [a, b] = [-2.0 * reach - self.from[k], most + 2.0 * reach - self.from[k]];
            if way[k] == 0.0 {
                if a > 0.0 || b < 0.0 {
                    return None;
                }
                continue;
            }
            let [p, q] = [a / way[k], b / way[k]];
            (low, high) = (low.max(p.min(q)), high.min(p.max(q)));
        }
        let at = |s: f64| [0, 1].map(|k| self.from[k] + way[k] * s);
        (low <= high).then(|| Self {
            from: if low > 0.0 { at(low) } else { self.from },
            to: if high < 1.0 { at(high) } else { self.to },
            ends: self.ends,
        })
    }

    /// How much a pixel is covered that lies so far along and beside it, by a line of this half width; 0 to 1.
    fn cover(&self, along: f64, across: f64, length: f64, half: f64) -> f64 {
        let (over, end) = match along < length / 2.0 {
            true => (-along, self.ends[0]),
            false => (along - length, self.ends[1]),
        };
        // What of the pixel's width, across the line, lies within it.
        let inside = |d: f64| ((d + SOFT).min(half) - (d - SOFT).max(-half)).clamp(0.0, 1.0);
        match end {
            End::Round => inside(across.hypot(over.max(0.0))),
            End::Straight => inside(across).min((SOFT - over).clamp(0.0, 1.0)),
        }
    }
}

/// Two points after one another, pulled in where they are far: no sum of them overflows.
fn near(pair: &[[f64; 2]]) -> [[f64; 2]; 2] {
    [0, 1].map(|k| pair[k].map(|c| c.clamp(-FAR, FAR)))
}

/// The pixels whose centres lie between two places, of so many.
fn pixels(low: f64, high: f64, count: u32) -> std::ops::Range<u32> {
    let [first, end] = [low.ceil(), high.floor() + 1.0].map(|c| c.clamp(0.0, f64::from(count)) as u32);
    first..end.max(first)
}

#[cfg(test)]
mod tests;
