//! Textures: those that egui hands over and this keeps, and images that are lent for a frame.

use std::collections::BTreeMap;

use egui::TextureId;
use egui::epaint::textures::{TextureFilter, TexturesDelta};
use egui::epaint::{Color32, ImageData, ImageDelta};

use super::Image;
use super::blend::{argb, opaque};

/// Bits behind the point of a texel's coordinate in [`bilinear`]: 255 levels times 2^-12 twice is an eighth of a level.
const FRACTION: u32 = 11;

/// What a texel is read from.
pub(crate) trait Texels {
    /// Columns and rows, at least 1 each.
    fn size(&self) -> [usize; 2];
    /// 0xAARRGGBB premultiplied; in bounds.
    fn texel(&self, x: usize, y: usize) -> u32;
    /// Interpolated between texels, or the nearest one.
    fn is_linear(&self) -> bool;
}

/// A texture of egui's.
#[derive(Debug)]
pub(crate) struct Texture {
    size: [usize; 2],
    /// 0xAARRGGBB, row by row.
    texels: Vec<u32>,
    is_linear: bool,
    version: u64,
}

impl Texture {
    /// Texels of row `y` from column `x` on.
    pub(crate) fn row(&self, x: usize, y: usize) -> &[u32] {
        let start = y * self.size[0];
        self.texels.get(start + x..start + self.size[0]).unwrap_or_default()
    }

    /// Overwrites the part at `at`; what would lie outside is left out.
    fn patch(&mut self, [x, y]: [usize; 2], [columns, rows]: [usize; 2], pixels: &[Color32]) {
        let fits = columns.min(self.size[0].saturating_sub(x));
        if fits == 0 {
            return;
        }
        for (i, from) in pixels.chunks_exact(columns).take(rows).enumerate() {
            let start = (y + i).saturating_mul(self.size[0]).saturating_add(x);
            let Some(to) = self.texels.get_mut(start..start.saturating_add(fits)) else {
                return;
            };
            to.iter_mut().zip(from).for_each(|(to, from)| *to = argb(*from));
        }
    }
}

impl Texels for Texture {
    fn size(&self) -> [usize; 2] {
        self.size
    }

    fn texel(&self, x: usize, y: usize) -> u32 {
        self.texels.get(y * self.size[0] + x).copied().unwrap_or_default()
    }

    fn is_linear(&self) -> bool {
        self.is_linear
    }
}

impl Texels for Image<'_> {
    fn size(&self) -> [usize; 2] {
        self.size.map(|n| n as usize)
    }

    fn texel(&self, x: usize, y: usize) -> u32 {
        let at = 4 * (y * self.size[0] as usize + x);
        let bytes = self.rgba.get(at..at + 4).and_then(|bytes| bytes.try_into().ok());
        opaque(bytes.unwrap_or_default())
    }

    fn is_linear(&self) -> bool {
        true
    }
}

/// What a mesh is painted with.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Source<'a> {
    /// Of egui's.
    Kept(&'a Texture),
    /// Lent for this frame, opaque.
    Lent(&'a Image<'a>),
}

impl Source<'_> {
    /// Numbers that are others whenever the texels of the same name are.
    pub(crate) fn stamp(&self) -> [u64; 2] {
        match self {
            Self::Kept(texture) => [texture.version, 0],
            Self::Lent(image) => [
                image.version,
                (u64::from(image.size[0]) << 32) | u64::from(image.size[1]),
            ],
        }
    }

    /// The colour at `uv`, parts of the texture's size.
    pub(crate) fn at(&self, uv: [f32; 2]) -> u32 {
        match self {
            Self::Kept(texture) => at(*texture, uv),
            Self::Lent(image) => at(*image, uv),
        }
    }
}

fn at(texels: &impl Texels, uv: [f32; 2]) -> u32 {
    // The corner is where egui keeps its white, for all that has no texture.
    if uv == [0.0; 2] {
        return texels.texel(0, 0);
    }
    let [columns, rows] = texels.size();
    let place = |uv: f32, count: usize| ((f64::from(uv) * count as f64 - 0.5) * 4_294_967_296.0) as i64;
    sample(texels, place(uv[0], columns), place(uv[1], rows))
}

