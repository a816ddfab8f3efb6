//! What tissue, fasciae, bone and gas do to a beam.

use chance::mix;

use crate::fan::Fan;
use crate::field::Field;
use crate::lattice::Lattice;
use crate::scene::Pose;
use crate::survey::{Kind, OUTER, Path, Survey};
use crate::tissue::{FASCIA_HU, GAS_HU, Tissue, amplitude};

/// Rays across the thickness of the image, on which stops are interpolated.
const RAYS: usize = 17;
/// Stops of neighbouring rays further apart than this, mm, belong to different surfaces.
const SAME_MM: f64 = 8.0;
/// Bone square to the beam and at any slant; fascia; skin and gel; the face itself, dB.
const BONE_DB: f64 = 37.0;
const BONE_FLOOR: f64 = 0.10;
const FASCIA_DB: f64 = 30.0;
const FASCIA_FLOOR: f64 = 0.08;
const FACE_DB: f64 = 24.0;
/// The face rings, mm.
const FACE_MM: f64 = 0.25;
/// HU from one side of a fascia to the other at which its echo is full: fat to muscle.
const FASCIA_STEP: f32 = 150.0;
/// How far under bone the haze of sound that found another way falls to 1 / e, mm.
const HAZE_MM: f64 = 12.0;
/// Its level beside that of repeated layers, dB.
const HAZE_DB: f64 = 13.0;
/// How far under bone repeated layers fall to 1 / e, mm: each way to and fro spreads.
const REPEAT_MM: f64 = 12.0;
/// Under gas everything repeats louder: the "dirty" shadow, dB.
const DIRTY_DB: f64 = 10.0;
/// Time-gain is too high where fluid took nothing, by at most this factor (12 dB).
const MOST_SURPLUS: f32 = 4.0;
/// A fascia is brighter here and fainter there: the size of such patches, mm.
const PATCH_MM: f64 = 2.7;
/// Below the bone's line, its pulse rings on: what each ring leaves of the one before, and how far apart they are, mm.
const RING: f64 = 0.4;
const RING_MM: f64 = 0.4;
/// Rough patches of bone, mm.
const ROUGH_MM: f64 = 0.25;

/// The rays of one beam: where each is stopped, mm as shown; infinite where none is.
struct Rays {
    stops: [f64; RAYS],
    first: f64,
    last: f64,
    kind: Kind,
}

/// How much of the sound runs along each ray: a Gaussian, followed to [`OUTER`].
fn weights() -> [f64; RAYS] {
    let plain: [f64; RAYS] = std::array::from_fn(|i| (-0.5 * aside(i).powi(2)).exp());
    let sum: f64 = plain.iter().sum();
    plain.map(|weight| weight / sum)
}

/// Deviations from the plane.
fn aside(ray: usize) -> f64 {
    OUTER * (2.0 * ray as f64 / (RAYS - 1) as f64 - 1.0)
}

impl Rays {
    fn of(path: &Path) -> Self {
        let [middle, near, far] = path.stops.map(|stop| stop.map(|stop| stop.depth));
        let stops = std::array::from_fn(|i| between([near, middle, far], aside(i) / OUTER).unwrap_or(f64::INFINITY));
        let kind = path.stops.iter().flatten().next().map_or(Kind::Bone, |stop| stop.kind);
        Self {
            first: stops.iter().copied().fold(f64::INFINITY, f64::min),
            last: stops.iter().copied().fold(0.0, f64::max),
            stops,
            kind,
        }
    }
}

/// The stop at a place from -1 to 1 between three known ones at -1, 0 and 1.
fn between([near, middle, far]: [Option<f64>; 3], place: f64) -> Option<f64> {
    let same = |a: Option<f64>, b: Option<f64>| a.zip(b).filter(|(a, b)| (a - b).abs() < SAME_MM);
    let side = if place < 0.0 { near } else { far };
    match (same(near, middle), same(middle, far)) {
        // The parabola through all three: exact to the third order for a curved bone.
        (Some((a, b)), Some((_, c))) => Some(b + place * ((c - a) / 2.0 + place * (a - 2.0 * b + c) / 2.0)),
        _ => match same(middle, side) {
            Some((b, c)) => Some(b + place.abs() * (c - b)),
            None if place.abs() < 0.5 => middle,
            None => side,
        },
    }
}

