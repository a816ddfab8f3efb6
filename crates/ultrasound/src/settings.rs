//! The scanner's settings: its physics and what its knobs say.

use std::ops::RangeInclusive;

/// How wide the beam is, by depth: sqrt(width^2 + (spread (depth - focus))^2), the full width at half of the peak amplitude.
///
/// The form of a Gaussian beam; dynamic focusing keeps `spread` small along a row, the fixed lens makes it large across.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Focus {
    /// Where it is narrowest, mm from the face.
    pub depth_mm: f64,
    /// The width there, mm.
    pub width_mm: f64,
    /// How fast it widens far from there, mm per mm.
    pub spread: f64,
}

impl Focus {
    /// The full width at half of the peak, mm, at a depth.
    #[must_use]
    pub fn width_at(&self, depth_mm: f64) -> f64 {
        self.width_mm.hypot(self.spread * (depth_mm - self.depth_mm))
    }
}

/// Everything but the shape of the image. Levels are dB above the speckle of soft tissue (0 dB, its root mean square).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// The carrier, MHz.
    pub frequency_mhz: f64,
    /// The pulse's full width at half of its peak, mm as shown.
    pub pulse_mm: f64,
    /// The beam along a row.
    pub lateral: Focus,
    /// The beam across the image: what makes a slanting bone's line thick.
    pub elevation: Focus,
    /// How many beams are computed.
    pub beams: usize,
    /// True speed of sound over the 1540 m/s that the scanner assumes: what lies `d` deep is shown at `d / speed_ratio`.
    ///
    /// The echo comes after t = 2 d / c, and is drawn at 1540 t / 2 = d 1540 / c.
    pub speed_ratio: f64,
    /// From this HU on it is bone.
    ///
    /// 300 is about the middle between muscle (50) and thin cortex as CTs show it (500 to 700); blood with contrast
    /// (150 to 300) is below, and cancellous bone (200) is met from outside only where a scan was cut.
    pub bone_hu: f64,
    /// How thick a layer of air under the face may be to count as filled with gel, mm.
    pub gel_mm: f64,
    /// The step at which HU are asked for, mm: what is thinner along a beam may be missed.
    pub survey_mm: f64,
    /// From black to white, dB.
    pub range_db: f64,
    /// Grey is 0 at `-gain_db`.
    pub gain_db: f64,
    /// The electronic noise at the face; time-gain raises it with depth, by at most 30 dB.
    pub noise_db: f64,
    /// The level of what is reflected to and fro above a bone and shown below it, beside what it repeats.
    pub reverberation_db: f64,
    /// The average of two images of half the bandwidth each, with speckle of its own: smoother, as scanners show it.
    pub compound: bool,
    /// Which scatterers the tissue has.
    pub seed: u64,
}

/// A setting that cannot be.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{what} is {found}; allowed are {least} to {most}")]
pub struct SettingError {
    /// Which one.
    pub what: &'static str,
    /// Its value.
    pub found: f64,
    /// The least.
    pub least: f64,
    /// The most.
    pub most: f64,
}

impl Settings {
    /// A linear array of 7.5 MHz for what lies within 6 cm.
    #[must_use]
    pub fn shallow() -> Self {
        Self {
            frequency_mhz: 7.5,
            pulse_mm: 0.45,
            lateral: Focus {
                depth_mm: 22.0,
                width_mm: 0.7,
                spread: 0.02,
            },
            elevation: Focus {
                depth_mm: 20.0,
                width_mm: 1.5,
                spread: 0.055,
            },
            beams: 192,
            speed_ratio: 1.0,
            bone_hu: 300.0,
            gel_mm: 2.5,
            survey_mm: 0.8,
            range_db: 60.0,
            gain_db: 13.0,
            noise_db: -44.0,
            reverberation_db: -16.0,
            compound: true,
            seed: 1,
        }
    }

    /// A curved array of 3.5 MHz for what lies deeper.
    #[must_use]
    pub fn deep() -> Self {
        Self {
            frequency_mhz: 3.5,
            pulse_mm: 0.9,
            lateral: Focus {
                depth_mm: 60.0,
                width_mm: 1.6,
                spread: 0.02,
            },
            elevation: Focus {
                depth_mm: 70.0,
                width_mm: 3.0,
                spread: 0.05,
            },
            ..Self::shallow()
        }
    }

    /// Refuses what cannot be.
    ///
    /// # Errors
    /// The first setting that is out of its range, or not a number.
    pub fn check(&self) -> Result<(), SettingError> {
        let all: [(&'static str, f64, RangeInclusive<f64>); 19] = [
            ("the frequency, MHz,", self.frequency_mhz, 0.5..=40.0),
            ("the length of the pulse, mm,", self.pulse_mm, 0.05..=5.0),
            ("the lateral focus, mm,", self.lateral.depth_mm, 0.0..=400.0),
            ("the lateral width, mm,", self.lateral.width_mm, 0.1..=10.0),
            ("the lateral spread", self.lateral.spread, 0.0..=0.5),
            ("the elevation's focus, mm,", self.elevation.depth_mm, 0.0..=400.0),
            ("the elevation's width, mm,", self.elevation.width_mm, 0.1..=10.0),
            ("the elevation's spread", self.elevation.spread, 0.0..=0.5),
            ("the number of beams", self.beams as f64, 16.0..=1024.0),
            ("the speed of sound over 1540 m/s", self.speed_ratio, 0.8..=1.25),
            ("the HU of bone", self.bone_hu, 100.0..=2000.0),
            ("the gel's thickness, mm,", self.gel_mm, 0.0..=20.0),
            ("the step of the survey, mm,", self.survey_mm, 0.2..=3.0),
            ("the dynamic range, dB,", self.range_db, 20.0..=120.0),
            ("the gain, dB,", self.gain_db, -60.0..=120.0),
            ("the noise, dB,", self.noise_db, -200.0..=20.0),
            ("the reverberation, dB,", self.reverberation_db, -200.0..=0.0),
            // Narrower than the beams are apart, a wire between two would vanish.
            (
                "the lateral width at 400 mm, mm,",
                self.lateral.width_at(400.0),
                0.1..=250.0,
            ),
            (
                "the elevation's width at 400 mm, mm,",
                self.elevation.width_at(400.0),
                0.1..=250.0,
            ),
        ];
        let wrong = all.into_iter().find(|(_, found, allowed)| !allowed.contains(found));
        wrong.map_or(Ok(()), |(what, found, allowed)| {
            Err(SettingError {
                what,
                found,
                least: *allowed.start(),
                most: *allowed.end(),
            })
        })
    }
}
