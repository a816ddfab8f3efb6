//! Scatterers of soft tissue, and its thin layers.

use crate::fan::Fan;
use crate::field::Field;
use crate::lattice::Lattice;
use crate::scene::{Pose, dot};
use crate::settings::Settings;

/// Scatterers a resolution cell (pulse x width x width at the foci): speckle is fully developed from about 10 on
/// (Wagner et al., "Statistics of speckle in ultrasound B-scans", IEEE Trans. Sonics Ultrason. 30(3), 1983).
const PER_CELL: f64 = 10.0;
/// Scatterers of an image at most: where a fine pulse meets a large image there are fewer of them a cell.
const MOST: f64 = 1.5e6;
/// Speed that scanners assume, mm a microsecond.
const SPEED: f64 = 1.54;
/// Deviations of the beam across the image beyond which a scatterer is left out: 0.2 % of the power.
const REACH: f64 = 2.2;
/// Size of the cells of thin layers, mm, and their largest radius.
const SEPTUM_MM: f64 = 1.3;
const SEPTUM_RADIUS_MM: f64 = 4.5;
/// A layer is seen within about this angle from square to the beam: cosine.
const SEPTUM_COSINE: f64 = 0.94;
/// Level of a thin layer that lies square in the beam, dB.
const SEPTUM_DB: f64 = 20.0;
/// Steps of a turn, and of the Gaussian across the image.
const TURN: usize = 256;
const FALL: usize = 256;

/// What is drawn once for all images.
#[derive(Debug, Clone)]
pub(crate) struct Speckle {
    scatterers: Lattice,
    septa: Lattice,
    /// Turns a mm of depth as shown, for each look.
    turns: [f64; 2],
    turn: Vec<[f32; 2]>,
    fall: Vec<f32>,
    /// By sample: makes the mean power 1 after the blur.
    level: Vec<f32>,
    /// Scatterers in a resolution cell.
    pub(crate) per_cell: f64,
}

impl Speckle {
    pub(crate) fn new(fan: &Fan, settings: &Settings) -> Self {
        let resolution = settings.pulse_mm * settings.lateral.width_mm * settings.elevation.width_mm;
        let depth = fan.shape.depth_mm();
        let wide = fan.pitch_mm(depth) * fan.beams as f64;
        let thick = 2.0 * REACH * fan.elevation_mm(depth).max(fan.elevation_mm(0.0));
        let cell = (resolution / PER_CELL).max(wide * depth * thick / MOST);
        let cell_mm = cell.cbrt();
        // A half of the bandwidth above the carrier and one below it.
        let apart = if settings.compound { 0.12 } else { 0.0 };
        let turns = [1.0 - apart, 1.0 + apart].map(|part| 2.0 * part * settings.frequency_mhz / SPEED * fan.ratio);
        let turn = (0..TURN).map(|i| {
            let (sine, cosine) = (std::f64::consts::TAU * i as f64 / TURN as f64).sin_cos();
            [cosine as f32, sine as f32]
        });
        let fall = (0..FALL).map(|i| (-0.5 * REACH * REACH * (i as f64 + 0.5) / FALL as f64).exp() as f32);
        // Power a node: density times the area of a node times the integral of the squared Gaussian across.
        let level = (0..fan.samples).map(|sample| {
            let shown = fan.shown_mm(sample);
            let across = fan.elevation_mm(shown) * std::f64::consts::PI.sqrt();
            let node = fan.pitch_mm(shown) * fan.step_mm * fan.ratio;
            (across * node / cell).sqrt().recip() as f32
        });
        Self {
            scatterers: Lattice {
                cell_mm,
                seed: chance::mix(settings.seed),
            },
            septa: Lattice {
                cell_mm: SEPTUM_MM,
                seed: chance::mix(settings.seed ^ 0x7365_7074),
            },
            turns,
            turn: turn.collect(),
            fall: fall.collect(),
            level: level.collect(),
            per_cell: resolution / cell,
        }
    }

