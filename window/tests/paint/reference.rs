//! A slow painter in `f64` that knows triangles only. It follows the rule of sampling in its own words: corners on a grid of
//! 1/256 pixel, a pixel inside where its centre is, upper and left sides included, eight bits a channel after each triangle.

use std::collections::BTreeMap;

use egui::epaint::textures::{TextureFilter, TexturesDelta};
use egui::epaint::{ClippedPrimitive, ImageData, Mesh, Primitive, Vertex};
use egui::{Color32, TextureId};
use window::paint::Image;

/// Channels 0 to 255: red, green, blue, alpha.
type Colour = [f64; 4];

#[derive(Debug, Clone)]
struct Texture {
    size: [usize; 2],
    texels: Vec<Colour>,
    is_linear: bool,
}

fn colour(colour: Color32) -> Colour {
    colour.to_array().map(f64::from)
}

impl Texture {
    fn clamped(&self, x: f64, y: f64) -> Colour {
        let inside = |v: f64, count: usize| v.clamp(0.0, (count - 1) as f64) as usize;
        self.texels[inside(y, self.size[1]) * self.size[0] + inside(x, self.size[0])]
    }

    fn at(&self, uv: [f64; 2]) -> Colour {
        let [x, y] = [uv[0] * self.size[0] as f64, uv[1] * self.size[1] as f64];
        if !self.is_linear {
            return self.clamped(x.floor(), y.floor());
        }
        let (x, y) = (x - 0.5, y - 0.5);
        let (left, top) = (x.floor(), y.floor());
        let (right, down) = (x - left, y - top);
        let corner = |dx: f64, dy: f64| self.clamped(left + dx, top + dy);
        let [a, b, c, d] = [corner(0.0, 0.0), corner(1.0, 0.0), corner(0.0, 1.0), corner(1.0, 1.0)];
        std::array::from_fn(|i| {
            (a[i] * (1.0 - right) + b[i] * right) * (1.0 - down) + (c[i] * (1.0 - right) + d[i] * right) * down
        })
    }
}

/// The painter.
#[derive(Debug, Default)]
pub(crate) struct Reference {
    textures: BTreeMap<TextureId, Texture>,
}

impl Reference {
    /// Sets what is new; frees nothing.
    pub(crate) fn set(&mut self, delta: &TexturesDelta) {
        for (id, changes) in &delta.set {
            for change in changes {
                let ImageData::Color(image) = &change.image;
                let whole = || Texture {
                    size: image.size,
                    texels: image.pixels.iter().map(|pixel| colour(*pixel)).collect(),
                    is_linear: change.options.magnification == TextureFilter::Linear,
                };
                let Some([x, y]) = change.pos else {
                    self.textures.insert(*id, whole());
                    continue;
                };
                let texture = self.textures.get_mut(id).expect("a part of a texture that is there");
                for (i, pixel) in image.pixels.iter().enumerate() {
                    let (row, column) = (y + i / image.size[0], x + i % image.size[0]);
                    texture.texels[row * texture.size[0] + column] = colour(*pixel);
                }
            }
        }
    }

    /// Takes an image as it is now.
    pub(crate) fn lend(&mut self, image: &Image<'_>) {
        let texel = |p: &[u8]| [p[0], p[1], p[2], 255].map(f64::from);
        let texture = Texture {
            size: image.size.map(|n| n as usize),
            texels: image.rgba.chunks_exact(4).map(texel).collect(),
            is_linear: true,
        };
        self.textures.insert(TextureId::User(image.id), texture);
    }

    /// Levels of red, green and blue for each pixel, each a whole number.
    pub(crate) fn paint(
        &self,
        size: [u32; 2],
        pixels_per_point: f32,
        clear: Color32,
        primitives: &[ClippedPrimitive],
    ) -> Vec<[f64; 3]> {
        let [columns, rows] = size.map(|n| n as usize);
        let [r, g, b, _] = colour(clear);
        let mut screen = vec![[r, g, b]; columns * rows];
        for clipped in primitives {
            let Primitive::Mesh(mesh) = &clipped.primitive else {
                continue;
            };
            let side =
                |v: f32, count: usize| f64::from((v * pixels_per_point).round()).clamp(0.0, count as f64) as usize;
            let (min, max) = (clipped.clip_rect.min, clipped.clip_rect.max);
            let clip = [
                side(min.x, columns),
                side(min.y, rows),
                side(max.x, columns),
                side(max.y, rows),
            ];
            self.mesh(&mut screen, columns, clip, pixels_per_point, mesh);
        }
        screen
    }

