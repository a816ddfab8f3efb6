//! Grids behind a lens: error beside the error stated, and beside OpenCV's, class by class.

use optics::grid::{Found, GridSpec, find};

use crate::common::Random;
use crate::common::lens_scene::{Glass, LensScene, PITCH, Seen};
use crate::opencv::{Peer, peers};
use crate::{cpu_ms, turned};

const BENDS: [f64; 7] = [-0.4, -0.3, -0.1, 0.0, 0.1, 0.3, 0.4];
const BLURS: [f64; 3] = [0.5, 1.2, 2.5];
const TILTS: [f64; 4] = [0.0, 40.0, 65.0, 80.0];

/// Squares summed over discs: of our errors, of those stated, and of OpenCV's.
#[derive(Default)]
pub(crate) struct Sums {
    images: usize,
    found: usize,
    ours: [f64; 2],
    discs: usize,
    peers: usize,
    peer: f64,
    /// Both found it: images, ours and OpenCV's mean squares, and in how many ours is further.
    both: [f64; 3],
    further: usize,
    /// By model: whole, with a lens, one by one.
    models: [usize; 3],
    /// The largest ratio of an image's error to what it states.
    worst: f64,
    ms: f64,
}

/// The sum of squared distances to the truth in the turn that fits best.
fn squares(found: &Found, seen: &Seen, cols: usize) -> f64 {
    let of = |k: usize| {
        let off = found.discs.iter().map(|d| {
            let [c, r] = turned(k, [d.col, d.row]);
            (d.at - seen.centres[r * cols + c]).norm_squared()
        });
        off.sum::<f64>()
    };
    (0..4).map(of).fold(f64::MAX, f64::min)
}

fn stated(found: &Found) -> f64 {
    found.discs.iter().map(|d| d.covariance.trace()).sum()
}

impl Sums {
    fn add(&mut self, seen: &Seen, peer: Option<&Peer>) -> Option<f64> {
        self.images += 1;
        let start = cpu_ms();
        let found = find(&seen.image, &GridSpec::new(10, 10, PITCH)).ok();
        self.ms += cpu_ms() - start;
        let peer = peer.and_then(|p| p.rms);
        self.peer += peer.map_or(0.0, |rms| rms * rms);
        self.peers += usize::from(peer.is_some());
        let found = found?;
        let (error, said) = (squares(&found, seen, 10), stated(&found));
        self.found += 1;
        self.discs += found.discs.len();
        self.ours[0] += error;
        self.ours[1] += said;
        self.models[model(&found)] += 1;
        self.worst = self.worst.max((error / said).sqrt());
        let mean = error / found.discs.len() as f64;
        if let Some(rms) = peer {
            self.both[0] += 1.0;
            self.both[1] += mean;
            self.both[2] += rms * rms;
            self.further += usize::from(mean.sqrt() > rms);
        }
        Some((error / said).sqrt())
    }

    pub(crate) fn line(&self) -> String {
        let rms = |s: f64, n: f64| (s / n).sqrt();
        let n = self.discs as f64;
        format!(
            "{:4}/{} {:8.4} {:8.4} {:5.2} {:6.2} |{:4} {:8.4} | both {:4} {:8.4} {:8.4} {:4} | {:?} {:6.1}",
            self.found,
            self.images,
            rms(self.ours[0], n),
            rms(self.ours[1], n),
            rms(self.ours[0], self.ours[1]),
            self.worst,
            self.peers,
            rms(self.peer, self.peers as f64),
            self.both[0],
            rms(self.both[1], self.both[0]),
            rms(self.both[2], self.both[0]),
            self.further,
            self.models,
            self.ms / self.images as f64
        )
    }
}

pub(crate) const HEAD: &str = "found, rms px, stated px, ratio, largest ratio | OpenCV found, rms px | where both found: images, our \
                    rms, its rms, images with ours further | models whole, lens, each; CPU ms";

fn model(found: &Found) -> usize {
    match found.refinement {
        optics::grid::Refinement::Whole => 0,
        optics::grid::Refinement::Lens => 1,
        optics::grid::Refinement::Each => 2,
    }
}

/// The image of a class and a seed: any roll, noise 1 to 6.
fn scene(k1: f64, blur: f64, tilt_deg: f64, seed: u64) -> LensScene {
    let mut random = Random::new(seed + 31);
    LensScene {
        tilt_deg,
        roll_deg: 180.0 * random.signed(),
        glass: Glass {
            radial: [k1, 0.0, 0.0],
            ..Glass::default()
        },
        blur,
        noise: 1.0 + 5.0 * random.unit(),
        shade: 0.3 * random.signed(),
        seed,
        ..LensScene::default()
    }
}

/// All classes, `count` images each, or those whose k1, blur and tilt begin with `only`.
pub(crate) fn run(python: Option<&str>, first: u64, count: u64, only: Option<&str>) {
    println!("k1, blur, tilt: {HEAD}");
    for k1 in BENDS {
        for blur in BLURS {
            for tilt in TILTS {
                if only.is_some_and(|only| !format!("{k1},{blur},{tilt},").starts_with(&format!("{only},"))) {
                    continue;
                }
                let seen: Vec<Seen> = (first..first + count)
                    .map(|s| scene(k1, blur, tilt, s).draw())
                    .collect();
                println!("{k1:5} {blur:4} {tilt:3}: {}", of(&seen, python).line());
            }
        }
    }
}

pub(crate) fn of(seen: &[Seen], python: Option<&str>) -> Sums {
    let images: Vec<_> = seen.iter().map(|s| (&s.image, &*s.centres)).collect();
    let peer = python.map(|p| peers(p, &images)).unwrap_or_default();
    let mut sums = Sums::default();
    for (k, seen) in seen.iter().enumerate() {
        let _ = sums.add(seen, peer.get(k));
    }
    sums
}