    /// Adds every scatterer at its place, with the phase of its depth.
    pub(crate) fn scatter(&self, pose: &Pose, fan: &Fan, field: &mut Field) {
        let Lattice { cell_mm, .. } = self.scatterers;
        let reach = |shown: f64| REACH * fan.elevation_mm(shown);
        let (last_beam, last_sample) = (fan.beams as f64 - 0.5, fan.samples as f64 - 0.5);
        let narrow: Vec<f64> = (0..fan.samples)
            .map(|sample| (REACH * fan.elevation_mm(fan.shown_mm(sample))).powi(2).recip() * FALL as f64)
            .collect();
        self.scatterers.visit(pose, fan, reach, |cell| {
            let bits = self.scatterers.bits(cell);
            // Three times 14 bits of place, then 22 of amplitude.
            let part = |i: usize| ((bits >> (14 * i)) & 0x3fff) as f64 * (1.0 / 16384.0);
            let place = std::array::from_fn(|i| (cell[i] as f64 + part(i)) * cell_mm);
            let [x, y, aside] = pose.inside(place);
            let (beam, shown) = fan.locate([x, y]);
            let (beam, sample) = (beam + 0.5, shown / fan.step_mm + 0.5);
            // A NaN is within nothing.
            if !(beam >= 0.0 && beam < last_beam + 0.5 && sample >= 0.0 && sample < last_sample + 0.5) {
                return;
            }
            let (beam, sample) = (beam as usize, sample as usize);
            let fall = (aside * aside * narrow[sample]) as usize;
            if fall >= FALL {
                return;
            }
            let weight = self.fall[fall] * self.level[sample] * amplitude(bits >> 42);
            let turned = self.turns.map(|turns| {
                let turn = turns * shown;
                self.turn[((turn - turn.floor()) * TURN as f64) as usize % TURN]
            });
            let node = field.speckle_at(beam, sample);
            for (into, part) in node.iter_mut().zip(turned.as_flattened()) {
                *into += weight * part;
            }
        });
    }

    /// Adds thin layers: discs that lie any way, of which those square to a beam are seen.
    ///
    /// Muscle is full of them (perimysium); their level is that of the tissue around.
    pub(crate) fn layer(&self, pose: &Pose, fan: &Fan, field: &mut Field, tissue: impl Fn(f64, f64) -> f32) {
        let top = crate::tissue::amplitude(SEPTUM_DB) as f32;
        self.septa.visit(
            pose,
            fan,
            |_| SEPTUM_RADIUS_MM,
            |cell| {
                let bits = self.septa.bits(cell);
                let part = |i: usize| ((bits >> (10 * i)) & 0x3ff) as f64 / 1024.0;
                let place = std::array::from_fn(|i| (cell[i] as f64 + part(i)) * SEPTUM_MM);
                let [x, y, aside] = pose.inside(place);
                let radius = 1.0 + (SEPTUM_RADIUS_MM - 1.0) * part(3).powi(3);
                if aside.abs() >= radius {
                    return;
                }
                // Even over the sphere (Archimedes): height and longitude.
                let (height, (sine, cosine)) = (2.0 * part(4) - 1.0, (std::f64::consts::TAU * part(5)).sin_cos());
                let flat = (1.0 - height * height).sqrt();
                let normal = [flat * cosine, flat * sine, height];
                let (beam, shown) = fan.locate([x, y]);
                let middle = (
                    beam.clamp(0.0, (fan.beams - 1) as f64),
                    shown.clamp(0.0, fan.shape.depth_mm()),
                );
                let (_, direction) = fan.at(middle.0, middle.1);
                let along = dot(normal, pose.direction(direction));
                if along.abs() < SEPTUM_COSINE {
                    return;
                }
                // Most are faint.
                let own = (0.15 + 0.85 * part(2).powi(2)) as f32;
                let level = top
                    * own
                    * tissue(middle.0, middle.1)
                    * ((along.abs() - SEPTUM_COSINE) / (1.0 - SEPTUM_COSINE)) as f32;
                if level < 0.05 {
                    return;
                }
                let half = (radius * radius - aside * aside).sqrt();
                let pitch = fan.pitch_mm(middle.1);
                let side = dot(normal, pose.direction([direction[1], -direction[0]]));
                let slope = -side / along / fan.ratio;
                let [from, to] = [beam - half / pitch, beam + half / pitch];
                let from = from.ceil().max(0.0) as usize;
                // A cast of what is below 0 gives 0, and the range is empty where the disc is beside the image.
                for at in from..((to.floor() + 1.0).max(0.0) as usize).min(fan.beams) {
                    let off = (at as f64 - beam) * pitch;
                    let taper = 1.0 - (off / half).powi(2);
                    field.line(at, shown + slope * off, level * taper as f32);
                }
            },
        );
    }
}

/// An even number from 22 bits, of either sign, of mean square 1.
fn amplitude(bits: u64) -> f32 {
    let even = bits as f32 / (1 << 21) as f32 - 1.0;
    even * 1.732_050_8
}
