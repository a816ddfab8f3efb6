//! Links with a known truth: when frames were captured, what the device stamped, when they arrived.

use chance::Chance;

/// Frames of a link, in the order of their arrival; seconds.
#[derive(Debug, Clone)]
pub(crate) struct Link {
    /// Number of the frame, with gaps where frames were lost.
    pub(crate) number: Vec<u64>,
    /// The device's stamp.
    pub(crate) device: Vec<f64>,
    pub(crate) arrival: Vec<f64>,
    /// Capture plus least delay.
    pub(crate) truth: Vec<f64>,
}

/// How a link is made.
#[derive(Clone, Copy)]
pub(crate) struct Plan {
    pub(crate) name: &'static str,
    pub(crate) rate_hz: f64,
    pub(crate) length_s: f64,
    /// Part of the frames that are lost.
    pub(crate) lost: f64,
    /// Delay beyond the least, of the capture's time and chances of its own.
    pub(crate) delay: fn(f64, Chance) -> f64,
    /// What the device's clock is ahead of the run's, of the capture's time.
    pub(crate) ahead: fn(f64) -> f64,
    /// What the least delay has grown by, of the capture's time.
    pub(crate) longer: fn(f64) -> f64,
    /// When the device's clock is set, by the capture's time, and by how much, s; forward is positive.
    pub(crate) steps: &'static [(f64, f64)],
    /// Whether the device says nothing at this time.
    pub(crate) silent: fn(f64) -> bool,
    /// What stamps are cut off to, 0 for nothing.
    pub(crate) quantum_s: f64,
}

pub(crate) const LEAST_DELAY_S: f64 = 5e-3;

impl Plan {
    /// Three minutes at 60 Hz over a link whose delays are `delay`; a skew of 50 ppm, one frame of a thousand lost.
    pub(crate) const fn of(name: &'static str, delay: fn(f64, Chance) -> f64) -> Self {
        Self {
            name,
            rate_hz: 60.0,
            length_s: 180.0,
            lost: 1e-3,
            delay,
            ahead: |t| t * 50e-6,
            longer: |_| 0.0,
            steps: &[],
            silent: |_| false,
            quantum_s: 0.0,
        }
    }

    pub(crate) const fn with_steps(self, name: &'static str, steps: &'static [(f64, f64)]) -> Self {
        Self { name, steps, ..self }
    }

    pub(crate) fn link(&self, seed: u64) -> Link {
        let mut link = Link {
            number: Vec::new(),
            device: Vec::new(),
            arrival: Vec::new(),
            truth: Vec::new(),
        };
        let mut newest = f64::NEG_INFINITY;
        for number in 0..(self.length_s * self.rate_hz) as u64 {
            let chance = Chance::new(seed, number);
            let t = number as f64 / self.rate_hz;
            if chance.uniform(0) < self.lost || (self.silent)(t) {
                continue;
            }
            let truth = t + LEAST_DELAY_S + (self.longer)(t);
            // A stream keeps the order.
            newest = f64::max(newest, truth + (self.delay)(t, chance));
            let set: f64 = self.steps.iter().filter(|(at, _)| t >= *at).map(|(_, by)| by).sum();
            link.number.push(number);
            let stamp = 1000.0 + t + (self.ahead)(t) + set;
            let cut = if self.quantum_s > 0.0 {
                stamp.rem_euclid(self.quantum_s)
            } else {
                0.0
            };
            link.device.push(stamp - cut);
            link.arrival.push(newest);
            link.truth.push(truth);
        }
        link
    }
}

pub(crate) fn exponential(chance: Chance, draw: u64, mean: f64) -> f64 {
    -mean * chance.uniform(draw).ln()
}

fn ethernet_delay(_: f64, chance: Chance) -> f64 {
    let spike = if chance.uniform(2) < 0.02 {
        40e-3 * chance.uniform(3)
    } else {
        0.0
    };
    exponential(chance, 1, 0.3e-3) + spike
}

fn wifi_delay(t: f64, chance: Chance) -> f64 {
    let spike = if chance.uniform(2) < 0.05 {
        100e-3 * chance.uniform(3)
    } else {
        0.0
    };
    let congestion = if t > 60.0 && t < 62.0 { 30e-3 } else { 0.0 };
    exponential(chance, 1, 3e-3) + spike + congestion
}

fn polled_delay(_: f64, chance: Chance) -> f64 {
    20e-3 * chance.uniform(1)
}

fn stalled_delay(t: f64, chance: Chance) -> f64 {
    let phase = t % 20.0;
    exponential(chance, 1, 0.3e-3) + if phase < 0.5 { 0.5 - phase } else { 0.0 }
}

pub(crate) const ETHERNET: Plan = Plan::of("Ethernet, 2 % spikes to 40 ms", ethernet_delay);
pub(crate) const WIFI: Plan = Plan::of("WiFi, 5 % to 100 ms, 2 s congestion", wifi_delay);
pub(crate) const POLLED: Plan = Plan::of("polled at 50 Hz by the peer", polled_delay);
pub(crate) const STALLED: Plan = Plan::of("receiver stalls 0.5 s each 20 s", stalled_delay);

/// A bridge of two radios, whose delays are the sums of two, so that few are near the least.
pub(crate) const TWO_RADIOS: Plan = Plan::of("two radios in a row", |_, chance| {
    exponential(chance, 1, 1.5e-3) + exponential(chance, 2, 1.5e-3)
});

