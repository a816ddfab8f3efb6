//! Images of a scene.

use crate::display::Display;
use crate::echoes::Echoes;
use crate::fan::Fan;
use crate::field::{Field, Kernels};
use crate::scene::{Body, Pose, Scene, SceneError};
use crate::settings::{SettingError, Settings};
use crate::shape::Shape;
use crate::speckle::Speckle;
use crate::survey::Survey;
use crate::tissue::Tissue;
use crate::wires;

/// Soft tissue's loss, dB a mm, a MHz, one way (0.5 dB / (cm MHz)).
const LOSS: f64 = 0.05;

/// A scanner with its probe, ready to make images.
#[derive(Debug)]
pub struct Scanner {
    settings: Settings,
    fan: Fan,
    kernels: Kernels,
    speckle: Speckle,
    tissue: Tissue,
    display: Display,
    field: Field,
    survey: Survey,
}

impl Scanner {
    /// A scanner; what every image shares is computed here.
    ///
    /// # Errors
    /// [`SettingError`]: the first setting that cannot be.
    pub fn new(shape: &Shape, settings: &Settings) -> Result<Self, SettingError> {
        settings.check()?;
        let fan = Fan::new(shape, settings);
        let loss = 2.0 * LOSS * settings.frequency_mhz;
        Ok(Self {
            settings: *settings,
            kernels: Kernels::new(&fan),
            speckle: Speckle::new(&fan, settings),
            tissue: Tissue::new(loss),
            display: Display::new(&fan, settings, loss),
            field: Field::new(&fan),
            survey: Survey::new(&fan, settings.survey_mm),
            fan,
        })
    }

    /// The shape of its images.
    pub fn shape(&self) -> &Shape {
        &self.fan.shape
    }

    /// Its settings.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Scatterers in a resolution cell at the foci: 10, and less where a fine pulse meets a large image.
    ///
    /// From about 10 on, speckle is fully developed.
    pub fn scatterers_per_cell(&self) -> f64 {
        self.speckle.per_cell
    }

    /// How often the last image asked the body for its HU.
    pub fn asked(&self) -> usize {
        self.survey.asked
    }

    /// The grey values, row by row, of image `number` of the scene: the noise is the number's, all else is the place's.
    ///
    /// # Errors
    /// [`SceneError`]: a wire or a wall that cannot be.
    pub fn scan<B: Body>(&mut self, scene: &Scene<B>, pose: &Pose, number: u64) -> Result<Vec<u8>, SceneError> {
        let mut grey = vec![0; self.fan.shape.columns() * self.fan.shape.rows()];
        let noise = number ^ chance::mix(self.settings.seed);
        let beams = self.fan.beams;
        let looks = if self.settings.compound { 2.0 } else { 1.0 };
        self.echoes(scene, pose)?;
        let power = self.field.power(&self.kernels, looks);
        self.display.show(power, noise, beams, &mut grey);
        Ok(grey)
    }

    /// Every echo, blurred along rows.
    fn echoes<B: Body>(&mut self, scene: &Scene<B>, pose: &Pose) -> Result<(), SceneError> {
        scene.check()?;
        let Self {
            settings, fan, field, ..
        } = self;
        self.survey.take(scene, pose, fan, (settings.bone_hu, settings.gel_mm));
        field.clear();
        self.speckle.scatter(pose, fan, field);
        let echoes = Echoes {
            pose,
            fan,
            survey: &self.survey,
            tissue: &self.tissue,
            peak: self.kernels.peak(),
            reverberation_db: settings.reverberation_db,
            seed: settings.seed,
        };
        echoes.fasciae(field);
        let septa = |beam: f64, shown: f64| self.tissue.septa(self.survey.hu_at(fan, beam, shown));
        self.speckle.layer(pose, fan, field, septa);
        wires::draw(scene.wires, pose, fan, field);
        echoes.shade(field);
        field.blur_beams(&self.kernels);
        Ok(())
    }
}
