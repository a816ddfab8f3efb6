//! The chain that goes with a room: what a calibration, a registration and a data sheet would say of it.

use calib::pose::{Gates, Localizer};
use geometry::{Ct, Marker, Point, Rigid, Tool, Tracker, Uncertain, Vector};
use scene::operating_room::{Deviations, Gates as GateSpec, Room, Sensor};

use super::{OperatingRoom, RoomError, body, sensing};
use crate::chain::{Chain, Registration};
use crate::errors::errors_about;
use chance::Chance;

/// Keeps the draws of the links apart from those of the frames.
const LINKS: u64 = 0x6c69_6e6b;
/// Numbers of the two links.
const CALIBRATION: u64 = 0;
const REGISTRATION: u64 = 1;
/// Weights need a deviation above 0: this, where the scene says less, mm.
const LEAST_MM: f64 = 1e-3;
/// And none may be this many times smaller than the other, so that its square can be inverted.
const LARGEST_RATIO: f64 = 50.0;

impl OperatingRoom {
    /// The chain that turns this room's frames into poses. Its calibration and its registration are off the truth by errors
    /// drawn from the seed, normal, with the covariances that the chain is told; the registration's are about `region`, the
    /// point of the patient that counts (a target).
    ///
    /// # Errors
    /// [`RoomError::Localizer`], [`RoomError::Covariance`].
    pub fn chain(&self, region: Point<Ct>) -> Result<Chain, RoomError> {
        chain_of(&self.room, self.tracker_from_rest, self.seed, region)
    }
}

/// The same without a gesture: for frames of the room that were recorded.
pub(crate) fn chain_of(
    room: &Room,
    tracker_from_rest: Rigid<Tracker, Ct>,
    seed: u64,
    region: Point<Ct>,
) -> Result<Chain, RoomError> {
    let (error, off) = (room.registration_error, Chance::new(seed ^ LINKS, REGISTRATION));
    let registration = match &room.reference {
        Some(on) => Registration::Referenced(disturbed(on.ct_from_reference, region, error, off)?),
        None => Registration::Fixed(disturbed(tracker_from_rest.inverse(), region, error, off)?),
    };
    let reference = room.reference.as_ref().map(|on| body(&on.shape));
    Ok(Chain {
        marker: body(&room.marker).map_err(RoomError::Marker)?,
        reference: reference.transpose().map_err(RoomError::Reference)?,
        marker_from_tool: calibration(room, seed)?,
        registration,
        localizer: weights(&room.sensor).checked()?,
        gates: gates(&room.gates),
        reference_gates: gates(&room.reference_gates),
        region,
    })
}

/// The tool's calibration in a room of this seed: off the truth by errors about the tip.
///
/// # Errors
/// [`RoomError::Covariance`].
pub(crate) fn calibration(room: &Room, seed: u64) -> Result<Uncertain<Marker, Tool>, RoomError> {
    let tip = room.marker_from_tool * Point::<Tool>::new(0.0, 0.0, 0.0);
    let off = Chance::new(seed ^ LINKS, CALIBRATION);
    disturbed(room.marker_from_tool, tip, room.calibration_error, off)
}

/// A transform as measured with normal errors about the point `c`: the truth is the drawn motion after it, so it is the
/// inverse motion after the truth.
fn disturbed<To, From>(
    truth: Rigid<To, From>,
    c: Point<To>,
    errors: Deviations,
    chance: Chance,
) -> Result<Uncertain<To, From>, RoomError> {
    let drawn = |first: u64, size: f64| {
        let [x, y, z] = [0, 1, 2].map(|i| size * chance.normal(first + i));
        Vector::<To>::new(x, y, z)
    };
    let motion = about(c, drawn(0, errors.turn_rad), drawn(3, errors.shift_mm));
    let errors = errors_about(c, errors)?;
    Ok(Uncertain::from_upper(motion.inverse() * truth, errors.upper())?)
}

/// The motion p -> exp(w) (p - c) + c + v; exactly the identity for zeros.
pub(crate) fn about<F>(c: Point<F>, w: Vector<F>, v: Vector<F>) -> Rigid<F, F> {
    let origin = Point::new(0.0, 0.0, 0.0);
    let no_shift = Vector::new(0.0, 0.0, 0.0);
    // Draws are finite and scenes checked, so there always is such a turn.
    let turn: Rigid<F, F> = Rigid::from_rotation_vector(w, no_shift).unwrap_or(Rigid::identity());
    let lever = c - origin;
    Rigid::from_parts(turn.rotation(), lever - turn * lever + v)
}

/// The noise that emitters are weighted with: the scene's with the rounding of its steps, and a floor where there is none.
pub(crate) fn weights(sensor: &Sensor) -> Localizer {
    let [across, depth] = [sensor.across_mm, sensor.depth_mm];
    let floor = LEAST_MM.max(across.max(depth) / LARGEST_RATIO);
    Localizer {
        across_mm: across.max(floor),
        depth_mm: depth.max(floor),
        ..sensing::noise(sensor)
    }
}

/// Whether an emitter at rest may have the same coordinates again and again: without noise, or rounded so coarsely that the
/// noise drowns in it.
pub(crate) fn is_noiseless(sensor: &Sensor) -> bool {
    let noise_mm = sensor.across_mm.max(sensor.depth_mm);
    noise_mm == 0.0 || sensor.quantisation_mm > 3.0 * noise_mm
}

pub(crate) fn gates(spec: &GateSpec) -> Gates {
    Gates {
        min_emitters: spec.min_emitters,
        max_fre_mm: spec.max_fre_mm,
        outlier_sigmas: spec.outlier_sigmas,
        max_tip_mm: spec.max_tip_mm,
    }
}
