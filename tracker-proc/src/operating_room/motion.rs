//! How the patient has moved since it was registered.

use std::f64::consts::PI;

use geometry::{Ct, Rigid, Vector};
use scene::operating_room::{Breathing, Bump, Patient};

/// The patient's motion at script time `t_s`: from the CT's frame as it is now to where it was registered, both LPS.
///
/// Breath and drift shift the bumped patient: `p -> bump(p) + breath + drift`.
pub(super) fn rest_from_moved(patient: &Patient, t_s: f64) -> Rigid<Ct, Ct> {
    let mut shift = patient.drift_mm_per_s * t_s;
    if let Some(breathing) = &patient.breathing {
        shift = shift + breathing.direction * breath_mm(breathing, t_s);
    }
    let mut turn = Vector::new(0.0, 0.0, 0.0);
    if let Some(bump) = &patient.bump {
        let share = bumped(bump, t_s);
        shift = shift + bump.translation * share;
        turn = bump.rotation * share;
    }
    // Checked scenes are finite, so there always is such a motion.
    Rigid::from_rotation_vector(turn, shift).unwrap_or(Rigid::identity())
}

/// How far along its direction the breath is, mm: 0 at the end of an expiration.
fn breath_mm(breathing: &Breathing, t_s: f64) -> f64 {
    let sin = (PI * (t_s / breathing.period_s).fract()).sin();
    breathing.amplitude_mm * sin.powi(4)
}

/// The part of the bump that has happened, 0 to 1; it starts and ends gently.
fn bumped(bump: &Bump, t_s: f64) -> f64 {
    let since = t_s - bump.at_s;
    if since <= 0.0 {
        return 0.0;
    }
    if since >= bump.over_s {
        return 1.0;
    }
    let s = since / bump.over_s;
    s * s * (3.0 - 2.0 * s)
}