/// The colour at a place in texels, with 32 bits behind the point; whole numbers are centres of texels. Clamped at the edges.
pub(crate) fn sample(texels: &impl Texels, u: i64, v: i64) -> u32 {
    let [columns, rows] = texels.size();
    if texels.is_linear() {
        return bilinear(texels, u, v);
    }
    let nearest = |place: i64, count: usize| {
        let whole = place.saturating_add(1 << 31) >> 32;
        whole.clamp(0, count as i64 - 1) as usize
    };
    texels.texel(nearest(u, columns), nearest(v, rows))
}

fn bilinear(texels: &impl Texels, u: i64, v: i64) -> u32 {
    let [columns, rows] = texels.size();
    let (x, right) = split(u, columns);
    let (y, down) = split(v, rows);
    let (next_x, next_y) = ((x + 1).min(columns - 1), (y + 1).min(rows - 1));
    let corners = [
        texels.texel(x, y),
        texels.texel(next_x, y),
        texels.texel(x, next_y),
        texels.texel(next_x, next_y),
    ];
    let one = 1_u32 << FRACTION;
    let weights = [
        (one - right) * (one - down),
        right * (one - down),
        (one - right) * down,
        right * down,
    ];
    let channel = |shift: u32| {
        let parts = corners.iter().zip(weights);
        let sum: u32 = parts.map(|(corner, weight)| ((corner >> shift) & 0xFF) * weight).sum();
        ((sum + (1 << (2 * FRACTION - 1))) >> (2 * FRACTION)) << shift
    };
    channel(24) | channel(16) | channel(8) | channel(0)
}

/// The texel at or before a place, and how far the place is towards the next one, of `1 << FRACTION`.
fn split(place: i64, count: usize) -> (usize, u32) {
    let rounded = place.saturating_add(1 << (31 - FRACTION)) >> (32 - FRACTION);
    let last = ((count - 1) as i64) << FRACTION;
    let inside = rounded.clamp(0, last);
    ((inside >> FRACTION) as usize, (inside & ((1 << FRACTION) - 1)) as u32)
}

/// The textures of egui's that are set.
#[derive(Debug, Default)]
pub(crate) struct Textures {
    kept: BTreeMap<TextureId, Texture>,
    versions: u64,
}

impl Textures {
    /// Sets what is new; what is to be freed stays until [`Self::free`].
    pub(crate) fn set(&mut self, delta: &TexturesDelta) {
        for (id, changes) in &delta.set {
            changes.iter().for_each(|change| self.change(*id, change));
        }
    }

    /// Frees what is not needed any more, and empties `delta`.
    pub(crate) fn free(&mut self, delta: &mut TexturesDelta) {
        for id in &delta.free {
            self.kept.remove(id);
        }
        delta.clear();
    }

    fn change(&mut self, id: TextureId, change: &ImageDelta) {
        self.versions += 1;
        let ImageData::Color(image) = &change.image;
        let is_linear = change.options.magnification == TextureFilter::Linear;
        let Some(at) = change.pos else {
            let texels = image.pixels.iter().map(|pixel| argb(*pixel)).collect();
            let texture = Texture {
                size: image.size,
                texels,
                is_linear,
                version: self.versions,
            };
            self.kept.insert(id, texture);
            return;
        };
        // A part of a texture that nobody set has no place to go to.
        if let Some(texture) = self.kept.get_mut(&id) {
            texture.patch(at, image.size, &image.pixels);
            texture.is_linear = is_linear;
            texture.version = self.versions;
        }
    }

    /// What `id` names; `None` for what nobody set, what is empty and what has another length than it says.
    pub(crate) fn find<'a>(&'a self, id: TextureId, images: &'a [Image<'a>]) -> Option<Source<'a>> {
        let (source, size, length) = match id {
            TextureId::Managed(_) => {
                let texture = self.kept.get(&id)?;
                (Source::Kept(texture), texture.size, texture.texels.len())
            }
            TextureId::User(number) => {
                let image = images.iter().find(|image| image.id == number)?;
                (Source::Lent(image), image.size(), image.rgba.len() / 4)
            }
        };
        let wanted = size[0].checked_mul(size[1])?;
        (wanted > 0 && length == wanted).then_some(source)
    }
}
