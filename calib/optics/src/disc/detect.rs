//! All discs of an image: the criterion at every pixel and several radii, its local maxima, the best radius of each.

use super::chi::{Chi, Probe};
use super::error::DetectRefused;
use crate::image::{Image, Sums};

/// The most candidates that are returned, the most significant first.
pub const MAX_DISCS: usize = 4096;
/// Steps between the radii that are tried.
const RADIUS_FACTOR: f64 = 1.3;
/// The local-maximum window is never smaller, pixels: at 1 px every pixel is its own maximum.
const MIN_WINDOW: f64 = 2.5;

/// Which discs are looked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Polarity {
    /// Darker than their surroundings.
    Dark,
    /// Brighter.
    Bright,
    /// Either.
    Both,
}

/// What is looked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DetectOptions {
    /// The least and the greatest radius, pixels.
    pub radii: [f64; 2],
    /// Dark, bright or both.
    pub polarity: Polarity,
    /// The criterion must exceed its mean over the image by so many of its deviations (5.4: 5).
    pub deviations: f64,
    /// And be at least so great: 1 is a contrast of one and a half deviations of the noise.
    pub least: f64,
    /// Discs of less than this share of the median contrast of all that are found are left out: specks of texture beside
    /// printed dots. 0 leaves none out.
    pub share: f64,
}

impl DetectOptions {
    /// Dark discs with the threshold of 5.4, however faint beside the others.
    pub fn new(least: f64, greatest: f64) -> Self {
        Self {
            radii: [least, greatest],
            polarity: Polarity::Dark,
            deviations: 5.0,
            least: 1.0,
            share: 0.0,
        }
    }
}

/// A disc to within a pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Disc {
    /// The pixel, column and row.
    pub at: [usize; 2],
    /// Estimated from the light it takes away, pixels.
    pub radius: f64,
    /// The criterion.
    pub chi: Chi,
}

/// The discs of an image, the most significant first.
///
/// Every radius of a ladder costs the same (regions of at most 9 rectangles over exact integral images). A candidate is
/// the greatest within 0.7 radii, at least 2.5 px; of equal ones the first row by row counts. Of candidates of different
/// radii within a radius of each other the most significant is kept, and those too faint beside the others are left out
/// ([`DetectOptions::share`]). At most [`MAX_DISCS`].
///
/// # Errors
/// [`DetectRefused`]: options that are no interval, or an image that holds not one such disc.
pub fn detect(image: &Image, options: &DetectOptions) -> Result<Vec<Disc>, DetectRefused> {
    let [least, greatest] = options.radii;
    if !(least >= 1.0 && least <= greatest && greatest <= 200.0) {
        return Err(DetectRefused::BadRadii { least, greatest });
    }
    let (width, height) = (image.width(), image.height());
    let needed = 2 * (1.25 * least + 1.0).ceil() as usize + 1;
    if width.min(height) < needed {
        return Err(DetectRefused::TooSmall {
            width,
            height,
            radius: least,
            needed,
        });
    }
    let sums = Sums::new(image);
    let mut discs = Vec::new();
    let rungs = ((greatest / least).ln() / RADIUS_FACTOR.ln()).ceil() as i32;
    for k in 0..=rungs {
        // The last rung is the greatest radius itself, however near the one before.
        let radius = (least * RADIUS_FACTOR.powi(k)).min(greatest);
        discs.extend(of_radius(&sums, radius, options)?);
    }
    discs.sort_by(|a: &Disc, b: &Disc| b.chi.significance.abs().total_cmp(&a.chi.significance.abs()));
    Ok(outstanding(strongest(discs), options.share))
}

/// Those that are not faint beside the others.
fn outstanding(mut discs: Vec<Disc>, share: f64) -> Vec<Disc> {
    let contrast = |disc: &Disc| (disc.chi.means[1] - disc.chi.means[0]).abs();
    let mut all: Vec<f64> = discs.iter().map(contrast).collect();
    all.sort_by(f64::total_cmp);
    let median = all.get(all.len() / 2).copied().unwrap_or(0.0);
    discs.retain(|disc| contrast(disc) >= share * median);
    discs
}

fn of_radius(sums: &Sums, radius: f64, options: &DetectOptions) -> Result<Vec<Disc>, DetectRefused> {
    let probe = Probe::about(radius)?;
    let (width, height) = (sums.width(), sums.height());
    let mut map = vec![0.0_f32; width * height];
    for (y, row) in map.chunks_exact_mut(width).enumerate() {
        for (x, out) in row.iter_mut().enumerate() {
            let chi = probe.at(sums, x, y).map_or(0.0, |chi| chi.value);
            *out = match options.polarity {
                Polarity::Dark => chi,
                Polarity::Bright => -chi,
                Polarity::Both => chi.abs(),
            } as f32;
        }
    }
    let threshold = threshold(&map, options);
    // Two discs of this radius cannot be nearer than that: the lesser maximum is the same disc.
    let window = (0.7 * radius).max(MIN_WINDOW);
    let mut found = Vec::new();
    for (i, value) in map.iter().enumerate() {
        let at = [i % width, i / width];
        if *value > threshold && is_greatest(&map, width, at, window) {
            let chi = probe.at(sums, at[0], at[1]);
            found.extend(chi.map(|chi| Disc {
                at,
                radius: probe.radius(sums, at[0], at[1], &chi),
                chi,
            }));
        }
    }
    Ok(found)
}

/// 5.4: the mean of the criterion over the image and so many deviations more.
fn threshold(map: &[f32], options: &DetectOptions) -> f32 {
    let n = map.len() as f64;
    let mean = map.iter().map(|v| f64::from(*v)).sum::<f64>() / n;
    let variance = map.iter().map(|v| (f64::from(*v) - mean).powi(2)).sum::<f64>() / n;
    (mean + options.deviations * variance.sqrt()).max(options.least) as f32
}

/// Nothing within `reach` is greater, and nothing equal comes before.
fn is_greatest(map: &[f32], width: usize, [x, y]: [usize; 2], reach: f64) -> bool {
    let here = map[y * width + x];
    let (r, height) = (reach.floor() as usize, map.len() / width);
    for j in y.saturating_sub(r)..(y + r + 1).min(height) {
        let dy = j.abs_diff(y) as f64;
        let half = (reach * reach - dy * dy).max(0.0).sqrt() as usize;
        let (first, last) = (x.saturating_sub(half), (x + half + 1).min(width));
        let row = &map[j * width + first..j * width + last];
        let before = |i: usize| (j, first + i) < (y, x);
        if row
            .iter()
            .enumerate()
            .any(|(i, v)| *v > here || (*v == here && before(i)))
        {
            return false;
        }
    }
    true
}

/// Leaves out what lies within the radius of something more significant.
fn strongest(discs: Vec<Disc>) -> Vec<Disc> {
    let mut kept: Vec<Disc> = Vec::new();
    for disc in discs {
        let near = |other: &Disc| {
            let d = [0, 1].map(|k| disc.at[k].abs_diff(other.at[k]) as f64);
            d[0].hypot(d[1]) < other.radius.max(disc.radius).max(MIN_WINDOW)
        };
        if !kept.iter().any(near) {
            kept.push(disc);
        }
        if kept.len() == MAX_DISCS {
            break;
        }
    }
    kept
}
