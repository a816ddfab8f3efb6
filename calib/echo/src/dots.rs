//! Bright dots of an image, each with its centre and the centre's error.
//!
//! The image is blurred a little and looked at from its brightest pixel down: each pixel joins the blob beside it, a
//! pixel without one begins a blob, and where two meet the lower one is part of the higher unless the way between
//! them dips (a watershed with a least dip: Vincent and Soille, 1991; Meyer, 1994). A blob's pixels above a share of
//! its own height are the dot; the centre is their mean.

use crate::grey::{Grey, background, blurred};

/// What a dot is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DotOptions {
    /// The blur that is looked at, deviations along rows and along columns, pixels.
    pub blur_px: [f64; 2],
    /// The least height above the background, grey values of the blurred image.
    pub least_grey: f64,
    /// The same in deviations of the background's noise.
    pub least_noise: f64,
    /// The share of a dot's height above the background from which on pixels belong to it.
    pub share: f64,
    /// Two dots are told apart where the grey between them is below this share of the lower one's height.
    pub dip: f64,
    /// The largest dot, columns and rows.
    pub most_px: [usize; 2],
    /// Grains of speckle: how far grey values vary together along rows and along columns, pixels.
    pub grain_px: [f64; 2],
    /// The most dots that are told, those with the most light.
    pub most: usize,
}

impl Default for DotOptions {
    /// For images of 400 to 1000 rows.
    fn default() -> Self {
        Self {
            blur_px: [3.0, 1.5],
            least_grey: 16.0,
            least_noise: 6.0,
            share: 0.25,
            dip: 0.7,
            most_px: [100, 50],
            grain_px: [6.0, 3.0],
            most: 24,
        }
    }
}

/// A bright dot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dot {
    /// Its centre (u, v), pixels.
    pub px: [f64; 2],
    /// Standard deviations of the centre along rows and along columns, pixels: what the grain of speckle in a dot of
    /// this size moves its centre by, more where it touches another or the border.
    pub sigma_px: [f64; 2],
    /// Its height above the background, grey values of the blurred image.
    pub height: f64,
    /// Its pixels.
    pub area: usize,
    /// Whether it goes over into another dot or reaches the border of the region.
    pub is_cut: bool,
}

/// The dots of an image, those with the most light first.
#[must_use]
pub fn dots(grey: &Grey<'_>, options: &DotOptions) -> Vec<Dot> {
    let size = grey.size();
    let raw = grey.values();
    let soft = blurred(&raw, size, options.blur_px);
    let (background, noise) = background(&soft);
    let least = background + (options.least_noise * noise).max(options.least_grey) as f32;
    let blobs = blobs(&soft, size, background, least, options);
    let origin = grey.region().from;
    let mut found: Vec<(f64, Dot)> = blobs
        .iter()
        .filter_map(|blob| dot(blob, [&raw, &soft], size, background, origin, options))
        .collect();
    // By light, then by place, so that equal ones have one order.
    found.sort_by(|(a, p), (b, q)| {
        b.total_cmp(a)
            .then(p.px[1].total_cmp(&q.px[1]))
            .then(p.px[0].total_cmp(&q.px[0]))
    });
    found.truncate(options.most);
    found.into_iter().map(|(_, dot)| dot).collect()
}

/// A connected part of the blurred image about one summit.
#[derive(Debug, Clone, Default)]
struct Blob {
    peak: f32,
    /// Pixels, from the brightest down.
    pixels: Vec<u32>,
    /// The highest grey at which it meets another that stayed apart.
    meets: f32,
}

const NONE: u32 = u32::MAX;

fn blobs(soft: &[f32], size: [usize; 2], background: f32, least: f32, options: &DotOptions) -> Vec<Blob> {
    // A dot's foot lies at a share of its height, which is below the least height of its summit.
    let foot = background + (least - background) * options.share as f32;
    let mut order: Vec<u32> = (0..soft.len() as u32).filter(|i| soft[*i as usize] > foot).collect();
    order.sort_by(|a, b| soft[*b as usize].total_cmp(&soft[*a as usize]).then(a.cmp(b)));
    let mut of = vec![NONE; soft.len()];
    let mut blobs: Vec<Blob> = Vec::new();
    let mut parent: Vec<u32> = Vec::new();
    for pixel in order {
        let value = soft[pixel as usize];
        let mut near: Vec<u32> = neighbours(pixel, size)
            .filter(|i| of[*i as usize] != NONE)
            .map(|i| root(&mut parent, of[i as usize]))
            .collect();
        near.sort_unstable();
        near.dedup();
        // Blobs are numbered from the highest summit down.
        let Some((&home, others)) = near.split_first() else {
            of[pixel as usize] = blobs.len() as u32;
            parent.push(blobs.len() as u32);
            blobs.push(Blob {
                peak: value,
                pixels: vec![pixel],
                meets: background,
            });
            continue;
        };
        for &other in others {
            let height = blobs[other as usize].peak - background;
            if value - background >= options.dip as f32 * height {
                let joined = std::mem::take(&mut blobs[other as usize]);
                blobs[home as usize].meets = blobs[home as usize].meets.max(joined.meets);
                blobs[home as usize].pixels.extend(joined.pixels);
                parent[other as usize] = home;
            } else {
                for blob in [home, other] {
                    blobs[blob as usize].meets = blobs[blob as usize].meets.max(value);
                }
            }
        }
        of[pixel as usize] = home;
        blobs[home as usize].pixels.push(pixel);
    }
    blobs
        .into_iter()
        .filter(|blob| blob.peak >= least && !blob.pixels.is_empty())
        .collect()
}

