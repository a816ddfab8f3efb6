//! Ultrasound images made by geometry alone: scatterers along beams, blurred by a pulse and a beam, in decibels.
//!
//! Shares nothing with the project's simulator: other physics would be other errors.

use chance::Chance;
use ultrasound::{Beams, Image, Shape};

/// From sample to sample along a beam, mm.
const STEP_MM: f64 = 0.05;
/// Beams.
const BEAMS: usize = 240;
/// Levels: 60 dB over 255.
const PER_DB: f64 = 255.0 / 60.0;
/// Two waves' worth of phase a mm there and back, at 7 MHz.
const PHASE: f64 = 4.0 * std::f64::consts::PI / 0.22;

/// A depth of a share of the beams, mm.
pub(crate) type Depth<'a> = dyn Fn(f64) -> Option<f64> + 'a;

/// What is imaged. Depths are mm of a share of the beams, `None` where there is nothing.
pub(crate) struct Scene<'a> {
    pub(crate) seed: u64,
    pub(crate) bone: &'a Depth<'a>,
    /// Depth and amplitude, bone having 40 and the tissue's speckle 1.
    pub(crate) fascias: &'a [(&'a Depth<'a>, f64)],
    /// dB a mm that the time gain leaves.
    pub(crate) fade: f64,
    /// Grey of the tissue at the face.
    pub(crate) tissue: f64,
    /// Grey of the receiver's noise.
    pub(crate) noise: f64,
    /// Strength of echoes that go to and fro, as a share of the bone's.
    pub(crate) reverberation: f64,
    /// Below that depth the tissue scatters less, by so many dB.
    pub(crate) layer: Option<(f64, f64)>,
}

pub(crate) const NOTHING: &Depth<'static> = &|_| None;

impl Default for Scene<'_> {
    fn default() -> Self {
        Self {
            seed: 1,
            bone: NOTHING,
            fascias: &[],
            fade: 0.15,
            tissue: 75.0,
            noise: -60.0,
            reverberation: 0.03,
            layer: None,
        }
    }
}

pub(crate) fn linear() -> Shape {
    let beams = Beams::Linear {
        from_mm: 3.0,
        to_mm: 41.0,
        face_mm: 1.0,
    };
    Shape::new([440, 500], [0.1, 0.1], beams, 48.0).unwrap()
}

pub(crate) fn convex() -> Shape {
    let beams = Beams::Convex {
        centre_mm: [60.0, -48.0],
        radius_mm: 50.0,
        half_angle: 0.55,
    };
    Shape::new([600, 450], [0.2, 0.2], beams, 80.0).unwrap()
}

/// How wide the beams are together at a depth, mm.
pub(crate) fn width_mm(shape: &Shape, depth: f64) -> f64 {
    match shape.beams() {
        Beams::Linear { from_mm, to_mm, .. } => to_mm - from_mm,
        Beams::Convex {
            radius_mm, half_angle, ..
        } => 2.0 * half_angle * (radius_mm + depth),
    }
}

/// Grey values of a scene.
pub(crate) fn image(shape: &Shape, scene: &Scene<'_>) -> Vec<u8> {
    let depths = (shape.depth_mm() / STEP_MM) as usize + 1;
    let field = blurred(shape, field(shape, scene, depths), depths);
    let chance = Chance::new(scene.seed, 77);
    let noise = 10.0_f64.powf(scene.noise / PER_DB / 20.0);
    let level = |beam: f64, depth: f64, at: u64| {
        let amplitude = |part: &[f64], which: u64| {
            let value = between(part, depths, beam, depth / STEP_MM);
            value * 10.0_f64.powf((scene.tissue / PER_DB - scene.fade * depth) / 20.0)
                + noise * chance.normal(2 * at + which)
        };
        let power = amplitude(&field[0], 0).hypot(amplitude(&field[1], 1));
        (20.0 * power.max(1e-9).log10() * PER_DB).clamp(0.0, 255.0).round() as u8
    };
    let pixels = (0..shape.rows()).flat_map(|row| (0..shape.columns()).map(move |column| (column, row)));
    pixels
        .map(|(column, row)| {
            let beam = shape.beam_at(shape.place_mm([column as f64, row as f64]));
            let at = (row * shape.columns() + column) as u64;
            beam.map_or(0, |beam| level(beam.share * (BEAMS - 1) as f64, beam.depth_mm, at))
        })
        .collect()
}

pub(crate) fn share(beam: usize) -> f64 {
    beam as f64 / (BEAMS - 1) as f64
}