/// What echoes are made with.
pub(crate) struct Echoes<'a> {
    pub(crate) pose: &'a Pose,
    pub(crate) fan: &'a Fan,
    pub(crate) survey: &'a Survey,
    pub(crate) tissue: &'a Tissue,
    /// Amplitude of a node that is 1 after the blur.
    pub(crate) peak: f32,
    pub(crate) reverberation_db: f64,
    pub(crate) seed: u64,
}

impl Echoes<'_> {
    /// Fasciae: where HU pass from fat to anything else, along each beam.
    pub(crate) fn fasciae(&self, field: &mut Field) {
        let (mut here, mut next) = (Vec::new(), Vec::new());
        let top = amplitude(FASCIA_DB) as f32;
        let patches = Lattice {
            cell_mm: PATCH_MM,
            seed: mix(self.seed),
        };
        for beam in 0..self.fan.beams {
            let (column, across) = self.survey.column(self.fan, beam as f64);
            let step = self.survey.profile(column, across, &mut here);
            self.survey.profile(column, (across + 0.5) % 1.0, &mut next);
            let aside = if across < 0.5 { 0.5 } else { -0.5 } * self.survey.column_mm(self.fan);
            for row in 1..here.len() - 2 {
                let [a, b] = [here[row], here[row + 1]];
                if a < GAS_HU as f32 || b < GAS_HU as f32 || (a < FASCIA_HU as f32) == (b < FASCIA_HU as f32) {
                    continue;
                }
                let share = (FASCIA_HU as f32 - a) / (b - a);
                let along = f64::from(b - a) / step;
                let beside = f64::from(next[row] + share * (next[row + 1] - next[row]) - FASCIA_HU as f32) / aside;
                let cosine = along.abs() / along.hypot(beside);
                // NaN where a neighbour is stopped before: nothing is known of its slant.
                if cosine.is_nan() {
                    continue;
                }
                let mirrored = FASCIA_FLOOR + (1.0 - FASCIA_FLOOR) * cosine.powi(12);
                let jump = ((here[row + 2] - here[row - 1]).abs() / FASCIA_STEP).min(1.0);
                let depth = (row as f64 + f64::from(share)) * step;
                let (plane, _) = self.fan.at(beam as f64, depth);
                let patch = patches.smooth(self.pose.place(plane)).powi(2) as f32;
                field.line(beam, depth, 2.2 * patch * top * jump * mirrored as f32);
            }
        }
    }

    /// Weighs scatterers and lines by tissue and by what sound is left, adds stops and what is shown below them.
    pub(crate) fn shade(&self, field: &mut Field) {
        let weights = weights();
        let paths = &self.survey.paths;
        let rays: Vec<Rays> = paths.iter().map(Rays::of).collect();
        let haze = amplitude(self.reverberation_db + HAZE_DB);
        let dirty = |kind| if kind == Kind::Gas { amplitude(DIRTY_DB) } else { 1.0 };
        let mut gain = vec![1.0_f32; paths.len()];
        let beams = self.fan.beams;
        for sample in 0..self.fan.samples {
            let shown = self.fan.shown_mm(sample);
            for (beam, (path, rays)) in paths.iter().zip(&rays).enumerate() {
                let at = sample * beams + beam;
                let silent = path.entry.is_none_or(|entry| shown < entry);
                let left = if silent { 0.0 } else { left(rays, shown, &weights) };
                let mut level = 0.0;
                if left > 0.0 {
                    let hu = self.survey.hu_at(self.fan, beam as f64, shown);
                    let more = self.tissue.surplus(hu) * self.fan.step_mm as f32;
                    if more > 0.0 {
                        // d 10^(x / 20) = ln 10 / 20 dx.
                        gain[beam] = (gain[beam] * (1.0 + more * 0.115_129_25)).min(MOST_SURPLUS);
                    }
                    level = left * gain[beam] * self.tissue.speckle(hu);
                }
                field.lines[at] *= left * gain[beam];
                if left < 1.0 && !silent {
                    let below = (shown - rays.first) / HAZE_MM;
                    level += ((1.0 - f64::from(left)) * haze * dirty(rays.kind) * (-below).exp()) as f32;
                }
                field.speckle[at] = field.speckle[at].map(|part| part * level);
            }
        }
        self.stops(field, &rays, &weights);
        self.face(field);
        self.repeat(field, &rays, dirty);
    }

    /// Bone and gas: each ray's echo where it is stopped.
    fn stops(&self, field: &mut Field, rays: &[Rays], weights: &[f64; RAYS]) {
        let top = amplitude(BONE_DB);
        let cells = Lattice {
            cell_mm: ROUGH_MM,
            seed: self.seed,
        };
        for (beam, (path, rays)) in self.survey.paths.iter().zip(rays).enumerate() {
            if path.entry.is_none() || rays.first.is_infinite() {
                continue;
            }
            let mirrored = top * (BONE_FLOOR + (1.0 - BONE_FLOOR) * path.cosine.powi(6));
            for (ray, (&depth, weight)) in rays.stops.iter().zip(weights).enumerate() {
                if depth.is_infinite() {
                    continue;
                }
                for ring in 0..4 {
                    let height = mirrored * weight * RING.powi(ring);
                    field.line(beam, depth + RING_MM * f64::from(ring), height as f32);
                }
                let (plane, _) = self.fan.at(beam as f64, depth);
                let place = self.pose.beside(plane, aside(ray) * self.fan.elevation_mm(depth));
                // Power, not amplitude, is shared by rough places: their phases differ.
                let level = (0.45 * mirrored * weight.sqrt()) as f32 / self.peak;
                let echo = normals(cells.bits(cells.cell(place))).map(|part| part * level);
                field.rough(beam, depth, echo);
            }
        }
    }

    /// The face rings; without coupling it goes on ringing in itself.
    fn face(&self, field: &mut Field) {
        let top = amplitude(FACE_DB);
        for (beam, path) in self.survey.paths.iter().enumerate() {
            let far = if path.entry.is_some() { 6.0 } else { 14.0 } * FACE_MM;
            let rings = (far / self.fan.step_mm) as usize;
            for sample in 0..rings.min(self.fan.samples) {
                let shown = self.fan.shown_mm(sample);
                let height = top * (-shown / FACE_MM / if path.entry.is_some() { 1.0 } else { 3.0 }).exp();
                let wave = match path.entry {
                    Some(_) => 1.0,
                    None => (std::f64::consts::PI * shown / (2.5 * FACE_MM)).cos().abs(),
                };
                let density = self.fan.step_mm / FACE_MM;
                field.line(beam, shown, (height * wave * density) as f32);
            }
        }
    }

    /// Sound that runs from a bone up to a layer and back is shown as far below the bone as the layer lies above.
    fn repeat(&self, field: &mut Field, rays: &[Rays], dirty: impl Fn(Kind) -> f64) {
        let beams = self.fan.beams;
        for (beam, rays) in rays.iter().enumerate() {
            if rays.first.is_infinite() || self.survey.paths[beam].entry.is_none() {
                continue;
            }
            let again = (amplitude(self.reverberation_db) * dirty(rays.kind)) as f32;
            // From below the echo of the bone itself on.
            let clear = 3.0 * self.fan.pulse;
            let mirror = 2.0 * rays.first / self.fan.step_mm;
            let start = (rays.last.min(rays.first + 3.0) / self.fan.step_mm + clear).ceil();
            for sample in (start as usize..self.fan.samples).take_while(|&sample| sample as f64 <= mirror) {
                let from = (mirror - sample as f64) as usize;
                let (from, to) = (from * beams + beam, sample * beams + beam);
                if from >= to {
                    continue;
                }
                let again = again * (-((sample as f64 - start) * self.fan.step_mm / REPEAT_MM) as f32).exp();
                // The layers are met from below and at all slants: their lines come back rough, not mirrored.
                let line = field.lines[from] * again / self.peak;
                let [into, other] = [field.speckle[to], field.speckle[from]];
                let rough = normals(mix((sample * beams + beam) as u64 ^ self.seed));
                field.speckle[to] = std::array::from_fn(|i| into[i] + again * other[i] + line * rough[i]);
            }
        }
    }
}

/// The share of sound that is not stopped above a depth.
fn left(rays: &Rays, shown: f64, weights: &[f64; RAYS]) -> f32 {
    if shown < rays.first {
        return 1.0;
    }
    let pairs = rays.stops.iter().zip(weights);
    pairs
        .filter(|(stop, _)| **stop > shown)
        .map(|(_, weight)| *weight)
        .sum::<f64>() as f32
}

/// Four numbers of mean 0 and mean square 1 / 2: two complex numbers of mean square 1.
fn normals(bits: u64) -> [f32; 4] {
    std::array::from_fn(|i| {
        // The sum of four even numbers is nearly normal; of 0..256 each, mean 510 and deviation 147.8.
        let bits = mix(bits.wrapping_add(i as u64));
        let sum: u64 = (0..4).map(|byte| (bits >> (8 * byte)) & 0xff).sum();
        (sum as f32 - 510.0) / 147.8 * std::f32::consts::FRAC_1_SQRT_2
    })
}