fn root(parent: &mut [u32], mut blob: u32) -> u32 {
    while parent[blob as usize] != blob {
        parent[blob as usize] = parent[parent[blob as usize] as usize];
        blob = parent[blob as usize];
    }
    blob
}

/// The eight pixels about one.
fn neighbours(pixel: u32, [columns, rows]: [usize; 2]) -> impl Iterator<Item = u32> {
    let (u, v) = (i64::from(pixel) % columns as i64, i64::from(pixel) / columns as i64);
    let around = (-1..=1).flat_map(|dv| (-1..=1).map(move |du| (du, dv)));
    around.filter_map(move |(du, dv)| {
        let (x, y) = (u + du, v + dv);
        let is_inside = (du, dv) != (0, 0) && (0..columns as i64).contains(&x) && (0..rows as i64).contains(&y);
        is_inside.then_some((y * columns as i64 + x) as u32)
    })
}

/// The dot of a blob with its light; `None` where it is larger than a dot.
fn dot(
    blob: &Blob,
    [raw, soft]: [&[f32]; 2],
    [columns, rows]: [usize; 2],
    background: f32,
    origin: [usize; 2],
    options: &DotOptions,
) -> Option<(f64, Dot)> {
    let height = blob.peak - background;
    let level = background + options.share as f32 * height;
    let mut sums = Sums::default();
    let (mut low, mut high) = ([usize::MAX; 2], [0; 2]);
    for &pixel in &blob.pixels {
        let at = [pixel as usize % columns, pixel as usize / columns];
        if soft[pixel as usize] <= level {
            continue;
        }
        for a in 0..2 {
            low[a] = low[a].min(at[a]);
            high[a] = high[a].max(at[a]);
        }
        sums.add(at.map(|x| x as f64), f64::from(raw[pixel as usize] - background));
    }
    if sums.count == 0.0 || (0..2).any(|a| high[a] - low[a] >= options.most_px[a]) {
        return None;
    }
    let is_at_border = low.contains(&0) || high[0] + 1 == columns || high[1] + 1 == rows;
    let is_cut = is_at_border || blob.meets > level;
    let (centre, spread) = sums.result();
    // Grains of fully developed speckle vary as much as their mean, log compressed ones less (0.52 of it): a mean over
    // n of them moves by the dot's own spread over the root of n.
    let grain = options.grain_px[0] * options.grain_px[1];
    let grains = (sums.count / grain).max(1.0);
    let sigma = [0, 1].map(|a| {
        let moved = 0.52 * spread[a] / grains.sqrt();
        // What a cut takes away shifts the centre by up to its spread.
        let cut = if is_cut { spread[a] } else { 0.0 };
        moved.hypot(cut).hypot(0.1)
    });
    Some((
        sums.weight,
        Dot {
            px: [0, 1].map(|a| centre[a] + origin[a] as f64),
            sigma_px: sigma,
            height: f64::from(height),
            area: sums.count as usize,
            is_cut,
        },
    ))
}

/// Sums over pixels.
#[derive(Debug, Default)]
struct Sums {
    count: f64,
    weight: f64,
    first: [f64; 2],
    second: [f64; 2],
}

impl Sums {
    fn add(&mut self, at: [f64; 2], weight: f64) {
        self.count += 1.0;
        self.weight += weight;
        for (a, x) in at.into_iter().enumerate() {
            self.first[a] += x;
            self.second[a] += x * x;
        }
    }

    /// Mean and spread. Pixels count alike: by their light the mean would follow single bright grains.
    fn result(&self) -> ([f64; 2], [f64; 2]) {
        let mean = self.first.map(|sum| sum / self.count);
        let spread = [0, 1].map(|a| (self.second[a] / self.count - mean[a] * mean[a]).max(0.0).sqrt());
        (mean, spread)
    }
}