/// Scatterers: real and imaginary part, beam by beam.
fn field(shape: &Shape, scene: &Scene<'_>, depths: usize) -> [Vec<f64>; 2] {
    let chance = Chance::new(scene.seed, 1);
    let mut parts = [vec![0.0; BEAMS * depths], vec![0.0; BEAMS * depths]];
    for beam in 0..BEAMS {
        let bone = (scene.bone)(share(beam));
        for row in 0..depths {
            let z = row as f64 * STEP_MM;
            let mut strength = if bone.is_some_and(|bone| z > bone) { 0.003 } else { 1.0 };
            if let Some(bone) = bone.filter(|bone| z > *bone) {
                // The haze of a bone that is rough.
                strength += 40.0 * 0.02 * (-(z - bone) / 2.5).exp();
            }
            if let Some((_, decibels)) = scene.layer.filter(|(from, _)| z > *from) {
                strength *= 10.0_f64.powf(-decibels / 20.0);
            }
            let at = beam * depths + row;
            for (k, part) in parts.iter_mut().enumerate() {
                part[at] = strength * chance.normal((2 * at + k) as u64);
            }
        }
        let mut lines: Vec<(f64, f64, f64)> = Vec::new();
        for (depth, amplitude) in scene.fascias {
            let hidden = |z: f64| bone.is_some_and(|bone| z > bone);
            lines.extend(
                (depth(share(beam)))
                    .filter(|z| !hidden(*z))
                    .map(|z| (z, *amplitude, 0.5)),
            );
        }
        lines.extend(bone.map(|z| (z, 40.0 * leaning(shape, scene.bone, beam), 0.6)));
        // To the face and back once more: fainter, and broken up.
        lines.extend(bone.map(|z| (2.0 * z, 40.0 * scene.reverberation, 0.8)));
        for (which, (z, amplitude, rough)) in lines.into_iter().enumerate() {
            echo(&mut parts, &chance, depths, beam, z, amplitude, rough, which);
        }
    }
    parts
}

/// The share of an echo that comes back from a surface that leans: the square of the cosine.
fn leaning(shape: &Shape, bone: &Depth<'_>, beam: usize) -> f64 {
    let at = share(beam);
    let (Some(a), Some(z), Some(b)) = (bone(at - 0.002), bone(at), bone(at + 0.002)) else {
        return 1.0;
    };
    let slope = (b - a) / (0.004 * width_mm(shape, z));
    1.0 / (1.0 + slope * slope)
}

/// A line's echo: a part in phase, which falls off by itself where the line leans, and a part of chance.
fn echo(
    parts: &mut [Vec<f64>; 2],
    chance: &Chance,
    depths: usize,
    beam: usize,
    z: f64,
    amplitude: f64,
    rough: f64,
    which: usize,
) {
    let place = z / STEP_MM;
    let (low, part) = (place as usize, place.fract());
    if low + 1 >= depths {
        return;
    }
    let (sine, cosine) = (PHASE * z).sin_cos();
    for (k, turned) in [cosine, sine].into_iter().enumerate() {
        let draw = chance.normal((10_000_000 + (which * BEAMS + beam) * 2 + k) as u64);
        // In a beam's width there are many: what is in phase adds up, what is not by its root.
        let value = 3.0 * amplitude * ((1.0 - rough) * 0.35 * turned + rough * draw);
        parts[k][beam * depths + low] += value * (1.0 - part);
        parts[k][beam * depths + low + 1] += value * part;
    }
}

/// Along the beam 0.15 mm, across it 0.45 mm at half of the depth.
fn blurred(shape: &Shape, parts: [Vec<f64>; 2], depths: usize) -> [Vec<f64>; 2] {
    let across = 0.45 / (width_mm(shape, 0.5 * shape.depth_mm()) / BEAMS as f64);
    parts.map(|part| blur(&blur(&part, 0.15 / STEP_MM, 1, depths), across, depths, depths))
}

fn blur(part: &[f64], sigma: f64, step: usize, depths: usize) -> Vec<f64> {
    let reach = (3.0 * sigma).ceil() as i64;
    let kernel: Vec<f64> = (-reach..=reach)
        .map(|k| (-0.5 * (k as f64 / sigma).powi(2)).exp())
        .collect();
    let norm = kernel.iter().map(|k| k * k).sum::<f64>().sqrt();
    let mut out = vec![0.0; part.len()];
    for (k, weight) in (-reach..=reach).zip(&kernel) {
        let shift = k * step as i64;
        for (at, out) in out.iter_mut().enumerate() {
            let other = at as i64 + shift;
            // Along a beam nothing comes from the next one.
            let is_same = step > 1 || other.div_euclid(depths as i64) == (at / depths) as i64;
            if let Some(value) = usize::try_from(other)
                .ok()
                .filter(|_| is_same)
                .and_then(|other| part.get(other))
            {
                *out += weight / norm * value;
            }
        }
    }
    out
}

fn between(part: &[f64], depths: usize, beam: f64, row: f64) -> f64 {
    let (b, r) = ((beam as usize).min(BEAMS - 2), (row as usize).min(depths - 2));
    let (x, y) = (beam - b as f64, row - r as f64);
    let at = b * depths + r;
    let side = |at: usize| part[at] + y * (part[at + 1] - part[at]);
    side(at) + x * (side(at + depths) - side(at))
}

/// An image as `echo` takes it.
pub(crate) fn of<'a>(shape: &'a Shape, grey: &'a [u8]) -> Image<'a> {
    Image::new(shape, grey).unwrap()
}

/// The image with the line drawn, as PGM, in the folder `ECHO_TEST_FOLDER`: to be looked at.
pub(crate) fn keep(shape: &Shape, grey: &[u8], line: &echo::bone::BoneLine, name: &str) {
    let Some(folder) = std::env::var_os("ECHO_TEST_FOLDER") else {
        return;
    };
    let mut drawn = grey.to_vec();
    for point in &line.points {
        let [u, v] = point.pixel.map(|place| place.round() as usize);
        drawn[v * shape.columns() + u] = 255 - drawn[v * shape.columns() + u] / 2;
        if v > 3 {
            drawn[(v - 3) * shape.columns() + u] = 255;
        }
    }
    let mut bytes = format!("P5 {} {} 255\n", shape.columns(), shape.rows()).into_bytes();
    bytes.extend(drawn);
    std::fs::write(std::path::Path::new(&folder).join(format!("{name}.pgm")), bytes).unwrap();
}