    fn mesh(&self, screen: &mut [[f64; 3]], columns: usize, clip: [usize; 4], pixels_per_point: f32, mesh: &Mesh) {
        let texture = &self.textures[&mesh.texture_id];
        for three in mesh.indices.chunks_exact(3) {
            let mut three = [three[0], three[1], three[2]].map(|i| mesh.vertices[i as usize]);
            let snap = |v: f32| (f64::from(v) * f64::from(pixels_per_point) * 256.0).round() / 256.0;
            let at = |vertex: &Vertex| [snap(vertex.pos.x), snap(vertex.pos.y)];
            if side(at(&three[0]), at(&three[1]), at(&three[2])) < 0.0 {
                three.swap(1, 2);
            }
            let corners = [at(&three[0]), at(&three[1]), at(&three[2])];
            let whole = side(corners[0], corners[1], corners[2]);
            if whole == 0.0 {
                continue;
            }
            let low = |axis: usize| corners.iter().map(|c| c[axis]).fold(f64::INFINITY, f64::min).max(0.0) as usize;
            let high = |axis: usize| corners.iter().map(|c| c[axis]).fold(0.0, f64::max).ceil() as usize;
            for y in low(1).max(clip[1])..high(1).min(clip[3]) {
                for x in low(0).max(clip[0])..high(0).min(clip[2]) {
                    let middle = [x as f64 + 0.5, y as f64 + 0.5];
                    if let Some(parts) = inside(&corners, middle) {
                        let source = mixed(texture, &three, parts.map(|part| part / whole));
                        blend(&mut screen[y * columns + x], source);
                    }
                }
            }
        }
    }
}

/// Twice the area of a triangle, positive where it turns clockwise on the screen.
fn side(a: [f64; 2], b: [f64; 2], p: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])
}

/// Twice the areas opposite to the corners, for a point that belongs to the triangle.
fn inside(corners: &[[f64; 2]; 3], p: [f64; 2]) -> Option<[f64; 3]> {
    let mut parts = [0.0; 3];
    for i in 0..3 {
        let (a, b) = (corners[(i + 1) % 3], corners[(i + 2) % 3]);
        parts[i] = side(a, b, p);
        let is_left = b[1] < a[1];
        let is_upper = b[1] == a[1] && b[0] > a[0];
        if parts[i] < 0.0 || (parts[i] == 0.0 && !is_left && !is_upper) {
            return None;
        }
    }
    Some(parts)
}

fn mixed(texture: &Texture, three: &[Vertex; 3], parts: [f64; 3]) -> Colour {
    let sum = |value: &dyn Fn(&Vertex) -> f64| three.iter().zip(parts).map(|(v, part)| value(v) * part).sum::<f64>();
    let uv = [sum(&|v| f64::from(v.uv.x)), sum(&|v| f64::from(v.uv.y))];
    let same = three.iter().all(|vertex| vertex.uv == three[0].uv);
    // A sum of parts would lose the corner where the white is.
    let texel = texture.at(if same {
        [three[0].uv.x, three[0].uv.y].map(f64::from)
    } else {
        uv
    });
    std::array::from_fn(|i| sum(&|v| f64::from(v.color.to_array()[i])) * texel[i] / 255.0)
}

fn blend(pixel: &mut [f64; 3], source: Colour) {
    for (below, source_level) in pixel.iter_mut().zip(source) {
        *below = (source_level + *below * (1.0 - source[3] / 255.0))
            .round()
            .clamp(0.0, 255.0);
    }
}

/// The largest difference of a level between what was painted and the reference.
pub(crate) fn difference(pixels: &[u32], reference: &[[f64; 3]]) -> f64 {
    assert_eq!(pixels.len(), reference.len());
    let worst = pixels.iter().zip(reference).map(|(pixel, levels)| {
        let [_, r, g, b] = pixel.to_be_bytes().map(f64::from);
        [r, g, b]
            .iter()
            .zip(levels)
            .map(|(a, b)| (a - b).abs())
            .fold(0.0, f64::max)
    });
    worst.fold(0.0, f64::max)
}
