//! Smoothing of poses, for who wants a calmer image and knows what it costs: it is late.
//!
//! Off unless a scene asks for it. Causal: a pose is mixed with the smoothed one before it, so that of a steady motion
//! the picture lags behind by the time constant, which is said wherever a smoothed pose is shown.

use geometry::rotation::Rotation;
use geometry::{Ct, Rigid, Tool, Vector};

/// First-order smoothing with a time constant.
#[derive(Debug, Clone, Copy)]
pub struct Smoothing {
    time_constant_s: f64,
    last: Option<(i64, Rigid<Ct, Tool>)>,
}

impl Smoothing {
    /// Smoothing that lags behind a steady motion by `time_constant_s` (above zero; otherwise poses pass unchanged).
    pub fn new(time_constant_s: f64) -> Self {
        Self {
            time_constant_s,
            last: None,
        }
    }

    /// The delay of a steady motion, s.
    pub fn delay_s(&self) -> f64 {
        self.time_constant_s.max(0.0)
    }

    /// The pose was lost: what comes next is not mixed with what was before.
    pub fn reset(&mut self) {
        self.last = None;
    }

    /// The smoothed pose: the tip and the rotation each go `1 - exp(-dt / tau)` of the way from the last smoothed one.
    pub fn smooth(&mut self, t_ns: i64, pose: Rigid<Ct, Tool>) -> Rigid<Ct, Tool> {
        let smoothed = match self.last {
            Some((last_ns, last)) if self.time_constant_s > 0.0 => {
                let dt_s = (t_ns.saturating_sub(last_ns)) as f64 / 1e9;
                mixed(last, pose, -(-dt_s.max(0.0) / self.time_constant_s).exp_m1())
            }
            _ => pose,
        };
        self.last = Some((t_ns, smoothed));
        smoothed
    }
}

fn mixed(from: Rigid<Ct, Tool>, to: Rigid<Ct, Tool>, share: f64) -> Rigid<Ct, Tool> {
    let rotation: Rotation = from.rotation().slerp(to.rotation(), share);
    let tip: Vector<Ct> = from.translation() + (to.translation() + from.translation() * -1.0) * share;
    Rigid::from_parts(rotation, tip)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(x: f64) -> Rigid<Ct, Tool> {
        Rigid::from_rotation_vector(Vector::new(0.0, 0.0, 0.01 * x), Vector::new(x, 0.0, 0.0)).unwrap()
    }

    #[test]
    fn a_steady_motion_lags_by_the_stated_delay() {
        let mut smoothing = Smoothing::new(0.05);
        let (rate_hz, speed) = (1000, 20.0);
        let mut shown = at(0.0);
        for i in 0..=2000 {
            let t_s = f64::from(i) / f64::from(rate_hz);
            shown = smoothing.smooth(i64::from(i) * 1_000_000, at(speed * t_s));
        }
        let lag_s = (speed * 2.0 - shown.translation_mm()[0]) / speed;
        // Sampled at 1 ms, the steady lag is tau less half a sample.
        assert!((lag_s - smoothing.delay_s()).abs() < 0.6e-3, "{lag_s}");
        let turn_lag = (0.01 * speed * 2.0 - shown.angle()) / (0.01 * speed);
        assert!((turn_lag - lag_s).abs() < 1e-9);
    }

    #[test]
    fn off_and_after_a_loss_poses_pass_bit_for_bit() {
        let mut off = Smoothing::new(0.0);
        assert_eq!(off.smooth(0, at(1.0)), at(1.0));
        assert_eq!(off.smooth(1_000_000, at(2.0)), at(2.0));
        let mut smoothing = Smoothing::new(1.0);
        smoothing.smooth(0, at(1.0));
        smoothing.reset();
        assert_eq!(smoothing.smooth(1_000_000, at(50.0)), at(50.0));
    }
}
