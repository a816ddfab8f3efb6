//! What frames begin with: a system that they can follow, its state, and the first factor.

use std::sync::Arc;

use nalgebra::Vector3;

use super::contact::Contact;
use super::factors::Factors;
use super::mix::Mix;
use super::search::Found;
use super::touch::Touches;
use super::watch::Others;
use super::{Evaluated, Frames, NoFrames, Now, Refused, Settings};
use crate::control::Potential;
use crate::space::system::System;
use crate::space::tube::Tube;
use crate::sparse::Dissection;

impl Frames {
    /// Frames of a system without tubes of its own, from its state `a` on, for a tube that presses points of the surface of solid `body` for
    /// which `wanted(reference place, normal)` holds. Wherever else it comes to lie in a surface the frame is refused, so
    /// name all that it may reach. What the solid is held by must do without its bones: the factor is of elasticity alone.
    ///
    /// # Errors
    /// [`NoFrames`].
    pub fn new(
        system: System,
        a: Vec<f64>,
        body: usize,
        tube: Tube,
        settings: Settings,
        wanted: impl Fn(&Vector3<f64>, &Vector3<f64>) -> bool,
    ) -> Result<Self, NoFrames> {
        let wanted = |of: usize, at: &Vector3<f64>, normal: &Vector3<f64>| of == body && wanted(at, normal);
        Self::of_bodies(system, a, &[body], tube, settings, wanted)
    }

    /// The same of a tube that presses several solids, `pressed`, by points for which `wanted(solid, reference place, normal)` holds. Solids know
    /// nothing of one another: whether they come into one another, whoever asks for frames must look ([`Frames::frame_where`]).
    ///
    /// # Errors
    /// [`NoFrames`].
    pub fn of_bodies(
        mut system: System,
        a: Vec<f64>,
        pressed: &[usize],
        tube: Tube,
        settings: Settings,
        wanted: impl Fn(usize, &Vector3<f64>, &Vector3<f64>) -> bool,
    ) -> Result<Self, NoFrames> {
        settings.check(tube.least_radius())?;
        let (solids, expected) = (system.bodies.len(), system.bodies.size());
        if let Some(body) = pressed.iter().copied().find(|body| *body >= solids) {
            return Err(NoFrames::NoBody { body, solids });
        }
        let wanted =
            |of: usize, at: &Vector3<f64>, normal: &Vector3<f64>| pressed.contains(&of) && wanted(of, at, normal);
        if a.len() != expected {
            return Err(NoFrames::Size {
                found: a.len(),
                expected,
            });
        }
        if !system.tubes.is_empty() {
            return Err(NoFrames::Tubes {
                found: system.tubes.len(),
            });
        }
        if !system.organs.is_empty() {
            return Err(NoFrames::Organs {
                found: system.organs.len(),
            });
        }
        // Their pressures are found as the tube's are, not by the energy.
        let bones = std::mem::take(&mut system.obstacles);
        if let Some(term) = system.others.iter().position(|term| term.changes()) {
            return Err(NoFrames::Changing { term });
        }
        let others = Others::new(&system, &bones, &wanted);
        let touches = Arc::new(Touches::new(&system, pressed, wanted, &bones)?);
        let order = Dissection::by_places(&system.places(), &[])?;
        let at = Evaluated::of(&system, &a).ok_or(NoFrames::NoEnergy)?;
        let system = Arc::new(system);
        let made = Factors::new(&system, order, Arc::clone(&touches), settings.precision, &a);
        let factors = made.ok_or(NoFrames::NoFactor)?;
        let least_forces = least_forces(&system, pressed, &settings, tube.least_radius())?;
        let now = Now {
            a,
            at,
            pressures: touches.pressures(),
            tube,
            found: Found::default(),
            settled: false,
        };
        let mut frames = Self {
            begun: now.clone(),
            now,
            last: None,
            contact: Contact::new(touches),
            mix: Mix::default(),
            system,
            bones,
            settings,
            others,
            factors,
            present: None,
            scale: least_forces.iter().copied().fold(f64::INFINITY, f64::min),
            least_forces,
            frame: 0,
            ways: [0.0; 2],
            slow: false,
            stale: false,
        };
        let found = frames.first().map_err(|refused| match refused {
            Refused::TooDeep { depth, most } | Refused::Through { depth, most } => NoFrames::TooDeep { depth, most },
            other => NoFrames::Start(other),
        })?;
        frames.now.found = found;
        let pose = *frames.tube().pose();
        frames.judge(&pose, &found);
        frames.begun = frames.now.clone();
        Ok(frames)
    }

    /// What there is to say of the state at the start; refused where a frame would be.
    fn first(&mut self) -> Result<Found, Refused> {
        let (tube, mut v) = (self.now.tube.clone(), Vec::new());
        self.contact.touches.take(&self.now.a, &mut v);
        let found = Found {
            gap: self.watch(&tube, &self.now.a, &v, true)?,
            inside: self.look_inside(&tube, &self.now.a)?,
            determinant: self.system.least_determinant(&self.now.a),
            ..self.balance(&tube, &v)
        };
        Ok(Found {
            unsettled: self.unsettled(),
            ..found
        })
    }
}

/// What free forces of each solid are measured by at the least; of one that the tube does not press and that has no scale of its own, by the least of others.
fn least_forces(system: &System, pressed: &[usize], settings: &Settings, radius: f64) -> Result<Vec<f64>, NoFrames> {
    let usual = |body: usize| {
        let solid = system.bodies.solid(body);
        let hundredth = 1e-2 * solid.extent();
        settings
            .least_force
            .unwrap_or(solid.shear_scale() * hundredth * hundredth)
    };
    let mut least = f64::INFINITY;
    for body in pressed {
        let least_force = Some(usual(*body));
        Settings {
            least_force,
            ..*settings
        }
        .check(radius)?;
        least = least.min(usual(*body));
    }
    let of = |body: usize| match usual(body) {
        own if pressed.contains(&body) || own > 0.0 => own,
        _ => least,
    };
    Ok((0..system.bodies.len()).map(of).collect())
}
