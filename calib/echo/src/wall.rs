//! The line of a flat wall: the bottom of a tank, a taut membrane.
//!
//! The image is cut into upright strips; each has its echoes, the summits of its mean grey over the rows. Every two of
//! them are a line, and the echoes beside it are its support (a Hough transform over pairs: the same image gives the
//! same line). Sound that goes to and fro shows the wall again below itself: of parallel lines that are strong, the
//! uppermost is the wall. Its row in each strip is the middle of the echo above half of its height, and the line is
//! fitted with Tukey's biweight.

mod fit;

use crate::grey::{Grey, background, blurred};
use fit::Fit;

/// What a wall is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WallOptions {
    /// Upright strips that the image is cut into, 8 to 128.
    pub strips: usize,
    /// The blur that is looked at, deviations along rows and along columns, pixels.
    pub blur_px: [f64; 2],
    /// The least height of an echo above the background, grey values.
    pub least_grey: f64,
    /// The same in deviations of the background's noise.
    pub least_noise: f64,
    /// How far an echo may lie from the line, pixels.
    pub most_off_px: f64,
    /// The steepest line: rows a column.
    pub most_slope: f64,
    /// The least share of the strips that must show the line.
    pub least_share: f64,
    /// A line above the strongest is the wall where it has this share of its support.
    pub first_share: f64,
}

impl Default for WallOptions {
    fn default() -> Self {
        Self {
            strips: 32,
            blur_px: [3.0, 1.5],
            least_grey: 16.0,
            least_noise: 6.0,
            most_off_px: 4.0,
            most_slope: 1.0,
            least_share: 0.5,
            first_share: 0.5,
        }
    }
}

/// A place on the wall.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WallPoint {
    /// (u, v), pixels.
    pub px: [f64; 2],
    /// Standard deviation of v, pixels: by how far the strips about it lie from the line.
    pub sigma_px: f64,
}

/// The line of a wall.
#[derive(Debug, Clone, PartialEq)]
pub struct Wall {
    /// Places on it, from left to right, as they were measured and not on the fitted line.
    pub points: Vec<WallPoint>,
    /// Its row at the middle column of the region, and the standard deviation, pixels.
    pub row: [f64; 2],
    /// Rows a column.
    pub slope: f64,
    /// The share of the strips that show it.
    pub share: f64,
    /// Deviation of the strips' rows about the line, pixels.
    pub off_px: f64,
}

/// Why an image shows no wall.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum WallError {
    /// A number that cannot be.
    #[error("{found} strips of an image {columns} pixels wide; 8 to 128 of 4 pixels or more are allowed")]
    Strips {
        /// As given.
        found: usize,
        /// Columns of the region.
        columns: usize,
    },
    /// No line has enough strips.
    #[error("{} of {strips} strips show the best line; {least} must", .found)]
    NoLine {
        /// Strips that show the best one.
        found: usize,
        /// Strips of the image.
        strips: usize,
        /// As bounded.
        least: usize,
    },
}

/// The most echoes of a strip that are looked at, the highest ones.
const MOST_ECHOES: usize = 6;
/// Strips that make one point.
const STRIPS_A_POINT: usize = 4;

/// An echo of a strip.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Echo {
    row: f64,
    height: f64,
}

/// A line and what supports it.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Line {
    /// The row at column 0 of the region.
    at: f64,
    slope: f64,
    support: f64,
    strips: usize,
}

/// The line of the wall in an image.
///
/// # Errors
/// [`WallError`].
pub fn wall(grey: &Grey<'_>, options: &WallOptions) -> Result<Wall, WallError> {
    let size = grey.size();
    let columns = size[0];
    let strips = options.strips;
    if !(8..=128).contains(&strips) || columns < 4 * strips {
        return Err(WallError::Strips { found: strips, columns });
    }
    let soft = blurred(&grey.values(), size, options.blur_px);
    let (background, noise) = background(&soft);
    let least = (options.least_noise * noise).max(options.least_grey);
    let middles: Vec<f64> = (0..strips)
        .map(|k| 0.5 * (edge(k, strips, columns) + edge(k + 1, strips, columns)) as f64 - 0.5)
        .collect();
    let echoes: Vec<Vec<Echo>> = (0..strips)
        .map(|k| {
            let from_to = edge(k, strips, columns)..edge(k + 1, strips, columns);
            echoes(&profile(&soft, size, from_to, background), least)
        })
        .collect();
    let needed = (options.least_share * strips as f64).ceil() as usize;
    let line = chosen(&echoes, &middles, needed, options)?;
    measured(&line, &echoes, &middles, grey, needed, options)
}

/// The first column of a strip.
fn edge(strip: usize, strips: usize, columns: usize) -> usize {
    strip * columns / strips
}

/// The mean grey above the background of some columns, row by row.
fn profile(soft: &[f32], [columns, rows]: [usize; 2], from_to: std::ops::Range<usize>, background: f32) -> Vec<f64> {
    let count = from_to.len() as f64;
    let row = |v: usize| soft[v * columns + from_to.start..v * columns + from_to.end].iter();
    let mean = |v: usize| row(v).map(|value| f64::from(*value)).sum::<f64>() / count;
    (0..rows).map(|v| mean(v) - f64::from(background)).collect()
}

