//! What a Hounsfield unit says of sound.
//!
//! A CT does not tell tissues apart as sound does: what is here is a picture's plausibility, not a measurement. Levels are dB
//! above the speckle of soft tissue; the order follows the textbooks (fluid black, muscle dark with bright septa, fat and
//! organs grey).

/// Below this there is no way for sound: gas, and the air around.
pub(crate) const GAS_HU: f64 = -400.0;
/// The face is coupled where HU are at least this.
pub(crate) const COUPLED_HU: f64 = -500.0;
/// Between fat and everything else: where it is crossed there is a fascia.
pub(crate) const FASCIA_HU: f64 = -22.0;

/// HU, speckle, septa.
const LEVELS: [[f64; 3]; 15] = [
    [-1000.0, -60.0, -60.0],
    [-401.0, -60.0, -60.0],
    [-200.0, -6.0, -8.0],
    [-100.0, -6.0, -3.0],
    [-60.0, -2.0, -4.0],
    [-20.0, -3.0, -6.0],
    [-6.0, -40.0, -60.0],
    [8.0, -40.0, -60.0],
    [14.0, -8.0, -20.0],
    [30.0, -8.0, -10.0],
    [45.0, -9.0, 0.0],
    [60.0, -8.0, 0.0],
    [90.0, 0.0, -14.0],
    [150.0, -6.0, -20.0],
    [200.0, -22.0, -60.0],
];
const LOWEST: i32 = -1024;
const COUNT: usize = 2048;

/// Amplitudes by whole HU.
#[derive(Debug, Clone)]
pub(crate) struct Tissue {
    speckle: Vec<f32>,
    septa: Vec<f32>,
    surplus: Vec<f32>,
}

impl Tissue {
    /// `loss` is what soft tissue takes, dB a mm to and fro, and time-gain gives back.
    pub(crate) fn new(loss: f64) -> Self {
        let hu = |i: usize| f64::from(LOWEST + i as i32);
        let table = |column| (0..COUNT).map(|i| amplitude(level(hu(i), column)) as f32).collect();
        Self {
            speckle: table(1),
            septa: table(2),
            surplus: (0..COUNT).map(|i| (loss * surplus(hu(i))) as f32).collect(),
        }
    }

    /// The amplitude of speckle.
    pub(crate) fn speckle(&self, hu: f32) -> f32 {
        self.speckle[index(hu)]
    }

    /// The amplitude of thin layers inside it.
    pub(crate) fn septa(&self, hu: f32) -> f32 {
        self.septa[index(hu)]
    }

    /// What time-gain adds too much, dB a mm.
    pub(crate) fn surplus(&self, hu: f32) -> f32 {
        self.surplus[index(hu)]
    }
}

fn index(hu: f32) -> usize {
    // A cast takes what is below, and what nobody asked for (NaN), to 0: silent.
    ((hu - LOWEST as f32) as usize).min(COUNT - 1)
}

/// Straight from one row of [`LEVELS`] to the next.
fn level(hu: f64, column: usize) -> f64 {
    let last = LEVELS[LEVELS.len() - 1][column];
    let pair = LEVELS.windows(2).find(|pair| hu <= pair[1][0]);
    pair.map_or(last, |pair| {
        let share = ((hu - pair[0][0]) / (pair[1][0] - pair[0][0])).max(0.0);
        pair[0][column] + share * (pair[1][column] - pair[0][column])
    })
}

/// Of soft tissue's loss, what a tissue does not take: fluids take nearly nothing.
fn surplus(hu: f64) -> f64 {
    match hu {
        hu if hu.abs() < 14.0 => 0.9,
        hu if hu < -30.0 => 0.2,
        _ => 0.0,
    }
}

/// dB to amplitude.
pub(crate) fn amplitude(level_db: f64) -> f64 {
    10.0_f64.powf(level_db / 20.0)
}