/// A device that warms up: its skew goes from 100 ppm towards 115 ppm with a time constant of two minutes.
pub(crate) const WARMING: Plan = Plan {
    ahead: |t| t * 115e-6 - 15e-6 * 120.0 * (1.0 - (-t / 120.0).exp()),
    length_s: 600.0,
    ..Plan::of("device warms up by 15 ppm", ethernet_delay)
};

/// The four links of the published comparison, and two more.
pub(crate) const LINKS: [Plan; 6] = [ETHERNET, WIFI, POLLED, STALLED, TWO_RADIOS, WARMING];

const BACK: &[(f64, f64)] = &[(60.0, -80e-3), (120.0, -80e-3)];
const FORTH: &[(f64, f64)] = &[(60.0, 80e-3), (120.0, 80e-3)];

/// The device's clock is set by 80 ms.
pub(crate) const STEPPED: [Plan; 8] = [
    ETHERNET.with_steps("Ethernet, set back by 80 ms", BACK),
    ETHERNET.with_steps("Ethernet, set forward by 80 ms", FORTH),
    WIFI.with_steps("WiFi, set back by 80 ms", &[(70.0, -80e-3), (130.0, -80e-3)]),
    WIFI.with_steps("WiFi, set forward by 80 ms", &[(70.0, 80e-3), (130.0, 80e-3)]),
    POLLED.with_steps("polled, set back by 80 ms", BACK),
    POLLED.with_steps("polled, set forward by 80 ms", FORTH),
    STALLED.with_steps("stalls, set back by 80 ms", &[(70.0, -80e-3), (130.0, -80e-3)]),
    STALLED.with_steps("stalls, set forward by 80 ms", &[(70.0, 80e-3), (130.0, 80e-3)]),
];

const fn broken(name: &'static str) -> Plan {
    Plan { name, ..ETHERNET }
}

/// Links on which a law may lie.
pub(crate) const BREAKERS: [Plan; 20] = [
    Plan {
        longer: |t| if t > 60.0 { 5e-3 } else { 0.0 },
        ..broken("route longer by 5 ms")
    },
    Plan {
        longer: |t| if t > 60.0 { 5e-3 } else { 0.0 },
        ..WIFI.with_steps("route longer by 5 ms, WiFi", &[])
    },
    Plan {
        longer: |t| if t > 60.0 { 5e-3 } else { 0.0 },
        ..POLLED.with_steps("route longer by 5 ms, polled", &[])
    },
    Plan {
        longer: |t| if t < 60.0 { 5e-3 } else { 0.0 },
        ..broken("route shorter by 5 ms")
    },
    broken("set forward by 2 ms").with_steps("set forward by 2 ms", &[(60.0, 2e-3)]),
    broken("set back by 2 ms").with_steps("set back by 2 ms", &[(60.0, -2e-3)]),
    broken("set forward by 0.4 ms").with_steps("set forward by 0.4 ms", &[(60.0, 0.4e-3)]),
    broken("set back by 0.4 ms").with_steps("set back by 0.4 ms", &[(60.0, -0.4e-3)]),
    Plan {
        ahead: |t| t * 100e-6 + 20e-6 * 95.5 * (t / 95.5).cos(),
        length_s: 600.0,
        ..broken("skew 100 ppm, +-20 ppm in 600 s")
    },
    Plan {
        rate_hz: 10.0,
        ..broken("10 Hz")
    },
    Plan {
        rate_hz: 4000.0,
        length_s: 20.0,
        ..broken("4 kHz")
    },
    Plan {
        delay: |t, c| {
            exponential(c, 1, 0.3e-3)
                + if (t * 60.0).round() % 2.0 == 0.0 {
                    1.0 / 60.0
                } else {
                    0.0
                }
        },
        ..broken("frames in pairs")
    },
    Plan {
        ahead: |t| (t - 40.0).clamp(0.0, 100.0) * 500e-6,
        ..broken("slewed by +500 ppm for 100 s")
    },
    Plan {
        ahead: |t| (t - 40.0).clamp(0.0, 100.0) * -500e-6,
        ..broken("slewed by -500 ppm for 100 s")
    },
    Plan {
        delay: |t, c| exponential(c, 1, 0.3e-3) + (1.0 - t).max(0.0),
        ..broken("backlog in the first second")
    },
    Plan {
        delay: |t, c| exponential(c, 1, 0.3e-3) + if (30.0..31.0).contains(&t) { 31.0 - t } else { 0.0 },
        silent: |t| (31.0..46.0).contains(&t),
        ..broken("late burst, then silent for 15 s")
    },
    Plan {
        silent: |t| (60.0..120.0).contains(&t),
        ..broken("silent for 60 s")
    },
    Plan {
        delay: |t, c| exponential(c, 1, 0.3e-3) + if (60.0..70.0).contains(&t) { 30e-3 } else { 0.0 },
        ..broken("all frames late by 30 ms for 10 s")
    },
    Plan {
        delay: |t, c| {
            exponential(c, 1, 0.3e-3)
                + if (60.0..65.0).contains(&t) {
                    10e-3 * (t - 60.0)
                } else {
                    0.0
                }
        },
        ..broken("queue that grows for 5 s")
    },
    Plan {
        quantum_s: 1e-3,
        ..broken("stamps in whole milliseconds")
    },
];
