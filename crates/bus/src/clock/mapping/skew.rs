//! How much faster the run's clock goes than the device's, from one window after another.

/// The skew's belief before anything was seen: crystals of computers lie within 100 ppm of one another.
const FIRST_SIGMA: f64 = 100e-6;
/// By how much a skew may change from one window to the next: 0.1 ppm a second is a crystal that is warmed by a hand.
const DRIFT_SIGMA: f64 = 2e-6;

/// A skew with its deviation, by Kalman's filter on one number. Windows that overlap share their noise, so a window's skew is
/// counted only once, when its time has gone; until then it is looked at beside what the windows before said.
#[derive(Debug, Clone, Copy)]
pub(super) struct Skew {
    /// Of the windows before.
    prior: f64,
    prior_sigma: f64,
    /// With the present window.
    pub(super) now: f64,
    pub(super) sigma: f64,
    /// The device's stamp when the present window's time began, nanoseconds from the envelope's base.
    since: f64,
}

impl Skew {
    pub(super) fn new() -> Self {
        Self {
            prior: 0.0,
            prior_sigma: FIRST_SIGMA,
            now: 0.0,
            sigma: FIRST_SIGMA,
            since: 0.0,
        }
    }

    /// The same clock after it was set.
    pub(super) fn after_a_step(self) -> Self {
        Self {
            prior: self.now,
            prior_sigma: self.sigma.hypot(DRIFT_SIGMA),
            since: 0.0,
            ..self
        }
    }

    /// Takes the skew of the present window, which is known to `sigma`, at the device's time `x`.
    pub(super) fn see(&mut self, measured: f64, sigma: f64, x: f64, settings: (f64, f64)) {
        let (window, bound) = settings;
        // What goes beyond the bound is no skew, and says that something else is wrong.
        let sigma = sigma.max(measured.abs() - bound);
        let (a, b) = (self.prior_sigma.powi(2), sigma.powi(2));
        // Both without any noise cannot be: the prior's has a floor.
        let gain = a / (a + b);
        self.now = (self.prior + gain * (measured - self.prior)).clamp(-bound, bound);
        self.sigma = (a * b / (a + b)).sqrt();
        if x - self.since >= window {
            *self = Self {
                since: x,
                ..self.after_a_step()
            };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_add_up_and_a_change_is_followed() {
        let mut skew = Skew::new();
        let window = 20e9;
        for k in 1..=20 {
            skew.see(50e-6, 13e-6, f64::from(k) * window, (window, 200e-6));
        }
        assert!((skew.now - 50e-6).abs() < 1e-6 && skew.sigma < 6e-6, "{skew:?}");
        for k in 21..=40 {
            skew.see(70e-6, 13e-6, f64::from(k) * window, (window, 200e-6));
        }
        assert!((skew.now - 70e-6).abs() < 1e-6, "{skew:?}");
    }

    #[test]
    fn no_window_tilts_it_beyond_the_bound() {
        let mut skew = Skew::new();
        skew.see(1.0, 1e-9, 20e9, (20e9, 200e-6));
        assert!((0.0..=200e-6).contains(&skew.now));
        skew.see(-1.0, 1e-9, 40e9, (20e9, 200e-6));
        assert!((-200e-6..=200e-6).contains(&skew.now));
    }
}