/// The summits of a profile, the highest first, each at the middle of what lies above half of it.
fn echoes(profile: &[f64], least: f64) -> Vec<Echo> {
    let mut found = Vec::new();
    for v in 1..profile.len() - 1 {
        let height = profile[v];
        // The first of equal ones, as saturated echoes are flat.
        if height < least || profile[v - 1] >= height || profile[v + 1] > height {
            continue;
        }
        let half = 0.5 * height;
        let up = (0..v).rev().take_while(|k| profile[*k] > half).last().unwrap_or(v);
        let down = (v + 1..profile.len())
            .take_while(|k| profile[*k] > half)
            .last()
            .unwrap_or(v);
        // A summit on the flank of a higher one is no echo of its own.
        if profile[up..=down].iter().any(|value| *value > height) {
            continue;
        }
        let (mut weight, mut moment) = (0.0, 0.0);
        for (k, value) in (up..).zip(&profile[up..=down]) {
            weight += value - half;
            moment += (value - half) * k as f64;
        }
        found.push(Echo {
            row: if weight > 0.0 { moment / weight } else { v as f64 },
            height,
        });
    }
    found.sort_by(|a, b| b.height.total_cmp(&a.height).then(a.row.total_cmp(&b.row)));
    found.truncate(MOST_ECHOES);
    found
}

/// The uppermost strong line.
fn chosen(echoes: &[Vec<Echo>], middles: &[f64], needed: usize, options: &WallOptions) -> Result<Line, WallError> {
    let strips = echoes.len();
    let mut lines = Vec::new();
    for j in 0..strips {
        // Two strips that are near one another tell no slope.
        for i in 0..(j + 1).saturating_sub(strips / 4) {
            for b in &echoes[j] {
                for a in &echoes[i] {
                    let slope = (b.row - a.row) / (middles[j] - middles[i]);
                    if slope.abs() <= options.most_slope {
                        lines.push(supported(a.row - slope * middles[i], slope, echoes, middles, options));
                    }
                }
            }
        }
    }
    let better = |a: &&Line, b: &&Line| a.support.total_cmp(&b.support).then(b.at.total_cmp(&a.at));
    let refused = |found| WallError::NoLine {
        found,
        strips,
        least: needed,
    };
    let most = lines.iter().map(|line| line.strips).max().unwrap_or(0);
    let shown = |line: &&Line| line.strips >= needed;
    let best = *lines.iter().filter(shown).max_by(better).ok_or_else(|| refused(most))?;
    let middle = 0.5 * (middles[0] + middles[strips - 1]);
    let row = |line: &Line| line.at + line.slope * middle;
    let (mut first, least) = (best, options.first_share * best.support);
    loop {
        // Parallel within what two echoes at the strips' ends may be off.
        let parallel = 4.0 * options.most_off_px / (middles[strips - 1] - middles[0]);
        let is_above = |line: &&Line| {
            line.support >= least
                && row(line) < row(&first) - 4.0 * options.most_off_px
                && (line.slope - first.slope).abs() <= parallel
        };
        match lines.iter().filter(shown).filter(is_above).max_by(better) {
            Some(line) => first = *line,
            None => return Ok(first),
        }
    }
}

/// A line with the heights of the echoes beside it.
fn supported(at: f64, slope: f64, echoes: &[Vec<Echo>], middles: &[f64], options: &WallOptions) -> Line {
    let mut line = Line {
        at,
        slope,
        support: 0.0,
        strips: 0,
    };
    for (echoes, middle) in echoes.iter().zip(middles) {
        if let Some((off, echo)) = nearest(echoes, at + slope * middle, options.most_off_px) {
            line.support += echo.height * (1.0 - (off / options.most_off_px).powi(2));
            line.strips += 1;
        }
    }
    line
}

/// The echo nearest to a row, within `most`, with how far it is.
fn nearest(echoes: &[Echo], row: f64, most: f64) -> Option<(f64, Echo)> {
    let off = echoes.iter().map(|echo| ((echo.row - row).abs(), *echo));
    off.filter(|(off, _)| *off <= most).min_by(|a, b| a.0.total_cmp(&b.0))
}

/// The fitted line and its points.
fn measured(
    line: &Line,
    echoes: &[Vec<Echo>],
    middles: &[f64],
    grey: &Grey<'_>,
    needed: usize,
    options: &WallOptions,
) -> Result<Wall, WallError> {
    let rows: Vec<Option<[f64; 2]>> = echoes
        .iter()
        .zip(middles)
        .map(|(echoes, u)| {
            // Twice as far as for the support: the line of two echoes is off by more than the fitted one.
            let near = nearest(echoes, line.at + line.slope * u, 2.0 * options.most_off_px);
            near.map(|(_, echo)| [*u, echo.row])
        })
        .collect();
    let places: Vec<[f64; 2]> = rows.iter().flatten().copied().collect();
    let fit = Fit::of(&places, options.most_off_px);
    let kept = |[u, v]: &[f64; 2]| (v - fit.row(*u)).abs() <= options.most_off_px;
    let count = places.iter().filter(|place| kept(place)).count();
    if count < needed {
        return Err(WallError::NoLine {
            found: count,
            strips: echoes.len(),
            least: needed,
        });
    }
    let [left, top] = grey.region().from.map(|x| x as f64);
    let points = rows.chunks(STRIPS_A_POINT).filter_map(|some| {
        let some: Vec<[f64; 2]> = some.iter().flatten().copied().filter(kept).collect();
        let count = some.len() as f64;
        let mean = |a: usize| some.iter().map(|place| place[a]).sum::<f64>() / count;
        (some.len() >= 2).then(|| WallPoint {
            px: [left + mean(0), top + mean(1)],
            sigma_px: (fit.off / count.sqrt()).hypot(0.05),
        })
    });
    let middle = 0.5 * (grey.size()[0] as f64 - 1.0);
    Ok(Wall {
        points: points.collect(),
        row: [top + fit.row(middle), fit.row_sigma(middle).hypot(0.05)],
        slope: fit.slope,
        share: count as f64 / echoes.len() as f64,
        off_px: fit.off,
    })
}
